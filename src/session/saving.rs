//! The session's files: where it is saved, what has changed since, and what earlier windows left
//! for recovery.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};

use super::document::Document;
use super::messages::{Level, Message};
use super::timeline::Branch;
use super::workspace::Workspace;
use super::{Action, Effect, Session};
use crate::worker::LoadedShape;

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
enum Saved {
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
    saved: Saved,
    /// Sessions left behind by earlier windows, still to be decided on.
    found: Vec<Found>,
    /// Whether there is a session that was closed without saving.
    has_last: bool,
    /// Whether the journal is up to date.
    is_kept: bool,
    parting: Option<Parting>,
    /// The action to resume once the session is saved.
    after_saving: Option<Parting>,
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

impl Session {
    /// The file that the current work was saved to or opened from. `None` once
    /// another shape is open, because the file does not contain that work.
    /// Undoing this restores the work together with its file.
    pub fn session_file(&self) -> Option<&Path> {
        let Saved::As { path, document } = &self.saving.saved else { return None };
        let shape = |loaded: &Option<Arc<LoadedShape>>| loaded.as_ref().map(|l| Arc::as_ptr(&l.shape));
        (shape(&self.loaded) == shape(&document.loaded)).then_some(path)
    }

    /// Name of the session: that of its file, or of its shape.
    pub fn title(&self) -> Option<String> {
        let file =
            self.session_file().and_then(Path::file_stem).map(|stem| stem.to_string_lossy().into_owned());
        file.or_else(|| self.loaded.as_ref().map(|loaded| loaded.shape.name.clone()))
    }

    /// Whether there is unsaved work.
    pub fn is_changed(&self) -> bool {
        match &self.saving.saved {
            Saved::Never => !self.undo.done().is_empty() || !self.undo.undone().is_empty(),
            Saved::Recovered => true,
            Saved::As { document, .. } => !self.has_work_of(document),
        }
    }

    /// Whether the current work equals that of the document. The selection and
    /// the shown state do not count as work.
    fn has_work_of(&self, saved: &Document) -> bool {
        let place = |loaded: &Option<_>| loaded.as_ref().map(Arc::as_ptr);
        let mark = |branch: &Branch| (branch.id, branch.states.len(), branch.states.last().map(|s| s.key));
        let (now, then) = (self.timeline.branches(), saved.timeline.branches());
        place(&self.loaded) == place(&saved.loaded)
            && (self.params, self.sampling) == (saved.params, saved.sampling)
            && self.hidden == saved.hidden
            && now.len() == then.len()
            && now.iter().zip(then).all(|(a, b)| mark(a) == mark(b) && a.name == b.name)
    }

    /// Whether this equals what was last journalled. A change of the camera
    /// alone is not worth writing.
    pub fn is_kept_as(&self, kept: &Workspace) -> bool {
        let Workspace { document, undo, pace, is_live, view, .. } = kept;
        self.undo.is_same(undo)
            && (self.pace, self.live.is_on, self.view) == (*pace, *is_live, *view)
            && self.is_document(document)
    }

    fn is_document(&self, document: &Document) -> bool {
        let place = |loaded: &Option<_>| loaded.as_ref().map(Arc::as_ptr);
        place(&self.loaded) == place(&document.loaded)
            && (self.params, self.sampling) == (document.params, document.sampling)
            && self.timeline == document.timeline
            && self.selection == document.selection
            && self.selected_points == document.selected_points
            && self.hidden == document.hidden
    }

    /// The session to keep when the window closes; `None` if there is no unsaved work.
    pub fn unsaved(&self) -> Option<Workspace> {
        self.is_changed().then(|| self.workspace())
    }

    /// Handles an event about session files.
    pub fn absorb_keeping(&mut self, event: KeepingEvent) -> Vec<Effect> {
        match event {
            KeepingEvent::Found(found) => self.saving.found = found,
            KeepingEvent::HasLast(has) => self.saving.has_last = has,
            KeepingEvent::Kept => self.saving.is_kept = true,
            KeepingEvent::NotKept(error) => {
                self.saving.is_kept = false;
                self.messages.push(Level::Error, "Crash recovery is not available for this session", error);
            }
            KeepingEvent::Saved { path, workspace } => {
                self.messages.dismiss_errors();
                let text = format!("Saved the session to {}", path.display());
                let offer = Action::ShowInFolder(path.clone());
                self.messages.add(Message::new(Level::Note, text).offer("Show in folder", offer));
                self.window.recent.add(&path);
                self.saving.saved = Saved::As { path, document: Box::new(workspace.document) };
                if let Some(parting) = self.saving.after_saving.take() {
                    return vec![self.part(parting)];
                }
            }
            KeepingEvent::Opened { from, workspace, notes } => {
                let name =
                    workspace.document.loaded.as_ref().map_or("an unnamed shape", |l| l.shape.name.as_str());
                self.messages.dismiss_errors();
                self.messages.push(Level::Note, format!("Opened the session of {name}"), "");
                for note in notes {
                    self.messages.push(Level::Error, "The session is incomplete", note);
                }
                self.saving.saved = match from {
                    Opening::File(path) => {
                        self.window.recent.add(&path);
                        Saved::As { path, document: Box::new(workspace.document.clone()) }
                    }
                    Opening::Recovered(id) => {
                        self.saving.found.retain(|found| found.id != id);
                        Saved::Recovered
                    }
                    Opening::Last => Saved::Recovered,
                };
                return self.take_workspace(*workspace);
            }
            KeepingEvent::Failed { what, error } => {
                self.saving.after_saving = None;
                self.messages.push(Level::Error, what, error);
            }
        }
        Vec::new()
    }

    /// Saves the session to its file, or asks for one.
    pub(super) fn save_session(&mut self) -> Effect {
        self.saving.after_saving = None;
        self.session_file().map_or(Effect::AskForSession, |path| Effect::SaveSession(path.to_owned()))
    }

    pub(super) fn save_session_as(&mut self) -> Effect {
        self.saving.after_saving = None;
        Effect::AskForSession
    }

    /// Opens another session or quits, immediately if nothing would be lost.
    pub fn leave(&mut self, parting: Parting) -> Vec<Effect> {
        if self.is_changed() && !self.saving.is_kept {
            self.saving.parting = Some(parting);
            return Vec::new();
        }
        vec![self.part(parting)]
    }

    pub(super) fn answer_parting(&mut self, answer: PartingAnswer) -> Vec<Effect> {
        let parting = self.saving.parting.take();
        match (answer, parting) {
            (PartingAnswer::Save, Some(parting)) => {
                let save = self.save_session();
                self.saving.after_saving = Some(parting);
                vec![save]
            }
            (PartingAnswer::Discard, Some(parting)) => vec![self.part(parting)],
            _ => Vec::new(),
        }
    }

    fn part(&self, parting: Parting) -> Effect {
        match parting {
            Parting::Quit => Effect::Quit,
            Parting::Open(opening) => Effect::OpenSession(opening),
        }
    }

    /// Discards a session offered for recovery.
    pub(super) fn discard_found(&mut self, id: u64) -> Effect {
        self.saving.found.retain(|found| found.id != id);
        Effect::DiscardFound(id)
    }

    /// Postpones recovery to the next start.
    pub(super) fn put_off_found(&mut self) {
        self.saving.found.clear();
    }
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
