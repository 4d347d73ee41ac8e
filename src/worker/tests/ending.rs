//! A thread that ends in a fault is told of, and another takes its place.

use super::*;

fn ended(events: &[Event]) -> Vec<&str> {
    let of_sampler = |event| match event {
        &Event::Ended { who: Helper::Sampler, ref error } => Some(error.as_str()),
        _ => None,
    };
    events.iter().filter_map(of_sampler).collect()
}

fn is_ended(event: &Event) -> bool {
    matches!(event, Event::Ended { .. })
}

#[test]
fn another_thread_goes_on_from_the_last_state_that_was_told() {
    let mut worker = worker();
    let mut told = load(&mut worker, ENDS_AT_THIRD);
    let loaded = shape_of(&told);
    worker.send(Command::Run);
    told.extend(until(&mut worker, is_ended));
    assert_eq!(ended(&told), ["nobody catches this"]);
    let last = states(&told).pop().expect("states were told");
    assert_eq!(last.abstraction.iteration, 2);
    // As a window does: the settings, the last good state, and on.
    worker.send(Command::SetParams(Params { seed: WELL_BEHAVED, ..Params::default() }));
    worker.send(Command::Resume(State { loaded, snapshot: last }));
    worker.send(Command::SetParams(Params { seed: WELL_BEHAVED, ..Params::default() }));
    worker.send(Command::Run);
    let again = until(&mut worker, |e| matches!(e, Event::Snapshot(s) if s.abstraction.iteration == 30));
    assert_eq!(iterations(&again), (3..=30).collect::<Vec<_>>());
    assert_eq!((failures(&again), ended(&again).len()), (0, 0), "{again:?}");
}

#[test]
fn the_owner_is_woken_and_a_thread_can_end_again_and_again() {
    let woken = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&woken);
    let mut worker = Worker::spawn_machine::<Scripted>(move || {
        counter.fetch_add(1, Ordering::SeqCst);
    })
    .expect("a thread");
    for round in 1..=3 {
        load(&mut worker, ENDS_AT_THIRD);
        worker.send(Command::Run);
        let before = woken.load(Ordering::SeqCst);
        let events = until(&mut worker, is_ended);
        assert_eq!(ended(&events).len(), 1, "round {round}: {events:?}");
        let begun = Instant::now();
        while woken.load(Ordering::SeqCst) <= before {
            assert!(begun.elapsed() < PATIENCE, "a window that sleeps never learns of it");
            std::thread::yield_now();
        }
    }
    // An order without a shape is answered, as by any new worker.
    worker.send(Command::Run);
    assert_eq!(failures(&until_idle(&mut worker)), 1);
}

#[test]
fn orders_that_come_too_late_are_dropped_and_nothing_blocks() {
    let mut worker = worker();
    load(&mut worker, ENDS_AT_THIRD);
    worker.send(Command::Run);
    // The owner has not looked yet, and goes on asking.
    for _ in 0..1000 {
        worker.send(Command::StepIteration);
    }
    let events = until(&mut worker, is_ended);
    assert_eq!(ended(&events).len(), 1, "{events:?}");
    assert_eq!(worker.orders.waiting().len(), 0);
    drop(worker);
}

#[test]
fn a_thread_that_works_beside_begins_again() {
    let (events, told) = mpsc::sync_channel(4);
    let wake: Arc<Wake> = Arc::new(|| {});
    let rounds = AtomicUsize::new(0);
    measure::again_after_faults(Helper::Measurer, &events, &Arc::downgrade(&wake), || {
        assert!(rounds.fetch_add(1, Ordering::SeqCst) > 0, "the first round fails");
    });
    assert_eq!(rounds.load(Ordering::SeqCst), 2);
    let told: Vec<NumberedEvent> = told.try_iter().collect();
    let [(_, Event::Ended { who: Helper::Measurer, error })] = &told[..] else { panic!("{told:?}") };
    assert_eq!(error, "the first round fails");
}
