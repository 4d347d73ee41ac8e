//! What the worker steps: a run, seen through the few calls it needs, so
//! that the thread's own promises can be tested with a machine that stalls or
//! panics on demand.

use std::sync::Arc;

use crate::geometry::SampleCloud;
use crate::inference::{Abstraction, Cancel, InferenceError, MergeReport, Occurrence, Params, Run};

/// A run as a machine of steps; a clone is a checkpoint.
pub(crate) trait Machine: Clone + Send + 'static {
    fn start(cloud: Arc<SampleCloud>, params: Params, cancel: &Cancel) -> Result<Self, InferenceError>;
    /// A start on the same cloud.
    fn restarted(&self, params: Params, cancel: &Cancel) -> Result<Self, InferenceError>;
    /// The parameters in force.
    fn params(&self) -> Params;
    fn set_params(&mut self, params: Params) -> Result<(), InferenceError>;
    fn is_finished(&self) -> bool;
    fn step(&mut self, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError>;
    fn step_merge(&mut self, cancel: &Cancel) -> Result<Option<MergeReport>, InferenceError>;
    fn abstraction(&self) -> Abstraction;
}

impl Machine for Run {
    fn start(cloud: Arc<SampleCloud>, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        Self::new(cloud, params, cancel)
    }
    fn restarted(&self, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        self.restarted(params, cancel)
    }
    fn params(&self) -> Params {
        *self.params()
    }
    fn set_params(&mut self, params: Params) -> Result<(), InferenceError> {
        self.set_params(params)
    }
    fn is_finished(&self) -> bool {
        self.is_finished()
    }
    fn step(&mut self, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        self.step(cancel)
    }
    fn step_merge(&mut self, cancel: &Cancel) -> Result<Option<MergeReport>, InferenceError> {
        self.step_merge(cancel)
    }
    fn abstraction(&self) -> Abstraction {
        self.abstraction()
    }
}
