//! The content of a session file: the document with its undo history and view.

use super::camera::Camera;
use super::document::Document;
use super::undo::Undo;
use super::view::View;
use crate::worker::Pace;

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
