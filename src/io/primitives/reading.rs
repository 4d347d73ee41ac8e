//! Primitives from a file, whose format its content tells.

use std::path::Path;

use super::stored::StoredPrimitives;
use super::{csv, json, npz};
use crate::io::content::content;
use crate::io::error::{Fault, ReadError};
use crate::io::names::{PRIMITIVES_FILE, PRIMITIVES_FILES};
use crate::io::read::text;

/// Reads the primitives of a run, by the name of the file or of the folder that
/// holds it: `primitives.json`, NPZ or CSV, told from the content. Of a file
/// with several shapes the first is taken, with a note.
///
/// # Errors
/// Where there is no such file, it is in none of these formats, a field is
/// missing or of the wrong kind, or a primitive is none: an exponent or a
/// semi-axis not above 0, a matrix that is no rotation, a taper beyond [−1, 1],
/// an id or more points than there are used twice.
pub fn read_primitives(path: &Path) -> Result<StoredPrimitives, ReadError> {
    read_primitives_of(path, None)
}

/// As [`read_primitives`], the shape at place `shape` (from 0) of a file with
/// several.
///
/// # Errors
/// The same, and where there are not so many shapes.
pub fn read_primitives_of(path: &Path, shape: Option<usize>) -> Result<StoredPrimitives, ReadError> {
    let path = if path.is_dir() {
        let found = PRIMITIVES_FILES.iter().map(|name| path.join(name)).find(|file| file.exists());
        found.unwrap_or_else(|| path.join(PRIMITIVES_FILE))
    } else {
        path.to_owned()
    };
    let bytes = content(&path)?;
    parse_primitives(&bytes, &path, shape)
}

/// As [`read_primitives_of`], from the content of a file or a text that was
/// pasted; `origin` is what messages call it.
///
/// # Errors
/// The same.
pub fn parse_primitives(
    bytes: &[u8],
    origin: &Path,
    shape: Option<usize>,
) -> Result<StoredPrimitives, ReadError> {
    let parsed = if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        npz::parse(bytes, shape)
    } else {
        let text = text::decode(bytes);
        let one =
            if text.trim_start().starts_with(['{', '[']) { json::parse(&text) } else { csv::parse(&text) };
        one.and_then(|stored| match shape {
            None | Some(0) => Ok(stored),
            Some(n) => Err(Fault::whole(format!("it contains only one shape, so index {n} does not exist"))),
        })
    };
    parsed.and_then(|stored| stored.checked(origin)).map_err(|fault| fault.in_file(origin.to_owned()))
}
