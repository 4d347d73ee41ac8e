//! Making the whole run anew, out of sight, while its parameters are turned.
//!
//! While a slider is dragged, setups come faster than runs end. If each
//! cancelled the run of the one before, none would ever end and the picture
//! would stand still until the hand does. So the run under way is let finish
//! and shown, although the hand has moved on; the next is made with the newest
//! setup, and those between are never begun. That gives as many results as the
//! machine can make, each at most two runs old. Only when the hand rests, which
//! the owner tells by a renewal `at_once`, is a run for an older setup cancelled:
//! then nothing stands between the person and what was asked for last.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::super::machine::Steppable;
use super::super::protocol::{Cause, Event, LiveResult, LoadedShape, SamplingOptions, Setup, Snapshot};
use super::super::source;
use super::super::trouble::{Stop, guarded};
use super::{Engine, Goal, Present};
use crate::inference::{Cancel, Occurrence};

/// How long another setup is waited for before the worker is said to be idle
/// and the result measured: longer than from one to the next of a drag.
const LINGER: Duration = Duration::from_millis(200);
/// A run that takes longer is told as running, so that it can be paused.
const SLOW: Duration = Duration::from_millis(600);

/// A run in the making.
pub(super) struct LiveRun<M> {
    setup: Setup,
    /// Nothing else is expected soon.
    is_last: bool,
    begun: Instant,
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
    fn new(setup: Setup, is_last: bool, present: &Present<M>) -> Self {
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
    fn advance(&mut self, cancel: &Cancel) -> Result<bool, Stop> {
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
    fn finish(self) -> Option<Finished<M>> {
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
struct Finished<M> {
    present: Present<M>,
    renewed: LiveResult,
}

impl<M: Steppable> Engine<M> {
    /// Takes the setup for the renewal to come.
    pub(super) fn renew(&mut self, setup: Setup, at_once: bool) {
        // Where the flag is raised, the order that raised it decides how it goes on.
        if !self.set_params(setup.params) || self.cancel.is_requested() || self.present.is_none() {
            return;
        }
        match &self.renewal {
            Some(under_way) if !at_once => {
                // The hand may have come back to where it was.
                self.next_setup = (under_way.setup != setup).then_some(setup);
            }
            _ => self.begin_renewal(setup, at_once),
        }
    }

    fn begin_renewal(&mut self, setup: Setup, is_last: bool) {
        let Some(present) = &self.present else { return };
        if !matches!(self.work, Goal::Renew | Goal::Linger) {
            self.renews_slowly = false;
        }
        self.renewal = Some(LiveRun::new(setup, is_last, present));
        self.next_setup = None;
        self.emit(Event::LiveStarted(setup));
        if self.work != Goal::Renew {
            self.begin(Goal::Renew);
            self.announce();
        }
    }

    pub(super) fn drop_renewal(&mut self) {
        self.renewal = None;
        self.next_setup = None;
    }

    pub(super) fn advance_renewal(&mut self) {
        let cancel = self.cancel.clone();
        let Some(renewal) = &mut self.renewal else {
            self.work = Goal::Nothing;
            self.announce();
            return;
        };
        match guarded(|| renewal.advance(&cancel)) {
            Ok(false) => {
                if !self.renews_slowly && renewal.begun.elapsed() > SLOW {
                    self.renews_slowly = true;
                    self.announce();
                }
            }
            Ok(true) => self.take_renewed(),
            // The order that cancelled the step decides how it goes on.
            Err(Stop::Cancelled) => {}
            Err(stop) => {
                self.drop_renewal();
                self.work = Goal::Nothing;
                self.report(stop);
                self.announce();
            }
        }
    }

    /// Makes the finished renewal the present run, and goes on to the next.
    fn take_renewed(&mut self) {
        let Some(renewal) = self.renewal.take() else { return };
        let is_last = renewal.is_last;
        self.renews_slowly &= renewal.begun.elapsed() > SLOW;
        let Some(Finished { present, renewed }) = renewal.finish() else { return };
        self.generation = present.shape.generation;
        self.present = Some(present);
        self.emit(Event::LiveFinished(Arc::new(renewed)));
        if let Some(setup) = self.next_setup.take() {
            self.begin_renewal(setup, false);
        } else if is_last || !self.held.is_empty() {
            self.work = Goal::Nothing;
            self.announce();
        } else {
            self.work = Goal::Linger;
            self.pacer.make_due(Instant::now() + LINGER);
        }
    }
}

fn resampled(old: &LoadedShape, sampling: SamplingOptions) -> Result<Arc<LoadedShape>, String> {
    let cloud = source::sample(&old.shape, sampling)?;
    let shape = Arc::clone(&old.shape);
    Ok(Arc::new(LoadedShape { generation: old.generation + 1, shape, cloud, sampling }))
}
