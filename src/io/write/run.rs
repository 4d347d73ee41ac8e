//! The files of a run.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

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

/// Writes the three files of a run to a folder, which is created if missing, and
/// further files with formats from their names ([`Format::from_path`]): all
/// files or none.
///
/// # Errors
/// If one of them cannot be written or a name has no known format. Then none is
/// written, existing files are unchanged, and a folder created for them is
/// removed.
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
    stage_all(&mut writing, folder, more, outcome)?;
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
