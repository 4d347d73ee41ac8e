//! The session and its files: what changes is kept, what the autosave's thread
//! tells is taken in, and nothing is lost when the window closes.

use std::path::PathBuf;
use std::time::Duration;

use super::App;
use crate::project::{self, Autosave, Event, Origin};
use crate::session::saving::{KeepingEvent, Opening};
use crate::session::workspace::Workspace;
use crate::session::{Action, Effect, Session, Verb};

/// The autosave and what it was told last.
#[derive(Debug)]
pub(super) struct Saving {
    /// `None` once the window closes.
    autosave: Option<Autosave>,
    /// What was handed over last.
    kept: Option<Workspace>,
    /// The window is to close, whatever is unsaved.
    is_leaving: bool,
}

impl Saving {
    /// Looks for what was left behind in the folder, and keeps the session
    /// there; nothing is kept where there is none.
    pub(super) fn start(folder: Option<PathBuf>, ctx: &egui::Context) -> std::io::Result<Self> {
        let ctx = ctx.clone();
        let autosave = Autosave::spawn(folder, move || ctx.request_repaint())?;
        Ok(Self { autosave: Some(autosave), kept: None, is_leaving: false })
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
}

impl App {
    /// Takes in what the autosave has told.
    pub(super) fn absorb_keeping(&mut self, ctx: &egui::Context) {
        let events: Vec<Event> = self.saving.autosave.iter_mut().flat_map(Autosave::try_events).collect();
        for event in events {
            self.absorb_kept(ctx, event);
        }
    }

    /// Waits for the autosave's next event and takes it in; whether there was
    /// one within `timeout`.
    pub fn wait_for_keeper(&mut self, ctx: &egui::Context, timeout: Duration) -> bool {
        let event = self.saving.autosave.as_mut().and_then(|autosave| autosave.next_event(timeout));
        let came = event.is_some();
        if let Some(event) = event {
            self.absorb_kept(ctx, event);
        }
        came
    }

    fn absorb_kept(&mut self, ctx: &egui::Context, event: Event) {
        let event = match event {
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
                self.saving.kept = None;
                KeepingEvent::Opened { from, workspace: Box::new(workspace), notes }
            }
            Event::Failed { what, error } => KeepingEvent::Failed { what, error },
        };
        let effects = self.session.absorb_keeping(event);
        self.carry_out(ctx, effects);
    }

    /// Closes the window.
    pub(super) fn leave(&mut self, ctx: &egui::Context) {
        self.saving.is_leaving = true;
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    /// Asks before the window system closes the window over unsaved work that
    /// nothing else keeps.
    pub(super) fn watch_closing(&mut self, ctx: &egui::Context) {
        if self.saving.is_leaving || !ctx.input(|input| input.viewport().close_requested()) {
            return;
        }
        let effects = self.session.apply(Action::Verb(Verb::Quit));
        if !effects.iter().any(|effect| matches!(effect, Effect::Quit)) {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
        }
    }

    /// Waits until all that is to be kept is on the disk: unsaved work as the
    /// last session.
    pub fn close(&mut self) {
        if let Some(autosave) = self.saving.autosave.take() {
            autosave.close(self.session.unsaved());
        }
    }
}
