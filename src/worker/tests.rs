//! The thread's promises, kept with a machine that stalls or panics on demand.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::geometry::Bulk;
use crate::inference::{Edit, Params};
use scripted::*;

mod ending;
mod live_run;
mod scripted;

/// Longer than anything here takes; reached only by a failing test.
const PATIENCE: Duration = Duration::from_secs(300);

fn worker() -> Worker {
    Worker::spawn_machine::<Scripted>(|| {}).expect("a thread")
}

fn load(worker: &mut Worker, seed: u64) -> Vec<Event> {
    worker.send(Command::SetParams(Params { seed, ..Params::default() }));
    worker.send(Command::Load { source: Source::BuiltIn, sampling: SamplingOptions::default() });
    until_idle(worker)
}

/// All events up to and with the first that says the worker is idle.
fn until_idle(worker: &mut Worker) -> Vec<Event> {
    until(worker, |event| matches!(event, Event::Activity(Activity::Idle)))
}

fn until(worker: &mut Worker, last: impl Fn(&Event) -> bool) -> Vec<Event> {
    let mut events = Vec::new();
    loop {
        let event = worker.next_event(PATIENCE).unwrap_or_else(|| panic!("only {events:?}"));
        let is_last = last(&event);
        events.push(event);
        if is_last {
            return events;
        }
    }
}

fn iterations(events: &[Event]) -> Vec<u32> {
    events
        .iter()
        .filter_map(|event| match event {
            Event::Snapshot(snapshot) => Some(snapshot.abstraction.iteration),
            _ => None,
        })
        .collect()
}

fn failures(events: &[Event]) -> usize {
    events.iter().filter(|event| matches!(event, Event::Failed { .. })).count()
}

/// Waits until the machine is in the middle of its third step.
fn wait_for_stall(seed: u64) {
    let begun = Instant::now();
    while !STALLED[seed as usize].load(Ordering::SeqCst) {
        assert!(begun.elapsed() < PATIENCE, "the machine never reached its third step");
        std::thread::yield_now();
    }
}

#[test]
fn a_run_shows_every_iteration_once_and_in_order() {
    let mut worker = worker();
    let loaded = load(&mut worker, WELL_BEHAVED);
    assert!(matches!(loaded[0], Event::Activity(Activity::Loading)));
    assert_eq!(iterations(&loaded), [0], "the start is a state of its own");
    worker.send(Command::Run);
    assert_eq!(iterations(&until_idle(&mut worker)), (1..=30).collect::<Vec<_>>());
    // A finished run starts anew, as a run of its own.
    worker.send(Command::Run);
    let again = until_idle(&mut worker);
    assert_eq!(iterations(&again), (0..=30).collect::<Vec<_>>());
    let Some(Event::Snapshot(last)) = again.iter().rev().find(|e| matches!(e, Event::Snapshot(_))) else {
        panic!("no snapshot")
    };
    assert_eq!((last.generation, last.run), (1, 2));
}

#[test]
fn a_run_that_finds_nothing_says_so_at_its_end() {
    for (seed, failed) in [(WELL_BEHAVED, 0), (FINDS_NOTHING, 1)] {
        let mut worker = worker();
        load(&mut worker, seed);
        worker.send(Command::Run);
        let events = until_idle(&mut worker);
        assert_eq!(failures(&events), failed, "{events:?}");
        let said = |e: &Event| matches!(e, Event::Failed { error, .. } if error.contains("no primitives were found"));
        assert_eq!(events.iter().filter(|e| said(e)).count(), failed);
    }
}

#[test]
fn a_pause_in_the_middle_of_a_step_leaves_the_state_before_it() {
    let seed = STALLS_AT_THIRD;
    let mut worker = worker();
    load(&mut worker, seed);
    worker.send(Command::Run);
    wait_for_stall(seed);
    worker.send(Command::Pause);
    let events = until_idle(&mut worker);
    assert_eq!(iterations(&events), [1, 2]);
    assert_eq!(failures(&events), 0, "a pause is no failure");
    // Nothing is lost: it goes on from there with other parameters.
    worker.send(Command::SetParams(Params { seed: WELL_BEHAVED, ..Params::default() }));
    worker.send(Command::StepIteration);
    assert_eq!(iterations(&until_idle(&mut worker)), [3]);
}

#[test]
fn reset_and_load_interrupt_a_step() {
    let seed = STALLS_AT_THIRD + 1;
    let mut worker = worker();
    load(&mut worker, seed);
    worker.send(Command::Run);
    wait_for_stall(seed);
    worker.send(Command::Reset);
    assert_eq!(iterations(&until_idle(&mut worker)), [1, 2, 0]);
    STALLED[seed as usize].store(false, Ordering::SeqCst);
    worker.send(Command::Run);
    wait_for_stall(seed);
    worker.send(Command::Load { source: Source::BuiltIn, sampling: SamplingOptions::default() });
    let events = until_idle(&mut worker);
    assert_eq!(iterations(&events), [1, 2, 0]);
    assert!(matches!(&events[events.len() - 2], Event::Snapshot(s) if s.generation == 2));
}

#[test]
fn a_file_that_cannot_be_opened_leaves_the_state() {
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    worker.send(Command::StepIteration);
    until_idle(&mut worker);
    let missing = PathBuf::from("no/such/file.obj");
    worker.send(Command::Load { source: Source::File(missing), sampling: SamplingOptions::default() });
    let events = until_idle(&mut worker);
    let Some(Event::Failed { what, error }) = events.iter().find(|e| matches!(e, Event::Failed { .. }))
    else {
        panic!("no failure was told: {events:?}")
    };
    assert!(what.contains("file.obj"), "{what}");
    assert!(!error.is_empty());
    assert_eq!(iterations(&events), [0; 0]);
    worker.send(Command::StepIteration);
    assert_eq!(iterations(&until_idle(&mut worker)), [2]);
}

#[test]
fn a_panic_is_told_and_the_last_good_state_goes_on() {
    let mut worker = worker();
    load(&mut worker, PANICS_AT_THIRD);
    worker.send(Command::Run);
    let events = until_idle(&mut worker);
    assert_eq!(iterations(&events), [1, 2]);
    let told = events.iter().any(
        |event| matches!(event, Event::Failed { error, .. } if error.contains("the third step always panics")),
    );
    assert!(told, "{events:?}");
    worker.send(Command::SetParams(Params { seed: WELL_BEHAVED, ..Params::default() }));
    worker.send(Command::Run);
    assert_eq!(iterations(&until_idle(&mut worker)), (3..=30).collect::<Vec<_>>());
}

#[test]
fn parameters_reach_a_run_that_goes_on() {
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    worker.send(Command::StepIteration);
    until_idle(&mut worker);
    let changed = Params { alpha: 7.0, clusters: 12, ..Params::default() };
    worker.send(Command::SetParams(changed));
    worker.send(Command::StepIteration);
    let events = until_idle(&mut worker);
    let Some(Event::Snapshot(snapshot)) = events.iter().find(|e| matches!(e, Event::Snapshot(_))) else {
        panic!("no snapshot")
    };
    assert_eq!(snapshot.params, changed);
    assert_eq!(snapshot.start.clusters, 30, "K belongs to the start of the run");
    worker.send(Command::SetParams(Params { alpha: f64::NAN, ..Params::default() }));
    worker.send(Command::Pause);
    assert_eq!(failures(&until_idle(&mut worker)), 1, "bad parameters are refused, and said so");
}

#[test]
fn merges_are_stepped_one_by_one_or_to_the_end() {
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    worker.send(an_edit());
    let step = until_idle(&mut worker);
    assert!(step.iter().any(|e| matches!(e, Event::Snapshot(s) if s.cause == Cause::Edit)));
    worker.send(Command::MergeAll);
    let all = until_idle(&mut worker);
    assert_eq!(iterations(&all).len() as u32, MERGES_LEFT - 1);
    assert!(all.iter().any(|e| matches!(e, Event::MergeStep(Some(report)) if report.merged == (3, 9))));
    assert!(all.iter().any(|e| matches!(e, Event::MergeStep(None))), "it ends by saying that none is left");
    worker.send(Command::MergeAll);
    let none = until_idle(&mut worker);
    assert!(none.iter().any(|e| matches!(e, Event::MergeStep(None))), "{none:?}");
    worker.send(Command::ProposeMerge { of: None, skipped: Bulk::default() });
    let none = until_idle(&mut worker);
    assert!(none.iter().any(|e| matches!(e, Event::Proposed(None))), "{none:?}");
}

fn open_gate(seed: u64) {
    GATES[seed as usize].store(true, Ordering::SeqCst);
}

/// Any change that the scripted machine takes.
fn an_edit() -> Command {
    Command::Edit(Edit::Refit { id: 1 })
}

fn states(events: &[Event]) -> Vec<Arc<Snapshot>> {
    events
        .iter()
        .filter_map(|event| match event {
            Event::Snapshot(state) => Some(Arc::clone(state)),
            _ => None,
        })
        .collect()
}

fn shape_of(events: &[Event]) -> Arc<LoadedShape> {
    let loaded = events.iter().find_map(|e| match e {
        Event::Loaded(loaded) => Some(Arc::clone(loaded)),
        _ => None,
    });
    loaded.expect("a shape")
}

#[test]
fn a_run_goes_on_from_any_state_that_was_told() {
    let mut worker = worker();
    let loaded = shape_of(&load(&mut worker, WELL_BEHAVED));
    worker.send(Command::Run);
    let run = states(&until_idle(&mut worker));
    let state = State { loaded: Arc::clone(&loaded), snapshot: Arc::clone(&run[9]) };
    worker.send(Command::Resume(state.clone()));
    assert_eq!(iterations(&until_idle(&mut worker)), [0; 0], "the owner has that state already");
    worker.send(Command::StepIteration);
    assert_eq!(iterations(&until_idle(&mut worker)), [11]);
    // Also when another shape has been opened since.
    let other = shape_of(&load(&mut worker, WELL_BEHAVED));
    assert!(!Arc::ptr_eq(&other, &loaded));
    worker.send(Command::Resume(state));
    until_idle(&mut worker);
    worker.send(Command::StepIteration);
    let events = until_idle(&mut worker);
    assert_eq!(iterations(&events), [11]);
    assert_eq!(states(&events)[0].generation, loaded.generation);
    // A finished run with more to do.
    worker.send(Command::Run);
    assert_eq!(iterations(&until_idle(&mut worker)).last(), Some(&30));
    worker.send(Command::Extend(3));
    assert_eq!(iterations(&until_idle(&mut worker)), [31, 32, 33]);
}

#[test]
fn a_state_that_was_given_up_is_never_heard_of_again() {
    let seed = STALLS_AT_THIRD + 8;
    let mut worker = worker();
    let events = load(&mut worker, seed);
    let state = State { loaded: shape_of(&events), snapshot: states(&events).remove(0) };
    worker.send(Command::Run);
    wait_for_stall(seed);
    // Two steps wait in the channel, the third is in the making.
    worker.send(Command::Resume(state));
    let events = until_idle(&mut worker);
    assert!(matches!(events[..], [Event::Activity(Activity::Idle)]), "{events:?}");
    worker.send(Command::StepIteration);
    assert_eq!(iterations(&until_idle(&mut worker)), [1]);
}

#[test]
fn an_edit_in_the_middle_of_a_run_is_one_more_state() {
    let seed = WAITS_AT_THIRD + 2;
    let mut worker = worker();
    load(&mut worker, seed);
    worker.send(Command::Run);
    wait_for_stall(seed);
    worker.send(an_edit());
    open_gate(seed);
    let events = until_idle(&mut worker);
    assert_eq!(failures(&events), 0);
    let states = states(&events);
    let edits: Vec<u32> =
        states.iter().filter(|s| s.cause == Cause::Edit).map(|s| s.abstraction.iteration).collect();
    assert_eq!(edits, [3], "the step that was under way was made");
    assert_eq!(states.last().map(|s| s.abstraction.iteration), Some(30), "and the run went on");
    assert_eq!(states.last().map(|s| s.abstraction.figures.clusters), Some(1), "from there");
    // What is refused changes nothing, and says so.
    worker.send(Command::Edit(Edit::Refit { id: 0 }));
    let events = until_idle(&mut worker);
    assert_eq!((failures(&events), iterations(&events)), (1, vec![]));
}

/// Were it to wait for the next step, it would each time; a busy machine delays
/// it now and then.
#[test]
fn a_pace_does_not_hold_back_a_pause() {
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    worker.send(Command::SetPace(Pace::PerSecond(1)));
    let was_quick = (0..20).any(|_| {
        worker.send(Command::Run);
        until(&mut worker, |event| matches!(event, Event::Snapshot(_)));
        let begun = Instant::now();
        worker.send(Command::Pause);
        let rest = until_idle(&mut worker);
        iterations(&rest).is_empty() && begun.elapsed() < Duration::from_millis(900)
    });
    assert!(was_quick, "the pause waited for the pace");
}

#[test]
fn nothing_is_run_without_a_shape() {
    let mut worker = worker();
    let proposal = Command::ProposeMerge { of: None, skipped: Bulk::default() };
    for command in [Command::Run, Command::MergeAll, Command::Reset, an_edit(), proposal] {
        worker.send(command);
        assert_eq!(failures(&until_idle(&mut worker)), 1);
    }
}

#[test]
fn an_owner_that_takes_no_events_can_send_and_drop() {
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    worker.send(Command::SetParams(Params { iterations: 500, ..Params::default() }));
    worker.send(Command::Run);
    // Many more than the channel holds, while the worker waits for its events to be taken.
    for i in 0..10_000_u32 {
        worker.send(Command::SetParams(Params { alpha: f64::from(1 + i % 50), ..Params::default() }));
    }
    assert!(
        worker.orders.waiting().len() <= 1,
        "a dragged slider piles up: {}",
        worker.orders.waiting().len()
    );
    drop(worker);
}

#[test]
fn dropping_stops_a_step_and_joins_the_thread() {
    let seed = STALLS_AT_THIRD + 2;
    let owned = Arc::new(());
    let in_thread = Arc::clone(&owned);
    let mut worker = Worker::spawn_machine::<Scripted>(move || {
        let _ = &in_thread;
    })
    .expect("a thread");
    load(&mut worker, seed);
    worker.send(Command::Run);
    wait_for_stall(seed);
    // The thread owns the callback: when it has ended, nobody holds `owned` any more.
    assert_eq!(Arc::strong_count(&owned), 2);
    drop(worker);
    assert_eq!(Arc::strong_count(&owned), 1, "the thread outlived its owner");
}

#[test]
fn the_owner_is_woken_for_each_event() {
    let woken = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&woken);
    let mut worker = Worker::spawn_machine::<Scripted>(move || {
        counter.fetch_add(1, Ordering::SeqCst);
    })
    .expect("a thread");
    let mut events = load(&mut worker, WELL_BEHAVED).len();
    worker.send(Command::Run);
    events += until(&mut worker, |event| matches!(event, Event::Measured(_))).len();
    // The thread that measures is not waited for.
    let begun = Instant::now();
    while woken.load(Ordering::SeqCst) < events && begun.elapsed() < PATIENCE {
        std::thread::yield_now();
    }
    drop(worker);
    assert_eq!(woken.load(Ordering::SeqCst), events);
}

/// A run that ends just before another shape is asked for must not pass for
/// the end of loading that.
#[test]
fn rest_from_before_a_command_is_not_told_after_it() {
    let woken = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&woken);
    let mut worker = Worker::spawn_machine::<Scripted>(move || {
        counter.fetch_add(1, Ordering::SeqCst);
    })
    .expect("a thread");
    load(&mut worker, WELL_BEHAVED);
    worker.send(Command::SetParams(Params { seed: WELL_BEHAVED, iterations: 2, ..Params::default() }));
    woken.store(0, Ordering::SeqCst);
    worker.send(Command::Run);
    // Its word, two states, that the last is being measured and was: then it rests.
    let begun = Instant::now();
    while woken.load(Ordering::SeqCst) < 6 {
        assert!(begun.elapsed() < PATIENCE, "only {woken:?} events of the run");
        std::thread::yield_now();
    }
    worker.send(Command::Load { source: Source::BuiltIn, sampling: SamplingOptions::default() });
    let events = until_idle(&mut worker);
    assert!(events.iter().any(|event| matches!(event, Event::Loaded(_))), "{events:?}");
    let activities: Vec<Activity> = events
        .iter()
        .filter_map(|event| if let Event::Activity(activity) = event { Some(*activity) } else { None })
        .collect();
    assert_eq!(activities, [Activity::Loading, Activity::Idle], "nothing of the run is left");
}

/// The states that are said to be measured, and those that were.
fn measured(events: &[Event]) -> (Vec<u32>, Vec<u32>) {
    let of = |pick: fn(&Event) -> Option<&Snapshot>| {
        events.iter().filter_map(pick).map(|s| s.abstraction.iteration).collect()
    };
    (
        of(|event| if let Event::Measuring(snapshot) = event { Some(snapshot) } else { None }),
        of(|event| if let Event::Measured(measurement) = event { Some(&measurement.snapshot) } else { None }),
    )
}

#[test]
fn states_are_measured_where_the_run_comes_to_rest() {
    let seed = STALLS_AT_THIRD + 3;
    let mut worker = worker();
    assert_eq!(measured(&load(&mut worker, seed)), (vec![], vec![]), "the start is not worth it");
    worker.send(Command::Run);
    wait_for_stall(seed);
    worker.send(Command::Pause);
    let mut events = until_idle(&mut worker);
    assert_eq!(measured(&events).0, [2], "not each iteration of a running run");
    // The steps go on at once, whatever is being measured.
    worker.send(Command::SetParams(Params { seed: WELL_BEHAVED, ..Params::default() }));
    for _ in 0..3 {
        worker.send(Command::StepIteration);
        events.extend(until_idle(&mut worker));
    }
    worker.send(Command::Pause);
    events.extend(until_idle(&mut worker));
    assert_eq!(measured(&events).0, [2, 3, 4, 5], "a pause at the same state is nothing new");
    let is_last =
        |event: &Event| matches!(event, Event::Measured(m) if m.snapshot.abstraction.iteration == 5);
    if !events.iter().any(is_last) {
        events.extend(until(&mut worker, is_last));
    }
    let (_, found) = measured(&events);
    assert!(found.is_sorted() && found.ends_with(&[5]), "{found:?}");
    worker.send(Command::Reset);
    assert_eq!(measured(&until_idle(&mut worker)), (vec![], vec![]));
}
