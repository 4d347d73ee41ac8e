//! The background thread that owns the run, and the types that cross.
//!
//! Commands go in and events come out over bounded channels. No lock is shared
//! with the owner: what has to be stopped is stopped through an atomic flag
//! that travels with each command. The worker knows nothing of a window; it is
//! handed a `wake` callback and calls it after every event.
//!
//! Each layer uses only those below it:
//!
//! | layer | what lives there |
//! |---|---|
//! | `engine` | the loop that obeys orders and steps the run, and the renewal of the run |
//! | `seeds` | runs with other seeds, on a thread of their own |
//! | `measure` | measuring states, on a thread of its own |
//! | `trouble`, `source`, `pacer` | how work ends early, the calls into `io`, when a step is due |
//! | `channel`, `machine`, `outbox` | what goes through the channels, what can be stepped |
//! | `protocol` | commands, events and what they carry |

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::inference::{Cancel, Run};
use crate::io::caught;

mod channel;
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

use channel::{NumberedCommand, NumberedEvent, Wake};
use engine::Engine;
use machine::Steppable;
pub(crate) use outbox::Outbox;
pub use protocol::{
    Activity, Cause, Command, Event, ExportRequest, Helper, LiveResult, LoadedShape, Measurement, Pace,
    SamplingOptions, SeedNews, SeedRequest, SeedRun, Setup, Snapshot, Source, State,
};
pub use trouble::FAULT;

/// Commands that may wait for a busy worker before they wait at the sender.
const COMMAND_CAPACITY: usize = 64;
/// Events that may wait for a busy owner before the worker waits for it.
const EVENT_CAPACITY: usize = 32;

/// The owner's end: send commands, take events. Dropping it cancels what is
/// going on, stops the thread and waits for it. Should the thread end before, in
/// a panic that nothing has caught, another takes its place: [`Event::Ended`].
pub struct Worker {
    orders: Outbox<NumberedCommand>,
    /// `None` only while dropping.
    events: Option<Receiver<NumberedEvent>>,
    /// What was found out here, and is told before what the thread tells.
    early: VecDeque<Event>,
    start: Box<Start>,
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

impl std::fmt::Debug for Worker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Worker").field("epoch", &self.epoch).field("thread", &self.thread).finish()
    }
}

/// The two ends of a thread that was started, and the thread.
type Started = (SyncSender<NumberedCommand>, Receiver<NumberedEvent>, JoinHandle<()>);
type Start = dyn Fn() -> std::io::Result<Started> + Send;

/// Starts a thread, which tells its end if that is a panic.
fn start<M: Steppable>(wake: Arc<Wake>) -> std::io::Result<Started> {
    let (orders, incoming) = mpsc::sync_channel(COMMAND_CAPACITY);
    let (outgoing, events) = mpsc::sync_channel(EVENT_CAPACITY);
    let thread = std::thread::Builder::new().name("sampler".to_owned()).spawn(move || {
        let (last, woken) = (outgoing.clone(), Arc::clone(&wake));
        let run = || match threads() {
            // The loop is one of the pool's threads: while it computes, all cores do.
            Ok(pool) => pool.install(|| Engine::<M>::new(incoming, outgoing, wake).run()),
            Err(error) => {
                tracing::warn!("cannot start the sampler's thread pool: {error}");
                Engine::<M>::new(incoming, outgoing, wake).run();
            }
        };
        if let Err(error) = caught(run) {
            // Fails only where the owner is gone.
            let _ = last.send((u64::MAX, Event::Ended { who: Helper::Sampler, error }));
            woken();
        }
    })?;
    Ok((orders, events, thread))
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

    fn spawn_machine<M: Steppable>(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let wake: Arc<Wake> = Arc::new(wake);
        let start: Box<Start> = Box::new(move || start::<M>(Arc::clone(&wake)));
        let (orders, events, thread) = start()?;
        Ok(Self {
            orders: Outbox::new(orders),
            events: Some(events),
            early: VecDeque::new(),
            start,
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
        if let Some(NumberedCommand { command: waiting, .. }) = self.orders.waiting().back()
            && command.replaces(waiting)
        {
            self.orders.waiting().pop_back();
        }
        self.orders.push(NumberedCommand {
            command,
            cancel: self.cancel.clone(),
            epoch: self.epoch,
            asked: self.asked,
        });
        self.flush();
    }

    /// The events that have arrived, oldest first; never blocks. Whoever owns
    /// a worker calls this whenever `wake` was called.
    pub fn try_events(&mut self) -> impl Iterator<Item = Event> + use<> {
        self.flush();
        let told: Vec<NumberedEvent> = self.events.iter().flat_map(Receiver::try_iter).collect();
        let mut events: Vec<Event> = self.early.drain(..).collect();
        events.extend(told.into_iter().filter_map(|told| self.hear(told)));
        events.into_iter()
    }

    /// Waits for the next event, at most `timeout`; `None` if there was none.
    pub fn next_event(&mut self, timeout: Duration) -> Option<Event> {
        self.flush();
        let deadline = Instant::now() + timeout;
        loop {
            if let Some(event) = self.early.pop_front() {
                return Some(event);
            }
            let left = deadline.saturating_duration_since(Instant::now());
            let told = self.events.as_ref()?.recv_timeout(left).ok()?;
            if let Some(event) = self.hear(told) {
                return Some(event);
            }
        }
    }

    fn flush(&mut self) {
        if !self.orders.flush() {
            // The end of the thread may be on its way, with more to say.
            let told: Vec<NumberedEvent> = self.events.iter().flat_map(Receiver::try_iter).collect();
            let heard: Vec<Event> = told.into_iter().filter_map(|told| self.hear(told)).collect();
            if !heard.iter().any(|event| matches!(event, Event::Ended { who: Helper::Sampler, .. })) {
                self.take_over();
                let error = "its thread has stopped".to_owned();
                self.early.push_back(Event::Ended { who: Helper::Sampler, error });
            }
            self.early.extend(heard);
        }
    }

    /// The event, unless it tells of a state that was given up since, or of an
    /// activity that an answer yet to come will correct: a run that ended while
    /// another shape was asked for would pass for the end of loading that.
    fn hear(&mut self, (of, event): NumberedEvent) -> Option<Event> {
        if matches!(event, Event::Ended { who: Helper::Sampler, .. }) {
            self.take_over();
        }
        let is_present = match event {
            Event::Activity(_) => of >= self.asked,
            _ => of >= self.epoch || !event.is_of_present(),
        };
        is_present.then_some(event)
    }

    /// Puts another thread in the place of one that has ended. Orders that it
    /// has not obeyed are dropped: they were about a state that is gone.
    fn take_over(&mut self) {
        self.cancel.request();
        self.cancel = Cancel::default();
        self.orders.waiting().clear();
        // Nobody will answer what the thread was asked.
        self.asked = 0;
        match (self.start)() {
            Ok((orders, events, thread)) => {
                self.orders = Outbox::new(orders);
                self.events = Some(events);
                if let Some(ended) = self.thread.replace(thread)
                    && ended.join().is_err()
                {
                    tracing::error!("the worker's thread ended in a panic");
                }
            }
            // The next order tries again.
            Err(error) => tracing::error!("cannot restart the worker's thread: {error}"),
        }
    }
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
