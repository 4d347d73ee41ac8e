use std::path::PathBuf;
use std::time::Duration;

use nalgebra::Point3;

use super::saving::KeepingEvent;
use super::workspace::Workspace;
use super::*;
use crate::geometry::{SampleCloud, Superquadric};
use crate::inference::Checkpoint;
use crate::inference::{Abstraction, Figures, MergeReason, MergeReport, Method, Occurrence, Sighting};
use crate::io::{Attributes, Format, PointCloud, Shape, ShapeGeometry};
use crate::worker::{Cause, Event, Helper};

mod editing;
mod in_logs;
mod live;
mod naming;
mod playback;

fn loaded() -> Arc<LoadedShape> {
    let points: Vec<_> = (0..9).map(|i| Point3::new(f64::from(i), f64::from(i % 3), 0.5)).collect();
    let cloud = Arc::new(SampleCloud::from_points(&points));
    let geometry = ShapeGeometry::Cloud(PointCloud { points });
    let (name, attributes) = ("nine".to_owned(), Attributes::default());
    let shape = Arc::new(Shape {
        name,
        path: None,
        content: None,
        geometry,
        attributes,
        viewpoints: Vec::new(),
        notes: Vec::new(),
    });
    Arc::new(LoadedShape { generation: 1, shape, cloud, sampling: SamplingOptions::default() })
}

fn snapshot(ids: &[u32], phase: Phase, iteration: u32, occurrences: Vec<Occurrence>) -> Event {
    let primitives = ids
        .iter()
        .map(|&id| Primitive {
            id,
            shape: Superquadric::sphere(Point3::new(f64::from(id), 0.0, 0.5), 0.4),
            sigma: 0.1,
            points: 3,
            mean_distance: 0.01,
            locked: false,
        })
        .collect();
    let abstraction = Abstraction {
        phase,
        iteration,
        labels: vec![0; 9].into(),
        pinned: [].into(),
        primitives,
        figures: Figures { clusters: ids.len(), ..Figures::default() },
        sighting: Sighting::default(),
    };
    let params = Params::default();
    let elapsed = Duration::ZERO;
    let checkpoint = Arc::new(Checkpoint {
        params,
        phase,
        iteration,
        clusters: Vec::new(),
        labels: Vec::new(),
        frozen: Vec::new(),
        pinned: Vec::new(),
        next_id: 0,
        next_revision: 0,
        work: crate::inference::runs::checkpoint::Remaining::Sampler,
    });
    Event::Snapshot(Arc::new(Snapshot {
        key: Snapshot::new_key(),
        generation: 1,
        run: 1,
        abstraction,
        checkpoint,
        cause: if phase == Phase::Start { Cause::Start } else { Cause::Step },
        params,
        start: params,
        occurrences,
        elapsed,
    }))
}

fn session() -> Session {
    let mut session = Session::new(Params::default(), SamplingOptions::default());
    session.absorb(Event::Loaded(loaded()));
    session.absorb(snapshot(&[1, 2, 3], Phase::Start, 0, vec![]));
    session.absorb(Event::Activity(Activity::Idle));
    // What Live adds is tested by itself.
    session.live.is_on = false;
    session
}

fn merged(a: u32, b: u32) -> MergeReport {
    MergeReport { merged: (a, b), into: b, reason: MergeReason::Energy { gain: 0.25 } }
}

#[test]
fn no_two_enabled_verbs_share_a_shortcut() {
    let mut states = vec![Session::new(Params::default(), SamplingOptions::default()), session()];
    for activity in
        [Activity::Loading, Activity::Running, Activity::Merging, Activity::LiveRun, Activity::Writing]
    {
        let mut busy = session();
        busy.selection.insert(1);
        busy.activity = activity;
        states.push(busy);
    }
    for state in &states {
        let mut taken = std::collections::HashMap::new();
        for &verb in Verb::ALL.iter().filter(|&&v| state.is_enabled(v)) {
            if let Some(shortcut) = verb.entry().shortcut
                && let Some(other) = taken.insert(shortcut, verb)
            {
                panic!("{shortcut} means both {verb:?} and {other:?} while {:?}", state.activity);
            }
        }
    }
}

#[test]
fn a_shape_is_run_as_soon_as_it_is_there() {
    let mut session = Session::new(Params::default(), SamplingOptions::default());
    let commands = session.begin(Source::BuiltIn);
    assert!(matches!(commands.last(), Some(Command::Load { .. })));
    assert!(!session.is_enabled(Verb::Run), "while it loads");
    assert!(session.absorb(Event::Loaded(loaded())).is_empty());
    let effects = session.absorb(Event::Activity(Activity::Idle));
    assert!(matches!(effects[..], [Effect::Send(Command::Run)]));
    assert_eq!(session.activity, Activity::Running, "there is no rest between the two");
    // Sampling anew doesn't run by itself, and leaves the camera alone.
    session.camera.orbit(1.0, 0.2);
    let camera = session.camera;
    let again = Arc::new(LoadedShape {
        generation: 2,
        shape: Arc::clone(&session.loaded.as_ref().expect("a shape").shape),
        cloud: Arc::clone(&session.loaded.as_ref().expect("a shape").cloud),
        sampling: SamplingOptions { points: 5, seed: 2, ..SamplingOptions::default() },
    });
    session.absorb(Event::Loaded(again));
    assert!(session.absorb(Event::Activity(Activity::Idle)).is_empty());
    assert_eq!(session.camera, camera);
}

#[test]
fn a_failed_load_keeps_everything_and_says_so() {
    let mut session = session();
    session.apply(Action::OpenFile(PathBuf::from("bad.obj")));
    session.absorb(Event::Activity(Activity::Loading));
    session.absorb(Event::Failed { what: "bad.obj could not be opened".into(), error: "no vertices".into() });
    session.absorb(Event::Activity(Activity::Idle));
    assert_eq!(session.primitives().len(), 3);
    assert!(session.messages.open_error().is_some_and(|m| m.what.contains("bad.obj")));
    // What failed to load is not run when the next thing arrives.
    session.absorb(Event::Loaded(loaded()));
    assert!(session.absorb(Event::Activity(Activity::Idle)).is_empty());
    assert!(session.messages.open_error().is_none(), "a shape that loads closes the error box");
}

#[test]
fn buttons_are_enabled_only_when_they_do_something() {
    let empty = Session::new(Params::default(), SamplingOptions::default());
    for verb in [Verb::Run, Verb::Pause, Verb::StepIteration, Verb::StepMerge, Verb::Reset, Verb::Export] {
        assert!(!empty.is_enabled(verb), "{verb:?} with nothing loaded");
    }
    let mut session = session();
    assert!(session.is_enabled(Verb::Run) && session.is_enabled(Verb::StepMerge));
    assert!(!session.is_enabled(Verb::Pause) && !session.is_enabled(Verb::Reset), "nothing has been done");
    session.apply(Action::Verb(Verb::Run));
    assert!(session.is_enabled(Verb::Pause) && !session.is_enabled(Verb::Run));
    session.absorb(snapshot(&[1, 2], Phase::Finished, 30, vec![]));
    session.absorb(Event::Activity(Activity::Idle));
    assert!(session.is_enabled(Verb::Reset) && !session.is_enabled(Verb::StepIteration));
    // A disabled verb does nothing, however it is asked for.
    assert!(session.apply(Action::Verb(Verb::StepIteration)).is_empty());
    session.absorb(Event::MergeStep(None));
    assert!(!session.is_enabled(Verb::MergeAll), "none is left");
    assert!(session.is_enabled(Verb::StepMerge), "those that the rule refuses can still be looked at");
    session.apply(Action::SetParams(Params::paper()));
    assert!(session.is_enabled(Verb::MergeAll), "another rule may find a pair");
}

#[test]
fn the_selection_follows_a_merge_and_forgets_the_dead() {
    let mut session = session();
    session.apply(Action::Select(Some(1)));
    session.apply(Action::ToggleSelected(3));
    session.apply(Action::SetPrimitiveVisible(3, false));
    session.absorb(snapshot(&[2], Phase::Merging, 30, vec![Occurrence::Merged(merged(1, 2))]));
    assert_eq!(session.selection, [2].into());
    assert!(session.hidden.is_empty());
    assert_eq!(session.selected_primitive().map(|p| p.id), Some(2));
    session.absorb(Event::MergeStep(Some(merged(1, 2))));
    assert!(session.merge_text.is_some_and(|text| text.starts_with("Merged 1 into 2. Merging lowers")));
}

#[test]
fn the_history_holds_all_states_of_one_run() {
    let mut session = session();
    for i in 1..=4 {
        session.absorb(snapshot(&[1], Phase::Sampling, i, vec![]));
    }
    assert_eq!(session.timeline.states().len(), 5);
    let Event::Snapshot(first) = snapshot(&[1, 2], Phase::Start, 0, vec![]) else { unreachable!() };
    session.absorb(Event::Snapshot(Arc::new(Snapshot { run: 2, ..(*first).clone() })));
    assert_eq!(session.timeline.states().len(), 1, "a reset starts a new history");
}

#[test]
fn clusters_and_seed_wait_for_the_next_start() {
    let mut session = session();
    assert!(session.stale_start().is_none());
    session.apply(Action::SetParams(Params { alpha: 3.0, ..session.params }));
    assert!(session.stale_start().is_none(), "α is taken at once");
    session.apply(Action::SetParams(Params { clusters: 7, ..session.params }));
    assert_eq!(session.stale_start().map(|p| p.clusters), Some(30));
    assert!(session.is_enabled(Verb::Reset), "a reset would take it");
}

#[test]
fn a_method_waits_for_the_next_start_and_keeps_the_seed() {
    let mut session = session();
    session.apply(Action::SetParams(Params { seed: 5, ..session.params }));
    session.absorb(started(5, Params { seed: 5, ..Params::default() }));
    let effects = session.apply(Action::SetMethod(Method::KMeans));
    let expected = Params { seed: 5, ..Method::KMeans.params() };
    assert_eq!(session.params, expected);
    assert!(matches!(effects[..], [Effect::Send(Command::SetParams(params))] if params == expected));
    assert!(session.stale_start().is_some() && session.is_enabled(Verb::StepMerge));
    // The run of a baseline has nothing to merge by, and says why.
    session.absorb(started(6, expected));
    assert!(session.stale_start().is_none());
    assert!(!session.is_enabled(Verb::StepMerge) && !session.is_enabled(Verb::MergeAll));
    assert!(session.why_disabled(Verb::StepMerge).is_some_and(|why| why.contains("sampler")));
    assert!(session.why_disabled(Verb::Pause).is_none());
    // EMS has neither K nor a seed that it could wait for.
    session.absorb(started(7, Params { seed: 5, ..Method::Ems.params() }));
    session.apply(Action::SetParams(Params { seed: 6, clusters: 3, ..Method::Ems.params() }));
    assert!(session.stale_start().is_none());
}

/// The first state of another run.
fn started(run: u64, start: Params) -> Event {
    let Event::Snapshot(first) = snapshot(&[1, 2], Phase::Start, 0, vec![]) else { unreachable!() };
    Event::Snapshot(Arc::new(Snapshot { run, start, params: start, ..(*first).clone() }))
}

#[test]
fn an_error_goes_when_the_same_thing_succeeds() {
    let failed = || Event::Failed { what: "it failed".into(), error: "for a reason".into() };
    let mut session = session();
    session.absorb(failed());
    // The run that a failed load has interrupted goes on.
    session.absorb(snapshot(&[1], Phase::Sampling, 1, vec![]));
    assert!(session.messages.open_error().is_some());
    session.absorb(Event::Written { path: "out.ply".into(), format: Format::CloudPly, notes: vec![] });
    assert!(session.messages.open_error().is_none());
    // A step that was asked for after it, and made.
    session.absorb(failed());
    session.absorb(Event::Activity(Activity::Idle));
    session.apply(Action::Verb(Verb::StepIteration));
    assert!(session.messages.open_error().is_some(), "it has not been made yet");
    session.absorb(snapshot(&[1], Phase::Sampling, 2, vec![Occurrence::Died { id: 2 }]));
    assert!(session.messages.open_error().is_none());
    session.absorb(failed());
    session.apply(Action::Note("Wrote the screenshot".into()));
    assert!(session.messages.open_error().is_none());
    session.absorb(failed());
    session.absorb(started(8, Params::default()));
    assert!(session.messages.open_error().is_none());
}

#[test]
fn work_goes_on_where_the_thread_that_computes_has_ended() {
    let mut session = session();
    session.apply(Action::Verb(Verb::Run));
    session.absorb(snapshot(&[1, 2], Phase::Sampling, 1, vec![]));
    let Event::Snapshot(state) = snapshot(&[1], Phase::Sampling, 2, vec![]) else { unreachable!() };
    session.absorb(Event::Snapshot(Arc::clone(&state)));
    session.absorb(Event::Measuring(Arc::clone(&state)));
    let effects = session.absorb(Event::Ended { who: Helper::Sampler, error: "it panicked".into() });
    assert!(
        matches!(effects[..], [Effect::Send(Command::SetParams(p)), Effect::Send(Command::SetPace(_))] if p == session.params)
    );
    let error = session.messages.open_error().expect("the window says so");
    assert!(error.what.contains("internal error") && error.why == "it panicked", "{error:?}");
    assert!(error.advice.contains("All states and settings are kept"), "{error:?}");
    // Nothing waits for what will not come; the states are there.
    assert!(session.activity == Activity::Idle && !session.is_measuring());
    assert_eq!((session.timeline.states().len(), session.primitives().len()), (3, 1));
    let effects = session.apply(Action::Verb(Verb::Run));
    let [
        Effect::Send(Command::Resume(from)),
        Effect::Send(Command::SetParams(_)),
        Effect::Send(Command::Run),
    ] = &effects[..]
    else {
        panic!("{effects:?}")
    };
    assert!(Arc::ptr_eq(&from.snapshot, &state));
    // Of the others nothing but their answers is missing.
    session.absorb(Event::Ended { who: Helper::Measurer, error: "it panicked".into() });
    assert_eq!(session.activity, Activity::Running);
}

/// Another shape than all before.
fn open_another(session: &mut Session) -> Vec<Effect> {
    let effects = session.apply(Action::OpenDropped(vec![PathBuf::from("other.obj")].into()));
    session.absorb(Event::Activity(Activity::Loading));
    session.absorb(Event::Loaded(loaded()));
    session.absorb(snapshot(&[7], Phase::Start, 0, vec![]));
    session.absorb(Event::Activity(Activity::Idle));
    // It was run at once.
    session.absorb(Event::Activity(Activity::Idle));
    effects
}

#[test]
fn another_shape_is_never_saved_or_exported_over_the_file_of_the_first() {
    let mut session = session();
    let file = PathBuf::from("first.superform");
    let saved = KeepingEvent::Saved { path: file.clone(), workspace: Box::new(session.workspace()) };
    session.absorb_keeping(saved);
    session.apply(Action::Export(PathBuf::from("first.ply")));
    session.absorb(Event::Activity(Activity::Idle));
    assert_eq!(session.title().as_deref(), Some("first"));
    assert!(session.is_enabled(Verb::ExportAgain));

    open_another(&mut session);
    assert_eq!((session.session_file(), session.title().as_deref()), (None, Some("nine")));
    assert!(matches!(session.apply(Action::Verb(Verb::SaveSession))[..], [Effect::AskForSession]));
    assert!(session.apply(Action::Verb(Verb::ExportAgain)).is_empty());
    assert!(session.reason(Verb::ExportAgain).is_some_and(|why| why.contains("This shape")));
    // A save of the first that was under way is not one of the second.
    let first = session.undo.done().last().expect("a dropped shape can be undone").document.clone();
    let late = Workspace { document: first, ..session.workspace() };
    session.absorb_keeping(KeepingEvent::Saved { path: file.clone(), workspace: Box::new(late) });
    assert_eq!(session.session_file(), None);

    // Back at the first, its file is the one to save to, and again not at the second.
    session.apply(Action::Verb(Verb::Undo));
    assert_eq!(session.session_file(), Some(file.as_path()));
    assert!(session.is_enabled(Verb::ExportAgain) && !session.is_changed());
    let effects = session.apply(Action::Verb(Verb::SaveSession));
    assert!(matches!(&effects[..], [Effect::SaveSession(path)] if *path == file));
    session.apply(Action::Verb(Verb::Redo));
    assert_eq!(session.session_file(), None);

    // What is recovered has no file of its own yet.
    let workspace = Box::new(session.workspace());
    let from = Opening::Recovered(1);
    session.absorb_keeping(KeepingEvent::Opened { from, workspace, notes: vec![] });
    assert!(session.session_file().is_none() && session.is_changed());
}

#[test]
fn sampling_anew_is_of_the_shape_that_is_shown() {
    let mut session = session();
    open_another(&mut session);
    session.apply(Action::Verb(Verb::Undo));
    session.apply(Action::SetSampling(SamplingOptions { points: 700, ..session.sampling }));
    // The worker is still at the other shape.
    let effects = session.apply(Action::Verb(Verb::Resample));
    let [Effect::Send(Command::Resume(state)), .., Effect::Send(Command::Resample(_))] = &effects[..] else {
        panic!("{effects:?}")
    };
    assert!(Arc::ptr_eq(&state.loaded, session.loaded.as_ref().expect("a shape")));
}

#[test]
fn framing_the_selection_looks_at_it() {
    let mut session = session();
    session.apply(Action::SetAspect(1.6));
    session.apply(Action::Select(Some(3)));
    session.apply(Action::Verb(Verb::FrameSelection));
    let center = session.scene.point(&Point3::new(3.0, 0.0, 0.5));
    assert!((session.camera.target - center).norm() < 1e-9);
    let all = session.camera.distance;
    session.apply(Action::Verb(Verb::FrameAll));
    assert!(session.camera.distance > all);
}

#[test]
fn figures_are_shown_for_the_state_they_belong_to() {
    let mut session = session();
    let Event::Snapshot(first) = snapshot(&[1, 2], Phase::Sampling, 1, vec![]) else { unreachable!() };
    let Event::Snapshot(second) = snapshot(&[1], Phase::Sampling, 2, vec![]) else { unreachable!() };
    let measured = |snapshot: &Arc<Snapshot>| {
        let (snapshot, result) = (Arc::clone(snapshot), Err("it has no surface".to_owned()));
        Event::Measured(Arc::new(Measurement { snapshot, result }))
    };
    session.absorb(Event::Snapshot(Arc::clone(&first)));
    session.absorb(Event::Measuring(Arc::clone(&first)));
    assert!(session.is_measuring() && session.measurement().is_none());
    session.absorb(measured(&first));
    assert!(!session.is_measuring() && session.measurement().is_some());
    // The next state has none of its own yet, and doesn't take a late one.
    session.absorb(Event::Snapshot(Arc::clone(&second)));
    assert!(session.measurement().is_none());
    session.absorb(Event::Measuring(Arc::clone(&second)));
    session.absorb(measured(&first));
    assert!(session.is_measuring() && session.measurement().is_none());
    session.absorb(measured(&second));
    assert!(!session.is_measuring() && session.measurement().is_some());
    session.absorb(Event::Loaded(loaded()));
    assert!(session.last_measurement().is_none(), "another shape has other figures");
}
