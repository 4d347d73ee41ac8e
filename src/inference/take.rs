//! Primitives from elsewhere as the state of a run.

use std::collections::HashSet;

use super::abstraction::{Occurrence, Phase, UNASSIGNED};
use super::checkpoint::{MOST_IDS, is_sound};
use super::edit::{Outcome, refuse};
use super::fit::sum_squared_radial;
use super::refine::Layout;
use super::sampler::{Cancel, Sampler};
use super::state::Cluster;
use super::streams::{Purpose, stream};
use crate::geometry::Superquadric;

impl Sampler {
    /// Puts these primitives in the place of all others; see
    /// [`super::Edit::Take`]. σ is drawn as after a sweep.
    pub(super) fn take(
        &mut self,
        primitives: &[(u32, Superquadric)],
        cancel: &Cancel,
    ) -> Outcome<Vec<Occurrence>> {
        if primitives.is_empty() {
            return refuse("there are no primitives to take");
        }
        if let Some(locked) = self.state.clusters.iter().find(|c| c.locked) {
            return refuse(format!("primitive {} is locked; unlock it first", locked.id));
        }
        let mut ids = HashSet::new();
        let mut clusters = Vec::with_capacity(primitives.len());
        for (id, shape) in primitives {
            let normalised = self.state.model.frame.normalized_shape(shape);
            if !(shape.is_valid() && is_sound(&normalised)) {
                return refuse(format!(
                    "primitive {id} is none that can be sampled: an exponent is not between 0.01 and 2, it \
                     is too large or too far from the points, or a number is not finite"
                ));
            }
            if *id >= MOST_IDS || !ids.insert(*id) {
                return refuse(format!("the id {id} is too large, or belongs to two primitives"));
            }
            let (revision, sigma) = (self.state.new_revision(), self.state.model.sigma_floor());
            clusters.push(Cluster { id: *id, revision, shape: normalised, sigma, locked: false });
        }
        let state = &mut self.state;
        state.next_id = state.next_id.max(ids.iter().max().map_or(0, |id| id + 1));
        state.clusters = clusters;
        state.pinned = [].into();
        state.labels.fill(UNASSIGNED);
        state.frozen.fill(false);
        let mut layout = Layout::of(&state.model, state, &self.params, cancel);
        layout.assign();
        let labels = layout.labels();
        state.labels = labels;
        for (j, members) in state.members().iter().enumerate() {
            let cluster = &state.clusters[j];
            let sum_d2 = sum_squared_radial(&cluster.shape, &state.model.gather(members));
            let revision = cluster.revision as u32;
            let mut rng = stream(self.params.seed, Purpose::Edit, state.iteration, revision);
            state.clusters[j].sigma = state.model.draw_sigma(sum_d2, members.len(), &mut rng);
        }
        self.phase = Phase::Finished;
        Ok(vec![Occurrence::Taken { primitives: primitives.len() }])
    }
}
