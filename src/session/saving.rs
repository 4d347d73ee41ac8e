//! The session's files: where it is saved, what has changed since, and what earlier windows left
//! for recovery.

use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};

use super::document::Document;
use super::workspace::Workspace;

/// A session left behind by a process that has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// Identifies it among the journals.
    pub id: u64,
    pub summary: Summary,
    /// When it was last written.
    pub kept_at: SystemTime,
}

/// Summary of a session for the recovery dialog.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Summary {
    /// The shape's name, where there is one.
    pub shape: Option<String>,
    /// Of the shown state: finished iterations, and the total.
    pub iteration: u32,
    pub iterations: u32,
    pub primitives: usize,
    pub branches: usize,
    /// Steps that can be undone.
    pub steps: usize,
}

impl std::fmt::Display for Summary {
    /// “chair.obj, iteration 17 of 30, 2 branches”.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.shape.as_deref().unwrap_or("No shape"))?;
        if self.primitives > 0 {
            write!(f, ", iteration {} of {}", self.iteration, self.iterations)?;
        }
        match self.branches {
            0 | 1 => Ok(()),
            branches => write!(f, ", {branches} branches"),
        }
    }
}

impl Summary {
    /// Of a document with this many undo steps.
    pub fn of(document: &Document, steps: usize) -> Self {
        let shown = document.timeline.shown();
        let params = shown.map_or(document.params, |state| state.params);
        Self {
            shape: document.loaded.as_ref().map(|loaded| loaded.shape.name.clone()),
            iteration: shown.map_or(0, |state| state.abstraction.iteration),
            iterations: params.iterations,
            primitives: shown.map_or(0, |state| state.abstraction.primitives.len()),
            branches: document.timeline.branches().len(),
            steps,
        }
    }
}

/// How much of the current session is saved in a file.
#[derive(Debug, Default)]
pub(super) enum Saved {
    /// Nothing has been saved yet: all of the user's work is unsaved.
    #[default]
    Never,
    /// It came from the journal of another window: all of it is unsaved.
    Recovered,
    As {
        path: PathBuf,
        document: Box<Document>,
    },
}

/// An action that waits for a decision about unsaved work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Parting {
    Quit,
    /// Open another session.
    Open(Opening),
}

/// A session to open.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Opening {
    File(PathBuf),
    /// A session offered for recovery, by id.
    Recovered(u64),
    /// The session that was last closed without saving.
    Last,
}

/// Where the session is kept.
#[derive(Debug, Default)]
pub struct Saving {
    pub(super) saved: Saved,
    /// Sessions left behind by earlier windows, still to be decided on.
    pub(super) found: Vec<Found>,
    /// Whether there is a session that was closed without saving.
    pub(super) has_last: bool,
    /// Whether the journal is up to date.
    pub(super) is_kept: bool,
    pub(super) parting: Option<Parting>,
    /// The action to resume once the session is saved.
    pub(super) after_saving: Option<Parting>,
}

impl Saving {
    /// The sessions offered for recovery.
    pub fn found(&self) -> &[Found] {
        &self.found
    }

    pub fn has_last(&self) -> bool {
        self.has_last
    }

    /// The action that waits for a decision about unsaved work.
    pub fn parting(&self) -> Option<&Parting> {
        self.parting.as_ref()
    }
}

/// Events from the thread that handles session files.
#[derive(Debug)]
pub enum KeepingEvent {
    Found(Vec<Found>),
    HasLast(bool),
    /// The journal is up to date.
    Kept,
    /// The journal cannot be written, with the reason.
    NotKept(String),
    Saved {
        path: PathBuf,
        workspace: Box<Workspace>,
    },
    Opened {
        from: Opening,
        workspace: Box<Workspace>,
        /// What was lost, one sentence each.
        notes: Vec<String>,
    },
    Failed {
        what: String,
        error: String,
    },
}

/// What to do about unsaved work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartingAnswer {
    Save,
    Discard,
    Cancel,
}

/// How long ago something was, for people: “12 minutes ago”.
pub fn ago(then: SystemTime, now: SystemTime) -> String {
    let seconds = now.duration_since(then).unwrap_or(Duration::ZERO).as_secs();
    let (count, unit) = match seconds {
        0..60 => return "a moment ago".to_owned(),
        60..3600 => (seconds / 60, "minute"),
        3600..86_400 => (seconds / 3600, "hour"),
        _ => (seconds / 86_400, "day"),
    };
    format!("{count} {unit}{} ago", if count == 1 { "" } else { "s" })
}
