//! Measuring states beside the run: on a thread and on cores of its own, so
//! that no order and no step waits for it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel};
use std::sync::{Arc, Weak};

use rayon::ThreadPool;

use super::protocol::{Event, Measurement, Snapshot};
use super::source;
use super::{Told, Wake};
use crate::geometry::metrics::{Metrics, Reference, evaluate};
use crate::io::Shape;

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
    pub(super) fn spawn(events: SyncSender<Told>, wake: &Arc<Wake>) -> Self {
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
                    .spawn(move || work(&incoming, &pool, &events, &wake))
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
fn work(jobs: &Receiver<Job>, pool: &ThreadPool, events: &SyncSender<Told>, wake: &Weak<Wake>) {
    // What measuring against the last shape takes; without keeping that shape.
    let mut prepared: Option<(Weak<Shape>, Result<Reference, String>)> = None;
    let mut waiting: Option<Job> = None;
    while let Some(job) = waiting.take().or_else(|| jobs.recv().ok()) {
        let job = jobs.try_iter().last().unwrap_or(job);
        let result = match &prepared {
            Some((shape, reference)) if std::ptr::eq(shape.as_ptr(), Arc::as_ptr(&job.shape)) => reference
                .as_ref()
                .map_err(String::clone)
                .and_then(|reference| guarded(|| pool.install(|| measured(&job.snapshot, reference)))),
            _ => {
                let reference =
                    guarded(|| pool.install(|| source::reference(&job.shape))).and_then(|found| found);
                prepared = Some((Arc::downgrade(&job.shape), reference));
                // That took a while: there may be a newer state by now.
                waiting = Some(job);
                continue;
            }
        };
        let measurement = Measurement { snapshot: job.snapshot, result };
        // An owner that has this event will be woken for it, too.
        let Some(wake) = wake.upgrade() else { return };
        if events.send((0, Event::Measured(Arc::new(measurement)))).is_err() {
            return;
        }
        wake();
    }
}

fn measured(snapshot: &Snapshot, reference: &Reference) -> Metrics {
    let state = &snapshot.abstraction;
    let shapes: Vec<_> = state.primitives.iter().map(|p| p.shape).collect();
    let unassigned_share = state.figures.unassigned as f64 / state.labels.len().max(1) as f64;
    evaluate(&shapes, Some(unassigned_share), reference)
}

fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        "the program made a mistake on measuring; please report this, with the shape and the parameters"
            .to_owned()
    })
}
