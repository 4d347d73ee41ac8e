//! Runs with several seeds: their results, sorted.

use std::sync::Arc;

use crate::worker::{LoadedShape, Measurement, SeedRequest, SeedRun, Snapshot};

/// Number of runs per request.
pub const SEEDS: u32 = 8;

/// What the list of runs is sorted by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SeedOrder {
    /// The least error first.
    #[default]
    Error,
    /// The fewest primitives first.
    Primitives,
    Time,
    Seed,
}

impl SeedOrder {
    pub const ALL: [Self; 4] = [Self::Error, Self::Primitives, Self::Time, Self::Seed];

    pub fn text(self) -> &'static str {
        match self {
            Self::Error => "Best first",
            Self::Primitives => "Fewest first",
            Self::Time => "Fastest first",
            Self::Seed => "By seed",
        }
    }

    pub fn tooltip(self) -> &'static str {
        match self {
            Self::Error => {
                "Lowest Chamfer-L1 first, then unmeasured runs by mean error. More primitives usually mean \
                 less error, so compare K as well"
            }
            Self::Primitives => "Smallest number of primitives K first; ties are sorted by error",
            Self::Time => "Shortest computing time first",
            Self::Seed => "In order of the seeds",
        }
    }
}

/// One finished run.
#[derive(Debug, Clone)]
pub struct SeedResult {
    pub run: Arc<SeedRun>,
    /// Measurement of its last state, once available.
    pub measurement: Option<Arc<Measurement>>,
}

impl SeedResult {
    /// Its last state.
    pub fn last(&self) -> Option<&Arc<Snapshot>> {
        self.run.states.last()
    }

    /// Chamfer-L1, in units of the input's longest edge, where it was measured.
    pub fn chamfer(&self) -> Option<f64> {
        self.measurement.as_ref()?.result.as_ref().ok()?.chamfer_l1
    }

    /// Number of primitives.
    pub fn primitives(&self) -> usize {
        self.last().map_or(0, |s| s.abstraction.primitives.len())
    }

    /// Mean distance of the samples to their primitives, in input units.
    pub fn mean_distance(&self) -> f64 {
        self.last().map_or(f64::INFINITY, |s| s.abstraction.figures.mean_distance)
    }

    /// Sorts the better one first.
    fn error(&self) -> (bool, f64) {
        self.chamfer().map_or_else(|| (true, self.mean_distance()), |chamfer| (false, chamfer))
    }
}

/// The runs of the last request.
#[derive(Debug, Clone, Default)]
pub struct Seeds {
    pub order: SeedOrder,
    pub(super) request: Option<SeedRequest>,
    pub(super) is_running: bool,
    /// Seed and share of the run that is being made.
    pub(super) progress: Option<(u64, f32)>,
    /// In the order in which they were made.
    pub(super) results: Vec<SeedResult>,
    /// Requests so far.
    pub(super) count: u64,
}

impl Seeds {
    /// Whether runs or their measurements are still in progress.
    pub fn is_running(&self) -> bool {
        self.is_running
    }

    /// How many runs were asked for.
    pub fn wanted(&self) -> usize {
        self.request.as_ref().map_or(0, |r| r.count as usize)
    }

    /// The seed that is being run, and its share of all its iterations.
    pub fn progress(&self) -> Option<(u64, f32)> {
        self.progress
    }

    /// The share of all that was asked for, within [0, 1].
    pub fn share(&self) -> f32 {
        let part = self.progress.map_or(0.0, |(_, share)| share);
        ((self.results.len() as f32 + part) / self.wanted().max(1) as f32).min(1.0)
    }

    /// In the order in which they were made.
    pub fn results(&self) -> &[SeedResult] {
        &self.results
    }

    /// In the chosen order.
    pub fn sorted(&self) -> Vec<&SeedResult> {
        let mut sorted: Vec<&SeedResult> = self.results.iter().collect();
        let by_error = |a: &&SeedResult, b: &&SeedResult| {
            let ((a_unknown, a), (b_unknown, b)) = (a.error(), b.error());
            a_unknown.cmp(&b_unknown).then(a.total_cmp(&b))
        };
        sorted.sort_by(|a, b| match self.order {
            SeedOrder::Error => by_error(a, b),
            SeedOrder::Primitives => a.primitives().cmp(&b.primitives()).then_with(|| by_error(a, b)),
            SeedOrder::Time => a.last().map(|s| s.elapsed).cmp(&b.last().map(|s| s.elapsed)),
            SeedOrder::Seed => a.run.seed.cmp(&b.run.seed),
        });
        sorted
    }

    /// What they were made from.
    pub fn loaded(&self) -> Option<&Arc<LoadedShape>> {
        self.request.as_ref().map(|r| &r.state.loaded)
    }

    pub(super) fn stop(&self) {
        if let Some(request) = &self.request {
            request.cancel.request();
        }
    }

    /// No more results will arrive.
    pub(super) fn end(&mut self) {
        self.progress = None;
        self.is_running = false;
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.stop();
        *self = Self { order: self.order, count: self.count, ..Self::default() };
    }
}
