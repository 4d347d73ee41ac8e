//! How work in the engine ends early, and how that is said.

use super::source;
use crate::inference::InferenceError;
use crate::io::caught;

/// Something that a person has to be told.
#[derive(Debug)]
pub(super) struct Trouble {
    pub(super) what: String,
    pub(super) error: String,
}

/// The work was cancelled, or there is trouble.
#[derive(Debug)]
pub(super) enum Stop {
    Cancelled,
    Trouble(Trouble),
}

impl Stop {
    pub(super) fn trouble(what: impl Into<String>, error: impl Into<String>) -> Self {
        Self::Trouble(Trouble { what: what.into(), error: error.into() })
    }

    pub(super) fn inference(what: &str, error: &InferenceError) -> Self {
        match error {
            InferenceError::Cancelled => Self::Cancelled,
            other => Self::trouble(what, source::chain(other)),
        }
    }
}

/// What [`Event::Failed`](super::Event::Failed) says after a panic.
pub const FAULT: &str = "The sampler stopped after an internal error";

/// Runs `work`, and turns a panic into trouble that can be reported.
pub(super) fn guarded<T>(work: impl FnOnce() -> Result<T, Stop>) -> Result<T, Stop> {
    caught(work).unwrap_or_else(|message| Err(Stop::trouble(FAULT, message)))
}
