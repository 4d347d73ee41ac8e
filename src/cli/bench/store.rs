//! Finished runs on disk, from which an interrupted benchmark resumes.

use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

use anyhow::{Context, anyhow};
use serde::{Deserialize, Serialize};

use crate::io::on_writing;

/// The figures of one run: one line of `runs.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) shape: String,
    pub(super) method: String,
    pub(super) seed: u64,
    /// Stands for everything that the figures depend on.
    pub(super) key: String,
    pub(super) primitives: usize,
    pub(super) chamfer_l1: f64,
    pub(super) accuracy: f64,
    pub(super) completeness: f64,
    pub(super) iou: Option<f64>,
    pub(super) iou_outside: Option<f64>,
    pub(super) unassigned_share: f64,
    /// CPU seconds of sampling and inference.
    pub(super) seconds: f64,
}

/// The file of finished runs, a JSON object a line.
#[derive(Debug)]
pub(super) struct Store {
    file: File,
    rows: Vec<Row>,
}

impl Store {
    /// Opens the file or makes it. Lines that are no rows (the last one of a
    /// run that was killed, or one by another version) count as not there.
    pub(super) fn open(path: &Path) -> anyhow::Result<Self> {
        let about = || format!("cannot store finished runs in {}", path.display());
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .with_context(about)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).with_context(about)?;
        let rows = bytes.split(|b| *b == b'\n').filter_map(|l| serde_json::from_slice(l).ok()).collect();
        file.seek(SeekFrom::End(0)).with_context(about)?;
        if bytes.last().is_some_and(|b| *b != b'\n') {
            file.write_all(b"\n").with_context(about)?;
        }
        Ok(Self { file, rows })
    }

    /// The finished run with that key, if there is one; the last of several.
    pub(super) fn find(&self, key: &str) -> Option<&Row> {
        self.rows.iter().rev().find(|row| row.key == key)
    }

    /// Adds a run, on disk at once.
    pub(super) fn add(&mut self, row: Row) -> anyhow::Result<()> {
        let mut line = serde_json::to_vec(&row)?;
        line.push(b'\n');
        let failed = |e| anyhow!("cannot store a finished run: {}", on_writing(&e));
        self.file.write_all(&line).map_err(failed)?;
        self.rows.push(row);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_and_half_a_line_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let row = |seed: u64, chamfer_l1: f64| Row {
            shape: "a".to_owned(),
            method: "paper".to_owned(),
            seed,
            key: format!("k{seed}"),
            primitives: 3,
            chamfer_l1,
            accuracy: 0.1,
            completeness: 0.3,
            iou: None,
            iou_outside: None,
            unassigned_share: 0.0,
            seconds: 1.5,
        };
        let mut store = Store::open(&path).unwrap();
        store.add(row(1, 0.25)).unwrap();
        store.add(row(2, 1.0 / 3.0)).unwrap();
        store.add(row(1, 0.5)).unwrap();
        drop(store);
        let mut text = std::fs::read_to_string(&path).unwrap();
        text.push_str("{\"shape\": \"a\", \"meth");
        std::fs::write(&path, text).unwrap();
        let mut store = Store::open(&path).unwrap();
        assert_eq!((store.find("k1"), store.find("k3")), (Some(&row(1, 0.5)), None));
        store.add(row(3, 0.1)).unwrap();
        let store = Store::open(&path).unwrap();
        assert_eq!((store.find("k2"), store.find("k3")), (Some(&row(2, 1.0 / 3.0)), Some(&row(3, 0.1))));
    }
}
