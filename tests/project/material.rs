//! Sessions for tests: real states of short runs, put together at will.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use nalgebra::Point3;
use superform::geometry::palette::Colors;
use superform::geometry::{SamplingOptions, TriMesh};
use superform::inference::{Algorithm, Cancel, Params, Run};
use superform::io::{self, Attributes, PointCloud, Shape, ShapeGeometry};
use superform::project;
use superform::session::camera::Camera;
use superform::session::document::Document;
use superform::session::timeline::{Branch, Origin, Timeline};
use superform::session::undo::{Step, Undo};
use superform::session::view::{Layer, View};
use superform::session::workspace::Workspace;
use superform::worker::{Cause, LoadedShape, Pace, Snapshot};

/// A shape with its samples and the states of a run on them.
#[derive(Debug, Clone)]
pub(crate) struct Material {
    pub(crate) loaded: Arc<LoadedShape>,
    pub(crate) states: Vec<Arc<Snapshot>>,
}

/// A box that is longer than wide, as a mesh.
fn mesh() -> ShapeGeometry {
    let vertices = (0..8)
        .map(|i| Point3::new(f64::from(i & 1) * 3.0, f64::from(i >> 1 & 1), f64::from(i >> 2) / 3.0))
        .collect();
    let faces = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4], //
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    ShapeGeometry::Mesh(TriMesh { vertices, faces: faces.to_vec() })
}

/// Points on a cylinder and one that is not finite, with colours, normals and labels.
fn cloud() -> (ShapeGeometry, Attributes) {
    let mut points: Vec<Point3<f64>> = (0..260)
        .map(|i| {
            let (turn, height) = (f64::from(i % 20), f64::from(i / 20));
            let angle = turn * std::f64::consts::TAU / 20.0;
            Point3::new(angle.cos(), angle.sin(), height * 0.3)
        })
        .collect();
    points.push(Point3::new(f64::NAN, 0.0, 1.0));
    let colors = (0..points.len()).map(|i| [i as u8, 7, 255 - i as u8]).collect();
    let normals = (0..points.len()).map(|i| [0.5, -1.0, i as f32]).collect();
    let labels = (0..points.len()).map(|i| i as i64 - 3).collect();
    let attributes = Attributes { colors: Some(colors), normals: Some(normals), labels: Some(labels) };
    (ShapeGeometry::Cloud(PointCloud { points }), attributes)
}

impl Material {
    /// A run of the algorithm, made as far as it goes or `most` states.
    pub(crate) fn new(generation: u64, is_mesh: bool, algorithm: Algorithm, most: usize) -> Self {
        let (geometry, attributes) = if is_mesh { (mesh(), Attributes::default()) } else { cloud() };
        let shape = Shape {
            name: if is_mesh { "box.obj".to_owned() } else { "pipe.xyz".to_owned() },
            path: is_mesh.then(|| "shapes/box.obj".into()),
            content: None,
            geometry,
            attributes,
            viewpoints: vec![Point3::new(0.0, -3.0, f64::from(u8::from(is_mesh)))],
            notes: vec!["left out 1 face without an area".to_owned()],
        };
        let sampling = SamplingOptions { points: 200, seed: generation, ..SamplingOptions::default() };
        let cloud = Arc::new(io::sample(&shape, &sampling).unwrap());
        let params = Params { algorithm, iterations: 4, clusters: 3, ..Params::default() };
        let cancel = Cancel::default();
        let mut run = Run::new(Arc::clone(&cloud), params, &cancel).unwrap();
        let loaded = Arc::new(LoadedShape { generation, shape: Arc::new(shape), cloud, sampling });
        let mut states = Vec::new();
        let mut occurrences = Vec::new();
        for number in 0..most {
            states.push(Arc::new(Snapshot {
                key: Snapshot::new_key(),
                generation,
                run: 1,
                abstraction: run.abstraction(),
                checkpoint: Arc::new(run.checkpoint()),
                cause: if number == 0 { Cause::Start } else { Cause::Step },
                params,
                start: params,
                occurrences: std::mem::take(&mut occurrences),
                elapsed: Duration::from_micros(1234 * number as u64),
            }));
            if run.is_finished() {
                break;
            }
            occurrences = run.step(&cancel).unwrap();
        }
        Self { loaded, states }
    }

    /// A document that shows the last of the first `count` states.
    pub(crate) fn document(&self, count: usize) -> Document {
        self.branched(&[count])
    }

    /// A document with a branch of so many states for each number; the last is
    /// shown.
    pub(crate) fn branched(&self, counts: &[usize]) -> Document {
        let branch = |(id, &count): (u32, &usize)| Branch {
            id,
            name: format!("Branch “{id}”"),
            origin: (id > 0).then(|| Origin { branch: id - 1, index: 0 }),
            loaded: Arc::clone(&self.loaded),
            states: self.states[..count.clamp(1, self.states.len())].to_vec(),
            colors: Arc::new(Colors::new(BTreeMap::from([(id, 7)]), 0..3)),
        };
        let branches: Vec<Branch> = (0..).zip(counts).map(branch).collect();
        let current = branches.len() - 1;
        let shown = branches[current].states.len() - 1;
        let primitives = &branches[current].states[shown].abstraction.primitives;
        Document {
            loaded: Some(Arc::clone(&self.loaded)),
            params: Params { alpha: 0.75, ..self.states[0].params },
            sampling: self.loaded.sampling,
            selection: primitives.iter().map(|p| p.id).take(1).collect(),
            selected_points: [1, 5, 8].into(),
            hidden: primitives.iter().map(|p| p.id).skip(1).collect(),
            timeline: Timeline::from_parts(branches, current, shown, counts.len() as u32).unwrap(),
        }
    }
}

/// Nothing loaded yet.
pub(crate) fn empty_document() -> Document {
    Document {
        loaded: None,
        params: Params::default(),
        sampling: SamplingOptions::default(),
        timeline: Timeline::default(),
        selection: [].into(),
        selected_points: [].into(),
        hidden: [].into(),
    }
}

/// A session with that document, and these to go back and forth to.
pub(crate) fn workspace(document: Document, done: &[Document], undone: &[Document]) -> Workspace {
    let steps = |what: &str, documents: &[Document]| -> Vec<Arc<Step>> {
        let label = |i: usize| format!("{what} {i}");
        documents
            .iter()
            .enumerate()
            .map(|(i, d)| Arc::new(Step { label: label(i), document: d.clone() }))
            .collect()
    };
    let mut view = View::default();
    view.point_size = 5.25;
    view.set_layer(Layer::Grid, false);
    Workspace {
        document,
        undo: Undo::from_parts(steps("done", done), steps("undone", undone)),
        pace: Pace::PerSecond(25),
        is_live: false,
        view,
        camera: Camera {
            target: Point3::new(0.1, -0.2, 0.3),
            yaw: 1.0 / 3.0,
            distance: 3.5,
            ..Camera::default()
        },
    }
}

/// What makes a session, as bytes: of two that are the same they are, too.
pub(crate) fn bytes(workspace: &Workspace) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("same.superform");
    project::save(&path, workspace).unwrap();
    std::fs::read(path).unwrap()
}

fn assert_same_state(a: &Snapshot, b: &Snapshot) {
    assert_eq!(a.abstraction, b.abstraction);
    assert_eq!(a.checkpoint, b.checkpoint);
    assert_eq!((a.run, a.cause, a.params, a.start), (b.run, b.cause, b.params, b.start));
    assert_eq!((&a.occurrences, a.elapsed), (&b.occurrences, b.elapsed));
}

fn assert_same_shape(a: &LoadedShape, b: &LoadedShape) {
    assert_eq!((a.sampling, &a.shape.name, &a.shape.path), (b.sampling, &b.shape.name, &b.shape.path));
    assert_eq!(a.cloud, b.cloud);
    assert_eq!(a.shape.notes, b.shape.notes);
    assert_eq!(a.shape.attributes, b.shape.attributes);
    match (&a.shape.geometry, &b.shape.geometry) {
        (ShapeGeometry::Mesh(a), ShapeGeometry::Mesh(b)) => assert_eq!(a, b),
        (ShapeGeometry::Cloud(a), ShapeGeometry::Cloud(b)) => {
            let bits = |cloud: &PointCloud| -> Vec<u64> {
                cloud.points.iter().flat_map(|p| p.iter().map(|c| c.to_bits()).collect::<Vec<_>>()).collect()
            };
            assert_eq!(bits(a), bits(b));
        }
        _ => panic!("a mesh became a cloud, or the other way round"),
    }
}

pub(crate) fn assert_same_document(a: &Document, b: &Document) {
    assert_eq!(a.loaded.is_some(), b.loaded.is_some());
    if let (Some(a), Some(b)) = (&a.loaded, &b.loaded) {
        assert_same_shape(a, b);
    }
    assert_eq!((a.params, a.sampling), (b.params, b.sampling));
    assert_eq!((&a.selection, &a.selected_points, &a.hidden), (&b.selection, &b.selected_points, &b.hidden));
    let (a, b) = (&a.timeline, &b.timeline);
    assert_eq!(
        (a.current_index(), a.shown_index(), a.count()),
        (b.current_index(), b.shown_index(), b.count())
    );
    assert_eq!(a.branches().len(), b.branches().len());
    for (a, b) in a.branches().iter().zip(b.branches()) {
        assert_eq!((a.id, &a.name, a.origin, &a.colors), (b.id, &b.name, b.origin, &b.colors));
        assert_same_shape(&a.loaded, &b.loaded);
        assert_eq!(a.states.len(), b.states.len());
        a.states.iter().zip(&b.states).for_each(|(a, b)| assert_same_state(a, b));
    }
}

pub(crate) fn assert_same(a: &Workspace, b: &Workspace) {
    assert_same_document(&a.document, &b.document);
    for (a, b) in [(a.undo.done(), b.undo.done()), (a.undo.undone(), b.undo.undone())] {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert_eq!(a.label, b.label);
            assert_same_document(&a.document, &b.document);
        }
    }
    assert_eq!((a.pace, a.is_live, a.view, a.camera), (b.pace, b.is_live, b.view, b.camera));
}
