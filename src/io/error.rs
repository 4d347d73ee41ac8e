//! Errors on reading and writing. Each message says what is wrong, where, and what to do.

use std::borrow::Cow;
use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::wording::{on_reading, on_writing};
use super::write::is_standard_output;

/// The formats that can be read, for messages.
pub(super) const FORMATS: &str =
    "OBJ, PLY, STL, OFF, glTF, GLB, PCD, LAS, LAZ, NPY, NPZ and XYZ text (.xyz, .txt, .csv, .pts)";

/// Where in a file something was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Line number, from 1.
    Line(usize),
    /// Offset in bytes from the start of the file.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(n) => write!(f, "line {n}"),
            Self::Byte(n) => write!(f, "byte {n}"),
        }
    }
}

/// Why a shape can't be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    #[error("cannot open {path}: {}", on_reading(reason), path = path.display())]
    Open { path: PathBuf, reason: std::io::Error },
    #[error("{path} is not a file; give a mesh or a point cloud", path = path.display())]
    NotAFile { path: PathBuf },
    #[error("{path} has {bytes} bytes; the limit is {limit}; reduce its size first", path = path.display())]
    TooLarge { path: PathBuf, bytes: u64, limit: u64 },
    #[error("{path} is empty; it may not have been written completely", path = path.display())]
    Empty { path: PathBuf },
    #[error("{path} is {what}, which cannot be read; {advice}", path = path.display())]
    Unsupported { path: PathBuf, what: &'static str, advice: &'static str },
    #[error("{path} is a Superform session, not a shape; open it in the window and export what \
         you need", path = path.display())]
    Session { path: PathBuf },
    #[error("{path} contains Superform primitives, not a shape; import it as primitives or open \
         the original shape", path = path.display())]
    Primitives { path: PathBuf },
    #[error("{path} has an unknown format; supported formats are {formats}", path = path.display(), formats = FORMATS)]
    Unknown { path: PathBuf },
    #[error("{path}{at}: {problem}", path = path.display(), at = place.map(|p| format!(", {p}")).unwrap_or_default())]
    Malformed { path: PathBuf, place: Option<Place>, problem: String },
}

/// A fault in a file's content, before the file's name is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) place: Option<Place>,
    pub(super) problem: String,
}

impl Fault {
    pub(super) fn at_line(line: usize, problem: impl Into<String>) -> Self {
        Self { place: Some(Place::Line(line)), problem: problem.into() }
    }

    pub(super) fn at_byte(byte: usize, problem: impl Into<String>) -> Self {
        Self { place: Some(Place::Byte(byte)), problem: problem.into() }
    }

    pub(super) fn whole(problem: impl Into<String>) -> Self {
        Self { place: None, problem: problem.into() }
    }

    /// The same fault in a text that follows this many lines.
    pub(super) fn after_lines(mut self, lines: usize) -> Self {
        if let Some(Place::Line(line)) = &mut self.place {
            *line += lines;
        }
        self
    }

    pub(super) fn in_file(self, path: PathBuf) -> ReadError {
        ReadError::Malformed { path, place: self.place, problem: self.problem }
    }
}

/// Why a result can't be written. Nothing was left behind, and a file that
/// stood at the place is as it was.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    #[error("cannot write {}: {}", target(path), on_writing(reason))]
    Io { path: PathBuf, reason: std::io::Error },
    #[error("cannot write {path}: the folder {folder} does not exist; create it or choose another", path = path.display(), folder = folder.display())]
    NoFolder { path: PathBuf, folder: PathBuf },
    #[error("cannot write {path}: this would overwrite the input {input}; choose another name or \
         folder", path = path.display(), input = input.display())]
    IsInput { path: PathBuf, input: PathBuf },
    #[error("cannot write {path}: a folder with this name exists", path = path.display())]
    IsAFolder { path: PathBuf },
    /// The file could be written, but can't hold what should be in it.
    #[error("cannot write {path}: {problem}", path = path.display())]
    Content { path: PathBuf, problem: String },
    #[error("cannot write {path}: {format} needs a mesh, but the input is a point cloud; export \
         the segmented cloud instead", path = path.display())]
    NeedsMesh { path: PathBuf, format: &'static str },
    #[error("cannot write {path}: {format} needs the shape, but only primitives are available; \
         run the shape again", path = path.display())]
    OnlyPrimitives { path: PathBuf, format: &'static str },
    #[error("cannot write {path}: cannot tell the format from the name; see superform export \
         --list", path = path.display())]
    UnknownFormat { path: PathBuf },
}

impl WriteError {
    /// Whether nobody reads any more what was to be written.
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Io { reason, .. } if reason.kind() == ErrorKind::BrokenPipe)
    }
}

/// Where something is written to, for messages.
fn target(path: &Path) -> Cow<'_, str> {
    if is_standard_output(path) { "to standard output".into() } else { path.to_string_lossy() }
}
