//! What can go wrong with a session file, said so that a person can act.

use std::path::PathBuf;

use crate::io::on_reading;

/// Why a session can't be opened. The present session stays as it is.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    #[error("cannot open {path}: {}", on_reading(reason), path = path.display())]
    Open { path: PathBuf, reason: std::io::Error },
    #[error("{path} is not a file; give a session file (.superform)", path = path.display())]
    NotAFile { path: PathBuf },
    #[error("{path} has {bytes} bytes; the limit is {limit}", path = path.display())]
    TooLarge { path: PathBuf, bytes: u64, limit: u64 },
    #[error("{path} is empty; it may not have been copied completely", path = path.display())]
    Empty { path: PathBuf },
    #[error("{path} is not a Superform session; open a file written by Save session (.superform)", path = path.display())]
    NotASession { path: PathBuf },
    #[error(
        "{path} is a session of format {format}, written by Superform {program}, and this is Superform {this}, \
         which reads formats up to {newest}; open it with Superform {program} or later",
        path = path.display(), this = env!("CARGO_PKG_VERSION"),
    )]
    TooNew { path: PathBuf, format: u16, newest: u16, program: String },
    #[error("{path} is damaged at byte {byte}: {problem}; nothing can be recovered from it; use a \
         backup copy", path = path.display())]
    Damaged { path: PathBuf, byte: u64, problem: String },
}

/// A fault in a file's content, before the file's name is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Fault {
    /// Offset in bytes from the start of the file.
    pub(super) byte: u64,
    pub(super) problem: String,
}

impl Fault {
    pub(super) fn at(byte: u64, problem: impl Into<String>) -> Self {
        Self { byte, problem: problem.into() }
    }

    pub(super) fn in_file(self, path: PathBuf) -> OpenError {
        OpenError::Damaged { path, byte: self.byte, problem: self.problem }
    }
}
