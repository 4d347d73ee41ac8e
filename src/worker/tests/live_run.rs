//! Runs made anew while a slider is dragged: the latest wins, none starves.

use super::*;

/// The setup that a hand on α asks for.
fn setup(seed: u64, alpha: f64) -> Setup {
    Setup { params: Params { seed, alpha, ..Params::default() }, sampling: SamplingOptions::default() }
}

fn renew(worker: &mut Worker, setup: Setup, at_once: bool) {
    worker.send(Command::Renew { setup, at_once });
}

fn begun(events: &[Event]) -> Vec<f64> {
    events
        .iter()
        .filter_map(|e| if let Event::LiveStarted(s) = e { Some(s.params.alpha) } else { None })
        .collect()
}

fn results(events: &[Event]) -> Vec<Arc<LiveResult>> {
    let result = |e: &Event| if let Event::LiveFinished(r) = e { Some(Arc::clone(r)) } else { None };
    events.iter().filter_map(result).collect()
}

fn finished(events: &[Event]) -> Vec<f64> {
    results(events).iter().map(|r| r.setup.params.alpha).collect()
}

#[test]
fn a_renewed_run_comes_whole_and_in_one_piece() {
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    worker.send(Command::StepIteration);
    until_idle(&mut worker);
    // However slowly it is watched.
    worker.send(Command::SetPace(Pace::PerSecond(1)));
    let asked = setup(WELL_BEHAVED, 3.0);
    renew(&mut worker, asked, false);
    let events = until_idle(&mut worker);
    assert_eq!(iterations(&events), [0; 0], "nothing is seen before its end");
    assert!(matches!(events[0], Event::LiveStarted(s) if s == asked));
    assert!(matches!(events[1], Event::Activity(Activity::LiveRun)));
    let [result] = &results(&events)[..] else { panic!("{events:?}") };
    let made: Vec<u32> = result.states.iter().map(|s| s.abstraction.iteration).collect();
    assert_eq!(made, (0..=30).collect::<Vec<_>>());
    for state in &result.states {
        assert_eq!((state.generation, state.run), (1, 2));
        assert_eq!((state.params, state.start), (asked.params, asked.params));
    }
    // It is the present run: Run would start over, a merge goes on from it.
    worker.send(an_edit());
    let merged = until_idle(&mut worker);
    assert_eq!(iterations(&merged), [30]);
}

#[test]
fn the_latest_wins_and_those_between_are_never_begun() {
    let seed = WAITS_AT_THIRD;
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    renew(&mut worker, setup(seed, 1.0), false);
    wait_for_stall(seed);
    for i in 2..=200 {
        renew(&mut worker, setup(WELL_BEHAVED, f64::from(i) * 0.1), false);
    }
    assert!(worker.orders.waiting().len() <= 1, "restarts pile up: {}", worker.orders.waiting().len());
    open_gate(seed);
    let mut events =
        until(&mut worker, |e| matches!(e, Event::LiveFinished(r) if r.setup.params.alpha == 20.0));
    events.extend(until_idle(&mut worker));
    let (begun, finished) = (begun(&events), finished(&events));
    assert_eq!(finished, begun, "what is begun while the hand moves is shown");
    assert_eq!(finished[0], 1.0, "also a run that is no longer the newest");
    // The channel may have held a few of them back from the worker's sight.
    assert!(finished.len() <= 3 && finished.is_sorted(), "{finished:?}");
}

#[test]
fn a_hand_that_is_always_ahead_starves_nobody() {
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    let mut alpha = 1.0;
    renew(&mut worker, setup(WELL_BEHAVED, alpha), false);
    let mut events = Vec::new();
    while results(&events).len() < 20 {
        let event = worker.next_event(PATIENCE).expect("an event");
        // Whatever the worker does, there is a newer setup before it is done.
        if matches!(event, Event::LiveStarted(_)) {
            alpha += 1.0;
            renew(&mut worker, setup(WELL_BEHAVED, alpha), false);
        }
        events.push(event);
    }
    let (begun, finished) = (begun(&events), finished(&events));
    assert!(begun.len() <= finished.len() + 1, "a run was begun in vain: {begun:?}, {finished:?}");
    assert!(finished.is_sorted_by(|a, b| a < b), "an older result came after a newer: {finished:?}");
}

#[test]
fn a_hand_at_rest_cancels_what_is_stale_within_a_step() {
    let seed = STALLS_AT_THIRD + 4;
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    renew(&mut worker, setup(seed, 1.0), false);
    wait_for_stall(seed);
    renew(&mut worker, setup(WELL_BEHAVED, 2.0), false);
    renew(&mut worker, setup(WELL_BEHAVED, 3.0), true);
    let events = until_idle(&mut worker);
    assert_eq!((begun(&events), finished(&events)), (vec![1.0, 3.0], vec![3.0]));
    assert_eq!(STEPS[seed as usize].load(Ordering::SeqCst), 3, "the cancelled step was the last");
    assert_eq!(failures(&events), 0);
    assert_eq!(measured(&events).0, [30], "the result is measured once the hand rests");
}

#[test]
fn a_renewal_that_is_stopped_leaves_the_last_result() {
    let seed = STALLS_AT_THIRD + 5;
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    renew(&mut worker, setup(WELL_BEHAVED, 1.0), true);
    until_idle(&mut worker);
    renew(&mut worker, setup(seed, 2.0), false);
    wait_for_stall(seed);
    worker.send(Command::Pause);
    let events = until_idle(&mut worker);
    assert_eq!((finished(&events), iterations(&events)), (vec![], vec![]));
    worker.send(an_edit());
    let events = until_idle(&mut worker);
    let Some(Event::Snapshot(state)) = events.iter().find(|e| matches!(e, Event::Snapshot(_))) else {
        panic!("no state")
    };
    assert_eq!((state.run, state.start.alpha), (2, 1.0), "it goes on from the last result");
    // So does one that fails.
    renew(&mut worker, setup(PANICS_AT_THIRD, 4.0), false);
    let events = until_idle(&mut worker);
    assert_eq!((failures(&events), finished(&events)), (1, vec![]));
    renew(&mut worker, setup(WELL_BEHAVED, 5.0), false);
    assert_eq!(finished(&until_idle(&mut worker)), [5.0]);
}

#[test]
fn a_watched_run_makes_way_at_once() {
    let seed = STALLS_AT_THIRD + 6;
    let mut worker = worker();
    load(&mut worker, seed);
    worker.send(Command::Run);
    wait_for_stall(seed);
    renew(&mut worker, setup(WELL_BEHAVED, 2.0), true);
    let events = until_idle(&mut worker);
    assert_eq!((iterations(&events), finished(&events)), (vec![1, 2], vec![2.0]));
    // And the other way round: a reset takes the place of a renewal.
    let seed = STALLS_AT_THIRD + 7;
    renew(&mut worker, setup(seed, 3.0), false);
    wait_for_stall(seed);
    worker.send(Command::Reset);
    let events = until_idle(&mut worker);
    assert_eq!((iterations(&events), finished(&events)), (vec![0], vec![]));
}

#[test]
fn what_needs_a_result_waits_for_it() {
    let seed = WAITS_AT_THIRD + 1;
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    renew(&mut worker, setup(seed, 1.0), false);
    wait_for_stall(seed);
    worker.send(an_edit());
    // Behind it in the channel, and yet first.
    renew(&mut worker, setup(WELL_BEHAVED, 2.0), false);
    open_gate(seed);
    let events = until(&mut worker, |e| matches!(e, Event::Snapshot(_)));
    assert_eq!(finished(&events), [1.0, 2.0]);
    assert_eq!(iterations(&events), [30], "the merge was made on the newest result");
}

#[test]
fn other_samples_come_with_their_run() {
    let mut worker = worker();
    load(&mut worker, WELL_BEHAVED);
    let sampling = SamplingOptions { points: 300, ..SamplingOptions::default() };
    renew(&mut worker, Setup { sampling, ..setup(WELL_BEHAVED, 1.0) }, false);
    let events = until_idle(&mut worker);
    assert!(!events.iter().any(|e| matches!(e, Event::Loaded(_))), "the old samples stay until then");
    let [result] = &results(&events)[..] else { panic!("{events:?}") };
    assert_eq!((result.loaded.cloud.points.len(), result.loaded.sampling), (300, sampling));
    assert!(result.states.iter().all(|s| s.generation == 2 && s.abstraction.labels.len() == 300));
}

#[test]
fn without_a_shape_the_setup_is_kept_for_later() {
    let mut worker = worker();
    renew(&mut worker, setup(WELL_BEHAVED, 7.0), false);
    worker.send(Command::Load { source: Source::BuiltIn, sampling: SamplingOptions::default() });
    let events = until_idle(&mut worker);
    assert_eq!((failures(&events), finished(&events)), (0, vec![]));
    assert!(events.iter().any(|e| matches!(e, Event::Snapshot(s) if s.start.alpha == 7.0)));
}
