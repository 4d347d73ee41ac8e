//! A run of whatever algorithm its parameters ask for.

use std::sync::Arc;

use super::abstraction::{Abstraction, MergeReport, Occurrence};
use super::baselines::Baseline;
use super::method::Algorithm;
use super::params::Params;
use super::sampler::{Cancel, InferenceError, Sampler};
use crate::geometry::SampleCloud;

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
    /// the cloud alone is shared.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn restarted(&self, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        let same = match &self.0 {
            Kind::Sampler(run) => run,
            Kind::Baseline(run) => run.base(),
        };
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
    pub fn step_merge(&mut self, cancel: &Cancel) -> Result<Option<MergeReport>, InferenceError> {
        match &mut self.0 {
            Kind::Sampler(run) => run.step_merge(cancel),
            Kind::Baseline(_) => Ok(None),
        }
    }

    /// The present state in input units.
    pub fn abstraction(&self) -> Abstraction {
        match &self.0 {
            Kind::Sampler(run) => run.abstraction(),
            Kind::Baseline(run) => run.abstraction(),
        }
    }
}
