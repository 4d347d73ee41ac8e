//! Collects logged warnings and errors for the window's log.

use std::fmt::Write as _;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::Context;

/// Records that may wait for the window; more are only on standard error.
const CAPACITY: usize = 256;

/// Something that was logged.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Record {
    /// Otherwise it is a warning.
    pub is_error: bool,
    pub text: String,
}

/// The reading end.
#[derive(Debug)]
pub struct Journal(Receiver<Record>);

impl Journal {
    /// A journal, and the layer of the log that writes it.
    pub fn new() -> (Self, JournalLayer) {
        let (sender, receiver) = sync_channel(CAPACITY);
        (Self(receiver), JournalLayer(sender))
    }

    /// What was logged since the last call.
    pub fn records(&self) -> impl Iterator<Item = Record> + '_ {
        self.0.try_iter()
    }
}

/// The writing end: takes this program's warnings and errors.
#[derive(Debug)]
pub struct JournalLayer(SyncSender<Record>);

impl<S: Subscriber> Layer<S> for JournalLayer {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let about = event.metadata();
        let level = *about.level();
        let root = about.target().split("::").next();
        if level > Level::WARN || root != Some(env!("CARGO_CRATE_NAME")) {
            return;
        }
        let mut text = Text::default();
        event.record(&mut text);
        // If the journal is full or gone, standard error still has it.
        let _ = self.0.try_send(Record { is_error: level == Level::ERROR, text: text.0 });
    }
}

/// The message and the fields of an event.
#[derive(Debug, Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        // Writing to a string doesn't fail.
        let _ = if field.name() == "message" {
            write!(self.0, "{value:?}")
        } else {
            write!(self.0, "{}{}: {value:?}", if self.0.is_empty() { "" } else { ", " }, field.name())
        };
    }
}

#[cfg(test)]
mod tests {
    use tracing_subscriber::layer::SubscriberExt as _;

    use super::*;

    #[test]
    fn warnings_and_errors_arrive_and_nothing_else() {
        let (journal, layer) = Journal::new();
        tracing::subscriber::with_default(tracing_subscriber::registry().with(layer), || {
            tracing::info!("not this");
            tracing::warn!(file = "a.ply", "no room");
            tracing::error!("broken");
            tracing::warn!(target: "another_crate", "nor this");
        });
        let records: Vec<Record> = journal.records().collect();
        assert_eq!(
            records,
            [
                Record { is_error: false, text: "no room, file: \"a.ply\"".to_owned() },
                Record { is_error: true, text: "broken".to_owned() },
            ]
        );
        assert!(journal.records().next().is_none());
    }
}
