//! The worker's side of the channels: a loop that obeys orders and, between
//! them, makes the steps of the work at hand.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError};
use std::time::{Duration, Instant};

use super::Wake;
use super::machine::Machine;
use super::measure::Measurer;
use super::protocol::{Activity, Command, Event, LoadedShape, Pace, SamplingOptions, Snapshot, Source};
use super::source::{self, Part};
use crate::geometry::SampleCloud;
use crate::inference::{Abstraction, Cancel, InferenceError, MergeReport, Occurrence, Params};
use crate::io::Shape;

/// A command with the flag that stops it.
#[derive(Debug)]
pub(super) struct Order {
    pub(super) command: Command,
    pub(super) cancel: Cancel,
}

/// What the engine does when no order waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Work {
    Nothing,
    Run,
    StepIteration,
    StepMerge,
    MergeAll,
}

/// A shape with its run.
struct Present<M> {
    shape: Arc<LoadedShape>,
    run: u64,
    start: Params,
    machine: M,
    abstraction: Abstraction,
    elapsed: Duration,
    /// The state that the last step led to, until it is measured or the run
    /// starts anew.
    unmeasured: Option<Arc<Snapshot>>,
}

/// What one step came to.
enum Step {
    Iterated(Vec<Occurrence>),
    Merged(Option<MergeReport>),
}

/// Something that a person has to be told.
struct Trouble {
    what: String,
    error: String,
}

/// The work was cancelled, or there is trouble.
enum Stop {
    Cancelled,
    Trouble(Trouble),
}

impl Stop {
    fn trouble(what: impl Into<String>, error: impl Into<String>) -> Self {
        Self::Trouble(Trouble { what: what.into(), error: error.into() })
    }

    fn inference(what: &str, error: &InferenceError) -> Self {
        match error {
            InferenceError::Cancelled => Self::Cancelled,
            other => Self::trouble(what, source::chain(other)),
        }
    }
}

pub(super) struct Engine<M> {
    orders: Receiver<Order>,
    events: SyncSender<Event>,
    wake: Arc<Wake>,
    measurer: Measurer,
    cancel: Cancel,
    params: Params,
    pace: Pace,
    work: Work,
    next_step: Instant,
    present: Option<Present<M>>,
    generation: u64,
    owner_is_gone: bool,
}

impl<M: Machine> Engine<M> {
    pub(super) fn new(orders: Receiver<Order>, events: SyncSender<Event>, wake: Arc<Wake>) -> Self {
        Self {
            orders,
            measurer: Measurer::spawn(events.clone(), &wake),
            events,
            wake,
            cancel: Cancel::default(),
            params: Params::default(),
            pace: Pace::default(),
            work: Work::Nothing,
            next_step: Instant::now(),
            present: None,
            generation: 0,
            owner_is_gone: false,
        }
    }

    /// Runs until the owner is gone.
    pub(super) fn run(mut self) {
        while !self.owner_is_gone {
            match self.next_order() {
                Some(order) => {
                    self.cancel = order.cancel;
                    self.obey(order.command);
                }
                None if self.owner_is_gone => return,
                None => self.advance(),
            }
        }
    }

    /// The next order; `None` if it is time for a step instead.
    fn next_order(&mut self) -> Option<Order> {
        // A raised flag says that an order is on its way: the step would only be cancelled.
        if self.work == Work::Nothing || self.cancel.is_requested() {
            let order = self.orders.recv().ok();
            self.owner_is_gone = order.is_none();
            return order;
        }
        let wait = self.next_step.saturating_duration_since(Instant::now());
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

    fn obey(&mut self, command: Command) {
        match command {
            Command::SetParams(params) => {
                self.set_params(params);
                return;
            }
            Command::SetPace(pace) => {
                self.pace = pace;
                self.next_step = self.next_step.min(Instant::now() + pace.interval());
                return;
            }
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
                self.restart();
            }
            Command::Run => {
                let algorithm = self.params.algorithm;
                let is_over =
                    |p: &Present<M>| p.machine.is_finished() || p.machine.params().algorithm != algorithm;
                // A run that can't start anew stays as it is, and says why.
                let ready = !self.present.as_ref().is_some_and(is_over) || self.restart();
                self.begin(if ready { Work::Run } else { Work::Nothing });
            }
            Command::Pause => self.work = Work::Nothing,
            Command::StepIteration => self.begin(Work::StepIteration),
            Command::StepMerge => self.begin(Work::StepMerge),
            Command::MergeAll => self.begin(Work::MergeAll),
            Command::ExportCloud(path) => self.export(&path, Part::Cloud),
            Command::ExportPrimitives(path) => self.export(&path, Part::Primitives),
        }
        self.announce();
    }

    fn set_params(&mut self, params: Params) {
        if let Err(error) = params.check() {
            self.fail("The parameters were not taken", error);
            return;
        }
        self.params = params;
        if let Some(present) = &mut self.present
            && let Err(error) = present.machine.set_params(params)
        {
            let error = source::chain(&error);
            self.fail("The parameters were not taken", error);
        }
    }

    fn begin(&mut self, work: Work) {
        if self.present.is_none() {
            self.fail("There is nothing to run", "no shape is loaded; open one first");
            return;
        }
        self.work = work;
        self.next_step = Instant::now();
    }

    /// Lays the work down for another activity; what it was.
    fn halt(&mut self, activity: Activity) -> Work {
        self.emit(Event::Activity(activity));
        std::mem::replace(&mut self.work, Work::Nothing)
    }

    /// Whether there is a new shape; if not, all is as it was.
    fn load(&mut self, source: &Source, sampling: SamplingOptions) -> bool {
        let what = match source {
            Source::File(path) => format!("{} could not be opened", path.display()),
            Source::BuiltIn => "The built-in shape could not be opened".to_owned(),
        };
        let cancel = self.cancel.clone();
        let params = self.params;
        let outcome = guarded(|| {
            if cancel.is_requested() {
                return Err(Stop::Cancelled);
            }
            let shape = source::read(source).map_err(|error| Stop::trouble(what.as_str(), error))?;
            sampled::<M>(&what, shape, sampling, params, &cancel)
        });
        self.take_in(outcome, sampling)
    }

    /// Whether there are new samples; if not, all is as it was.
    fn resample(&mut self, sampling: SamplingOptions) -> bool {
        let Some(present) = &self.present else {
            self.fail("There is nothing to sample", "no shape is loaded; open one first");
            return false;
        };
        let shape = Arc::clone(&present.shape.shape);
        let cancel = self.cancel.clone();
        let params = self.params;
        let outcome =
            guarded(|| sampled::<M>("The shape could not be sampled anew", shape, sampling, params, &cancel));
        self.take_in(outcome, sampling)
    }

    /// Makes a freshly loaded shape the present one, or leaves all as it is;
    /// which of the two.
    fn take_in(&mut self, outcome: Result<Fresh<M>, Stop>, sampling: SamplingOptions) -> bool {
        match outcome {
            Ok(Fresh { shape, cloud, machine, abstraction }) => {
                self.generation += 1;
                let shape = Arc::new(LoadedShape { generation: self.generation, shape, cloud, sampling });
                self.emit(Event::Loaded(Arc::clone(&shape)));
                self.present = Some(Present {
                    shape,
                    run: 1,
                    start: self.params,
                    machine,
                    abstraction,
                    elapsed: Duration::ZERO,
                    unmeasured: None,
                });
                self.emit_snapshot(Vec::new());
                true
            }
            Err(stop) => {
                self.report(stop);
                false
            }
        }
    }

    /// Back to the start of the run; whether it worked.
    fn restart(&mut self) -> bool {
        let Some(present) = &self.present else {
            self.fail("There is nothing to reset", "no shape is loaded; open one first");
            return false;
        };
        let cloud = Arc::clone(&present.shape.cloud);
        let cancel = self.cancel.clone();
        let params = self.params;
        let outcome = guarded(|| {
            let machine = M::start(cloud, params, &cancel)
                .map_err(|error| Stop::inference("The run could not be started", &error))?;
            let abstraction = machine.abstraction();
            Ok((machine, abstraction))
        });
        match (outcome, &mut self.present) {
            (Ok((machine, abstraction)), Some(present)) => {
                present.machine = machine;
                present.abstraction = abstraction;
                present.run += 1;
                present.start = params;
                present.elapsed = Duration::ZERO;
                present.unmeasured = None;
                self.emit_snapshot(Vec::new());
                true
            }
            (Ok(_), None) => false,
            (Err(stop), _) => {
                self.report(stop);
                false
            }
        }
    }

    /// Makes one step of the work at hand. The step is made on a copy: what is
    /// cancelled or panics in the middle leaves the state as it was.
    fn advance(&mut self) {
        let Some(present) = &self.present else {
            self.work = Work::Nothing;
            return;
        };
        let begun = Instant::now();
        let work = self.work;
        let cancel = self.cancel.clone();
        if matches!(work, Work::Run | Work::StepIteration) && present.machine.is_finished() {
            self.work = Work::Nothing;
            self.announce();
            return;
        }
        let outcome = guarded(|| {
            let mut machine = present.machine.clone();
            let step = match work {
                Work::StepMerge | Work::MergeAll => machine.step_merge(&cancel).map(Step::Merged),
                Work::Run | Work::StepIteration | Work::Nothing => machine.step(&cancel).map(Step::Iterated),
            }
            .map_err(|error| Stop::inference("The step could not be made", &error))?;
            let abstraction = machine.abstraction();
            Ok((machine, abstraction, step))
        });
        match outcome {
            Ok((machine, abstraction, step)) => {
                if let Some(present) = &mut self.present {
                    present.machine = machine;
                    present.abstraction = abstraction;
                    present.elapsed += begun.elapsed();
                }
                self.next_step = begun + self.pace.interval();
                self.conclude(step);
            }
            // The order that cancelled the step decides how it goes on.
            Err(Stop::Cancelled) => {}
            Err(stop) => {
                self.work = Work::Nothing;
                self.report(stop);
                self.announce();
            }
        }
    }

    /// Tells of a step that was made, and whether it was the last.
    fn conclude(&mut self, step: Step) {
        let mut done = matches!(self.work, Work::StepIteration | Work::StepMerge);
        match step {
            Step::Iterated(occurrences) => {
                done |= self.present.as_ref().is_none_or(|p| p.machine.is_finished());
                self.emit_step(occurrences);
            }
            Step::Merged(Some(report)) => {
                self.emit_step(vec![Occurrence::Merged(report.clone())]);
                self.emit(Event::MergeStep(Some(report)));
            }
            Step::Merged(None) => {
                done = true;
                self.emit(Event::MergeStep(None));
            }
        }
        if done {
            self.work = Work::Nothing;
            self.announce();
        }
    }

    fn export(&mut self, path: &Path, part: Part) {
        self.emit(Event::Activity(Activity::Writing));
        let failure = format!("The {} could not be written", part.name());
        let Some(present) = &self.present else {
            self.fail(failure, "no shape is loaded; open one first");
            return;
        };
        // Those of the run, whatever the sliders say that waits for the next start.
        let params = present.machine.params();
        let outcome = guarded(|| {
            source::write(part, path, &present.shape, &params, &present.abstraction)
                .map_err(|error| Stop::trouble(failure, error))
        });
        match outcome {
            Ok(()) => self.emit(Event::Written { path: path.to_owned(), what: part.name() }),
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
    fn measure(&mut self) {
        let Some(present) = &mut self.present else { return };
        if let Some(snapshot) = present.unmeasured.take()
            && self.measurer.ask(&present.shape.shape, &snapshot)
        {
            self.emit(Event::Measuring(snapshot));
        }
    }

    /// Says what the engine is about to do.
    fn announce(&mut self) {
        if self.work == Work::Nothing {
            self.measure();
        }
        self.emit(Event::Activity(match self.work {
            Work::Nothing => Activity::Idle,
            Work::Run | Work::StepIteration => Activity::Running,
            Work::StepMerge | Work::MergeAll => Activity::Merging,
        }));
    }

    fn emit_step(&mut self, occurrences: Vec<Occurrence>) {
        let snapshot = self.emit_snapshot(occurrences);
        if let Some(present) = &mut self.present {
            present.unmeasured = snapshot;
        }
    }

    /// Tells the present state, which it returns.
    fn emit_snapshot(&mut self, occurrences: Vec<Occurrence>) -> Option<Arc<Snapshot>> {
        let present = self.present.as_ref()?;
        let snapshot = Arc::new(Snapshot {
            generation: present.shape.generation,
            run: present.run,
            abstraction: present.abstraction.clone(),
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
        self.owner_is_gone |= self.events.send(event).is_err();
        (self.wake)();
    }
}

/// What loading comes to.
struct Fresh<M> {
    shape: Arc<Shape>,
    cloud: Arc<SampleCloud>,
    machine: M,
    abstraction: Abstraction,
}

fn sampled<M: Machine>(
    what: &str,
    shape: Arc<Shape>,
    sampling: SamplingOptions,
    params: Params,
    cancel: &Cancel,
) -> Result<Fresh<M>, Stop> {
    let cloud = source::sample(&shape, sampling).map_err(|error| Stop::trouble(what, error))?;
    let machine =
        M::start(Arc::clone(&cloud), params, cancel).map_err(|error| Stop::inference(what, &error))?;
    let abstraction = machine.abstraction();
    Ok(Fresh { shape, cloud, machine, abstraction })
}

/// Runs `work`, and turns a panic into trouble that can be reported.
fn guarded<T>(work: impl FnOnce() -> Result<T, Stop>) -> Result<T, Stop> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| {
        let message = payload
            .downcast_ref::<&str>()
            .map(|text| (*text).to_owned())
            .or_else(|| payload.downcast_ref::<String>().cloned())
            .unwrap_or_else(|| "it gave no message".to_owned());
        Err(Stop::trouble(
            "The program made a mistake and went back to the last good state",
            format!("{message}. Please report this, with the shape and the parameters"),
        ))
    })
}
