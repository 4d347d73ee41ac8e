//! What several test files share.
#![allow(dead_code)] // Each test file uses its part.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Point3;
use superform::geometry::metrics::{MetricOptions, Reference, evaluate};
use superform::geometry::tessellate::{Resolution, tessellate};
use superform::geometry::{SampleCloud, Superquadric, TriMesh};
use superform::inference::{Abstraction, Cancel, Params, Sampler};
use superform::io::{self, ReadError, Shape, ShapeGeometry};
use tempfile::TempDir;

/// Reads a file with this name and content.
pub(crate) fn read_as(name: &str, content: impl AsRef<[u8]>) -> Result<Shape, ReadError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    io::read(&path)
}

/// Vertices and faces of a shape that must be a mesh.
pub(crate) fn mesh(shape: Shape) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    match shape.geometry {
        ShapeGeometry::Mesh(mesh) => (mesh.vertices, mesh.faces),
        ShapeGeometry::Cloud(_) => panic!("{} is a cloud", shape.name),
    }
}

/// Points and colours of a shape that must be a cloud.
pub(crate) fn cloud(shape: Shape) -> (Vec<Point3<f64>>, Option<Vec<[u8; 3]>>) {
    match shape.geometry {
        ShapeGeometry::Cloud(cloud) => (cloud.points, shape.attributes.colors),
        ShapeGeometry::Mesh(_) => panic!("{} is a mesh", shape.name),
    }
}

/// The folder of test shapes, which lies beside the repository. Tests that use
/// it are ignored where it was missing when they were compiled; see `build.rs`.
pub(crate) fn shared_data() -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    assert!(folder.is_dir(), "{} is missing, which holds the test shapes", folder.display());
    folder
}

/// The state at the end of a run.
pub(crate) fn finished(cloud: &Arc<SampleCloud>, params: Params) -> Abstraction {
    let cancel = Cancel::default();
    let mut sampler = Sampler::new(Arc::clone(cloud), params, &cancel).unwrap();
    while !sampler.is_finished() {
        sampler.step(&cancel).unwrap();
    }
    sampler.abstraction()
}

/// The same, on a cloud taken as it is.
pub(crate) fn abstracted(points: &[Point3<f64>], params: Params) -> Abstraction {
    finished(&Arc::new(SampleCloud::from_points(points)), params)
}

/// The surfaces of primitives as one mesh.
pub(crate) fn union_mesh(shapes: &[Superquadric]) -> TriMesh {
    let mut mesh = TriMesh::default();
    for shape in shapes {
        let surface = tessellate(shape, Resolution::default());
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(surface.vertices);
        mesh.faces.extend(surface.faces.iter().map(|f| f.map(|i| i + first)));
    }
    mesh
}

/// How far two abstractions are from each other: the larger of the mean
/// distances of the surface of either to the other, in units of its longest
/// edge.
pub(crate) fn apart(a: &[Superquadric], b: &[Superquadric]) -> f64 {
    let one_way = |from: &[Superquadric], to: &[Superquadric]| {
        let options = MetricOptions { samples: 20_000, volume_points: 1000, seed: 1 };
        let reference = Reference::of_mesh(&union_mesh(to), &options).unwrap();
        evaluate(from, None, &reference).accuracy.unwrap()
    };
    one_way(a, b).max(one_way(b, a))
}
