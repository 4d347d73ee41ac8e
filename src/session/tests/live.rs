//! Live, as the session sees it.

use super::*;
use crate::worker::{LiveResult, Setup};

fn live() -> Session {
    let mut session = session();
    session.absorb(snapshot(&[1, 2, 3], Phase::Finished, 30, vec![]));
    session.apply(Action::Verb(Verb::ToggleLive));
    session
}

fn turn(session: &mut Session, alpha: f64) -> Vec<Effect> {
    session.apply(Action::SetParams(Params { alpha, ..session.params }))
}

/// The renewal that an action led to, and whether it is to be made at once.
fn renewal(effects: &[Effect]) -> Option<(Setup, bool)> {
    match effects {
        [Effect::Send(Command::Renew { setup, at_once })] => Some((*setup, *at_once)),
        _ => None,
    }
}

/// A result of run 2 with these labels.
fn renewed(session: &Session, labels: [u32; 9]) -> Event {
    let ids: BTreeSet<u32> = labels.into_iter().collect();
    let ids: Vec<u32> = ids.into_iter().collect();
    let state = |phase, iteration| {
        let Event::Snapshot(state) = snapshot(&ids, phase, iteration, vec![]) else { unreachable!() };
        let mut state =
            Snapshot { run: 2, params: session.params, start: session.params, ..(*state).clone() };
        state.key = Snapshot::new_key();
        state.abstraction.labels = labels.into();
        Arc::new(state)
    };
    Event::LiveFinished(Arc::new(LiveResult {
        setup: Setup { params: session.params, sampling: session.sampling },
        loaded: Arc::clone(session.loaded.as_ref().expect("a shape")),
        states: vec![state(Phase::Start, 0), state(Phase::Sampling, 1), state(Phase::Finished, 2)],
    }))
}

#[test]
fn a_change_makes_the_run_anew_and_moves_nothing_else() {
    let mut session = live();
    let before = session.snapshot.clone().expect("a state");
    // All but that the change can be undone.
    let others = || Verb::ALL.iter().filter(|verb| **verb != Verb::Undo);
    let buttons = |s: &Session| others().map(|v| s.is_enabled(*v)).collect::<Vec<_>>();
    let idle = buttons(&session);
    let effects = turn(&mut session, 3.0);
    let expected = Setup { params: Params { alpha: 3.0, ..Params::default() }, sampling: session.sampling };
    assert_eq!(renewal(&effects), Some((expected, false)));
    assert_eq!(session.activity, Activity::LiveRun);
    session.absorb(Event::LiveStarted(expected));
    assert_eq!(buttons(&session), idle, "no button blinks");
    assert!(Arc::ptr_eq(session.snapshot.as_ref().expect("a state"), &before));
    let camera = session.camera;
    let result = renewed(&session, [0; 9]);
    session.absorb(result);
    assert_eq!(session.phase(), Some(Phase::Finished));
    assert_eq!(session.timeline.states().len(), 3, "the history is that of the new run");
    assert_eq!(session.camera, camera);
    session.absorb(Event::Activity(Activity::Idle));
    assert!(!session.live.is_renewing());
}

#[test]
fn only_what_the_method_reads_makes_another_run() {
    let mut session = live();
    session.apply(Action::SetMethod(Method::Ems));
    session.absorb(Event::Activity(Activity::Idle));
    let effects = session.apply(Action::SetParams(Params { alpha: 9.0, clusters: 4, ..session.params }));
    assert!(matches!(effects[..], [Effect::Send(Command::SetParams(_))]), "{effects:?}");
    let effects = session.apply(Action::SetParams(Params { outlier_prior: 0.2, ..session.params }));
    assert!(renewal(&effects).is_some());
    let sampling = SamplingOptions { seed: 9, ..session.sampling };
    let effects = session.apply(Action::SetSampling(sampling));
    assert_eq!(renewal(&effects).map(|(setup, _)| setup.sampling), Some(sampling));
    assert!(session.apply(Action::SetSampling(sampling)).is_empty(), "nothing has changed");
}

#[test]
fn a_resting_hand_hurries_only_what_is_stale() {
    let mut session = live();
    turn(&mut session, 3.0);
    assert!(!session.awaits_newer_run());
    assert!(session.apply(Action::HandRests).is_empty(), "the run under way is the one that is wanted");
    turn(&mut session, 4.0);
    assert!(session.awaits_newer_run());
    let effects = session.apply(Action::HandRests);
    assert_eq!(renewal(&effects).map(|(setup, at_once)| (setup.params.alpha, at_once)), Some((4.0, true)));
    assert!(session.apply(Action::HandRests).is_empty(), "once is enough");
    session.absorb(Event::Activity(Activity::Idle));
    assert!(session.apply(Action::HandRests).is_empty());
}

#[test]
fn a_watched_run_is_interrupted() {
    let mut session = live();
    session.apply(Action::Verb(Verb::Run));
    session.absorb(Event::Activity(Activity::Running));
    assert_eq!(renewal(&turn(&mut session, 3.0)).map(|(_, at_once)| at_once), Some(true));
    // A renewal that is told as running, since it takes long, is none.
    session.absorb(Event::Activity(Activity::Running));
    assert_eq!(renewal(&turn(&mut session, 4.0)).map(|(_, at_once)| at_once), Some(false));
    assert!(session.is_enabled(Verb::Pause));
}

#[test]
fn a_change_that_comes_too_early_is_made_up_for() {
    let mut session = live();
    session.apply(Action::OpenFile("next.ply".into()));
    let effects = turn(&mut session, 3.0);
    assert!(matches!(effects[..], [Effect::Send(Command::SetParams(_))]), "it does not stop the reading");
    session.absorb(Event::Loaded(loaded()));
    let effects = session.absorb(Event::Activity(Activity::Idle));
    assert_eq!(renewal(&effects).map(|(setup, _)| setup.params.alpha), Some(3.0));
    assert!(session.absorb(Event::Activity(Activity::Idle)).is_empty(), "once is enough");
}

#[test]
fn switching_live_makes_up_for_what_was_changed() {
    let mut session = live();
    assert!(session.apply(Action::Verb(Verb::ToggleLive)).is_empty());
    assert!(matches!(turn(&mut session, 3.0)[..], [Effect::Send(Command::SetParams(_))]));
    let effects = session.apply(Action::Verb(Verb::ToggleLive));
    assert_eq!(renewal(&effects).map(|(setup, _)| setup.params.alpha), Some(3.0));
    let result = renewed(&session, [0; 9]);
    session.absorb(result);
    session.absorb(Event::Activity(Activity::Idle));
    session.apply(Action::Verb(Verb::ToggleLive));
    assert!(session.apply(Action::Verb(Verb::ToggleLive)).is_empty(), "the result is that of the sliders");
}

#[test]
fn the_selection_goes_with_the_points() {
    let mut session = live();
    let result = renewed(&session, [1, 1, 1, 2, 2, 2, 3, 3, 3]);
    session.absorb(result);
    session.apply(Action::Select(Some(1)));
    session.apply(Action::ToggleSelected(2));
    session.apply(Action::SetPrimitiveVisible(3, false));
    // 1 is now 8, 2 has joined 8, 3 is now 1.
    let result = renewed(&session, [8, 8, 8, 8, 8, 1, 1, 1, 1]);
    session.absorb(result);
    assert_eq!((&session.selection, &session.hidden), (&[8].into(), &[1].into()));
    // 1 is swallowed by what is not hidden: that stays in sight.
    let result = renewed(&session, [4; 9]);
    session.absorb(result);
    assert_eq!((&session.selection, &session.hidden), (&[4].into(), &[].into()));
}
