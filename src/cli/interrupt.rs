//! Ctrl-C: ask for an end, insist at the second time.

use std::io::Write as _;
use std::process::ExitCode;

use super::{fail, say};
use crate::inference::{Cancel, InferenceError};

/// Exit status of a job that was stopped by Ctrl-C, as shells have it.
pub(super) const INTERRUPTED: u8 = 130;

/// A flag that is raised by Ctrl-C. Pressed again, it ends the program.
pub(super) fn cancel_on_interrupt() -> Cancel {
    let cancel = Cancel::default();
    let asked = cancel.clone();
    let handler = ctrlc::set_handler(move || {
        if asked.is_requested() {
            std::process::exit(i32::from(INTERRUPTED));
        }
        asked.request();
    });
    if let Err(e) = handler {
        tracing::warn!("Ctrl-C will end the program at once: {e}");
    }
    cancel
}

/// Does a job that writes nothing unless it comes to its end: the text that it
/// gives goes to standard output.
pub(super) fn until_done_or_interrupted(work: impl FnOnce(&Cancel) -> anyhow::Result<String>) -> ExitCode {
    match work(&cancel_on_interrupt()) {
        Ok(text) => {
            // A closed pipe is no reason to call the job a failure.
            let _ = write!(std::io::stdout(), "{text}");
            ExitCode::SUCCESS
        }
        Err(e) if matches!(e.downcast_ref(), Some(InferenceError::Cancelled)) => {
            say("stopped; nothing was written");
            ExitCode::from(INTERRUPTED)
        }
        Err(e) => fail(&format!("{e:#}")),
    }
}
