//! What is to be measured, as the command line tells it.

use std::path::PathBuf;
use std::str::FromStr;
use std::thread;

use clap::Args;

use super::BenchJob;
use super::scaling::ScalingArgs;
use crate::cli::names::folder_for_results;
use crate::cli::request::Request;
use crate::cli::settings::{MeasureArgs, TuningArgs, methods};
use crate::geometry::metrics::MetricOptions;
use crate::inference::{Method, Params};

/// Most runs of one benchmark with the same shape and method.
const MOST_SEEDS: u64 = 1000;

#[derive(Debug, Args)]
pub(in crate::cli) struct BenchArgs {
    /// Shapes, folders of shapes, or lists (CSV with the columns name, cloud and reference)
    ///
    /// Paths in a list are relative to it; an empty reference means the cloud
    /// itself.
    #[arg(required_unless_present = "scaling")]
    shapes: Vec<PathBuf>,
    /// Methods to compare
    #[arg(long, value_delimiter = ',', default_value = "default", value_name = "A,B,…", value_parser = methods())]
    methods: Vec<Method>,
    /// Seeds of each method on each shape: numbers, and ranges with both ends
    #[arg(long, default_value = "1..3", value_name = "A..B,C,…")]
    seeds: Seeds,
    /// Folder for the results; a benchmark that was stopped goes on from what is there
    #[arg(short, long, value_name = "DIR", default_value = "superform-bench")]
    output: PathBuf,
    /// List that says what shapes that come from no list are measured against (by name)
    #[arg(long, value_name = "CSV", conflicts_with = "scaling")]
    reference_list: Option<PathBuf>,
    /// Compare with the figures of another program: columns name, primitives, chamfer_l1 and iou
    #[arg(long, value_name = "CSV", conflicts_with = "scaling")]
    compare: Option<PathBuf>,
    /// Number of runs side by side [default: one a core]
    #[arg(long, value_name = "N", conflicts_with = "scaling")]
    jobs: Option<usize>,
    #[command(flatten)]
    measure: MeasureArgs,
    #[command(flatten)]
    scaling: ScalingArgs,
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

impl BenchArgs {
    /// The job, with all settings within their limits.
    pub(in crate::cli) fn resolve(self) -> Result<Request, String> {
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
