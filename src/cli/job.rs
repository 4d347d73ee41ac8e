//! A single run: reads a shape, samples it and abstracts it. Used once by `run` and many times by a
//! batch.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use nalgebra::Point3;

use crate::geometry::palette::Colors;
use crate::geometry::{SampleCloud, SamplingOptions};
use crate::inference::{Abstraction, Cancel, InferenceError, Occurrence, Params, Run};
use crate::io::{self, Exported, Outcome, RunRecord, Shape, WriteError};
use crate::worker::Source;

/// How far a run has come.
#[derive(Debug, Clone, Copy)]
pub(super) enum Stage<'a> {
    Reading,
    Read(&'a Shape),
    Sampling,
    Starting,
    /// An iteration, a step or a merge was made.
    Step {
        iteration: u32,
        clusters: usize,
    },
}

/// A finished run with all that it came from.
#[derive(Debug)]
pub(super) struct Finished {
    pub(super) shape: Shape,
    pub(super) cloud: Arc<SampleCloud>,
    pub(super) sampling: SamplingOptions,
    pub(super) params: Params,
    pub(super) abstraction: Abstraction,
    record: RunRecord,
    colors: Colors,
}

impl Finished {
    /// Makes a run from beginning to end. `viewpoints`, in input units, stand in
    /// place of those that the file names.
    ///
    /// # Errors
    /// What stopped it; [`InferenceError::Cancelled`] if that was `cancel`.
    pub(super) fn make(
        source: &Source,
        viewpoints: &[Point3<f64>],
        sampling: SamplingOptions,
        params: Params,
        cancel: &Cancel,
        mut watch: impl FnMut(Stage<'_>),
    ) -> anyhow::Result<Self> {
        let mut record = RunRecord::default();
        watch(Stage::Reading);
        let mut shape = timed(&mut record.times.read, || match source {
            Source::File(path) => io::read(path),
            Source::BuiltIn => io::built_in(),
        })?;
        if !viewpoints.is_empty() {
            shape.viewpoints = viewpoints.to_vec();
        }
        watch(Stage::Read(&shape));
        watch(Stage::Sampling);
        let cloud = timed(&mut record.times.sample, || io::sample(&shape, &sampling))
            .with_context(|| shape.name.clone())?;
        let cloud = Arc::new(cloud);
        watch(Stage::Starting);
        let abstraction = infer(Arc::clone(&cloud), params, cancel, &mut record, watch)
            .with_context(|| shape.name.clone())?;
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled.into());
        }
        Ok(Self { shape, cloud, sampling, params, abstraction, record, colors: Colors::default() })
    }

    /// What the files are made of.
    pub(super) fn outcome(&self) -> Outcome<'_> {
        Outcome {
            colors: &self.colors,
            shape: &self.shape,
            cloud: &self.cloud,
            sampling: self.sampling,
            params: &self.params,
            abstraction: &self.abstraction,
        }
    }

    /// Writes the files of a run and more, by their names, into a folder, all of
    /// them or none: the one place that decides which they are, for one shape
    /// and for many. In the end they are in `home`.
    pub(super) fn write(&self, folder: &Path, home: &Path, more: &[String]) -> Result<Exported, WriteError> {
        let record = RunRecord { home: Some(home.to_owned()), ..self.record.clone() };
        io::write_run(folder, more, &self.outcome(), &record)
    }
}

fn infer(
    cloud: Arc<SampleCloud>,
    params: Params,
    cancel: &Cancel,
    record: &mut RunRecord,
    mut watch: impl FnMut(Stage<'_>),
) -> Result<Abstraction, InferenceError> {
    let times = &mut record.times;
    let mut run = timed(&mut times.start, || Run::new(cloud, params, cancel))?;
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
        watch(Stage::Step { iteration: run.iteration(), clusters });
    }
    let abstraction = run.abstraction();
    abstraction.check()?;
    Ok(abstraction)
}

/// Runs `work` and adds the time it took to `spent`.
fn timed<T>(spent: &mut Duration, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    *spent += start.elapsed();
    result
}
