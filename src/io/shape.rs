//! A shape as it was read: a mesh or a cloud, with what its file says of its points.

use std::fmt;
use std::path::PathBuf;

use nalgebra::Point3;

use crate::geometry::brief::Brief;
use crate::geometry::metrics::{MetricOptions, Reference, ReferenceError};
use crate::geometry::outside::FilledOutside;
use crate::geometry::{SampleCloud, SamplingError, SamplingOptions, TriMesh, sample_cloud, sample_mesh};

/// A shape as it was read, in the file's units and order.
#[derive(Debug, Clone)]
pub struct Shape {
    /// For people: the file name without folder, or the built-in shape's name.
    pub name: String,
    pub path: Option<PathBuf>,
    /// `None` where it was made and not read.
    pub content: Option<Content>,
    pub geometry: ShapeGeometry,
    /// What the file says of the points of the cloud, or of the vertices of the mesh.
    pub attributes: Attributes,
    /// The places that it was seen from, where the file or a person says so.
    pub viewpoints: Vec<Point3<f64>>,
    /// What was skipped or mended on reading, one sentence each.
    pub notes: Vec<String>,
}

/// What a shape was read from: by this it is known again, whatever it is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// The shape that is part of the program.
    BuiltIn,
    /// A file of so many bytes with this CRC-32.
    File { bytes: u64, crc32: u32 },
}

impl Content {
    pub(super) fn of(bytes: &[u8]) -> Self {
        Self::File { bytes: bytes.len() as u64, crc32: crc32fast::hash(bytes) }
    }
}

#[derive(Debug, Clone)]
pub enum ShapeGeometry {
    Mesh(TriMesh),
    Cloud(PointCloud),
}

/// A cloud as it was read: every point, in file order, also those that are
/// not finite (they get no label).
#[derive(Clone, Default)]
pub struct PointCloud {
    pub points: Vec<Point3<f64>>,
}

impl fmt::Debug for PointCloud {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PointCloud").field("points", &Brief::of_points(&self.points)).finish()
    }
}

/// Attributes of the points in a file; each has one entry per point of the cloud
/// or vertex of the mesh, in order.
#[derive(Clone, Default, PartialEq)]
pub struct Attributes {
    /// Red, green and blue.
    pub colors: Option<Vec<[u8; 3]>>,
    /// As they are in the file: not of unit length, and zero or not finite
    /// where it has them so.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Labels that somebody gave: a class, or a part.
    pub labels: Option<Vec<i64>>,
}

impl fmt::Debug for Attributes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let normals = self.normals.as_ref().map(|all| Brief::of(all.iter().map(|n| n.map(f32::to_bits))));
        f.debug_struct("Attributes")
            .field("colors", &self.colors.as_ref().map(Brief::of))
            .field("normals", &normals)
            .field("labels", &self.labels.as_ref().map(Brief::of))
            .finish()
    }
}

impl Attributes {
    /// Those of some of the points, in the order of `kept`.
    ///
    /// # Panics
    /// Where an index is out of range.
    pub fn of(&self, kept: &[u32]) -> Self {
        fn pick<T: Copy>(all: Option<&Vec<T>>, kept: &[u32]) -> Option<Vec<T>> {
            all.map(|all| kept.iter().map(|&i| all[i as usize]).collect())
        }
        Self {
            colors: pick(self.colors.as_ref(), kept),
            normals: pick(self.normals.as_ref(), kept),
            labels: pick(self.labels.as_ref(), kept),
        }
    }

    /// Whether there is one entry a point, of those that there are.
    pub fn fit(&self, points: usize) -> bool {
        let lengths = [
            self.colors.as_ref().map(Vec::len),
            self.normals.as_ref().map(Vec::len),
            self.labels.as_ref().map(Vec::len),
        ];
        lengths.into_iter().flatten().all(|length| length == points)
    }
}

/// Samples a shape evenly to N points; see [`sample_mesh`] and
/// [`sample_cloud`].
///
/// # Errors
/// Where the shape has no area (mesh) or no finite point (cloud).
pub fn sample(shape: &Shape, options: &SamplingOptions) -> Result<SampleCloud, SamplingError> {
    let cloud = match &shape.geometry {
        ShapeGeometry::Mesh(mesh) => sample_mesh(mesh, options)?,
        ShapeGeometry::Cloud(cloud) => sample_cloud(&cloud.points, options)?,
    };
    Ok(SampleCloud { viewpoints: shape.viewpoints.clone(), ..cloud })
}

/// Prepares a shape as the reference that abstractions are measured against;
/// see [`crate::geometry::metrics`]. Of a mesh the inside with its hollows filled
/// is measured, too; see [`FilledOutside`].
///
/// # Errors
/// Where the shape has no area (mesh) or no two distinct points (cloud).
pub fn reference(shape: &Shape, options: &MetricOptions) -> Result<Reference, ReferenceError> {
    match &shape.geometry {
        ShapeGeometry::Mesh(mesh) => {
            let filled = FilledOutside::new(mesh);
            Ok(Reference::of_mesh(mesh, options)?.with_filled(|p| filled.contains(p)))
        }
        ShapeGeometry::Cloud(cloud) => Reference::of_cloud(&cloud.points, options),
    }
}
