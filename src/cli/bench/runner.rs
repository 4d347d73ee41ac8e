//! Runs in parallel, each on one core.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

use anyhow::Context;

use super::shapes::BenchShape;
use super::store::Row;
use crate::geometry::SamplingOptions;
use crate::geometry::metrics::{MetricOptions, Reference, evaluate};
use crate::inference::{Cancel, Method, Params, Run};
use crate::io::{self, Shape};

/// One run to make.
#[derive(Debug, Clone)]
pub(super) struct Task {
    /// Index of its shape.
    pub(super) shape: usize,
    pub(super) method: Method,
    pub(super) params: Params,
    pub(super) sampling: SamplingOptions,
    pub(super) key: String,
}

/// A shape as it was read, and what its results are measured against.
type Prepared = Result<Arc<(Shape, Reference)>, String>;

/// A shape that is read when its first run starts and let go when its last
/// one ends.
#[derive(Debug, Default)]
struct Slot {
    prepared: Option<Prepared>,
    left: usize,
}

/// Makes all runs, the first ones first, on `jobs` threads; `done` is called
/// on this thread as each ends (with its index) and may end the whole by an
/// error. Runs that are cut short by `cancel` are not reported.
pub(super) fn run_all(
    tasks: &[Task],
    shapes: &[BenchShape],
    metrics: &MetricOptions,
    jobs: usize,
    cancel: &Cancel,
    mut done: impl FnMut(usize, Result<Row, String>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let slots: Vec<Mutex<Slot>> = shapes.iter().map(|_| Mutex::default()).collect();
    for task in tasks {
        slots[task.shape].lock().unwrap_or_else(PoisonError::into_inner).left += 1;
    }
    let pools = (0..jobs.clamp(1, tasks.len().max(1)))
        .map(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build())
        .collect::<Result<Vec<_>, _>>()
        .context("cannot start a thread")?;
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for pool in &pools {
            let (sender, next, slots) = (sender.clone(), &next, &slots);
            scope.spawn(move || {
                pool.install(|| {
                    loop {
                        let at = next.fetch_add(1, Ordering::Relaxed);
                        let Some(task) = tasks.get(at).filter(|_| !cancel.is_requested()) else { return };
                        let (slot, shape) = (&slots[task.shape], &shapes[task.shape]);
                        let result = prepared(slot, shape, metrics)
                            .and_then(|p| figures(task, &shape.name, &p.0, &p.1, cancel));
                        release(slot);
                        if cancel.is_requested() || sender.send((at, result)).is_err() {
                            return;
                        }
                    }
                });
            });
        }
        drop(sender);
        for (at, result) in receiver {
            if let Err(e) = done(at, result) {
                cancel.request();
                return Err(e);
            }
        }
        Ok(())
    })
}

fn prepared(slot: &Mutex<Slot>, shape: &BenchShape, metrics: &MetricOptions) -> Prepared {
    // Others that wait for the same shape wait for this.
    let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
    slot.prepared
        .get_or_insert_with(|| {
            let input = io::read(&shape.input).map_err(|e| e.to_string())?;
            let other;
            let measured = if shape.reference == shape.input {
                &input
            } else {
                other = io::read(&shape.reference).map_err(|e| e.to_string())?;
                &other
            };
            let reference = io::reference(measured, metrics)
                .map_err(|e| format!("{}: {e}", shape.reference.display()))?;
            Ok(Arc::new((input, reference)))
        })
        .clone()
}

fn release(slot: &Mutex<Slot>) {
    let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
    slot.left -= 1;
    if slot.left == 0 {
        slot.prepared = None;
    }
}

/// Makes one run and measures what it found.
fn figures(
    task: &Task,
    name: &str,
    shape: &Shape,
    reference: &Reference,
    cancel: &Cancel,
) -> Result<Row, String> {
    let start = thread_time();
    let cloud = Arc::new(io::sample(shape, &task.sampling).map_err(|e| e.to_string())?);
    let mut run = Run::new(cloud, task.params, cancel).map_err(|e| e.to_string())?;
    while !run.is_finished() {
        run.step(cancel).map_err(|e| e.to_string())?;
    }
    let abstraction = run.abstraction();
    let seconds = thread_time().saturating_sub(start).as_secs_f64();
    let shapes: Vec<_> = abstraction.primitives.iter().map(|p| p.shape).collect();
    let unassigned_share = abstraction.figures.unassigned as f64 / abstraction.labels.len().max(1) as f64;
    let found = evaluate(&shapes, Some(unassigned_share), reference);
    let (Some(chamfer_l1), Some(accuracy), Some(completeness)) =
        (found.chamfer_l1, found.accuracy, found.completeness)
    else {
        return Err("no primitive with a surface was found".to_owned());
    };
    Ok(Row {
        shape: name.to_owned(),
        method: task.method.name().to_owned(),
        seed: task.params.seed,
        key: task.key.clone(),
        primitives: found.primitives,
        chamfer_l1,
        accuracy,
        completeness,
        iou: found.iou,
        iou_outside: found.iou_outside,
        unassigned_share,
        seconds,
    })
}

/// CPU time of this thread, which other programs on the machine don't change.
#[cfg(unix)]
fn thread_time() -> Duration {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec.unsigned_abs(), now.tv_nsec.unsigned_abs() as u32)
}

/// Elapsed time, where CPU time can't be had.
#[cfg(not(unix))]
fn thread_time() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}
