//! Every format of the registry: written, and what we read ourselves read
//! back. What others make of the files is `python_read_back.rs`.

use std::fs;
use std::path::Path;

use crate::common::{cloud, read_as};
use crate::outcome::{Run, names};
use nalgebra::{Rotation3, Vector3};
use superform::geometry::Superquadric;
use superform::geometry::palette::Colors;
use superform::inference::UNASSIGNED;
use superform::io::{self, ExportOptions, Format, Kind, Opened, RunRecord, Shape};

/// Samples dealt to three primitives and none in turn.
fn run_on(shape: Shape, points: usize) -> Run {
    Run::on(shape, points, &[4, 0, UNASSIGNED, 11], |id| Superquadric {
        exponents: [0.1 + f64::from(id) / 10.0, 1.0 / 3.0],
        semi_axes: Vector3::new(0.25, 2.0, 1.0 + f64::from(id)),
        rotation: Rotation3::from_euler_angles(0.3, -1.2, f64::from(id)),
        translation: Vector3::new(-1.5, 0.1, 1e3),
        taper: [-0.25, 0.5],
    })
}

fn cloud_run() -> Run {
    let text: String = (0..400)
        .map(|i| {
            if i == 7 {
                "nan 0 1 9 9 9\n".to_owned()
            } else {
                format!("{} {} 0.1 {} 20 30\n", i % 8, f64::from(i / 8) * 1.1, i % 256)
            }
        })
        .collect();
    run_on(read_as("grid.xyz", text).unwrap(), 120)
}

#[test]
fn every_format_is_written_and_about_as_large_as_was_said() {
    let runs = [cloud_run(), run_on(io::built_in().unwrap(), 2000)];
    for format in Format::ALL {
        for (run, is_mesh) in runs.iter().zip([false, true]) {
            for binary in [true, false] {
                let folder = tempfile::tempdir().unwrap();
                let path = folder.path().join(format!("a.{}", format.ending()));
                let options = ExportOptions { binary, ..ExportOptions::default() };
                let written = io::export(&path, format, &options, &run.outcome());
                if format.needs_mesh() && !is_mesh {
                    assert!(written.unwrap_err().to_string().contains("needs a mesh"));
                    assert!(names(folder.path()).is_empty());
                    continue;
                }
                let written = written.unwrap();
                assert_eq!(written.files[0], path, "{format}");
                let size: u64 = written.files.iter().map(|f| fs::metadata(f).unwrap().len()).sum();
                let said = io::estimated_size(format, &options, &run.outcome());
                // How far an archive shrinks depends on what is in it.
                let least = if format.ending() == "npz" { 0 } else { said / 2 };
                assert!((least..2 * said).contains(&size), "{format}: {size} bytes, said were {said}");
                // The same result gives the same bytes.
                let first: Vec<_> = written.files.iter().map(|f| fs::read(f).unwrap()).collect();
                let again = io::export(&path, format, &options, &run.outcome()).unwrap();
                assert!(again.files.iter().zip(&first).all(|(f, bytes)| fs::read(f).unwrap() == *bytes));
            }
        }
    }
}

#[test]
fn all_forms_of_the_cloud_hold_the_same() {
    let run = cloud_run();
    let folder = tempfile::tempdir().unwrap();
    let (input, _) = cloud(run.shape.clone());
    for (name, binary) in [("a.ply", true), ("b.ply", false), ("c.csv", true), ("d.xyz", true)] {
        let path = folder.path().join(name);
        let format = Format::from_path(&path, Some(Kind::Cloud)).unwrap();
        let options = ExportOptions { binary, ..ExportOptions::default() };
        io::export(&path, format, &options, &run.outcome()).unwrap();
        let (points, colors) = cloud(io::read(&path).unwrap());
        assert_eq!(points.len(), input.len(), "{name}");
        for (a, b) in points.iter().zip(&input).flat_map(|(p, q)| p.iter().zip(q.iter())) {
            assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "{name}: {a} {b}");
        }
        let labels = run.cloud.labels_of_input(&run.abstraction.labels, UNASSIGNED);
        for (color, &label) in colors.unwrap().iter().zip(&labels) {
            let expected = if label == UNASSIGNED { [138; 3] } else { run.colors.of(label) };
            assert_eq!(*color, expected, "{name}");
        }
    }
}

#[test]
fn primitives_come_back_from_each_form() {
    let run = cloud_run();
    let folder = tempfile::tempdir().unwrap();
    let options = ExportOptions::default();
    for name in ["p.json", "p.npz", "p.csv"] {
        let path = folder.path().join(name);
        let format = Format::from_path(&path, None).unwrap();
        io::export(&path, format, &options, &run.outcome()).unwrap();
        let back = io::read_primitives(&path).unwrap();
        assert_eq!(back.notes, [] as [&str; 0]);
        assert_eq!(back.primitives.len(), 3);
        for (p, q) in back.primitives.iter().zip(run.abstraction.primitives.iter()) {
            assert_eq!(p.id, q.id);
            if name == "p.csv" {
                let turned = (p.shape.rotation.matrix() - q.shape.rotation.matrix()).amax();
                assert!(turned < 1e-15 * 4.0, "{turned}");
                let same = Superquadric { rotation: q.shape.rotation, ..p.shape };
                assert_eq!(same, q.shape);
                assert_eq!(back.points, None);
            } else {
                assert_eq!(p, q, "{name}");
                assert_eq!(back.points, Some(120));
                assert_eq!(back.input.as_deref(), Some("grid.xyz"));
            }
        }
        // Written from what was read, it is the same file but for the samples.
        let again = folder.path().join(format!("again-{name}"));
        let colors = Colors::default();
        io::export_primitives(&again, format, &options, &back.set(&colors)).unwrap();
        let back_again = io::read_primitives(&again).unwrap();
        for (p, q) in back_again.primitives.iter().zip(&back.primitives) {
            // Angles are rounded anew.
            let turned = (p.shape.rotation.matrix() - q.shape.rotation.matrix()).amax();
            assert!(p.id == q.id && turned < 1e-15, "{turned}");
        }
        if name == "p.json" {
            assert_eq!(fs::read(&again).unwrap(), fs::read(&path).unwrap());
        }
        // A pasted text is as good as a file.
        if name != "p.npz" {
            let text = io::primitives_text(format, &(&run.outcome()).into()).unwrap();
            assert_eq!(text.as_bytes(), fs::read(&path).unwrap());
            let pasted = io::parse_primitives(text.as_bytes(), Path::new("the clipboard"), None).unwrap();
            assert_eq!(pasted.primitives, back.primitives);
        }
    }
    assert!(io::primitives_text(Format::PrimitivesNpz, &(&run.outcome()).into()).is_err());
    let cloud = folder.path().join("a.ply");
    let colors = Colors::default();
    let stored = io::read_primitives(&folder.path().join("p.json")).unwrap();
    let problem =
        io::export_primitives(&cloud, Format::CloudPly, &options, &stored.set(&colors)).unwrap_err();
    assert!(problem.to_string().contains("only primitives are available"), "{problem}");
}

#[test]
fn several_exports_are_written_together_or_not_at_all() {
    let run = cloud_run();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/out");
    let write = |list: &[&str]| {
        let list: Vec<String> = list.iter().map(|n| (*n).to_owned()).collect();
        io::write_run(&out, &list, &run.outcome(), &RunRecord::default())
    };
    let problem = write(&["a.csv", "b.docx"]).unwrap_err();
    assert!(problem.to_string().contains("b.docx"), "{problem}");
    assert!(names(folder.path()).is_empty());
    let list = ["segmented.npz", "primitives.npz", "p.csv"];
    let written = write(&list).unwrap();
    assert_eq!(written.files[3..], list.map(|n| out.join(n)));
    assert_eq!(names(&out).len(), 6);
}

#[test]
fn whatever_is_opened_is_told_from_its_name_and_content() {
    let run = cloud_run();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    io::write_run(&at("out"), &["primitives.npz".to_owned()], &run.outcome(), &RunRecord::default()).unwrap();
    let told = |path: &Path| match io::open(path) {
        Ok(Opened::Shape(shape)) => shape.name,
        Ok(Opened::Result(result)) => format!("{} primitives", result.stored.primitives.len()),
        Ok(Opened::Session(path)) => format!("session {}", path.file_name().unwrap().display()),
        Err(error) => panic!("{error}"),
    };
    assert_eq!(told(&at("out")), "3 primitives");
    assert_eq!(told(&at("out/primitives.json")), "3 primitives");
    assert_eq!(told(&at("out/segmented.ply")), "segmented.ply");
    // Whether it is there is for its reader to say.
    assert_eq!(told(&at("gone.Superform")), "session gone.Superform");
    // A folder may be called like a session, and hold primitives in any form.
    fs::remove_file(at("out/primitives.json")).unwrap();
    fs::rename(at("out"), at("out.superform")).unwrap();
    assert_eq!(told(&at("out.superform")), "3 primitives");
    fs::create_dir(at("empty")).unwrap();
    assert!(io::open(&at("empty")).unwrap_err().to_string().contains("not a file"));
}
