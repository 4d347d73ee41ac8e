//! Reading shapes and writing results. Kind is told from content; errors say
//! what, where and what to do; files are written whole or not at all.

mod animation;
mod detect;
mod error;
mod gltf;
mod obj;
mod off;
mod ply;
mod primitives;
mod raw;
mod stl;
mod text;
mod write;
mod xyz;

use std::io::Read;
use std::path::{Path, PathBuf};

use nalgebra::Point3;

use crate::geometry::metrics::{MetricOptions, Reference, ReferenceError};
use crate::geometry::outside::FilledOutside;
use crate::geometry::{SampleCloud, SamplingError, SamplingOptions, TriMesh, sample_cloud, sample_mesh};

pub use animation::{AnimationFormat, AnimationWriter, LARGEST_GIF};
pub use error::{Place, ReadError, WriteError};
pub use primitives::{StoredPrimitives, read_primitives};
pub use write::{
    Outcome, PRIMITIVES_FILE, PhaseTimes, REPORT_FILE, RunRecord, SEGMENTED_FILE, write_picture,
    write_primitives_json, write_report_json, write_run, write_segmented_ply, write_streamed, write_whole,
};

/// Largest file that is read, in bytes.
const LARGEST: u64 = 8 << 30;

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

/// Reads a shape from an OBJ, PLY, STL, OFF, glTF, GLB or XYZ text file. The
/// format is told from the content first and the name's ending second; a file
/// with faces is a mesh, one without a cloud. Faces that are out of range, not finite or
/// without area are left out and noted in [`Shape::notes`].
///
/// # Errors
/// One [`ReadError`] that says what is wrong, where, and what to do. Memory
/// stays within a small multiple of the file's size, whatever the file claims;
/// only a glTF scene may ask for more, by its copies of meshes, within limits.
pub fn read(path: &Path) -> Result<Shape, ReadError> {
    let bytes = content(path)?;
    let format = detect::format(&bytes, path)?;
    let parsed = match format {
        detect::Format::Obj => obj::parse(&text::decode(&bytes)),
        detect::Format::Ply => ply::parse(&bytes),
        detect::Format::Stl => stl::parse(&bytes),
        detect::Format::Off => off::parse(&text::decode(&bytes)),
        detect::Format::Gltf => gltf::parse(&bytes, path.parent().unwrap_or(Path::new(""))),
        detect::Format::Xyz => xyz::parse(&text::decode(&bytes)),
    };
    let (geometry, notes) =
        parsed.and_then(raw::Raw::checked).map_err(|fault| fault.in_file(path.to_owned()))?;
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    Ok(Shape { name, path: Some(path.to_owned()), geometry, notes })
}

/// The bytes of a regular file that is neither empty nor too large.
fn content(path: &Path) -> Result<Vec<u8>, ReadError> {
    let open = |reason| ReadError::Open { path: path.to_owned(), reason };
    let about = std::fs::metadata(path).map_err(open)?;
    if !about.is_file() {
        return Err(ReadError::NotAFile { path: path.to_owned() });
    }
    if about.len() > LARGEST {
        return Err(ReadError::TooLarge { path: path.to_owned(), bytes: about.len(), limit: LARGEST });
    }
    let mut bytes = Vec::with_capacity(about.len() as usize);
    std::fs::File::open(path).and_then(|file| file.take(LARGEST).read_to_end(&mut bytes)).map_err(open)?;
    if bytes.is_empty() {
        return Err(ReadError::Empty { path: path.to_owned() });
    }
    Ok(bytes)
}

/// Endings of the names of all files that can be read.
pub const SHAPE_ENDINGS: &[&str] = &detect::ENDINGS;

/// Whether a file's name ends as that of a shape that can be read.
pub fn has_shape_ending(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| detect::ENDINGS.contains(&e.to_string_lossy().to_ascii_lowercase().as_str()))
}

/// Ending of the names of session files.
pub const SESSION_ENDING: &str = "superform";

/// Whether a file's name ends as that of a session.
pub fn has_session_ending(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(SESSION_ENDING))
}

/// The shape that is built into the program: a chair (CC0, see
/// `assets/README.md`).
///
/// # Errors
/// None in practice: the asset is part of the program and tested.
pub fn built_in() -> Result<Shape, ReadError> {
    const CHAIR: &str = include_str!("../../assets/chair.obj");
    let (geometry, notes) = obj::parse(CHAIR)
        .and_then(raw::Raw::checked)
        .map_err(|fault| fault.in_file(PathBuf::from("the built-in chair")))?;
    Ok(Shape { name: "built-in chair".to_owned(), path: None, geometry, notes })
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
