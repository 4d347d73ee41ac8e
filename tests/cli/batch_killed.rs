//! A batch that is killed without warning loses nothing but what it was at.

use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::batch_common::*;

const SHAPES: usize = 100;

/// Longest that anything here may take.
const PATIENCE: Duration = Duration::from_secs(300);

fn shapes(folder: &Path) {
    for number in 0..SHAPES {
        write_box(&folder.join(format!("shapes/{number:03}.xyz")), number);
    }
}

/// Waits until the table has so many rows; what was there before counts.
fn wait_for_rows(table: &Path, rows: usize, child: &mut Child) {
    let start = Instant::now();
    loop {
        let has_ended = child.try_wait().unwrap().is_some();
        // What it wrote before it ended is there now.
        if lines_in(table) >= rows {
            return;
        }
        assert!(!has_ended, "the batch ended before it had {rows} rows");
        assert!(start.elapsed() < PATIENCE, "{} never had {rows} rows", table.display());
        thread::yield_now();
    }
}

fn start(folder: &Path, args: &[&str]) -> Child {
    program(folder, args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Whether all that is in a job's folder is whole: it can be read to its end.
fn assert_whole(folder: &Path) {
    for name in ["report.json", "primitives.json", "job.json"] {
        let content = fs::read(folder.join(name)).unwrap();
        assert!(
            serde_json::from_slice::<serde_json::Value>(&content).is_ok(),
            "{name} in {}",
            folder.display()
        );
    }
    let parser = ply_rs_bw::parser::Parser::<ply_rs_bw::ply::DefaultElement>::new();
    let ply = parser.read_ply(&mut fs::File::open(folder.join("segmented.ply")).unwrap()).unwrap();
    assert_eq!(ply.payload["vertex"].len(), 288);
}

#[test]
fn three_kills_lose_nothing_but_the_jobs_in_flight() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    shapes(folder);
    let args = [&["run", "shapes", "-o", "out", "--jobs", "3"], &QUICK[..]].concat();
    let out = folder.join("out");
    let (csv, json_lines) = (out.join("results.csv"), out.join("results.jsonl"));
    let mut finished = Vec::new();
    for rows in [20, 45, 70] {
        let mut child = start(folder, &args);
        wait_for_rows(&json_lines, rows, &mut child);
        child.kill().unwrap();
        child.wait().unwrap();
        // Every row that was there is a finished job, and each of these is whole.
        let done = job_folders(&out).into_iter().filter(|path| !path.starts_with(out.join(".superform")));
        let done: Vec<_> = done.collect();
        assert!(done.len() >= rows, "{} jobs of {rows} rows", done.len());
        done.iter().for_each(|path| assert_whole(path));
        let named: Vec<String> = fs::read_to_string(&json_lines)
            .unwrap()
            .lines()
            .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
            .map(|row| row["name"].as_str().unwrap().to_owned())
            .collect();
        assert!(named.iter().all(|name| done.contains(&out.join(name))));
        let times: Vec<_> = done
            .iter()
            .map(|path| (path.clone(), fs::metadata(path.join("segmented.ply")).unwrap().modified().unwrap()))
            .collect();
        // What was finished at the last kill was not made again.
        assert!(finished.iter().all(|before| times.contains(before)));
        finished = times;
    }
    let (said, progress) = done(folder, &args);
    assert!(said.contains("100 jobs: 100 done"), "{said}");
    assert!(progress.lines().count() <= 1 + SHAPES - finished.len(), "{progress}");
    let now = |path: &Path| fs::metadata(path.join("segmented.ply")).unwrap().modified().unwrap();
    assert!(finished.iter().all(|(path, time)| now(path) == *time), "a finished job was made again");
    let hidden = |entry: &fs::DirEntry| entry.file_name().to_string_lossy().starts_with('.');
    let leftovers: Vec<_> = fs::read_dir(&out).unwrap().map(Result::unwrap).filter(hidden).collect();
    assert!(leftovers.is_empty(), "leftovers of the killed: {leftovers:?}");

    // All there, in order, and the same as without a kill.
    let rows = table(&csv);
    let names: Vec<String> = (0..SHAPES).map(|number| format!("{number:03}")).collect();
    assert_eq!(column(&rows, "name"), names);
    assert_eq!(column(&rows, "status"), vec!["ok"; SHAPES]);
    done(folder, &[&["run", "shapes", "-o", "plain", "--quiet"], &QUICK[..]].concat());
    for name in &names {
        for file in RESULTS {
            let [one, other] =
                ["out", "plain"].map(|dir| fs::read(folder.join(dir).join(name).join(file)).unwrap());
            assert_eq!(one, other, "{name}/{file}");
        }
    }
}

/// Shards write to the same folder at the same time; one is killed and started
/// again while the others go on.
#[test]
fn shards_do_not_disturb_each_other() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    shapes(folder);
    let of_shard = |shard: &'static str| {
        [&["run", "shapes", "-o", "out", "--jobs", "1", "--shard", shard], &QUICK[..]].concat()
    };
    let mut others = [start(folder, &of_shard("0/3")), start(folder, &of_shard("2/3"))];
    let mut child = start(folder, &of_shard("1/3"));
    wait_for_rows(&folder.join("out/results.1-of-3.jsonl"), 8, &mut child);
    child.kill().unwrap();
    child.wait().unwrap();
    done(folder, &of_shard("1/3"));
    for other in &mut others {
        assert!(other.wait().unwrap().success());
    }
    assert_eq!(job_folders(&folder.join("out")).len(), SHAPES);
    assert!(!folder.join("out/.superform").exists());
    let (said, _) = done(folder, &["merge-results", "out"]);
    assert!(said.contains("100 jobs: 100 done"), "{said}");
    assert_eq!(column(&table(&folder.join("out/results.csv")), "job").last().unwrap(), "100");
}
