//! What the tests of batches share.
#![allow(dead_code)] // Each test file uses its part.

use std::fs;
use std::path::{Path, PathBuf};

pub(crate) use crate::process::{done, program, superform, text};

/// Settings that make a run short.
pub(crate) const QUICK: [&str; 6] = ["--points", "200", "--iterations", "2", "--clusters", "4"];

/// The files of a job that depend on nothing but its input and settings.
pub(crate) const RESULTS: [&str; 2] = ["primitives.json", "segmented.ply"];

/// A cloud of points on a box, a little different for each number.
pub(crate) fn write_box(path: &Path, number: usize) {
    let mut content = String::new();
    let height = 0.3 + 0.1 * number as f64;
    for i in 0..12 {
        for j in 0..12 {
            for z in [0.0, height] {
                content.push_str(&format!("{} {} {z}\n", 0.1 * f64::from(i), 0.1 * f64::from(j)));
            }
        }
    }
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, content).unwrap();
}

/// A row of a table, by the names of its columns.
pub(crate) type Row = std::collections::BTreeMap<String, String>;

pub(crate) fn table(path: &Path) -> Vec<Row> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

/// One column of a table.
pub(crate) fn column(rows: &[Row], name: &str) -> Vec<String> {
    rows.iter().map(|row| row[name].clone()).collect()
}

/// Complete lines of a file, none if it isn't there.
pub(crate) fn lines_in(path: &Path) -> usize {
    fs::read(path).map_or(0, |bytes| bytes.iter().filter(|b| **b == b'\n').count())
}

/// Folders below one that hold a finished job.
pub(crate) fn job_folders(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            if path.join("job.json").is_file() {
                found.push(path.clone());
            }
            found.extend(job_folders(&path));
        }
    }
    found.sort();
    found
}
