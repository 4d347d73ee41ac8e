//! The run as a machine of steps.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::abstraction::{Abstraction, MergeReport, Occurrence};
use super::params::Params;
use crate::geometry::SampleCloud;

/// A flag that asks long work to stop; cheap to clone and to test.
#[derive(Debug, Clone, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Why a run can't start or go on.
#[derive(Debug, thiserror::Error)]
pub enum InferenceError {
    #[error("the cloud has {points} distinct points, but at least {needed} are needed to fit a primitive")]
    TooFewPoints { points: usize, needed: usize },
    #[error("{0}")]
    Params(String),
    /// The step was cancelled; the state is the one before the step.
    #[error("cancelled")]
    Cancelled,
}

/// A run of the sampler. `Clone` is a checkpoint: a clone continued gives the
/// same bits as the original continued.
#[derive(Debug, Clone)]
pub struct Sampler {
    params: Params,
}

impl Sampler {
    /// Starts a run: normalises the cloud and clusters it by k-means.
    pub fn new(cloud: Arc<SampleCloud>, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        let _ = (cloud, cancel);
        params.check().map_err(InferenceError::Params)?;
        Ok(Self { params })
    }

    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Takes other parameters from the next step on. K (`clusters`) only
    /// matters at the start of a run, and the seed likewise.
    pub fn set_params(&mut self, params: Params) -> Result<(), InferenceError> {
        params.check().map_err(InferenceError::Params)?;
        self.params = params;
        Ok(())
    }

    /// Whether iterations (or, after the last, the merge) are still to be made.
    pub fn is_finished(&self) -> bool {
        todo!()
    }

    /// Makes the next Gibbs iteration with the merge pass that belongs to it
    /// or, after the last one, finishes the run (final merges). On
    /// `Cancelled` the state is as before the call.
    pub fn step(&mut self, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        let _ = cancel;
        todo!()
    }

    /// Makes the best acceptable merge of two clusters; `None` if no pair is
    /// acceptable. May be called between any two steps.
    pub fn step_merge(&mut self, cancel: &Cancel) -> Result<Option<MergeReport>, InferenceError> {
        let _ = cancel;
        todo!()
    }

    /// The present state in input units.
    pub fn abstraction(&self) -> Abstraction {
        todo!()
    }
}
