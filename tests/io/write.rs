//! Writing: what is written comes back the same, through another's reader
//! where there is one; and a failure leaves nothing behind.

use std::fs;
use std::path::Path;

use crate::common::{cloud, read_as};
use crate::outcome::{Run, names};
use nalgebra::{Point3, Rotation3, Vector3};
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};
use superform::geometry::Superquadric;
use superform::geometry::palette::{UNASSIGNED_COLOR, color_of};
use superform::inference::{MergeReason, MergeReport, UNASSIGNED};
use superform::io::{
    self, ExportOptions, Exported, Format, Outcome, PhaseTimes, RunRecord, Shape, WriteError,
};

/// Points dealt to two primitives in turn, every third to none.
fn run_on(shape: Shape, points: usize) -> Run {
    Run::on(shape, points, &[4, 11, UNASSIGNED], |_| Superquadric {
        exponents: [0.1, 1.0 / 3.0],
        semi_axes: Vector3::new(1e-9, 2.0, 3e12),
        rotation: Rotation3::from_euler_angles(0.3, -1.2, 2.0),
        translation: Vector3::new(-1.5, 0.1, 1e7),
        taper: [-0.25, 0.5],
    })
}

fn cloud_run() -> Run {
    let text: String = (0..40)
        .map(|i| {
            if i == 7 {
                "nan 0 1\n".to_owned()
            } else {
                format!("{} {} 0.1\n", i % 8, f64::from(i / 8) * 1.1)
            }
        })
        .collect();
    run_on(read_as("grid.xyz", text).unwrap(), 12)
}

fn write(path: &Path, format: Format, outcome: &Outcome<'_>) -> Result<Exported, WriteError> {
    io::export(path, format, &ExportOptions::default(), outcome)
}

#[test]
fn the_segmented_cloud_holds_every_input_point_in_order() {
    let run = cloud_run();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("segmented.ply");
    write(&path, Format::CloudPly, &run.outcome()).unwrap();
    assert_eq!(names(folder.path()), ["segmented.ply"]);

    let mut file = fs::File::open(&path).unwrap();
    let ply = Parser::<DefaultElement>::new().read_ply(&mut file).unwrap();
    let vertices = &ply.payload["vertex"];
    let (input, _) = cloud(run.shape.clone());
    let map = run.cloud.sample_of_input.as_ref().unwrap();
    assert_eq!((vertices.len(), input.len()), (40, 40));
    for (i, (v, p)) in vertices.iter().zip(&input).enumerate() {
        for (name, c) in [("x", p.x), ("y", p.y), ("z", p.z)] {
            let Property::Double(read) = v[name] else { panic!("{name} is no double") };
            assert!(read.to_bits() == c.to_bits() || (read.is_nan() && c.is_nan()));
        }
        let expected = if i == 7 { UNASSIGNED } else { run.abstraction.labels[map[i] as usize] };
        let (label, color) = if expected == UNASSIGNED {
            (-1, UNASSIGNED_COLOR)
        } else {
            (expected as i32, color_of(expected))
        };
        assert_eq!(v["label"], Property::Int(label), "point {i}");
        for (name, c) in ["red", "green", "blue"].iter().zip(color) {
            assert_eq!(v[*name], Property::UChar(c));
        }
    }
    // And our own reader takes it as a cloud with these colours.
    let (points, colors) = cloud(io::read(&path).unwrap());
    assert_eq!(points[..7], input[..7]);
    assert_eq!(colors.unwrap()[7], UNASSIGNED_COLOR);
}

#[test]
fn for_a_mesh_the_samples_are_the_segmented_cloud() {
    let run = run_on(io::built_in().unwrap(), 200);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("segmented.ply");
    write(&path, Format::CloudPly, &run.outcome()).unwrap();
    assert_eq!(cloud(io::read(&path).unwrap()).0, run.cloud.points);
}

#[test]
fn primitives_come_back_to_the_last_bit() {
    let run = cloud_run();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("primitives.json");
    write(&path, Format::PrimitivesJson, &run.outcome()).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    assert_eq!(json["format"], "superform-primitives");
    assert_eq!(json["version"], 1);
    assert_eq!(json["seed"], 1);
    assert_eq!(json["params"]["alpha"], 0.5);
    let numbers = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect()
    };
    let list = json["primitives"].as_array().unwrap();
    assert_eq!(list.len(), 2);
    for (entry, primitive) in list.iter().zip(run.abstraction.primitives.iter()) {
        let shape = &primitive.shape;
        assert_eq!(entry["id"], primitive.id);
        assert_eq!(entry["points"], primitive.points);
        assert_eq!(entry["sigma"], primitive.sigma);
        assert_eq!(entry["mean_distance"], primitive.mean_distance);
        assert_eq!(numbers(&entry["eps"]), shape.exponents);
        assert_eq!(numbers(&entry["scale"]), shape.semi_axes.as_slice());
        assert_eq!(numbers(&entry["translation"]), shape.translation.as_slice());
        assert_eq!(numbers(&entry["taper"]), shape.taper);
        let rows: Vec<Vec<f64>> = entry["rotation"].as_array().unwrap().iter().map(numbers).collect();
        // Rows of world_from_local: the local x axis in the world is the first column.
        let x = shape.rotation * Vector3::x();
        assert_eq!([rows[0][0], rows[1][0], rows[2][0]], [x.x, x.y, x.z]);
    }
    let first = fs::read(&path).unwrap();
    write(&path, Format::PrimitivesJson, &run.outcome()).unwrap();
    assert_eq!(first, fs::read(&path).unwrap(), "the same run gives the same bytes");
}

#[test]
fn the_report_tells_how_the_run_went() {
    let run = cloud_run();
    let record = RunRecord {
        clusters: vec![5, 3, 2],
        merges: vec![MergeReport { merged: (4, 9), into: 4, reason: MergeReason::Energy { gain: 0.25 } }],
        times: PhaseTimes { read: std::time::Duration::from_millis(1500), ..Default::default() },
        home: None,
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("report.json");
    io::write_run(folder.path(), &[], &run.outcome(), &record).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    assert_eq!(json["input"]["name"], "grid.xyz");
    assert_eq!(json["input"]["kind"], "cloud");
    assert_eq!(json["input"]["points"], 40);
    assert_eq!(json["input"]["notes"].as_array().unwrap().len(), 1);
    assert_eq!(json["points"], 12);
    assert_eq!(json["iterations"], 2);
    assert_eq!(json["clusters_at_iteration"], serde_json::json!([5, 3, 2]));
    assert_eq!(json["merges"][0]["into"], 4);
    assert_eq!(json["unassigned_points"], 4);
    assert_eq!(json["seconds"]["read"], 1.5);
    assert_eq!(json["mean_distance"], 0.01);
    let labels = run.cloud.labels_of_input(&run.abstraction.labels, UNASSIGNED);
    let unassigned = labels.iter().filter(|&&l| l == UNASSIGNED).count();
    assert_eq!(json["unassigned_input_points"], unassigned);
}

#[test]
fn a_run_is_written_whole_or_not_at_all() {
    let run = cloud_run();
    let folder = tempfile::tempdir().unwrap();
    let new = folder.path().join("a/b");
    let record = RunRecord::default();
    let paths = io::write_run(&new, &[], &run.outcome(), &record).unwrap().files;
    assert!(paths.iter().all(|p| p.is_file()));
    assert_eq!(names(&new), ["primitives.json", "report.json", "segmented.ply"]);
    // Again, over what is there.
    let before = fs::read(&paths[1]).unwrap();
    io::write_run(&new, &[], &run.outcome(), &record).unwrap();
    assert_eq!(names(&new).len(), 3);

    // A primitive that can't be written: what was there stays, nothing is added.
    let mut broken = cloud_run();
    let mut primitives = broken.abstraction.primitives.to_vec();
    primitives[0].shape.semi_axes.x = f64::NAN;
    broken.abstraction.primitives = primitives.into();
    fs::write(&paths[0], "mine").unwrap();
    let error = io::write_run(&new, &[], &broken.outcome(), &record).unwrap_err().to_string();
    assert!(error.contains("primitives.json") && error.contains("primitive 4"), "{error}");
    assert_eq!(names(&new).len(), 3);
    assert_eq!(fs::read(&paths[0]).unwrap(), b"mine");
    assert_eq!(fs::read(&paths[1]).unwrap(), before);

    // The last of the three names is taken by a folder.
    let other = folder.path().join("other");
    fs::create_dir_all(other.join("report.json")).unwrap();
    assert!(io::write_run(&other, &[], &run.outcome(), &record).is_err());
    assert_eq!(names(&other), ["report.json"]);

    // A folder that can't be made, and one that was made for nothing.
    assert!(io::write_run(&paths[0], &[], &run.outcome(), &record).is_err());
    assert!(io::write_run(&folder.path().join("gone"), &[], &broken.outcome(), &record).is_err());
    assert!(!folder.path().join("gone").exists());
}

#[test]
fn labels_of_another_cloud_are_refused() {
    let run = run_on(io::built_in().unwrap(), 200);
    let other = cloud_run();
    let outcome = Outcome { cloud: &other.cloud, abstraction: &other.abstraction, ..run.outcome() };
    let folder = tempfile::tempdir().unwrap();
    // For a mesh the samples are the cloud; here they are short of the map's 40.
    assert!(write(&folder.path().join("a.ply"), Format::CloudPly, &outcome).is_err());
    assert!(names(folder.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn results_can_be_read_by_whom_the_umask_lets() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain");
    fs::write(&plain, "").unwrap();
    let path = folder.path().join("a.ply");
    write(&path, Format::CloudPly, &cloud_run().outcome()).unwrap();
    let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
    assert_eq!(mode(&path), mode(&plain));
}

#[test]
fn points_at_any_scale_survive_the_round_trip() {
    let text = "1e-300 -1e300 0.1\n450000.123456789 5400000.1 -0.0\n5e-324 1 2\n";
    let run = run_on(read_as("odd.xyz", text).unwrap(), 10);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    write(&path, Format::CloudPly, &run.outcome()).unwrap();
    let (points, _) = cloud(io::read(&path).unwrap());
    assert_eq!(points[0], Point3::new(1e-300, -1e300, 0.1));
    assert_eq!(points, cloud(run.shape).0);
}

#[test]
fn primitives_are_read_as_they_were_written() {
    let run = run_on(io::built_in().unwrap(), 300);
    let folder = tempfile::tempdir().unwrap();
    io::write_run(folder.path(), &[], &run.outcome(), &RunRecord::default()).unwrap();
    let back = io::read_primitives(folder.path()).unwrap();
    assert_eq!(back, io::read_primitives(&folder.path().join(io::PRIMITIVES_FILE)).unwrap());
    assert_eq!(back.primitives[..], run.abstraction.primitives[..]);
    assert_eq!((back.input.as_deref(), back.points, back.seed), (Some("built-in chair"), Some(300), Some(1)));
    assert!((back.unassigned_share().unwrap() - 1.0 / 3.0).abs() < 1e-12);
}
