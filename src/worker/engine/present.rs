//! The shape at hand with its run.

use std::sync::Arc;
use std::time::Duration;

use super::super::protocol::{LoadedShape, Snapshot};
use crate::inference::{Abstraction, Params};

/// A shape with its run.
pub(super) struct Present<M> {
    pub(super) shape: Arc<LoadedShape>,
    pub(super) run: u64,
    pub(super) start: Params,
    pub(super) machine: M,
    pub(super) abstraction: Abstraction,
    pub(super) elapsed: Duration,
    /// The state that the last step led to, until it is measured or the run
    /// starts anew.
    pub(super) unmeasured: Option<Arc<Snapshot>>,
}
