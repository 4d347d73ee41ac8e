//! The state compared with the shown one.

use std::sync::Arc;

use super::naming::StateName;
use super::{Action, Effect, Session};
use crate::session::timeline::Branch;
use crate::worker::{Activity, Command, Snapshot, State};

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

impl Session {
    /// The compared state; `None` if there is none, or its branch was removed.
    pub fn compared(&self) -> Option<Compared<'_>> {
        let comparison = self.comparison?;
        let branch = self.timeline.branch(comparison.branch)?;
        let last = branch.states.len().checked_sub(1)?;
        let index = comparison.index.unwrap_or(last).min(last);
        let snapshot = branch.states.get(index)?;
        let shown = self.timeline.current()?;
        let same_samples = Arc::ptr_eq(&branch.loaded.cloud, &shown.loaded.cloud);
        Some(Compared { branch, index, snapshot, same_samples })
    }

    /// Starts or stops comparing with another state.
    pub(super) fn compare(&mut self, comparison: Option<Comparison>) -> Vec<Effect> {
        let was_apart = self.comparison.is_some_and(|c| !c.is_linked);
        if !was_apart {
            self.other_camera = self.camera;
        }
        self.comparison = comparison;
        let Some(other) = self.compared() else { return Vec::new() };
        if self.activity != Activity::Idle || self.measurement_of(other.snapshot.key).is_some() {
            return Vec::new();
        }
        let state = State { loaded: Arc::clone(&other.branch.loaded), snapshot: Arc::clone(other.snapshot) };
        vec![Effect::Send(Command::Measure(state))]
    }

    /// Applies a camera action to the other view.
    pub(super) fn carry_out_in_other(&mut self, action: Action) -> Vec<Effect> {
        std::mem::swap(&mut self.camera, &mut self.other_camera);
        let effects = self.carry_out(action);
        std::mem::swap(&mut self.camera, &mut self.other_camera);
        effects
    }
}
