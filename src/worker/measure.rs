//! Measuring states beside the run: on a thread and on cores of its own, so
//! that no order and no step waits for it.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::channel::{NumberedEvent, Wake};
use super::protocol::{Event, Helper, Measurement, Snapshot, State};
use super::source;
use crate::geometry::Superquadric;
use crate::geometry::metrics::{Metrics, Reference, estimate_chamfer, evaluate};
use crate::io::{Shape, caught};

/// Points of each surface by which a state is estimated: enough for an error of
/// about one percent.
const PROBES: usize = 4000;

/// What measuring against a shape takes.
type Prepared = Result<Arc<Reference>, String>;

/// The last shape, and what measuring against it takes.
type Latest = (Weak<Shape>, Prepared);

/// What measuring against the last shape takes, shared by those who measure;
/// without keeping that shape.
#[derive(Debug, Clone, Default)]
pub(super) struct References(Arc<Mutex<Option<Latest>>>);

impl References {
    /// Prepares it on the pool's threads, unless it is there already; whoever
    /// else asks waits meanwhile.
    pub(super) fn of(&self, shape: &Arc<Shape>, pool: &ThreadPool) -> Prepared {
        let mut prepared = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*prepared {
            Some((of, reference)) if std::ptr::eq(of.as_ptr(), Arc::as_ptr(shape)) => reference.clone(),
            _ => {
                let reference = guarded(|| pool.install(|| source::reference(shape))).and_then(|found| found);
                let reference = reference.map(Arc::new);
                *prepared = Some((Arc::downgrade(shape), reference.clone()));
                reference
            }
        }
    }
}

/// A state to measure, against its shape.
struct Task {
    shape: Arc<Shape>,
    snapshot: Arc<Snapshot>,
}

impl Task {
    fn of(State { loaded, snapshot }: &State) -> Self {
        Self { shape: Arc::clone(&loaded.shape), snapshot: Arc::clone(snapshot) }
    }
}

fn shapes_of(snapshot: &Snapshot) -> Vec<Superquadric> {
    snapshot.abstraction.primitives.iter().map(|p| p.shape).collect()
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
    pub(super) fn spawn(events: SyncSender<NumberedEvent>, wake: &Arc<Wake>, references: References) -> Self {
        let (jobs, incoming) = channel();
        let wake = Arc::downgrade(wake);
        let started = Pools::new().map_err(|e| e.to_string()).and_then(|pools| {
            std::thread::Builder::new()
                .name("measurer".to_owned())
                .spawn(move || {
                    again_after_faults(Helper::Measurer, &events, &wake, || {
                        work(&incoming, &pools, &events, &wake, &references);
                    });
                })
                .map_err(|e| e.to_string())
        });
        if let Err(error) = &started {
            tracing::warn!("states will not be measured: {error}");
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

/// Does the work of a thread, which ends when one of the two ends is gone. A
/// fault that nothing else has caught is told, and the work begun again.
pub(super) fn again_after_faults(
    who: Helper,
    events: &SyncSender<NumberedEvent>,
    wake: &Weak<Wake>,
    work: impl Fn(),
) {
    while let Err(error) = caught(&work) {
        let Some(wake) = wake.upgrade() else { return };
        if events.send((0, Event::Ended { who, error })).is_err() {
            return;
        }
        wake();
    }
}

/// Measures until one of the two ends is gone.
fn work(
    jobs: &Receiver<Job>,
    pools: &Pools,
    events: &SyncSender<NumberedEvent>,
    wake: &Weak<Wake>,
    references: &References,
) {
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
        let shape = Arc::clone(&task.shape);
        let reference = references.of(&shape, &pools.half);
        // That may have taken a while: there may be a newer state by now.
        for job in jobs.try_iter() {
            match job {
                Job::Measure(task) => to_measure = Some(task),
                Job::Estimate(tasks) => to_estimate = tasks.into(),
            }
        }
        let is_same = |task: &Task| Arc::ptr_eq(&task.shape, &shape);
        if !to_measure.as_ref().or(to_estimate.front()).is_some_and(is_same) {
            continue;
        }
        let event = if let Some(task) = to_measure.take() {
            let result = reference.and_then(|reference| measured(&task.snapshot, &reference, &pools.half));
            Event::Measured(Arc::new(Measurement { snapshot: task.snapshot, result }))
        } else if let Some(task) = to_estimate.pop_front() {
            // Why there is none is told where the state is measured.
            let estimate = reference.ok().and_then(|reference| {
                guarded(|| {
                    pools.one.install(|| estimate_chamfer(&shapes_of(&task.snapshot), &reference, PROBES))
                })
                .ok()
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

/// What a state comes to, or why that can't be said.
pub(super) fn measured(
    snapshot: &Snapshot,
    reference: &Reference,
    pool: &ThreadPool,
) -> Result<Metrics, String> {
    let state = &snapshot.abstraction;
    let shapes = shapes_of(snapshot);
    let unassigned_share = state.figures.unassigned as f64 / state.labels.len().max(1) as f64;
    guarded(|| pool.install(|| evaluate(&shapes, Some(unassigned_share), reference)))
}

fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    caught(work).map_err(|_| {
        "internal error while measuring; please report it with the shape and the parameters".to_owned()
    })
}
