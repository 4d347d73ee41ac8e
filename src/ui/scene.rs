//! The data that the viewport uploads, made anew only when its source changed.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::Point3;

use crate::geometry::palette::{UNASSIGNED_COLOR, color_of};
use crate::inference::UNASSIGNED;
use crate::io::ShapeGeometry;
use crate::render::{Highlight, PickScene, PrimitiveInstance};
use crate::session::Session;
use crate::session::scene::SceneFromInput;
use crate::worker::{LoadedShape, Snapshot};

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
        self.points.set(loaded.cloud.points.iter().map(to_scene).collect());
        self.mesh.set(match &loaded.shape.geometry {
            ShapeGeometry::Mesh(mesh) => {
                Mesh { vertices: mesh.vertices.iter().map(to_scene).collect(), faces: mesh.faces.clone() }
            }
            ShapeGeometry::Cloud(_) => Mesh::default(),
        });
    }

    fn color_points(&mut self, session: &Session) {
        let [r, g, b] = UNASSIGNED_COLOR;
        let unassigned = [r, g, b, 255];
        let colors = match (&session.snapshot, &session.loaded) {
            (Some(snapshot), _) => {
                let color = |label: &u32| match *label {
                    UNASSIGNED => unassigned,
                    id if session.hidden.contains(&id) => [0; 4],
                    id => opaque(id),
                };
                snapshot.abstraction.labels.iter().map(color).collect()
            }
            (None, Some(loaded)) => vec![unassigned; loaded.cloud.points.len()],
            (None, None) => Vec::new(),
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
                    color: opaque(id),
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

    pub(super) fn points(&self) -> &[[f32; 3]] {
        &self.points.data
    }

    pub(super) fn pickable(&self) -> PickScene<'_> {
        PickScene {
            points: &self.points.data,
            point_colors: &self.colors.data,
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

fn opaque(id: u32) -> [u8; 4] {
    let [r, g, b] = color_of(id);
    [r, g, b, 255]
}
