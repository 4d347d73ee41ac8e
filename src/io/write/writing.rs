//! Files on their way, with what there is to say of them.

use std::io;
use std::path::Path;

use super::atomic::Together;
use crate::io::error::WriteError;

/// Files that are being written, and what there is to say of them.
#[derive(Debug, Default)]
pub(super) struct Writing {
    pub(super) files: Together,
    pub(super) notes: Vec<String>,
}

/// What can't be written says so of its file.
pub(super) fn content(path: &Path) -> impl Fn(io::Error) -> WriteError {
    move |e| WriteError::Content { path: path.to_owned(), problem: e.to_string() }
}
