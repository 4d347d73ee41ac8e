//! Results as files: the segmented cloud and mesh, the primitives, the report.

mod animation;
mod atomic;
mod cloud;
mod export;
mod formats;
mod glb;
mod meshes;
mod npy;
mod params;
mod parts;
mod place;
mod report;
mod robot;
mod standard;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

pub use animation::{AnimationFormat, AnimationWriter, LARGEST_GIF};
pub use atomic::{move_whole, write_streamed, write_whole};
pub use export::{Exported, estimated_size, export, export_all, export_primitives, outputs};
pub use formats::{Choice, ExportOptions, Format, Kind};
pub(super) use params::PrimitiveEntry;
pub use params::{PrimitiveSet, primitives_text};
pub use place::{is_standard_output, is_written_through};
pub use report::{PhaseTimes, RunRecord, write_report_json};
pub use standard::print;

use self::atomic::Staged;
use self::cloud::SegmentedCloud;
use self::export::Writing;
use super::{Shape, WriteError};
use crate::geometry::palette::Colors;
use crate::geometry::{SampleCloud, SamplingOptions};
use crate::inference::{Abstraction, Params};

/// Names of the files that [`write_run`] puts into a folder.
pub const SEGMENTED_FILE: &str = "segmented.ply";
pub const PRIMITIVES_FILE: &str = "primitives.json";
pub const REPORT_FILE: &str = "report.json";

/// A state of a run with its inputs, from which the files are written.
#[derive(Debug, Clone, Copy)]
pub struct Outcome<'a> {
    /// Of the primitives and their points.
    pub colors: &'a Colors,
    pub shape: &'a Shape,
    pub cloud: &'a SampleCloud,
    pub sampling: SamplingOptions,
    pub params: &'a Params,
    pub abstraction: &'a Abstraction,
}

/// Writes the segmented cloud as binary little-endian PLY: for each point
/// `x y z` (double, input units), `red green blue` (uchar, the palette's
/// colour of the primitive) and `label` (int, the primitive's id in
/// `primitives.json`; −1 where the point belongs to none); then, where the
/// input says so of its points, `nx ny nz` (float), `input_label` and
/// `input_red input_green input_blue`.
/// For an input cloud: all its points in input order, each with the label of its sample. Non-finite points are written unchanged, with label −1. For an input mesh its samples are the
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
    Staged::with(path, |w| PrimitiveSet::from(outcome).json(w))?.persist()
}

/// Writes a picture as PNG.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_picture(path: &Path, picture: &image::RgbaImage) -> Result<(), WriteError> {
    Staged::with(path, |w| picture.write_to(w, image::ImageFormat::Png).map_err(io::Error::other))?.persist()
}

/// Writes the three files of a run to a folder, which is created if missing, and further files with formats from their names ([`Format::from_path`]): all files or none.
///
/// # Errors
/// If one of them cannot be written or a name has no known format. Then none is written, existing files are unchanged, and a folder created for them is removed.
pub fn write_run(
    folder: &Path,
    more: &[String],
    outcome: &Outcome<'_>,
    record: &RunRecord,
) -> Result<Exported, WriteError> {
    let mut writing = Writing::default();
    writing.files.folder(folder)?;
    writing.files.stage(&folder.join(SEGMENTED_FILE), |w| segmented_ply(w, outcome))?;
    writing.files.stage(&folder.join(PRIMITIVES_FILE), |w| PrimitiveSet::from(outcome).json(w))?;
    writing.files.stage(&folder.join(REPORT_FILE), |w| report::report_json(w, folder, outcome, record))?;
    writing.all(folder, more, &ExportOptions::default(), outcome)?;
    writing.finish()
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

fn json(w: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *w, value)?;
    writeln!(w)
}
