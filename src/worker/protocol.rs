//! The only types that cross between the worker's thread and its owner.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

pub use crate::geometry::SamplingOptions;
use crate::geometry::brief::Brief;
use crate::geometry::metrics::Metrics;
use crate::geometry::palette::Colors;
use crate::geometry::{Bulk, SampleCloud};
use crate::inference::{
    Abstraction, Cancel, Checkpoint, Edit, MergeProposal, MergeReport, Occurrence, Params,
};
use crate::io::{ExportOptions, Format, Shape};

/// Where a shape comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    File(PathBuf),
    /// The shape that is built into the program.
    BuiltIn,
}

/// What the owner asks of the worker. Commands are answered in order; a
/// command that starts long work can be overtaken by `Pause` and by a newer
/// `Load` or `Reset` (they raise the cancel flag on their way in).
#[derive(Debug, Clone)]
pub enum Command {
    /// Read and sample a shape. On failure the present state stays.
    Load { source: Source, sampling: SamplingOptions },
    /// Sample the present shape anew and start over.
    Resample(SamplingOptions),
    /// Use these parameters from the next step on.
    SetParams(Params),
    /// Make the whole run anew with this setup, as fast as it goes and out of
    /// sight: the present state stays until [`Event::LiveFinished`] replaces it by
    /// the finished one. Of the renewals that wait only the latest is made. The
    /// one under way comes first, unless this one is to be made `at_once`: then
    /// it is cancelled. Commands that need a state at rest wait for the renewal.
    Renew { setup: Setup, at_once: bool },
    /// Iterate until the run is finished (or paused). A finished run, and one of
    /// another algorithm than the parameters ask for, starts anew.
    Run,
    /// Stop after (or within) the present step; nothing is lost.
    Pause,
    /// Make the next step of the run.
    StepIteration,
    /// Go on from an earlier state, at rest: what was going on is cancelled, and
    /// what it still had to tell is never heard. Parameters are those of the
    /// state until the next `SetParams`.
    Resume(State),
    /// Change the present state by hand; a run that is going on goes on from
    /// there.
    Edit(Edit),
    /// Go on with a finished run for that many further iterations.
    Extend(u32),
    /// Find the best merge of a pair that is not among these (by ids), or judge
    /// that of the pair `of`; answered by [`Event::Proposed`]. Nothing changes.
    ProposeMerge { of: Option<(u32, u32)>, skipped: Bulk<Vec<(u32, u32)>> },
    /// Merge until no pair is acceptable.
    MergeAll,
    /// Back to the start, with the present parameters.
    Reset,
    /// Write a state to a file.
    Export(Box<ExportRequest>),
    /// Take the primitives of a file in place of those of the present state.
    TakeFrom(PathBuf),
    /// Measure a state, besides whatever else goes on; answered by
    /// [`Event::Measuring`] and [`Event::Measured`].
    Measure(State),
    /// Estimate the Chamfer distance of these states, one after the other, on
    /// one core and whenever nothing else is to be measured; in place of those
    /// that still wait. Answered by [`Event::Estimated`], one for each.
    Estimate(Bulk<Vec<State>>),
    /// How fast `Run` and `MergeAll` go from step to step.
    SetPace(Pace),
    /// Make whole runs with several seeds, besides whatever else goes on, in
    /// place of those that were asked for before; answered by [`Event::Seeds`].
    RunSeeds(Box<SeedRequest>),
}

impl Command {
    /// Whether the command stops what is going on, and what was sent before it
    /// and has not begun.
    pub fn interrupts(&self) -> bool {
        matches!(
            self,
            Self::Load { .. }
                | Self::Resample(_)
                | Self::Reset
                | Self::Resume(_)
                | Self::Pause
                | Self::Renew { at_once: true, .. }
        )
    }
}

impl Command {
    /// Whether the worker answers by what it does then, an [`Event::Activity`].
    pub(super) fn asks(&self) -> bool {
        match self {
            Self::SetParams(_)
            | Self::SetPace(_)
            | Self::Renew { .. }
            | Self::Measure(_)
            | Self::Estimate(_)
            | Self::RunSeeds(_) => false,
            Self::Load { .. }
            | Self::Resample(_)
            | Self::Reset
            | Self::Run
            | Self::Pause
            | Self::StepIteration
            | Self::MergeAll
            | Self::Resume(_)
            | Self::Edit(_)
            | Self::TakeFrom(_)
            | Self::Extend(_)
            | Self::ProposeMerge { .. }
            | Self::Export(_) => true,
        }
    }

    /// Whether nothing is lost if `earlier`, sent just before, is never obeyed.
    pub(super) fn replaces(&self, earlier: &Self) -> bool {
        match self {
            Self::SetParams(_) => matches!(earlier, Self::SetParams(_)),
            Self::Renew { .. } => matches!(earlier, Self::SetParams(_) | Self::Renew { .. }),
            _ => false,
        }
    }

    /// Whether the command is about a state at rest, and waits for the renewal
    /// that is under way.
    pub(super) fn waits_for_renewal(&self) -> bool {
        match self {
            Self::Run
            | Self::StepIteration
            | Self::Edit(_)
            | Self::TakeFrom(_)
            | Self::Extend(_)
            | Self::ProposeMerge { .. }
            | Self::MergeAll => true,
            Self::Load { .. }
            | Self::Resample(_)
            | Self::Resume(_)
            | Self::Export(_)
            | Self::Measure(_)
            | Self::Estimate(_)
            | Self::SetParams(_)
            | Self::Renew { .. }
            | Self::Pause
            | Self::Reset
            | Self::SetPace(_)
            | Self::RunSeeds(_) => false,
        }
    }
}

/// What is to be written, and how.
#[derive(Debug, Clone)]
pub struct ExportRequest {
    pub path: PathBuf,
    pub format: Format,
    pub options: ExportOptions,
    pub state: State,
    /// Of the primitives and their points.
    pub colors: Arc<Colors>,
}

/// All that a run is made from, but for the shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    pub params: Params,
    pub sampling: SamplingOptions,
}

/// A finished run that takes the place of the present one.
pub struct LiveResult {
    pub setup: Setup,
    /// What the states belong to; the same as before where it was not sampled
    /// anew.
    pub loaded: Arc<LoadedShape>,
    /// The state after every step, the start first; never empty.
    pub states: Vec<Arc<Snapshot>>,
}

impl fmt::Debug for LiveResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Renewed")
            .field("setup", &self.setup)
            .field("loaded", &self.loaded.shape.name)
            .field("states", &self.states.len())
            .finish()
    }
}

/// How fast a run goes from step to step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// No waiting.
    #[default]
    Unlimited,
    /// At most this many steps a second, so that a person can follow; at least 1.
    PerSecond(u32),
}

impl Pace {
    /// The least time from one step to the next.
    pub fn interval(self) -> Duration {
        match self {
            Self::Unlimited => Duration::ZERO,
            Self::PerSecond(steps) => Duration::from_secs(1) / steps.max(1),
        }
    }
}

/// A shape that has been read and sampled.
#[derive(Debug)]
pub struct LoadedShape {
    /// Counts loads, so that late snapshots of another shape can be told apart.
    pub generation: u64,
    /// Shared, so that sampling anew doesn't copy the shape.
    pub shape: Arc<Shape>,
    pub cloud: Arc<SampleCloud>,
    pub sampling: SamplingOptions,
}

/// A state with what it belongs to.
#[derive(Clone)]
pub struct State {
    pub loaded: Arc<LoadedShape>,
    pub snapshot: Arc<Snapshot>,
}

impl fmt::Debug for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { loaded, snapshot } = self;
        let (name, iteration) = (&loaded.shape.name, snapshot.abstraction.iteration);
        write!(f, "State {{ shape: {name:?}, key: {}, iteration: {iteration} }}", snapshot.key)
    }
}

/// What led to a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// A run started.
    Start,
    /// An iteration, or another step of the run.
    Step,
    /// A merge that was asked for.
    Merge,
    /// A change by hand.
    Edit,
}

impl Cause {
    /// Whether a person did it, and no run would do it again.
    pub fn is_manual(self) -> bool {
        matches!(self, Self::Merge | Self::Edit)
    }
}

/// The state after a step.
#[derive(Clone)]
pub struct Snapshot {
    /// Names this state, in this process.
    pub key: u64,
    /// The [`LoadedShape`] this belongs to.
    pub generation: u64,
    /// Counts the runs (starts and resets) of this generation.
    pub run: u64,
    pub abstraction: Abstraction,
    /// From which a run goes on.
    pub checkpoint: Arc<Checkpoint>,
    pub cause: Cause,
    /// The parameters in force in the step that led here.
    pub params: Params,
    /// The parameters that the run was started with: its algorithm, K and seed.
    pub start: Params,
    /// What happened in that step.
    pub occurrences: Vec<Occurrence>,
    /// Time spent in the run's steps; pauses and waiting for the pace are not
    /// counted.
    pub elapsed: Duration,
}

impl fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Snapshot")
            .field("key", &self.key)
            .field("generation", &self.generation)
            .field("run", &self.run)
            .field("cause", &self.cause)
            .field("abstraction", &self.abstraction)
            .field("occurrences", &Brief::of_told(&self.occurrences))
            .field("elapsed", &self.elapsed)
            .finish_non_exhaustive()
    }
}

impl Snapshot {
    /// A key that no other state of this process has.
    pub fn new_key() -> u64 {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        NEXT.fetch_add(1, Ordering::Relaxed)
    }
}

/// What a state comes to against the shape that was read.
#[derive(Debug, Clone)]
pub struct Measurement {
    pub snapshot: Arc<Snapshot>,
    /// The figures that `evaluate` gives with its own settings, or why there
    /// are none.
    pub result: Result<Metrics, String>,
}

/// Runs that differ in nothing but their seed.
#[derive(Debug, Clone)]
pub struct SeedRequest {
    /// Names the request among others.
    pub number: u64,
    /// What they run on: its cloud, and what is locked in it.
    pub state: State,
    /// Of the state's primitives: what stands for the same part gets the same.
    pub colors: Arc<Colors>,
    /// Of the first run; each further one has the next seed.
    pub params: Params,
    pub count: u32,
    /// Stops them; what is finished stays.
    pub cancel: Cancel,
}

impl SeedRequest {
    pub fn seeds(&self) -> impl Iterator<Item = u64> + use<> {
        let first = self.params.seed;
        (0..u64::from(self.count)).map(move |i| first.wrapping_add(i))
    }
}

/// A finished run with one of several seeds.
pub struct SeedRun {
    pub seed: u64,
    /// What its states belong to.
    pub loaded: Arc<LoadedShape>,
    /// The state after every step, the start first; of large clouds the first
    /// and the last only. Never empty.
    pub states: Vec<Arc<Snapshot>>,
    /// Of its primitives.
    pub colors: Arc<Colors>,
}

impl fmt::Debug for SeedRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SeedRun")
            .field("seed", &self.seed)
            .field("loaded", &self.loaded.shape.name)
            .field("states", &self.states.len())
            .field("colors", &self.colors)
            .finish()
    }
}

/// How far runs with several seeds have come.
#[derive(Debug, Clone)]
pub enum SeedNews {
    /// The share of the iterations that the run with this seed has made.
    Progress {
        seed: u64,
        share: f32,
    },
    Finished(Arc<SeedRun>),
    /// What a finished run comes to against the shape.
    Measured {
        seed: u64,
        measurement: Arc<Measurement>,
    },
    /// No more of them can be made.
    Failed {
        what: String,
        error: String,
    },
    /// All that was asked for was made, or was stopped.
    Over,
}

/// What the worker is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Activity {
    #[default]
    Idle,
    Loading,
    Running,
    Merging,
    /// Making the run anew while the last result stands; told as `Running`
    /// where it takes so long that a person may want to stop it.
    LiveRun,
    Writing,
}

/// What the worker tells its owner.
#[derive(Debug, Clone)]
pub enum Event {
    Loaded(Arc<LoadedShape>),
    Snapshot(Arc<Snapshot>),
    Activity(Activity),
    /// A renewal has begun.
    LiveStarted(Setup),
    /// A renewal was finished and is now the present run.
    LiveFinished(Arc<LiveResult>),
    /// A step of `MergeAll`, told after its snapshot: the accepted pair, or
    /// `None` if no pair is left, with which it ends.
    MergeStep(Option<MergeReport>),
    /// The answer to `ProposeMerge`; `None` where no pair is left to judge.
    Proposed(Option<Box<MergeProposal>>),
    /// Before the worker is idle again: the state at which steps, merges or a
    /// run came to rest is being measured, besides whatever comes next.
    Measuring(Arc<Snapshot>),
    /// Sooner or later after that, unless a later state took its place.
    Measured(Arc<Measurement>),
    /// The Chamfer distance of the state with this key, roughly.
    Estimated {
        key: u64,
        chamfer_l1: Option<f64>,
    },
    /// How far the runs of a request have come, by its number.
    Seeds {
        request: u64,
        news: SeedNews,
    },
    /// A file was written, whole, with those beside it that it refers to.
    Written {
        path: PathBuf,
        format: Format,
        /// What of the state the file can't say, one sentence each.
        notes: Vec<String>,
    },
    /// Something went wrong; the state is what it was before.
    Failed {
        what: String,
        error: String,
    },
    /// A thread has ended in a fault that nothing had caught, and another has
    /// taken its place: what was asked of it and not answered is not done. That
    /// of the sampler has neither shape nor parameters yet.
    Ended {
        who: Helper,
        error: String,
    },
}

/// The threads of the worker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Helper {
    /// That makes the run, and all else that is ordered.
    Sampler,
    /// That measures states.
    Measurer,
    /// That makes runs with other seeds.
    Seeds,
}

impl Event {
    /// Whether it tells of the worker's present state, and means nothing any
    /// more once another was resumed.
    pub(super) fn is_of_present(&self) -> bool {
        match self {
            Self::Loaded(_)
            | Self::Snapshot(_)
            | Self::LiveStarted(_)
            | Self::LiveFinished(_)
            | Self::MergeStep(_)
            | Self::Proposed(_) => true,
            // Has a number of its own.
            Self::Activity(_)
            | Self::Measuring(_)
            | Self::Measured(_)
            | Self::Estimated { .. }
            | Self::Seeds { .. }
            | Self::Written { .. }
            | Self::Failed { .. }
            | Self::Ended { .. } => false,
        }
    }
}
