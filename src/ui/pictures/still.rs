//! A frozen copy of the state while pictures of it are rendered.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::geometry::palette::Colors;
use crate::render::SceneTheme;
use crate::session::camera::Camera;
use crate::session::scene::SceneFromInput;
use crate::session::seeds::Seeds;
use crate::session::view::View;
use crate::ui::scene::SceneView;
use crate::ui::viewport::Shot;
use crate::worker::{LoadedShape, Snapshot};

/// What was shown when a picture was asked for, without what only a person at
/// work needs to see: what is selected and proposed.
#[derive(Debug)]
pub(super) struct Still {
    loaded: Option<Arc<LoadedShape>>,
    snapshot: Option<Arc<Snapshot>>,
    history: Vec<Arc<Snapshot>>,
    seeds: Option<Seeds>,
    colors: Arc<Colors>,
    scene: SceneFromInput,
    camera: Camera,
    view: View,
    hidden: BTreeSet<u32>,
    nothing: BTreeSet<u32>,
    no_points: Arc<[u32]>,
}

impl Still {
    pub(super) fn of(view: &SceneView<'_>) -> Self {
        Self {
            loaded: view.loaded.cloned(),
            snapshot: view.snapshot.cloned(),
            history: view.history.to_vec(),
            seeds: view.seeds.cloned(),
            colors: Arc::clone(&view.colors),
            scene: *view.scene,
            camera: *view.camera,
            view: *view.view,
            hidden: view.hidden.clone(),
            nothing: BTreeSet::new(),
            no_points: Arc::default(),
        }
    }

    pub(super) fn view(&self) -> SceneView<'_> {
        SceneView {
            loaded: self.loaded.as_ref(),
            snapshot: self.snapshot.as_ref(),
            history: &self.history,
            seeds: self.seeds.as_ref(),
            colors: Arc::clone(&self.colors),
            scene: &self.scene,
            camera: &self.camera,
            camera_jumps: 0,
            view: &self.view,
            selection: &self.nothing,
            selected_points: &self.no_points,
            hidden: &self.hidden,
            scalar: None,
            surface_scalar: None,
            disagrees: None,
            lit: Vec::new(),
            draft: None,
            handles: None,
            ghosts: Vec::new(),
            marked: None,
            is_loading: false,
        }
    }

    /// From where the camera stood.
    pub(super) fn shot(&self, size: [u32; 2], theme: SceneTheme, transparent: bool) -> Shot {
        Shot { size, camera: self.camera, theme, transparent }
    }
}
