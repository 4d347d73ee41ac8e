//! Playing the timeline, comparing states, and estimating them in the
//! background.

use super::*;
use crate::session::comparison::Comparison;
use crate::session::curves::Curve;

/// A finished run of 11 states.
fn finished() -> Session {
    let mut session = session();
    for iteration in 1..=10 {
        let phase = if iteration == 10 { Phase::Finished } else { Phase::Sampling };
        session.absorb(snapshot(&[1, 2, 3], phase, iteration, vec![]));
    }
    session.absorb(Event::Activity(Activity::Idle));
    session
}

fn index(session: &Session) -> usize {
    session.timeline.shown_index()
}

#[test]
fn playing_passes_every_state_in_time_and_stops_at_the_end() {
    let mut session = finished();
    session.apply(Action::SetPlaySpeed(4));
    session.apply(Action::Verb(Verb::Play));
    assert!(session.playback.is_playing);
    assert_eq!(index(&session), 0, "from the end it begins anew");
    let mut seen = vec![0];
    for _ in 0..19 {
        let effects = session.apply(Action::PlayOn(0.125));
        assert!(effects.is_empty(), "what is passed by is not measured");
        if seen.last() != Some(&index(&session)) {
            seen.push(index(&session));
        }
    }
    assert_eq!(seen, (0..=9).collect::<Vec<_>>(), "2.4 seconds are nine states and a half");
    let effects = session.apply(Action::PlayOn(0.125));
    assert!(!session.playback.is_playing && session.timeline.is_at_end());
    assert!(matches!(effects[..], [Effect::Send(Command::Measure(_))]), "where it stays is");
    assert!(session.apply(Action::PlayOn(1.0)).is_empty());
}

#[test]
fn a_loop_shows_the_last_state_and_goes_round() {
    let mut session = finished();
    session.apply(Action::Verb(Verb::ToggleLoop));
    session.apply(Action::SetPlaySpeed(1));
    session.apply(Action::ShowState(8));
    session.apply(Action::Verb(Verb::Play));
    let mut seen = Vec::new();
    for _ in 0..4 {
        session.apply(Action::PlayOn(1.0));
        seen.push(index(&session));
    }
    assert_eq!(seen, [9, 10, 0, 1]);
    assert!(session.playback.is_playing);
}

#[test]
fn a_hand_on_the_playhead_stops_it() {
    let mut session = finished();
    for action in [Action::ShowState(3), Action::Verb(Verb::PreviousState), Action::Verb(Verb::StopPlaying)] {
        session.apply(Action::ShowState(5));
        session.apply(Action::Verb(Verb::Play));
        session.apply(action.clone());
        assert!(!session.playback.is_playing, "{action:?}");
    }
    session.apply(Action::Verb(Verb::Play));
    session.apply(Action::Verb(Verb::Run));
    assert!(!session.playback.is_playing, "work that was asked for is looked at");
}

#[test]
fn states_are_estimated_once_while_nothing_else_is_to_be_done() {
    let mut session = finished();
    let asked = |effects: Vec<Effect>| match &effects[..] {
        [] => None,
        [Effect::Send(Command::Estimate(states))] => {
            Some(states.iter().map(|s| s.snapshot.abstraction.iteration).collect::<Vec<_>>())
        }
        other => panic!("{other:?}"),
    };
    let first = asked(session.background()).expect("states");
    assert_eq!((first.len(), &first[..2]), (11, &[10, 0][..]), "the ends come first");
    assert_eq!(asked(session.background()), None, "once");
    let key = session.timeline.states()[4].key;
    session.absorb(Event::Estimated { key, chamfer_l1: Some(0.02) });
    let state = Arc::clone(&session.timeline.states()[4]);
    assert_eq!(session.value_of(Curve::Chamfer, &state), Some(0.02));
    assert!(session.chamfer_of(key).is_some_and(|c| c.is_rough));
    // A run takes the core, and what is missing is asked for after it.
    session.apply(Action::Verb(Verb::Run));
    assert_eq!(asked(session.background()), Some(vec![]));
    session.absorb(Event::Activity(Activity::Running));
    assert_eq!(asked(session.background()), None);
    session.absorb(Event::Activity(Activity::Idle));
    let again = asked(session.background()).expect("states");
    assert!(again.len() == 10 && !again.contains(&4), "{again:?}");
    // Whoever doesn't look needs none.
    session.apply(Action::SetCurve(Curve::Chamfer, false));
    assert_eq!(asked(session.background()), Some(vec![]));
    session.absorb(Event::Loaded(loaded()));
    assert!(session.chamfer_of(key).is_none(), "another shape has other figures");
}

#[test]
fn of_many_states_some_are_estimated_evenly() {
    let mut session = finished();
    for iteration in 11..1000 {
        session.absorb(snapshot(&[1, 2, 3], Phase::Sampling, iteration, vec![]));
    }
    let effects = session.background();
    let [Effect::Send(Command::Estimate(states))] = &effects[..] else { panic!("{effects:?}") };
    let mut chosen: Vec<u32> = states.iter().map(|s| s.snapshot.abstraction.iteration).collect();
    chosen.sort_unstable();
    assert!((150..=200).contains(&chosen.len()), "{}", chosen.len());
    assert_eq!(chosen.last(), Some(&999));
    let gaps: BTreeSet<u32> = chosen.windows(2).map(|w| w[1] - w[0]).collect();
    assert_eq!(gaps.len(), 1, "{gaps:?}");
}

#[test]
fn another_state_is_shown_beside() {
    let mut session = finished();
    assert!(session.compared().is_none());
    let main = session.timeline.current().expect("a branch").id;
    let effects = session.apply(Action::Compare(Some(Comparison::with(main, Some(2)))));
    assert!(matches!(effects[..], [Effect::Send(Command::Measure(_))]), "its figures are wanted");
    let other = session.compared().expect("a state");
    assert_eq!((other.index, other.same_samples), (2, true));
    // Linked, then each on its own.
    let both = session.camera;
    session.apply(Action::Orbit { right: 0.4, up: 0.0 });
    let apart = Comparison { is_linked: false, ..Comparison::with(main, None) };
    session.apply(Action::Compare(Some(apart)));
    assert_eq!(session.other_camera, session.camera, "they part where they are");
    session.apply(Action::InOther(Box::new(Action::Orbit { right: 0.4, up: 0.0 })));
    assert_ne!(session.other_camera, session.camera);
    assert_ne!(session.camera, both);
    assert_eq!(session.compared().expect("a state").index, 10, "the last there is");
    session.absorb(snapshot(&[1], Phase::Finished, 11, vec![]));
    assert_eq!(session.compared().expect("a state").index, 11);
    session.apply(Action::Compare(Some(Comparison::with(77, None))));
    assert!(session.compared().is_none(), "a removed branch");
}

#[test]
fn several_steps_are_undone_at_once() {
    let mut session = finished();
    for id in [1, 2, 3] {
        session.apply(Action::Select(Some(id)));
    }
    session.apply(Action::GoBack(2));
    assert_eq!(session.selection, [1].into());
    session.apply(Action::GoOn(1));
    assert_eq!(session.selection, [2].into());
    session.apply(Action::GoBack(99));
    assert!(session.selection.is_empty() && !session.is_enabled(Verb::Undo));
    session.apply(Action::GoOn(3));
    assert_eq!(session.selection, [3].into());
}
