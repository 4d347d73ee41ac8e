//! Reading shapes and writing results. Kind is told from content; errors say
//! what, where and what to do; files are written whole or not at all.

use std::path::PathBuf;

use nalgebra::Point3;

use crate::geometry::TriMesh;

/// A shape as it was read, in the file's units and order.
#[derive(Debug, Clone)]
pub struct Shape {
    /// For people: the file name without folder, or the built-in shape's name.
    pub name: String,
    pub path: Option<PathBuf>,
    pub geometry: ShapeGeometry,
    /// What was skipped or mended on reading, one sentence each.
    pub notes: Vec<String>,
}

#[derive(Debug, Clone)]
pub enum ShapeGeometry {
    Mesh(TriMesh),
    Cloud(PointCloud),
}

/// A cloud as it was read: every point, in file order, also those that are
/// not finite (they get no label).
#[derive(Debug, Clone, Default)]
pub struct PointCloud {
    pub points: Vec<Point3<f64>>,
    /// Input colours, one a point, where the file has them.
    pub colors: Option<Vec<[u8; 3]>>,
}
