//! The command `export`, and `run --export`: what the names say is written.

use std::path::Path;

use crate::process::{done, superform};
use superform::io::{self, Format};

fn ok(folder: &Path, args: &[&str]) -> String {
    done(folder, args).0
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

    // A mesh in parts needs the mesh, which the report leads to.
    ok(folder.path(), &["export", "out", "-o", "mesh.ply"]);
    std::fs::rename(at("out/report.json"), at("report.json")).unwrap();
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
        (&["export", "out", "-o", "x.docx"][..], "cannot tell the format of x.docx"),
        (&["export", "out", "-o", "x.ply", "--format", "word"], "word is not a format"),
        (&["export", "out", "-o", "x.ply", "--density", "0"], "density"),
        (&["export", "out"], "--output"),
        (&["run", "a.obj", "-o", "out", "--export", "x.docx"], "x.docx"),
    ] {
        let problem = refused(folder.path(), args, 2);
        assert!(problem.contains(words), "{problem}");
    }
    assert!(refused(folder.path(), &["export", "nowhere", "-o", "x.json"], 1).contains("nowhere"));
}

/// An input in millimetres gives a model in metres, meshes and all; what no
/// simulator can mean or take is told.
#[test]
fn robots_are_in_metres() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // A ball of 100 millimetres, and one of 60.
    let axes = |a: f64, x: f64| format!("1,1,{a},{a},{a},0,0,0,{x},0,0,0,0\n");
    std::fs::write(at("balls.csv"), axes(50.0, 0.0) + &axes(30.0, 200.0)).unwrap();
    let export = |name: &str, more: &[&str]| {
        let output = superform(folder.path(), &[&["export", "balls.csv", "-o", name], more].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        said
    };
    let masses = |name: &str| -> Vec<f64> {
        let text = std::fs::read_to_string(at(name)).unwrap();
        let masses = text.split("<mass value=\"").skip(1);
        masses.map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect()
    };
    let widths = |name: &str| {
        let superform::io::ShapeGeometry::Mesh(mesh) = io::read(&at(name)).unwrap().geometry else {
            panic!("{name} is no mesh")
        };
        let (low, high) = mesh.bounds().unwrap();
        high.x - low.x
    };
    let said = export("plain.urdf", &[]);
    assert!(said.contains("a mass of 6.4e8 kg") && said.contains("0.001 for millimetres"), "{said}");
    assert!(!export("robot.urdf", &["--unit", "mm"]).contains(" kg"));
    assert!(!export("same.urdf", &["--scale", "0.001"]).contains(" kg"));
    assert_eq!(masses("robot.urdf"), masses("same.urdf"));
    let ball = |radius: f64| 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    for (mass, expected) in masses("robot.urdf").into_iter().zip([ball(0.05), ball(0.03)]) {
        assert!((mass / expected - 1.0).abs() < 1e-9, "{mass} {expected}");
    }
    for mesh in ["primitive_0.stl", "primitive_0_collision.stl"] {
        let ratio = widths(&format!("robot_meshes/{mesh}")) / widths(&format!("plain_meshes/{mesh}"));
        assert!((ratio - 0.001).abs() < 1e-8, "{mesh}: {ratio}");
    }
    let said = export("tiny.xml", &["--scale", "1e-6"]);
    assert!(said.contains("MuJoCo rejects") && said.contains("a scale of 0.001"), "{said}");
    for args in [["--scale", "0"], ["--scale", "nan"], ["--unit", "parsec"]] {
        refused(folder.path(), &[&["export", "balls.csv", "-o", "x.urdf"], &args[..]].concat(), 2);
    }
}

/// What lies where results go: links, pipes, devices, the inputs themselves.
#[cfg(unix)]
mod places {
    use std::ffi::OsStr;
    use std::fs::{self, File};
    use std::io::Read as _;
    use std::os::unix::ffi::OsStrExt as _;
    use std::os::unix::fs::{FileTypeExt as _, PermissionsExt, symlink};
    use std::path::{Path, PathBuf};
    use std::process::{Command, Stdio};

    use tempfile::TempDir;

    use super::{ok, refused, superform};

    const QUICK: [&str; 6] = ["--points", "200", "--iterations", "2", "--clusters", "4"];

    /// A folder with a cloud and the result of a run on it in `out`.
    fn result() -> TempDir {
        let folder = tempfile::tempdir().unwrap();
        let points = (0..400).map(|i| format!("{} {} {}\n", i % 20, i / 20, 7 * (i % 3)));
        fs::write(folder.path().join("in.xyz"), points.collect::<String>()).unwrap();
        ok(folder.path(), &[&["run", "in.xyz", "-o", "out", "-q"], &QUICK[..]].concat());
        folder
    }

    #[test]
    fn one_file_goes_to_standard_output_and_nothing_else_does() {
        let folder = result();
        let at = |name: &str| folder.path().join(name);
        for (format, name) in [("json", "x.json"), ("npz", "x.npz"), ("cloud-ply", "cloud.ply")] {
            ok(folder.path(), &["export", "out", "-o", name]);
            let output =
                superform(folder.path(), &["export", "out", "-o", "-", "more.csv", "--format", format]);
            assert!(output.status.success());
            assert!(output.stdout == fs::read(at(name)).unwrap(), "{format}");
            let said = String::from_utf8(output.stderr).unwrap();
            assert!(said.contains("wrote more.csv") && !said.contains("wrote -"), "{said}");
        }
        // Where there is no place beside a file, an OBJ is without colours, and
        // a robot without a body.
        let output = superform(folder.path(), &["export", "out", "-o", "-", "--format", "surfaces-obj"]);
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.contains("\nf ") && !text.contains("mtllib"), "{text:.300}");
        assert!(String::from_utf8(output.stderr).unwrap().contains("colours"));
        let problem = refused(folder.path(), &["export", "out", "-o", "-", "--format", "urdf"], 1);
        assert!(problem.contains("give a file name"), "{problem}");
        let problem =
            refused(folder.path(), &["export", "out", "-o", "-", "/dev/fd/1", "--format", "csv"], 1);
        assert!(problem.contains("only one file"), "{problem}");
        for args in [
            &["run", "in.xyz", "-o", "-"][..],
            &["run", "in.xyz", "-o", "out.json"],
            &["bench", "in.xyz", "-o", "-"],
        ] {
            let problem = refused(folder.path(), args, 2);
            assert!(problem.contains("give a folder"), "{problem}");
        }
        assert!(!at("-").exists() && !at("out.json").exists() && !at("-.mtl").exists());
    }

    #[test]
    fn pipes_and_devices_are_written_through() {
        let folder = result();
        let at = |name: &str| folder.path().join(name);
        assert!(Command::new("mkfifo").arg(at("pipe.json")).status().unwrap().success());
        let reader = std::thread::spawn({
            let path = at("pipe.json");
            move || fs::read(path).unwrap()
        });
        ok(folder.path(), &["export", "out", "-o", "pipe.json"]);
        assert!(reader.join().unwrap() == fs::read(at("out/primitives.json")).unwrap());
        assert!(fs::symlink_metadata(at("pipe.json")).unwrap().file_type().is_fifo());
        // Through links of our own: were they replaced, the system's devices would still be there.
        symlink("/dev/null", at("null.json")).unwrap();
        ok(folder.path(), &["export", "out", "-o", "null.json"]);
        assert!(fs::symlink_metadata(at("null.json")).unwrap().is_symlink());
        if Path::new("/dev/full").exists() {
            symlink("/dev/full", at("full.json")).unwrap();
            let problem = refused(folder.path(), &["export", "out", "-o", "full.json"], 1);
            assert!(problem.contains("full.json") && problem.contains("free some space"), "{problem}");
            assert!(fs::symlink_metadata(at("full.json")).unwrap().is_symlink());
        }
        // What was there stays before what is appended.
        let log = File::options().append(true).create(true).open(at("log")).unwrap();
        std::io::Write::write_all(&mut &log, b"before\n").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_superform"));
        let args = ["export", "out", "-o", "/dev/fd/1", "--format", "csv"];
        assert!(command.args(args).current_dir(folder.path()).stdout(log).status().unwrap().success());
        let text = fs::read_to_string(at("log")).unwrap();
        assert!(text.starts_with("before\n") && text.lines().count() > 2, "{text}");
    }

    #[test]
    fn links_are_followed_and_permissions_kept() {
        let folder = result();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("deep")).unwrap();
        fs::write(at("deep/old.json"), "old").unwrap();
        fs::set_permissions(at("deep/old.json"), PermissionsExt::from_mode(0o640)).unwrap();
        symlink("deep/second", at("chain.json")).unwrap();
        symlink("old.json", at("deep/second")).unwrap();
        symlink("deep/new.json", at("dangling.json")).unwrap();
        symlink("deep", at("folder.json")).unwrap();
        ok(folder.path(), &["export", "out", "-o", "chain.json", "dangling.json"]);
        let expected = fs::read(at("out/primitives.json")).unwrap();
        for (link, target) in [("chain.json", "deep/old.json"), ("dangling.json", "deep/new.json")] {
            assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink());
            assert!(fs::symlink_metadata(at(target)).unwrap().is_file());
            assert!(fs::read(at(target)).unwrap() == expected, "{target}");
        }
        assert_eq!(fs::metadata(at("deep/old.json")).unwrap().permissions().mode() & 0o777, 0o640);
        let problem = refused(folder.path(), &["export", "out", "-o", "folder.json"], 1);
        assert!(problem.contains("a folder with this name exists"), "{problem}");
        let problem = refused(folder.path(), &["export", "out", "-o", "gone/x.json"], 1);
        assert!(problem.contains("the folder gone"), "{problem}");
        assert_eq!(fs::read_dir(at("deep")).unwrap().count(), 3, "nothing else is left there");
    }

    #[test]
    fn what_is_read_is_not_written_over() {
        let folder = result();
        let at = |name: &str| folder.path().join(name);
        fs::copy(at("out/segmented.ply"), at("copy.ply")).unwrap();
        fs::create_dir_all(at("hard/in")).unwrap();
        fs::create_dir_all(at("linked")).unwrap();
        fs::hard_link(at("copy.ply"), at("hard/segmented.ply")).unwrap();
        symlink("../copy.ply", at("linked/parts.ply")).unwrap();
        fs::hard_link(at("copy.ply"), at("hard/in/primitives.json")).unwrap();
        fs::write(at("jobs.csv"), "input,name\ncopy.ply,hard/in\n").unwrap();
        fs::copy(at("jobs.csv"), at("hard/jobs.csv")).unwrap();
        fs::hard_link(at("hard/jobs.csv"), at("hard/results.jsonl")).unwrap();
        fs::write(at("scene.gltf"), r#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "copy.ply"}]}"#)
            .unwrap();
        fs::create_dir(at("bench")).unwrap();
        fs::hard_link(at("in.xyz"), at("bench/table.md")).unwrap();
        let before = fs::read(at("copy.ply")).unwrap();
        let cloud = fs::read(at("in.xyz")).unwrap();
        for args in [
            &["run", "out/segmented.ply", "-o", "out"][..],
            &["run", "./out/../out/segmented.ply", "-o", "./out/"],
            &["run", "copy.ply", "-o", "hard"],
            &["run", "scene.gltf", "-o", "hard"],
            &["run", "copy.ply", "-o", "linked", "--export", "parts.ply"],
            &["run", "--manifest", "jobs.csv", "-o", "."],
            &["run", "--manifest", "hard/jobs.csv", "-o", "hard"],
            &["run", "copy.ply", "in.xyz", "-o", "hard", "--sweep", "seed=1", "--export", "../../parts.ply"],
            &["export", "out", "-o", "out/segmented.ply"],
            &["export", "out", "-o", "in.xyz"],
            &["export", "out/primitives.json", "-o", "new.csv", "out/report.json"],
            &["export", "out", "--shape", "copy.ply", "-o", "hard/segmented.ply"],
            &["bench", "in.xyz", "-o", "bench"],
            &["bench", "in.xyz", "--compare", "bench/table.csv", "-o", "bench"],
        ] {
            if args.contains(&"bench/table.csv") {
                fs::remove_file(at("bench/table.md")).unwrap();
                fs::write(at("bench/table.csv"), "name,primitives,chamfer_l1,iou\nin,3,0.1,\n").unwrap();
            }
            if args.contains(&"../../parts.ply") {
                fs::hard_link(at("copy.ply"), at("parts.ply")).unwrap();
                fs::create_dir_all(at("hard/copy/seed=1")).unwrap();
                fs::hard_link(at("copy.ply"), at("hard/copy/seed=1/segmented.ply")).unwrap();
            }
            let problem = refused(folder.path(), args, 1);
            assert!(problem.contains("this would overwrite the input"), "{args:?}: {problem}");
        }
        assert!(fs::read(at("copy.ply")).unwrap() == before && fs::read(at("in.xyz")).unwrap() == cloud);
        assert!(!at("new.csv").exists() && !at("bench/runs.jsonl").exists());
    }

    #[test]
    fn lost_output_is_a_failure() {
        let folder = result();
        let has_full = Path::new("/dev/full").exists();
        for args in [
            &["evaluate", "out", "--reference", "in.xyz", "--samples", "1000", "--json"][..],
            &["evaluate", "out", "--reference", "in.xyz", "--samples", "1000"],
            &["export", "--list"],
            &["export", "out", "-o", "again.json"],
            &["export", "out", "-o", "-", "--format", "json"],
            &["completions", "bash"],
            &["man"],
            &["man", "-o", "pages"],
            &["--help"],
            &["run", "-h"],
            &["--version"],
            &["merge-results", "batch"],
            &["run", "in.xyz", "-o", "batch", "--sweep", "points=200"],
            &["run", "in.xyz", "-o", "once", "--points", "200"],
            &["bench", "in.xyz", "--points", "200", "--seeds", "1"],
        ] {
            if args[0] == "merge-results" {
                let quick = ["--sweep", "points=200", "--iterations", "1", "-q"];
                ok(folder.path(), &[&["run", "in.xyz", "-o", "batch"], &quick[..]].concat());
            }
            let run = |stdout: Stdio| {
                let mut command = Command::new(env!("CARGO_BIN_EXE_superform"));
                command.args(args).current_dir(folder.path()).env_remove("RUST_LOG").stdout(stdout);
                let output = command.stderr(Stdio::piped()).output().unwrap();
                (output.status.code(), String::from_utf8(output.stderr).unwrap())
            };
            if has_full {
                let (code, said) = run(File::options().write(true).open("/dev/full").unwrap().into());
                assert_eq!(code, Some(1), "{args:?}: {said}");
                assert!(said.contains("standard output: "), "{args:?}: {said}");
                assert!(said.contains("No space left") || said.contains("disk is full"), "{args:?}: {said}");
            }
            let (reader, writer) = std::io::pipe().unwrap();
            drop(reader);
            let (code, said) = run(writer.into());
            assert_eq!(code, Some(1), "{args:?}: {said}");
            assert!(!said.contains("pipe"), "{args:?}: {said}");
            // And all is well where it arrives.
            let (mut reader, writer) = std::io::pipe().unwrap();
            let read = std::thread::spawn(move || reader.read_to_end(&mut Vec::new()).unwrap());
            let (code, said) = run(writer.into());
            assert_eq!(code, Some(0), "{args:?}: {said}");
            assert!(read.join().unwrap() > 0, "{args:?}");
        }
    }

    /// Not on macOS, whose file systems take no such names.
    #[cfg(target_os = "linux")]
    #[test]
    fn names_need_not_be_text() {
        let folder = result();
        let name = |text: &str| -> PathBuf { OsStr::from_bytes(&[text.as_bytes(), b"\xfc"].concat()).into() };
        let at = |path: PathBuf| folder.path().join(path);
        let run = |args: &[&OsStr]| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_superform"));
            command.args(args).args(QUICK).current_dir(folder.path());
            let output = command.output().unwrap();
            (output.status.code(), String::from_utf8(output.stderr).unwrap())
        };
        let export = |args: &[&OsStr]| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_superform"));
            let output = command.args(args).current_dir(folder.path()).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        };
        let shapes = name("shapes");
        fs::create_dir(at(shapes.clone())).unwrap();
        let (a, b) = (at(shapes.join(name("a"))), at(shapes.join(name("b").with_extension("xyz"))));
        for path in [&a, &b] {
            fs::copy(folder.path().join("in.xyz"), path).unwrap();
        }
        let word = OsStr::new;
        let out = name("results");
        let (code, said) = run(&[word("run"), a.as_os_str(), word("-o"), out.as_os_str()]);
        assert_eq!(code, Some(0), "{said}");
        let stored = superform::io::read_primitives(&at(out.clone())).unwrap();
        let shape = superform::io::open_result(stored, None).unwrap().shape;
        assert_eq!(shape.path.as_deref(), Some(a.as_path()), "the report leads to the input");
        let mut obj = at(name("x"));
        obj.add_extension("obj");
        export(&[word("export"), out.as_os_str(), word("-o"), obj.as_os_str()]);
        let text = fs::read_to_string(&obj).unwrap();
        let materials = text.lines().find_map(|line| line.strip_prefix("mtllib ")).unwrap();
        assert!(folder.path().join(materials).is_file(), "{materials}");
        // As a pattern and as a folder, in a batch.
        for (input, batch) in [(shapes.join("*"), name("p")), (shapes, name("f"))] {
            let (code, said) =
                run(&[word("run"), input.as_os_str(), word("-o"), batch.as_os_str(), word("--jobs=1")]);
            assert_eq!(code, Some(0), "{said}");
            let table = fs::read_to_string(at(batch.join("results.csv"))).unwrap();
            assert!(table.contains(",ok,"), "{table}");
            let (code, said) = run(&[word("run"), input.as_os_str(), word("-o"), batch.as_os_str()]);
            assert!(code == Some(0) && said.contains("were already done"), "{said}");
        }
        // No command, and no panic.
        let (code, said) = run(&[word("runn"), a.as_os_str(), b.as_os_str()]);
        assert_eq!(code, Some(2), "{said}");
    }
}
