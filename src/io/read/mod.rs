//! Reads shapes from common file formats, and primitives from result files.

mod columns;
mod detect;
mod gltf;
mod las;
mod npy;
mod obj;
mod off;
mod pcd;
mod ply;
mod polygon;
pub(super) mod primitives;
mod raw;
mod results;
mod scalar;
mod stl;
mod text;
mod xyz;

use std::io::Read;
use std::path::{Path, PathBuf};

use super::{Content, ReadError, Shape, harmless};
use detect::Format;

pub use gltf::buffers_beside;
pub(crate) use gltf::percent_bytes;
pub(super) use results::places_of_shape;
pub use results::{FoundAs, LabelledPoints, OpenedResult, holds_primitives, open_result};

/// Largest file that is read, in bytes.
const LARGEST: u64 = 8 << 30;

/// Maximum decompressed size for this compressed size: clouds compress to about a tenth; anything below a hundredth is not a cloud.
fn most_unpacked(packed: usize) -> u64 {
    (16 << 20) + 100 * packed as u64
}

/// Reads a shape from an OBJ, PLY, STL, OFF, glTF, GLB, PCD, LAS, LAZ, NPY, NPZ
/// or XYZ text file. The format is told from the content first and the name's
/// ending second; a file with faces is a mesh, one without a cloud. Faces that
/// are out of range, not finite or without area are left out and noted in
/// [`Shape::notes`].
///
/// # Errors
/// One [`ReadError`] that says what is wrong, where, and what to do. Memory
/// stays within a small multiple of the file's size, whatever the file claims.
/// A glTF scene may ask for more, by its copies of meshes, and compressed
/// points (LAZ, NPZ) may unpack to a hundred times their size, within limits.
pub fn read(path: &Path) -> Result<Shape, ReadError> {
    let bytes = content(path)?;
    let shape = parsed(&bytes, path, Some(path.parent().unwrap_or(Path::new(""))))?;
    Ok(Shape { path: Some(path.to_owned()), content: Some(Content::of(&bytes)), ..shape })
}

/// Reads a shape from the content of a file that has this name; see [`read`].
/// Buffers of a glTF scene must be inside.
///
/// # Errors
/// As [`read`], with the name in the place of the path.
pub fn read_bytes(bytes: &[u8], name: &str) -> Result<Shape, ReadError> {
    let path = Path::new(name);
    if bytes.is_empty() {
        return Err(ReadError::Empty { path: path.to_owned() });
    }
    parsed(bytes, path, None)
}

/// Reads a content in the format of an ending, whatever it looks like: so each
/// reader can be tested alone. `None` for other endings.
#[doc(hidden)]
pub fn read_bytes_as(bytes: &[u8], ending: &str) -> Option<Result<Shape, ReadError>> {
    let format = Format::of_ending(ending)?;
    Some(shape(format, bytes, Path::new("it"), None))
}

fn parsed(bytes: &[u8], path: &Path, folder: Option<&Path>) -> Result<Shape, ReadError> {
    shape(detect::format(bytes, path)?, bytes, path, folder)
}

fn shape(format: Format, bytes: &[u8], path: &Path, folder: Option<&Path>) -> Result<Shape, ReadError> {
    let parsed = match format {
        Format::Obj => obj::parse(&text::decode(bytes)),
        Format::Ply => ply::parse(bytes),
        Format::Stl => stl::parse(bytes),
        Format::Off => off::parse(&text::decode(bytes)),
        Format::Gltf => gltf::parse(bytes, folder),
        Format::Pcd => pcd::parse(bytes),
        Format::Las => las::parse(bytes),
        Format::Npy => npy::parse(bytes),
        Format::Npz => npy::parse_archive(bytes),
        Format::Xyz => xyz::parse(&text::decode(bytes)),
    };
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let name = harmless(&name).into_owned();
    parsed.and_then(|raw| raw.checked(name)).map_err(|fault| fault.in_file(path.to_owned()))
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
    const CHAIR: &str = include_str!("../../../assets/chair.obj");
    obj::parse(CHAIR)
        .and_then(|raw| raw.checked("built-in chair".to_owned()))
        .map(|shape| Shape { content: Some(Content::BuiltIn), ..shape })
        .map_err(|fault| fault.in_file(PathBuf::from("the built-in chair")))
}
