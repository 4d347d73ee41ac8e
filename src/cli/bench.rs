//! Measures methods on many shapes: shape × method × seed.
//!
//! Each run uses one core; several run in parallel. Finished runs are stored immediately, so that
//! an interrupted benchmark can resume.

mod output;
mod runner;
mod scaling;
mod shapes;
mod store;
mod table;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;
use std::thread;

use anyhow::Context;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use self::runner::{Task, run_all};
use self::shapes::BenchShape;
use self::store::{Row, Store};
use self::table::Table;
use super::batch::fingerprint::fingerprint;
use super::interrupt::{INTERRUPTED, cancel_on_interrupt};
use super::settings::{TuningArgs, methods};
use super::{MeasureArgs, Request, fail, fail_by, folder_for_results, print, say};
use crate::geometry::SamplingOptions;
use crate::geometry::metrics::MetricOptions;
use crate::inference::{Cancel, Method, Params};
use crate::io::{self, Inputs};

pub use self::scaling::ScalingJob;

/// Files in the folder of a benchmark.
const RUNS_FILE: &str = "runs.jsonl";
const MARKDOWN_FILE: &str = "table.md";
const CSV_FILE: &str = "table.csv";
const JSON_FILE: &str = "table.json";

/// Most runs of one benchmark with the same shape and method.
const MOST_SEEDS: u64 = 1000;

#[derive(Debug, Args)]
pub(super) struct BenchArgs {
    /// Shapes, folders of shapes or lists (CSV with columns name, cloud and reference)
    ///
    /// Paths are relative to the list. An empty reference means the cloud itself.
    #[arg(required_unless_present = "scaling")]
    shapes: Vec<PathBuf>,
    /// Methods to compare
    #[arg(long, value_delimiter = ',', default_value = "default", value_name = "A,B,…", value_parser = methods())]
    methods: Vec<Method>,
    /// Seeds for each method and shape: numbers and inclusive ranges
    #[arg(long, default_value = "1..3", value_name = "A..B,C,…")]
    seeds: Seeds,
    /// Folder for the results; an interrupted benchmark resumes from it
    #[arg(short, long, value_name = "DIR", default_value = "superform-bench")]
    output: PathBuf,
    /// List of references, by name, for shapes that are not given in a list
    #[arg(long, value_name = "CSV", conflicts_with = "scaling")]
    reference_list: Option<PathBuf>,
    /// Compare with another program's results: columns name, primitives, chamfer_l1 and iou
    #[arg(long, value_name = "CSV", conflicts_with = "scaling")]
    compare: Option<PathBuf>,
    /// Number of parallel runs [default: one per core]
    #[arg(long, value_name = "N", conflicts_with = "scaling")]
    jobs: Option<usize>,
    #[command(flatten)]
    measure: MeasureArgs,
    #[command(flatten)]
    scaling: scaling::ScalingArgs,
    #[command(next_help_heading = "Settings, for all methods that use them")]
    #[command(flatten)]
    tuning: TuningArgs,
}

/// Seeds as in `1..3,7`: both ends of a range belong to it.
#[derive(Debug, Clone, PartialEq)]
struct Seeds(Vec<u64>);

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |t: &str| t.trim().parse::<u64>().map_err(|_| format!("“{t}” is not a whole number"));
        let mut seeds = Vec::new();
        for part in text.split(',') {
            match part.split_once("..") {
                None => seeds.push(number(part)?),
                Some((from, to)) => {
                    let (from, to) = (number(from)?, number(to)?);
                    if from > to || to - from >= MOST_SEEDS {
                        return Err(format!("“{part}” is not a range of 1 to {MOST_SEEDS} seeds"));
                    }
                    seeds.extend(from..=to);
                }
            }
        }
        seeds.sort_unstable();
        seeds.dedup();
        Ok(Self(seeds))
    }
}

/// A benchmark to make.
#[derive(Debug, Clone)]
pub struct BenchJob {
    shapes: Vec<PathBuf>,
    reference_list: Option<PathBuf>,
    /// Each with its parameters.
    methods: Vec<(Method, Params)>,
    seeds: Vec<u64>,
    points: usize,
    metrics: MetricOptions,
    output: PathBuf,
    compare: Option<PathBuf>,
    jobs: usize,
    /// How the program was called, for the table's reader.
    command: String,
}

impl BenchArgs {
    /// The job, with all settings within their limits.
    pub(super) fn resolve(self) -> Result<Request, String> {
        let sampling = self.tuning.sampling()?;
        let mut methods: Vec<(Method, Params)> = Vec::new();
        for method in self.methods {
            if !methods.iter().any(|(m, _)| *m == method) {
                methods.push((method, self.tuning.params(method)?));
            }
        }
        let params: Vec<Params> = methods.iter().map(|(_, params)| *params).collect();
        if let Some(option) = self.tuning.unread(&params) {
            return Err(format!("none of the methods uses {option}; remove it"));
        }
        let args = std::env::args_os().skip(1);
        let command = args.fold("superform".to_owned(), |all, arg| all + " " + &arg.to_string_lossy());
        folder_for_results(&self.output)?;
        if self.scaling.is_wanted() {
            let job =
                self.scaling.resolve(self.shapes, &methods, self.seeds.0, sampling, self.output, command)?;
            return Ok(Request::Scaling(job));
        }
        let cores = thread::available_parallelism().map_or(1, usize::from);
        Ok(Request::Bench(BenchJob {
            shapes: self.shapes,
            reference_list: self.reference_list,
            methods,
            seeds: self.seeds.0,
            points: sampling.points,
            metrics: self.measure.resolve(MetricOptions::default().seed)?,
            output: self.output,
            compare: self.compare,
            jobs: self.jobs.unwrap_or(cores).max(1),
            command,
        }))
    }
}

/// A run that gave no figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Failure {
    shape: String,
    method: String,
    seed: u64,
    problem: String,
}

impl BenchJob {
    /// Does the job: the table goes to standard output and, with more detail,
    /// to files. Exit status 1 if any run failed; the others count all the
    /// same.
    pub fn run(&self) -> ExitCode {
        let cancel = cancel_on_interrupt();
        match self.work(&cancel) {
            Ok(None) => {
                say(&format!(
                    "stopped; repeat the command to resume from the results in {}",
                    self.output.display()
                ));
                ExitCode::from(INTERRUPTED)
            }
            Ok(Some((text, failures))) => {
                let exit = print(&text);
                match failures {
                    0 => exit,
                    1 => fail("one run failed and is missing from the table"),
                    n => fail(&format!("{n} runs failed and are missing from the table")),
                }
            }
            Err(e) => fail_by(&e),
        }
    }

    /// The table as text and the number of failed runs; `None` if stopped.
    fn work(&self, cancel: &Cancel) -> anyhow::Result<Option<(String, usize)>> {
        let others = self.compare.as_deref().map(table::read_others).transpose()?;
        let shapes = shapes::find(&self.shapes, self.reference_list.as_deref())?;
        let mut inputs = Inputs::default();
        let lists = self.shapes.iter().chain(&self.reference_list).chain(&self.compare);
        let shapes_of = shapes.iter().flat_map(|shape| [&shape.input, &shape.reference]);
        lists.chain(shapes_of).for_each(|path| inputs.add(path));
        let place = |name: &str| self.output.join(name);
        inputs.check([RUNS_FILE, MARKDOWN_FILE, CSV_FILE, JSON_FILE].map(place))?;
        fs::create_dir_all(&self.output)
            .with_context(|| format!("cannot create the folder {}", self.output.display()))?;
        let mut store = Store::open(&self.output.join(RUNS_FILE))?;
        let tasks = self.tasks(&shapes)?;
        let mut rows: Vec<Option<Row>> = tasks.iter().map(|t| store.find(&t.key).cloned()).collect();
        let open: Vec<usize> = (0..tasks.len()).filter(|&i| rows[i].is_none()).collect();
        let open_tasks: Vec<Task> = open.iter().map(|&i| tasks[i].clone()).collect();
        if open.len() < tasks.len() {
            say(&format!("{} of {} runs were already finished", tasks.len() - open.len(), tasks.len()));
        }

        let bar = ProgressBar::new(tasks.len() as u64);
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} (+{eta}) {msg}") {
            bar.set_style(style);
        }
        bar.set_position((tasks.len() - open.len()) as u64);
        bar.reset_eta();
        let mut failures = Vec::new();
        run_all(&open_tasks, &shapes, &self.metrics, self.jobs, cancel, |at, result| {
            let task = &open_tasks[at];
            let (shape, method, seed) = (&shapes[task.shape].name, task.method.name(), task.params.seed);
            match result {
                Ok(row) => {
                    store.add(row.clone())?;
                    rows[open[at]] = Some(row);
                }
                Err(problem) => {
                    bar.suspend(|| say(&format!("{shape}, {method}, seed {seed}: {problem}")));
                    let (shape, method) = (shape.clone(), method.to_owned());
                    failures.push(Failure { shape, method, seed, problem });
                }
            }
            bar.set_message(format!("{shape} {method}"));
            bar.inc(1);
            Ok(())
        })?;
        bar.finish_and_clear();
        if cancel.is_requested() {
            return Ok(None);
        }
        let rows: Vec<Row> = rows.into_iter().flatten().collect();
        let table = Table::new(&rows, others.as_ref());
        let text = output::markdown(&table);
        self.write(&table, &rows, &failures, &text)?;
        Ok(Some((text, failures.len())))
    }

    /// All runs, shape by shape.
    fn tasks(&self, shapes: &[BenchShape]) -> anyhow::Result<Vec<Task>> {
        // Another build of the program may give other figures.
        let program = std::env::current_exe()
            .and_then(fs::read)
            .map(|bytes| fingerprint(&[&bytes]))
            .context("cannot read the program file")?;
        let content = |path: &Path| fs::read(path).map_or_else(|e| e.to_string(), |b| fingerprint(&[&b]));
        let mut tasks = Vec::new();
        for (k, shape) in shapes.iter().enumerate() {
            let files = [content(&shape.input), content(&shape.reference)];
            for &(method, params) in &self.methods {
                for &seed in &self.seeds {
                    let params = Params { seed, ..params };
                    let sampling =
                        SamplingOptions { points: self.points, seed, ..SamplingOptions::default() };
                    let settings = serde_json::to_vec(&(
                        (&shape.name, method.name(), params),
                        (sampling.points, sampling.seed, sampling.surface, sampling.isolated, self.metrics),
                    ))?;
                    let key = fingerprint(&[
                        program.as_bytes(),
                        files[0].as_bytes(),
                        files[1].as_bytes(),
                        &settings,
                    ]);
                    tasks.push(Task { shape: k, method, params, sampling, key });
                }
            }
        }
        Ok(tasks)
    }

    fn write(&self, table: &Table, rows: &[Row], failures: &[Failure], text: &str) -> anyhow::Result<()> {
        let file = TableFile {
            format: "superform-bench",
            version: 1,
            program: concat!("superform ", env!("CARGO_PKG_VERSION")),
            command: &self.command,
            seeds: &self.seeds,
            points: self.points,
            methods: self.methods.iter().map(|(m, params)| (m.name(), params)).collect(),
            measuring: &self.metrics,
            table,
            runs: rows,
            failures,
        };
        let place = |name: &str| self.output.join(name);
        let markdown = format!("{text}\nCommand: `{}`.\n", self.command);
        io::write_whole(&place(MARKDOWN_FILE), markdown.as_bytes())?;
        io::write_whole(&place(CSV_FILE), &output::csv(table)?)?;
        io::write_whole(&place(JSON_FILE), &serde_json::to_vec_pretty(&file)?)?;
        Ok(())
    }
}

#[derive(Debug, Serialize)]
struct TableFile<'a> {
    format: &'static str,
    version: u32,
    program: &'static str,
    command: &'a str,
    seeds: &'a [u64],
    points: usize,
    methods: Vec<(&'static str, &'a Params)>,
    measuring: &'a MetricOptions,
    #[serde(flatten)]
    table: &'a Table,
    runs: &'a [Row],
    failures: &'a [Failure],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_numbers_and_ranges_with_both_ends() {
        let seeds = |text: &str| text.parse::<Seeds>().map(|s| s.0);
        assert_eq!(seeds("1..3"), Ok(vec![1, 2, 3]));
        assert_eq!(seeds("7,2..4, 3"), Ok(vec![2, 3, 4, 7]));
        assert!(seeds("3..1").unwrap_err().contains("is not a range"));
        assert!(seeds("0..18446744073709551615").unwrap_err().contains("is not a range"));
        assert!(seeds("one").unwrap_err().contains("“one”"));
        assert!(seeds("").is_err());
    }
}
