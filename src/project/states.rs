//! States and what is made of them as records.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::raw::Raw;
use crate::geometry::SamplingOptions;
use crate::geometry::palette::Colors;
use crate::inference::{
    Abstraction, Checkpoint, Figures, Occurrence, Params, Phase, Primitive, Sighting, UNASSIGNED,
};
use crate::session::camera::Camera;
use crate::session::saving::Summary;
use crate::session::timeline::Origin;
use crate::session::view::View;
use crate::worker::{Cause, Pace, Snapshot};

/// Longer than any run: some 1000 years. What is added to it doesn't overflow.
const LONGEST: Duration = Duration::from_secs(1 << 35);
/// More than any session counts to; as much can be added without an overflow.
const MOST_COUNTED: u64 = 1 << 53;
/// The same of a run's steps.
const MOST_STEPS: u32 = 1 << 24;

/// Whether something can have been counted, and goes on being.
pub(super) fn is_counter(count: u64) -> bool {
    count < MOST_COUNTED
}

/// The state after a step.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct StateEntry<'a> {
    pub(super) generation: u64,
    run: u64,
    cause: Cause,
    params: Params,
    start: Params,
    occurrences: Cow<'a, [Occurrence]>,
    elapsed: Duration,
    phase: Phase,
    iteration: u32,
    labels: Raw<'a, u32>,
    pinned: Raw<'a, u32>,
    primitives: Cow<'a, [Primitive]>,
    figures: Figures,
    #[serde(default)]
    sighting: Sighting,
    checkpoint: Cow<'a, Checkpoint>,
}

impl<'a> From<&'a Snapshot> for StateEntry<'a> {
    fn from(state: &'a Snapshot) -> Self {
        let Abstraction { phase, iteration, labels, pinned, primitives, figures, sighting } =
            &state.abstraction;
        Self {
            generation: state.generation,
            run: state.run,
            cause: state.cause,
            params: state.params,
            start: state.start,
            occurrences: Cow::Borrowed(&state.occurrences),
            elapsed: state.elapsed,
            phase: *phase,
            iteration: *iteration,
            labels: Raw::of(labels),
            pinned: Raw::of(pinned),
            primitives: Cow::Borrowed(primitives),
            figures: *figures,
            sighting: *sighting,
            checkpoint: Cow::Borrowed(&state.checkpoint),
        }
    }
}

impl StateEntry<'_> {
    /// The state under a key of this process, if it can be one.
    pub(super) fn checked(self) -> Result<Snapshot, &'static str> {
        let (labels, pinned) = (self.labels.into_vec(), self.pinned.into_vec());
        let ids: BTreeSet<u32> = self.primitives.iter().map(|p| p.id).collect();
        if ids.len() != self.primitives.len() {
            return Err("has two primitives with the same id");
        }
        if !labels.iter().all(|label| *label == UNASSIGNED || ids.contains(label)) {
            return Err("has a label that refers to a missing primitive");
        }
        if !self.primitives.iter().all(|p| p.shape.is_valid()) {
            return Err("has a primitive with an invalid parameter");
        }
        if !is_ascending(&pinned, labels.len()) {
            return Err("pins a sample that does not exist");
        }
        if self.params.check().is_err() || self.start.check().is_err() {
            return Err("has a parameter out of range");
        }
        let assigned = self.primitives.iter().try_fold(0usize, |sum, p| sum.checked_add(p.points));
        if assigned.is_none_or(|assigned| assigned > labels.len())
            || self.figures.unassigned > labels.len()
            || ![self.generation, self.run, self.figures.clusters as u64].into_iter().all(is_counter)
            || self.iteration >= MOST_STEPS
        {
            return Err("has a counter out of range");
        }
        if self.elapsed > LONGEST {
            return Err("has a duration out of range");
        }
        let is_distance = |d: f64| d.is_finite() && d >= 0.0;
        let distances = self.primitives.iter().flat_map(|p| [p.sigma, p.mean_distance]);
        if !distances.chain([self.figures.mean_distance]).all(is_distance) {
            return Err("has a value out of range");
        }
        if self.checkpoint.check(labels.len()).is_err() {
            return Err("has a checkpoint that a run cannot continue from");
        }
        let abstraction = Abstraction {
            phase: self.phase,
            iteration: self.iteration,
            labels: labels.into(),
            pinned: pinned.into(),
            primitives: self.primitives.into_owned().into(),
            // What can't be plotted is not worth the session.
            figures: Figures { log_joint: self.figures.log_joint.filter(|l| l.is_finite()), ..self.figures },
            sighting: self.sighting,
        };
        Ok(Snapshot {
            key: Snapshot::new_key(),
            generation: self.generation,
            run: self.run,
            abstraction,
            checkpoint: Arc::new(self.checkpoint.into_owned()),
            cause: self.cause,
            params: self.params,
            start: self.start,
            occurrences: self.occurrences.into_owned(),
            elapsed: self.elapsed,
        })
    }
}

/// Whether these are indices below a limit, each once, in order.
pub(super) fn is_ascending(indices: &[u32], limit: usize) -> bool {
    indices.windows(2).all(|pair| pair[0] < pair[1]) && indices.last().is_none_or(|&i| (i as usize) < limit)
}

/// A branch, with the numbers of the records it is made of.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct BranchEntry<'a> {
    pub(super) id: u32,
    pub(super) name: Cow<'a, str>,
    pub(super) origin: Option<Origin>,
    pub(super) loaded: u32,
    pub(super) states: Vec<u32>,
    pub(super) colors: Cow<'a, Colors>,
}

/// A document, with the numbers of the records it is made of.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct DocumentEntry<'a> {
    pub(super) loaded: Option<u32>,
    pub(super) params: Params,
    pub(super) sampling: SamplingOptions,
    pub(super) branches: Vec<u32>,
    /// Index of the branch that is shown, and of its state.
    pub(super) current: usize,
    pub(super) shown: usize,
    /// Branches so far.
    pub(super) count: u32,
    pub(super) selection: Cow<'a, BTreeSet<u32>>,
    pub(super) selected_points: Raw<'a, u32>,
    pub(super) hidden: Cow<'a, BTreeSet<u32>>,
}

/// The whole session.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct HeadEntry<'a> {
    /// The version of the program.
    pub(super) program: Cow<'a, str>,
    pub(super) summary: Summary,
    /// The generation of the present shape, and the newest of all.
    pub(super) generations: (u64, u64),
    pub(super) document: u32,
    /// Labels and documents, the newest last.
    pub(super) done: Vec<(Cow<'a, str>, u32)>,
    pub(super) undone: Vec<(Cow<'a, str>, u32)>,
    pub(super) pace: Pace,
    pub(super) is_live: bool,
    pub(super) view: View,
    pub(super) camera: Camera,
}
