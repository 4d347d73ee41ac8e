//! The jobs of a batch are done.

use std::collections::HashSet;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, bail};

use super::fingerprint;
use super::job::Job;
use super::progress::{Line, Progress};
use super::rows::{self, Place, Row, Status, Tables};
use super::staging::{self, RECORD_FILE, StagingFolder, finished};
use super::tally::Tally;
use crate::cli::headless::primitives;
use crate::cli::interrupt::{INTERRUPTED, cancel_on_interrupt};
use crate::cli::job::Finished;
use crate::cli::output::{fail_by, say};
use crate::cli::runner::{End, run_all};
use crate::inference::Cancel;
use crate::io::{self, Inputs};
use crate::worker::Source;

/// A batch of jobs.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchJob {
    pub(super) jobs: Vec<Job>,
    /// How many jobs the whole list has.
    pub(super) listed: usize,
    /// Folder for the results.
    pub(super) output: PathBuf,
    /// Name of the tables, without the ending.
    pub(super) table: String,
    /// Jobs side by side.
    pub(super) workers: usize,
    /// Threads that they share.
    pub(super) cores: usize,
    /// Do again what is finished.
    pub(super) force: bool,
    pub(super) quiet: bool,
    /// More files for each job's folder, by their names.
    pub(super) exports: Vec<String>,
    /// The list that they came from.
    pub(super) manifest: Option<PathBuf>,
}

impl BatchJob {
    /// Does the jobs: progress goes to standard error, a summary to standard
    /// output. The exit status tells how many failed.
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

    /// How it went, and the path of the table; `None` if it was stopped while
    /// it waited for another.
    fn work(&self, cancel: &Cancel) -> anyhow::Result<Option<(Tally, PathBuf)>> {
        if self.output.exists() && !self.output.is_dir() {
            bail!("{} is not a folder; choose another one for the results", self.output.display());
        }
        self.check_outputs()?;
        if self.jobs.is_empty() && !self.quiet {
            say(&format!("nothing to do for this part of the list of {} jobs", self.listed));
        }
        let Some(staging) = StagingFolder::take(&self.output, &self.table, cancel)? else { return Ok(None) };

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
        let mut tables = Tables::start(Place::new(&self.output, &self.table, staging.folder()), &known)?;
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
                let row = one(job, &self.exports, &staging, cancel, line);
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

    /// Refuses to write over what is read, by whichever job.
    fn check_outputs(&self) -> anyhow::Result<()> {
        let mut inputs = Inputs::default();
        self.manifest.iter().chain(self.jobs.iter().map(|job| &job.input)).for_each(|path| inputs.add(path));
        inputs.check(rows::paths(&self.output, &self.table))?;
        for job in &self.jobs {
            let folder = self.output.join(&job.name);
            if folder.is_dir() {
                inputs.check(io::run_outputs(&folder, &self.exports))?;
                // What an earlier job has left there is cleared away.
                inputs.check(staging::made_before(&folder))?;
            }
        }
        Ok(())
    }

    /// The row of a job that was finished before, from the same input with the
    /// same settings by the same program.
    fn before(&self, job: &Job, inputs: &mut fingerprint::Inputs) -> Option<Row> {
        let (row, made_from) = finished(&self.output.join(&job.name))?;
        let content = inputs.content(&job.input)?;
        let wanted = fingerprint::of_job(&content, &job.sampling, &job.params, &self.exports).ok()?;
        (made_from == wanted).then(|| row.now_of(job))
    }

    /// Rows of the same table that other commands have made, if their results
    /// are still there.
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
fn one(
    job: &Job,
    exports: &[String],
    staging: &StagingFolder,
    cancel: &Cancel,
    line: &Line,
) -> anyhow::Result<Row> {
    let start = Instant::now();
    let place = staging.place(job.number).with_context(|| format!("cannot create files for {}", job.name))?;
    // Before it is read: if it changes in between, the next batch sees that.
    let content = fingerprint::content(&job.input);
    let finished =
        Finished::make(&Source::File(job.input.clone()), &[], job.sampling, job.params, cancel, |stage| {
            line.show(stage);
        })?;
    let content = content.with_context(|| format!("cannot read {}", job.input.display()))?;
    let made_from = fingerprint::of_job(&content, &job.sampling, &job.params, exports)?;
    let written = finished.write(&place, &staging.target(&job.name), exports)?;
    let row = Row::ok(job, &finished, &written.notes, start.elapsed().as_secs_f64());
    staging.publish(&place, &written.files, made_from, &row)?;
    Ok(row)
}
