//! The command `export`, and `run --export`: what the names say is written.

use std::path::Path;
use std::process::{Command, Output};

use superform::io::{self, Format};

fn superform(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_superform"))
        .args(args)
        .current_dir(folder)
        .env_remove("RUST_LOG")
        .output()
        .unwrap()
}

fn ok(folder: &Path, args: &[&str]) -> String {
    let output = superform(folder, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(folder: &Path, args: &[&str], code: i32) -> String {
    let output = superform(folder, args);
    assert_eq!(output.status.code(), Some(code), "{args:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_result_is_written_in_other_forms() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let chair = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/chair.obj").display().to_string();
    let small = ["--points", "300", "--iterations", "2", "--clusters", "4"];
    let more = ["--export", "segmented.csv,robot.xml"];
    let said = ok(folder.path(), &[&["run", &chair, "-o", "out"], &small[..], &more].concat());
    assert!(
        said.contains("robot.xml") && at("out/segmented.csv").is_file() && at("out/robot_meshes").is_dir()
    );

    let names = ["cloud.npz", "primitives.npz", "chair.csv", "again.json", "robot.urdf"];
    let said = ok(folder.path(), &[&["export", "out", "-o"], &names[..]].concat());
    assert!(names.iter().all(|name| said.contains(&format!("wrote {name}")) && at(name).is_file()));
    let stored = io::read_primitives(&at("out")).unwrap();
    assert_eq!(
        std::fs::read(at("again.json")).unwrap(),
        std::fs::read(at("out/primitives.json")).unwrap(),
        "nothing is lost on the way through"
    );
    for name in ["primitives.npz", "chair.csv"] {
        let back = io::read_primitives(&at(name)).unwrap();
        assert_eq!(back.primitives.len(), stored.primitives.len());
        assert!(back.primitives.iter().zip(&stored.primitives).all(|(a, b)| a.id == b.id));
    }

    // A mesh in parts needs the mesh.
    assert!(refused(folder.path(), &["export", "out", "-o", "mesh.ply"], 1).contains("--shape"));
    ok(folder.path(), &["export", "out", "--shape", &chair, "-o", "mesh.ply", "b.glb"]);
    assert!(io::read(&at("mesh.ply")).is_ok() && io::read(&at("b.glb")).is_ok());
    // From primitives alone there are no points.
    let problem = refused(folder.path(), &["export", "chair.csv", "-o", "segmented.ply"], 1);
    assert!(problem.contains("only primitives"), "{problem}");
}

#[test]
fn the_list_holds_every_format_and_odd_names_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let list = ok(folder.path(), &["export", "--list"]);
    for format in Format::ALL {
        assert!(list.lines().any(|line| line.trim_start().starts_with(format.name())), "{format}");
    }
    for (args, words) in [
        (&["export", "out", "-o", "x.docx"][..], "x.docx does not tell its format"),
        (&["export", "out", "-o", "x.ply", "--format", "word"], "word is no format"),
        (&["export", "out", "-o", "x.ply", "--density", "0"], "density"),
        (&["export", "out"], "--output"),
        (&["run", "a.obj", "-o", "out", "--export", "x.docx"], "x.docx"),
    ] {
        let problem = refused(folder.path(), args, 2);
        assert!(problem.contains(words), "{problem}");
    }
    assert!(refused(folder.path(), &["export", "nowhere", "-o", "x.json"], 1).contains("nowhere"));
}
