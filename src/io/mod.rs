//! Reading shapes and writing results. Kind is told from content; errors say
//! what, where and what to do; files are written whole or not at all.

mod error;
mod read;
mod wording;
mod write;

use std::path::PathBuf;

use nalgebra::Point3;

use crate::geometry::metrics::{MetricOptions, Reference, ReferenceError};
use crate::geometry::outside::FilledOutside;
use crate::geometry::{SampleCloud, SamplingError, SamplingOptions, TriMesh, sample_cloud, sample_mesh};

pub use error::{Place, ReadError, WriteError};
pub(crate) use read::percent_decoded;
pub use read::primitives::{StoredPrimitives, parse_primitives, read_primitives, read_primitives_of};
#[doc(hidden)]
pub use read::read_bytes_as;
pub use read::{
    SESSION_ENDING, SHAPE_ENDINGS, built_in, has_session_ending, has_shape_ending, holds_primitives, read,
    read_bytes, shape_of,
};
pub use wording::{cause, harmless, on_reading, on_writing};
pub use write::{
    AnimationFormat, AnimationWriter, Choice, ExportOptions, Exported, Format, Kind, LARGEST_GIF, Outcome,
    PRIMITIVES_FILE, PhaseTimes, PrimitiveSet, REPORT_FILE, RunRecord, SEGMENTED_FILE, estimated_size,
    export, export_all, export_primitives, primitives_text, write_picture, write_primitives_json,
    write_report_json, write_run, write_segmented_ply, write_streamed, write_whole,
};

/// A shape as it was read, in the file's units and order.
#[derive(Debug, Clone)]
pub struct Shape {
    /// For people: the file name without folder, or the built-in shape's name.
    pub name: String,
    pub path: Option<PathBuf>,
    pub geometry: ShapeGeometry,
    /// What the file says of the points of the cloud, or of the vertices of the mesh.
    pub attributes: Attributes,
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
}

/// What a file says of its points beside their places; each has one entry a
/// point of the cloud or a vertex of the mesh, in its order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Attributes {
    /// Red, green and blue.
    pub colors: Option<Vec<[u8; 3]>>,
    /// As they are in the file: not of unit length, and zero or not finite
    /// where it has them so.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Labels that somebody gave: a class, or a part.
    pub labels: Option<Vec<i64>>,
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
    match &shape.geometry {
        ShapeGeometry::Mesh(mesh) => sample_mesh(mesh, options),
        ShapeGeometry::Cloud(cloud) => sample_cloud(&cloud.points, options),
    }
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
