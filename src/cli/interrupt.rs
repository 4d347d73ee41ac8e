//! Ctrl-C: ask for an end, insist at the second time.

use crate::inference::Cancel;

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
