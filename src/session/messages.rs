//! Messages: the log, and the error currently shown.

use std::collections::VecDeque;
use std::time::Instant;

use super::action::{Level, Message};
use crate::inference::Occurrence;
use crate::io::harmless;
use crate::worker::Snapshot;

/// Number of messages kept; older ones are dropped.
const KEPT: usize = 1000;

/// The log, oldest first.
#[derive(Debug, Clone)]
pub struct Messages {
    begun: Instant,
    kept: VecDeque<Message>,
    count: u64,
    dismissed: u64,
}

impl Default for Messages {
    fn default() -> Self {
        Self { begun: Instant::now(), kept: VecDeque::new(), count: 0, dismissed: 0 }
    }
}

impl Messages {
    pub fn push(&mut self, level: Level, what: impl Into<String>, why: impl Into<String>) {
        self.add(Message::new(level, what).because(why));
    }

    /// Adds a message. File names in it may contain any character.
    pub fn add(&mut self, mut message: Message) {
        let Message { what, why, advice, chain, .. } = &mut message;
        for text in [what, why, advice].into_iter().chain(chain) {
            *text = harmless(text).into_owned();
        }
        self.count += 1;
        if self.kept.len() == KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back(Message { number: self.count, at: self.begun.elapsed(), ..message });
    }

    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Message> + ExactSizeIterator {
        self.kept.iter()
    }

    /// Messages after the one with this number, oldest first.
    pub fn since(&self, number: u64) -> impl Iterator<Item = &Message> {
        let first = self.kept.partition_point(|message| message.number <= number);
        self.kept.range(first..)
    }

    /// The message with this number, if it is still kept.
    pub fn get(&self, number: u64) -> Option<&Message> {
        self.since(number.checked_sub(1)?).next().filter(|message| message.number == number)
    }

    /// The newest error that has not been dismissed.
    pub fn open_error(&self) -> Option<&Message> {
        self.kept.iter().rev().find(|m| m.level == Level::Error && m.number > self.dismissed)
    }

    /// Number of the newest message.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Dismisses all errors so far.
    pub fn dismiss_errors(&mut self) {
        self.dismissed = self.count;
    }

    /// Dismisses all errors up to this number.
    pub fn dismiss_errors_until(&mut self, number: u64) {
        self.dismissed = self.dismissed.max(number.min(self.count));
    }

    /// Clears the log and dismisses open errors.
    pub fn clear(&mut self) {
        self.kept.clear();
        self.dismiss_errors();
    }
}

/// The events that led to a state, in one line; `None` if there were none.
pub fn of_step(snapshot: &Snapshot) -> Option<String> {
    let parts: Vec<String> = snapshot
        .occurrences
        .iter()
        .map(|occurrence| match occurrence {
            Occurrence::Born { id, points } => format!("{id} born with {points} points"),
            Occurrence::Died { id } => format!("{id} died"),
            Occurrence::Split { id, coverage } => {
                format!("{id} split (coverage {:.0} %)", 100.0 * coverage)
            }
            Occurrence::Separated { id } => format!("{id} reduced to its largest part"),
            Occurrence::Cut { id, gain } => format!("{id} cut (error reduced by {gain:.4} mean spacings)"),
            Occurrence::Froze { id } => format!("{id} frozen"),
            Occurrence::Merged(report) => {
                format!("{} and {} merged into {}", report.merged.0, report.merged.1, report.into)
            }
            Occurrence::Edited { id } => format!("{id} reshaped"),
            Occurrence::Refitted { id } => format!("{id} refitted"),
            Occurrence::Locked { id } => format!("{id} locked"),
            Occurrence::Unlocked { id } => format!("{id} unlocked"),
            Occurrence::Joined { ids, into } => {
                let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
                format!("{} merged into {into}", ids.join(", "))
            }
            Occurrence::Halved { id, into } => format!("{id} split into {id} and {into}"),
            Occurrence::Deleted { id, points } => format!("{id} deleted ({points} points)"),
            Occurrence::Taken { primitives } => format!("{primitives} imported"),
            Occurrence::Created { id, points } => format!("{id} created from {points} points"),
            Occurrence::Pinned { id, points } => format!("{points} points pinned to {id}"),
            Occurrence::Released { points } => format!("{points} points unpinned"),
        })
        .collect();
    (!parts.is_empty()).then(|| parts.join(", "))
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
        assert_eq!(messages.open_error().map(|m| m.what.as_str()), Some("first"));
        messages.dismiss_errors();
        assert_eq!(messages.open_error(), None);
        for i in 0..2 * KEPT {
            messages.push(Level::Note, format!("{i}"), "");
        }
        assert_eq!(messages.iter().len(), KEPT);
        let last = messages.iter().next_back().map(|m| m.what.clone());
        assert_eq!(last, Some(format!("{}", 2 * KEPT - 1)));
        let first = messages.iter().next().map_or(0, |m| m.number);
        assert_eq!(messages.get(first).map(|m| m.number), Some(first));
        assert_eq!(messages.get(first - 1), None, "it was dropped");
        assert_eq!(messages.since(messages.count() - 3).count(), 3);
        messages.clear();
        assert!(messages.iter().len() == 0 && messages.since(0).next().is_none());
        messages.push(Level::Note, "next", "");
        assert_eq!(messages.get(messages.count()).map(|m| m.what.as_str()), Some("next"));
        messages.push(Level::Note, "a\u{1b}[2J\nb.ply", "");
        assert_eq!(messages.get(messages.count()).map(|m| m.what.as_str()), Some("a\\u{1b}[2J\\nb.ply"));
    }
}
