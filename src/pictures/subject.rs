//! What a picture is taken of: a result, a session or a plain shape.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use nalgebra::Point3;

use crate::geometry::palette::Colors;
use crate::geometry::tessellate::{Resolution, surface_vertices};
use crate::geometry::{SampleCloud, SampledPart, SamplingOptions, TriMesh};
use crate::inference::{
    Abstraction, Algorithm, Cancel, Figures as StateFigures, Params, Phase, Primitive, Run, Sighting,
};
use crate::io::{self, FoundAs, Opened, OpenedResult, ReadError, Shape, ShapeGeometry, StoredPrimitives};
use crate::project::{self, OpenError};
use crate::session::camera::Camera;
use crate::session::paint::shown_points;
use crate::session::scene::{SceneFromInput, UpAxis};
use crate::session::view::View;
use crate::worker::LoadedShape;

/// Why there is nothing to take a picture of.
#[derive(Debug, thiserror::Error)]
pub enum SubjectError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Session(#[from] OpenError),
    #[error("the session contains no shape; open a shape in it and save it again")]
    EmptySession,
    #[error("{0} contains nothing to draw: no finite points, no faces and no primitives")]
    Nothing(String),
}

/// A shape with the primitives that stand for it, where there are any.
#[derive(Debug)]
pub struct Subject {
    pub(super) loaded: LoadedShape,
    /// Labels are of the samples; with none, they are not known.
    pub(super) state: Option<Abstraction>,
    pub(super) colors: Arc<Colors>,
    /// Ids of primitives that are not shown.
    pub(super) hidden: BTreeSet<u32>,
    /// How it was looked at, where the file tells.
    saved: Option<(View, Camera)>,
    notes: Vec<String>,
}

/// What a caption tells of a subject.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Figures {
    Result {
        primitives: usize,
        /// Mean distance of the assigned samples to their primitive, as a share
        /// of the shape's longest edge; `None` where the file does not tell.
        mean_distance: Option<f64>,
    },
    Mesh {
        faces: usize,
    },
    Cloud {
        points: usize,
    },
}

impl Subject {
    /// Reads a result (primitives as JSON, NPZ or CSV, or the folder that holds
    /// them), a session or a shape, as the content has it. Points get the labels
    /// of the segmented cloud beside the primitives; without one, each joins the
    /// nearest primitive, as where a result is opened in the window.
    ///
    /// # Errors
    /// Where it can't be read, and where there is nothing in it to see.
    pub fn read(path: &Path) -> Result<Self, SubjectError> {
        let subject = match io::open(path)? {
            Opened::Session(path) => Self::of_session(&path)?,
            Opened::Result(result) => Self::of_result(*result),
            Opened::Shape(shape) => Self::of_shape(*shape),
        };
        let has_primitives = subject.primitives().iter().any(|p| p.shape.is_valid());
        if subject.extent().is_empty() && !has_primitives {
            return Err(SubjectError::Nothing(path.display().to_string()));
        }
        Ok(subject)
    }

    fn of_session(path: &Path) -> Result<Self, SubjectError> {
        let project::Opened { workspace, notes } = project::open(path)?;
        let document = workspace.document;
        let loaded = document.loaded.ok_or(SubjectError::EmptySession)?;
        let timeline = &document.timeline;
        Ok(Self {
            loaded: LoadedShape {
                generation: loaded.generation,
                shape: Arc::clone(&loaded.shape),
                cloud: Arc::clone(&loaded.cloud),
                sampling: loaded.sampling,
            },
            state: timeline.shown().map(|snapshot| snapshot.abstraction.clone()),
            colors: timeline.current().map(|branch| Arc::clone(&branch.colors)).unwrap_or_default(),
            hidden: document.hidden,
            saved: Some((workspace.view, workspace.camera)),
            notes,
        })
    }

    fn of_shape(shape: Shape) -> Self {
        let cloud = match &shape.geometry {
            // A mesh is shown by its faces.
            ShapeGeometry::Mesh(_) => samples(Vec::new(), None),
            ShapeGeometry::Cloud(cloud) => SampleCloud::from_points(&cloud.points),
        };
        let notes = shape.notes.clone();
        Self::of(shape, cloud, None, notes)
    }

    fn of_result(result: OpenedResult) -> Self {
        let mut notes = result.stored.notes.clone();
        // What was mended in the input was told when the result was made.
        if result.found_as != FoundAs::Input {
            notes.extend(result.shape.notes.iter().cloned());
        }
        if result.found_as == FoundAs::Surfaces {
            // Points on the primitives would look like an input that fits.
            let nothing = Shape { geometry: ShapeGeometry::Mesh(TriMesh::default()), ..result.shape };
            let state = state_of(&result.stored, [].into());
            return Self::of(nothing, samples(Vec::new(), None), Some(state), notes);
        }
        if let Some(segmented) = &result.segmented {
            let (cloud, labels) = segmented.samples_of(&result.shape);
            let state = state_of(&result.stored, labels.into());
            return Self::of(result.shape, cloud, Some(state), notes);
        }
        match assigned(&result) {
            Ok((cloud, state)) => Self::of(result.shape, cloud, Some(state), notes),
            Err(why) => {
                notes.push(format!("points are shown without labels: {why}"));
                let plain = Self::of_shape(result.shape);
                Self { state: Some(state_of(&result.stored, [].into())), notes, ..plain }
            }
        }
    }

    fn of(shape: Shape, cloud: SampleCloud, state: Option<Abstraction>, notes: Vec<String>) -> Self {
        let sampling = SamplingOptions::default();
        let loaded = LoadedShape { generation: 1, shape: Arc::new(shape), cloud: Arc::new(cloud), sampling };
        Self { loaded, state, colors: Arc::default(), hidden: BTreeSet::new(), saved: None, notes }
    }

    /// What was skipped or mended on reading, one sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// How the window shows it: as it was left, for a session. Points that stand
    /// for the shape all alone are larger.
    pub fn view(&self) -> View {
        if let Some((view, _)) = self.saved {
            return view;
        }
        let mut view = View::default();
        if self.state.is_none() && matches!(self.loaded.shape.geometry, ShapeGeometry::Cloud(_)) {
            view.point_size = LONE_POINT;
        }
        view
    }

    /// Where the camera was left, where the file tells.
    pub fn camera(&self) -> Option<Camera> {
        self.saved.map(|(_, camera)| camera)
    }

    pub(super) fn primitives(&self) -> &[Primitive] {
        self.state.as_ref().map_or(&[], |state| &state.primitives)
    }

    /// Whether the file gives its points colours.
    pub fn has_input_colors(&self) -> bool {
        let is_cloud = matches!(self.loaded.shape.geometry, ShapeGeometry::Cloud(_));
        is_cloud && self.loaded.shape.attributes.colors.is_some()
    }

    /// Whether there are primitives with points of their own.
    pub fn has_labels(&self) -> bool {
        self.state.as_ref().is_some_and(|state| !state.labels.is_empty())
    }

    /// Whether there are primitives, and an input that their surfaces can be
    /// compared with.
    pub fn has_surfaces(&self) -> bool {
        let has_input = match &self.loaded.shape.geometry {
            ShapeGeometry::Mesh(mesh) => !mesh.faces.is_empty(),
            ShapeGeometry::Cloud(cloud) => !cloud.points.is_empty(),
        };
        has_input && !self.primitives().is_empty()
    }

    /// What there is to tell in numbers.
    pub fn figures(&self) -> Figures {
        match (&self.state, &self.loaded.shape.geometry) {
            (Some(state), _) => {
                let assigned: usize = state.primitives.iter().map(|p| p.points).sum();
                let sum: f64 = state.primitives.iter().map(|p| p.points as f64 * p.mean_distance).sum();
                let scale = self.scene(UpAxis::Y).scale();
                Figures::Result {
                    primitives: state.primitives.len(),
                    // Other programs' files tell of no points.
                    mean_distance: (assigned > 0 && sum > 0.0).then(|| sum / assigned as f64 * scale),
                }
            }
            (None, ShapeGeometry::Mesh(mesh)) => Figures::Mesh { faces: mesh.faces.len() },
            (None, ShapeGeometry::Cloud(cloud)) => Figures::Cloud { points: cloud.points.len() },
        }
    }

    /// From the input's units to what is drawn.
    pub(super) fn scene(&self, up: UpAxis) -> SceneFromInput {
        let extent = self.extent();
        if extent.is_empty() {
            return SceneFromInput::fit(&surfaces(self.primitives()), up);
        }
        SceneFromInput::fit(&extent, up)
    }

    /// The points that the scene is fitted to: the samples, as in the window;
    /// without any the corners of the mesh's faces.
    fn extent(&self) -> Vec<Point3<f64>> {
        let cloud = &self.loaded.cloud.points;
        match &self.loaded.shape.geometry {
            ShapeGeometry::Mesh(mesh) if cloud.is_empty() => corners(mesh).collect(),
            _ => cloud.clone(),
        }
    }

    /// All that is shown, in input units, as far as `view` has it.
    pub(super) fn content(&self, shows: [bool; 3]) -> Vec<Point3<f64>> {
        let [input, points, primitives] = shows;
        let mut content = Vec::new();
        if let (true, ShapeGeometry::Mesh(mesh)) = (input, &self.loaded.shape.geometry) {
            content.extend(corners(mesh));
        }
        if points {
            content.extend(shown_points(&self.loaded));
        }
        if primitives {
            let shown: Vec<Primitive> =
                self.primitives().iter().filter(|p| !self.hidden.contains(&p.id)).cloned().collect();
            content.extend(surfaces(&shown));
        }
        content.retain(|p| p.iter().all(|c| c.is_finite()));
        content
    }
}

/// Corners of a mesh's faces.
fn corners(mesh: &TriMesh) -> impl Iterator<Item = Point3<f64>> + '_ {
    let mut used = vec![false; mesh.vertices.len()];
    for &corner in mesh.faces.iter().flatten() {
        if let Some(used) = used.get_mut(corner as usize) {
            *used = true;
        }
    }
    let finite = |p: &Point3<f64>| p.iter().all(|c| c.is_finite());
    mesh.vertices.iter().zip(used).filter(move |(p, used)| *used && finite(p)).map(|(p, _)| *p)
}

/// Points of the primitives' surfaces.
fn surfaces(primitives: &[Primitive]) -> Vec<Point3<f64>> {
    let valid = primitives.iter().filter(|p| p.shape.is_valid());
    valid.flat_map(|p| surface_vertices(&p.shape, Resolution::SCREEN).map(|(vertex, _)| vertex)).collect()
}

/// Diameter of points with nothing between them, in logical pixels.
const LONE_POINT: f32 = 6.0;

fn samples(points: Vec<Point3<f64>>, sample_of_input: Option<Vec<u32>>) -> SampleCloud {
    SampleCloud { points, sample_of_input, part: SampledPart::Whole, viewpoints: Vec::new() }
}

/// Samples the shape as the run did, and lets each sample join the nearest
/// primitive.
fn assigned(result: &OpenedResult) -> Result<(SampleCloud, Abstraction), String> {
    let cloud = io::sample(&result.shape, &result.sampling).map_err(|e| e.to_string())?;
    let cancel = Cancel::default();
    // Only the sampler goes on from primitives.
    let params = Params { algorithm: Algorithm::Sampler, ..Params::default() };
    let mut run = Run::new(Arc::new(cloud.clone()), params, &cancel).map_err(|e| e.to_string())?;
    run.edit(&result.taken(Vec::new()), &cancel).map_err(|e| e.to_string())?;
    Ok((cloud, state_of(&result.stored, run.abstraction().labels)))
}

/// The primitives of a file, as they are in it.
fn state_of(stored: &StoredPrimitives, labels: Arc<[u32]>) -> Abstraction {
    Abstraction {
        phase: Phase::Finished,
        iteration: 0,
        labels,
        pinned: [].into(),
        primitives: stored.primitives.clone().into(),
        figures: StateFigures::default(),
        sighting: Sighting::default(),
    }
}
