//! Batches: many shapes or many settings, one job each, some in parallel.
//!
//! The files of a job appear in its folder together, with a record of what they were made from. An
//! interrupted batch therefore resumes where it stopped: finished jobs are skipped, and incomplete
//! output never counts as finished. The tables are built from the records.

mod desk;
pub(super) mod fingerprint;
mod inputs;
mod manifest;
mod merge;
mod names;
mod plan;
mod progress;
mod rows;
mod runner;
mod sweep;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, bail};

use self::desk::{Desk, finished};
use self::progress::{Line, Progress};
use self::rows::{Place, Row, Status, Tables};
use self::runner::{End, run_all};
use super::headless::primitives;
use super::interrupt::{INTERRUPTED, cancel_on_interrupt};
use super::job::Finished;
use super::{fail_by, print, say};
use crate::geometry::SamplingOptions;
use crate::inference::{Cancel, Params};
use crate::io::{self, Inputs};
use crate::worker::Source;

pub(super) use self::inputs::is_one_file;
pub use self::merge::MergeJob;
pub(super) use self::plan::BatchArgs;

/// The record of a finished job, in its folder.
const RECORD_FILE: &str = "job.json";

/// Staging folder in the output, removed when the batch is done.
const HIDDEN_FOLDER: &str = ".superform";

/// Exit status of a batch with one failed job; each further adds one.
const FIRST_FAILURE: usize = 11;
const MOST_FAILURES: usize = 100;

/// Maximum number of failed jobs listed at the end; the tables contain all.
const MOST_LISTED: usize = 20;

/// One job: input, settings and name.
#[derive(Debug, Clone, PartialEq)]
struct Job {
    /// Its number in the whole list, from 1.
    number: usize,
    /// Path of its folder in the output, with `/`.
    name: String,
    input: PathBuf,
    sampling: SamplingOptions,
    params: Params,
}

/// A batch of jobs.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchJob {
    jobs: Vec<Job>,
    /// Number of jobs in the whole list.
    listed: usize,
    /// Folder for the results.
    output: PathBuf,
    /// Name of the tables, without the ending.
    table: String,
    /// Number of parallel jobs.
    workers: usize,
    /// Number of threads they share.
    cores: usize,
    /// Run finished jobs again.
    force: bool,
    quiet: bool,
    /// Further files for each job's folder, by name.
    exports: Vec<String>,
    /// The manifest they came from.
    manifest: Option<PathBuf>,
}

/// Exit status for this number of failures.
pub(super) fn failures(failed: usize) -> ExitCode {
    match failed {
        0 => ExitCode::SUCCESS,
        failed => ExitCode::from((FIRST_FAILURE - 1 + failed.min(MOST_FAILURES)) as u8),
    }
}

/// Outcome of a batch.
#[derive(Debug, Default)]
struct Tally {
    /// Finished, including by an earlier batch.
    ok: usize,
    before: usize,
    /// Name and problem.
    failed: Vec<(String, String)>,
    cancelled: usize,
}

impl Tally {
    fn of<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Self {
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

    /// Prints the summary and the failed jobs. The exit status gives their number.
    fn conclude(&self, summary: &str) -> ExitCode {
        let arrived = print(summary);
        for (name, problem) in self.failed.iter().take(MOST_LISTED) {
            say(&format!("{name}: {problem}"));
        }
        if self.failed.len() > MOST_LISTED {
            say(&format!("and {} more; see the table", self.failed.len() - MOST_LISTED));
        }
        if self.failed.is_empty() { arrived } else { failures(self.failed.len()) }
    }

    /// "12 jobs: 10 done, 4 of them earlier; 2 failed".
    fn summary(&self) -> String {
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

impl BatchJob {
    /// Runs the jobs, with progress on standard error and a summary on standard output. The exit status gives the number of failed jobs.
    pub fn run(&self) -> ExitCode {
        let cancel = cancel_on_interrupt();
        match self.work(&cancel) {
            Ok(None) => {
                say("stopped before anything was started");
                ExitCode::from(INTERRUPTED)
            }
            Ok(Some((tally, table))) => {
                let summary = format!("{}, results in {}", tally.summary(), table.display());
                if tally.cancelled > 0 {
                    say(&format!("stopped: {summary}; repeat the command to resume"));
                    return ExitCode::from(INTERRUPTED);
                }
                tally.conclude(&if self.quiet { String::new() } else { summary + "\n" })
            }
            Err(e) => fail_by(&e),
        }
    }

    /// Outcome, and path of the table; `None` if stopped while waiting for another batch.
    fn work(&self, cancel: &Cancel) -> anyhow::Result<Option<(Tally, PathBuf)>> {
        if self.output.exists() && !self.output.is_dir() {
            bail!("{} is not a folder; choose another one for the results", self.output.display());
        }
        self.check_outputs()?;
        if self.jobs.is_empty() && !self.quiet {
            say(&format!("nothing to do for this part of the list of {} jobs", self.listed));
        }
        let Some(desk) = Desk::take(&self.output, &self.table, cancel)? else { return Ok(None) };

        let mut inputs = fingerprint::Inputs::default();
        let mut rows: Vec<Option<Row>> = Vec::with_capacity(self.jobs.len());
        for job in &self.jobs {
            if cancel.is_requested() {
                return Ok(None);
            }
            rows.push(if self.force { None } else { self.before(job, &mut inputs) });
        }
        let others = self.others();
        let known: Vec<Row> = rows.iter().flatten().chain(&others).cloned().collect();
        let mut tables = Tables::start(Place::new(&self.output, &self.table, desk.folder()), &known)?;
        let open: Vec<usize> = (0..rows.len()).filter(|&at| rows[at].is_none()).collect();
        let before = rows.len() - open.len();
        if before > 0 && !self.quiet {
            say(&format!("{before} of {} jobs were already done", rows.len()));
        }

        let workers = self.workers.clamp(1, open.len().max(1));
        let threads = (self.cores / workers).max(1);
        let mut progress = Progress::new(rows.len(), before, workers, self.quiet);
        let lines: Vec<Line> = (0..workers).map(|worker| progress.line(worker)).collect();
        let mut failed = 0;
        run_all(
            open.len(),
            (workers, threads),
            cancel,
            |worker, at| {
                let line = &lines[worker];
                let job = &self.jobs[open[at]];
                line.begin(&job.name);
                let row = one(job, &self.exports, &desk, cancel, line);
                line.end();
                row
            },
            |at, end| {
                let job = &self.jobs[open[at]];
                let (row, how) = match end {
                    End::Done(row) => {
                        let found = primitives(row.primitives.unwrap_or_default());
                        let how = format!("{found}, {:.1} s", row.seconds.unwrap_or_default());
                        (row, how)
                    }
                    End::Failed(problem) => {
                        failed += 1;
                        let how = format!("failed: {problem}");
                        (Row::failed(job, problem), how)
                    }
                    // Told with those that were not begun.
                    End::Cancelled => return Ok(()),
                };
                tables.add(&row)?;
                progress.ended(&job.name, &how, failed);
                rows[open[at]] = Some(row);
                Ok(())
            },
        )?;
        progress.finish();
        let rows: Vec<Row> = rows
            .into_iter()
            .zip(&self.jobs)
            .map(|(row, job)| row.unwrap_or_else(|| Row::cancelled(job)))
            .collect();
        let tally = Tally { before, ..Tally::of(&rows) };
        let all: Vec<Row> = rows.into_iter().chain(others).collect();
        let table = tables.finish(&all)?;
        Ok(Some((tally, table)))
    }

    /// Fails if any output would overwrite the input of any job.
    fn check_outputs(&self) -> anyhow::Result<()> {
        let mut inputs = Inputs::default();
        self.manifest.iter().chain(self.jobs.iter().map(|job| &job.input)).for_each(|path| inputs.add(path));
        inputs.check(rows::paths(&self.output, &self.table))?;
        for job in &self.jobs {
            let folder = self.output.join(&job.name);
            if folder.is_dir() {
                inputs.check(io::run_outputs(&folder, &self.exports))?;
                // What an earlier job has left there is cleared away.
                inputs.check(desk::made_before(&folder))?;
            }
        }
        Ok(())
    }

    /// The row of a job already finished from the same input, settings and program version.
    fn before(&self, job: &Job, inputs: &mut fingerprint::Inputs) -> Option<Row> {
        let (row, made_from) = finished(&self.output.join(&job.name))?;
        let content = inputs.content(&job.input)?;
        let wanted = fingerprint::of_job(&content, &job.sampling, &job.params, &self.exports).ok()?;
        (made_from == wanted).then(|| row.now_of(job))
    }

    /// Rows of the same table from other commands, if their results still exist.
    fn others(&self) -> Vec<Row> {
        let ours: HashSet<&str> = self.jobs.iter().map(|job| job.name.as_str()).collect();
        let is_there = |row: &Row| self.output.join(&row.name).join(RECORD_FILE).is_file();
        rows::earlier(&self.output, &self.table)
            .into_iter()
            .filter(|row| row.status == Status::Ok && !ours.contains(row.name.as_str()) && is_there(row))
            .collect()
    }
}

/// Runs one job; its files are in place on return.
fn one(job: &Job, exports: &[String], desk: &Desk, cancel: &Cancel, line: &Line) -> anyhow::Result<Row> {
    let start = Instant::now();
    let place = desk.place(job.number).with_context(|| format!("cannot create files for {}", job.name))?;
    // Before it is read: if it changes in between, the next batch sees that.
    let content = fingerprint::content(&job.input);
    let finished =
        Finished::make(&Source::File(job.input.clone()), job.sampling, job.params, cancel, |stage| {
            line.show(stage);
        })?;
    let content = content.with_context(|| format!("cannot read {}", job.input.display()))?;
    let made_from = fingerprint::of_job(&content, &job.sampling, &job.params, exports)?;
    let written = finished.write(&place, &desk.target(&job.name), exports)?;
    let row = Row::ok(job, &finished, &written.notes, start.elapsed().as_secs_f64());
    desk.publish(&place, &written.files, made_from, &row)?;
    Ok(row)
}

/// What a folder is asked for that results are to be merged in.
fn must_be_folder(path: &Path) -> anyhow::Result<()> {
    if !path.is_dir() {
        bail!("{} is not a folder; give the output folder of the runs", path.display());
    }
    Ok(())
}
