//! Measuring states beside the run: on a thread and on cores of its own, so
//! that no order and no step waits for it.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel};
use std::sync::{Arc, Weak};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::protocol::{Event, Measurement, Snapshot, State};
use super::source;
use super::{Told, Wake};
use crate::geometry::Superquadric;
use crate::geometry::metrics::{Metrics, Reference, estimate_chamfer, evaluate};
use crate::io::Shape;

/// Points of each surface by which a state is estimated: enough for an error of
/// about one percent.
const PROBES: usize = 4000;

/// A state to measure, against its shape.
struct Task {
    shape: Arc<Shape>,
    snapshot: Arc<Snapshot>,
}

impl Task {
    fn of(State { loaded, snapshot }: &State) -> Self {
        Self { shape: Arc::clone(&loaded.shape), snapshot: Arc::clone(snapshot) }
    }

    fn shapes(&self) -> Vec<Superquadric> {
        self.snapshot.abstraction.primitives.iter().map(|p| p.shape).collect()
    }
}

enum Job {
    Measure(Task),
    Estimate(Vec<Task>),
}

/// The engine's end. Nobody waits for the thread: a measurement that is under
/// way when the engine goes ends unheard.
#[derive(Debug)]
pub(super) struct Measurer {
    /// `None` where the operating system gave no threads.
    jobs: Option<Sender<Job>>,
}

impl Measurer {
    /// Results go out as events.
    pub(super) fn spawn(events: SyncSender<Told>, wake: &Arc<Wake>) -> Self {
        let (jobs, incoming) = channel();
        let wake = Arc::downgrade(wake);
        let started = Pools::new().map_err(|e| e.to_string()).and_then(|pools| {
            std::thread::Builder::new()
                .name("measurer".to_owned())
                .spawn(move || work(&incoming, &pools, &events, &wake))
                .map_err(|e| e.to_string())
        });
        if let Err(error) = &started {
            tracing::warn!("states are not measured: {error}");
        }
        Self { jobs: started.ok().map(|_| jobs) }
    }

    /// Asks for a state to be measured in place of those that still wait;
    /// whether it will be.
    pub(super) fn measure(&self, state: &State) -> bool {
        self.ask(Job::Measure(Task::of(state)))
    }

    /// Asks for states to be estimated in place of those that still wait.
    pub(super) fn estimate(&self, states: &[State]) {
        // Without threads nothing is measured, which was told at the start.
        let _ = self.ask(Job::Estimate(states.iter().map(Task::of).collect()));
    }

    fn ask(&self, job: Job) -> bool {
        self.jobs.as_ref().is_some_and(|jobs| jobs.send(job).is_ok())
    }
}

struct Pools {
    /// Half of the cores: the others are left to the run that may go on
    /// meanwhile.
    half: ThreadPool,
    /// One core, for what nobody waits for.
    one: ThreadPool,
}

impl Pools {
    fn new() -> Result<Self, ThreadPoolBuildError> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let pool = |threads, name: &'static str| {
            ThreadPoolBuilder::new().num_threads(threads).thread_name(move |i| format!("{name} {i}")).build()
        };
        Ok(Self { half: pool((cores / 2).max(1), "measurer")?, one: pool(1, "estimator")? })
    }
}

/// What measuring against the last shape takes; without keeping that shape.
#[derive(Default)]
struct Prepared(Option<(Weak<Shape>, Result<Reference, String>)>);

impl Prepared {
    fn of(&self, shape: &Arc<Shape>) -> Option<Result<&Reference, String>> {
        let (of, reference) = self.0.as_ref()?;
        std::ptr::eq(of.as_ptr(), Arc::as_ptr(shape)).then(|| reference.as_ref().map_err(String::clone))
    }
}

/// Measures until one of the two ends is gone.
fn work(jobs: &Receiver<Job>, pools: &Pools, events: &SyncSender<Told>, wake: &Weak<Wake>) {
    let mut prepared = Prepared::default();
    let mut to_measure: Option<Task> = None;
    let mut to_estimate: VecDeque<Task> = VecDeque::new();
    loop {
        let is_idle = to_measure.is_none() && to_estimate.is_empty();
        let first = if is_idle { jobs.recv().ok() } else { None };
        if is_idle && first.is_none() {
            return;
        }
        for job in first.into_iter().chain(jobs.try_iter()) {
            match job {
                Job::Measure(task) => to_measure = Some(task),
                Job::Estimate(tasks) => to_estimate = tasks.into(),
            }
        }
        let Some(task) = to_measure.as_ref().or(to_estimate.front()) else { continue };
        let Some(reference) = prepared.of(&task.shape) else {
            let shape = Arc::clone(&task.shape);
            let reference = guarded(|| pools.half.install(|| source::reference(&shape)));
            prepared.0 = Some((Arc::downgrade(&shape), reference.and_then(|found| found)));
            // That took a while: there may be a newer state by now.
            continue;
        };
        let event = if let Some(task) = to_measure.take() {
            let result =
                reference.and_then(|reference| guarded(|| pools.half.install(|| measured(&task, reference))));
            Event::Measured(Arc::new(Measurement { snapshot: task.snapshot, result }))
        } else if let Some(task) = to_estimate.pop_front() {
            // Why there is none is told where the state is measured.
            let estimate = reference.ok().and_then(|reference| {
                guarded(|| pools.one.install(|| estimate_chamfer(&task.shapes(), reference, PROBES))).ok()
            });
            Event::Estimated { key: task.snapshot.key, chamfer_l1: estimate.flatten() }
        } else {
            continue;
        };
        // An owner that has this event will be woken for it, too.
        let Some(wake) = wake.upgrade() else { return };
        if events.send((0, event)).is_err() {
            return;
        }
        wake();
    }
}

fn measured(task: &Task, reference: &Reference) -> Metrics {
    let state = &task.snapshot.abstraction;
    let unassigned_share = state.figures.unassigned as f64 / state.labels.len().max(1) as f64;
    evaluate(&task.shapes(), Some(unassigned_share), reference)
}

fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        "the program made a mistake on measuring; please report this, with the shape and the parameters"
            .to_owned()
    })
}
