//! Interactive editing of a primitive: a drag is previewed immediately and becomes one edit when it
//! ends, that is, one state and one undo step.

use nalgebra::Rotation3;

use super::shaping::{ShapeDraft, ShapeLimits, Shaping, angles_near};
use super::{Effect, Session};
use crate::geometry::Superquadric;
use crate::inference::{Algorithm, Edit, Primitive};
use crate::worker::Activity;

impl Session {
    /// The shown shape of a primitive: its draft during a drag, otherwise its own.
    pub fn shape_of<'a>(&'a self, primitive: &'a Primitive) -> &'a Superquadric {
        self.draft().filter(|(id, _)| *id == primitive.id).map_or(&primitive.shape, |(_, shape)| shape)
    }

    /// The primitive being edited, by id, with its draft.
    pub fn draft(&self) -> Option<(u32, &Superquadric)> {
        self.shaping.as_ref().map(|s| (s.id, &s.shape))
    }

    /// Whether a primitive is being dragged.
    pub fn is_shaping(&self) -> bool {
        self.shaping.is_some_and(|s| !s.is_sent)
    }

    /// The limits of manually edited shapes.
    pub fn shape_limits(&self) -> ShapeLimits {
        ShapeLimits { extent: 1.0 / self.scene.scale(), center: self.scene.center() }
    }

    /// Turns about x, then y, then z, in radians, that make up a primitive's
    /// rotation. Of all that do, those next to the last ones, so that numbers
    /// do not jump while the primitive is turned.
    pub fn angles_of(&self, id: u32, rotation: &Rotation3<f64>) -> [f64; 3] {
        let near = self.last_angles.filter(|(of, _)| *of == id).map_or([0.0; 3], |(_, angles)| angles);
        angles_near(rotation, near)
    }

    /// Why the shape of a primitive cannot be edited now.
    pub fn why_fixed(&self, primitive: &Primitive) -> Option<&'static str> {
        if self.activity == Activity::Loading {
            Some("A shape is loading")
        } else if self.algorithm() != Algorithm::Sampler {
            Some("Only states of the sampler can be edited. Choose a sampler method and run")
        } else if primitive.locked {
            Some("Locked. Unlock the primitive to edit it")
        } else {
            None
        }
    }

    pub(super) fn take_draft(&mut self, ShapeDraft { id, shape, angles }: ShapeDraft) {
        let Some(primitive) = self.primitives().iter().find(|p| p.id == id) else { return };
        let is_finite = shape.translation.iter().chain(shape.rotation.matrix().iter()).all(|v| v.is_finite());
        if self.why_fixed(primitive).is_some() || !is_finite {
            return;
        }
        let shape = self.shape_limits().clamped(&shape);
        if !shape.is_valid() {
            return;
        }
        self.last_angles = Some((id, angles.unwrap_or_else(|| self.angles_of(id, &shape.rotation))));
        self.drop_proposal();
        self.shaping = Some(Shaping { id, shape, is_sent: false });
    }

    /// The edit that results from the drag, if anything has changed.
    pub(super) fn drafted_edit(&self) -> Option<Edit> {
        let Shaping { id, shape, is_sent: false } = self.shaping? else { return None };
        let before = self.primitives().iter().find(|p| p.id == id)?;
        (before.shape != shape).then_some(Edit::SetShape { id, shape })
    }

    /// Ends the drag.
    pub(super) fn end_shaping(&mut self) -> Vec<Effect> {
        let Some(edit) = self.drafted_edit() else {
            self.shaping.take_if(|s| !s.is_sent);
            return Vec::new();
        };
        let shaping = self.shaping;
        let effects = self.edit(vec![edit]);
        // Shown until the worker's answer is there.
        self.shaping = shaping.map(|s| Shaping { is_sent: true, ..s });
        effects
    }

    /// Cancels the drag and restores the primitive.
    pub(super) fn drop_draft(&mut self) {
        self.shaping = None;
    }

    /// The edit has been answered, or another state is shown in which the primitive may not exist.
    pub(super) fn settle_draft(&mut self) {
        let Some(Shaping { id, is_sent, .. }) = self.shaping else { return };
        let is_free = self.primitives().iter().any(|p| p.id == id && !p.locked);
        if is_sent || !is_free {
            self.shaping = None;
        }
    }
}
