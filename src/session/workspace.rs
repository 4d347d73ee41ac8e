//! The content of a session file: the document with its undo history and view.

use super::camera::Camera;
use super::document::Document;
use super::undo::Undo;
use super::view::View;
use super::{Effect, Session};
use crate::worker::{Command, Pace};

/// A whole session. Cheap to clone: shapes and states are shared.
#[derive(Debug, Clone)]
pub struct Workspace {
    pub document: Document,
    pub undo: Undo,
    pub pace: Pace,
    pub is_live: bool,
    pub view: View,
    pub camera: Camera,
}

impl Workspace {
    /// Whether there is anything worth saving.
    pub fn has_work(&self) -> bool {
        self.document.timeline.branches().iter().any(|branch| branch.states.len() > 1)
            || !self.undo.done().is_empty()
            || !self.undo.undone().is_empty()
    }
}

impl Session {
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
