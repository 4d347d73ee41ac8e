//! A whole run in the making, made step by step out of sight.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::super::machine::Steppable;
use super::super::protocol::{Cause, LiveResult, LoadedShape, SamplingOptions, Setup, Snapshot};
use super::super::source;
use super::super::trouble::Stop;
use super::present::Present;
use crate::inference::{Cancel, Occurrence};

/// A run in the making.
pub(super) struct LiveRun<M> {
    pub(super) setup: Setup,
    /// Nothing else is expected soon.
    pub(super) is_last: bool,
    pub(super) begun: Instant,
    /// The number of the run.
    run: u64,
    shape: Arc<LoadedShape>,
    /// The present run, while it is one on the same cloud.
    like: Option<M>,
    machine: Option<M>,
    /// Time spent in steps.
    elapsed: Duration,
    states: Vec<Arc<Snapshot>>,
}

impl<M: Steppable> LiveRun<M> {
    pub(super) fn new(setup: Setup, is_last: bool, present: &Present<M>) -> Self {
        Self {
            setup,
            is_last,
            begun: Instant::now(),
            run: present.run + 1,
            shape: Arc::clone(&present.shape),
            like: Some(present.machine.clone()),
            machine: None,
            elapsed: Duration::ZERO,
            states: Vec::new(),
        }
    }

    /// Samples, starts or makes one step; whether that was the last.
    pub(super) fn advance(&mut self, cancel: &Cancel) -> Result<bool, Stop> {
        const WHAT: &str = "Cannot repeat the run";
        let Setup { params, sampling } = self.setup;
        if cancel.is_requested() {
            return Err(Stop::Cancelled);
        }
        let begun = Instant::now();
        if let Some(machine) = &mut self.machine {
            let occurrences = machine.step(cancel).map_err(|error| Stop::inference(WHAT, &error))?;
            self.keep(Cause::Step, occurrences, begun);
        } else if self.shape.sampling != sampling {
            self.shape = resampled(&self.shape, sampling).map_err(|error| Stop::trouble(WHAT, error))?;
            self.run = 1;
            self.like = None;
        } else {
            let started = match self.like.take() {
                Some(like) => like.restarted(params, cancel),
                None => M::start(Arc::clone(&self.shape.cloud), params, cancel),
            };
            self.machine = Some(started.map_err(|error| Stop::inference(WHAT, &error))?);
            // As in any run, what comes before the first step is not counted.
            self.keep(Cause::Start, Vec::new(), Instant::now());
        }
        Ok(self.machine.as_ref().is_some_and(M::is_finished))
    }

    /// Keeps the present state, which a step led to that began at `begun`.
    fn keep(&mut self, cause: Cause, occurrences: Vec<Occurrence>, begun: Instant) {
        let Some(machine) = &self.machine else { return };
        let abstraction = machine.abstraction();
        self.elapsed += begun.elapsed();
        self.states.push(Arc::new(Snapshot {
            key: Snapshot::new_key(),
            generation: self.shape.generation,
            run: self.run,
            abstraction,
            checkpoint: Arc::new(machine.checkpoint()),
            cause,
            params: machine.params(),
            start: self.setup.params,
            occurrences,
            elapsed: self.elapsed,
        }));
    }

    /// What it has come to; `None` before its end.
    pub(super) fn finish(self) -> Option<Finished<M>> {
        let (machine, last) = (self.machine?, self.states.last().cloned()?);
        let present = Present {
            shape: Arc::clone(&self.shape),
            run: self.run,
            start: self.setup.params,
            machine,
            abstraction: last.abstraction.clone(),
            elapsed: self.elapsed,
            unmeasured: Some(last),
        };
        let renewed = LiveResult { setup: self.setup, loaded: self.shape, states: self.states };
        Some(Finished { present, renewed })
    }
}

/// What a renewal comes to.
pub(super) struct Finished<M> {
    pub(super) present: Present<M>,
    pub(super) renewed: LiveResult,
}

fn resampled(old: &LoadedShape, sampling: SamplingOptions) -> Result<Arc<LoadedShape>, String> {
    let cloud = source::sample(&old.shape, sampling)?;
    let shape = Arc::clone(&old.shape);
    Ok(Arc::new(LoadedShape { generation: old.generation + 1, shape, cloud, sampling }))
}
