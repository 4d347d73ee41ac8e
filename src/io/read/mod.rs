//! Reading: shapes from the files that people have, and primitives back.

mod detect;
mod gltf;
mod obj;
mod off;
mod ply;
pub(super) mod primitives;
mod raw;
mod results;
mod stl;
mod text;
mod xyz;

use std::io::Read;
use std::path::{Path, PathBuf};

use super::{ReadError, Shape};
pub(crate) use gltf::percent_decoded;
pub use results::{holds_primitives, shape_of};

/// Largest file that is read, in bytes.
const LARGEST: u64 = 8 << 30;

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
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let shape = parsed.and_then(|raw| raw.checked(name)).map_err(|fault| fault.in_file(path.to_owned()))?;
    Ok(Shape { path: Some(path.to_owned()), ..shape })
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
        .map_err(|fault| fault.in_file(PathBuf::from("the built-in chair")))
}
