//! Going back and on, branches, undo.

use super::*;
use crate::inference::Edit;

/// A session with a finished run of four iterations.
fn run() -> Session {
    let mut session = session();
    session.apply(Action::Verb(Verb::Run));
    for i in 1..=4 {
        let phase = if i == 4 { Phase::Finished } else { Phase::Sampling };
        session.absorb(snapshot(&[1, 2, 3], phase, i, vec![]));
    }
    session.absorb(Event::Activity(Activity::Idle));
    session
}

fn iterations(session: &Session) -> Vec<u32> {
    session.timeline.states().iter().map(|s| s.abstraction.iteration).collect()
}

fn edited(ids: &[u32], iteration: u32) -> Event {
    let Event::Snapshot(state) = snapshot(ids, Phase::Finished, iteration, vec![]) else { unreachable!() };
    Event::Snapshot(Arc::new(Snapshot { cause: Cause::Edit, ..(*state).clone() }))
}

fn resumes_at(effects: &[Effect]) -> Option<u32> {
    effects.iter().find_map(|effect| match effect {
        Effect::Send(Command::Resume(state)) => Some(state.snapshot.abstraction.iteration),
        _ => None,
    })
}

#[test]
fn going_on_from_an_earlier_state_is_a_branch() {
    let mut session = run();
    session.apply(Action::ShowState(2));
    assert_eq!(session.snapshot.as_ref().map(|s| s.abstraction.iteration), Some(2));
    assert!(session.is_enabled(Verb::NextState) && session.is_enabled(Verb::ContinueHere));
    let effects = session.apply(Action::Verb(Verb::StepIteration));
    assert_eq!(resumes_at(&effects), Some(2));
    assert!(matches!(effects.last(), Some(Effect::Send(Command::StepIteration))));
    session.absorb(snapshot(&[1, 2], Phase::Sampling, 3, vec![]));
    session.absorb(Event::Activity(Activity::Idle));
    assert_eq!(iterations(&session), [0, 1, 2, 3]);
    let branch = session.timeline.current().expect("a branch");
    assert_eq!(branch.origin, Some(timeline::Origin { branch: 0, index: 2 }));
    let main = session.timeline.branch(0).expect("the first one");
    assert_eq!(main.states.len(), 5, "the later states stay in theirs");
    assert!(Arc::ptr_eq(&main.states[2], &branch.states[2]), "what both have is shared");
    // The worker is there now: the next step is no other branch.
    assert_eq!(resumes_at(&session.apply(Action::Verb(Verb::StepIteration))), None);
    assert_eq!(session.timeline.branches().len(), 2);
}

#[test]
fn looking_back_is_left_in_peace_by_a_run_that_goes_on() {
    let mut session = run();
    session.activity = Activity::Running;
    session.apply(Action::ShowState(1));
    session.absorb(snapshot(&[1], Phase::Finished, 5, vec![]));
    assert_eq!(session.snapshot.as_ref().map(|s| s.abstraction.iteration), Some(1));
    assert_eq!(iterations(&session).last(), Some(&5));
    session.apply(Action::Verb(Verb::LastState));
    session.absorb(snapshot(&[1], Phase::Finished, 6, vec![]));
    assert_eq!(session.snapshot.as_ref().map(|s| s.abstraction.iteration), Some(6), "it follows again");
}

#[test]
fn work_by_hand_is_never_run_over() {
    let mut session = run();
    session.apply(Action::Edit(Edit::Delete { ids: vec![3] }));
    session.absorb(edited(&[1, 2], 4));
    session.absorb(snapshot(&[1, 2, 3, 4], Phase::Start, 0, vec![]));
    assert_eq!(session.timeline.branches().len(), 2, "the reset has a branch of its own");
    assert_eq!(session.timeline.branch(0).map(|b| b.states.len()), Some(6));
    session.absorb(snapshot(&[1, 2, 3, 4], Phase::Start, 0, vec![]));
    assert_eq!(session.timeline.branches().len(), 2, "but the next takes the place of that");
}

#[test]
fn everything_is_undone_and_done_again() {
    let mut session = session();
    let mut documents = vec![session.document()];
    let mut then = |session: &mut Session| documents.push(session.document());
    session.apply(Action::SetParams(Params { alpha: 3.0, ..session.params }));
    session.apply(Action::SetParams(Params { alpha: 4.0, ..session.params }));
    session.apply(Action::EndGesture);
    then(&mut session);
    session.apply(Action::Verb(Verb::Run));
    session.absorb(snapshot(&[1, 2, 3], Phase::Finished, 1, vec![]));
    session.absorb(Event::Activity(Activity::Idle));
    then(&mut session);
    session.apply(Action::Select(Some(2)));
    then(&mut session);
    session.apply(Action::SetPrimitiveVisible(1, false));
    then(&mut session);
    session.apply(Action::Edit(Edit::Delete { ids: vec![3] }));
    session.absorb(edited(&[1, 2], 1));
    then(&mut session);
    let other = LoadedShape {
        generation: 7,
        shape: Arc::new((*loaded().shape).clone()),
        cloud: Arc::clone(&loaded().cloud),
        sampling: session.sampling,
    };
    session.apply(Action::OpenFile("other.obj".into()));
    session.absorb(Event::Loaded(Arc::new(other)));
    session.absorb(snapshot(&[5], Phase::Start, 0, vec![]));
    session.absorb(Event::Activity(Activity::Idle));
    then(&mut session);
    let last = documents.len() - 1;
    for expected in documents[..last].iter().rev() {
        session.apply(Action::Verb(Verb::Undo));
        assert_eq!(&session.document(), expected);
        assert_eq!(session.snapshot.as_ref().map(|s| s.key), session.timeline.shown().map(|s| s.key));
    }
    assert!(!session.is_enabled(Verb::Undo), "a drag is one step");
    for expected in &documents[1..] {
        session.apply(Action::Verb(Verb::Redo));
        assert_eq!(&session.document(), expected);
    }
    assert!(!session.is_enabled(Verb::Redo));
    session.apply(Action::Verb(Verb::Undo));
    session.apply(Action::Verb(Verb::Deselect));
    assert!(!session.is_enabled(Verb::Redo), "what is done now takes the place of what was undone");
}

#[test]
fn undo_stops_what_is_going_on() {
    let mut session = run();
    session.apply(Action::Verb(Verb::Reset));
    session.absorb(snapshot(&[1], Phase::Start, 0, vec![]));
    session.absorb(Event::Activity(Activity::Idle));
    session.apply(Action::Verb(Verb::Run));
    session.absorb(snapshot(&[1], Phase::Sampling, 1, vec![]));
    let effects = session.apply(Action::Verb(Verb::Undo));
    assert_eq!(resumes_at(&effects), Some(0), "its late states are not heard of again");
    assert_eq!((iterations(&session), session.activity), (vec![0], Activity::Idle));
    session.apply(Action::Verb(Verb::Undo));
    assert_eq!(iterations(&session), [0, 1, 2, 3, 4]);
    // The worker follows when there is something to do.
    let effects = session.apply(Action::Edit(Edit::Delete { ids: vec![1] }));
    assert_eq!(resumes_at(&effects), Some(4));
}

#[test]
fn a_proposal_is_for_the_state_that_is_shown() {
    let mut session = run();
    let effects = session.apply(Action::Verb(Verb::StepMerge));
    assert!(matches!(effects[..], [Effect::Send(Command::ProposeMerge { of: None, .. })]));
    session.absorb(Event::Proposed(None));
    assert!(session.proposal.is_none() && session.merge_text.is_some());
    assert!(!session.is_enabled(Verb::AcceptMerge) && !session.is_enabled(Verb::SkipMerge));
}

#[test]
fn branches_are_named_switched_and_removed() {
    let mut session = run();
    session.apply(Action::ShowState(1));
    session.apply(Action::Verb(Verb::ContinueHere));
    assert_eq!(session.timeline.current().map(|b| b.id), Some(1));
    session.apply(Action::RenameBranch(1, "  thin legs ".to_owned()));
    session.apply(Action::RenameBranch(1, " ".to_owned()));
    assert_eq!(session.timeline.current().map(|b| b.name.as_str()), Some("thin legs"));
    session.apply(Action::SwitchBranch(0));
    assert_eq!(session.snapshot.as_ref().map(|s| s.abstraction.iteration), Some(4));
    session.apply(Action::RemoveBranch(0));
    assert_eq!(session.timeline.branches().len(), 1);
    assert_eq!(session.snapshot.as_ref().map(|s| s.abstraction.iteration), Some(1));
    session.apply(Action::RemoveBranch(1));
    assert_eq!(session.timeline.branches().len(), 1, "one always stays");
    session.apply(Action::Verb(Verb::Undo));
    assert_eq!(session.timeline.branches().len(), 2);
}
