//! How a batch went, and the exit status that tells it.

use std::process::ExitCode;

use super::rows::{Row, Status};
use crate::cli::output::{print, say};

/// Exit status of a batch with one failed job; each further adds one.
const FIRST_FAILURE: usize = 11;
const MOST_FAILURES: usize = 100;

/// Maximum number of failed jobs listed at the end; the tables contain all.
const MOST_LISTED: usize = 20;

/// Exit status for this number of failures.
pub(in crate::cli) fn failures(failed: usize) -> ExitCode {
    match failed {
        0 => ExitCode::SUCCESS,
        failed => ExitCode::from((FIRST_FAILURE - 1 + failed.min(MOST_FAILURES)) as u8),
    }
}

/// Outcome of a batch.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Finished, also by an earlier batch.
    pub(super) ok: usize,
    pub(super) before: usize,
    /// Name and problem.
    pub(super) failed: Vec<(String, String)>,
    pub(super) cancelled: usize,
}

impl Tally {
    pub(super) fn of<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Self {
        let mut tally = Self::default();
        for row in rows {
            match row.status {
                Status::Ok => tally.ok += 1,
                Status::Failed => tally.failed.push((row.name.clone(), row.message.clone())),
                Status::Cancelled => tally.cancelled += 1,
            }
        }
        tally
    }

    /// Prints how it went and says which jobs failed; the exit status tells how
    /// many.
    pub(super) fn conclude(&self, summary: &str) -> ExitCode {
        let arrived = print(summary);
        for (name, problem) in self.failed.iter().take(MOST_LISTED) {
            say(&format!("{name}: {problem}"));
        }
        if self.failed.len() > MOST_LISTED {
            say(&format!("and {} more; see the table", self.failed.len() - MOST_LISTED));
        }
        if self.failed.is_empty() { arrived } else { failures(self.failed.len()) }
    }

    /// "12 jobs: 10 done, 4 of them before; 2 failed".
    pub(super) fn summary(&self) -> String {
        let all = self.ok + self.failed.len() + self.cancelled;
        let mut text = format!("{all} {}: {} done", if all == 1 { "job" } else { "jobs" }, self.ok);
        if self.before > 0 {
            text += &format!(", {} of them earlier", self.before);
        }
        if !self.failed.is_empty() {
            text += &format!("; {} failed", self.failed.len());
        }
        if self.cancelled > 0 {
            text += &format!("; {} not done", self.cancelled);
        }
        text
    }
}
