//! The state compared with the shown one.

use std::sync::Arc;

use super::naming::StateName;
use super::timeline::Branch;
use crate::worker::Snapshot;

/// The state compared with the current one, and how it is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Comparison {
    /// Id of the branch.
    pub branch: u32,
    /// Index of the state; `None` for the latest.
    pub index: Option<usize>,
    /// Both views have the same camera.
    pub is_linked: bool,
    /// Highlight samples that belong to different primitives in both states,
    /// instead of the view's colours.
    pub paints_disagreement: bool,
}

impl Comparison {
    /// With linked cameras and the disagreement painted.
    pub fn with(branch: u32, index: Option<usize>) -> Self {
        Self { branch, index, is_linked: true, paints_disagreement: true }
    }
}

/// The state compared with the shown one.
#[derive(Debug, Clone, Copy)]
pub struct Compared<'a> {
    pub branch: &'a Branch,
    pub index: usize,
    pub snapshot: &'a Arc<Snapshot>,
    /// Both states label the same samples.
    pub same_samples: bool,
}

impl Compared<'_> {
    /// Name of the state.
    pub fn name(&self) -> StateName {
        self.branch.name_of(self.index)
    }
}
