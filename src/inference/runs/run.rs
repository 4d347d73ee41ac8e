//! A run of whatever algorithm its parameters ask for.

use std::sync::Arc;

use crate::geometry::SampleCloud;
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::data::abstraction::{Abstraction, MergeReport, Occurrence};
use crate::inference::data::model::Model;
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::params::{Algorithm, Params};
use crate::inference::runs::baselines::Baseline;
use crate::inference::runs::checkpoint::Checkpoint;
use crate::inference::runs::edit::Edit;
use crate::inference::runs::merge_proposal::MergeProposal;

/// A run of the sampler or of a baseline, step by step. `Clone` is a
/// checkpoint: a clone continued gives the same bits as the original
/// continued.
#[derive(Debug, Clone)]
pub struct Run(Kind);

#[derive(Debug, Clone)]
enum Kind {
    Sampler(Box<Sampler>),
    Baseline(Box<Baseline>),
}

impl Run {
    /// Starts a run of `params.algorithm`.
    ///
    /// # Errors
    /// Where a parameter is out of its limits, the cloud has too few points,
    /// or the start was cancelled.
    pub fn new(cloud: Arc<SampleCloud>, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        Ok(Self(match params.algorithm {
            Algorithm::Sampler => Kind::Sampler(Box::new(Sampler::new(cloud, params, cancel)?)),
            Algorithm::KMeans | Algorithm::Ems | Algorithm::HierarchicalEms => {
                Kind::Baseline(Box::new(Baseline::new(cloud, params, cancel)?))
            }
        }))
    }

    /// Starts a run of `params.algorithm` on the same cloud. What depends on
    /// the cloud alone is shared. The sampler keeps locked primitives with their
    /// id, shape, σ and points and starts its K clusters on the others; pins of
    /// other points go. Baselines know no locks and start from nothing.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn restarted(&self, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        let same = self.sampler();
        Ok(Self(match params.algorithm {
            Algorithm::Sampler => Kind::Sampler(Box::new(same.restarted(params, cancel)?)),
            Algorithm::KMeans | Algorithm::Ems | Algorithm::HierarchicalEms => {
                Kind::Baseline(Box::new(Baseline::restarted(same, params, cancel)?))
            }
        }))
    }

    /// The parameters in force: K, the seed and the algorithm are those of the
    /// start.
    pub fn params(&self) -> &Params {
        match &self.0 {
            Kind::Sampler(run) => run.params(),
            Kind::Baseline(run) => run.params(),
        }
    }

    /// Takes other parameters from the next step on, but for K (`clusters`)
    /// and the seed, which belong to the start of a run. Parameters of another
    /// algorithm wait for the next start altogether.
    ///
    /// # Errors
    /// Where a parameter is out of its limits.
    pub fn set_params(&mut self, params: Params) -> Result<(), InferenceError> {
        params.check().map_err(InferenceError::Params)?;
        if params.algorithm != self.params().algorithm {
            return Ok(());
        }
        match &mut self.0 {
            Kind::Sampler(run) => run.set_params(params),
            Kind::Baseline(run) => run.set_params(params),
        }
    }

    /// Whether nothing is left to do.
    pub fn is_finished(&self) -> bool {
        match &self.0 {
            Kind::Sampler(run) => run.is_finished(),
            Kind::Baseline(run) => run.is_finished(),
        }
    }

    /// Gibbs iterations, or steps of the baseline, made so far.
    pub fn iteration(&self) -> u32 {
        match &self.0 {
            Kind::Sampler(run) => run.iteration(),
            Kind::Baseline(run) => run.steps(),
        }
    }

    /// Makes the next step.
    ///
    /// # Errors
    /// `Cancelled`; the state is then as before the call.
    pub fn step(&mut self, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        match &mut self.0 {
            Kind::Sampler(run) => run.step(cancel),
            Kind::Baseline(run) => run.step(cancel),
        }
    }

    /// Makes the best acceptable merge of two clusters; `None` if no pair is
    /// acceptable. A baseline merges nothing.
    ///
    /// # Errors
    /// `Cancelled`; the state is then as before the call.
    pub fn step_merge(&mut self, cancel: &Cancel) -> Result<Vec<MergeReport>, InferenceError> {
        match &mut self.0 {
            Kind::Sampler(run) => run.step_merge(cancel),
            Kind::Baseline(_) => Ok(Vec::new()),
        }
    }

    /// All that the run needs to go on, but the cloud, as plain data.
    pub fn checkpoint(&self) -> Checkpoint {
        match &self.0 {
            Kind::Sampler(run) => Checkpoint::of(run),
            Kind::Baseline(run) => run.checkpoint(),
        }
    }

    /// The run that `checkpoint` was taken of, on this run's cloud: it goes on
    /// with the same bits. What depends on the cloud alone is shared.
    ///
    /// # Errors
    /// `Checkpoint` where it doesn't fit the cloud or is damaged.
    pub fn resumed(&self, checkpoint: &Checkpoint, cancel: &Cancel) -> Result<Self, InferenceError> {
        Self::resume_on(Arc::clone(&self.sampler().state.model), checkpoint, cancel)
    }

    /// The run that `checkpoint` was taken of, on the same cloud loaded anew.
    ///
    /// # Errors
    /// As [`Run::resumed`], and where the cloud has too few points.
    pub fn resume(
        cloud: Arc<SampleCloud>,
        checkpoint: &Checkpoint,
        cancel: &Cancel,
    ) -> Result<Self, InferenceError> {
        // What can be told without the neighbourhoods is told at once.
        checkpoint.check(cloud.points.len())?;
        Self::resume_on(Sampler::model_of(&cloud, cancel)?, checkpoint, cancel)
    }

    fn resume_on(
        model: Arc<Model>,
        checkpoint: &Checkpoint,
        cancel: &Cancel,
    ) -> Result<Self, InferenceError> {
        checkpoint.check(model.points.len())?;
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        Ok(Self(match checkpoint.params.algorithm {
            Algorithm::Sampler => Kind::Sampler(Box::new(checkpoint.sampler(model))),
            Algorithm::KMeans | Algorithm::Ems | Algorithm::HierarchicalEms => {
                Kind::Baseline(Box::new(Baseline::resumed(checkpoint, model)))
            }
        }))
    }

    /// The state and records that every kind of run keeps.
    pub(crate) fn sampler(&self) -> &Sampler {
        match &self.0 {
            Kind::Sampler(run) => run,
            Kind::Baseline(run) => run.base(),
        }
    }

    /// The sampler, for what only it can do.
    fn only_sampler(&mut self) -> Result<&mut Sampler, InferenceError> {
        match &mut self.0 {
            Kind::Sampler(run) => Ok(run),
            Kind::Baseline(run) => Err(InferenceError::Edit(format!(
                "{} cannot continue from an edited state; run the sampler instead",
                run.params().algorithm.title()
            ))),
        }
    }

    /// Changes the state by hand: whole or not at all. The phase stays; to let
    /// the sampler go on after the end, see [`Run::resample`].
    ///
    /// # Errors
    /// `Edit` where it can't be made, with what to do instead; `Cancelled`. The
    /// state is then as before the call.
    pub fn edit(&mut self, edit: &Edit, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        self.only_sampler()?.edit(edit, cancel)
    }

    /// The least semi-axis that [`Edit::SetShape`] accepts, in input units.
    pub fn smallest_axis(&self) -> f64 {
        let model = &self.sampler().state.model;
        model.normalization.length(model.axis_floor())
    }

    /// Lets the sampler make `more` further iterations from the present state,
    /// whether or not it had finished: T becomes the iterations made so far and
    /// `more`, at least 1, within the limits of T.
    ///
    /// # Errors
    /// Where the run is a baseline's, or T is at its limit.
    pub fn resample(&mut self, more: u32) -> Result<(), InferenceError> {
        self.only_sampler()?.resample(more)
    }

    /// The merge that would be made next: the best pair that is neither in
    /// `skipped` (ids in any order) nor locked, whether or not it is acceptable;
    /// `None` where no pair is near each other. The state stays as it is.
    ///
    /// # Errors
    /// Where the run is a baseline's; `Cancelled`.
    pub fn propose_merge(
        &mut self,
        skipped: &[(u32, u32)],
        cancel: &Cancel,
    ) -> Result<Option<MergeProposal>, InferenceError> {
        self.only_sampler()?.propose_merge(skipped, cancel)
    }

    /// The merge of two primitives by id, with the numbers that speak for it and
    /// against it. The state stays as it is.
    ///
    /// # Errors
    /// Where the run is a baseline's, an id is unknown or locked, or the union
    /// can't be fitted; `Cancelled`.
    pub fn propose_merge_of(
        &mut self,
        a: u32,
        b: u32,
        cancel: &Cancel,
    ) -> Result<MergeProposal, InferenceError> {
        self.only_sampler()?.propose_merge_of(a, b, cancel)
    }

    /// The present state in input units.
    pub fn abstraction(&self) -> Abstraction {
        match &self.0 {
            Kind::Sampler(run) => run.abstraction(),
            Kind::Baseline(run) => run.abstraction(),
        }
    }
}
