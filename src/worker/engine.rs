//! The worker's side of the channels: a loop that obeys orders and, between
//! them, makes the steps of the work at hand.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError};
use std::time::Instant;

use super::channel::{NumberedCommand, NumberedEvent, Wake};
use super::machine::Steppable;
use super::measure::{Measurer, References};
use super::pacer::Pacer;
use super::protocol::{
    Activity, Cause, Command, Event, ExportRequest, SeedNews, SeedRequest, Setup, Snapshot, State,
};
use super::seeds::SeedRunner;
use super::source;
use super::trouble::{Stop, Trouble, guarded};
use crate::inference::{Cancel, Occurrence, Params};
use live_run::LiveRun;
use present::Present;

mod by_hand;
mod live_run;
mod loading;
mod present;
mod renewal;
mod stepping;

/// What the engine does when no order waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Goal {
    Nothing,
    Run,
    StepIteration,
    MergeAll,
    Renew,
    /// Nothing any more, but the next renewal is likely to come soon.
    Linger,
}

pub(super) struct Engine<M> {
    orders: Receiver<NumberedCommand>,
    events: SyncSender<NumberedEvent>,
    wake: Arc<Wake>,
    measurer: Measurer,
    seeds: SeedRunner<M>,
    cancel: Cancel,
    /// That of the last order.
    epoch: u64,
    /// That of the latest order; one that was held is older.
    asked: u64,
    params: Params,
    pacer: Pacer,
    work: Goal,
    present: Option<Present<M>>,
    /// The run that is to replace the present one; there while `work` is
    /// [`Goal::Renew`].
    renewal: Option<LiveRun<M>>,
    /// What the next renewal is made with.
    next_setup: Option<Setup>,
    /// Renewals have taken so long that this was told.
    renews_slowly: bool,
    /// Orders that wait for the renewal.
    held: VecDeque<NumberedCommand>,
    generation: u64,
    owner_is_gone: bool,
}

impl<M: Steppable> Engine<M> {
    pub(super) fn new(
        orders: Receiver<NumberedCommand>,
        events: SyncSender<NumberedEvent>,
        wake: Arc<Wake>,
    ) -> Self {
        let references = References::default();
        Self {
            orders,
            measurer: Measurer::spawn(events.clone(), &wake, references.clone()),
            seeds: SeedRunner::spawn(events.clone(), &wake, references),
            events,
            wake,
            cancel: Cancel::default(),
            epoch: 0,
            asked: 0,
            params: Params::default(),
            pacer: Pacer::new(Instant::now()),
            work: Goal::Nothing,
            present: None,
            renewal: None,
            next_setup: None,
            renews_slowly: false,
            held: VecDeque::new(),
            generation: 0,
            owner_is_gone: false,
        }
    }

    /// Runs until the owner is gone.
    pub(super) fn run(mut self) {
        while !self.owner_is_gone {
            match self.next_order() {
                Some(order) if self.renewal.is_some() && order.command.waits_for_renewal() => {
                    self.held.push_back(order);
                }
                Some(order) => {
                    self.cancel = order.cancel;
                    self.epoch = order.epoch;
                    self.asked = self.asked.max(order.asked);
                    self.obey(order.command);
                }
                None if self.owner_is_gone => return,
                None => self.advance(),
            }
        }
    }

    /// The next order; `None` if it is time for a step instead.
    fn next_order(&mut self) -> Option<NumberedCommand> {
        if let Some(order) = self.next_held_order() {
            return Some(order);
        }
        // A raised flag says that an order is on its way: the step would only be cancelled.
        if self.work == Goal::Nothing || self.cancel.is_requested() {
            let order = self.orders.recv().ok();
            self.owner_is_gone = order.is_none();
            return order;
        }
        let wait = self.pacer.wait(Instant::now());
        if wait.is_zero() {
            match self.orders.try_recv() {
                Ok(order) => Some(order),
                Err(TryRecvError::Empty) => None,
                Err(TryRecvError::Disconnected) => {
                    self.owner_is_gone = true;
                    None
                }
            }
        } else {
            match self.orders.recv_timeout(wait) {
                Ok(order) => Some(order),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => {
                    self.owner_is_gone = true;
                    None
                }
            }
        }
    }

    /// The next order that has waited long enough and was not interrupted.
    fn next_held_order(&mut self) -> Option<NumberedCommand> {
        if self.renewal.is_some() {
            return None;
        }
        while let Some(order) = self.held.pop_front() {
            if !order.cancel.is_requested() {
                return Some(order);
            }
        }
        None
    }

    fn obey(&mut self, command: Command) {
        match command {
            Command::SetParams(params) => {
                self.set_params(params);
                return;
            }
            Command::SetPace(pace) => {
                self.pacer.set(pace, Instant::now());
                return;
            }
            Command::Renew { setup, at_once } => {
                self.renew(setup, at_once);
                return;
            }
            Command::Measure(state) => {
                self.measure(&state);
                return;
            }
            Command::Estimate(states) => {
                self.measurer.estimate(&states);
                return;
            }
            Command::RunSeeds(request) => {
                self.run_seeds(*request);
                return;
            }
            Command::Export(request) => self.export(&request),
            Command::TakeFrom(path) => self.take_from(&path),
            Command::Load { source, sampling } => {
                let interrupted = self.halt(Activity::Loading);
                if !self.load(&source, sampling) {
                    self.work = interrupted;
                }
            }
            Command::Resample(sampling) => {
                let interrupted = self.halt(Activity::Loading);
                if !self.resample(sampling) {
                    self.work = interrupted;
                }
            }
            Command::Reset => {
                let _ = self.halt(Activity::Loading);
                self.drop_renewal();
                self.restart();
            }
            Command::Run => {
                let algorithm = self.params.algorithm;
                let is_over =
                    |p: &Present<M>| p.machine.is_finished() || p.machine.params().algorithm != algorithm;
                // A run that can't start anew stays as it is, and says why.
                let ready = !self.present.as_ref().is_some_and(is_over) || self.restart();
                self.begin(if ready { Goal::Run } else { Goal::Nothing });
            }
            Command::Pause => {
                self.drop_renewal();
                self.work = Goal::Nothing;
            }
            Command::StepIteration => self.begin(Goal::StepIteration),
            Command::MergeAll => self.begin(Goal::MergeAll),
            Command::Resume(state) => {
                self.drop_renewal();
                self.work = Goal::Nothing;
                self.resume(&state);
            }
            Command::Edit(edit) => self.edit(&edit),
            Command::Extend(iterations) => {
                let ready = self.extend(iterations);
                self.begin(if ready { Goal::Run } else { Goal::Nothing });
            }
            Command::ProposeMerge { of, skipped } => self.propose_merge(of, &skipped),
        }
        self.announce();
    }

    /// Whether they were taken.
    fn set_params(&mut self, params: Params) -> bool {
        if let Err(error) = params.check() {
            self.fail("Invalid parameters", error);
            return false;
        }
        self.params = params;
        if let Some(present) = &mut self.present
            && let Err(error) = present.machine.set_params(params)
        {
            let error = source::chain(&error);
            self.fail("Invalid parameters", error);
            return false;
        }
        true
    }

    fn begin(&mut self, work: Goal) {
        if self.present.is_none() {
            self.fail("Nothing to run", "no shape is loaded; open one first");
            return;
        }
        self.work = work;
        self.pacer.make_due(Instant::now());
    }

    /// Lays the work down for another activity; what it was.
    fn halt(&mut self, activity: Activity) -> Goal {
        self.emit(Event::Activity(activity));
        std::mem::replace(&mut self.work, Goal::Nothing)
    }

    fn export(&mut self, request: &ExportRequest) {
        self.emit(Event::Activity(Activity::Writing));
        let ExportRequest { path, format, .. } = request;
        let failure = format!("Cannot write {}", path.display());
        let outcome = guarded(|| source::export(request).map_err(|error| Stop::trouble(failure, error)));
        match outcome {
            Ok(notes) => self.emit(Event::Written { path: path.clone(), format: *format, notes }),
            Err(stop) => self.report(stop),
        }
    }

    fn report(&mut self, stop: Stop) {
        match stop {
            Stop::Cancelled => {}
            Stop::Trouble(Trouble { what, error }) => self.fail(what, error),
        }
    }

    fn fail(&mut self, what: impl Into<String>, error: impl Into<String>) {
        self.emit(Event::Failed { what: what.into(), error: error.into() });
    }

    /// Has the state measured that the work came to rest at.
    fn measure_present(&mut self) {
        let Some(present) = &mut self.present else { return };
        if let Some(snapshot) = present.unmeasured.take() {
            let loaded = Arc::clone(&present.shape);
            self.measure(&State { loaded, snapshot });
        }
    }

    fn measure(&mut self, state: &State) {
        if self.measurer.measure(state) {
            self.emit(Event::Measuring(Arc::clone(&state.snapshot)));
        }
    }

    fn run_seeds(&mut self, request: SeedRequest) {
        let is_same = |p: &&Present<M>| Arc::ptr_eq(&p.shape.cloud, &request.state.loaded.cloud);
        let like = self.present.as_ref().filter(is_same).map(|p| p.machine.clone());
        let number = request.number;
        if !self.seeds.ask(request, like) {
            self.emit(Event::Seeds { request: number, news: SeedNews::Over });
            self.fail("Cannot run other seeds", "the operating system could not start the threads");
        }
    }

    /// Says what the engine is about to do.
    fn announce(&mut self) {
        if self.work == Goal::Nothing {
            self.measure_present();
        }
        self.emit(Event::Activity(match self.work {
            Goal::Nothing => Activity::Idle,
            Goal::Run | Goal::StepIteration => Activity::Running,
            Goal::MergeAll => Activity::Merging,
            Goal::Renew | Goal::Linger if self.renews_slowly => Activity::Running,
            Goal::Renew | Goal::Linger => Activity::LiveRun,
        }));
    }

    fn emit_step(&mut self, cause: Cause, occurrences: Vec<Occurrence>) {
        let snapshot = self.emit_snapshot(cause, occurrences);
        if let Some(present) = &mut self.present {
            present.unmeasured = snapshot;
        }
    }

    /// Tells the present state, which it returns.
    fn emit_snapshot(&mut self, cause: Cause, occurrences: Vec<Occurrence>) -> Option<Arc<Snapshot>> {
        let present = self.present.as_ref()?;
        let snapshot = Arc::new(Snapshot {
            key: Snapshot::new_key(),
            generation: present.shape.generation,
            run: present.run,
            abstraction: present.abstraction.clone(),
            checkpoint: Arc::new(present.machine.checkpoint()),
            cause,
            params: present.machine.params(),
            start: present.start,
            occurrences,
            elapsed: present.elapsed,
        });
        self.emit(Event::Snapshot(Arc::clone(&snapshot)));
        Some(snapshot)
    }

    /// Waits while the owner is behind, which bounds what is kept for it.
    fn emit(&mut self, event: Event) {
        let of = if matches!(event, Event::Activity(_)) { self.asked } else { self.epoch };
        self.owner_is_gone |= self.events.send((of, event)).is_err();
        (self.wake)();
    }
}
