//! Primitives from elsewhere as the state of a run.

use std::collections::{HashMap, HashSet};

use crate::geometry::Superquadric;
use crate::geometry::theta::Bounds;
use crate::inference::control::{Cancel, Outcome, refuse};
use crate::inference::data::abstraction::{Occurrence, Phase, Primitive};
use crate::inference::data::change::{Change, Draw, Identity, Noise, Successor};
use crate::inference::data::limits::{MOST_IDS, is_sigma};
use crate::inference::data::random_streams::Purpose;
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::moves::configuration::Configuration;

impl Sampler {
    /// Puts these primitives in the place of all others; see
    /// [`crate::inference::runs::edit::Edit::Take`]. A σ that is not known is
    /// drawn as after a sweep.
    pub(crate) fn take(
        &mut self,
        primitives: &[Primitive],
        labels: &[u32],
        cancel: &Cancel,
    ) -> Outcome<Vec<Occurrence>> {
        if primitives.is_empty() {
            return refuse("there are no primitives to import");
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
        let (mut shapes, mut sigmas) = (Vec::new(), Vec::new());
        for Primitive { id, shape, sigma, .. } in primitives {
            let normalised = self.state.model.normalization.normalized_shape(shape);
            if !(shape.is_valid() && normalised.check(&Bounds::RUN).is_ok()) {
                return refuse(format!(
                    "primitive {id} cannot be used: an exponent is not between 0.01 and 2, it is too large \
                     or too far from the points, or a number is not finite"
                ));
            }
            if *id >= MOST_IDS || !ids.insert(*id) {
                return refuse(format!("the id {id} is too large or is used twice"));
            }
            let sigma = sigma * self.state.model.normalization.scale();
            if !is_sigma(sigma) && sigma != 0.0 {
                return refuse(format!("σ of primitive {id} is out of range"));
            }
            shapes.push(normalised);
            sigmas.push(sigma);
        }
        let members = self.members_of_import(primitives, &shapes, labels, cancel);
        let seed = self.params.seed;
        let added = members.into_iter().enumerate().map(|(j, members)| Successor {
            identity: Identity::Id(primitives[j].id),
            shape: shapes[j],
            members,
            noise: if sigmas[j] > 0.0 {
                Noise::Given(sigmas[j])
            } else {
                Noise::Conditional(Draw::Revision(seed, Purpose::Edit), None)
            },
        });
        let removed = (0..self.state.clusters.len()).collect();
        self.state.pinned = [].into();
        self.state.apply(Change { removed, added: added.collect(), ..Change::default() });
        self.phase = Phase::Finished;
        Ok(vec![Occurrence::Taken { primitives: primitives.len() }])
    }

    /// The points of each imported primitive: by their labels, if there are any;
    /// else each joins the nearest primitive but for outliers.
    fn members_of_import(
        &self,
        primitives: &[Primitive],
        shapes: &[Superquadric],
        labels: &[u32],
        cancel: &Cancel,
    ) -> Vec<Vec<u32>> {
        if labels.is_empty() {
            let mut configuration = Configuration::new(&self.state.model, shapes, &self.params, cancel);
            configuration.assign();
            return configuration.members;
        }
        let places: HashMap<u32, usize> = primitives.iter().map(|p| p.id).zip(0..).collect();
        let mut members = vec![Vec::new(); primitives.len()];
        for (i, id) in (0u32..).zip(labels) {
            if let Some(&j) = places.get(id) {
                members[j].push(i);
            }
        }
        members
    }
}
