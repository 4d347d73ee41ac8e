//! Detects the format of a file, by its content first and its name second.

use std::path::Path;

use super::{gltf, off, pcd, ply, stl, text, xyz};
use crate::io::error::ReadError;
use foreign::{foreign_binary, foreign_ending, foreign_json, foreign_text};

mod foreign;

/// Formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Obj,
    Ply,
    Stl,
    Off,
    Gltf,
    Pcd,
    Las,
    Npy,
    Npz,
    Xyz,
}

/// How much of the file is looked at.
const HEAD: usize = 64 << 10;

/// First words of OBJ lines.
const OBJ_KEYWORDS: [&str; 12] = ["v", "vn", "vt", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl"];
/// Endings of the names of all files that can be read.
pub(super) const ENDINGS: [&str; 19] = [
    "obj", "ply", "stl", "off", "coff", "gltf", "glb", "pcd", "las", "laz", "npy", "npz", "xyz", "txt",
    "csv", "pts", "asc", "xyzrgb", "xyzn",
];

impl Format {
    /// The format that files with this ending, in lower case, should have.
    pub(super) fn of_ending(ending: &str) -> Option<Self> {
        Some(match ending {
            "obj" => Self::Obj,
            "ply" => Self::Ply,
            "stl" => Self::Stl,
            "off" | "coff" => Self::Off,
            "gltf" | "glb" => Self::Gltf,
            "pcd" => Self::Pcd,
            "las" | "laz" => Self::Las,
            "npy" => Self::Npy,
            "npz" => Self::Npz,
            "xyz" | "txt" | "csv" | "pts" | "asc" | "xyzrgb" | "xyzn" => Self::Xyz,
            _ => return None,
        })
    }
}

/// The format of a file that is not empty.
pub(super) fn format(bytes: &[u8], path: &Path) -> Result<Format, ReadError> {
    let head = &bytes[..bytes.len().min(HEAD)];
    let tail = &bytes[bytes.len().saturating_sub(HEAD)..];
    let magics: [(&[u8], Format); 4] = [
        (b"glTF", Format::Gltf),
        (b"LASF", Format::Las),
        (b"\x93NUMPY", Format::Npy),
        (b"# .PCD", Format::Pcd),
    ];
    if let Some((_, format)) = magics.into_iter().find(|(magic, _)| head.starts_with(magic)) {
        return Ok(format);
    }
    if head.starts_with(b"\x89Superform") {
        return Err(ReadError::Session { path: path.to_owned() });
    }
    let is_in_archive = |name: &[u8]| [head, tail].iter().any(|part| contains(part, name));
    if head.starts_with(b"PK\x03\x04") && is_in_archive(b".npy") {
        // Those of others hold the points that they were made from, too.
        if is_in_archive(b"exponents.npy") && is_in_archive(b"scale.npy") && !is_in_archive(b"pc.npy") {
            return Err(ReadError::Primitives { path: path.to_owned() });
        }
        return Ok(Format::Npz);
    }
    let unsupported = |(what, advice)| Err(ReadError::Unsupported { path: path.to_owned(), what, advice });
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if let Some(known) = foreign_binary(bytes, &ending) {
        return unsupported(known);
    }
    if stl::is_binary(bytes) {
        return Ok(Format::Stl);
    }
    let text = text::decode(head);
    if ply::is_ply(&text) {
        return Ok(Format::Ply);
    }
    if pcd::is_pcd(&text) {
        return Ok(Format::Pcd);
    }
    let is_named_off = Format::of_ending(&ending) == Some(Format::Off);
    let binary = text.contains('\0');
    if !binary {
        if let Some(known) = foreign_text(&text) {
            return unsupported(known);
        }
        if text.trim_start().starts_with('{') && text.contains("\"superform-primitives\"") {
            return Err(ReadError::Primitives { path: path.to_owned() });
        }
        let is_gltf = gltf::is_gltf(&text, tail) || Format::of_ending(&ending) == Some(Format::Gltf);
        if let Some(known) = foreign_json(&text).filter(|_| !is_gltf) {
            return unsupported(known);
        }
        match text_format(&text, tail) {
            // Counts are no points.
            Some(Format::Xyz) if is_named_off && !off::is_points(&text) => return Ok(Format::Off),
            // Rows of numbers may stand in anything.
            Some(Format::Xyz) if foreign_ending(&ending).is_some() => {}
            Some(format) => return Ok(format),
            None => {}
        }
    }
    if let Some(known) = foreign_ending(&ending).filter(|_| ending != "npz") {
        return unsupported(known);
    }
    // The content tells nothing: trust the name, and let the parser say what
    // it stumbles over. Of formats with a mark of their own, the mark is gone.
    match Format::of_ending(&ending) {
        Some(
            format @ (Format::Ply | Format::Stl | Format::Off | Format::Pcd | Format::Las | Format::Npy),
        ) => Ok(format),
        Some(Format::Npz) | None => Err(ReadError::Unknown { path: path.to_owned() }),
        Some(_) if binary => Err(ReadError::Unknown { path: path.to_owned() }),
        Some(format) => Ok(format),
    }
}

/// Whether bytes contain others.
fn contains(bytes: &[u8], wanted: &[u8]) -> bool {
    bytes.windows(wanted.len()).any(|w| w == wanted)
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
        if xyz::names_columns(line) {
            return Some(Format::Xyz);
        }
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
