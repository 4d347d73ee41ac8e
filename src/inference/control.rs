//! What every step may be asked, and what may come in its way: to stop, and
//! errors.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::geometry::theta::Invalid;
use crate::inference::params::SMALLEST_CLUSTER;

/// A flag that asks long work to stop; cheap to clone and to test.
#[derive(Debug, Clone, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Why a run can't start or go on.
#[derive(Debug, thiserror::Error)]
pub enum InferenceError {
    #[error(
        "there {are} {points} distinct {noun}, but a primitive needs more than {SMALLEST_CLUSTER}; use a \
         cloud with more points, or a mesh with faces",
        are = if *points == 1 { "is" } else { "are" },
        noun = if *points == 1 { "point" } else { "points" },
    )]
    TooFewPoints { points: usize },
    /// A run came to its end without a result.
    #[error(
        "no primitives were found for the {points} samples; use a shape with more points or less noise, another \
         method, or a lower p0"
    )]
    NoPrimitives { points: usize },
    #[error("{0}")]
    Params(String),
    /// A saved state that no run can go on from.
    #[error("the saved state cannot be continued: {0}; start a new run")]
    Checkpoint(String),
    /// An edit that can't be made, and what to do about it.
    #[error("{0}")]
    Edit(String),
    /// A shape that a primitive can't have.
    #[error("{0}")]
    Shape(#[from] Invalid),
    /// The step was cancelled; the state is the one before the step.
    #[error("cancelled")]
    Cancelled,
}

pub(crate) type Outcome<T> = Result<T, InferenceError>;

pub(crate) fn refuse<T>(problem: impl Into<String>) -> Outcome<T> {
    Err(InferenceError::Edit(problem.into()))
}
