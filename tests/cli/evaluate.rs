//! Measuring results: stored ones against an independent evaluator's figures,
//! the reader of primitives, the command.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::process;
use nalgebra::{Point3, Rotation3, Vector3};
use serde_json::{Value, json};
use superform::geometry::metrics::{MetricOptions, Metrics, evaluate};
use superform::geometry::{Superquadric, TriMesh};
use superform::io::{self, Attributes, Shape, ShapeGeometry};

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/evaluation")
}

fn reference_path(name: &str) -> PathBuf {
    match name {
        "chair.obj" => Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/chair.obj"),
        _ => data().join(name),
    }
}

fn measured(result: &str, reference: &str) -> Metrics {
    let stored = io::read_primitives(&data().join(result)).unwrap();
    let shape = io::read(&reference_path(reference)).unwrap();
    let reference = io::reference(&shape, &MetricOptions::default()).unwrap();
    evaluate(&stored.shapes(), stored.unassigned_share(), &reference)
}

#[test]
fn stored_results_measure_as_the_independent_evaluator_has_it() {
    let expected: Value = serde_json::from_slice(&fs::read(data().join("expected.json")).unwrap()).unwrap();
    let evaluations = expected["evaluations"].as_array().unwrap();
    assert_eq!(evaluations.len(), 3);
    for entry in evaluations {
        let found = measured(entry["result"].as_str().unwrap(), entry["reference"].as_str().unwrap());
        let near = |name: &str, found: Option<f64>, deviations: f64, allowance: f64| {
            let (found, expected) = (found.unwrap(), entry[name].as_f64().unwrap());
            let spread = entry[format!("{name}_spread")].as_f64().unwrap();
            // Ours and theirs, each with its noise; what is allowed beyond
            // stands for samplers that spread their points differently.
            let tolerance = deviations * spread * 2f64.sqrt() + allowance * expected;
            assert!(
                (found - expected).abs() < tolerance,
                "{name}: {found} {expected} ± {tolerance}\n{entry}"
            );
        };
        near("accuracy", found.accuracy, 4.0, 0.003);
        near("completeness", found.completeness, 4.0, 0.008);
        near("chamfer_l1", found.chamfer_l1, 4.0, 0.006);
        let buried = entry["share_of_surface_inside_others"].as_f64().unwrap();
        assert!((found.buried_share.unwrap() - buried).abs() < 5e-3, "{found:?}\n{entry}");
        if entry["iou"].is_null() {
            assert!(found.iou.is_none() && found.iou_missing.unwrap().contains("cloud"));
        } else {
            let off = (found.iou.unwrap() - entry["iou"].as_f64().unwrap()).abs();
            assert!(off < 3.0 * found.iou_error.unwrap(), "{found:?}\n{entry}");
        }
    }
}

fn stored() -> Value {
    serde_json::from_slice(&fs::read(data().join("merged.json")).unwrap()).unwrap()
}

/// What reading the text as a file of primitives complains about.
fn complaint(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("primitives.json");
    fs::write(&path, text).unwrap();
    // A folder does as well as the file in it.
    let problem = io::read_primitives(folder.path()).unwrap_err().to_string();
    let shown = path.display().to_string();
    assert!(problem.contains(&shown), "{problem}");
    problem.replace(&shown, "F")
}

#[test]
fn what_is_no_file_of_primitives_is_refused_with_the_place() {
    let text = fs::read_to_string(data().join("merged.json")).unwrap();
    let half = complaint(&text[..text.len() / 2]);
    assert!(half.starts_with("F, line ") && half.contains("EOF"), "{half}");
    assert!(complaint("{\"a\": 1}").contains("its \"format\" is not \"superform-primitives\""));
    assert!(complaint("v 0 0 0\n").contains("F, line 1: “v” is not a number"));
    assert!(complaint("[]").contains("F, line 1"));
    let missing = io::read_primitives(Path::new("nowhere.json")).unwrap_err().to_string();
    assert!(missing.contains("cannot open nowhere.json"), "{missing}");

    let changed = |change: &dyn Fn(&mut Value)| {
        let mut value = stored();
        change(&mut value);
        complaint(&serde_json::to_string_pretty(&value).unwrap())
    };
    let at = |v: &mut Value, name: &str, to: Value| v["primitives"][1][name] = to;
    let id = stored()["primitives"][1]["id"].clone();
    for (change, words) in [
        (
            &(|v: &mut Value| v["version"] = json!(7)) as &dyn Fn(&mut Value),
            "version is 7, but only version 1",
        ),
        (&|v| drop(v.as_object_mut().unwrap().remove("points")), "missing field `points`"),
        (&|v| v["points"] = json!(3), "more points than their cloud"),
        (&|v| at(v, "eps", json!([0.0, 1.0])), "the exponent 0 is not greater than 0"),
        (&|v| at(v, "scale", json!([1.0, -2.0, 1.0])), "the semi-axis -2 is not greater than 0"),
        (&|v| at(v, "scale", json!([1.0, 2.0])), "array of length 3"),
        (&|v| at(v, "taper", json!([0.0, 1.5])), "the taper 1.5 is not between"),
        (&|v| at(v, "rotation", json!([[1, 0, 0], [0, 1, 0], [0, 0, 2]])), "is not a rotation"),
        (&|v| at(v, "rotation", json!([[1, 0, 0], [0, 1, 0], [0, 0, -1]])), "is not a rotation"),
        (&|v| at(v, "sigma", json!(-1.0)), "below 0"),
        (&|v| at(v, "bend", json!(0.5)), "unknown field `bend`"),
        (&|v| v["primitives"][0] = v["primitives"][1].clone(), "two primitives have the id"),
    ] {
        let problem = changed(change);
        assert!(problem.contains(words), "{problem}");
        if problem.contains("primitive ") {
            assert!(problem.contains(&format!("primitive {id}: ")), "{problem}");
        }
    }
}

fn superform(args: &[&str]) -> Output {
    process::superform(Path::new("."), args)
}

#[test]
fn the_command_prints_a_table_or_json() {
    let result = data().join("merged.json").display().to_string();
    let chair = reference_path("chair.obj").display().to_string();
    let args = ["evaluate", &result, "--reference", &chair, "--samples", "20000", "--seed", "5"];
    let output = superform(&args);
    assert!(output.status.success());
    let table = String::from_utf8(output.stdout).unwrap();
    for words in
        ["Chamfer-L1", "accuracy", "completeness", "IoU", "±", "Primitives              6", "Unassigned"]
    {
        assert!(table.contains(words), "{words} in\n{table}");
    }
    let output = superform(&[&args[..], &["--json"]].concat());
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["format"], "superform-evaluation");
    assert_eq!((&found["primitives"], &found["options"]["seed"]), (&json!(6), &json!(5)));
    assert!((found["chamfer_l1"].as_f64().unwrap() - 0.0056).abs() < 5e-4, "{found}");
    assert!(found["iou"].as_f64().unwrap() > 0.7 && found["iou_missing"].is_null());
    // The chair has parts that reach into others: the filled outside is another volume.
    assert!((found["iou_outside"].as_f64().unwrap() - found["iou"].as_f64().unwrap()).abs() < 0.2, "{found}");
    assert!(table.contains("IoU outside"), "{table}");
    // A cloud encloses nothing, and says so.
    let cloud = reference_path("chair.xyz").display().to_string();
    let output = superform(&["evaluate", &result, "--reference", &cloud]);
    let (table, notes) =
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert!(!table.contains("IoU outside"), "{table}");
    assert!(table.contains("encloses no volume") && notes.contains("point spacing"), "{table}{notes}");
}

#[test]
fn the_command_refuses_what_it_can_not_measure() {
    let result = data().join("merged.json").display().to_string();
    let chair = reference_path("chair.obj").display().to_string();
    for (args, code, words) in [
        (vec!["evaluate", &result], 2, "--reference"),
        (vec!["evaluate", &result, "--reference", &chair, "--samples", "7"], 2, "samples is 7"),
        (vec!["evaluate", &chair, "--reference", &chair], 1, "chair.obj, line 2"),
        (vec!["evaluate", &result, "--reference", "missing.obj"], 1, "cannot open missing.obj"),
    ] {
        let output = superform(&args);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{args:?} {message}");
        assert!(message.contains(words), "{message}");
        assert!(output.stdout.is_empty());
    }
}

/// A bottle that is hollow but for a narrow mouth: the winding number finds its
/// thin wall, a person a solid.
#[test]
fn a_hollow_thing_is_also_measured_as_a_solid() {
    let line: [(f64, f64); 10] = [
        (0.0, 0.0),
        (1.0, 0.0),
        (1.0, 3.0),
        (0.25, 3.1),
        (0.25, 3.2),
        (0.2, 3.2),
        (0.2, 3.05),
        (0.95, 2.95),
        (0.95, 0.05),
        (0.0, 0.05),
    ];
    let mut mesh = TriMesh::default();
    for (radius, height) in line {
        mesh.vertices.extend((0..64).map(|i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 64.0).sin_cos();
            Point3::new(radius * cos, radius * sin, height)
        }));
    }
    for (ring, i) in (0..9).flat_map(|ring| (0..64).map(move |i| (ring * 64, i))) {
        let (a, b) = (ring + i, ring + (i + 1) % 64);
        mesh.faces.extend([[a, b, b + 64], [a, b + 64, a + 64]]);
    }
    let body = Superquadric {
        exponents: [0.1, 1.0],
        semi_axes: Vector3::new(1.0, 1.0, 1.5),
        rotation: Rotation3::identity(),
        translation: Vector3::new(0.0, 0.0, 1.5),
        taper: [0.0, 0.0],
    };
    let geometry = ShapeGeometry::Mesh(mesh);
    let (name, attributes) = ("bottle".to_owned(), Attributes::default());
    let shape = Shape {
        name,
        path: None,
        content: None,
        geometry,
        attributes,
        viewpoints: Vec::new(),
        notes: Vec::new(),
    };
    let found = evaluate(&[body], None, &io::reference(&shape, &MetricOptions::default()).unwrap());
    assert!(found.iou.is_none_or(|iou| iou < 0.25), "{found:?}");
    assert!(found.iou_outside.unwrap() > 0.95, "{found:?}");
}
