//! Work in background threads that a frame must not wait for.

use std::sync::{Arc, LazyLock, OnceLock};

use egui::Context;
use rayon::ThreadPool;

use crate::io::caught;

/// Uses half of the cores; rendering and sampling need the others. `None` if no
/// threads can be started.
static POOL: LazyLock<Option<ThreadPool>> = LazyLock::new(|| {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads((cores / 2).max(1))
        .thread_name(|i| format!("background {i}"))
        .build();
    pool.inspect_err(|error| {
        tracing::warn!("no background threads; computing on the window's thread: {error}")
    })
    .ok()
});

/// Holds a result; empty if the computation failed.
type Place<T> = Arc<OnceLock<Option<Arc<T>>>>;

/// The newest result of some work that is done again and again with other
/// inputs, which the keys name. One work is under way at a time, and the next
/// is the one that is wanted by then: what came between is never begun.
#[derive(Debug)]
pub(super) struct Background<K, T> {
    done: Option<(K, Option<Arc<T>>)>,
    under_way: Option<(K, Place<T>)>,
}

impl<K, T> Default for Background<K, T> {
    fn default() -> Self {
        Self { done: None, under_way: None }
    }
}

/// Shares the results, even if `T` cannot be cloned.
impl<K: Clone, T> Clone for Background<K, T> {
    fn clone(&self) -> Self {
        Self { done: self.done.clone(), under_way: self.under_way.clone() }
    }
}

impl<K: Clone + PartialEq, T: Send + Sync + 'static> Background<K, T> {
    /// The newest result there is, with its key. If it is not that of `key`,
    /// `work` is on its way or will be in a later call: a `window` is drawn anew
    /// when it is there, without one it is waited for.
    pub(super) fn get(
        &mut self,
        key: &K,
        window: Option<&Context>,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Option<(&K, &Arc<T>)> {
        if let Some((of, place)) = &self.under_way
            && let Some(result) = place.get()
        {
            self.done = Some((of.clone(), result.clone()));
            self.under_way = None;
        }
        if self.under_way.is_none() && self.done.as_ref().is_none_or(|(of, _)| of != key) {
            match (window.cloned(), &*POOL) {
                (Some(window), Some(pool)) => {
                    let place: Place<T> = Arc::default();
                    self.under_way = Some((key.clone(), Arc::clone(&place)));
                    pool.spawn(move || {
                        place.get_or_init(|| guarded(work));
                        window.request_repaint();
                    });
                }
                _ => self.done = Some((key.clone(), guarded(work))),
            }
        }
        self.done.as_ref().and_then(|(of, result)| Some((of, result.as_ref()?)))
    }

    /// Whether a result is being computed.
    #[cfg(test)]
    fn is_busy(&self) -> bool {
        self.under_way.is_some()
    }
}

/// Result of the work; `None` if it panics, which is logged.
fn guarded<T>(work: impl FnOnce() -> T) -> Option<Arc<T>> {
    let result = caught(work);
    if result.is_err() {
        tracing::error!("internal error in a background computation; please report it and attach the shape");
    }
    result.ok().map(Arc::new)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    /// Waits until no work is in progress.
    fn settle(background: &mut Background<u32, u32>, key: u32) -> Option<(u32, u32)> {
        loop {
            let found = background.get(&key, Some(&Context::default()), move || 10 * key);
            let found = found.map(|(k, v)| (*k, **v));
            if !background.is_busy() {
                return found;
            }
            std::thread::yield_now();
        }
    }

    #[test]
    fn the_newest_wins_and_what_came_between_is_never_begun() {
        let mut background = Background::default();
        let window = Context::default();
        let (go, gate) = channel::<()>();
        assert!(background.get(&1, Some(&window), move || gate.recv().map_or(0, |()| 10)).is_none());
        for key in 2..5 {
            let waits = background.get(&key, Some(&window), || panic!("it was not to be begun"));
            assert!(waits.is_none() && background.is_busy());
        }
        go.send(()).expect("the work waits");
        assert_eq!(settle(&mut background, 5), Some((5, 50)));
    }

    #[test]
    fn work_that_fails_leaves_nothing_and_is_not_tried_again() {
        let mut background = Background::<u32, u32>::default();
        assert!(background.get(&1, None, || panic!("as meant")).is_none());
        assert!(background.get(&1, None, || 7).is_none());
        assert_eq!(background.get(&2, None, || 7).map(|(k, v)| (*k, **v)), Some((2, 7)));
    }
}
