//! What the program has to say: the log, and the error that waits for an answer.

use std::collections::VecDeque;

use crate::inference::{Algorithm, Occurrence};
use crate::worker::Snapshot;

/// Messages that are kept; older ones are dropped.
const KEPT: usize = 1000;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// For the log only.
    Detail,
    /// Shown for a moment.
    Note,
    /// Shown until it is dismissed.
    Error,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Counts all messages from 1.
    pub number: u64,
    pub level: Level,
    /// What happened.
    pub text: String,
    /// Why, and what to do; may be empty.
    pub detail: String,
}

/// The log, oldest first.
#[derive(Debug, Clone, Default)]
pub struct Messages {
    kept: VecDeque<Message>,
    count: u64,
    dismissed: u64,
}

impl Messages {
    pub fn push(&mut self, level: Level, text: impl Into<String>, detail: impl Into<String>) {
        self.count += 1;
        if self.kept.len() == KEPT {
            self.kept.pop_front();
        }
        let message = Message { number: self.count, level, text: text.into(), detail: detail.into() };
        self.kept.push_back(message);
    }

    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Message> + ExactSizeIterator {
        self.kept.iter()
    }

    /// The newest error that has not been dismissed.
    pub fn open_error(&self) -> Option<&Message> {
        self.kept.iter().rev().find(|m| m.level == Level::Error && m.number > self.dismissed)
    }

    /// The newest note, shown for a moment.
    pub fn last_note(&self) -> Option<&Message> {
        self.kept.iter().rev().find(|m| m.level == Level::Note)
    }

    /// Number of the newest message.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Closes the error box, for all errors so far.
    pub fn dismiss_errors(&mut self) {
        self.dismissed = self.count;
    }

    /// Closes the error box, for all errors up to that number.
    pub fn dismiss_errors_until(&mut self, number: u64) {
        self.dismissed = self.dismissed.max(number.min(self.count));
    }
}

/// One line of what happened in a step.
pub fn of_step(snapshot: &Snapshot) -> String {
    let parts: Vec<String> = snapshot
        .occurrences
        .iter()
        .map(|occurrence| match occurrence {
            Occurrence::Born { id, points } => format!("{id} was born with {points} points"),
            Occurrence::Died { id } => format!("{id} died"),
            Occurrence::Split { id, coverage } => {
                format!("{id} was split (coverage {:.0} %)", 100.0 * coverage)
            }
            Occurrence::Separated { id } => format!("{id} was cut to its largest part"),
            Occurrence::Cut { id, gain } => format!("{id} was cut (saves {gain:.4} mean spacings of error)"),
            Occurrence::Froze { id } => format!("{id} froze"),
            Occurrence::Merged(report) => {
                format!("{} and {} became {}", report.merged.0, report.merged.1, report.into)
            }
            Occurrence::Edited { id } => format!("{id} was given another shape"),
            Occurrence::Refitted { id } => format!("{id} was fitted again"),
            Occurrence::Locked { id } => format!("{id} was locked"),
            Occurrence::Unlocked { id } => format!("{id} was unlocked"),
            Occurrence::Joined { ids, into } => {
                let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
                format!("{} were made one, {into}", ids.join(", "))
            }
            Occurrence::Halved { id, into } => format!("{id} was cut in two, {id} and {into}"),
            Occurrence::Deleted { id, points } => format!("{id} was deleted ({points} points)"),
            Occurrence::Created { id, points } => format!("{id} was made of {points} points"),
            Occurrence::Pinned { id, points } => format!("{points} points were pinned to {id}"),
            Occurrence::Released { points } => format!("{points} points were released"),
        })
        .collect();
    let step = if snapshot.start.algorithm == Algorithm::Sampler { "Iteration" } else { "Step" };
    format!("{step} {}: {}", snapshot.abstraction.iteration, parts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_stays_until_dismissed_and_the_log_is_bounded() {
        let mut messages = Messages::default();
        messages.push(Level::Error, "first", "why");
        for i in 0..100 {
            messages.push(Level::Detail, format!("{i}"), "");
        }
        assert_eq!(messages.open_error().map(|m| m.text.as_str()), Some("first"));
        messages.dismiss_errors();
        assert_eq!(messages.open_error(), None);
        for i in 0..2 * KEPT {
            messages.push(Level::Note, format!("{i}"), "");
        }
        assert_eq!(messages.iter().len(), KEPT);
        assert_eq!(messages.last_note().map(|m| m.text.clone()), Some(format!("{}", 2 * KEPT - 1)));
    }
}
