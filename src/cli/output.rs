//! Output of the program: results on standard output, everything else on standard error.

use std::io::{self as stdio, Write as _};
use std::process::ExitCode;

use anyhow::Context as _;

use crate::io::{self, WriteError};

const LOST: &str = "cannot write to standard output";

/// Prints what a job gave. It failed if that got lost.
pub(super) fn print(text: &str) -> ExitCode {
    tell(text).map_or_else(|e| fail_by(&e), |()| ExitCode::SUCCESS)
}

/// Prints what a job has to say on its way.
///
/// # Errors
/// Where that got lost: a job with more to do had better stop.
pub(super) fn tell(text: &str) -> anyhow::Result<()> {
    io::print(harmless(text).as_bytes()).context(LOST)
}

/// The exit status of what was printed.
pub(super) fn arrived(printed: stdio::Result<()>) -> ExitCode {
    match printed {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => fail_by(&anyhow::Error::new(e).context(LOST)),
    }
}

/// Says what went wrong in the job. If only nobody reads on (as behind `| head`),
/// that is no news.
pub(super) fn fail_by(error: &anyhow::Error) -> ExitCode {
    if is_closed_pipe(error) { ExitCode::FAILURE } else { fail(&format!("{error:#}")) }
}

/// Whether nobody reads any more what was to be written.
pub(super) fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let closed = |e: &stdio::Error| e.kind() == stdio::ErrorKind::BrokenPipe;
        cause.downcast_ref().is_some_and(closed)
            || cause.downcast_ref().is_some_and(WriteError::is_closed_pipe)
    })
}

/// Says what went wrong in the job.
pub fn fail(problem: &str) -> ExitCode {
    say(problem);
    ExitCode::FAILURE
}

/// One line for the person at the terminal. If standard error is closed there
/// is nobody to tell.
pub(super) fn say(line: &str) {
    let _ = writeln!(stdio::stderr(), "superform: {}", harmless(line));
}

/// The text without what would steer a terminal: names of files may hold any
/// character.
fn harmless(text: &str) -> String {
    let lines =
        text.split('\n').map(|line| line.split('\t').map(io::harmless).collect::<Vec<_>>().join("\t"));
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_steer_the_terminal() {
        assert_eq!(harmless("a\u{1b}[31mü\r\n\t\u{9b}2J"), "a\\u{1b}[31mü\\r\n\t\\u{9b}2J");
    }
}
