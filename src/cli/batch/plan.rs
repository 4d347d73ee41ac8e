//! From the command line to the list of jobs, or the reason why not: nothing is
//! run before all of it makes sense.

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
    /// List of jobs, one a line: CSV with a header, or JSON lines
    ///
    /// The column input is the shape (relative to the list), name the folder of
    /// its results; any other is called like an option below (alpha, seed, …) and
    /// goes before what the command line says. An empty field says nothing.
    #[arg(long, value_name = "FILE", conflicts_with = "inputs")]
    manifest: Option<PathBuf>,
    /// Settings to try out, in all combinations: alpha=0.1,0.5 seed=1..5
    ///
    /// Each is called like an option below; both ends of a range belong to it.
    /// Results go to DIR/NAME/alpha=0.1,seed=1 and so on.
    #[arg(long, value_name = "KEY=VALUES", num_args = 1..)]
    sweep: Vec<Swept>,
    /// Number of jobs side by side [default: one a core]
    ///
    /// The cores are shared among them. The results are the same for any number.
    #[arg(long, value_name = "COUNT", value_parser = at_least_one)]
    jobs: Option<usize>,
    /// Take the shapes in folders below the given ones, too
    #[arg(short, long)]
    recursive: bool,
    /// Do every N-th job only, beginning with I, counted from 0; N machines share a list
    ///
    /// Each writes a table of its own, results.I-of-N.csv.
    #[arg(long, value_name = "I/N", conflicts_with = "lines")]
    shard: Option<Shard>,
    /// Do some jobs of the list only, counted from 1; both ends belong to it
    ///
    /// The header of a manifest doesn't count. The table is results.lines-A-to-B.csv.
    #[arg(long, value_name = "A..B")]
    lines: Option<Lines>,
    /// Do also those jobs again that are finished
    #[arg(long)]
    force: bool,
}

fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "it must be a whole number from 1".to_owned())
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
        return Err(format!("these are more than {MOST_JOBS} jobs; make several lists of them"));
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
            let problem = format!("{}, column {key}: --sweep has values for it, too", line.place);
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
                return Err(format!("two jobs would have the name {name}; give them names in a manifest"));
            }
            jobs.push(Job { number: jobs.len() + 1, name, input: line.input.clone(), sampling, params });
        }
    }
    let params: Vec<Params> = jobs.iter().map(|job| job.params).collect();
    if let Some(option) = settings.tuning.unread(&params) {
        return Err(format!("none of the methods reads {option}; leave it out"));
    }
    Ok(jobs)
}
