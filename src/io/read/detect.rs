//! Tells a file's format, from its content first and its name second.

use std::path::Path;

use super::{gltf, off, stl, text, xyz};
use crate::io::error::ReadError;

/// Formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Obj,
    Ply,
    Stl,
    Off,
    Gltf,
    Xyz,
}

/// How much of the file is looked at.
const HEAD: usize = 64 << 10;

/// First words of OBJ lines.
const OBJ_KEYWORDS: [&str; 12] = ["v", "vn", "vt", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl"];
/// Endings of the names of all files that can be read.
pub(super) const ENDINGS: [&str; 14] =
    ["obj", "ply", "stl", "off", "coff", "gltf", "glb", "xyz", "txt", "csv", "pts", "asc", "xyzrgb", "xyzn"];
const XYZ_ENDINGS: [&str; 7] = ["xyz", "txt", "csv", "pts", "asc", "xyzrgb", "xyzn"];

/// The format of a file that is not empty.
pub(super) fn format(bytes: &[u8], path: &Path) -> Result<Format, ReadError> {
    let head = &bytes[..bytes.len().min(HEAD)];
    if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") {
        return Ok(Format::Ply);
    }
    if head.starts_with(b"glTF") {
        return Ok(Format::Gltf);
    }
    if head.starts_with(b"\x89Superform") {
        return Err(ReadError::Session { path: path.to_owned() });
    }
    let unsupported = |what| Err(ReadError::Unsupported { path: path.to_owned(), what });
    if let Some(what) = other_magic(head) {
        return unsupported(what);
    }
    if stl::is_binary(bytes) {
        return Ok(Format::Stl);
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let text = text::decode(head);
    if let Some(what) = other_text(&text) {
        return unsupported(what);
    }
    let binary = text.contains('\0');
    if let Some(format) = text_format(&text, &bytes[bytes.len().saturating_sub(HEAD)..]).filter(|_| !binary) {
        return Ok(format);
    }
    // The content tells nothing: trust the name, and let the parser say what
    // it stumbles over.
    match ending.as_str() {
        "ply" => Ok(Format::Ply),
        "stl" => Ok(Format::Stl),
        _ if binary => Err(ReadError::Unknown { path: path.to_owned() }),
        "obj" => Ok(Format::Obj),
        "off" | "coff" => Ok(Format::Off),
        "gltf" | "glb" => Ok(Format::Gltf),
        e if XYZ_ENDINGS.contains(&e) => Ok(Format::Xyz),
        _ => Err(ReadError::Unknown { path: path.to_owned() }),
    }
}

/// How the text begins decides, then the first line that speaks for one of
/// the formats without a beginning of their own.
fn text_format(text: &str, end: &[u8]) -> Option<Format> {
    if stl::is_ascii(text) {
        return Some(Format::Stl);
    } else if off::is_off(text) {
        return Some(Format::Off);
    } else if gltf::is_gltf(text, end) {
        return Some(Format::Gltf);
    }
    for (_, line) in text::lines(text) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') || line.starts_with("//") {
            continue;
        }
        let first = line.split_whitespace().next().unwrap_or_default();
        if OBJ_KEYWORDS.contains(&first) {
            return Some(Format::Obj);
        }
        if xyz::is_data(line) {
            return Some(Format::Xyz);
        }
    }
    None
}

/// Binary formats that are known but not read.
fn other_magic(head: &[u8]) -> Option<&'static str> {
    let magics: [(&[u8], &str); 7] = [
        (b"LASF", "a LAS or LAZ point cloud"),
        (b"\x93NUMPY", "a NumPy array"),
        (b"PK\x03\x04", "a ZIP archive"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"Kaydara FBX", "an FBX scene"),
        (b"\x89PNG", "a picture"),
        (b"ASTM-E57", "an E57 point cloud"),
    ];
    magics.into_iter().find(|(magic, _)| head.starts_with(magic)).map(|(_, what)| what)
}

/// Text formats that are known but not read.
fn other_text(text: &str) -> Option<&'static str> {
    let start = text.trim_start();
    let has_line =
        |word: &str| text::lines(text).take(20).any(|(_, l)| l.split_whitespace().next() == Some(word));
    if start.starts_with("# .PCD") || (has_line("FIELDS") && has_line("POINTS")) {
        Some("a PCD point cloud")
    } else if start.starts_with("# vtk") {
        Some("a VTK file")
    } else if start.starts_with("<?xml") || start.starts_with("<COLLADA") {
        Some("an XML document")
    } else {
        None
    }
}
