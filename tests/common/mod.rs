//! What several test files share.
#![allow(dead_code)] // Each test file uses its part.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // A failure fails the test; a skip is said.

use std::path::{Path, PathBuf};

use nalgebra::Point3;
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
        ShapeGeometry::Cloud(cloud) => (cloud.points, cloud.colors),
        ShapeGeometry::Mesh(_) => panic!("{} is a mesh", shape.name),
    }
}

/// The folder of test shapes, which lies beside the repository; `None`, said
/// aloud, where it is missing.
pub(crate) fn shared_data() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: {} is missing, which holds the test shapes", folder.display());
    None
}
