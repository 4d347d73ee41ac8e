//! Runs jobs in parallel, each with its own threads.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use anyhow::Context;

use crate::inference::{Cancel, InferenceError};

/// How a job ended.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum End<T> {
    Done(T),
    /// With what went wrong.
    Failed(String),
    Cancelled,
}

/// Does `count` jobs, the first ones first, `workers` of them side by side with
/// `threads` threads each. `work` gets the number of the worker and that of the
/// job; `done` is called on this thread as each ends, and may end the whole by
/// an error. A panic in a job is its failure. After `cancel` no job is begun.
pub(super) fn run_all<T: Send>(
    count: usize,
    (workers, threads): (usize, usize),
    cancel: &Cancel,
    work: impl Fn(usize, usize) -> anyhow::Result<T> + Sync,
    mut done: impl FnMut(usize, End<T>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let pools = (0..workers.clamp(1, count.max(1)))
        .map(|_| rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build())
        .collect::<Result<Vec<_>, _>>()
        .context("cannot start a thread")?;
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for (worker, pool) in pools.iter().enumerate() {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    if at >= count || cancel.is_requested() {
                        return;
                    }
                    let end = guarded(|| pool.install(|| work(worker, at)));
                    if sender.send((at, end)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for (at, end) in receiver {
            if let Err(e) = done(at, end) {
                cancel.request();
                return Err(e);
            }
        }
        Ok(())
    })
}

fn guarded<T>(work: impl FnOnce() -> anyhow::Result<T>) -> End<T> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(value)) => End::Done(value),
        Ok(Err(e)) if e.chain().any(|e| matches!(e.downcast_ref(), Some(InferenceError::Cancelled))) => {
            End::Cancelled
        }
        Ok(Err(e)) => End::Failed(format!("{e:#}")),
        Err(payload) => {
            let text = payload
                .downcast_ref::<&str>()
                .copied()
                .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
                .unwrap_or("no message");
            End::Failed(format!("internal error: {text}; please report it"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(
        count: usize,
        workers: usize,
        cancel: &Cancel,
        work: impl Fn(usize) -> anyhow::Result<usize> + Sync,
    ) -> Vec<Option<End<usize>>> {
        let mut ends = vec![None; count];
        run_all(
            count,
            (workers, 1),
            cancel,
            |_, at| work(at),
            |at, end| {
                assert!(ends[at].replace(end).is_none(), "{at} ended twice");
                Ok(())
            },
        )
        .unwrap();
        ends
    }

    #[test]
    fn a_failure_or_a_panic_stops_nobody_else() {
        for workers in [1, 3] {
            let found = ends(9, workers, &Cancel::default(), |at| match at {
                2 => anyhow::bail!("bad file"),
                5 => panic!("index {at} out of range"),
                _ => Ok(at * at),
            });
            for (at, end) in found.into_iter().enumerate() {
                match (at, end.unwrap()) {
                    (2, End::Failed(text)) => assert_eq!(text, "bad file"),
                    (5, End::Failed(text)) => {
                        assert!(text.contains("internal error: index 5 out of range"), "{text}")
                    }
                    (_, end) => assert_eq!(end, End::Done(at * at)),
                }
            }
        }
    }

    #[test]
    fn after_a_stop_nothing_is_begun() {
        let cancel = Cancel::default();
        let found = ends(9, 1, &cancel, |at| {
            if at == 3 {
                cancel.request();
                return Err(anyhow::Error::from(InferenceError::Cancelled).context("a shape"));
            }
            Ok(at)
        });
        assert_eq!(
            found[..4],
            [0, 1, 2]
                .map(|at| Some(End::Done(at)))
                .into_iter()
                .chain([Some(End::Cancelled)])
                .collect::<Vec<_>>()
        );
        assert!(found[4..].iter().all(Option::is_none));
    }

    #[test]
    fn an_error_of_the_owner_ends_the_whole() {
        let cancel = Cancel::default();
        let result = run_all(100, (2, 1), &cancel, |_, at| Ok(at), |_, _| anyhow::bail!("the disk is full"));
        assert_eq!(result.unwrap_err().to_string(), "the disk is full");
        assert!(cancel.is_requested());
    }
}
