//! The worker with the real sampler.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use superform::geometry::metrics::{MetricOptions, evaluate};
use superform::inference::{Method, Params, Phase, UNASSIGNED};
use superform::io::{self, ExportOptions, Format};
use superform::worker::{
    Activity, Command, Event, ExportRequest, FAULT, LoadedShape, SamplingOptions, Snapshot, Source, State,
    Worker,
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

/// Runs the program on a shape in a folder of its own: `NAME/shape/INPUT`, and
/// its result in `NAME/out`.
fn result(folder: &Path, name: &str, input: &str, content: &[u8]) -> PathBuf {
    let place = folder.join(name);
    std::fs::create_dir_all(place.join("shape")).unwrap();
    let shape = Path::new("shape").join(input);
    std::fs::write(place.join(&shape), content).unwrap();
    let quick = ["--points", "500", "--iterations", "3", "--clusters", "6", "--seed", "5"];
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_superform"))
        .args(["run", shape.to_str().unwrap(), "-o", "out", "--quiet"])
        .args(quick)
        .current_dir(&place)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    place
}

/// A tube of points in two rows of different length, and one far away.
fn tube() -> Vec<u8> {
    let mut text = String::new();
    for i in 0..2400 {
        let (turn, z) = (f64::from(i % 60) * 0.104_719_755, f64::from(i / 60) * 0.05);
        let radius = if i < 1000 { 1.0 } else { 0.4 };
        text.push_str(&format!("{} {} {z}\n", radius * turn.cos(), radius * turn.sin()));
    }
    text.push_str("9 9 9\n");
    text.into_bytes()
}

/// Labels of all points of the cloud, and the primitives, as they are in the files.
fn written(place: &Path) -> (Vec<i64>, io::StoredPrimitives) {
    let segmented = io::read(&place.join("out/segmented.ply")).unwrap();
    (segmented.attributes.labels.unwrap(), io::read_primitives(&place.join("out")).unwrap())
}

fn labels_of(loaded: &LoadedShape, state: &Snapshot) -> Vec<i64> {
    let labels = loaded.cloud.labels_of_input(&state.abstraction.labels, UNASSIGNED);
    labels.into_iter().map(|label| if label == UNASSIGNED { -1 } else { i64::from(label) }).collect()
}

/// The last of the shape's notes.
fn note(loaded: &LoadedShape) -> &str {
    loaded.shape.notes.last().map_or("", String::as_str)
}

#[test]
fn a_result_keeps_its_labels_and_noise_wherever_its_folder_goes() {
    let folder = tempfile::tempdir().unwrap();
    let chair = include_bytes!("../../assets/chair.obj");
    for (name, input, content) in [("cloud", "tube.xyz", &tube()[..]), ("mesh", "built-in chair", chair)] {
        let place = result(folder.path(), name, input, content);
        let moved = folder.path().join(format!("{name} moved"));
        let (labels, stored) = written(&place);
        assert!(labels.iter().any(|&l| l >= 0) && stored.primitives.len() > 1, "{name}");
        for at in [&place, &moved] {
            if at == &moved {
                std::fs::rename(&place, &moved).unwrap();
            }
            let mut worker = Worker::spawn(|| {}).unwrap();
            let (loaded, state) = opened(&mut worker, &at.join("out"));
            assert_eq!(loaded.shape.path.as_ref().and_then(|p| p.file_name()), Some(input.as_ref()));
            assert_eq!(labels_of(&loaded, &state), labels, "{name}");
            // As they are in the file, to the last bit.
            assert_eq!(&*state.abstraction.primitives, &*stored.primitives, "{name}");
            // What is exported of it is what was opened.
            let shown = State { loaded: Arc::clone(&loaded), snapshot: Arc::clone(&state) };
            let again = folder.path().join("again.ply");
            worker.send(export(&again, Format::CloudPly, &shown));
            until_idle(&mut worker);
            assert_eq!(std::fs::read(&again).unwrap(), std::fs::read(at.join("out/segmented.ply")).unwrap());
            let same = folder.path().join("by export.ply");
            let args =
                [at.join("out"), "--output".into(), same.clone(), "--format".into(), "cloud-ply".into()];
            let program = env!("CARGO_BIN_EXE_superform");
            let output = std::process::Command::new(program).arg("export").args(args).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            assert_eq!(std::fs::read(&same).unwrap(), std::fs::read(&again).unwrap());
            // And it goes on.
            worker.send(Command::Extend(1));
            let more = until_idle(&mut worker).pop().unwrap();
            assert_eq!(more.abstraction.phase, Phase::Finished);
        }
    }
}

#[test]
fn a_shape_that_has_changed_or_gone_is_not_taken_and_said_so() {
    let folder = tempfile::tempdir().unwrap();
    let place = result(folder.path(), "cloud", "tube.xyz", &tube());
    let (labels, stored) = written(&place);
    let shape = place.join("shape/tube.xyz");
    let mut worker = Worker::spawn(|| {}).unwrap();
    // Another file under the same name, of the same size and number of points; then none.
    let other = String::from_utf8(tube()).unwrap().replacen("9 9 9", "9 9 8", 1);
    std::fs::write(&shape, other).unwrap();
    for words in [["tube.xyz has changed", "segmented cloud"], ["not found at", "import them"]] {
        let (loaded, state) = opened(&mut worker, &place.join("out"));
        assert_eq!(loaded.shape.path, None);
        assert!(words.iter().all(|word| note(&loaded).contains(word)), "{}", note(&loaded));
        assert_eq!(labels_of(&loaded, &state), labels, "the labels are in the segmented cloud");
        assert_eq!(&*state.abstraction.primitives, &*stored.primitives);
        if shape.exists() {
            std::fs::remove_file(&shape).unwrap();
        }
    }
    // Without that cloud, the primitives alone; a file of that name beside them is no proof.
    std::fs::remove_file(place.join("out/segmented.ply")).unwrap();
    std::fs::write(place.join("out/tube.xyz"), "0 0 0\n1 0 0\n0 1 0\n0 0 1\n").unwrap();
    let (loaded, state) = opened(&mut worker, &place.join("out"));
    assert!(note(&loaded).contains("the surfaces of the primitives"), "{}", note(&loaded));
    assert_eq!(state.abstraction.primitives.len(), stored.primitives.len());
    // The report of another run says nothing of this one.
    std::fs::write(&shape, tube()).unwrap();
    let report = place.join("out/report.json");
    let text = std::fs::read_to_string(&report).unwrap();
    std::fs::write(&report, text.replacen("\"seed\": 5", "\"seed\": 6", 2)).unwrap();
    let (loaded, _) = opened(&mut worker, &place.join("out"));
    assert!(
        note(&loaded).contains("report.json next to them belongs to a different run"),
        "{}",
        note(&loaded)
    );
}

#[test]
fn the_built_in_shape_is_known_by_its_own_field_and_old_reports_open() {
    let folder = tempfile::tempdir().unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_superform"))
        .args(["--headless", "--points", "500", "--iterations", "2", "--clusters", "6"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::rename(folder.path().join("superform-out"), folder.path().join("out")).unwrap();
    let report = folder.path().join("out/report.json");
    let change = |report: &Path, change: &dyn Fn(&mut serde_json::Value)| {
        let mut json: serde_json::Value = serde_json::from_slice(&std::fs::read(report).unwrap()).unwrap();
        change(&mut json["input"]);
        std::fs::write(report, json.to_string()).unwrap();
    };
    change(&report, &|input| {
        assert_eq!((&input["built_in"], &input["path"]), (&true.into(), &serde_json::Value::Null));
    });
    let (labels, _) = written(folder.path());
    let mut worker = Worker::spawn(|| {}).unwrap();
    for _ in 0..2 {
        let (loaded, state) = opened(&mut worker, &folder.path().join("out"));
        assert_eq!(loaded.shape.content, Some(io::Content::BuiltIn));
        assert_eq!(labels_of(&loaded, &state), labels);
        // As early versions wrote it.
        change(
            &report,
            &|input| *input = serde_json::json!({ "name": "built-in chair", "path": null, "kind": input["kind"], "points": input["points"], "faces": input["faces"] }),
        );
    }
    // The name says nothing without the report.
    std::fs::remove_file(&report).unwrap();
    let (loaded, _) = opened(&mut worker, &folder.path().join("out"));
    assert_ne!(loaded.shape.content, Some(io::Content::BuiltIn));

    let place = result(folder.path(), "old", "tube.xyz", &tube());
    let (report, shape) = (place.join("out/report.json"), place.join("shape/tube.xyz"));
    change(&report, &|input| {
        assert_eq!(input["relative_path"], "../shape/tube.xyz");
        assert_eq!(input["bytes"], tube().len());
        assert_eq!(input["crc32"], format!("{:08x}", crc32fast::hash(&tube())));
        *input = serde_json::json!({ "name": "tube.xyz", "path": shape, "kind": "cloud", "points": 2401, "faces": 0 });
    });
    let (loaded, _) = opened(&mut worker, &place.join("out"));
    assert_eq!(loaded.shape.path.as_ref(), Some(&shape));
    change(&report, &|input| input["path"] = "elsewhere/tube.xyz".into());
    let (loaded, _) = opened(&mut worker, &place.join("out"));
    assert!(note(&loaded).contains("or at elsewhere/tube.xyz"), "{}", note(&loaded));
}

/// Numbers and lists in JSON, by their pointers.
fn places(value: &serde_json::Value, at: &str, found: &mut Vec<String>) {
    match value {
        serde_json::Value::Number(_) => found.push(at.to_owned()),
        serde_json::Value::Array(list) => {
            found.push(at.to_owned());
            let ends = [0, list.len().saturating_sub(1)];
            list.iter()
                .enumerate()
                .filter(|(i, _)| ends.contains(i))
                .for_each(|(i, v)| places(v, &format!("{at}/{i}"), found));
        }
        serde_json::Value::Object(map) => {
            map.iter().for_each(|(k, v)| places(v, &format!("{at}/{k}"), found))
        }
        _ => {}
    }
}

#[test]
fn numbers_in_a_result_that_cant_be_bring_nothing_down() {
    let folder = tempfile::tempdir().unwrap();
    let place = result(folder.path(), "cloud", "tube.xyz", &tube());
    let mut worker = Worker::spawn(|| {}).unwrap();
    let sampling = SamplingOptions { points: 500, ..SamplingOptions::default() };
    let mut opened = 0;
    for name in ["primitives.json", "report.json"] {
        let path = place.join("out").join(name);
        let whole = std::fs::read_to_string(&path).unwrap();
        let json: serde_json::Value = serde_json::from_str(&whole).unwrap();
        let mut found = Vec::new();
        places(&json, "", &mut found);
        assert!(found.len() > 20, "{found:?}");
        for at in found {
            for other in [
                "0",
                "-1",
                "18446744073709551615",
                "4294967295",
                "1e308",
                "-1e308",
                "1e999",
                "[]",
                "[1]",
                "null",
            ] {
                const MARK: &str = "here it is";
                let mut changed = json.clone();
                *changed.pointer_mut(&at).unwrap() = MARK.into();
                std::fs::write(&path, changed.to_string().replace(&format!("\"{MARK}\""), other)).unwrap();
                worker.send(Command::Load { source: Source::File(place.join("out")), sampling });
                loop {
                    match worker.next_event(PATIENCE).expect("the worker has fallen silent") {
                        Event::Failed { what, error } => {
                            assert_ne!(what, FAULT, "{name}{at} = {other}: {error}")
                        }
                        Event::Ended { error, .. } => panic!("{name}{at} = {other}: {error}"),
                        Event::Snapshot(_) => opened += 1,
                        Event::Activity(Activity::Idle) => break,
                        _ => {}
                    }
                }
            }
        }
        std::fs::write(&path, whole).unwrap();
    }
    assert!(opened > 50, "only {opened} could be opened");
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
    assert!(what.contains("Cannot import primitives") && error.contains("line 1"), "{what}: {error}");
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
