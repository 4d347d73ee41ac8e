//! A shape from its file: the format is told, and its reader called.

use std::path::{Path, PathBuf};

use super::detect::{self, Format};
use super::{gltf, las, npy, obj, off, pcd, ply, stl, text, xyz};
use crate::io::content::content;
use crate::io::error::ReadError;
use crate::io::shape::{Content, Shape};
use crate::io::wording::harmless;

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

/// Endings of the names of all files that can be read.
pub const SHAPE_ENDINGS: &[&str] = &detect::ENDINGS;

/// Whether a file's name ends as that of a shape that can be read.
pub fn has_shape_ending(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| detect::ENDINGS.contains(&e.to_string_lossy().to_ascii_lowercase().as_str()))
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
