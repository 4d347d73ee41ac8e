//! The worker with the real sampler.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use superform::geometry::metrics::{MetricOptions, evaluate};
use superform::inference::{Method, Params, Phase};
use superform::io::{self, ExportOptions, Format};
use superform::worker::{
    Activity, Command, Event, ExportRequest, LoadedShape, SamplingOptions, Snapshot, Source, State, Worker,
};

/// Longer than anything here takes; reached only by a failing test.
const PATIENCE: Duration = Duration::from_secs(120);

fn start() -> Worker {
    start_with_shape().0
}

fn start_with_shape() -> (Worker, Arc<LoadedShape>) {
    let mut worker = Worker::spawn(|| {}).unwrap();
    let params = Params { iterations: 8, clusters: 12, ..Params::default() };
    worker.send(Command::SetParams(params));
    let sampling = SamplingOptions { points: 800, seed: 3, ..SamplingOptions::default() };
    worker.send(Command::Load { source: Source::BuiltIn, sampling });
    let loaded = loop {
        match worker.next_event(PATIENCE).expect("the worker has fallen silent") {
            Event::Loaded(loaded) => break loaded,
            Event::Failed { what, error } => panic!("{what}: {error}"),
            _ => {}
        }
    };
    until_idle(&mut worker);
    (worker, loaded)
}

/// The snapshots up to the next rest.
fn until_idle(worker: &mut Worker) -> Vec<Arc<Snapshot>> {
    let mut snapshots = Vec::new();
    loop {
        match worker.next_event(PATIENCE).expect("the worker has fallen silent") {
            Event::Snapshot(snapshot) => snapshots.push(snapshot),
            Event::Activity(Activity::Idle) => return snapshots,
            Event::Failed { what, error } => panic!("{what}: {error}"),
            _ => {}
        }
    }
}

#[test]
fn a_run_interrupted_again_and_again_gives_the_same_bits() {
    let mut worker = start();
    worker.send(Command::Run);
    let whole = until_idle(&mut worker).pop().unwrap();
    assert_eq!(whole.abstraction.phase, Phase::Finished);

    worker.send(Command::Reset);
    until_idle(&mut worker);
    let mut last = None;
    let mut pauses = 0;
    while last.as_ref().is_none_or(|s: &Arc<Snapshot>| s.abstraction.phase != Phase::Finished) {
        worker.send(Command::Run);
        // Somewhere in the middle of the step after the first snapshot.
        while let Some(event) = worker.next_event(PATIENCE) {
            if let Event::Snapshot(snapshot) = event {
                last = Some(snapshot);
                break;
            }
        }
        worker.send(Command::Pause);
        let late = until_idle(&mut worker);
        pauses += 1;
        // A run that finished before the pause came in says that it is idle twice.
        let finished = late.iter().chain(&last).any(|s| s.abstraction.phase == Phase::Finished);
        last = late.into_iter().next_back().or(last);
        if finished {
            break;
        }
    }
    assert!(pauses > 1, "it was never interrupted");
    let pieced = last.unwrap();
    assert_eq!(pieced.abstraction.labels, whole.abstraction.labels);
    assert_eq!(pieced.abstraction.primitives, whole.abstraction.primitives);
}

fn export(path: &Path, format: Format, state: &State) -> Command {
    Command::Export(Box::new(ExportRequest {
        path: path.to_owned(),
        format,
        options: ExportOptions::default(),
        state: state.clone(),
        colors: Arc::default(),
    }))
}

/// What loading a file comes to: the shape and its only state.
fn opened(worker: &mut Worker, path: &Path) -> (Arc<LoadedShape>, Arc<Snapshot>) {
    let sampling = SamplingOptions { points: 800, seed: 3, ..SamplingOptions::default() };
    worker.send(Command::Load { source: Source::File(path.to_owned()), sampling });
    let mut found = (None, None);
    loop {
        match worker.next_event(PATIENCE).expect("the worker has fallen silent") {
            Event::Loaded(loaded) => found.0 = Some(loaded),
            Event::Snapshot(snapshot) => found.1 = Some(snapshot),
            Event::Failed { what, error } => panic!("{what}: {error}"),
            Event::Activity(Activity::Idle) if found.1.is_some() => break,
            _ => {}
        }
    }
    (found.0.unwrap(), found.1.unwrap())
}

fn assert_same_primitives(a: &Snapshot, b: &Snapshot) {
    assert_eq!(a.abstraction.primitives.len(), b.abstraction.primitives.len());
    for (a, b) in a.abstraction.primitives.iter().zip(b.abstraction.primitives.iter()) {
        assert_eq!(a.id, b.id);
        let size = a.shape.semi_axes.norm();
        assert!((a.shape.semi_axes - b.shape.semi_axes).norm() < 1e-9 * size);
        assert!((a.shape.translation - b.shape.translation).norm() < 1e-9 * size);
        assert!(a.shape.rotation.rotation_to(&b.shape.rotation).matrix().trace() > 3.0 - 1e-9);
    }
}

#[test]
fn a_result_is_opened_with_what_it_stands_for_and_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let (mut worker, loaded) = start_with_shape();
    worker.send(Command::Run);
    let state = until_idle(&mut worker).pop().unwrap();
    let shown = State { loaded, snapshot: Arc::clone(&state) };
    for (format, name, shape) in [
        (Format::PrimitivesJson, "primitives.json", "built-in chair"),
        (Format::PrimitivesNpz, "primitives.npz", "built-in chair"),
        (Format::PrimitivesCsv, "alone.csv", "alone.csv"),
    ] {
        let path = folder.path().join(name);
        worker.send(export(&path, format, &shown));
        until_idle(&mut worker);
        // Whoever opens it has another shape open, or none.
        let mut other = Worker::spawn(|| {}).unwrap();
        let (loaded, taken) = opened(&mut other, &path);
        assert_eq!(loaded.shape.name, shape);
        assert_eq!(taken.abstraction.phase, Phase::Finished);
        assert_same_primitives(&taken, &state);
        assert!(taken.abstraction.primitives.iter().all(|p| p.points > 0), "{name}: some have no points");
        other.send(Command::Extend(2));
        let last = until_idle(&mut other).pop().unwrap();
        assert_eq!((last.abstraction.iteration, last.abstraction.phase), (2, Phase::Finished));
    }
}

#[test]
fn a_lone_file_of_primitives_with_points_is_opened_on_these() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("input.xyz");
    let chair = io::sample(&io::built_in().unwrap(), &SamplingOptions::default()).unwrap().points;
    let lines: String = chair.iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z)).collect();
    std::fs::write(&input, lines).unwrap();
    let mut worker = start();
    let (loaded, _) = opened(&mut worker, &input);
    worker.send(Command::Run);
    let state = until_idle(&mut worker).pop().unwrap();
    let path = folder.path().join("elsewhere.npz");
    worker.send(export(
        &path,
        Format::PrimitivesNpz,
        &State { loaded: Arc::clone(&loaded), snapshot: state },
    ));
    until_idle(&mut worker);
    std::fs::remove_file(input).unwrap();
    let mut other = Worker::spawn(|| {}).unwrap();
    let (again, taken) = opened(&mut other, &path);
    let io::ShapeGeometry::Cloud(cloud) = &again.shape.geometry else { panic!("it is a mesh") };
    assert_eq!(cloud.points, loaded.cloud.points);
    assert!(taken.abstraction.primitives.iter().all(|p| p.points > 0));
}

#[test]
fn primitives_of_a_file_take_the_place_of_the_present_ones() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("primitives.csv");
    let (mut worker, loaded) = start_with_shape();
    worker.send(Command::Run);
    let state = until_idle(&mut worker).pop().unwrap();
    worker.send(export(&path, Format::PrimitivesCsv, &State { loaded, snapshot: Arc::clone(&state) }));
    until_idle(&mut worker);
    worker.send(Command::Reset);
    until_idle(&mut worker);
    worker.send(Command::TakeFrom(path.clone()));
    let taken = until_idle(&mut worker).pop().unwrap();
    assert_same_primitives(&taken, &state);
    // What can't be read changes nothing.
    std::fs::write(&path, "1,2,3\n").unwrap();
    worker.send(Command::TakeFrom(path));
    let event =
        std::iter::from_fn(|| worker.next_event(PATIENCE)).find(|e| matches!(e, Event::Failed { .. }));
    let Some(Event::Failed { what, error }) = event else { unreachable!() };
    assert!(what.contains("could not be brought in") && error.contains("line 1"), "{what}: {error}");
    until_idle(&mut worker);
    worker.send(Command::Extend(1));
    assert_eq!(until_idle(&mut worker).pop().unwrap().abstraction.iteration, 1);
}

#[test]
fn the_results_of_a_step_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    let (cloud, primitives) = (folder.path().join("cloud.ply"), folder.path().join("primitives.json"));
    let (mut worker, loaded) = start_with_shape();
    worker.send(Command::StepIteration);
    let state = until_idle(&mut worker).pop().unwrap();
    let shown = State { loaded, snapshot: Arc::clone(&state) };
    worker.send(export(&cloud, Format::CloudPly, &shown));
    until_idle(&mut worker);
    worker.send(export(&primitives, Format::PrimitivesJson, &shown));
    until_idle(&mut worker);
    assert!(std::fs::read(&cloud).unwrap().starts_with(b"ply"));
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(&primitives).unwrap()).unwrap();
    let ids: Vec<u64> =
        json["primitives"].as_array().unwrap().iter().map(|p| p["id"].as_u64().unwrap()).collect();
    let expected: Vec<u64> = state.abstraction.primitives.iter().map(|p| u64::from(p.id)).collect();
    assert_eq!(ids, expected);
}

#[test]
fn another_method_starts_anew() {
    let mut worker = start();
    worker.send(Command::StepIteration);
    until_idle(&mut worker);
    let params = Params { clusters: 7, ..Method::KMeans.params() };
    worker.send(Command::SetParams(params));
    worker.send(Command::StepIteration);
    let sampled = until_idle(&mut worker).pop().unwrap();
    assert_eq!(Method::of(&sampled.params), Some(Method::Default), "the run goes on as it began");
    worker.send(Command::Run);
    let states = until_idle(&mut worker);
    assert_eq!(states.len(), 8, "the start, and one state a fit");
    for (i, state) in (0..).zip(&states) {
        assert_eq!((state.params, state.start), (params, params));
        assert_eq!(state.abstraction.iteration, i);
    }
    assert_eq!(states[7].abstraction.phase, Phase::Finished);
    worker.send(Command::MergeAll);
    loop {
        match worker.next_event(PATIENCE).expect("the worker has fallen silent") {
            Event::MergeStep(merge) => break assert_eq!(merge, None, "a baseline merges nothing"),
            Event::Failed { what, error } => panic!("{what}: {error}"),
            _ => {}
        }
    }
}

/// What is shown is what `evaluate` says of the exported result.
#[test]
fn a_finished_run_is_measured_as_evaluate_measures_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("primitives.json");
    let (mut worker, loaded) = start_with_shape();
    worker.send(Command::Run);
    let measurement = loop {
        match worker.next_event(PATIENCE).expect("the worker has fallen silent") {
            Event::Measured(measurement) => break measurement,
            Event::Failed { what, error } => panic!("{what}: {error}"),
            _ => {}
        }
    };
    assert_eq!(measurement.snapshot.abstraction.phase, Phase::Finished);
    let found = measurement.result.as_ref().unwrap();
    let state = State { loaded, snapshot: Arc::clone(&measurement.snapshot) };
    worker.send(export(&path, Format::PrimitivesJson, &state));
    while !matches!(worker.next_event(PATIENCE).expect("the worker has fallen silent"), Event::Written { .. })
    {
    }
    let stored = io::read_primitives(&path).unwrap();
    let reference = io::reference(&io::built_in().unwrap(), &MetricOptions::default()).unwrap();
    let known = evaluate(&stored.shapes(), found.unassigned_share, &reference);
    assert_eq!(found, &known);
    assert!(known.chamfer_l1.is_some_and(|d| d < 0.1) && known.iou.is_some(), "{known:?}");
    assert!((found.unassigned_share.unwrap() - stored.unassigned_share().unwrap()).abs() < 1e-12);
}
