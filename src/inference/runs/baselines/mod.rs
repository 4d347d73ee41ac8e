//! What the paper is measured against, as machines of steps like the sampler:
//!
//! | algorithm | start | one step | end |
//! |---|---|---|---|
//! | K-means | K clusters, ellipsoids of moments | one cluster's fit | all are fitted |
//! | EMS | one primitive, all points | one round of EM, or a switch | the likelihood is at rest |
//! | hierarchical EMS | nothing, all points unassigned | one primitive by EMS | no part is left to fit |
//!
//! Nothing is sampled but the k-means centres.

mod ems;

use std::sync::Arc;

use crate::geometry::SampleCloud;
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::data::abstraction::{Abstraction, Figures, Occurrence, Phase, UNASSIGNED};
use crate::inference::data::change::{Change, Identity, Noise, Successor};
use crate::inference::data::model::{Model, sum_squared_radial};
use crate::inference::data::random_streams::{Purpose, stream};
use crate::inference::data::state::State;
use crate::inference::fit::k_means::k_means;
use crate::inference::fit::points::{Effort, fit};
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::params::{Algorithm, Params, SMALLEST_CLUSTER};
use crate::inference::runs::baselines::ems::{Problem, Recovery};
use crate::inference::runs::checkpoint;
use crate::inference::runs::checkpoint::{Checkpoint, Part};

/// Primitives that hierarchical EMS may take one after another out of the same
/// part of a cloud. Each one takes more than [`SMALLEST_CLUSTER`] points, so the
/// recursion ends by itself; this bounds it on clouds that are nothing but
/// noise.
const DEEPEST: u32 = 12;

/// Pieces, by k-means, of a part of the cloud that hierarchical EMS starts from,
/// besides the whole part: from a chair's moments alone it would find a body
/// that has something of everything.
const PIECES: usize = 6;

/// A run of a baseline. `Clone` is a checkpoint.
#[derive(Debug, Clone)]
pub(crate) struct Baseline {
    /// Start, state and records are the sampler's; none of its steps is made.
    base: Sampler,
    work: Pending,
    steps: u32,
}

/// What is left to do.
#[derive(Debug, Clone)]
enum Pending {
    /// The clusters from this index on have no fit yet.
    Fits(usize),
    /// The one primitive, from the first step on.
    One(Option<Box<Recovery>>),
    /// Parts of the cloud without a primitive, the next one last.
    Parts(Vec<Part>),
}

impl Baseline {
    /// # Errors
    /// As [`Sampler::new`].
    pub(crate) fn new(
        cloud: Arc<SampleCloud>,
        params: Params,
        cancel: &Cancel,
    ) -> Result<Self, InferenceError> {
        Ok(Self::on(Sampler::new(cloud, Self::of_start(params), cancel)?, params))
    }

    /// A run from the start on the same cloud; baselines know no locks.
    pub(crate) fn restarted(same: &Sampler, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        Ok(Self::on(same.anew(Self::of_start(params), cancel)?, params))
    }

    /// All that it needs to go on, but the cloud.
    pub(crate) fn checkpoint(&self) -> Checkpoint {
        let work = match &self.work {
            Pending::Fits(at) => checkpoint::Remaining::Fits(*at),
            Pending::One(recovery) => checkpoint::Remaining::One(recovery.as_ref().map(|r| r.recovered())),
            Pending::Parts(parts) => checkpoint::Remaining::Parts(parts.clone()),
        };
        Checkpoint { iteration: self.steps, work, ..Checkpoint::of(&self.base) }
    }

    /// The run that a checked checkpoint was taken of.
    pub(crate) fn resumed(checkpoint: &Checkpoint, model: Arc<Model>) -> Self {
        let mut base = checkpoint.sampler(Arc::clone(&model));
        // The steps are counted here.
        base.state.iteration = 0;
        let work = match &checkpoint.work {
            checkpoint::Remaining::Sampler => Pending::Parts(Vec::new()),
            checkpoint::Remaining::Fits(at) => Pending::Fits(*at),
            checkpoint::Remaining::One(recovered) => Pending::One(recovered.map(|r| {
                let problem = Problem::new(&model, model.points.to_vec(), r.outlier_prior, r.distance);
                Box::new(Recovery::resumed(problem, &r))
            })),
            checkpoint::Remaining::Parts(parts) => Pending::Parts(parts.clone()),
        };
        Self { base, work, steps: checkpoint.iteration }
    }

    pub(crate) fn base(&self) -> &Sampler {
        &self.base
    }

    /// What the sampler's start is to make of the parameters.
    fn of_start(params: Params) -> Params {
        let clusters = if params.algorithm == Algorithm::KMeans { params.clusters } else { 1 };
        Params { clusters, ..params }
    }

    fn on(mut base: Sampler, params: Params) -> Self {
        base.params = params;
        let work = match params.algorithm {
            Algorithm::HierarchicalEms => {
                let state = &mut base.state;
                let parts = parts_of(state, &(0..state.labels.len() as u32).collect::<Vec<_>>(), 0);
                let gone = vec![true; state.clusters.len()];
                state.remove_clusters(&gone);
                Pending::Parts(parts)
            }
            Algorithm::Ems => Pending::One(None),
            Algorithm::KMeans | Algorithm::Sampler => Pending::Fits(0),
        };
        let mut new = Self { base, work, steps: 0 };
        new.settle();
        new
    }

    pub(crate) fn params(&self) -> &Params {
        &self.base.params
    }

    /// Takes other parameters from the next step on, but for those that belong
    /// to the start. A finished run makes no step and keeps its own.
    ///
    /// # Errors
    /// Where a parameter is out of its limits.
    pub(crate) fn set_params(&mut self, params: Params) -> Result<(), InferenceError> {
        if self.is_finished() { Ok(()) } else { self.base.set_params(params) }
    }

    pub(crate) fn is_finished(&self) -> bool {
        self.base.phase == Phase::Finished
    }

    /// Steps made so far.
    pub(crate) fn steps(&self) -> u32 {
        self.steps
    }

    /// # Errors
    /// `Cancelled`; the state is then as before the call.
    pub(crate) fn step(&mut self, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        let mut occurrences = Vec::new();
        if self.is_finished() {
            return Ok(occurrences);
        }
        let mut next = self.clone();
        next.steps += 1;
        match &mut next.work {
            Pending::Fits(at) => {
                fit_cluster(&mut next.base.state, &next.base.params, *at, cancel);
                *at += 1;
            }
            Pending::One(recovery) => {
                recover(&mut next.base.state, &next.base.params, recovery, cancel);
            }
            Pending::Parts(parts) => {
                if let Some(part) = parts.pop() {
                    let (state, params) = (&mut next.base.state, &next.base.params);
                    parts.extend(take_one(state, params, part, cancel, &mut occurrences));
                    // The largest comes next.
                    parts.sort_by(|a, b| a.points.len().cmp(&b.points.len()).then(b.points.cmp(&a.points)));
                }
            }
        }
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        next.settle();
        *self = next;
        Ok(occurrences)
    }

    /// Names the phase that the work is in.
    fn settle(&mut self) {
        let is_done = match &self.work {
            Pending::Fits(at) => *at >= self.base.state.clusters.len(),
            Pending::One(recovery) => recovery.as_ref().is_some_and(|r| r.is_done()),
            Pending::Parts(parts) => parts.is_empty(),
        };
        self.base.phase = match (is_done, self.steps) {
            (true, _) => Phase::Finished,
            (false, 0) => Phase::Start,
            (false, _) => Phase::Sampling,
        };
    }

    pub(crate) fn abstraction(&self) -> Abstraction {
        let whole = self.base.abstraction();
        let figures = Figures { log_joint: None, ..whole.figures };
        Abstraction { iteration: self.steps, figures, ..whole }
    }
}

/// Fits the primitive of one k-means cluster.
fn fit_cluster(state: &mut State, params: &Params, at: usize, cancel: &Cancel) {
    let model = state.model.clone();
    let points = model.gather(&state.members()[at]);
    let warm = [state.clusters[at].shape];
    let found = fit(&points, &warm, model.limits(), Effort::THOROUGH, params.fit_distance, cancel);
    if let Some(found) = found {
        let sum_d2 = sum_squared_radial(&found.shape, &points);
        let cluster = &mut state.clusters[at];
        let mut rng = stream(params.seed, Purpose::Sigma, 1, cluster.id);
        cluster.shape = found.shape;
        cluster.sigma = model.draw_sigma(sum_d2, points.len(), &mut rng);
    }
}

/// One round of the recovery of one primitive from all points.
fn recover(state: &mut State, params: &Params, recovery: &mut Option<Box<Recovery>>, cancel: &Cancel) {
    let model = state.model.clone();
    let recovery = recovery.get_or_insert_with(|| {
        let problem = Problem::new(&model, model.points.to_vec(), params.outlier_prior, params.fit_distance);
        Box::new(Recovery::new(problem, &[], cancel))
    });
    recovery.tune(params.outlier_prior, params.fit_distance);
    recovery.round(cancel);
    for (label, is_inlier) in state.labels.iter_mut().zip(recovery.inliers()) {
        *label = if is_inlier { 0 } else { UNASSIGNED };
    }
    if let Some(cluster) = state.clusters.first_mut() {
        (cluster.shape, cluster.sigma) = (recovery.estimate().shape, recovery.estimate().sigma);
    }
}

/// Fits one primitive to a part of the cloud and labels the points that it
/// explains; the parts that the others fall into, if they may be fitted.
fn take_one(
    state: &mut State,
    params: &Params,
    part: Part,
    cancel: &Cancel,
    occurrences: &mut Vec<Occurrence>,
) -> Vec<Part> {
    let model = state.model.clone();
    let points = model.gather(&part.points);
    let mut rng = stream(params.seed, Purpose::KMeans, part.depth + 1, part.points[0]);
    let mut starts = vec![Vec::new(); PIECES];
    for (p, piece) in points.iter().zip(k_means(&points, PIECES, &mut rng)) {
        starts[piece as usize].push(*p);
    }
    starts.retain(|piece| piece.len() > SMALLEST_CLUSTER);
    let problem = Problem::new(&model, points, params.outlier_prior, params.fit_distance);
    let mut recovery = Recovery::new(problem, &starts, cancel);
    recovery.finish(cancel);
    let inliers = recovery.inliers();
    let explained = inliers.iter().filter(|i| **i).count();
    if cancel.is_requested() || explained <= SMALLEST_CLUSTER {
        return Vec::new();
    }
    let estimate = recovery.estimate();
    let explains = part.points.iter().copied().zip(inliers);
    let (members, rest): (Vec<_>, Vec<_>) = explains.partition(|(_, is_inlier)| *is_inlier);
    let [members, rest] = [members, rest].map(|list| list.into_iter().map(|(i, _)| i).collect::<Vec<u32>>());
    let (shape, noise) = (estimate.shape, Noise::Given(estimate.sigma));
    let found = Successor { identity: Identity::New, shape, members, noise };
    for id in state.apply(Change { added: vec![found], ..Change::default() }) {
        occurrences.push(Occurrence::Born { id, points: explained });
    }
    if part.depth + 1 < DEEPEST { parts_of(state, &rest, part.depth + 1) } else { Vec::new() }
}

/// The connected components of some points that are large enough for a
/// primitive, the smallest first.
fn parts_of(state: &State, points: &[u32], depth: u32) -> Vec<Part> {
    let mut inside = vec![false; state.labels.len()];
    for &i in points {
        inside[i as usize] = true;
    }
    let mut parts: Vec<Part> = state
        .model
        .graph
        .components(points, |i| inside[i as usize])
        .into_iter()
        .filter(|component| component.len() > SMALLEST_CLUSTER)
        .map(|points| Part { points, depth })
        .collect();
    parts.reverse();
    parts
}
