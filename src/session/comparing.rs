//! Comparing the shown state with another.

use std::sync::Arc;

use super::action::Action;
use super::comparison::{Compared, Comparison};
use super::{Effect, Session};
use crate::worker::{Activity, Command, State};

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
