//! From the command line to a list of jobs. Everything is validated before the first job runs.

use std::collections::HashSet;
use std::path::PathBuf;

use clap::Args;

use super::inputs::expand;
use super::job::Job;
use super::manifest::{self, Line};
use super::names::{Origin, names, safe};
use super::sweep::{Lines, Part, Shard, Sweep, Swept, shown};
use super::work::BatchJob;
use crate::cli::settings::SettingsArgs;
use crate::inference::Params;

/// Most jobs of one list.
const MOST_JOBS: usize = 1_000_000;

#[derive(Debug, Args)]
#[command(next_help_heading = "Many shapes")]
pub(in crate::cli) struct BatchArgs {
    /// List of jobs, one per line: CSV with a header, or JSON lines
    ///
    /// Columns: input is the shape (relative to the list), name the folder of its results, and any
    /// other column an option below (alpha, seed, …), which overrides the command line. Empty
    /// fields are ignored.
    #[arg(long, value_name = "FILE", conflicts_with = "inputs")]
    manifest: Option<PathBuf>,
    /// Settings to run in all combinations: alpha=0.1,0.5 seed=1..5
    ///
    /// Keys are the names of the options below; ranges are inclusive. Results go to
    /// DIR/NAME/alpha=0.1,seed=1 and so on.
    #[arg(long, value_name = "KEY=VALUES", num_args = 1..)]
    sweep: Vec<Swept>,
    /// Number of parallel jobs [default: one per core]
    ///
    /// The jobs share all cores. Results do not depend on this number.
    #[arg(long, value_name = "COUNT", value_parser = at_least_one)]
    jobs: Option<usize>,
    /// Include shapes in subfolders
    #[arg(short, long)]
    recursive: bool,
    /// Run only every N-th job, starting with I, counted from 0; for sharing a list among N
    /// machines
    ///
    /// Each machine writes its own table, results.I-of-N.csv.
    #[arg(long, value_name = "I/N", conflicts_with = "lines")]
    shard: Option<Shard>,
    /// Run only these jobs of the list, counted from 1, inclusive
    ///
    /// The header of a manifest is not counted. The table is results.lines-A-to-B.csv.
    #[arg(long, value_name = "A..B")]
    lines: Option<Lines>,
    /// Run finished jobs again
    #[arg(long)]
    force: bool,
}

fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "expected a whole number from 1".to_owned())
}

impl BatchArgs {
    /// Whether something was asked for that makes even one input a batch.
    pub(in crate::cli) fn is_wanted(&self) -> bool {
        self.manifest.is_some() || !self.sweep.is_empty() || self.shard.is_some() || self.lines.is_some()
    }

    /// The jobs, all settings within their limits.
    pub(in crate::cli) fn resolve(
        self,
        given: &[PathBuf],
        output: PathBuf,
        exports: Vec<String>,
        settings: &SettingsArgs,
        quiet: bool,
    ) -> Result<BatchJob, String> {
        let lines = match &self.manifest {
            Some(path) => manifest::read(path)?,
            None => expand(given, self.recursive, &output)?.into_iter().map(Line::of).collect(),
        };
        let sweep = Sweep::new(self.sweep)?;
        let part = match (self.shard, self.lines) {
            (Some(shard), _) => Part::Shard(shard),
            (None, Some(lines)) => Part::Lines(lines),
            (None, None) => Part::All,
        };
        let mut jobs = list(&lines, &sweep, settings)?;
        let listed = jobs.len();
        let mut index = 0..;
        jobs.retain(|_| index.next().is_some_and(|index| part.has(index)));
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let workers = self.jobs.unwrap_or(cores);
        let (table, force) = (part.table(), self.force);
        let manifest = self.manifest;
        Ok(BatchJob { jobs, listed, output, table, workers, cores, force, quiet, exports, manifest })
    }
}

/// All jobs: each line with each combination of what is swept.
fn list(lines: &[Line], sweep: &Sweep, settings: &SettingsArgs) -> Result<Vec<Job>, String> {
    settings.applied()?;
    if lines.len().saturating_mul(sweep.len()) > MOST_JOBS {
        return Err(format!("more than {MOST_JOBS} jobs; split them into several lists"));
    }
    let origins: Vec<Origin<'_>> = lines
        .iter()
        .map(|line| Origin {
            input: &line.input,
            given: line.name.as_deref(),
            settings: shown(line.settings.iter().map(|(key, value)| (*key, value.as_str()))),
        })
        .collect();
    let mut jobs = Vec::new();
    let mut used = HashSet::new();
    for (line, base) in lines.iter().zip(names(&origins)) {
        if let Some(key) = sweep.keys().find(|key| line.settings.iter().any(|(own, _)| own == key)) {
            let problem = format!("{}, column {key}: --sweep also sets {key}", line.place);
            return Err(problem);
        }
        for combination in sweep.combinations() {
            let own = line.settings.iter().map(|(key, value)| (*key, value.as_str()));
            let changes: Vec<(&'static str, &str)> = own.chain(combination.iter().copied()).collect();
            let (sampling, params) = settings.changed(&changes).map_err(|bad| {
                let key = changes.get(bad.at).map_or("", |(key, _)| key);
                if bad.at < line.settings.len() {
                    format!("{}, column {key}: {}", line.place, bad.problem)
                } else {
                    format!("--sweep {key}: {}", bad.problem)
                }
            })?;
            let name = match combination.is_empty() {
                true => base.clone(),
                false => format!("{base}/{}", safe(&shown(combination))),
            };
            if !used.insert(name.to_lowercase()) {
                return Err(format!("two jobs would have the name {name}; set their names in a manifest"));
            }
            jobs.push(Job { number: jobs.len() + 1, name, input: line.input.clone(), sampling, params });
        }
    }
    let params: Vec<Params> = jobs.iter().map(|job| job.params).collect();
    if let Some(option) = settings.tuning.unread(&params) {
        return Err(format!("none of the methods uses {option}; remove it"));
    }
    Ok(jobs)
}
