//! Triangle meshes.

use nalgebra::Point3;

/// A triangle mesh in input units. Faces index `vertices`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriMesh {
    pub vertices: Vec<Point3<f64>>,
    pub faces: Vec<[u32; 3]>,
}
