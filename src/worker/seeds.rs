//! The same run with several seeds, beside whatever else goes on: on a thread
//! and on cores of its own, so that no order and no step waits for it.

use std::sync::mpsc::{Receiver, Sender, SyncSender, channel};
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use rayon::ThreadPool;

use super::channel::{NumberedEvent, Wake};
use super::machine::Steppable;
use super::measure::{References, again_after_faults, measured};
use super::protocol::{Cause, Event, Helper, Measurement, SeedNews, SeedRequest, SeedRun, Snapshot, State};
use super::trouble::{Stop, Trouble, guarded};
use crate::geometry::palette::Colors;
use crate::inference::{Abstraction, Cancel, Occurrence, Params, align_labels};

const WHAT: &str = "Cannot run other seeds";
/// Labels that the states of one run may hold together; where they would hold
/// more, only the first and the last state are kept.
const MOST_LABELS: usize = 1 << 22;
/// Least time from one word on the progress to the next.
const PROGRESS: Duration = Duration::from_millis(60);

/// A request, with a run on the same cloud if there is one.
struct Job<M> {
    request: SeedRequest,
    like: Option<M>,
}

/// The engine's end. Nobody waits for the thread: it stops at the latest when
/// the step that is under way is cancelled.
pub(super) struct SeedRunner<M> {
    /// `None` where the operating system gave no threads.
    jobs: Option<Sender<Job<M>>>,
    cancel: Cancel,
}

impl<M: Steppable> SeedRunner<M> {
    /// Results go out as events.
    pub(super) fn spawn(events: SyncSender<NumberedEvent>, wake: &Arc<Wake>, references: References) -> Self {
        // Half of the cores are left to the window and the run.
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let (jobs, incoming) = channel();
        let wake = Arc::downgrade(wake);
        let started = rayon::ThreadPoolBuilder::new()
            .num_threads((cores / 2).max(1))
            .thread_name(|i| format!("seeds {i}"))
            .build()
            .map_err(|e| e.to_string())
            .and_then(|pool| {
                std::thread::Builder::new()
                    .name("seeds".to_owned())
                    .spawn(move || {
                        let work = SeedWork { pool, events, wake, references };
                        again_after_faults(Helper::Seeds, &work.events, &work.wake, || work.run(&incoming));
                    })
                    .map_err(|e| e.to_string())
            });
        if let Err(error) = &started {
            tracing::warn!("cannot start threads for seed runs: {error}");
        }
        Self { jobs: started.ok().map(|_| jobs), cancel: Cancel::default() }
    }

    /// Takes a request in place of the one before; whether it will be obeyed.
    pub(super) fn ask(&mut self, request: SeedRequest, like: Option<M>) -> bool {
        self.cancel.request();
        self.cancel = request.cancel.clone();
        self.jobs.as_ref().is_some_and(|jobs| jobs.send(Job { request, like }).is_ok())
    }
}

impl<M> Drop for SeedRunner<M> {
    fn drop(&mut self) {
        self.cancel.request();
    }
}

/// The owner is gone.
struct Gone;

/// What the thread works with.
struct SeedWork {
    pool: ThreadPool,
    events: SyncSender<NumberedEvent>,
    wake: Weak<Wake>,
    references: References,
}

impl SeedWork {
    /// Answers requests until one of the two ends is gone.
    fn run<M: Steppable>(&self, jobs: &Receiver<Job<M>>) {
        while let Ok(job) = jobs.recv() {
            let job = jobs.try_iter().last().unwrap_or(job);
            if self.answer(job).is_err() {
                return;
            }
        }
    }

    fn tell(&self, request: &SeedRequest, news: SeedNews) -> Result<(), Gone> {
        let event = Event::Seeds { request: request.number, news };
        // An owner that has this event will be woken for it, too.
        let wake = self.wake.upgrade().ok_or(Gone)?;
        self.events.send((0, event)).map_err(|_| Gone)?;
        wake();
        Ok(())
    }

    fn answer<M: Steppable>(&self, Job { request, like }: Job<M>) -> Result<(), Gone> {
        let State { loaded, snapshot } = &request.state;
        let base = self.guarded(|| {
            match like {
                Some(machine) => machine.resumed(&snapshot.checkpoint, &request.cancel),
                None => M::resume(Arc::clone(&loaded.cloud), &snapshot.checkpoint, &request.cancel),
            }
            .map_err(|error| Stop::inference(WHAT, &error))
        });
        let mut runs = Vec::new();
        let mut outcome = Ok(());
        match base {
            Ok(base) => {
                for seed in request.seeds() {
                    outcome = self.make(&request, &base, seed)?.map(|run| runs.push(run));
                    if outcome.is_err() {
                        break;
                    }
                }
            }
            Err(stop) => outcome = Err(stop),
        }
        if let Err(Stop::Trouble(Trouble { what, error })) = outcome {
            self.tell(&request, SeedNews::Failed { what, error })?;
        }
        self.measure(&request, &runs)?;
        self.tell(&request, SeedNews::Over)
    }

    /// Makes the run with one seed, and tells it.
    fn make<M: Steppable>(
        &self,
        request: &SeedRequest,
        base: &M,
        seed: u64,
    ) -> Result<Result<Arc<SeedRun>, Stop>, Gone> {
        let params = Params { seed, ..request.params };
        let base = base.clone();
        let started = self.guarded(move || {
            let machine = base.restarted(params, &request.cancel);
            let machine = machine.map_err(|error| Stop::inference(WHAT, &error))?;
            let abstraction = machine.abstraction();
            Ok((machine, abstraction))
        });
        let (mut machine, abstraction) = match started {
            Ok(started) => started,
            Err(stop) => return Ok(Err(stop)),
        };
        let mut states = States::new(request, params, abstraction, &machine);
        let mut told = Instant::now();
        self.tell(request, SeedNews::Progress { seed, share: 0.0 })?;
        while !machine.is_finished() {
            let begun = Instant::now();
            let stepped = self.guarded(|| {
                let occurrences = machine.step(&request.cancel);
                let occurrences = occurrences.map_err(|error| Stop::inference(WHAT, &error))?;
                Ok((occurrences, machine.abstraction()))
            });
            match stepped {
                Ok((occurrences, abstraction)) => {
                    let share = abstraction.iteration as f32 / params.iterations.max(1) as f32;
                    states.keep(abstraction, &machine, Cause::Step, occurrences, begun.elapsed());
                    if told.elapsed() >= PROGRESS {
                        told = Instant::now();
                        self.tell(request, SeedNews::Progress { seed, share: share.min(1.0) })?;
                    }
                }
                Err(stop) => return Ok(Err(stop)),
            }
        }
        let run = Arc::new(self.pool.install(|| states.finish(seed)));
        self.tell(request, SeedNews::Finished(Arc::clone(&run)))?;
        Ok(Ok(run))
    }

    /// Measures what the runs came to, one after the other.
    fn measure(&self, request: &SeedRequest, runs: &[Arc<SeedRun>]) -> Result<(), Gone> {
        for run in runs {
            if request.cancel.is_requested() {
                return Ok(());
            }
            let Some(last) = run.states.last() else { continue };
            let reference = self.references.of(&run.loaded.shape, &self.pool);
            let result = reference.and_then(|reference| measured(last, &reference, &self.pool));
            let measurement = Measurement { snapshot: Arc::clone(last), result };
            self.tell(request, SeedNews::Measured { seed: run.seed, measurement: Arc::new(measurement) })?;
        }
        Ok(())
    }

    fn guarded<T: Send>(&self, work: impl FnOnce() -> Result<T, Stop> + Send) -> Result<T, Stop> {
        guarded(|| self.pool.install(work))
    }
}

/// The states of a run in the making.
struct States<'a> {
    request: &'a SeedRequest,
    params: Params,
    kept: Vec<Arc<Snapshot>>,
    keeps_all: bool,
    /// Time spent in steps.
    elapsed: Duration,
}

impl<'a> States<'a> {
    fn new(request: &'a SeedRequest, params: Params, first: Abstraction, machine: &impl Steppable) -> Self {
        let labels = first.labels.len() * (params.iterations as usize + 1);
        let mut new = Self {
            request,
            params,
            kept: Vec::new(),
            keeps_all: labels <= MOST_LABELS,
            elapsed: Duration::ZERO,
        };
        new.keep(first, machine, Cause::Start, Vec::new(), Duration::ZERO);
        new
    }

    fn keep(
        &mut self,
        abstraction: Abstraction,
        machine: &impl Steppable,
        cause: Cause,
        occurrences: Vec<Occurrence>,
        took: Duration,
    ) {
        self.elapsed += took;
        if !self.keeps_all && self.kept.len() > 1 {
            self.kept.pop();
        }
        let before = &self.request.state.snapshot;
        self.kept.push(Arc::new(Snapshot {
            key: Snapshot::new_key(),
            generation: self.request.state.loaded.generation,
            run: before.run,
            abstraction,
            checkpoint: Arc::new(machine.checkpoint()),
            cause,
            params: self.params,
            start: self.params,
            occurrences,
            elapsed: self.elapsed,
        }));
    }

    fn finish(self, seed: u64) -> SeedRun {
        let State { loaded, snapshot } = &self.request.state;
        let colors = colors_like(&snapshot.abstraction, &self.request.colors, &self.kept);
        SeedRun { seed, loaded: Arc::clone(loaded), states: self.kept, colors: Arc::new(colors) }
    }
}

/// Colours for a run beside another: what stands for the same part has the same
/// colour.
fn colors_like(like: &Abstraction, colors: &Colors, states: &[Arc<Snapshot>]) -> Colors {
    let Some(last) = states.last() else { return Colors::default() };
    let kept = align_labels(&like.labels, &last.abstraction.labels);
    let kept = kept.into_iter().map(|(new, old)| (new, colors.place(old))).collect();
    // The last state first: its primitives are looked at longest.
    let all = states.iter().rev().flat_map(|s| s.abstraction.primitives.iter().map(|p| p.id));
    Colors::new(kept, all)
}
