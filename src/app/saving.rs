//! The session and its files: what changes is kept, what the autosave's thread
//! tells is put in the session's words, and nothing is lost when the window closes.

use std::path::PathBuf;
use std::time::Duration;

use crate::project::{self, Autosave, Event, Origin};
use crate::session::Session;
use crate::session::saving::{KeepingEvent, Opening};
use crate::session::workspace::Workspace;

/// The autosave and what it was told last.
#[derive(Debug)]
pub(super) struct Saving {
    /// `None` once the window closes.
    autosave: Option<Autosave>,
    /// What was handed over last.
    kept: Option<Workspace>,
}

impl Saving {
    /// Looks for what was left behind in the folder, and keeps the session
    /// there; nothing is kept where there is none.
    pub(super) fn start(folder: Option<PathBuf>, ctx: &egui::Context) -> std::io::Result<Self> {
        let ctx = ctx.clone();
        let autosave = Autosave::spawn(folder, move || ctx.request_repaint())?;
        Ok(Self { autosave: Some(autosave), kept: None })
    }

    pub(super) fn open(&mut self, opening: Opening, session: &Session) {
        let origin = match opening {
            Opening::File(path) => Origin::File(path),
            Opening::Recovered(id) => Origin::Recovered(id),
            Opening::Last => Origin::Last,
        };
        if let Some(autosave) = &mut self.autosave {
            autosave.open(origin, session.unsaved());
        }
    }

    pub(super) fn save(&mut self, path: PathBuf, session: &Session) {
        if let Some(autosave) = &mut self.autosave {
            autosave.save(path, session.workspace());
        }
    }

    pub(super) fn discard(&mut self, id: u64) {
        if let Some(autosave) = &mut self.autosave {
            autosave.discard(id);
        }
    }

    /// Hands the session over if it has changed.
    pub(super) fn keep(&mut self, session: &Session) {
        let is_kept = self.kept.as_ref().is_some_and(|kept| session.is_kept_as(kept));
        if is_kept || session.loaded.is_none() {
            return;
        }
        if let Some(autosave) = &mut self.autosave {
            let workspace = session.workspace();
            autosave.keep(workspace.clone());
            self.kept = Some(workspace);
        }
    }
    /// What the autosave has told.
    pub(super) fn news(&mut self) -> Vec<KeepingEvent> {
        let events: Vec<Event> = self.autosave.iter_mut().flat_map(Autosave::try_events).collect();
        events.into_iter().map(|event| self.heard(event)).collect()
    }

    /// Waits for the autosave's next event, at most `timeout`.
    pub(super) fn next_event(&mut self, timeout: Duration) -> Option<KeepingEvent> {
        let event = self.autosave.as_mut()?.next_event(timeout)?;
        Some(self.heard(event))
    }

    fn heard(&mut self, event: Event) -> KeepingEvent {
        match event {
            Event::Found(found) => KeepingEvent::Found(found),
            Event::HasLast(has) => KeepingEvent::HasLast(has),
            Event::Kept(_) => KeepingEvent::Kept,
            Event::NotKept(error) => KeepingEvent::NotKept(error),
            Event::Saved { path, workspace } => KeepingEvent::Saved { path, workspace },
            Event::Opened { origin, opened } => {
                let from = match origin {
                    Origin::File(path) => Opening::File(path),
                    Origin::Recovered(id) => Opening::Recovered(id),
                    Origin::Last => Opening::Last,
                };
                let project::Opened { workspace, notes } = *opened;
                // The autosave has it, or its file is there.
                self.kept = None;
                KeepingEvent::Opened { from, workspace: Box::new(workspace), notes }
            }
            Event::Failed { what, error } => KeepingEvent::Failed { what, error },
        }
    }

    /// Waits until all that is to be kept is on the disk: unsaved work as the
    /// last session.
    pub(super) fn close(&mut self, session: &Session) {
        if let Some(autosave) = self.autosave.take() {
            autosave.close(session.unsaved());
        }
    }
}
