//! The job without a window: read, sample, infer, write.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use indicatif::{ProgressBar, ProgressStyle};

use super::interrupt::until_done_or_interrupted;
use super::say;
use crate::geometry::SamplingOptions;
use crate::geometry::palette::Colors;
use crate::inference::{Abstraction, Cancel, InferenceError, Occurrence, Params, Run};
use crate::io::{self, Outcome, RunRecord, Shape, ShapeGeometry};
use crate::worker::Source;

/// A whole run, from a shape to its files.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadlessJob {
    pub source: Source,
    pub sampling: SamplingOptions,
    pub params: Params,
    /// Folder for the results.
    pub output: PathBuf,
}

impl HeadlessJob {
    /// Does the job: progress goes to standard error if that is a terminal,
    /// a summary to standard output. On failure, and when Ctrl-C is pressed,
    /// nothing is written.
    pub fn run(&self) -> ExitCode {
        until_done_or_interrupted(|cancel| Ok(self.work(cancel)? + "\n"))
    }

    fn work(&self, cancel: &Cancel) -> anyhow::Result<String> {
        if self.output.exists() && !self.output.is_dir() {
            bail!("{} is not a folder; name another one for the results", self.output.display());
        }
        let whole = Instant::now();
        let mut record = RunRecord::default();
        // How many steps the recovery of primitives takes is not known beforehand.
        let (bar, template) = match self.params.steps() {
            Some(steps) => (ProgressBar::new(steps.into()), "{bar:30} {pos}/{len} {elapsed} {msg}"),
            None => (ProgressBar::no_length(), "{spinner} {pos} {elapsed} {msg}"),
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message("reading");
        let shape = timed(&mut record.times.read, || match &self.source {
            Source::File(path) => io::read(path),
            Source::BuiltIn => io::built_in(),
        })?;
        for note in &shape.notes {
            bar.suspend(|| say(&format!("{}: {note}", shape.name)));
        }
        bar.set_message("sampling");
        let cloud = timed(&mut record.times.sample, || io::sample(&shape, &self.sampling))
            .with_context(|| shape.name.clone())?;
        let cloud = Arc::new(cloud);

        let abstraction =
            self.infer(Arc::clone(&cloud), cancel, &mut record, &bar).with_context(|| shape.name.clone())?;
        bar.finish_and_clear();
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled.into());
        }
        let colors = Colors::default();
        let outcome = Outcome {
            colors: &colors,
            shape: &shape,
            cloud: &cloud,
            sampling: self.sampling,
            params: &self.params,
            abstraction: &abstraction,
        };
        let files = io::write_run(&self.output, &outcome, &record)?;
        let names = files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>().join(", ");
        Ok(format!("{}\nwrote {names}", summary(&outcome, whole.elapsed())))
    }

    fn infer(
        &self,
        cloud: Arc<crate::geometry::SampleCloud>,
        cancel: &Cancel,
        record: &mut RunRecord,
        bar: &ProgressBar,
    ) -> Result<Abstraction, InferenceError> {
        bar.set_message("starting");
        let times = &mut record.times;
        let mut run = timed(&mut times.start, || Run::new(cloud, self.params, cancel))?;
        record.clusters.push(run.abstraction().primitives.len());
        while !run.is_finished() {
            let before = run.iteration();
            let mut spent = Duration::ZERO;
            let occurrences = timed(&mut spent, || run.step(cancel))?;
            let clusters = run.abstraction().primitives.len();
            if run.iteration() > before {
                times.iterations += spent;
                record.clusters.push(clusters);
            } else {
                times.merge += spent;
            }
            record.merges.extend(occurrences.into_iter().filter_map(|o| match o {
                Occurrence::Merged(report) => Some(report),
                _ => None,
            }));
            bar.set_position(u64::from(run.iteration()));
            bar.set_message(primitives(clusters));
        }
        Ok(run.abstraction())
    }
}

/// Runs `work` and adds the time it took to `spent`.
fn timed<T>(spent: &mut Duration, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    *spent += start.elapsed();
    result
}

fn summary(outcome: &Outcome<'_>, elapsed: Duration) -> String {
    let Outcome { shape, cloud, abstraction, .. } = outcome;
    let part = cloud.part.note().map(|note| format!("; {note}")).unwrap_or_default();
    format!(
        "{}: {}, {} samples{part}\n{}, mean distance {}, {} samples unassigned, {:.1} s",
        shape.name,
        contents(shape),
        cloud.points.len(),
        primitives(abstraction.primitives.len()),
        length(abstraction.figures.mean_distance),
        abstraction.figures.unassigned,
        elapsed.as_secs_f64()
    )
}

fn primitives(count: usize) -> String {
    format!("{count} {}", if count == 1 { "primitive" } else { "primitives" })
}

/// What a shape is made of, for people.
pub(super) fn contents(shape: &Shape) -> String {
    match &shape.geometry {
        ShapeGeometry::Mesh(mesh) => {
            format!("mesh of {} vertices and {} faces", mesh.vertices.len(), mesh.faces.len())
        }
        ShapeGeometry::Cloud(cloud) => format!("cloud of {} points", cloud.points.len()),
    }
}

/// Three significant digits, whatever the unit.
pub(super) fn length(value: f64) -> String {
    if value == 0.0 || (1e-4..1e6).contains(&value) {
        let digits = if value > 0.0 { (2.0 - value.log10().floor()).max(0.0) } else { 0.0 };
        format!("{value:.*}", digits as usize)
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_three_digits_at_any_scale() {
        let shown = [0.0, 0.012345, 1.23456, 98765.4, 1.2345e-9, 1e12].map(length);
        assert_eq!(shown, ["0", "0.0123", "1.23", "98765", "1.23e-9", "1.00e12"]);
    }
}
