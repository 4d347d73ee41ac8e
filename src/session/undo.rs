//! Undo and redo, as documents from before each step.

use std::fmt;
use std::sync::Arc;

use super::document::Document;

/// Steps that can be undone; older ones are forgotten.
const KEPT: usize = 200;

/// A step, with the document on its other side.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// For people: “change α”, “merge 3 and 5”.
    pub label: String,
    pub document: Document,
}

/// How an action is undone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Undoable {
    /// Combined with the following changes with the same label until the gesture ends.
    Gesture(String),
    Step(String),
}

/// The two stacks, the newest last. Cheap to clone.
#[derive(Clone, Default, PartialEq)]
pub struct Undo {
    done: Vec<Arc<Step>>,
    undone: Vec<Arc<Step>>,
    /// The label of the gesture that the newest step belongs to: what else it
    /// does is part of that step.
    gesture: Option<String>,
}

impl fmt::Debug for Undo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Undo")
            .field("done", &self.done.len())
            .field("undone", &self.undone.len())
            .field("gesture", &self.gesture)
            .finish()
    }
}

impl Undo {
    /// Restores the stacks from a file.
    pub fn from_parts(done: Vec<Arc<Step>>, undone: Vec<Arc<Step>>) -> Self {
        Self { done, undone, gesture: None }
    }

    /// Whether the same steps can be undone and redone.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let same = |a: &[Arc<Step>], b: &[Arc<Step>]| {
            a.len() == b.len()
                && match (a.last(), b.last()) {
                    (Some(a), Some(b)) => Arc::ptr_eq(a, b),
                    _ => true,
                }
        };
        same(&self.done, &other.done) && same(&self.undone, &other.undone)
    }

    /// Steps that can be undone, newest last.
    pub fn done(&self) -> &[Arc<Step>] {
        &self.done
    }

    /// Steps that can be redone, next one last.
    pub fn undone(&self) -> &[Arc<Step>] {
        &self.undone
    }

    /// Records the document from before a step.
    pub(super) fn record(&mut self, label: impl Into<String>, before: Document) {
        self.gesture = None;
        self.push(label.into(), before);
    }

    /// As [`Undo::record`], but consecutive changes with the same label are one
    /// step until the gesture ends.
    pub(super) fn record_gesture(&mut self, label: &str, before: Document) {
        if self.gesture.as_deref() != Some(label) {
            self.push(label.to_owned(), before);
            self.gesture = Some(label.to_owned());
        }
    }

    /// Ends the gesture.
    pub(super) fn end_gesture(&mut self) {
        self.gesture = None;
    }

    fn push(&mut self, label: String, document: Document) {
        self.undone.clear();
        if self.done.len() == KEPT {
            self.done.remove(0);
        }
        self.done.push(Arc::new(Step { label, document }));
    }

    /// Goes one step back from `now`, past steps that changed nothing.
    pub(super) fn undo(&mut self, now: &Document) -> Option<Arc<Step>> {
        step(&mut self.done, &mut self.undone, now, &mut self.gesture)
    }

    /// Reverts the last [`Undo::undo`].
    pub(super) fn redo(&mut self, now: &Document) -> Option<Arc<Step>> {
        step(&mut self.undone, &mut self.done, now, &mut self.gesture)
    }
}

/// Moves a step from one stack to the other, where `now` takes its place.
fn step(
    from: &mut Vec<Arc<Step>>,
    to: &mut Vec<Arc<Step>>,
    now: &Document,
    gesture: &mut Option<String>,
) -> Option<Arc<Step>> {
    *gesture = None;
    loop {
        let step = from.pop()?;
        if step.document != *now {
            to.push(Arc::new(Step { label: step.label.clone(), document: now.clone() }));
            return Some(step);
        }
    }
}
