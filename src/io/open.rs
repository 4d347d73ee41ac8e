//! Whatever is given is opened: what it is, is told here.

use std::path::{Path, PathBuf};

use super::error::ReadError;
use super::names::has_session_ending;
use super::primitives::read_primitives;
use super::read::{OpenedResult, holds_primitives, open_result, read};
use super::shape::Shape;

/// What a path leads to.
#[derive(Debug)]
pub enum Opened {
    Shape(Box<Shape>),
    /// Primitives, with the shape that they stand for.
    Result(Box<OpenedResult>),
    /// A session, which is still to be read: what it holds is not known here.
    Session(PathBuf),
}

/// Opens a file, or the folder of a run: a session is told by its name
/// ([`has_session_ending`]), anything else by its content ([`holds_primitives`]).
///
/// # Errors
/// As [`read`], [`read_primitives`] and [`open_result`].
pub fn open(path: &Path) -> Result<Opened, ReadError> {
    if has_session_ending(path) && !path.is_dir() {
        Ok(Opened::Session(path.to_owned()))
    } else if holds_primitives(path) {
        Ok(Opened::Result(Box::new(open_result(read_primitives(path)?, None)?)))
    } else {
        read(path).map(|shape| Opened::Shape(Box::new(shape)))
    }
}
