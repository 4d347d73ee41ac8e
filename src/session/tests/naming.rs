//! Names of states.

use super::*;
use crate::session::naming::StateName;

fn led_by(cause: Cause, phase: Phase, iteration: u32, occurrences: Vec<Occurrence>) -> Event {
    let Event::Snapshot(state) = snapshot(&[1, 2, 3], phase, iteration, occurrences) else { unreachable!() };
    Event::Snapshot(Arc::new(Snapshot { cause, key: Snapshot::new_key(), ..(*state).clone() }))
}

/// Two iterations, the end, and what a hand does then.
fn worked_on() -> Session {
    let mut session = session();
    let merged = |other| vec![Occurrence::Merged(super::merged(1, other))];
    let deleted = |ids: &[u32]| ids.iter().map(|&id| Occurrence::Deleted { id, points: 3 }).collect();
    for event in [
        led_by(Cause::Step, Phase::Sampling, 1, vec![]),
        led_by(Cause::Step, Phase::Sampling, 2, vec![]),
        led_by(Cause::Step, Phase::Finished, 2, vec![]),
        led_by(Cause::Merge, Phase::Sampling, 2, merged(2)),
        led_by(Cause::Merge, Phase::Sampling, 2, merged(3)),
        led_by(Cause::Edit, Phase::Sampling, 2, deleted(&[7])),
        led_by(Cause::Edit, Phase::Sampling, 2, deleted(&[1, 2, 3, 4, 5])),
        led_by(Cause::Step, Phase::Finished, 2, vec![]),
        led_by(Cause::Edit, Phase::Sampling, 2, vec![Occurrence::Released { points: 4 }]),
        led_by(Cause::Step, Phase::Sampling, 3, vec![]),
        led_by(Cause::Merge, Phase::Sampling, 3, merged(3)),
    ] {
        session.absorb(event);
    }
    session.absorb(Event::Activity(Activity::Idle));
    session
}

#[test]
fn every_state_of_a_branch_has_a_name_of_its_own() {
    let session = worked_on();
    let branch = session.timeline.current().expect("a branch");
    let names: Vec<String> = (0..branch.states.len()).map(|i| branch.name_of(i).to_string()).collect();
    assert_eq!(
        names,
        [
            "Iteration 0",
            "Iteration 1",
            "Iteration 2",
            "Iteration 2 · refined",
            "Iteration 2 · merge",
            "Iteration 2 · merge 2",
            "Iteration 2 · edit: deleted 7",
            "Iteration 2 · edit 2: deleted 1, 2, 3 …",
            "Iteration 2 · refined 2",
            "Iteration 2 · edit 3: unpinned points",
            "Iteration 3",
            "Iteration 3 · merge",
        ]
    );
    let short: BTreeSet<String> = (0..branch.states.len()).map(|i| branch.name_of(i).short()).collect();
    assert_eq!(short.len(), names.len(), "also where there is little room");
    assert!(short.contains("2 · edit 2"));
    assert_eq!(session.timeline.shown_name().to_string(), "Iteration 3 · merge");
}

#[test]
fn a_baseline_counts_steps_and_an_unrefined_run_is_finished() {
    let named = |change: &dyn Fn(&mut Snapshot)| {
        let Event::Snapshot(state) = led_by(Cause::Step, Phase::Finished, 4, vec![]) else { unreachable!() };
        let mut state = (*state).clone();
        change(&mut state);
        StateName::of(&[Arc::new(state)], 0).to_string()
    };
    assert_eq!(named(&|_| {}), "Iteration 4 · refined");
    assert_eq!(named(&|state| state.params.refine = false), "Iteration 4 · finished");
    assert_eq!(named(&|state| state.start = Method::KMeans.params()), "Step 4");
    assert_eq!(StateName::of(&[], 3).to_string(), "Iteration 0");
}

#[test]
fn messages_name_the_state_that_the_log_line_is_about() {
    let session = worked_on();
    let lines: Vec<&str> = session.messages.iter().map(|m| m.what.as_str()).collect();
    for line in ["Iteration 2 · merge 2: 1 and 3 merged into 3", "Iteration 2 · edit: 7 deleted (3 points)"]
    {
        assert!(lines.contains(&line), "{lines:?}");
    }
}

#[test]
fn no_two_branches_have_the_same_name() {
    let mut session = worked_on();
    session.apply(Action::ShowState(1));
    session.apply(Action::Verb(Verb::ContinueHere));
    session.absorb(Event::Activity(Activity::Idle));
    let names = |session: &Session| -> Vec<String> {
        session.timeline.branches().iter().map(|b| b.name.clone()).collect()
    };
    assert_eq!(names(&session), ["Main", "Branch 1"]);
    session.apply(Action::RenameBranch(1, " Main ".to_owned()));
    assert_eq!(names(&session), ["Main", "Main (2)"]);
    session.apply(Action::RenameBranch(1, "Main (2)".to_owned()));
    assert_eq!(names(&session), ["Main", "Main (2)"], "it keeps its own");
    session.apply(Action::RenameBranch(0, "Branch 2".to_owned()));
    session.apply(Action::ShowState(0));
    session.apply(Action::Verb(Verb::ContinueHere));
    assert_eq!(names(&session), ["Branch 2", "Main (2)", "Branch 2 (2)"]);
}
