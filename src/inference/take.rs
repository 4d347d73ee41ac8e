//! Primitives from elsewhere as the state of a run.

use std::collections::{HashMap, HashSet};

use super::abstraction::{Occurrence, Phase, Primitive, UNASSIGNED};
use super::checkpoint::{MOST_IDS, is_sigma, is_sound};
use super::edit::{Outcome, refuse};
use super::fit::sum_squared_radial;
use super::refine::Layout;
use super::sampler::{Cancel, Sampler};
use super::state::Cluster;
use super::streams::{Purpose, stream};

impl Sampler {
    /// Puts these primitives in the place of all others; see
    /// [`super::Edit::Take`]. A σ that is not known is drawn as after a sweep.
    pub(super) fn take(
        &mut self,
        primitives: &[Primitive],
        labels: &[u32],
        cancel: &Cancel,
    ) -> Outcome<Vec<Occurrence>> {
        if primitives.is_empty() {
            return refuse("there are no primitives to take");
        }
        if let Some(locked) = self.state.clusters.iter().find(|c| c.locked) {
            return refuse(format!("primitive {} is locked; unlock it first", locked.id));
        }
        let samples = self.state.labels.len();
        if !labels.is_empty() && labels.len() != samples {
            return refuse(format!(
                "there are labels for {} samples, but the cloud has {samples}",
                labels.len()
            ));
        }
        let mut ids = HashSet::new();
        let mut clusters = Vec::with_capacity(primitives.len());
        for Primitive { id, shape, sigma, .. } in primitives {
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
            let sigma = sigma * self.state.model.frame.scale();
            if !is_sigma(sigma) && sigma != 0.0 {
                return refuse(format!("σ of primitive {id} is out of its limits"));
            }
            let (revision, floor) = (self.state.new_revision(), self.state.model.sigma_floor());
            let sigma = if sigma > 0.0 { sigma } else { floor };
            clusters.push(Cluster { id: *id, revision, shape: normalised, sigma, locked: false });
        }
        let state = &mut self.state;
        state.next_id = state.next_id.max(ids.iter().max().map_or(0, |id| id + 1));
        state.clusters = clusters;
        state.pinned = [].into();
        state.labels.fill(UNASSIGNED);
        state.frozen.fill(false);
        if labels.is_empty() {
            let mut layout = Layout::of(&state.model, state, &self.params, cancel);
            layout.assign();
            let labels = layout.labels();
            state.labels = labels;
        } else {
            let places: HashMap<u32, u32> = primitives.iter().map(|p| p.id).zip(0..).collect();
            let place = |id: &u32| places.get(id).copied().unwrap_or(UNASSIGNED);
            state.labels = labels.iter().map(place).collect();
        }
        for (j, members) in state.members().iter().enumerate() {
            let cluster = &state.clusters[j];
            if primitives[j].sigma > 0.0 {
                continue;
            }
            let sum_d2 = sum_squared_radial(&cluster.shape, &state.model.gather(members));
            let revision = cluster.revision as u32;
            let mut rng = stream(self.params.seed, Purpose::Edit, state.iteration, revision);
            state.clusters[j].sigma = state.model.draw_sigma(sum_d2, members.len(), &mut rng);
        }
        self.phase = Phase::Finished;
        Ok(vec![Occurrence::Taken { primitives: primitives.len() }])
    }
}
