//! The program as a person or a script runs it.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::process::{stderr, superform};

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Settings that make a run short.
const QUICK: [&str; 6] = ["--points", "400", "--iterations", "3", "--clusters", "6"];

/// A box of points with a leg, and one point that is none.
fn write_cloud(path: &Path) {
    let mut text = String::new();
    for i in 0..16 {
        for j in 0..16 {
            for z in [0.0, 0.3] {
                text.push_str(&format!("{} {} {z}\n", f64::from(i) * 0.1, f64::from(j) * 0.1));
            }
        }
    }
    for i in 0..200 {
        let angle = f64::from(i) * 2.4;
        text.push_str(&format!("{} {} {}\n", 0.1 * angle.cos(), 0.1 * angle.sin(), -0.01 * f64::from(i)));
    }
    text.push_str("nan 0 0\n");
    fs::write(path, text).unwrap();
}

#[test]
fn a_run_writes_its_three_files() {
    let folder = tempfile::tempdir().unwrap();
    write_cloud(&folder.path().join("in.xyz"));
    let output = superform(
        folder.path(),
        &[&["run", "in.xyz", "-o", "out", "--seed", "7", "--alpha", "0.4"], &QUICK[..]].concat(),
    );
    assert!(output.status.success(), "{}", stderr(&output));
    let summary = String::from_utf8(output.stdout).unwrap();
    assert!(
        summary.contains("cloud of 713 points, 400 samples") && summary.contains("primitives.json"),
        "{summary}"
    );
    // No progress bar where nobody looks on.
    assert!(!summary.contains('\u{1b}') && !summary.contains('█'));

    let out = folder.path().join("out");
    let report = json(&out.join("report.json"));
    assert_eq!(report["iterations"], 3);
    assert_eq!(report["points"], 400);
    assert_eq!(report["seed"], 7);
    assert_eq!(report["params"]["alpha"], 0.4);
    let clusters = report["clusters_at_iteration"].as_array().unwrap();
    assert_eq!((clusters.len(), clusters[0].as_u64()), (4, Some(6)));
    let primitives = json(&out.join("primitives.json"));
    let primitives = primitives["primitives"].as_array().unwrap();
    assert_eq!(report["primitives"], primitives.len());
    assert!(!primitives.is_empty());
    // Labels are ids of the primitives or −1, for every input point.
    let (labels, ids) = (labels(&out.join("segmented.ply")), ids(primitives));
    assert_eq!(labels.len(), 713);
    assert!(labels.iter().all(|l| *l == -1 || ids.contains(l)));
    assert_eq!(labels[712], -1, "a point that is not finite gets no label");
}

/// A box in a closed box: four fifths of the area can be seen.
fn write_nested_boxes(path: &Path) {
    let mut text = String::new();
    for half in [1.0, 0.5] {
        for i in 0..8 {
            let side = |k: usize| if i >> k & 1 == 1 { half } else { -half };
            text.push_str(&format!("v {} {} {}\n", side(0), side(1), side(2)));
        }
    }
    for first in [1, 9] {
        for face in [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]] {
            let [a, b, c, d] = face.map(|i| i + first);
            text.push_str(&format!("f {a} {b} {c} {d}\n"));
        }
    }
    fs::write(path, text).unwrap();
}

#[test]
fn the_report_tells_what_of_a_mesh_was_left_out() {
    let folder = tempfile::tempdir().unwrap();
    write_nested_boxes(&folder.path().join("in.obj"));
    let run = |out: &str, more: &[&str]| {
        let args = [&["run", "in.obj", "-o", out], &QUICK[..], more].concat();
        let output = superform(folder.path(), &args);
        assert!(output.status.success(), "{}", stderr(&output));
        let out = folder.path().join(out);
        assert_eq!(labels(&out.join("segmented.ply")).len(), 400);
        (String::from_utf8(output.stdout).unwrap(), json(&out.join("report.json"))["surface"].clone())
    };
    let (summary, surface) = run("outside", &[]);
    assert!(summary.contains("20 % of the surface is not visible from outside"), "{summary}");
    assert_eq!((&surface["asked_for"], &surface["sampled"]), (&"outside".into(), &"outside".into()));
    assert!((surface["area_left_out"].as_f64().unwrap() - 0.2).abs() < 0.01, "{surface}");

    let (summary, surface) = run("all", &["--surface", "all"]);
    assert!(!summary.contains("left out"), "{summary}");
    assert_eq!((&surface["sampled"], &surface["area_left_out"]), (&"all".into(), &0.0.into()));

    write_cloud(&folder.path().join("in.xyz"));
    let output = superform(folder.path(), &[&["run", "in.xyz", "-o", "cloud"], &QUICK[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(json(&folder.path().join("cloud/report.json"))["surface"].is_null());
}

fn ids(primitives: &[serde_json::Value]) -> Vec<i32> {
    primitives.iter().map(|p| p["id"].as_i64().unwrap() as i32).collect()
}

/// Labels of a segmented cloud, by another's reader.
fn labels(path: &Path) -> Vec<i32> {
    use ply_rs_bw::ply::{DefaultElement, Property};
    let parser = ply_rs_bw::parser::Parser::<DefaultElement>::new();
    let ply = parser.read_ply(&mut fs::File::open(path).unwrap()).unwrap();
    ply.payload["vertex"]
        .iter()
        .map(|v| match v["label"] {
            Property::Int(label) => label,
            _ => panic!("the label is no int"),
        })
        .collect()
}

#[test]
fn every_method_runs_and_says_which_it_was() {
    let folder = tempfile::tempdir().unwrap();
    write_cloud(&folder.path().join("in.xyz"));
    for (method, algorithm) in [
        ("default", "sampler"),
        ("paper", "sampler"),
        ("without-merge", "sampler"),
        ("kmeans", "kmeans"),
        ("ems", "ems"),
        ("hierarchical-ems", "hierarchical-ems"),
    ] {
        let mut args = vec!["run", "in.xyz", "-o", method, "--points", "400", "--method", method];
        if algorithm == "sampler" {
            args.extend(["--iterations", "3"]);
        }
        let output = superform(folder.path(), &args);
        assert!(output.status.success(), "{method}: {}", stderr(&output));
        let out = folder.path().join(method);
        let primitives = json(&out.join("primitives.json"));
        for file in [&json(&out.join("report.json")), &primitives] {
            assert_eq!(file["method"], method);
            assert_eq!(file["params"]["algorithm"], algorithm);
        }
        let primitives = primitives["primitives"].as_array().unwrap();
        let summary = String::from_utf8(output.stdout).unwrap();
        assert_eq!(summary.contains("\n1 primitive, "), primitives.len() == 1, "{summary}");
        assert_eq!(primitives.len() == 1, method == "ems", "{method} gave {}", primitives.len());
        let (labels, ids) = (labels(&out.join("segmented.ply")), ids(primitives));
        assert!(labels.iter().all(|l| *l == -1 || ids.contains(l)));
    }
    // What is tuned is still the method, what is combined anew is none.
    let args = [&["run", "in.xyz", "-o", "own", "--no-merge"], &QUICK[..]].concat();
    assert!(superform(folder.path(), &args).status.success());
    assert!(json(&folder.path().join("own/report.json"))["method"].is_null());
}

#[test]
fn the_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    write_cloud(&folder.path().join("in.xyz"));
    let run = |out: &str, threads: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_superform"))
            .args(["run", "in.xyz", "-o", out])
            .args(QUICK)
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        ["primitives.json", "segmented.ply"].map(|f| fs::read(folder.path().join(out).join(f)).unwrap())
    };
    assert_eq!(run("one", "1"), run("two", "2"));
}

#[test]
fn bad_input_gives_one_clear_message_and_no_files() {
    let folder = tempfile::tempdir().unwrap();
    for (name, content, words) in [
        ("empty.ply", "", "is empty"),
        ("broken.obj", "v 0 0 0\nv a b c\n", "line 2"),
        ("mesh.stl", "solid x\nfacet normal 0 0 1\n", "line 2: a facet is incomplete"),
        ("scan.pcd", "# .PCD v0.7\n", "line 2"),
        ("scan.e57", "ASTM-E57 and more", "an E57 point cloud"),
        ("letter.doc", "Dear all", "is a document, which cannot be read"),
        ("letter", "Dear all", "unknown format"),
        ("one.xyz", "1 2 3\n", "one.xyz"),
        ("nan.xyz", "nan nan nan\n", "finite"),
    ] {
        fs::write(folder.path().join(name), content).unwrap();
        let output = superform(folder.path(), &["run", name, "-o", "out"]);
        assert_eq!(output.status.code(), Some(1), "{name}");
        let message = stderr(&output);
        assert!(message.contains(words) && message.lines().count() == 1, "{message}");
        assert!(output.stdout.is_empty());
        assert!(!folder.path().join("out").exists());
    }
    for (input, words) in [
        ("missing.obj", "missing.obj: file or folder not found; check the name"),
        ("one.xyz/a.obj", "part of its path is a file, not a folder; check the path"),
    ] {
        let output = superform(folder.path(), &["run", input, "-o", "out"]);
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
}

#[test]
fn a_run_that_finds_nothing_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let points =
        |i: u32| [0.618_034, 0.754_877, 0.569_840].map(|step| (f64::from(i) * step).fract().to_string());
    let text: String = (0..30).map(|i| points(i).join(" ") + "\n").collect();
    fs::write(folder.path().join("few.xyz"), &text).unwrap();
    fs::write(folder.path().join("fewer.xyz"), &text).unwrap();
    let run = |inputs: &[&str]| {
        superform(folder.path(), &[&["run"], inputs, &["-o", "out", "--method", "hierarchical-ems"]].concat())
    };
    let words = "no primitives were found for the 30 samples; use a shape with more points";
    let output = run(&["few.xyz"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains(words), "{}", stderr(&output));
    assert!(output.stdout.is_empty() && !folder.path().join("out").exists());
    // One of many fails as many do.
    let output = run(&["few.xyz", "fewer.xyz"]);
    assert_eq!(output.status.code(), Some(12));
    assert!(stderr(&output).contains(words), "{}", stderr(&output));
}

#[test]
fn an_output_that_is_no_folder_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    write_cloud(&folder.path().join("in.xyz"));
    let output = superform(folder.path(), &["run", "in.xyz", "-o", "in.xyz"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("in.xyz is not a folder"));
}

#[test]
fn a_command_line_that_makes_no_sense_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (args, words) in [
        (&["run"][..], "required"),
        (&["run", "a.obj"], "--output"),
        (&["--points", "many"], "many"),
        (&["run", "a.obj", "-o", "out", "--alpha", "-3"], "alpha is -3, but must be between"),
        (&["--preset", "best"], "paper"),
        (&["--method", "best"], "hierarchical-ems"),
        (&["run", "a.obj", "-o", "out", "--method", "kmeans", "--p0", "1"], "does not use --p0"),
        (&["run", "a.obj", "-o", "out", "--seen-from", "above"], "auto, all, one-side"),
        (
            &["run", "a.obj", "-o", "out", "--method", "kmeans", "--seen-from", "all"],
            "does not use --seen-from",
        ),
        (&["run", "a.obj", "-o", "out", "--viewpoint", "1,2"], "three numbers separated by commas"),
        (&["run", "a.obj", "-o", "out", "--viewpoint", "1,2,inf"], "three numbers separated by commas"),
        (
            &["run", "a.obj", "-o", "out", "--viewpoint", "-1,2,0", "--seen-from", "all"],
            "--seen-from all does not use --viewpoint",
        ),
        (&["run", "a.obj", "-o", "out", "--viewpoint", "1,2,3", "--method", "kmeans"], "not use --viewpoint"),
        (&["run", "a.obj", "b.obj", "-o", "out", "--viewpoint", "1,2,3"], "--viewpoint belongs to one shape"),
        (&["--seed", "-1"], "'-1' for '--seed <S>': expected a non-negative whole number"),
        (&["--p0", "1e300"], "p0 is 1e300, but must be between 1e-6 and 10"),
        (&["runn", "a.obj"], "runn is neither a command nor an existing file"),
        (&["--screenshot", "a.png", "--headless"], "cannot be used with"),
    ] {
        let output = superform(folder.path(), args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn without_a_display_the_job_is_done_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let output = superform(folder.path(), &QUICK);
    assert!(output.status.success(), "{}", stderr(&output));
    let message = stderr(&output);
    assert!(message.contains("without a window, writing results to ./superform-out"), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    let report = json(&folder.path().join("superform-out/report.json"));
    assert_eq!(report["input"]["name"], "built-in chair");
    assert!(folder.path().join("superform-out/segmented.ply").is_file());
}

#[cfg(all(unix, not(target_os = "macos")))]
#[test]
fn a_display_that_does_not_answer_is_no_display() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_superform"))
        .args(QUICK)
        .current_dir(folder.path())
        .env("DISPLAY", ":54321")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let message = stderr(&output);
    assert!(message.contains("running without a window") && message.lines().count() == 1, "{message}");
    assert!(folder.path().join("superform-out/primitives.json").is_file());
}

#[test]
fn without_a_display_there_is_no_screenshot() {
    let folder = tempfile::tempdir().unwrap();
    let output = superform(folder.path(), &["--screenshot", "shot.png"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("a screenshot needs a window"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Ctrl-C in the middle: the run says so and leaves nothing.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_nothing() {
    use std::io::Read;
    use std::process::Stdio;

    let folder = tempfile::tempdir().unwrap();
    write_cloud(&folder.path().join("in.xyz"));
    // A note about the input goes to standard error once it has been read:
    // from then on the run is under way, with 500 iterations to go.
    let mut child = Command::new(env!("CARGO_BIN_EXE_superform"))
        .args(["run", "in.xyz", "-o", "out", "--iterations", "500", "--clusters", "30", "--no-merge"])
        .current_dir(folder.path())
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut errors = child.stderr.take().unwrap();
    let mut first = [0; 10];
    errors.read_exact(&mut first).unwrap();
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    let mut rest = String::new();
    errors.read_to_string(&mut rest).unwrap();
    assert!(rest.contains("nothing was written"), "{rest}");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn the_report_tells_from_where_the_shape_was_seen() {
    let folder = tempfile::tempdir().unwrap();
    write_cloud(&folder.path().join("in.xyz"));
    let run = |out: &str, more: &[&str]| {
        let args = [&["run", "in.xyz", "-o", out], &QUICK[..], more].concat();
        let output = superform(folder.path(), &args);
        assert!(output.status.success(), "{}", stderr(&output));
        let report = json(&folder.path().join(out).join("report.json"));
        (String::from_utf8(output.stdout).unwrap(), report["seen_from"].clone())
    };
    let (summary, seen_from) = run("all", &["--seen-from", "all"]);
    assert_eq!(seen_from, "all-sides");
    assert!(!summary.contains("seen from"), "{summary}");

    let (summary, seen_from) = run("given", &["--viewpoint", "-3,0.5,9", "--viewpoint", "0,0,-9"]);
    assert_eq!(seen_from, serde_json::json!({ "given": { "viewpoints": 2 } }));
    assert!(summary.contains("seen from 2 viewpoints"), "{summary}");

    let (summary, seen_from) = run("side", &["--seen-from", "one-side"]);
    assert!(summary.contains("seen from one side only"), "{summary}");
    let (place, direction) = (&seen_from["found-place"], &seen_from["found-direction"]);
    let found = [&place["viewpoint"], &direction["towards"]].into_iter().filter_map(|v| v.as_array());
    assert_eq!(found.map(Vec::len).collect::<Vec<_>>(), [3], "{seen_from}");
}

#[test]
fn the_report_tells_how_many_points_of_a_cloud_were_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut text: String = (0..900).map(|i| format!("{} {} 0\n", i % 30, i / 30)).collect();
    // Nine points far above the square, in a place of their own each.
    text.extend((0..9).map(|i| format!("{} {} {}\n", 10 * (i % 3), 10 * (i / 3), 12 + 7 * (i % 2))));
    fs::write(folder.path().join("in.xyz"), text).unwrap();
    let run = |out: &str, more: &[&str]| {
        let args = [&["run", "in.xyz", "-o", out], &QUICK[..], more].concat();
        let output = superform(folder.path(), &args);
        assert!(output.status.success(), "{}", stderr(&output));
        let out = folder.path().join(out);
        let of_strays = labels(&out.join("segmented.ply")).split_off(900);
        let summary = String::from_utf8(output.stdout).unwrap();
        (summary, json(&out.join("report.json"))["isolated"].clone(), of_strays)
    };
    let (summary, isolated, labels) = run("out", &[]);
    assert!(summary.contains("9 of 909 points are isolated"), "{summary}");
    assert_eq!(isolated["asked_for"], "leave-out");
    assert_eq!((&isolated["points_left_out"], &isolated["points_unlabelled"]), (&9.into(), &9.into()));
    assert_eq!(labels, [-1; 9]);

    let (summary, isolated, labels) = run("all", &["--isolated", "keep"]);
    assert!(!summary.contains("left out"), "{summary}");
    assert_eq!((&isolated["asked_for"], &isolated["points_left_out"]), (&"keep".into(), &0.into()));
    assert_eq!(labels.len(), 9);
}
