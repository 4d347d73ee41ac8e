//! Measuring states beside the run: on a thread and on cores of its own, so
//! that no order and no step waits for it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use rayon::ThreadPool;

use super::protocol::{Event, Measurement, Snapshot};
use super::source;
use super::{Told, Wake};
use crate::geometry::metrics::{Metrics, Reference, evaluate};
use crate::io::Shape;

/// What measuring against a shape takes.
type Prepared = Result<Arc<Reference>, String>;

/// What measuring against the last shape takes, shared by those who measure;
/// without keeping that shape.
#[derive(Debug, Clone, Default)]
pub(super) struct References(Arc<Mutex<Option<(Weak<Shape>, Prepared)>>>);

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
struct Job {
    shape: Arc<Shape>,
    snapshot: Arc<Snapshot>,
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
    pub(super) fn spawn(events: SyncSender<Told>, wake: &Arc<Wake>, references: References) -> Self {
        // Half of the cores are left to the run that may go on meanwhile.
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let (jobs, incoming) = channel();
        let wake = Arc::downgrade(wake);
        let started = rayon::ThreadPoolBuilder::new()
            .num_threads((cores / 2).max(1))
            .thread_name(|i| format!("measurer {i}"))
            .build()
            .map_err(|e| e.to_string())
            .and_then(|pool| {
                std::thread::Builder::new()
                    .name("measurer".to_owned())
                    .spawn(move || work(&incoming, &pool, &events, &wake, &references))
                    .map_err(|e| e.to_string())
            });
        if let Err(error) = &started {
            tracing::warn!("states are not measured: {error}");
        }
        Self { jobs: started.ok().map(|_| jobs) }
    }

    /// Asks for a state to be measured in place of those that still wait;
    /// whether it will be.
    pub(super) fn ask(&self, shape: &Arc<Shape>, snapshot: &Arc<Snapshot>) -> bool {
        let job = Job { shape: Arc::clone(shape), snapshot: Arc::clone(snapshot) };
        self.jobs.as_ref().is_some_and(|jobs| jobs.send(job).is_ok())
    }
}

/// Measures until one of the two ends is gone.
fn work(
    jobs: &Receiver<Job>,
    pool: &ThreadPool,
    events: &SyncSender<Told>,
    wake: &Weak<Wake>,
    references: &References,
) {
    let mut waiting: Option<Job> = None;
    while let Some(job) = waiting.take().or_else(|| jobs.recv().ok()) {
        let job = jobs.try_iter().last().unwrap_or(job);
        let reference = references.of(&job.shape, pool);
        // That may have taken a while: there may be a newer state by now.
        waiting = jobs.try_iter().last();
        if waiting.is_some() {
            continue;
        }
        let result = reference.and_then(|reference| measured(&job.snapshot, &reference, pool));
        let measurement = Measurement { snapshot: job.snapshot, result };
        // An owner that has this event will be woken for it, too.
        let Some(wake) = wake.upgrade() else { return };
        if events.send((0, Event::Measured(Arc::new(measurement)))).is_err() {
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
    let shapes: Vec<_> = state.primitives.iter().map(|p| p.shape).collect();
    let unassigned_share = state.figures.unassigned as f64 / state.labels.len().max(1) as f64;
    guarded(|| pool.install(|| evaluate(&shapes, Some(unassigned_share), reference)))
}

fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        "the program made a mistake on measuring; please report this, with the shape and the parameters"
            .to_owned()
    })
}
