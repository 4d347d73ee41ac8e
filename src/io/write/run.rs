//! The files of a run.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::atomic::Staged;
use super::cloud::SegmentedCloud;
use super::export::{Exported, finish, outputs, stage_all};
use super::formats::Format;
use super::options::ExportOptions;
use super::outcome::Outcome;
use super::report::{RunRecord, report_json};
use super::writing::Writing;
use crate::io::error::WriteError;
use crate::io::names::{PRIMITIVES_FILE, REPORT_FILE, SEGMENTED_FILE};
use crate::io::primitives::{PrimitiveSet, json};

/// Writes the segmented cloud as binary little-endian PLY: for each point
/// `x y z` (double, input units), `red green blue` (uchar, the palette's
/// colour of the primitive) and `label` (int, the primitive's id in
/// `primitives.json`; −1 where the point belongs to none); then, where the
/// input says so of its points, `nx ny nz` (float), `input_label` and
/// `input_red input_green input_blue`.
///
/// For an input cloud these are all its points in input order, each with the
/// label of the sample that stands for it; points that are not finite are
/// written as they were, with label −1. For an input mesh its samples are the
/// cloud.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_segmented_ply(path: &Path, outcome: &Outcome<'_>) -> Result<(), WriteError> {
    Staged::with(path, |w| segmented_ply(w, outcome))?.persist()
}

/// Writes the primitives as JSON: `{"format": "superform-primitives",
/// "version": 1, …, "primitives": [{"id", "eps": [ε1, ε2], "scale": [ax, ay,
/// az], "rotation": [rows of world_from_local], "translation", "taper": [kx,
/// ky], "sigma", "points", "mean_distance"}]}`, lengths in input units. The
/// same run gives the same bytes. The schema is `docs/primitives.schema.json`.
///
/// # Errors
/// Where the file can't be written or a primitive has a parameter that is not
/// finite. It is written whole or not at all.
pub fn write_primitives_json(path: &Path, outcome: &Outcome<'_>) -> Result<(), WriteError> {
    Staged::with(path, |w| json::write(w, &PrimitiveSet::from(outcome)))?.persist()
}

/// Writes the three files of a run into a folder, which is made if it isn't
/// there, and more under names that tell their formats
/// ([`Format::from_path`]): all files or none.
///
/// # Errors
/// Where one of them can't be written or a name tells no format; then none is,
/// what stood there stays, and a folder made for them is gone again.
pub fn write_run(
    folder: &Path,
    more: &[String],
    outcome: &Outcome<'_>,
    record: &RunRecord,
) -> Result<Exported, WriteError> {
    let mut writing = Writing::default();
    writing.files.folder(folder)?;
    writing.files.stage(&folder.join(SEGMENTED_FILE), |w| segmented_ply(w, outcome))?;
    writing.files.stage(&folder.join(PRIMITIVES_FILE), |w| json::write(w, &PrimitiveSet::from(outcome)))?;
    writing.files.stage(&folder.join(REPORT_FILE), |w| report_json(w, folder, outcome, record))?;
    stage_all(&mut writing, folder, more, &ExportOptions::default(), outcome)?;
    finish(writing)
}

/// The files that [`write_run`] would write over, and those that it is for.
pub fn run_outputs(folder: &Path, more: &[String]) -> Vec<PathBuf> {
    let more = more.iter().flat_map(|name| {
        let format = Format::from_path(Path::new(name), None);
        format.map(|format| outputs(&folder.join(name), format, &ExportOptions::default()))
    });
    let own = [SEGMENTED_FILE, PRIMITIVES_FILE, REPORT_FILE].map(|name| folder.join(name));
    own.into_iter().chain(more.flatten()).collect()
}

fn segmented_ply(w: &mut impl Write, outcome: &Outcome<'_>) -> io::Result<()> {
    SegmentedCloud::new(outcome, &ExportOptions::default())?.ply(w, true)
}
