//! Tells a file's format, from its content first and its name second.

use std::path::Path;

use super::error::ReadError;
use super::{text, xyz};

/// Formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Obj,
    Ply,
    Xyz,
}

/// How much of the file is looked at.
const HEAD: usize = 64 << 10;

/// First words of OBJ lines.
const OBJ_KEYWORDS: [&str; 12] = ["v", "vn", "vt", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl"];
/// Endings of the names of all files that can be read.
pub(super) const ENDINGS: [&str; 9] = ["obj", "ply", "xyz", "txt", "csv", "pts", "asc", "xyzrgb", "xyzn"];
const XYZ_ENDINGS: [&str; 7] = ["xyz", "txt", "csv", "pts", "asc", "xyzrgb", "xyzn"];

/// The format of a file that is not empty.
pub(super) fn format(bytes: &[u8], path: &Path) -> Result<Format, ReadError> {
    let head = &bytes[..bytes.len().min(HEAD)];
    if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") {
        return Ok(Format::Ply);
    }
    let unsupported = |what| Err(ReadError::Unsupported { path: path.to_owned(), what });
    if let Some(what) = other_magic(head) {
        return unsupported(what);
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let text = text::decode(head);
    if let Some(what) = other_text(&text) {
        return unsupported(what);
    }
    let binary = text.contains('\0');
    if let Some(format) = text_format(&text).filter(|_| !binary) {
        return Ok(format);
    }
    let triangles = bytes.get(80..84).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if triangles.is_some_and(|n| bytes.len() as u64 == 84 + 50 * u64::from(n)) {
        return unsupported("an STL mesh");
    }
    // The content tells nothing: trust the name, and let the parser say what
    // it stumbles over.
    match ending.as_str() {
        "ply" => Ok(Format::Ply),
        _ if binary => Err(ReadError::Unknown { path: path.to_owned() }),
        "obj" => Ok(Format::Obj),
        e if XYZ_ENDINGS.contains(&e) => Ok(Format::Xyz),
        _ => Err(ReadError::Unknown { path: path.to_owned() }),
    }
}

/// The first line that speaks for one of the text formats decides.
fn text_format(text: &str) -> Option<Format> {
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
    let magics: [(&[u8], &str); 8] = [
        (b"glTF", "a binary glTF scene"),
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
    let first = start.split_whitespace().next().unwrap_or_default();
    let has_line =
        |word: &str| text::lines(text).take(20).any(|(_, l)| l.split_whitespace().next() == Some(word));
    if first == "solid" && (start.contains("facet") || has_line("endsolid")) {
        Some("an STL mesh")
    } else if ["OFF", "COFF", "NOFF", "CNOFF", "STOFF", "4OFF", "nOFF"].contains(&first) {
        Some("an OFF mesh")
    } else if start.starts_with("# .PCD") || (has_line("FIELDS") && has_line("POINTS")) {
        Some("a PCD point cloud")
    } else if start.starts_with('{') && start.contains("\"asset\"") {
        Some("a glTF scene")
    } else if start.starts_with("# vtk") {
        Some("a VTK file")
    } else if start.starts_with("<?xml") || start.starts_with("<COLLADA") {
        Some("an XML document")
    } else {
        None
    }
}
