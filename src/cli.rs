//! The command line: what was asked for, and the job without a window.
//!
//! ```text
//! superform [FILE] [settings] [--screenshot shot.png] [--headless]
//! superform run INPUT… -o DIR [settings]
//! superform run --manifest FILE -o DIR [--shard I/N] [settings]
//! superform merge-results DIR
//! superform evaluate RESULT --reference FILE [--json]
//! superform export RESULT -o FILE… | --list
//! superform bench SHAPES… [--methods a,b,…] [--seeds 1..3] [-o DIR]
//! superform bench --scaling [SHAPE]
//! superform render RESULT… [-o FILE|DIR] [--sheet PNG]
//! superform completions SHELL
//! superform man [-o DIR]
//! ```

mod batch;
mod bench;
mod display;
mod evaluate;
mod export;
mod headless;
mod interrupt;
mod job;
mod journal;
mod manual;
mod names;
mod output;
mod patterns;
mod render;
mod request;
mod run;
mod runner;
mod settings;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand};
use tracing::Level;
use tracing_subscriber::Layer as _;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

use self::names::is_png;
use self::output::say;
use self::settings::{MeasureArgs, SettingsArgs};
use crate::geometry::metrics::MetricOptions;
use crate::worker::Source;

pub use batch::{BatchJob, MergeJob};
pub use bench::{BenchJob, ScalingJob};
pub use display::{spare_complaints, why_no_display};
pub use evaluate::EvaluateJob;
pub use export::{ExportJob, WriteJob};
pub use headless::HeadlessJob;
pub use journal::{Journal, JournalLayer, Record};
pub use manual::ManualJob;
pub use output::fail;
pub use render::{Look, RenderJob, SheetWish, Turn, Viewpoint};
pub use request::{Request, WindowRequest};

/// Where a job goes that was meant for the window.
const FALLBACK_FOLDER: &str = "superform-out";

/// Turns a 3D shape into a small number of tapered superquadrics.
///
/// Opens FILE, or a built-in chair, in a window. Without a display, runs the same job and writes
/// the results to ./superform-out.
#[derive(Debug, Parser)]
#[command(name = "superform", version = env!("SUPERFORM_VERSION"), max_term_width = 100, args_conflicts_with_subcommands = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    open: OpenArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Abstract shapes without a window and write the results to a folder
    /// unfinished jobs.
    ///
    /// Writes segmented.ply (the cloud with labels and colours), primitives.json and report.json.
    /// unfinished jobs.
    ///
    /// The results of a single file go directly into the folder. Several files, a folder, a
    /// pattern, a manifest or a sweep form a batch: each job gets its own subfolder, and
    /// results.csv and results.jsonl get one row per job. Repeating the command runs only
    /// unfinished jobs.
    ///
    /// Exit status: 0 on success, 1 if a single run or the whole batch failed, 2 for an invalid
    /// command line, 10 + n if n jobs of a batch failed (at most 110), 130 if interrupted.
    Run(run::RunArgs),
    /// Merge the tables of several runs in a folder into one
    /// unfinished jobs.
    /// For runs with --shard or --lines, each of which writes its own table. Writes results.csv and
    /// results.jsonl. Exit status: 10 + n if n jobs failed.
    MergeResults {
        /// Output folder of the runs
        dir: PathBuf,
    },
    /// Measure a result against a shape: Chamfer distance, IoU, number of primitives
    /// unfinished jobs.
    /// Lengths are in units of the longest edge of the reference's bounding box.
    Evaluate(EvaluateArgs),
    /// Export a result to other formats: clouds, meshes, primitives, robot models
    /// unfinished jobs.
    /// RESULT is the output folder of `run` or a file of primitives. --list prints the formats and
    /// their uses.
    Export(export::ExportArgs),
    /// Measure methods on many shapes: a table of shape × method
    /// unfinished jobs.
    /// Each run uses one core; several run in parallel. A mesh is measured against itself. Writes
    /// runs.jsonl while running (an interrupted benchmark resumes from it), table.md, table.csv and
    /// table.json.
    /// unfinished jobs.
    /// With --scaling, measures instead how the run time of one method on one shape grows, using
    /// all cores, and writes scaling.md and scaling.csv.
    Bench(bench::BenchArgs),
    /// Render results without a window: pictures, turntables or a contact sheet
    /// unfinished jobs.
    /// A result is the folder of a run, a file of primitives (JSON, NPZ or CSV) or a session; the
    /// folder of a batch stands for all its jobs. Input shapes can be rendered as well. Needs a
    /// graphics driver (a software driver will do) but no display.
    /// unfinished jobs.
    /// Exit status: 0 on success, 1 if the only result failed, if there is nothing to render or if
    /// there is no graphics driver, 2 for an invalid command line, 10 + n if n of several results
    /// could not be rendered (at most 110), 130 if interrupted.
    Render(Box<render::RenderArgs>),
    /// Print a completion script for a shell
    Completions {
        /// Shell to complete for
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or write one page per command
    Man {
        /// Folder for superform.1, superform-run.1 and so on
        #[arg(short, long, value_name = "DIR")]
        output: Option<PathBuf>,
    },
}

#[derive(Debug, Args)]
struct OpenArgs {
    /// Mesh or point cloud to open: OBJ, PLY, STL, OFF, glTF, GLB, PCD, LAS,
    /// LAZ, NPY, NPZ or XYZ text
    file: Option<PathBuf>,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Save a screenshot of the window when the run finishes, then exit
    #[arg(long, value_name = "PNG", conflicts_with = "headless")]
    screenshot: Option<PathBuf>,
    /// Run without a window and write the results to ./superform-out
    #[arg(long)]
    headless: bool,
    /// Reset the window's size, panels, theme and recent files
    #[arg(long, conflicts_with = "headless")]
    reset_layout: bool,
}

#[derive(Debug, Args)]
struct EvaluateArgs {
    /// primitives.json of a run, or the folder that contains it
    result: PathBuf,
    /// Mesh or point cloud to measure against: OBJ, PLY, STL, OFF, glTF, GLB, PCD, LAS, LAZ, NPY,
    /// NPZ or XYZ text
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

impl Cli {
    /// Reads the command line of this process.
    /// unfinished jobs.
    /// # Errors
    /// Where it can't be read, or asks for help: it was told so, and this is the
    /// exit status.
    pub fn read() -> Result<Self, ExitCode> {
        Self::try_parse().map_err(|error| {
            if let Some(problem) = misspelt_command(&error, std::env::args_os().skip(1)) {
                return refuse(&problem);
            }
            let told = error.print();
            match error.use_stderr() {
                // Nobody else can be told.
                true => ExitCode::from(2),
                // Through to whoever reads it.
                false => output::arrived(told.and_then(|()| crate::io::print(std::io::empty()))),
            }
        })
    }

    /// The request, with all settings within their limits.
    /// unfinished jobs.
    /// # Errors
    /// One sentence that names the setting and its limits.
    pub fn request(self) -> Result<Request, String> {
        match self.command {
            Some(Command::Run(run)) => return run.resolve(),
            Some(Command::MergeResults { dir }) => return Ok(Request::Merge(MergeJob { folder: dir })),
            Some(Command::Completions { shell }) => {
                return Ok(Request::Manual(ManualJob::Completions(shell)));
            }
            Some(Command::Man { output }) => return Ok(Request::Manual(ManualJob::Pages(output))),
            Some(Command::Evaluate(EvaluateArgs { result, reference, json, measure, seed })) => {
                let options = measure.resolve(seed)?;
                return Ok(Request::Evaluate(EvaluateJob { result, reference, json, options }));
            }
            Some(Command::Export(export)) => return export.resolve().map(Request::Export),
            Some(Command::Bench(bench)) => return bench.resolve(),
            Some(Command::Render(render)) => return render.resolve().map(Request::Render),
            None => {}
        }
        let OpenArgs { file, settings, screenshot, headless, reset_layout } = self.open;
        let (sampling, params) = settings.resolve()?;
        let source = file.map_or(Source::BuiltIn, Source::File);
        if let Some(path) = screenshot.as_deref().filter(|path| !is_png(path)) {
            return Err(format!("a screenshot is a PNG file; give {} the ending .png", path.display()));
        }
        if let Source::File(file) = &source {
            let mut inputs = crate::io::Inputs::default();
            inputs.add_result(file);
            inputs.check(&screenshot).map_err(|e| e.to_string())?;
        }
        if headless {
            let output = PathBuf::from(FALLBACK_FOLDER);
            return Ok(Request::Headless(HeadlessJob {
                viewpoints: Vec::new(),
                source,
                sampling,
                params,
                output,
                exports: Vec::new(),
                quiet: false,
            }));
        }
        Ok(Request::Window(WindowRequest { source, sampling, params, screenshot, reset_layout }))
    }
}

/// What to say of `superform runn FILE`, which reads as one file too many.
fn misspelt_command(error: &clap::Error, args: impl Iterator<Item = OsString>) -> Option<String> {
    use clap::error::ErrorKind::{ArgumentConflict, UnknownArgument};
    // A command's name is text.
    let mut args = args.map_while(|arg| arg.into_string().ok());
    let (first, second) = (args.next()?, args.next()?);
    if !matches!(error.kind(), ArgumentConflict | UnknownArgument)
        || first.starts_with('-')
        || second.starts_with('-')
        || Path::new(&first).exists()
    {
        return None;
    }
    let cli = Cli::command();
    let commands: Vec<&str> = cli.get_subcommands().map(clap::Command::get_name).collect();
    let known = commands.contains(&first.as_str());
    (!known).then(|| {
        format!(
            "{first} is neither a command nor an existing file; commands are {} (see superform --help)",
            commands.join(", ")
        )
    })
}

/// Does the job of a window that can't be opened, for the reason `why`, and
/// says so. A screenshot can't be had that way: then nothing is done.
pub fn instead_of_window(request: WindowRequest, why: &str) -> ExitCode {
    let WindowRequest { source, sampling, params, screenshot, .. } = request;
    if screenshot.is_some() {
        return fail(&format!("{why}, but a screenshot needs a window; on a server try xvfb-run"));
    }
    say(&format!("{why}; running without a window, writing results to ./{FALLBACK_FOLDER}"));
    let output = PathBuf::from(FALLBACK_FOLDER);
    HeadlessJob {
        source,
        viewpoints: Vec::new(),
        sampling,
        params,
        output,
        exports: Vec::new(),
        quiet: false,
    }
    .run()
}

/// Sends warnings (or what RUST_LOG asks for) to standard error, and warnings
/// and errors to the journal.
pub fn start_log() -> Journal {
    let asked = std::env::var("RUST_LOG").ok().and_then(|asked| asked.parse::<Targets>().ok());
    let filter = asked.unwrap_or_else(|| Targets::new().with_target("superform", Level::WARN));
    let (journal, layer) = Journal::new();
    let printed = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_filter(filter);
    // Fails only if there is a log already.
    let _ = tracing_subscriber::registry().with(printed).with(layer).try_init();
    journal
}

/// Refuses a command line that makes no sense.
pub fn refuse(problem: &str) -> ExitCode {
    say(problem);
    ExitCode::from(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Isolated, SamplingOptions, Surface};
    use crate::inference::{MergeRule, Method, PARAMETERS, Params};

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
            "--primitive-cost",
            "2.5",
            "--no-merge",
            "--surface",
            "all",
            "--isolated",
            "keep",
        ]) else {
            panic!("not a run")
        };
        assert_eq!(job.source, Source::File("in.obj".into()));
        assert_eq!(
            job.sampling,
            SamplingOptions { points: 500, seed: 42, surface: Surface::All, isolated: Isolated::Keep }
        );
        let expected = Params {
            alpha: 2.0,
            p0: 0.2,
            iterations: 7,
            clusters: 9,
            seed: 42,
            primitive_cost: 2.5,
            merge: MergeRule::None,
            ..Params::default()
        };
        assert_eq!(job.params, expected);
    }

    #[test]
    fn methods_are_called_by_name_and_refuse_what_they_do_not_read() {
        for method in Method::ALL {
            for option in ["--method", "--preset"] {
                let Ok(Request::Headless(job)) =
                    request(&["run", "a.ply", "-o", "out", option, method.name()])
                else {
                    panic!("{method} is no run")
                };
                assert_eq!(job.params, method.params());
            }
        }
        for (args, option) in [
            (&["--method", "kmeans", "--alpha", "2"][..], "--alpha"),
            (&["--method", "ems", "--clusters", "2"], "--clusters"),
            (&["--method", "hierarchical-ems", "--no-merge"], "--no-merge"),
            (&["--method", "paper", "--primitive-cost", "2"], "--primitive-cost"),
            (&["--outlier-prior", "0.2"], "--outlier-prior"),
        ] {
            let problem = request(args).unwrap_err();
            assert!(problem.contains(&format!("does not use {option}")), "{problem}");
        }
        for (args, outlier_prior, clusters) in
            [(["ems", "--outlier-prior", "0.2"], 0.2, 30), (["kmeans", "--clusters", "7"], 0.5, 7)]
        {
            let Ok(Request::Window(window)) = request(&[&["--method"], &args[..]].concat()) else {
                panic!("not a window")
            };
            assert_eq!((window.params.outlier_prior, window.params.clusters), (outlier_prior, clusters));
        }
    }

    /// The limits that --help names are those that hold.
    #[test]
    fn help_names_the_limits() {
        let mut command = Cli::command();
        let run = command.find_subcommand_mut("run").unwrap();
        let help = run.render_long_help().to_string();
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        let samples = ("N", SamplingOptions::POINTS.0 as f64, SamplingOptions::POINTS.1 as f64);
        let numbers = PARAMETERS.iter().filter(|p| p.number.is_some());
        let limits = numbers.map(|p| (p.symbol, p.setting.range().0, p.setting.range().1)).chain([samples]);
        for (value, low, high) in limits {
            let text = help.split(&format!("<{value}>")).nth(1).unwrap().split("--").next().unwrap();
            let (from, to) = text.split("from ").nth(1).unwrap().split_once(" to ").unwrap();
            let to = to.split_whitespace().next().unwrap();
            assert_eq!((from.parse(), to.parse()), (Ok(low), Ok(high)), "{text}");
        }
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
            (["--primitive-cost", "0"], "primitive cost"),
        ] {
            let problem = request(&args).unwrap_err();
            assert!(problem.contains(word) && problem.contains("between"), "{problem}");
        }
    }
}
