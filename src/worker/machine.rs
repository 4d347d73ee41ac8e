//! What the worker steps: a run, seen through the few calls it needs, so
//! that the thread's own promises can be tested with a machine that stalls or
//! panics on demand.

use std::sync::Arc;

use crate::geometry::SampleCloud;
use crate::inference::{
    Abstraction, Cancel, Checkpoint, Edit, InferenceError, MergeProposal, MergeReport, Occurrence, Params,
    Run,
};

/// A run as a machine of steps; a clone is a checkpoint.
pub(crate) trait Steppable: Clone + Send + 'static {
    fn start(cloud: Arc<SampleCloud>, params: Params, cancel: &Cancel) -> Result<Self, InferenceError>;
    /// A start on the same cloud.
    fn restarted(&self, params: Params, cancel: &Cancel) -> Result<Self, InferenceError>;
    /// Goes on from a checkpoint of a run on the same cloud.
    fn resumed(&self, checkpoint: &Checkpoint, cancel: &Cancel) -> Result<Self, InferenceError>;
    /// Goes on from a checkpoint of a run on that cloud.
    fn resume(
        cloud: Arc<SampleCloud>,
        checkpoint: &Checkpoint,
        cancel: &Cancel,
    ) -> Result<Self, InferenceError>;
    fn checkpoint(&self) -> Checkpoint;
    /// The parameters in force.
    fn params(&self) -> Params;
    fn set_params(&mut self, params: Params) -> Result<(), InferenceError>;
    fn is_finished(&self) -> bool;
    fn step(&mut self, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError>;
    fn step_merge(&mut self, cancel: &Cancel) -> Result<Vec<MergeReport>, InferenceError>;
    fn edit(&mut self, edit: &Edit, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError>;
    /// Makes a finished run one with so many further iterations to go.
    fn extend(&mut self, iterations: u32) -> Result<(), InferenceError>;
    fn propose_merge(
        &mut self,
        of: Option<(u32, u32)>,
        skipped: &[(u32, u32)],
        cancel: &Cancel,
    ) -> Result<Option<MergeProposal>, InferenceError>;
    fn abstraction(&self) -> Abstraction;
}

impl Steppable for Run {
    fn start(cloud: Arc<SampleCloud>, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        Self::new(cloud, params, cancel)
    }
    fn restarted(&self, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        self.restarted(params, cancel)
    }
    fn resumed(&self, checkpoint: &Checkpoint, cancel: &Cancel) -> Result<Self, InferenceError> {
        self.resumed(checkpoint, cancel)
    }
    fn resume(
        cloud: Arc<SampleCloud>,
        checkpoint: &Checkpoint,
        cancel: &Cancel,
    ) -> Result<Self, InferenceError> {
        Self::resume(cloud, checkpoint, cancel)
    }
    fn checkpoint(&self) -> Checkpoint {
        self.checkpoint()
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
    fn step_merge(&mut self, cancel: &Cancel) -> Result<Vec<MergeReport>, InferenceError> {
        self.step_merge(cancel)
    }
    fn edit(&mut self, edit: &Edit, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        self.edit(edit, cancel)
    }
    fn extend(&mut self, iterations: u32) -> Result<(), InferenceError> {
        self.resample(iterations)
    }
    fn propose_merge(
        &mut self,
        of: Option<(u32, u32)>,
        skipped: &[(u32, u32)],
        cancel: &Cancel,
    ) -> Result<Option<MergeProposal>, InferenceError> {
        match of {
            Some((a, b)) => self.propose_merge_of(a, b, cancel).map(Some),
            None => self.propose_merge(skipped, cancel),
        }
    }
    fn abstraction(&self) -> Abstraction {
        self.abstraction()
    }
}
