//! Results as something to open: the primitives of a file, and the shape that
//! they stand for.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::primitives::{FORMAT, StoredPrimitives};
use super::{built_in, read};
use crate::geometry::TriMesh;
use crate::geometry::tessellate::{Resolution, tessellate};
use crate::io::write::{REPORT_FILE, SEGMENTED_FILE};
use crate::io::{ReadError, Shape, ShapeGeometry, StoredPath};

/// How much of a file is looked at.
const HEAD: u64 = 4 << 10;
/// Arrays that tell primitives from points in an NPZ file, by the names of
/// their members.
const MEMBERS: [&str; 4] = ["scale.npy", "rotation.npy", "translation.npy", "exponents.npy"];

/// Whether a file, or the folder of a run, holds primitives rather than a shape,
/// as far as its beginning tells. Not of CSV files of any name: 13 columns of
/// numbers may be points with their attributes.
pub fn holds_primitives(path: &Path) -> bool {
    if path.is_dir() {
        return path.join(crate::io::PRIMITIVES_FILE).is_file();
    }
    let Ok(file) = File::open(path) else { return false };
    let mut head = Vec::new();
    if (&file).take(HEAD).read_to_end(&mut head).is_err() {
        return false;
    }
    if head.starts_with(b"PK\x03\x04") {
        let Ok(archive) = zip::ZipArchive::new(file) else { return false };
        return MEMBERS.iter().all(|member| archive.index_for_name(member).is_some());
    }
    let text = String::from_utf8_lossy(&head);
    let first = text.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
    let is_table = first.split(',').map(str::trim).eq(crate::io::read::primitives::CSV_COLUMNS);
    // Ours says so in its first line.
    let is_ours = text.strip_prefix("# ").is_some_and(|text| text.starts_with(FORMAT));
    is_table || is_ours || (text.trim_start().starts_with('{') && text.contains(FORMAT))
}

/// The shape that primitives stand for: the input that the report beside them
/// names, if it is still there; else the segmented cloud beside them; else the
/// points in their own file; else their surfaces. [`Shape::notes`] tell which.
///
/// # Errors
/// Where the file that is named or stands beside can't be read.
pub fn shape_of(stored: &StoredPrimitives) -> Result<Shape, ReadError> {
    if let Some(path) = input_of(stored) {
        return read(&path);
    }
    if stored.input.as_deref() == Some("built-in chair") {
        return built_in();
    }
    let segmented = stored.path.with_file_name(SEGMENTED_FILE);
    let (source, of) = if segmented.is_file() {
        (Some(segmented), "the segmented cloud beside it")
    } else if has_points(&stored.path) {
        (Some(stored.path.clone()), "the points in the file")
    } else {
        (None, "the surfaces of the primitives")
    };
    let name = match (&stored.input, stored.path.file_name()) {
        (Some(input), _) => input.clone(),
        (None, Some(name)) => name.to_string_lossy().into_owned(),
        (None, None) => "primitives".to_owned(),
    };
    let shape = match source {
        Some(path) => read(&path)?,
        None => surfaces(stored),
    };
    let mut notes = shape.notes;
    notes.push(format!("the input of these primitives was not found: taken instead were {of}"));
    Ok(Shape { name, path: None, notes, ..shape })
}

/// The input that a report beside the file names.
fn input_of(stored: &StoredPrimitives) -> Option<PathBuf> {
    #[derive(Deserialize)]
    struct Report {
        input: Input,
    }
    #[derive(Deserialize)]
    struct Input {
        name: String,
        path: Option<StoredPath>,
    }
    let report = std::fs::read(stored.path.with_file_name(REPORT_FILE)).ok()?;
    let Report { input } = serde_json::from_slice(&report).ok()?;
    // A report of another run says nothing.
    let is_same = stored.input.as_deref() == Some(input.name.as_str());
    input.path.map(|path| path.0).filter(|path| is_same && path.is_file())
}

/// Whether an NPZ file of primitives has the points, too.
fn has_points(path: &Path) -> bool {
    let archive = File::open(path).ok().and_then(|file| zip::ZipArchive::new(file).ok());
    archive.is_some_and(|archive| archive.index_for_name("pc.npy").is_some())
}

fn surfaces(stored: &StoredPrimitives) -> Shape {
    let resolution = Resolution::SCREEN;
    let mut mesh = TriMesh::default();
    for primitive in &stored.primitives {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(tessellate(&primitive.shape, resolution).vertices);
        mesh.faces.extend(resolution.faces().into_iter().map(|face| face.map(|i| i + first)));
    }
    Shape {
        name: String::new(),
        path: None,
        geometry: ShapeGeometry::Mesh(mesh),
        attributes: Default::default(),
        notes: Vec::new(),
    }
}
