//! Saving and opening sessions, and what is done before unsaved work is left.

use std::path::Path;
use std::sync::Arc;

use super::action::{Action, Level, Message};
use super::camera::Camera;
use super::document::Document;
use super::saving::{KeepingEvent, Opening, Parting, PartingAnswer, Saved};
use super::timeline::Branch;
use super::workspace::Workspace;
use super::{Effect, Session};
use crate::worker::{Command, LoadedShape};

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

    /// The content of a session file.
    pub fn workspace(&self) -> Workspace {
        Workspace {
            document: self.document(),
            undo: self.undo.clone(),
            pace: self.pace,
            is_live: self.live.is_on,
            view: self.view,
            camera: self.camera,
        }
    }

    /// Restores a session. Settings of the window itself, such as its theme, are kept.
    pub fn take_workspace(&mut self, workspace: Workspace) -> Vec<Effect> {
        let Workspace { document, undo, pace, is_live, view, camera } = workspace;
        // Before the first picture the window has no form of its own yet, and
        // would frame the shape as soon as it has one.
        let is_known = self.camera.aspect != Camera::default().aspect;
        let aspect = if is_known { self.camera.aspect } else { camera.aspect };
        self.view = view.in_window_of(&self.view);
        self.live.is_on = is_live;
        let mut effects = self.take_document(document);
        self.undo = undo;
        self.refit_scene();
        self.camera = Camera { aspect, ..camera };
        if self.pace != pace {
            self.pace = pace;
            effects.push(Effect::Send(Command::SetPace(pace)));
        }
        effects
    }
}
