//! How the run time grows with the number of samples N, initial clusters K and iterations T.

use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, bail};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::Point3;

use super::output::{aligned, none};
use super::table::Spread;
use crate::cli::interrupt::until_done_or_interrupted;
use crate::geometry::cloud::grouped;
use crate::geometry::{SampleCloud, SamplingOptions, sample_cloud, scatter_mesh};
use crate::inference::{Cancel, Method, Params, Run, Setting};
use crate::io::{self, Inputs, Shape, ShapeGeometry};

const MARKDOWN_FILE: &str = "scaling.md";
const CSV_FILE: &str = "scaling.csv";

/// A size whose first seed takes longer than this many seconds is left at that.
const LONG: f64 = 20.0;
/// Most samples or points of a row.
const MOST_POINTS: usize = 10_000_000;

#[derive(Debug, Args)]
#[command(next_help_heading = "Scaling")]
pub(super) struct ScalingArgs {
    /// Measure how the run time of one method on one shape (default: the built-in one) grows with
    /// N, K and T
    #[arg(long)]
    scaling: bool,
    /// Numbers of samples N; also the numbers of points of clouds to be thinned
    #[arg(
        long,
        value_name = "N,…",
        value_delimiter = ',',
        requires = "scaling",
        default_value = "1000,3000,10000,30000,100000,300000,1000000"
    )]
    vary_points: Vec<usize>,
    /// Numbers of initial clusters K
    #[arg(
        long,
        value_name = "K,…",
        value_delimiter = ',',
        requires = "scaling",
        default_value = "5,10,20,50,100,200"
    )]
    vary_clusters: Vec<usize>,
    /// Numbers of iterations T
    #[arg(
        long,
        value_name = "T,…",
        value_delimiter = ',',
        requires = "scaling",
        default_value = "5,10,20,40,80,160"
    )]
    vary_iterations: Vec<usize>,
}

/// What grows from row to row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Varied {
    Samples,
    Clusters,
    Iterations,
}

impl Varied {
    const ALL: [Self; 3] = [Self::Samples, Self::Clusters, Self::Iterations];

    fn symbol(self) -> &'static str {
        match self {
            Self::Samples => "N",
            Self::Clusters => "K",
            Self::Iterations => "T",
        }
    }
}

/// The growth of one method's time on one shape, to be measured.
#[derive(Debug, Clone)]
pub struct ScalingJob {
    /// The built-in shape, if none.
    shape: Option<PathBuf>,
    method: Method,
    /// K and T where they are not varied.
    params: Params,
    /// N where it is not varied.
    sampling: SamplingOptions,
    seeds: Vec<u64>,
    sizes: Vec<(Varied, usize)>,
    output: PathBuf,
    /// How the program was called, for the table's reader.
    command: String,
}

impl ScalingArgs {
    pub(super) fn is_wanted(&self) -> bool {
        self.scaling
    }

    /// The job, with all settings within their limits.
    pub(super) fn resolve(
        self,
        shapes: Vec<PathBuf>,
        methods: &[(Method, Params)],
        seeds: Vec<u64>,
        sampling: SamplingOptions,
        output: PathBuf,
        command: String,
    ) -> Result<ScalingJob, String> {
        let &[(method, params)] = methods else {
            return Err("--scaling measures one method; give only one".to_owned());
        };
        if shapes.len() > 1 {
            return Err("--scaling measures one shape; give one, or none for the built-in one".to_owned());
        }
        let limits = |setting: Setting| (setting.range().0 as usize, setting.most() as usize);
        let mut sizes = Vec::new();
        for (varied, mut values, (least, most)) in [
            (Varied::Samples, self.vary_points, (SamplingOptions::POINTS.0, MOST_POINTS)),
            (Varied::Clusters, self.vary_clusters, limits(Setting::Clusters)),
            (Varied::Iterations, self.vary_iterations, limits(Setting::Iterations)),
        ] {
            values.sort_unstable();
            values.dedup();
            if let Some(value) = values.iter().find(|v| !(least..=most).contains(v)) {
                let symbol = varied.symbol();
                return Err(format!(
                    "a value of {symbol} is {value}, but must be between {least} and {most}"
                ));
            }
            sizes.extend(values.into_iter().map(|value| (varied, value)));
        }
        let shape = shapes.into_iter().next();
        Ok(ScalingJob { shape, method, params, sampling, seeds, sizes, output, command })
    }
}

/// Seconds of one run, on all cores.
#[derive(Debug, Clone, Copy)]
struct Timed {
    sample: f64,
    /// Normalisation and k-means.
    start: f64,
    iterations: f64,
    /// What comes after the last iteration.
    finish: f64,
    primitives: usize,
}

impl Timed {
    fn run(&self) -> f64 {
        self.start + self.iterations + self.finish
    }
}

/// A row: several seeds at one size.
#[derive(Debug)]
struct Line {
    varied: Varied,
    size: usize,
    runs: Vec<Timed>,
    /// Of a cloud of `size` points that is thinned to the usual number of
    /// samples; where it is larger than that.
    thinned: Vec<Timed>,
}

impl Line {
    fn median(&self, value: fn(&Timed) -> f64) -> Option<f64> {
        median(&self.runs, value)
    }

    fn thinned_median(&self, value: fn(&Timed) -> f64) -> Option<f64> {
        median(&self.thinned, value)
    }
}

fn median(runs: &[Timed], value: fn(&Timed) -> f64) -> Option<f64> {
    Spread::of(runs.iter().map(value).collect(), f64::max).map(|spread| spread.median)
}

impl ScalingJob {
    /// Does the job: the tables go to standard output and to files.
    pub fn run(&self) -> ExitCode {
        until_done_or_interrupted(|cancel| self.work(cancel))
    }

    fn work(&self, cancel: &Cancel) -> anyhow::Result<String> {
        let shape = match &self.shape {
            Some(path) => io::read(path)?,
            None => io::built_in()?,
        };
        let mut inputs = Inputs::default();
        self.shape.iter().for_each(|path| inputs.add(path));
        inputs.check([MARKDOWN_FILE, CSV_FILE].map(|name| self.output.join(name)))?;
        fs::create_dir_all(&self.output)
            .with_context(|| format!("cannot create the folder {}", self.output.display()))?;
        let bar = ProgressBar::new(self.sizes.len() as u64);
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {msg}") {
            bar.set_style(style);
        }
        let mut lines = Vec::new();
        for &(varied, size) in &self.sizes {
            bar.set_message(format!("{} = {}", varied.symbol(), grouped(size)));
            lines.push(self.line(&shape, varied, size, cancel).with_context(|| shape.name.clone())?);
            bar.inc(1);
        }
        bar.finish_and_clear();
        let text = self.markdown(&shape.name, &lines);
        io::write_whole(&self.output.join(MARKDOWN_FILE), text.as_bytes())?;
        io::write_whole(&self.output.join(CSV_FILE), &self.csv(&lines)?)?;
        Ok(text)
    }

    /// N, K and T of a row.
    fn size_of_run(&self, varied: Varied, size: usize) -> (usize, Params) {
        let (points, params) = (self.sampling.points, self.params);
        match varied {
            Varied::Samples => (size, params),
            // Within the limits of the parameters, which a u32 holds.
            Varied::Clusters => (points, Params { clusters: size as u32, ..params }),
            Varied::Iterations => (points, Params { iterations: size as u32, ..params }),
        }
    }

    fn line(&self, shape: &Shape, varied: Varied, size: usize, cancel: &Cancel) -> anyhow::Result<Line> {
        let (points, params) = self.size_of_run(varied, size);
        let mut line = Line { varied, size, runs: Vec::new(), thinned: Vec::new() };
        for &seed in &self.seeds {
            let (sampling, params) =
                (SamplingOptions { points, seed, ..self.sampling }, Params { seed, ..params });
            line.runs.push(timed_run(|| Ok(io::sample(shape, &sampling)?), points, params, cancel)?);
            if varied == Varied::Samples && size > self.sampling.points {
                let sampling = SamplingOptions { points: self.sampling.points, ..sampling };
                let dense = dense(shape, size, seed)?;
                let thin = || Ok(sample_cloud(&dense, &sampling)?);
                line.thinned.push(timed_run(thin, sampling.points, params, cancel)?);
            }
            if line.runs.last().is_some_and(|run| run.sample + run.run() > LONG) {
                break;
            }
        }
        Ok(line)
    }

    fn markdown(&self, name: &str, lines: &[Line]) -> String {
        let threads = rayon::current_num_threads();
        let usual = grouped(self.sampling.points);
        let mut text = format!(
            "Wall-clock seconds on {name} with the method {}, on {}; medians over seeds (fewer seeds where \
             one takes more than {LONG} s). N = {usual}, K = {} and T = {} unless varied. \"Thinned\" is a \
             cloud of N random surface points thinned to {usual} samples.\n",
            self.method,
            if threads == 1 { "one thread".to_owned() } else { format!("{threads} threads") },
            self.params.clusters,
            self.params.iterations,
        );
        for varied in Varied::ALL {
            let rows: Vec<&Line> = lines.iter().filter(|line| line.varied == varied).collect();
            if rows.is_empty() {
                continue;
            }
            let symbol = varied.symbol();
            let has_thinned = rows.iter().any(|line| !line.thinned.is_empty());
            let mut header = vec![symbol, "sample", "start", "iterations", "finish", "run", "primitives"];
            if varied == Varied::Samples {
                header.push("µs per sample");
            }
            if has_thinned {
                header.extend(["thinned: sample", "run"]);
            }
            header.push("seeds");
            let mut cells = vec![header.into_iter().map(str::to_owned).collect::<Vec<_>>()];
            cells.extend(rows.iter().map(|line| row(line, has_thinned)));
            text.push_str(&format!("\n{}", aligned(&cells, 0)));
            text.push_str(&growth(symbol, &rows));
        }
        text.push_str(&format!(
            "\nCommand: `{}` with superform {}.\n",
            self.command,
            env!("CARGO_PKG_VERSION")
        ));
        text
    }

    fn csv(&self, lines: &[Line]) -> anyhow::Result<Vec<u8>> {
        let mut out = csv::Writer::from_writer(Vec::new());
        out.write_record([
            "varied",
            "samples",
            "clusters",
            "iterations",
            "threads",
            "seeds",
            "sample_s",
            "start_s",
            "iterations_s",
            "finish_s",
            "run_s",
            "primitives",
            "thinned_sample_s",
            "thinned_run_s",
        ])?;
        for line in lines {
            let (points, params) = self.size_of_run(line.varied, line.size);
            let text = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
            out.write_record([
                line.varied.symbol().to_owned(),
                points.to_string(),
                params.clusters.to_string(),
                params.iterations.to_string(),
                rayon::current_num_threads().to_string(),
                line.runs.len().to_string(),
                text(line.median(|r| r.sample)),
                text(line.median(|r| r.start)),
                text(line.median(|r| r.iterations)),
                text(line.median(|r| r.finish)),
                text(line.median(Timed::run)),
                text(line.median(|r| r.primitives as f64)),
                text(line.thinned_median(|r| r.sample)),
                text(line.thinned_median(Timed::run)),
            ])?;
        }
        out.into_inner().context("cannot write the table")
    }
}

/// Samples and runs, by the clock.
fn timed_run(
    sample: impl FnOnce() -> anyhow::Result<SampleCloud>,
    points: usize,
    params: Params,
    cancel: &Cancel,
) -> anyhow::Result<Timed> {
    let mut clock = Instant::now();
    let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
    let cloud = sample()?;
    let sample = lap();
    let found = cloud.points.len();
    if found < points {
        bail!(
            "it has {} distinct points, too few for {} samples; use fewer samples or give a mesh",
            grouped(found),
            grouped(points)
        );
    }
    let mut run = Run::new(Arc::new(cloud), params, cancel)?;
    let start = lap();
    while run.iteration() < params.iterations && !run.is_finished() {
        run.step(cancel)?;
    }
    let iterations = lap();
    while !run.is_finished() {
        run.step(cancel)?;
    }
    Ok(Timed { sample, start, iterations, finish: lap(), primitives: run.abstraction().primitives.len() })
}

/// A cloud of so many points of the shape.
fn dense(shape: &Shape, count: usize, seed: u64) -> anyhow::Result<Vec<Point3<f64>>> {
    Ok(match &shape.geometry {
        ShapeGeometry::Mesh(mesh) => scatter_mesh(mesh, count, seed)?,
        ShapeGeometry::Cloud(cloud) => {
            let step = (cloud.points.len() / count.max(1)).max(1);
            cloud.points.iter().copied().step_by(step).take(count).collect()
        }
    })
}

fn row(line: &Line, has_thinned: bool) -> Vec<String> {
    let seconds = |value: Option<f64>| value.map_or_else(none, |v| format!("{v:.3}"));
    let run = line.median(Timed::run);
    let mut cells = vec![grouped(line.size)];
    let phases: [fn(&Timed) -> f64; 4] = [|r| r.sample, |r| r.start, |r| r.iterations, |r| r.finish];
    cells.extend(phases.map(|phase| seconds(line.median(phase))));
    cells.push(seconds(run));
    cells.push(line.median(|r| r.primitives as f64).map_or_else(none, |n| format!("{n:.0}")));
    if line.varied == Varied::Samples {
        cells.push(run.map_or_else(none, |v| format!("{:.1}", 1e6 * v / line.size as f64)));
    }
    if has_thinned {
        cells.push(seconds(line.thinned_median(|r| r.sample)));
        cells.push(seconds(line.thinned_median(Timed::run)));
    }
    cells.push(line.runs.len().to_string());
    cells
}

/// One sentence: the powers that the times grow with.
fn growth(symbol: &str, rows: &[&Line]) -> String {
    let power = |value: &dyn Fn(&Line) -> Option<f64>| {
        let points: Vec<(f64, f64)> =
            rows.iter().filter_map(|line| Some((line.size as f64, value(line)?))).collect();
        slope(&points)
    };
    let told: Vec<String> = [
        ("the run grows", power(&|line| line.median(Timed::run))),
        ("its iterations", power(&|line| line.median(|r| r.iterations))),
        ("the refinement", power(&|line| line.median(|r| r.finish))),
        ("sampling", power(&|line| line.median(|r| r.sample)).filter(|_| symbol == Varied::Samples.symbol())),
        ("thinning", power(&|line| line.thinned_median(|r| r.sample))),
    ]
    .into_iter()
    .filter_map(|(what, power)| Some(format!("{what} as {symbol}^{:.2}", power?)))
    .collect();
    match &told[..] {
        [] => String::new(),
        told => format!("\nSlopes in log-log: {}.\n", told.join(", ")),
    }
}

/// Slope of the straight line through (ln x, ln y) by least squares; `None` for
/// fewer than two different x.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> =
        points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0).map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let (mean_x, mean_y) = logs.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let spread: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let shared: f64 = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    (logs.len() > 1 && spread > 0.0).then(|| shared / spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_the_power() {
        for power in [0.0, 0.5, 1.0, 2.0] {
            let points = [1.0, 3.0, 10.0, 400.0].map(|x: f64| (x, 7.0 * x.powf(power)));
            assert!((slope(&points).unwrap() - power).abs() < 1e-12);
        }
        assert_eq!(slope(&[(10.0, 1.0)]), None);
        assert_eq!(slope(&[(10.0, 1.0), (10.0, 2.0)]), None);
        assert_eq!(slope(&[(1.0, 0.0), (2.0, 1.0)]), None);
    }
}
