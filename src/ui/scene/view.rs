//! What a viewport shows, borrowed from where it is kept.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::geometry::Superquadric;
use crate::geometry::palette::Colors;
use crate::inference::Primitive;
use crate::session::Session;
use crate::session::camera::Camera;
use crate::session::gizmo::Mode;
use crate::session::scalar::{Scalar, SurfaceScalar};
use crate::session::scene::SceneFromInput;
use crate::session::seeds::Seeds;
use crate::session::view::View;
use crate::worker::{Activity, LoadedShape, Snapshot};

/// A state of a shape with its view settings, as given to a viewport.
#[derive(Debug, Clone)]
pub(in crate::ui) struct SceneView<'a> {
    pub(in crate::ui) loaded: Option<&'a Arc<LoadedShape>>,
    pub(in crate::ui) snapshot: Option<&'a Arc<Snapshot>>,
    /// The states up to this one, the last one last.
    pub(in crate::ui) history: &'a [Arc<Snapshot>],
    /// Runs with other seeds.
    pub(in crate::ui) seeds: Option<&'a Seeds>,
    /// Of primitives.
    pub(in crate::ui) colors: Arc<Colors>,
    pub(in crate::ui) scene: &'a SceneFromInput,
    pub(in crate::ui) camera: &'a Camera,
    /// A camera whose number changed has jumped, and may be eased.
    pub(in crate::ui) camera_jumps: u64,
    pub(in crate::ui) view: &'a View,
    /// Ids of primitives.
    pub(in crate::ui) selection: &'a BTreeSet<u32>,
    /// Indices of samples, ascending.
    pub(in crate::ui) selected_points: &'a Arc<[u32]>,
    /// Ids of primitives.
    pub(in crate::ui) hidden: &'a BTreeSet<u32>,
    /// Point colours that override the view's `color_by`.
    pub(in crate::ui) scalar: Option<&'a Arc<Scalar>>,
    /// Colours of the primitives' surfaces.
    pub(in crate::ui) surface_scalar: Option<&'a Arc<SurfaceScalar>>,
    /// Samples to highlight, regardless of `color_by`.
    pub(in crate::ui) disagrees: Option<&'a Arc<[bool]>>,
    /// Ids of highlighted primitives, such as a proposed pair.
    pub(in crate::ui) lit: Vec<u32>,
    /// The primitive being edited, by id, with its shape in input units.
    pub(in crate::ui) draft: Option<(u32, Superquadric)>,
    /// Previewed primitives, in input units.
    pub(in crate::ui) ghosts: Vec<Superquadric>,
    /// The primitive, by id, that has handles, and what they change.
    pub(in crate::ui) handles: Option<(u32, Mode)>,
    /// The explained sample.
    pub(in crate::ui) marked: Option<u32>,
    pub(in crate::ui) is_loading: bool,
}

impl<'a> SceneView<'a> {
    /// The current state of the session.
    pub(in crate::ui) fn of(session: &'a Session) -> Self {
        Self {
            loaded: session.loaded.as_ref(),
            snapshot: session.snapshot.as_ref(),
            history: session.timeline.history(),
            seeds: Some(&session.seeds),
            colors: session.timeline.current().map(|b| Arc::clone(&b.colors)).unwrap_or_default(),
            scene: &session.scene,
            camera: &session.camera,
            camera_jumps: session.camera_jumps,
            view: &session.view,
            selection: &session.selection,
            selected_points: &session.selected_points,
            hidden: &session.hidden,
            scalar: None,
            surface_scalar: None,
            disagrees: None,
            lit: session.proposal.iter().flat_map(|p| [p.pair.0, p.pair.1]).collect(),
            ghosts: session.proposal.iter().map(|p| p.union).collect(),
            draft: session.draft().map(|(id, shape)| (id, *shape)),
            handles: handled(session),
            marked: session.explained.filter(|_| session.view.shows_odds),
            is_loading: session.activity == Activity::Loading,
        }
    }

    /// The primitive that has handles, with its shape in input units as it is
    /// shown.
    pub(in crate::ui) fn handled(&self) -> Option<(u32, &Superquadric, Mode)> {
        let (id, mode) = self.handles?;
        let primitive = self.primitives().iter().find(|p| p.id == id)?;
        let drafted = self.draft.as_ref().filter(|draft| draft.0 == id);
        Some((id, drafted.map_or(&primitive.shape, |draft| &draft.1), mode))
    }

    pub(in crate::ui) fn primitives(&self) -> &'a [Primitive] {
        self.snapshot.map_or(&[], |s| &s.abstraction.primitives)
    }
}

/// The one selected primitive, where it may be changed and is seen, and what its
/// handles change.
fn handled(session: &Session) -> Option<(u32, Mode)> {
    let primitive = session.selected_primitive()?;
    let can = session.why_fixed(primitive).is_none()
        && !session.is_judging()
        && !session.hidden.contains(&primitive.id);
    session.handles.filter(|_| can).map(|mode| (primitive.id, mode))
}
