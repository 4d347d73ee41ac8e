//! The tables of a batch: one row per job, as CSV and JSON lines.

use std::fs::{self, File, OpenOptions};
use std::io::{self as stdio, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::job::Job;
use crate::cli::job::Finished;
use crate::geometry::{Isolated, Surface};
use crate::inference::{MergeRule, Method, Setting};
use crate::io::{self, ShapeGeometry};

/// Beginning of the names of all tables.
const TABLE: &str = "results.";

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Status {
    Ok,
    Failed,
    /// The batch was stopped before the job was done.
    Cancelled,
}

/// One job: what it was, and what came out. Settings that the method does not
/// read have no value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    /// Its number in the whole list, from 1.
    pub(super) job: usize,
    pub(super) name: String,
    pub(super) input: String,
    pub(super) status: Status,
    /// What went wrong; what was skipped or mended on reading.
    pub(super) message: String,
    method: Option<Method>,
    /// Number of samples that were asked for.
    points: usize,
    alpha: Option<f64>,
    p0: Option<f64>,
    iterations: Option<u32>,
    clusters: Option<u32>,
    primitive_cost: Option<f64>,
    outlier_prior: Option<f64>,
    merge: Option<MergeRule>,
    surface: Surface,
    isolated: Isolated,
    seed: u64,
    pub(super) primitives: Option<usize>,
    /// In the input's units.
    mean_distance: Option<f64>,
    /// Samples that belong to no primitive.
    unassigned: Option<usize>,
    samples: Option<usize>,
    input_points: Option<usize>,
    input_faces: Option<usize>,
    /// From opening the input to the last file.
    pub(super) seconds: Option<f64>,
}

impl Row {
    fn new(job: &Job, status: Status, message: String) -> Self {
        let params = &job.params;
        fn read<T>(job: &Job, setting: Setting, value: T) -> Option<T> {
            job.params.reads(setting).then_some(value)
        }
        Self {
            job: job.number,
            name: job.name.clone(),
            input: job.input.display().to_string(),
            status,
            message,
            method: Method::of(params),
            points: job.sampling.points,
            alpha: read(job, Setting::Alpha, params.alpha),
            p0: read(job, Setting::P0, params.p0),
            iterations: read(job, Setting::Iterations, params.iterations),
            clusters: read(job, Setting::Clusters, params.clusters),
            primitive_cost: read(job, Setting::PrimitiveCost, params.primitive_cost),
            outlier_prior: read(job, Setting::OutlierPrior, params.outlier_prior),
            merge: read(job, Setting::Merge, params.merge),
            surface: job.sampling.surface,
            isolated: job.sampling.isolated,
            seed: job.sampling.seed,
            primitives: None,
            mean_distance: None,
            unassigned: None,
            samples: None,
            input_points: None,
            input_faces: None,
            seconds: None,
        }
    }

    /// The row of a finished job; `notes` are those on its files.
    pub(super) fn ok(job: &Job, finished: &Finished, notes: &[String], seconds: f64) -> Self {
        let (points, faces) = match &finished.shape.geometry {
            ShapeGeometry::Mesh(mesh) => (mesh.vertices.len(), mesh.faces.len()),
            ShapeGeometry::Cloud(cloud) => (cloud.points.len(), 0),
        };
        let figures = &finished.abstraction.figures;
        Self {
            primitives: Some(finished.abstraction.primitives.len()),
            mean_distance: Some(figures.mean_distance).filter(|d| d.is_finite()),
            unassigned: Some(figures.unassigned),
            samples: Some(finished.cloud.points.len()),
            input_points: Some(points),
            input_faces: Some(faces),
            seconds: Some(seconds),
            ..Self::new(job, Status::Ok, [&finished.shape.notes, notes].concat().join("; "))
        }
    }

    /// The row of a job that was done before, maybe from another list.
    pub(super) fn now_of(self, job: &Job) -> Self {
        Self { job: job.number, name: job.name.clone(), input: job.input.display().to_string(), ..self }
    }

    /// Of a job that gave nothing.
    pub(super) fn failed(job: &Job, problem: String) -> Self {
        Self::new(job, Status::Failed, problem)
    }

    /// Of a job that the batch did not come to, or that it gave up.
    pub(super) fn cancelled(job: &Job) -> Self {
        Self::new(job, Status::Cancelled, "the batch was stopped before this job".to_owned())
    }
}

/// Whether a file is a table of results, by its name.
pub(super) fn is_table(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with(TABLE) && (name.ends_with(".csv") || name.ends_with(".jsonl"))
}

/// The two tables of a batch, to which a row is added as each job ends.
#[derive(Debug)]
pub(super) struct Tables {
    place: Place,
    files: [File; 2],
}

/// Where the tables of a batch are, and where they are made.
#[derive(Debug)]
pub(super) struct Place {
    csv: PathBuf,
    json_lines: PathBuf,
    staging: PathBuf,
}

impl Place {
    pub(super) fn new(folder: &Path, table: &str, staging: &Path) -> Self {
        let [csv, json_lines] = paths(folder, table);
        Self { csv, json_lines, staging: staging.to_owned() }
    }

    /// Writes both tables; returns the path of the CSV file.
    pub(super) fn write(&self, rows: &[Row]) -> anyhow::Result<PathBuf> {
        let mut lines = Vec::new();
        for row in rows {
            lines.extend(json_line(row)?);
        }
        for (path, content) in [(&self.csv, csv_lines(rows, true)?), (&self.json_lines, lines)] {
            // Made on the staging: there nothing stays if this is killed.
            let made = self.staging.join(path.file_name().unwrap_or(path.as_os_str()));
            io::write_whole(&made, &content)?;
            io::move_whole(&made, path)?;
        }
        Ok(self.csv.clone())
    }
}

impl Tables {
    /// Makes the tables with the rows that are there already.
    pub(super) fn start(place: Place, rows: &[Row]) -> anyhow::Result<Self> {
        place.write(rows)?;
        let open = |path: &Path| OpenOptions::new().append(true).open(path).map_err(failed(path));
        let files = [open(&place.csv)?, open(&place.json_lines)?];
        Ok(Self { place, files })
    }

    /// Adds a row, for whoever looks on.
    pub(super) fn add(&mut self, row: &Row) -> anyhow::Result<()> {
        let lines = [csv_lines(std::slice::from_ref(row), false)?, json_line(row)?];
        for ((file, line), path) in
            self.files.iter_mut().zip(lines).zip([&self.place.csv, &self.place.json_lines])
        {
            file.write_all(&line).map_err(failed(path))?;
        }
        Ok(())
    }

    /// Writes all rows in their order, in place of those that were added.
    pub(super) fn finish(self, rows: &[Row]) -> anyhow::Result<PathBuf> {
        let Self { place, files } = self;
        drop(files);
        place.write(rows)
    }
}

/// The tables of a batch: CSV, and JSON lines.
pub(super) fn paths(folder: &Path, table: &str) -> [PathBuf; 2] {
    ["csv", "jsonl"].map(|ending| folder.join(format!("{table}.{ending}")))
}

fn failed(path: &Path) -> impl FnOnce(stdio::Error) -> io::WriteError {
    |reason| io::WriteError::Io { path: path.to_owned(), reason }
}

fn csv_lines(rows: &[Row], header: bool) -> anyhow::Result<Vec<u8>> {
    let mut out = csv::WriterBuilder::new().has_headers(header).from_writer(Vec::new());
    for row in rows {
        out.serialize(row)?;
    }
    if rows.is_empty() && header {
        // The names of the columns come with the first row otherwise.
        out.write_record(COLUMNS)?;
    }
    Ok(out.into_inner().map_err(csv::IntoInnerError::into_error)?)
}

fn json_line(row: &Row) -> serde_json::Result<Vec<u8>> {
    let mut line = serde_json::to_vec(row)?;
    line.push(b'\n');
    Ok(line)
}

/// The columns of the tables, in their order.
const COLUMNS: [&str; 24] = [
    "job",
    "name",
    "input",
    "status",
    "message",
    "method",
    "points",
    "alpha",
    "p0",
    "iterations",
    "clusters",
    "primitive_cost",
    "outlier_prior",
    "merge",
    "surface",
    "isolated",
    "seed",
    "primitives",
    "mean_distance",
    "unassigned",
    "samples",
    "input_points",
    "input_faces",
    "seconds",
];

/// The rows of a table; lines that are none (the last one of a batch that was
/// killed) count as not there.
pub(super) fn read(json_lines: &Path) -> stdio::Result<Vec<Row>> {
    let bytes = fs::read(json_lines)?;
    Ok(bytes.split(|b| *b == b'\n').filter_map(|line| serde_json::from_slice(line).ok()).collect())
}

/// The rows of the table of that name, if it is there.
pub(super) fn earlier(folder: &Path, table: &str) -> Vec<Row> {
    read(&paths(folder, table)[1]).unwrap_or_default()
}

/// All tables of JSON lines in a folder, the oldest first.
pub(super) fn all_tables(folder: &Path) -> stdio::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if is_table(&path) && path.extension().is_some_and(|e| e == "jsonl") {
            found.push((fs::metadata(&path)?.modified()?, path));
        }
    }
    found.sort();
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::SamplingOptions;
    use crate::inference::Params;

    pub(in crate::cli::batch) fn job(number: usize, name: &str) -> Job {
        Job {
            number,
            name: name.to_owned(),
            input: PathBuf::from(format!("shapes/{name}.obj")),
            sampling: SamplingOptions::default(),
            params: Params::default(),
        }
    }

    #[test]
    fn rows_come_back_and_half_a_line_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let first =
            Row { mean_distance: Some(1.0 / 3.0), ..Row::failed(&job(1, "a, b"), "say \"no\"\n".into()) };
        let second = Row::cancelled(&job(2, "c"));
        let place = Place::new(folder.path(), "results", folder.path());
        let mut tables = Tables::start(place, &[]).unwrap();
        let header = fs::read_to_string(folder.path().join("results.csv")).unwrap();
        assert_eq!(header.trim_end(), COLUMNS.join(","));
        tables.add(&second).unwrap();
        tables.add(&first).unwrap();
        let path = folder.path().join("results.jsonl");
        let mut text = fs::read_to_string(&path).unwrap();
        text.push_str("{\"job\": 3, \"name");
        fs::write(&path, text).unwrap();
        assert_eq!(read(&path).unwrap(), [second.clone(), first.clone()]);
        let csv = tables.finish(&[first.clone(), second.clone()]).unwrap();
        assert_eq!(read(&path).unwrap(), [first.clone(), second.clone()]);
        let mut table = csv::Reader::from_path(csv).unwrap();
        assert_eq!(table.headers().unwrap().iter().collect::<Vec<_>>(), COLUMNS);
        let rows: Vec<Row> = table.deserialize().map(Result::unwrap).collect();
        assert_eq!(rows, [first, second]);
    }

    #[test]
    fn settings_that_are_not_read_have_no_value() {
        let mut job = job(1, "a");
        job.params = Method::Ems.params();
        let row = Row::failed(&job, String::new());
        assert_eq!((row.alpha, row.merge, row.outlier_prior), (None, None, Some(0.5)));
        assert_eq!(row.method, Some(Method::Ems));
    }
}
