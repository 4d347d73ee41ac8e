//! The data that the viewport uploads, made anew only when its source changed.

use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};

use nalgebra::Point3;
use rayon::prelude::*;

use crate::inference::UNASSIGNED;
use crate::io::ShapeGeometry;
use crate::render::{Highlight, PickScene, PointIndex, PrimitiveInstance};
use crate::session::Session;
use crate::session::scene::{SceneFromInput, shown_colors, shown_points};
use crate::worker::{LoadedShape, Snapshot};

/// Up to this many points, what lies under the pointer is looked up as it moves
/// also without an index.
const QUICK_POINTS: usize = 200_000;

/// Data with a number that changes when it does; 0 is no data.
#[derive(Debug, Default)]
pub(super) struct Versioned<T> {
    version: u64,
    data: Arc<T>,
}

/// Shares the data, whether or not `T` can be cloned.
impl<T> Clone for Versioned<T> {
    fn clone(&self) -> Self {
        Self { version: self.version, data: Arc::clone(&self.data) }
    }
}

impl<T> Versioned<T> {
    fn set(&mut self, data: T) {
        self.version += 1;
        self.data = Arc::new(data);
    }

    /// Calls `upload` if `uploaded` is another version.
    pub(super) fn upload(&self, uploaded: &mut u64, upload: impl FnOnce(&T)) {
        if *uploaded != self.version {
            *uploaded = self.version;
            upload(&self.data);
        }
    }
}

#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub(super) vertices: Vec<[f32; 3]>,
    pub(super) faces: Vec<[u32; 3]>,
}

/// What the data was made of.
#[derive(Debug, Clone, Default)]
struct Made {
    shape: Option<Arc<LoadedShape>>,
    transform: Option<SceneFromInput>,
    snapshot: Option<Arc<Snapshot>>,
    hidden: BTreeSet<u32>,
    selection: BTreeSet<u32>,
    hovered: Option<u32>,
}

/// All data in scene units; cheap to clone.
#[derive(Debug, Clone, Default)]
pub(super) struct Scene {
    made: Made,
    pub(super) points: Versioned<Vec<[f32; 3]>>,
    /// That of the points, once it has been made in the background.
    index: Arc<OnceLock<PointIndex>>,
    pub(super) colors: Versioned<Vec<[u8; 4]>>,
    pub(super) mesh: Versioned<Mesh>,
    pub(super) primitives: Versioned<Vec<PrimitiveInstance>>,
}

impl Scene {
    /// Takes over what has changed in the session.
    pub(super) fn update(&mut self, session: &Session, hovered: Option<u32>) {
        let same_transform = self.made.transform == Some(session.scene);
        let same_shape = same(&self.made.shape, &session.loaded) && same_transform;
        let same_snapshot = same(&self.made.snapshot, &session.snapshot) && same_shape;
        let same_hidden = self.made.hidden == session.hidden;
        if !same_shape {
            self.take_shape(session);
        }
        if !same_snapshot || !same_hidden {
            self.color_points(session);
        }
        if !same_snapshot
            || !same_hidden
            || self.made.selection != session.selection
            || self.made.hovered != hovered
        {
            self.take_primitives(session, hovered);
        } else {
            return;
        }
        self.made = Made {
            shape: session.loaded.clone(),
            transform: Some(session.scene),
            snapshot: session.snapshot.clone(),
            hidden: session.hidden.clone(),
            selection: session.selection.clone(),
            hovered,
        };
    }

    fn take_shape(&mut self, session: &Session) {
        let to_scene = |p: &Point3<f64>| -> [f32; 3] {
            let p = session.scene.point(p);
            [p.x as f32, p.y as f32, p.z as f32]
        };
        let Some(loaded) = &session.loaded else { return };
        self.points.set(shown_points(loaded).par_iter().with_min_len(1 << 14).map(to_scene).collect());
        self.index = Arc::default();
        let (points, index) = (Arc::clone(&self.points.data), Arc::clone(&self.index));
        rayon::spawn(move || {
            index.get_or_init(|| PointIndex::new(&points));
        });
        self.mesh.set(match &loaded.shape.geometry {
            ShapeGeometry::Mesh(mesh) => {
                Mesh { vertices: mesh.vertices.iter().map(to_scene).collect(), faces: mesh.faces.clone() }
            }
            ShapeGeometry::Cloud(_) => Mesh::default(),
        });
    }

    fn color_points(&mut self, session: &Session) {
        let colors = match (&session.snapshot, &session.loaded) {
            (Some(snapshot), Some(loaded)) => {
                shown_colors(loaded, &snapshot.abstraction.labels, &session.hidden, |id| session.color_of(id))
            }
            // Nothing is labelled yet.
            (None, Some(loaded)) => {
                let labels = vec![UNASSIGNED; loaded.cloud.points.len()];
                shown_colors(loaded, &labels, &session.hidden, |id| session.color_of(id))
            }
            (_, None) => Vec::new(),
        };
        self.colors.set(colors);
    }

    fn take_primitives(&mut self, session: &Session, hovered: Option<u32>) {
        let instances = session
            .primitives()
            .iter()
            .filter(|primitive| primitive.shape.is_valid())
            .map(|primitive| {
                let id = primitive.id;
                PrimitiveInstance {
                    id,
                    shape: session.scene.shape(&primitive.shape),
                    color: opaque(session.color_of(id)),
                    visible: !session.hidden.contains(&id),
                    highlight: if session.selection.contains(&id) {
                        Highlight::Selected
                    } else if hovered == Some(id) {
                        Highlight::Hovered
                    } else {
                        Highlight::None
                    },
                }
            })
            .collect();
        self.primitives.set(instances);
    }

    /// Whether what lies under the pointer is found in no time.
    pub(super) fn is_quick_to_pick(&self) -> bool {
        self.points.data.len() <= QUICK_POINTS || self.index.get().is_some()
    }

    pub(super) fn pickable(&self) -> PickScene<'_> {
        PickScene {
            points: &self.points.data,
            point_colors: &self.colors.data,
            point_index: self.index.get(),
            primitives: &self.primitives.data,
        }
    }
}

fn same<T>(a: &Option<Arc<T>>, b: &Option<Arc<T>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (None, None) => true,
        _ => false,
    }
}

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 255]
}
