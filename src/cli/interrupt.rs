//! Handles Ctrl-C, TERM and HUP: the first asks for an orderly stop, the second ends the program.

use std::process::ExitCode;

use super::output::{fail_by, print, say};
use crate::inference::{Cancel, InferenceError};

/// Exit status of a job that was stopped, as shells have it for Ctrl-C.
pub(super) const INTERRUPTED: u8 = 130;

/// A flag that is raised by Ctrl-C, by TERM (which clusters send before they
/// kill), and when the terminal is closed. The second time ends the program.
pub(super) fn cancel_on_interrupt() -> Cancel {
    let cancel = Cancel::default();
    let asked = cancel.clone();
    let listening = listen(move || {
        if asked.is_requested() {
            std::process::exit(i32::from(INTERRUPTED));
        }
        asked.request();
    });
    if let Err(e) = listening {
        tracing::warn!("Ctrl-C will end the program immediately: {e}");
    }
    cancel
}

/// Calls `act` whenever the program is asked to end.
#[cfg(unix)]
fn listen(act: impl Fn() + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    if !outlives_its_terminal() {
        signals.add_signal(SIGHUP)?;
    }
    let wait = move || signals.forever().for_each(|_| act());
    std::thread::Builder::new().name("signals".to_owned()).spawn(wait).map(drop)
}

/// Calls `act` whenever the program is asked to end.
#[cfg(not(unix))]
fn listen(act: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(act)
}

/// Whether the program is to go on when its terminal is closed, as `nohup` asks
/// for: HUP is ignored.
#[cfg(unix)]
fn outlives_its_terminal() -> bool {
    // Only there on Linux.
    let ignored = std::fs::read_to_string("/proc/self/status").ok().and_then(|text| {
        let mask = text.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    });
    // HUP is signal 1, the lowest bit.
    ignored.is_some_and(|mask| mask & 1 == 1)
}

/// Does a job that writes nothing unless it comes to its end: the text that it
/// gives goes to standard output.
pub(super) fn until_done_or_interrupted(work: impl FnOnce(&Cancel) -> anyhow::Result<String>) -> ExitCode {
    match work(&cancel_on_interrupt()) {
        Ok(text) => print(&text),
        Err(e) if matches!(e.downcast_ref(), Some(InferenceError::Cancelled)) => {
            say("stopped; nothing was written");
            ExitCode::from(INTERRUPTED)
        }
        Err(e) => fail_by(&e),
    }
}
