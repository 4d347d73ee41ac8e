//! A run without a window: one shape, with its output files.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::bail;
use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::Point3;

use super::interrupt::until_done_or_interrupted;
use super::job::{Finished, Stage};
use super::output::say;
use crate::geometry::SamplingOptions;
use crate::inference::{Cancel, Params};
use crate::io::{self, Exported, Inputs, Outcome, Shape, ShapeGeometry};
use crate::worker::Source;

/// A whole run, from a shape to its files.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadlessJob {
    pub source: Source,
    /// Places that the shape was seen from, in its units; where there are none,
    /// those that its file names.
    pub viewpoints: Vec<Point3<f64>>,
    pub sampling: SamplingOptions,
    pub params: Params,
    /// Folder for the results.
    pub output: PathBuf,
    /// Names of more files for the folder, each of which tells its format.
    pub exports: Vec<String>,
    /// Print only errors and warnings.
    pub quiet: bool,
}

impl HeadlessJob {
    /// Does the job: progress goes to standard error if that is a terminal,
    /// a summary to standard output. On failure, and when Ctrl-C is pressed,
    /// nothing is written.
    pub fn run(&self) -> ExitCode {
        until_done_or_interrupted(|cancel| {
            let summary = self.work(cancel)?;
            Ok(if self.quiet { String::new() } else { summary + "\n" })
        })
    }

    fn work(&self, cancel: &Cancel) -> anyhow::Result<String> {
        if self.output.exists() && !self.output.is_dir() {
            bail!("{} is not a folder; choose another one for the results", self.output.display());
        }
        let mut inputs = Inputs::default();
        if let Source::File(path) = &self.source {
            inputs.add(path);
        }
        inputs.check(io::run_outputs(&self.output, &self.exports))?;
        let whole = Instant::now();
        // How many steps the recovery of primitives takes is not known beforehand.
        let (bar, template) = match self.params.steps() {
            _ if self.quiet => (ProgressBar::hidden(), ""),
            Some(steps) => (ProgressBar::new(steps.into()), "{bar:30} {pos}/{len} {elapsed} {msg}"),
            None => (ProgressBar::no_length(), "{spinner} {pos} {elapsed} {msg}"),
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let finished =
            Finished::make(&self.source, &self.viewpoints, self.sampling, self.params, cancel, |stage| {
                match stage {
                    Stage::Reading => bar.set_message("reading"),
                    Stage::Read(shape) => {
                        for note in shape.notes.iter().filter(|_| !self.quiet) {
                            bar.suspend(|| say(&format!("{}: {note}", shape.name)));
                        }
                    }
                    Stage::Sampling => bar.set_message("sampling"),
                    Stage::Starting => bar.set_message("starting"),
                    Stage::Step { iteration, clusters } => {
                        bar.set_position(u64::from(iteration));
                        bar.set_message(primitives(clusters));
                    }
                }
            })?;
        bar.finish_and_clear();
        let Exported { files, notes } = finished.write(&self.output, &self.output, &self.exports)?;
        for note in notes.iter().filter(|_| !self.quiet) {
            say(note);
        }
        let names = files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>().join(", ");
        Ok(format!("{}\nwrote {names}", summary(&finished.outcome(), whole.elapsed())))
    }
}

fn summary(outcome: &Outcome<'_>, elapsed: Duration) -> String {
    let Outcome { shape, cloud, abstraction, .. } = outcome;
    let notes = [cloud.part.note(), abstraction.sighting.note()];
    let notes: String = notes.into_iter().flatten().map(|note| format!("; {note}")).collect();
    format!(
        "{}: {}, {} samples{notes}\n{}, mean distance {}, {} samples unassigned, {:.1} s",
        shape.name,
        contents(shape),
        cloud.points.len(),
        primitives(abstraction.primitives.len()),
        length(abstraction.figures.mean_distance),
        abstraction.figures.unassigned,
        elapsed.as_secs_f64()
    )
}

/// "1 primitive", "3 primitives".
pub(super) fn primitives(count: usize) -> String {
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
