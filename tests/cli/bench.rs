//! The command that measures methods on many shapes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::process::{superform, text};
use serde_json::Value;

/// Settings that make a run short.
const QUICK: [&str; 8] = ["--points", "300", "--iterations", "2", "--clusters", "5", "--samples", "20000"];

fn bench(folder: &Path, args: &[&str]) -> Output {
    superform(folder, &[&["bench"], args, &QUICK[..]].concat())
}

/// Two chairs, one as a cloud with the mesh as its reference, and a list.
fn write_shapes(folder: &Path) {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR"));
    fs::create_dir(folder.join("shapes")).unwrap();
    fs::copy(assets.join("assets/chair.obj"), folder.join("shapes/chair.obj")).unwrap();
    fs::copy(assets.join("tests/data/evaluation/chair.xyz"), folder.join("shapes/cloud.xyz")).unwrap();
    fs::write(
        folder.join("list.csv"),
        "name,cloud,reference\r\nmeasured,shapes/cloud.xyz,shapes/chair.obj\r\nalone,shapes/cloud.xyz,\r\n",
    )
    .unwrap();
}

fn lines(path: &Path) -> Vec<String> {
    fs::read_to_string(path).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn a_benchmark_goes_on_where_it_was_and_makes_no_run_twice() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path();
    write_shapes(folder);
    let runs = folder.join("out/runs.jsonl");
    let first = bench(folder, &["list.csv", "--seeds", "1..2", "-o", "out"]);
    assert!(first.status.success(), "{}", text(&first.stderr));
    let made = lines(&runs);
    assert_eq!(made.len(), 4);
    let table = fs::read(folder.join("out/table.csv")).unwrap();

    // The same again: nothing is run, the table is the same.
    let again = bench(folder, &["list.csv", "--seeds", "1..2", "-o", "out"]);
    assert!(text(&again.stderr).contains("4 of 4 runs were already finished"), "{}", text(&again.stderr));
    assert_eq!((lines(&runs), &again.stdout), (made.clone(), &first.stdout));
    assert_eq!(fs::read(folder.join("out/table.csv")).unwrap(), table);

    // One run was lost, another is new.
    fs::write(&runs, made[1..].join("\n") + "\n" + &made[0][..40]).unwrap();
    let more = bench(folder, &["list.csv", "--seeds", "1..3", "-o", "out"]);
    assert!(text(&more.stderr).contains("3 of 6 runs were already finished"), "{}", text(&more.stderr));
    let now = lines(&runs);
    let figures = |line: &str| {
        let mut row: Value = serde_json::from_str(line).unwrap();
        row["seconds"].take();
        row
    };
    assert!(now[4..].iter().any(|l| figures(l) == figures(&made[0])), "the lost run gives the same figures");
    assert_eq!(now.len(), 3 + 1 + 3);

    // Other settings are other runs; so is another content of the same file.
    let other = bench(folder, &["list.csv", "--seeds", "1", "-o", "out", "--alpha", "0.7"]);
    assert!(!text(&other.stderr).contains("already finished"), "{}", text(&other.stderr));
    let cloud = folder.join("shapes/cloud.xyz");
    fs::write(&cloud, fs::read_to_string(&cloud).unwrap() + "0 0 0\n").unwrap();
    let other = bench(folder, &["list.csv", "--seeds", "1", "-o", "out"]);
    assert!(!text(&other.stderr).contains("already finished"), "{}", text(&other.stderr));
}

#[test]
fn the_table_holds_what_the_runs_were() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path();
    write_shapes(folder);
    fs::write(
        folder.join("authors.csv"),
        "name,primitives,chamfer_l1,iou\nchair,7,0.001,0.9\nmeasured,100,0.5,0.1\n",
    )
    .unwrap();
    let output = bench(
        folder,
        &[
            "shapes",
            "list.csv",
            "--methods",
            "default,without-merge",
            "--seeds",
            "4",
            "--compare",
            "authors.csv",
        ],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    let markdown = text(&output.stdout);
    assert!(!markdown.contains('\u{1b}'));
    let out = folder.join("superform-bench");
    assert!(fs::read_to_string(out.join("table.md")).unwrap().starts_with(&markdown));
    let table: Value = serde_json::from_slice(&fs::read(out.join("table.json")).unwrap()).unwrap();
    let lines = table["lines"].as_array().unwrap();
    let names: Vec<&str> = lines.iter().map(|l| l["shape"].as_str().unwrap()).collect();
    let twice = |names: &[&'static str]| names.iter().flat_map(|n| [*n, *n]).collect::<Vec<_>>();
    assert_eq!(names, twice(&["chair", "cloud", "measured", "alone"]));
    for line in lines {
        // Only against the mesh is there a volume.
        let mesh = ["chair", "measured"].contains(&line["shape"].as_str().unwrap());
        assert_eq!(line["iou"].is_object(), mesh, "{line}");
        let run = table["runs"]
            .as_array()
            .unwrap()
            .iter()
            .find(|r| (&r["shape"], &r["method"]) == (&line["shape"], &line["method"]));
        let run = run.unwrap();
        assert_eq!(run["chamfer_l1"], line["chamfer_l1"]["median"]);
        assert_eq!(run["primitives"].as_f64(), line["primitives"]["worst"].as_f64());
        assert!(run["seconds"].as_f64().unwrap() > 0.0);
        assert!(markdown.contains(line["shape"].as_str().unwrap()));
    }
    let versus = &table["comparison"][0];
    assert_eq!((versus["shapes"].as_u64(), versus["better_share"].as_f64()), (Some(2), Some(0.5)));
    assert!(markdown.contains("default, compared over 2 shapes"), "{markdown}");
    // The table of one method can be compared with in turn.
    let csv = fs::read_to_string(out.join("table.csv")).unwrap();
    let one = csv.lines().filter(|l| !l.contains("without-merge")).collect::<Vec<_>>().join("\n");
    fs::write(folder.join("before.csv"), one).unwrap();
    let output = bench(folder, &["list.csv", "--seeds", "4", "--compare", "before.csv"]);
    let markdown = text(&output.stdout);
    assert!(markdown.contains("Chamfer-L1 1.00× (by means over seeds 1.00×)"), "{markdown}");
    assert!(markdown.contains("none is worse in both"), "{markdown}");
}

/// A baseline is run as what it is, not as the sampler under its name.
#[test]
fn baselines_are_measured_beside_the_sampler() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path();
    write_shapes(folder);
    let methods = "default,kmeans,ems,hierarchical-ems";
    let output =
        bench(folder, &["shapes/chair.obj", "--methods", methods, "--seeds", "1", "--primitive-cost", "2"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let table: Value =
        serde_json::from_slice(&fs::read(folder.join("superform-bench/table.json")).unwrap()).unwrap();
    let runs = table["runs"].as_array().unwrap();
    let names: Vec<&str> = runs.iter().map(|r| r["method"].as_str().unwrap()).collect();
    assert_eq!(names.join(","), methods);
    let primitives: Vec<u64> = runs.iter().map(|r| r["primitives"].as_u64().unwrap()).collect();
    assert_eq!(primitives[1..3], [5, 1], "k-means has K primitives, EMS one: {primitives:?}");
    for (i, run) in runs.iter().enumerate() {
        for other in &runs[..i] {
            assert_ne!(run["chamfer_l1"], other["chamfer_l1"], "{run} {other}");
        }
    }
    let parameters = |method: &str, name: &str| {
        table["methods"].as_array().unwrap().iter().find(|m| m[0] == method).unwrap()[1][name].clone()
    };
    assert_eq!(parameters("default", "primitive_cost"), 2.0);
    assert_eq!(parameters("kmeans", "algorithm"), "kmeans");
}

#[test]
fn a_run_that_fails_is_told_and_the_others_count() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path();
    write_shapes(folder);
    fs::write(folder.join("shapes/tiny.xyz"), "0 0 0\n1 0 0\n0 1 0\n").unwrap();
    let output = bench(folder, &["shapes", "--seeds", "1", "-o", "out"]);
    assert_eq!(output.status.code(), Some(1));
    let message = text(&output.stderr);
    assert!(message.contains("tiny, default, seed 1: there are 3 distinct points"), "{message}");
    assert!(message.contains("one run failed and is missing from the table"), "{message}");
    assert!(text(&output.stdout).contains("| chair"));
    let table: Value = serde_json::from_slice(&fs::read(folder.join("out/table.json")).unwrap()).unwrap();
    assert_eq!(table["failures"][0]["shape"], "tiny");
}

#[test]
fn command_lines_that_make_no_sense_are_refused() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path();
    write_shapes(folder);
    for (args, code, words) in [
        (&[][..], 2, "required"),
        (&["list.csv", "--methods", "best"], 2, "without-merge"),
        (&["list.csv", "--seeds", "3..1"], 2, "is not a range"),
        (&["list.csv", "--alpha", "-1"], 2, "alpha is -1"),
        (&["list.csv", "--methods", "ems"], 2, "none of the methods uses --iterations"),
        (&["list.csv", "--primitive-cost", "0"], 2, "cost"),
        (&["list.csv", "--vary-clusters", "5"], 2, "--scaling"),
        (&["--scaling", "--jobs", "2"], 2, "--jobs"),
        (&["--scaling", "--methods", "default,paper"], 2, "one method"),
        (&["--scaling", "--vary-points", "300,5"], 2, "a value of N is 5"),
        (
            &["--scaling", "shapes/cloud.xyz", "--vary-points", "900", "-o", "growth"],
            1,
            "too few for 900 samples",
        ),
        (&["gone.obj"], 1, "gone.obj not found"),
        (&["list.csv", "--compare", "gone.csv"], 1, "gone.csv"),
    ] {
        let output = bench(folder, args);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{args:?} {message}");
        assert!(message.contains(words), "{message}");
    }
    assert!(!folder.join("superform-bench").exists());
}

#[test]
fn growth_is_measured_and_fitted() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path();
    let vary = ["--vary-points", "900,200,200", "--vary-clusters", "3,6", "--vary-iterations", "1,3"];
    let output = bench(folder, &[&["--scaling", "--seeds", "1,2", "-o", "growth"], &vary[..]].concat());
    let shown = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(shown, fs::read_to_string(folder.join("growth/scaling.md")).unwrap());
    for words in
        ["built-in chair", "K = 5 and T = 2", "the run grows as N^", "as K^", "as T^", "thinning as N^"]
    {
        assert_eq!(shown.contains(words), words != "thinning as N^", "{words} in {shown}");
    }
    let mut rows = csv::Reader::from_path(folder.join("growth/scaling.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
    let sizes: Vec<Vec<&str>> = rows.iter().map(|row| (0..4).map(|k| &row[k]).collect()).collect();
    let expected = ["N 200 5 2", "N 900 5 2", "K 300 3 2", "K 300 6 2", "T 300 5 1", "T 300 5 3"];
    assert_eq!(sizes.iter().map(|size| size.join(" ")).collect::<Vec<_>>(), expected);
    for row in &rows {
        let figure = |column: usize| row[column].parse::<f64>().unwrap();
        assert_eq!(&row[5], "2", "seeds");
        let (parts, run) = (figure(7) + figure(8) + figure(9), figure(10));
        // Medians of two seeds: the parts' add up to the whole's.
        assert!((parts - run).abs() < 1e-9 && run > 0.0, "{parts} and {run}");
        // Only the row of more points than samples has a cloud to thin.
        assert_eq!(row[12].is_empty(), &row[1] != "900");
    }
}

/// Ctrl-C in the middle: it says so, and there is no table of half the runs.
#[cfg(unix)]
#[test]
fn an_interrupted_benchmark_stops_cleanly() {
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;

    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path();
    write_shapes(folder);
    fs::write(folder.join("shapes/atiny.xyz"), "0 0 0\n1 0 0\n0 1 0\n").unwrap();
    // The first shape fails, which goes to standard error: from then on the
    // runs are under way.
    let mut child = Command::new(env!("CARGO_BIN_EXE_superform"))
        .args(["bench", "shapes", "--seeds", "1..200", "-o", "out", "--jobs", "1", "--iterations", "100"])
        .args(["--samples", "2000"])
        .current_dir(folder)
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut errors = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    errors.read_line(&mut line).unwrap();
    assert!(line.contains("atiny"), "{line}");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let last = errors.lines().map_while(Result::ok).last().unwrap();
    assert!(last.contains("repeat the command to resume"), "{last}");
    assert!(!folder.join("out/table.md").exists());
}
