//! The command line: what was asked for, and the job without a window.
//!
//! ```text
//! superform [FILE] [settings] [--screenshot shot.png] [--headless]
//! superform run INPUT -o DIR [settings]
//! superform evaluate RESULT --reference FILE [--json]
//! superform bench SHAPES… [--methods a,b,…] [--seeds 1..3] [-o DIR]
//! ```

mod bench;
mod display;
mod evaluate;
mod headless;
mod interrupt;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::geometry::metrics::MetricOptions;
use crate::geometry::{SamplingOptions, Surface};
use crate::inference::{MergeRule, Params};
use crate::worker::Source;

pub use bench::BenchJob;
pub use display::why_no_display;
pub use evaluate::EvaluateJob;
pub use headless::HeadlessJob;

/// Where a job goes that was meant for the window.
const FALLBACK_FOLDER: &str = "superform-out";

/// Turns a 3D shape into a handful of tapered superquadrics.
///
/// Opens the window on FILE (or on a built-in chair). Where there is no
/// display, does the same job without one and leaves the results in
/// ./superform-out.
#[derive(Debug, Parser)]
#[command(name = "superform", version, max_term_width = 100, args_conflicts_with_subcommands = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    open: OpenArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Abstract a shape without a window and write the results to a folder
    ///
    /// Writes segmented.ply (the cloud with labels and colours), primitives.json
    /// and report.json: all three, or none.
    Run(RunArgs),
    /// Measure a result against a shape: Chamfer distance, IoU, number of primitives
    ///
    /// Lengths are in units of the longest edge of the reference's bounding box.
    Evaluate(EvaluateArgs),
    /// Measure methods on many shapes: a table of shape × method
    ///
    /// Each run works on one core, several of them side by side. A mesh is
    /// measured against itself. Writes runs.jsonl (as it goes; a benchmark that
    /// was stopped goes on from there), table.md, table.csv and table.json.
    Bench(bench::BenchArgs),
}

#[derive(Debug, Args)]
struct OpenArgs {
    /// Mesh or point cloud to open: OBJ, PLY or XYZ text
    file: Option<PathBuf>,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Save what the window shows when the run has ended, and exit
    #[arg(long, value_name = "PNG", conflicts_with = "headless")]
    screenshot: Option<PathBuf>,
    /// Open no window; leave the results in ./superform-out
    #[arg(long)]
    headless: bool,
}

#[derive(Debug, Args)]
struct RunArgs {
    /// Mesh or point cloud to read: OBJ, PLY or XYZ text
    input: PathBuf,
    /// Folder for the results; made if it isn't there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    settings: SettingsArgs,
}

#[derive(Debug, Args)]
struct EvaluateArgs {
    /// primitives.json of a run, or the folder that holds it
    result: PathBuf,
    /// Mesh or point cloud to measure against: OBJ, PLY or XYZ text
    #[arg(long, value_name = "FILE")]
    reference: PathBuf,
    /// Write JSON instead of a table
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    measure: MeasureArgs,
    /// Seed of the samples
    #[arg(long, value_name = "S", default_value_t = MetricOptions::default().seed)]
    seed: u64,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Measuring")]
struct MeasureArgs {
    /// Samples of each of the two surfaces, and points that volumes are counted by
    #[arg(long, value_name = "N", default_value_t = MetricOptions::default().samples)]
    samples: usize,
}

impl MeasureArgs {
    fn resolve(&self, seed: u64) -> Result<MetricOptions, String> {
        let options = MetricOptions { samples: self.samples, volume_points: self.samples, seed };
        options.check().map(|()| options)
    }
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Settings")]
struct SettingsArgs {
    /// Number of samples N [default: 3500]
    #[arg(long, value_name = "N")]
    points: Option<usize>,
    /// Part of a mesh that is sampled
    #[arg(long, value_enum, default_value_t = SurfaceChoice::Outside)]
    surface: SurfaceChoice,
    /// Seed of all random draws: the same seed gives the same result [default: 1]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// Concentration α: the larger, the more primitives [default: 0.5]
    #[arg(long, value_name = "ALPHA", allow_negative_numbers = true)]
    alpha: Option<f64>,
    /// Density p0 that a new primitive gives to any point [default: 0.1]
    #[arg(long, value_name = "P0", allow_negative_numbers = true)]
    p0: Option<f64>,
    /// Number of Gibbs iterations T [default: 30]
    #[arg(long, value_name = "T")]
    iterations: Option<u32>,
    /// Number of clusters K at the start [default: 30]
    #[arg(long, value_name = "K")]
    clusters: Option<u32>,
    /// Leave the primitives unmerged
    #[arg(long)]
    no_merge: bool,
    /// Set of parameters that the other options change
    #[arg(long, value_enum, default_value_t = Preset::Default)]
    preset: Preset,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Preset {
    /// What gives the best results
    Default,
    /// The steps of the paper and its authors' program
    Paper,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SurfaceChoice {
    /// What can be seen from outside: no inner walls, no buried parts
    Outside,
    /// Every face
    All,
}

impl SettingsArgs {
    fn resolve(&self) -> Result<(SamplingOptions, Params), String> {
        let mut sampling = SamplingOptions::default();
        let mut params = match self.preset {
            Preset::Default => Params::default(),
            Preset::Paper => Params::paper(),
        };
        sampling.points = self.points.unwrap_or(sampling.points);
        sampling.surface = match self.surface {
            SurfaceChoice::Outside => Surface::Outside,
            SurfaceChoice::All => Surface::All,
        };
        params.alpha = self.alpha.unwrap_or(params.alpha);
        params.p0 = self.p0.unwrap_or(params.p0);
        params.iterations = self.iterations.unwrap_or(params.iterations);
        params.clusters = self.clusters.unwrap_or(params.clusters);
        if let Some(seed) = self.seed {
            (sampling.seed, params.seed) = (seed, seed);
        }
        if self.no_merge {
            params.merge = MergeRule::None;
        }
        sampling.check().map_err(|e| e.to_string())?;
        params.check()?;
        Ok((sampling, params))
    }
}

/// What the command line asks for.
#[derive(Debug, Clone)]
pub enum Request {
    Window(WindowRequest),
    Headless(HeadlessJob),
    Evaluate(EvaluateJob),
    Bench(BenchJob),
}

/// What the window is to be opened with.
#[derive(Debug, Clone)]
pub struct WindowRequest {
    pub source: Source,
    pub sampling: SamplingOptions,
    pub params: Params,
    /// Where to save a picture of the window after the run.
    pub screenshot: Option<PathBuf>,
}

impl Cli {
    /// The request, with all settings within their limits.
    ///
    /// # Errors
    /// One sentence that names the setting and its limits.
    pub fn request(self) -> Result<Request, String> {
        let job = |input: Option<PathBuf>, output, settings: &SettingsArgs| {
            let (sampling, params) = settings.resolve()?;
            let source = input.map_or(Source::BuiltIn, Source::File);
            Ok::<_, String>(HeadlessJob { source, sampling, params, output })
        };
        match self.command {
            Some(Command::Run(run)) => {
                return job(Some(run.input), run.output, &run.settings).map(Request::Headless);
            }
            Some(Command::Evaluate(EvaluateArgs { result, reference, json, measure, seed })) => {
                let options = measure.resolve(seed)?;
                return Ok(Request::Evaluate(EvaluateJob { result, reference, json, options }));
            }
            Some(Command::Bench(bench)) => return bench.resolve().map(Request::Bench),
            None => {}
        }
        let OpenArgs { file, settings, screenshot, headless } = self.open;
        let job = job(file, PathBuf::from(FALLBACK_FOLDER), &settings)?;
        if headless {
            return Ok(Request::Headless(job));
        }
        let HeadlessJob { source, sampling, params, .. } = job;
        Ok(Request::Window(WindowRequest { source, sampling, params, screenshot }))
    }
}

/// Does the job of a window that can't be opened, for the reason `why`, and
/// says so. A screenshot can't be had that way: then nothing is done.
pub fn instead_of_window(request: WindowRequest, why: &str) -> ExitCode {
    let WindowRequest { source, sampling, params, screenshot } = request;
    if screenshot.is_some() {
        return fail(&format!("{why}, and a screenshot needs a window; on a server try xvfb-run"));
    }
    say(&format!("{why}; doing the job without a window, results go to ./{FALLBACK_FOLDER}"));
    HeadlessJob { source, sampling, params, output: PathBuf::from(FALLBACK_FOLDER) }.run()
}

/// Sends warnings (or what RUST_LOG asks for) to standard error.
pub fn start_log() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("superform=warn"));
    // Fails only if there is a log already.
    let _ = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).try_init();
}

/// Refuses a command line that makes no sense.
pub fn refuse(problem: &str) -> ExitCode {
    say(problem);
    ExitCode::from(2)
}

/// Says what went wrong in the job.
pub fn fail(problem: &str) -> ExitCode {
    say(problem);
    ExitCode::FAILURE
}

/// One line for the person at the terminal. If standard error is closed there
/// is nobody to tell.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "superform: {line}");
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    fn request(args: &[&str]) -> Result<Request, String> {
        let args = std::iter::once("superform").chain(args.iter().copied());
        Cli::try_parse_from(args).map_err(|e| e.to_string())?.request()
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn all_settings_arrive() {
        let Ok(Request::Headless(job)) = request(&[
            "run",
            "in.obj",
            "-o",
            "out",
            "--alpha",
            "2",
            "--p0",
            "0.2",
            "--iterations",
            "7",
            "--clusters",
            "9",
            "--points",
            "500",
            "--seed",
            "42",
            "--no-merge",
            "--preset",
            "paper",
            "--surface",
            "all",
        ]) else {
            panic!("not a run")
        };
        assert_eq!(job.source, Source::File("in.obj".into()));
        assert_eq!(job.sampling, SamplingOptions { points: 500, seed: 42, surface: Surface::All });
        let expected = Params {
            alpha: 2.0,
            p0: 0.2,
            iterations: 7,
            clusters: 9,
            seed: 42,
            merge: MergeRule::None,
            ..Params::paper()
        };
        assert_eq!(job.params, expected);
    }

    #[test]
    fn without_arguments_the_window_opens_on_the_built_in_shape() {
        let Ok(Request::Window(window)) = request(&[]) else { panic!("not a window") };
        assert_eq!(window.source, Source::BuiltIn);
        assert_eq!(window.params, Params::default());
        assert_eq!(window.sampling, SamplingOptions::default());
        assert!(matches!(request(&["--headless"]), Ok(Request::Headless(_))));
        assert!(matches!(request(&["a.ply", "--screenshot", "s.png"]), Ok(Request::Window(_))));
    }

    #[test]
    fn settings_out_of_their_limits_are_named() {
        for (args, word) in [
            (["--alpha", "-1"], "alpha"),
            (["--alpha", "nan"], "alpha"),
            (["--p0", "1e9"], "p0"),
            (["--iterations", "0"], "iterations"),
            (["--clusters", "100000"], "clusters"),
            (["--points", "3"], "samples"),
        ] {
            let problem = request(&args).unwrap_err();
            assert!(problem.contains(word) && problem.contains("between"), "{problem}");
        }
    }
}
