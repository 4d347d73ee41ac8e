//! Many shapes with one command: names, tables, lists, sweeps, shards, and what
//! happens when something goes wrong.

use std::fs;
use std::path::Path;

use super::batch_common::*;

/// Three boxes and a folder with another.
fn boxes(folder: &Path) {
    for (number, name) in
        ["shapes/a.xyz", "shapes/b.xyz", "shapes/c.xyz", "shapes/deep/d.xyz"].iter().enumerate()
    {
        write_box(&folder.join(name), number);
    }
}

fn same_results(one: &Path, other: &Path) {
    for file in RESULTS {
        assert_eq!(fs::read(one.join(file)).unwrap(), fs::read(other.join(file)).unwrap(), "{file}");
    }
}

#[test]
fn each_shape_gets_a_folder_and_a_row_and_the_bits_of_a_single_run() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    boxes(folder);
    let run = |more: &[&str]| done(folder, &[&["run"], more, &QUICK[..], &["--seed", "7"]].concat());
    let (said, progress) = run(&["shapes/*.xyz", "-o", "out", "--jobs", "2"]);
    assert!(said.contains("3 jobs: 3 done, results in"), "{said}");
    // A line a job where nobody looks on.
    let lines: Vec<&str> = progress.lines().collect();
    assert_eq!(lines.len(), 3, "{progress}");
    assert!(lines[2].starts_with("superform: [3/3] ") && lines[2].contains(" primitive"), "{progress}");

    let rows = table(&folder.join("out/results.csv"));
    assert_eq!(column(&rows, "name"), ["a", "b", "c"]);
    assert_eq!(column(&rows, "status"), ["ok"; 3]);
    for (at, row) in rows.iter().enumerate() {
        let out = folder.join("out").join(&row["name"]);
        let report: serde_json::Value =
            serde_json::from_slice(&fs::read(out.join("report.json")).unwrap()).unwrap();
        assert_eq!(row["job"], (at + 1).to_string());
        assert_eq!(row["input_points"], "288");
        for (column, entry) in [
            ("primitives", &report["primitives"]),
            ("mean_distance", &report["mean_distance"]),
            ("unassigned", &report["unassigned_points"]),
            ("samples", &report["points"]),
            ("seed", &report["seed"]),
            ("iterations", &report["params"]["iterations"]),
            ("alpha", &report["params"]["alpha"]),
        ] {
            assert_eq!(row[column].parse::<f64>().unwrap(), entry.as_f64().unwrap(), "{column}");
        }
        run(&[&row["input"], "-o", "single"]);
        same_results(&out, &folder.join("single"));
        // A single run leaves its three files and nothing else.
        assert_eq!(fs::read_dir(folder.join("single")).unwrap().count(), 3);
    }
    let json_lines = fs::read_to_string(folder.join("out/results.jsonl")).unwrap();
    let names: Vec<serde_json::Value> =
        json_lines.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(names.iter().map(|row| row["name"].as_str().unwrap()).collect::<Vec<_>>(), ["a", "b", "c"]);
    #[cfg(unix)]
    assert!(!folder.join("out/.superform").exists(), "nothing is left over");

    // A folder, and those below it.
    run(&["shapes", "-o", "flat", "--quiet"]);
    run(&["shapes", "-o", "all", "--recursive", "--quiet"]);
    assert_eq!((job_folders(&folder.join("flat")).len(), job_folders(&folder.join("all")).len()), (3, 4));
}

#[test]
fn a_bad_file_stops_nobody_else_and_the_exit_status_counts() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    boxes(folder);
    fs::write(folder.join("shapes/bad.obj"), "v 0 0 0\nv a b c\n").unwrap();
    let args =
        [&["run", "shapes/a.xyz", "shapes/bad.obj", "gone.ply", "shapes/c.xyz", "-o", "out"], &QUICK[..]]
            .concat();
    let output = superform(folder, &args);
    // 10 and the number of failed jobs.
    assert_eq!(output.status.code(), Some(12), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("4 jobs: 2 done; 2 failed"), "{}", text(&output.stdout));
    let said = text(&output.stderr);
    let last: Vec<&str> = said.lines().rev().take(2).collect();
    assert!(last[1].starts_with("superform: bad: ") && last[1].contains("line 2"), "{said}");
    assert!(last[0].starts_with("superform: gone: cannot open gone.ply"), "{said}");
    let rows = table(&folder.join("out/results.csv"));
    assert_eq!(column(&rows, "status"), ["ok", "failed", "failed", "ok"]);
    assert!(rows[1]["message"].contains("line 2") && rows[1]["primitives"].is_empty());
    assert!(!folder.join("out/bad").exists());
    // A file where a folder would have to be.
    fs::create_dir(folder.join("other")).unwrap();
    fs::write(folder.join("other/a"), "mine").unwrap();
    let output = superform(folder, &[&["run", "shapes/[ac].xyz", "-o", "other"], &QUICK[..]].concat());
    assert_eq!(output.status.code(), Some(11));
    assert!(text(&output.stderr).contains("other/a is in the way"), "{}", text(&output.stderr));
    assert_eq!(fs::read_to_string(folder.join("other/a")).unwrap(), "mine");

    // Once it is mended, only what failed is run.
    write_box(&folder.join("gone.ply.xyz"), 9);
    fs::rename(folder.join("gone.ply.xyz"), folder.join("gone.ply")).unwrap();
    fs::remove_file(folder.join("shapes/bad.obj")).unwrap();
    write_box(&folder.join("shapes/bad.obj"), 8);
    let (said, progress) = done(folder, &args);
    assert!(said.contains("4 jobs: 4 done, 2 of them earlier"), "{said}");
    assert!(!progress.contains("] a:") && progress.contains("[3/4]"), "{progress}");
    assert_eq!(column(&table(&folder.join("out/results.csv")), "status"), ["ok"; 4]);
}

#[test]
fn what_is_finished_is_skipped_unless_something_it_came_from_is_another() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    boxes(folder);
    let before = |more: &[&str]| {
        let (said, _) = done(folder, &[&["run", "shapes", "-o", "out"], more].concat());
        let count = said.split(" done, ").nth(1).and_then(|rest| rest.split(" of them").next());
        count.and_then(|n| n.parse::<usize>().ok()).unwrap_or(0)
    };
    assert_eq!(before(&QUICK), 0);
    assert_eq!(before(&QUICK), 3);
    assert_eq!(before(&[&QUICK[..], &["--jobs", "1", "--recursive"]].concat()), 3);
    assert_eq!(before(&[&QUICK[..], &["--force"]].concat()), 0);
    let other = [&QUICK[..], &["--alpha", "2"]].concat();
    assert_eq!(before(&other), 0);
    // The input.
    write_box(&folder.join("shapes/a.xyz"), 11);
    assert_eq!(before(&other), 2);
    // Any of the files: cut, as by a power failure, changed, or missing.
    let out = folder.join("out");
    fs::write(out.join("a/report.json"), "{").unwrap();
    assert_eq!(before(&other), 2);
    fs::write(out.join("b/segmented.ply"), "").unwrap();
    fs::remove_file(out.join("c/primitives.json")).unwrap();
    assert_eq!(before(&other), 1);
    fs::remove_file(out.join("a/job.json")).unwrap();
    assert_eq!(before(&other), 2);
    // Files of one's own in the folder of a job stay.
    fs::write(out.join("a/notes.txt"), "mine").unwrap();
    assert_eq!(before(&[&other[..], &["--force"]].concat()), 0);
    assert_eq!(fs::read_to_string(out.join("a/notes.txt")).unwrap(), "mine");
    // The tables are made anew from the records.
    fs::remove_file(out.join("results.csv")).unwrap();
    fs::remove_file(out.join("results.jsonl")).unwrap();
    assert_eq!(before(&other), 3);
    assert_eq!(column(&table(&out.join("results.csv")), "name"), ["a", "b", "c"]);
}

#[test]
fn a_manifest_says_what_each_job_is() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    boxes(folder);
    fs::create_dir(folder.join("lists")).unwrap();
    let rows = [
        "input,name,method,alpha,seed\n",
        "../shapes/a.xyz,,,0.3,\n",
        "../shapes/a.xyz,,,2,5\n",
        "../shapes/b.xyz,group/bee,kmeans,,\n",
        "../shapes/c.xyz,,paper,,3\n",
    ];
    fs::write(folder.join("lists/jobs.csv"), rows.concat()).unwrap();
    let json_lines = [
        "{\"input\": \"../shapes/a.xyz\", \"alpha\": 0.3}\n",
        "{\"input\": \"../shapes/a.xyz\", \"alpha\": 2, \"seed\": 5}\n",
        "{\"input\": \"../shapes/b.xyz\", \"name\": \"group/bee\", \"method\": \"kmeans\"}\n",
        "{\"input\": \"../shapes/c.xyz\", \"method\": \"paper\", \"seed\": \"3\"}\n",
    ];
    fs::write(folder.join("lists/jobs.jsonl"), json_lines.concat()).unwrap();
    let run = |manifest: &str, out: &str, more: &[&str]| {
        let args = ["run", "--manifest", manifest, "-o", out, "--alpha", "0.7", "--quiet"];
        done(folder, &[&args[..], &QUICK[..], more].concat());
        table(&folder.join(out).join("results.csv"))
    };
    let rows = run("lists/jobs.csv", "out", &[]);
    assert_eq!(column(&rows, "name"), ["a/alpha=0.3", "a/alpha=2,seed=5", "group/bee", "c"]);
    // The command line speaks where a line says nothing; k-means has no alpha.
    assert_eq!(column(&rows, "alpha"), ["0.3", "2.0", "", "0.7"]);
    assert_eq!(column(&rows, "seed"), ["1", "5", "1", "3"]);
    assert_eq!(column(&rows, "method"), ["default", "default", "kmeans", "paper"]);
    let other = run("lists/jobs.jsonl", "other", &[]);
    assert_eq!(column(&rows, "name"), column(&other, "name"));
    for row in &rows {
        same_results(&folder.join("out").join(&row["name"]), &folder.join("other").join(&row["name"]));
    }

    // Parts of the list, each with a table of its own, make the same results.
    for part in ["0/2", "1/2"] {
        run_part(folder, "lists/jobs.csv", "parts", &["--shard", part]);
    }
    assert_eq!(column(&table(&folder.join("parts/results.0-of-2.csv")), "job"), ["1", "3"]);
    run_part(folder, "lists/jobs.csv", "lines", &["--lines", "2..3"]);
    let lines = table(&folder.join("lines/results.lines-2-to-3.csv"));
    assert_eq!(column(&lines, "name"), ["a/alpha=2,seed=5", "group/bee"]);
    for _ in 0..2 {
        let (said, _) = done(folder, &["merge-results", "parts"]);
        assert!(said.contains("4 jobs: 4 done"), "{said}");
        let merged = table(&folder.join("parts/results.csv"));
        for name in ["job", "name", "input", "status", "alpha", "seed", "primitives", "mean_distance"] {
            assert_eq!(column(&merged, name), column(&rows, name), "{name}");
        }
    }
    // The whole list finds everything done.
    let (_, progress) = done(
        folder,
        &[&["run", "--manifest", "lists/jobs.csv", "-o", "parts", "--alpha", "0.7"], &QUICK[..]].concat(),
    );
    assert!(progress.contains("4 of 4 jobs were already done"), "{progress}");
}

fn run_part(folder: &Path, manifest: &str, out: &str, part: &[&str]) {
    let args = ["run", "--manifest", manifest, "-o", out, "--alpha", "0.7", "--quiet"];
    done(folder, &[&args[..], &QUICK[..], part].concat());
}

#[test]
fn a_sweep_makes_all_combinations() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    boxes(folder);
    let args = ["run", "shapes/a.xyz", "shapes/b.xyz", "-o", "out", "--sweep", "alpha=0.1,2", "seed=1..3"];
    let (said, _) = done(folder, &[&args[..], &QUICK[..]].concat());
    assert!(said.contains("12 jobs: 12 done"), "{said}");
    let rows = table(&folder.join("out/results.csv"));
    assert_eq!(rows[1]["name"], "a/alpha=0.1,seed=2");
    assert_eq!(rows[11]["name"], "b/alpha=2,seed=3");
    let single = ["run", "shapes/b.xyz", "-o", "single", "--alpha", "2", "--seed", "3"];
    done(folder, &[&single[..], &QUICK[..]].concat());
    same_results(&folder.join("out/b/alpha=2,seed=3"), &folder.join("single"));
    // A wider sweep adds to what is there, a narrower one takes nothing away.
    let wider = [&["run", "shapes/a.xyz", "-o", "out", "--sweep", "alpha=0.1,0.5"], &QUICK[..]].concat();
    done(folder, &wider);
    let names = column(&table(&folder.join("out/results.csv")), "name");
    assert_eq!(names[..2], ["a/alpha=0.1", "a/alpha=0.5"]);
    assert_eq!(names.len(), 14);
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_runs() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    boxes(folder);
    for (name, content) in [
        ("column.csv", "input,alpah\nshapes/a.xyz,1\n"),
        ("value.csv", "input,alpha\nshapes/a.xyz,1\n\nshapes/b.xyz,-3\n"),
        ("word.jsonl", "{\"input\": \"shapes/a.xyz\", \"points\": \"many\"}\n"),
        ("unread.csv", "input,method,alpha\nshapes/a.xyz,kmeans,1\n"),
        ("twice.csv", "input,name\nshapes/a.xyz,x\nshapes/b.xyz,x\n"),
        ("good.csv", "input,alpha\nshapes/a.xyz,1\n"),
    ] {
        fs::write(folder.join(name), content).unwrap();
    }
    for (args, words) in [
        (&["shapes/*.ply"][..], "the pattern shapes/*.ply matches no shape"),
        (&["shapes/none"], ""),
        (&["."], "no shapes in the folder"),
        (&["--manifest", "gone.csv"], "cannot read the manifest gone.csv"),
        (&["--manifest", "column.csv"], "column.csv, line 1: unknown column “alpah”"),
        (&["--manifest", "value.csv"], "value.csv, line 4, column alpha: alpha is -3, but must be between"),
        (
            &["--manifest", "word.jsonl"],
            "word.jsonl, line 1, column points: “many” is not a non-negative whole number",
        ),
        (&["--manifest", "unread.csv"], "line 2, column alpha: the method kmeans does not use alpha"),
        (&["--manifest", "twice.csv"], "already used in line 2"),
        (
            &["--manifest", "good.csv", "--sweep", "alpha=1,2"],
            "line 2, column alpha: --sweep also sets alpha",
        ),
        (&["--manifest", "good.csv", "shapes/a.xyz"], "cannot be used with"),
        (&["shapes", "--sweep", "alpha=0.1,900"], "--sweep alpha: alpha is 900, but must be between"),
        (&["shapes", "--sweep", "alpah=1"], "“alpah” is not a setting"),
        (&["shapes", "--sweep", "alpha=1", "shapes"], "write inputs before --sweep"),
        (&["shapes", "--method", "kmeans", "--alpha", "1"], "none of the methods uses --alpha"),
        (&["shapes", "--shard", "2/2"], "shards are counted from 0"),
        (&["shapes", "--lines", "3..2"], "counted from 1"),
        (&["shapes", "--jobs", "0"], "a whole number from 1"),
    ] {
        let output = superform(folder, &[&["run"], args, &["-o", "out"]].concat());
        // A single file that is not there is an input that can't be used.
        let expected = if words.is_empty() { 1 } else { 2 };
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(expected), "{args:?}: {said}");
        assert!(said.contains(words), "{said} lacks {words}");
        assert!(!folder.join("out").exists(), "{args:?}");
    }
    let output = superform(folder, &["merge-results", "shapes"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("no results in shapes"));
}

/// Elsewhere files can't have such names in the first place.
#[cfg(unix)]
#[test]
fn names_are_told_apart_and_safe() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let inputs = ["x/chair.xyz", "y/chair.xyz", "y/chair.txt", "Стул 1.xyz", "a:b?.xyz", "con.xyz"];
    for (number, name) in inputs.iter().enumerate() {
        write_box(&folder.join(name), number);
    }
    let run = |inputs: &[&str], out: &str| {
        done(folder, &[&["run"], inputs, &["-o", out, "-q"], &QUICK[..]].concat());
        column(&table(&folder.join(out).join("results.csv")), "name")
    };
    let names = run(&inputs, "out");
    assert_eq!(names, ["x-chair.xyz", "y-chair.xyz", "chair.txt", "Стул 1", "a_b_", "_con"]);
    for name in &names {
        assert!(folder.join("out").join(name).join("job.json").is_file(), "{name}");
    }
    let reversed: Vec<&str> = inputs.iter().rev().copied().collect();
    let mut again = run(&reversed, "out");
    again.reverse();
    assert_eq!(again, names);
    // In place: results are no inputs of the next run.
    done(folder, &[&["run", ".", "-r", "-o", ".", "-q"], &QUICK[..]].concat());
    let first = column(&table(&folder.join("results.csv")), "input");
    done(folder, &[&["run", ".", "-r", "-o", ".", "-q"], &QUICK[..]].concat());
    assert_eq!(column(&table(&folder.join("results.csv")), "input"), first);
}

/// What has been done when it is stopped stays, and is told from the rest.
#[cfg(unix)]
#[test]
fn a_batch_that_is_stopped_keeps_what_is_done() {
    use std::io::{BufRead as _, BufReader};
    use std::process::{Command, Stdio};

    for signal in ["-INT", "-TERM"] {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        for number in 0..4 {
            write_box(&folder.join(format!("shapes/{number}.xyz")), number);
        }
        // The second job would take minutes.
        fs::write(
            folder.join("jobs.csv"),
            "input,iterations,points\nshapes/0.xyz,2,200\nshapes/1.xyz,500,5500\nshapes/2.xyz,500,5500\nshapes/3.xyz,500,5500\n",
        )
        .unwrap();
        let args = ["run", "--manifest", "jobs.csv", "-o", "out", "--jobs", "1"];
        let mut child = program(folder, &args).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
        assert!(said.next().unwrap().unwrap().contains("[1/4] 0: "));
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130));
        let rest: Vec<String> = said.map(Result::unwrap).collect();
        assert!(rest.concat().contains("stopped: 4 jobs: 1 done; 3 not done"), "{rest:?}");
        let rows = table(&folder.join("out/results.csv"));
        assert_eq!(column(&rows, "status"), ["ok", "cancelled", "cancelled", "cancelled"]);
        assert_eq!(job_folders(&folder.join("out")).len(), 1);
        assert!(!folder.join("out/.superform").exists());
    }
}

/// `nohup` and its like: a closed terminal is no reason to stop.
#[cfg(target_os = "linux")]
#[test]
fn a_batch_that_is_to_outlive_its_terminal_does() {
    use std::io::{BufRead as _, BufReader};
    use std::process::{Command, Stdio};

    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    boxes(folder);
    let start = |ignore: &str, iterations: u32| {
        let line =
            format!("{ignore} exec \"$0\" run shapes -o out --jobs 1 --force --iterations {iterations}");
        // Whoever runs this test may be one that outlives its terminal.
        let mut child = Command::new("env")
            .args(["--default-signal=HUP", "sh", "-c", &line, env!("CARGO_BIN_EXE_superform")])
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
        assert!(said.next().unwrap().unwrap().contains("[1/3] a: "));
        assert!(Command::new("kill").args(["-HUP", &child.id().to_string()]).status().unwrap().success());
        let rest: Vec<String> = said.map(Result::unwrap).collect();
        (child.wait().unwrap().code(), rest)
    };
    assert_eq!(start("trap '' HUP;", 5).0, Some(0));
    let (code, said) = start("", 300);
    assert!(code == Some(130) && said.concat().contains("stopped: 3 jobs"), "{code:?} {said:?}");
}

#[test]
fn more_files_are_written_for_each_shape_and_belong_to_what_is_finished() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    boxes(folder);
    let run = |exports: &str| {
        let job = ["run", "shapes/*.xyz", "-o", "out", "--export", exports];
        done(folder, &[&job, &QUICK[..]].concat()).0
    };
    let said = run("robot.urdf,labels.csv");
    assert!(said.contains("3 jobs: 3 done, results in"), "{said}");
    for name in ["a", "b", "c"] {
        let out = folder.join("out").join(name);
        assert!(fs::read_to_string(out.join("robot.urdf")).unwrap().contains("<robot"));
        assert!(out.join("labels.csv").is_file() || fs::read_dir(&out).unwrap().count() > 4);
        assert!(fs::read_dir(out.join("robot_meshes")).unwrap().count() > 0);
    }
    let again = run("robot.urdf,labels.csv");
    assert!(again.contains("3 of them earlier"), "{again}");
    // A mesh that has gone makes its job unfinished.
    let mesh = fs::read_dir(folder.join("out/b/robot_meshes")).unwrap().next().unwrap().unwrap().path();
    fs::remove_file(&mesh).unwrap();
    let again = run("robot.urdf,labels.csv");
    assert!(again.contains("2 of them earlier") && mesh.is_file(), "{again}");
    // Other files are another job, and those of before go.
    run("points.npz");
    assert!(folder.join("out/a/points.npz").is_file() && !folder.join("out/a/robot.urdf").exists());
}
