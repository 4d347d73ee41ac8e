//! The background thread that owns the run, and the types that cross.
//!
//! Commands go in and events come out over bounded channels. No lock is shared
//! with the owner: what has to be stopped is stopped through an atomic flag
//! that travels with each command. The worker knows nothing of a window; it is
//! handed a `wake` callback and calls it after every event.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::inference::{Cancel, Run};

mod engine;
mod machine;
mod measure;
mod outbox;
mod pacer;
pub mod protocol;
mod seeds;
mod source;
#[cfg(test)]
mod tests;
mod trouble;

use engine::{Engine, Order};
use machine::Machine;
pub(crate) use outbox::Outbox;
pub use protocol::{
    Activity, Cause, Command, Event, ExportRequest, LoadedShape, Measurement, Pace, Renewed, SamplingOptions,
    SeedNews, SeedRequest, SeedRun, Setup, Snapshot, Source, State,
};
pub use trouble::FAULT;

/// Commands that may wait for a busy worker before they wait at the sender.
const COMMAND_CAPACITY: usize = 64;
/// Events that may wait for a busy owner before the worker waits for it.
const EVENT_CAPACITY: usize = 32;

/// An event with the number of what it tells of: an activity, of the last
/// question that it answers; anything else, of its epoch.
type Told = (u64, Event);

/// Called after each event.
type Wake = dyn Fn() + Send + Sync;

/// The owner's end: send commands, take events. Dropping it cancels what is
/// going on, stops the thread and waits for it.
#[derive(Debug)]
pub struct Worker {
    orders: Outbox<Order>,
    /// `None` only while dropping.
    events: Option<Receiver<Told>>,
    /// Counts the states that were resumed: what is told of an earlier epoch's
    /// state came too late.
    epoch: u64,
    /// Counts the commands that are answered by an activity: what is told
    /// before the last of them has been obeyed is of the time before it.
    asked: u64,
    /// The flag that travels with the commands sent since the last
    /// interrupting one.
    cancel: Cancel,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread. `wake` is called after each event, on this thread or
    /// the one that measures, and must not block.
    ///
    /// # Errors
    /// If the operating system gives no thread.
    pub fn spawn(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Self::spawn_machine::<Run>(wake)
    }

    fn spawn_machine<M: Machine>(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let (orders, incoming) = mpsc::sync_channel(COMMAND_CAPACITY);
        let (outgoing, events) = mpsc::sync_channel(EVENT_CAPACITY);
        let thread =
            std::thread::Builder::new().name("sampler".to_owned()).spawn(move || match threads() {
                // The loop is one of the pool's threads: while it computes, all cores do.
                Ok(pool) => pool.install(|| Engine::<M>::new(incoming, outgoing, Arc::new(wake)).run()),
                Err(error) => {
                    tracing::warn!("the sampler has no threads of its own: {error}");
                    Engine::<M>::new(incoming, outgoing, Arc::new(wake)).run();
                }
            })?;
        Ok(Self {
            orders: Outbox::new(orders),
            events: Some(events),
            epoch: 0,
            asked: 0,
            cancel: Cancel::default(),
            thread: Some(thread),
        })
    }

    /// Hands a command over, in order; never blocks. Some interrupt what is
    /// going on, and what was sent but not begun, on their way in:
    /// [`Command::interrupts`].
    pub fn send(&mut self, command: Command) {
        if command.interrupts() {
            self.cancel.request();
            self.cancel = Cancel::default();
        }
        if matches!(command, Command::Resume(_)) {
            self.epoch += 1;
        }
        if command.asks() {
            self.asked += 1;
        }
        // A slider that is dragged while the worker is busy leaves one command, not hundreds.
        if let Some(Order { command: waiting, .. }) = self.orders.waiting().back()
            && command.replaces(waiting)
        {
            self.orders.waiting().pop_back();
        }
        self.orders.push(Order {
            command,
            cancel: self.cancel.clone(),
            epoch: self.epoch,
            asked: self.asked,
        });
        self.flush();
    }

    /// The events that have arrived, oldest first; never blocks. Whoever owns
    /// a worker calls this whenever `wake` was called.
    pub fn try_events(&mut self) -> impl Iterator<Item = Event> + '_ {
        self.flush();
        let (epoch, asked) = (self.epoch, self.asked);
        self.events.iter().flat_map(Receiver::try_iter).filter_map(move |told| heard(told, epoch, asked))
    }

    /// Waits for the next event, at most `timeout`; `None` if there was none.
    pub fn next_event(&mut self, timeout: Duration) -> Option<Event> {
        self.flush();
        let deadline = Instant::now() + timeout;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let told = self.events.as_ref()?.recv_timeout(left).ok()?;
            if let Some(event) = heard(told, self.epoch, self.asked) {
                return Some(event);
            }
        }
    }

    fn flush(&mut self) {
        if !self.orders.flush() {
            // The thread ends only with its owner; catch_unwind guards everything before.
            tracing::error!("the worker's thread has ended; the command was dropped");
        }
    }
}

/// The event, unless it tells of a state that was given up since, or of an
/// activity that an answer yet to come will correct: a run that ended while
/// another shape was asked for would pass for the end of loading that.
fn heard((of, event): Told, epoch: u64, asked: u64) -> Option<Event> {
    let is_present = match event {
        Event::Activity(_) => of >= asked,
        _ => of >= epoch || !event.is_of_present(),
    };
    is_present.then_some(event)
}

/// The threads that a run computes with. They are the worker's own, so that
/// whatever else computes in parallel never waits behind a step.
fn threads() -> Result<rayon::ThreadPool, rayon::ThreadPoolBuildError> {
    rayon::ThreadPoolBuilder::new().thread_name(|i| format!("sampler {i}")).build()
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.cancel.request();
        // Without channels a waiting worker wakes up and a sending one fails: it ends either way.
        self.orders.close();
        self.events = None;
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the worker's thread ended in a panic");
        }
    }
}
