//! The content of a viewport and its GPU data, rebuilt only when the source changes.

use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};

use nalgebra::Point3;
use rayon::prelude::*;

use crate::geometry::Superquadric;
use crate::geometry::palette::{Colors, UNASSIGNED_COLOR};
use crate::io::ShapeGeometry;
use crate::render::colormap::viridis;
use crate::render::{Highlight, PickScene, PointIndex, PrimitiveInstance, SurfacePaint};
use crate::session::paint::{Paint, faded, shown_colors, shown_points};
use crate::session::scalar::{Scalar, SurfaceScalar, Unit};
use crate::session::scene::SceneFromInput;
use crate::session::view::ColorBy;
use crate::worker::{LoadedShape, Snapshot};

mod coloring;
mod view;

use coloring::{Coloring, Numbers, ViewValues};
pub(super) use view::SceneView;

/// Up to this many points, picking on hover works without an index.
const QUICK_POINTS: usize = 200_000;

/// Data with a version number; 0 means no data.
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

/// Source of the data.
#[derive(Debug, Clone, Default)]
struct Made {
    shape: Option<Arc<LoadedShape>>,
    transform: Option<SceneFromInput>,
    snapshot: Option<Arc<Snapshot>>,
    hidden: BTreeSet<u32>,
    selection: BTreeSet<u32>,
    selected_points: Arc<[u32]>,
    colors: Arc<Colors>,
    color_by: ColorBy,
    scalar: Option<Arc<Scalar>>,
    surface_scalar: Option<Arc<SurfaceScalar>>,
    disagrees: Option<Arc<[bool]>>,
    lit: Vec<u32>,
    draft: Option<(u32, Superquadric)>,
    ghosts: Vec<Superquadric>,
    hovered: Option<u32>,
}

/// All data in scene units; cheap to clone.
#[derive(Debug, Clone, Default)]
pub(super) struct Scene {
    made: Made,
    coloring: Coloring,
    /// What the colours should show, and why they do not.
    missing: Option<&'static str>,
    pub(super) points: Versioned<Vec<[f32; 3]>>,
    /// That of the points, once it has been made in the background.
    index: Arc<OnceLock<PointIndex>>,
    pub(super) colors: Versioned<Vec<[u8; 4]>>,
    pub(super) mesh: Versioned<Mesh>,
    pub(super) primitives: Versioned<Vec<PrimitiveInstance>>,
    pub(super) paint: Versioned<Vec<SurfacePaint>>,
}

impl Scene {
    /// Updates what has changed. Values that take long to compute arrive in a
    /// later frame of the window; without a window, this call waits.
    pub(super) fn update(
        &mut self,
        view: &SceneView<'_>,
        hovered: Option<u32>,
        window: Option<&egui::Context>,
    ) {
        let told = self.coloring.update(view, window);
        self.missing = None;
        let (mut scalar, mut surface_scalar) = (view.scalar.cloned(), view.surface_scalar.cloned());
        if scalar.is_none() && surface_scalar.is_none() {
            match told {
                ViewValues::Nothing => {}
                ViewValues::Missing(why) => self.missing = Some(why),
                ViewValues::Numbers(Numbers::Points(numbers)) => scalar = Some(numbers),
                ViewValues::Numbers(Numbers::Surfaces(numbers)) => surface_scalar = Some(numbers),
            }
        }
        let same_transform = self.made.transform.as_ref() == Some(view.scene);
        let same_shape = same(self.made.shape.as_ref(), view.loaded) && same_transform;
        let same_snapshot = same(self.made.snapshot.as_ref(), view.snapshot) && same_shape;
        let same_colors = Arc::ptr_eq(&self.made.colors, &view.colors) || self.made.colors == view.colors;
        // Both go into points and primitives.
        let same_hidden = self.made.hidden == *view.hidden && same_colors;
        let same_lit = self.made.lit == view.lit;
        let same_paint = same_lit
            && self.made.color_by == view.view.color_by
            && same(self.made.scalar.as_ref(), scalar.as_ref())
            && same(self.made.disagrees.as_ref(), view.disagrees)
            && Arc::ptr_eq(&self.made.selected_points, view.selected_points);
        let same_marks = self.made.selection == *view.selection
            && self.made.hovered == hovered
            && same_lit
            && self.made.draft == view.draft
            && self.made.ghosts == view.ghosts;
        let same_surfaces = same(self.made.surface_scalar.as_ref(), surface_scalar.as_ref());
        if same_snapshot && same_hidden && same_paint && same_marks && same_surfaces {
            return;
        }
        if !same_shape {
            self.take_shape(view);
        }
        if !same_snapshot || !same_hidden || !same_paint {
            self.color_points(view, scalar.as_deref());
        }
        // Where points tell numbers, no other colours should.
        let same_tone = self.made.scalar.is_some() == scalar.is_some();
        if !same_snapshot || !same_hidden || !same_marks || !same_tone {
            self.take_primitives(view, hovered, scalar.is_some());
        }
        if !same_snapshot || !same_surfaces {
            let paint = surface_scalar.as_deref().map_or_else(Vec::new, paint_of);
            self.paint.set(paint);
        }
        self.made = Made {
            shape: view.loaded.cloned(),
            transform: Some(*view.scene),
            snapshot: view.snapshot.cloned(),
            hidden: view.hidden.clone(),
            selection: view.selection.clone(),
            selected_points: Arc::clone(view.selected_points),
            colors: Arc::clone(&view.colors),
            color_by: view.view.color_by,
            scalar,
            surface_scalar,
            disagrees: view.disagrees.cloned(),
            lit: view.lit.clone(),
            draft: view.draft,
            ghosts: view.ghosts.clone(),
            hovered,
        };
    }

    fn take_shape(&mut self, view: &SceneView<'_>) {
        let scene = view.scene;
        let to_scene = |p: &Point3<f64>| -> [f32; 3] { scene.point(p).coords.map(|c| c as f32).into() };
        let Some(loaded) = view.loaded else { return };
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

    fn color_points(&mut self, view: &SceneView<'_>, scalar: Option<&Scalar>) {
        let Some(loaded) = view.loaded else { return self.colors.set(Vec::new()) };
        // Before the first state nothing is labelled.
        let labels = view.snapshot.map_or(&[][..], |s| &s.abstraction.labels);
        let paint = match (scalar, view.view.color_by) {
            _ if view.disagrees.is_some() => Paint::Marked(view.disagrees.map_or(&[], |d| d)),
            (Some(scalar), _) => Paint::Scalar(scalar, viridis),
            (None, ColorBy::Input) => Paint::Input,
            (None, ColorBy::Plain | ColorBy::SurfaceDistance) => Paint::Plain,
            // Or numbers that are not there yet.
            (None, _) if view.lit.is_empty() => Paint::Clusters(&view.colors),
            (None, _) => Paint::Lit(&view.colors, &view.lit),
        };
        let pinned = view.snapshot.map_or(&[][..], |s| &s.abstraction.pinned);
        self.colors.set(shown_colors(loaded, labels, view.hidden, view.selected_points, pinned, paint));
    }

    fn take_primitives(&mut self, view: &SceneView<'_>, hovered: Option<u32>, is_grey: bool) {
        let present = view.primitives().iter().filter(|primitive| primitive.shape.is_valid());
        let instances = present.map(|primitive| {
            let id = primitive.id;
            let shape = view.draft.as_ref().filter(|d| d.0 == id).map_or(&primitive.shape, |d| &d.1);
            let color = if is_grey { UNASSIGNED_COLOR } else { view.colors.of(id) };
            let is_aside = !view.lit.is_empty() && !view.lit.contains(&id);
            let color = if is_aside { faded(color) } else { color };
            PrimitiveInstance {
                id,
                shape: view.scene.shape(shape),
                color: opaque(color),
                visible: !view.hidden.contains(&id),
                highlight: if view.lit.contains(&id) {
                    Highlight::Lit
                } else if view.selection.contains(&id) {
                    Highlight::Selected
                } else if hovered == Some(id) {
                    Highlight::Hovered
                } else {
                    Highlight::None
                },
                ghost: false,
            }
        });
        let ghosts = (0..).zip(&view.ghosts).map(|(id, shape)| PrimitiveInstance {
            id,
            shape: view.scene.shape(shape),
            color: [255; 4],
            visible: true,
            highlight: Highlight::None,
            ghost: true,
        });
        self.primitives.set(instances.chain(ghosts).collect());
    }

    /// Whether picking is fast.
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

    /// Content of the legend; `None` if the colours show no values.
    pub(super) fn legend(&self) -> Option<Legend<'_>> {
        if let Some(why) = self.missing {
            return Some(Legend::Missing(why));
        }
        let bar = |title, unit, range, most| Some(Legend::Bar { title, unit, range, most });
        match (&self.made.surface_scalar, &self.made.scalar) {
            (Some(s), _) => bar(&s.title, s.unit, s.range, s.most()),
            (None, Some(s)) => bar(&s.title, s.unit, s.range, s.most()),
            (None, None) => None,
        }
    }
}

/// Content of a legend.
#[derive(Debug, Clone, Copy)]
pub(super) enum Legend<'a> {
    Bar {
        title: &'a str,
        unit: Unit,
        /// The first and the last number with a colour of its own.
        range: (f32, f32),
        /// The largest number.
        most: f32,
    },
    /// Why there are no values.
    Missing(&'static str),
}

fn paint_of(scalar: &SurfaceScalar) -> Vec<SurfacePaint> {
    let paint = |(id, values): &(u32, Vec<f32>)| SurfacePaint {
        id: *id,
        colors: values
            .iter()
            .map(|&value| {
                let [r, g, b] = viridis(scalar.share(value));
                [r, g, b, if value.is_nan() { 0 } else { 255 }]
            })
            .collect(),
    };
    scalar.values.iter().map(paint).collect()
}

fn same<T: ?Sized>(a: Option<&Arc<T>>, b: Option<&Arc<T>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (None, None) => true,
        _ => false,
    }
}

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 255]
}
