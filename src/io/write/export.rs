//! Writing a result in a format of the registry.

use std::path::{Path, PathBuf};

use super::Outcome;
use super::atomic::Together;
use super::cloud::{Order, SegmentedCloud};
use super::formats::{ExportOptions, Format, Kind};
use super::params::{PrimitiveSet, primitives_text};
use crate::io::{ShapeGeometry, WriteError};

/// What was written.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Exported {
    /// The file that was asked for, and those beside it that it refers to.
    pub files: Vec<PathBuf>,
    /// What of the result the file can't say, one sentence each.
    pub notes: Vec<String>,
}

/// Writes the result to a file of the format, and the files that it refers to
/// (materials, meshes) beside it: all of them or none.
///
/// # Errors
/// Where a file can't be written, an option is out of its limits, the format
/// needs a mesh and the input is none, or the result has something that the
/// format can't hold.
pub fn export(
    path: &Path,
    format: Format,
    options: &ExportOptions,
    outcome: &Outcome<'_>,
) -> Result<Exported, WriteError> {
    let mut writing = Writing::default();
    writing.stage(path, format, options, Source::Outcome(outcome))?;
    writing.finish()
}

/// The same from primitives alone, of which no cloud and no mesh can be
/// written.
///
/// # Errors
/// As [`export`].
pub fn export_primitives(
    path: &Path,
    format: Format,
    options: &ExportOptions,
    set: &PrimitiveSet<'_>,
) -> Result<Exported, WriteError> {
    let mut writing = Writing::default();
    writing.stage(path, format, options, Source::Primitives(set))?;
    writing.finish()
}

/// Writes the result into a folder under several names, each of which tells
/// its format ([`Format::from_path`]): all files or none. The folder is made if
/// it isn't there.
///
/// # Errors
/// As [`export`], and where a name tells no format.
pub fn export_all(
    folder: &Path,
    names: &[String],
    options: &ExportOptions,
    outcome: &Outcome<'_>,
) -> Result<Exported, WriteError> {
    let mut writing = Writing::default();
    writing.files.folder(folder)?;
    for name in names {
        let path = folder.join(name);
        let format = Format::from_path(Path::new(name), None)
            .ok_or_else(|| WriteError::UnknownFormat { path: path.clone() })?;
        writing.stage(&path, format, options, Source::Outcome(outcome))?;
    }
    writing.finish()
}

/// About how many bytes the files will take; what is text or compressed is
/// estimated.
pub fn estimated_size(format: Format, options: &ExportOptions, outcome: &Outcome<'_>) -> u64 {
    let Outcome { shape, cloud, abstraction, .. } = outcome;
    let samples = cloud.points.len() as u64;
    let points = match &shape.geometry {
        ShapeGeometry::Mesh(_) => samples,
        ShapeGeometry::Cloud(input) => input.points.len() as u64,
    };
    let primitives = abstraction.primitives.len() as u64;
    let own = match &shape.geometry {
        ShapeGeometry::Mesh(_) => None,
        ShapeGeometry::Cloud(_) => options.input_attributes.then_some(&shape.attributes),
    };
    let (normals, labels, colors) = own.map_or((0, 0, 0), |a| {
        let one = |there: bool| u64::from(there);
        (one(a.normals.is_some()), one(a.labels.is_some()), one(a.colors.is_some()))
    });
    let shown = u64::from(options.colors);
    let row = |order: &Order| SegmentedCloud::new(outcome, options).map_or(0, |c| c.mean_row(order));
    match format {
        Format::CloudPly if options.binary => {
            points * (28 + 3 * shown + 12 * normals + 4 * labels + 3 * colors) + 400
        }
        Format::CloudPcd if options.binary => {
            let place = if options.doubles { 24 } else { 12 };
            points * (place + 4 + 4 * shown + 12 * normals + 4 * labels) + 300
        }
        Format::CloudPly | Format::CloudPcd | Format::CloudCsv => points * row(&Order::PLY) + 300,
        Format::CloudXyz => points * row(&Order::LABEL_LAST) + 60,
        // Coordinates hardly shrink, labels and colours to a small part.
        Format::CloudNpz => points * (23 + normals * 11 + labels + colors) + 1500,
        Format::PrimitivesJson | Format::PrimitivesCsv => {
            primitives_text(format, &PrimitiveSet::from(outcome)).map_or(0, |text| text.len() as u64)
        }
        Format::PrimitivesNpz => 2500 + 23 * samples + 200 * primitives,
        _ => 0,
    }
}

/// What is written from.
#[derive(Clone, Copy)]
enum Source<'a> {
    Outcome(&'a Outcome<'a>),
    Primitives(&'a PrimitiveSet<'a>),
}

impl<'a> Source<'a> {
    fn primitives(self) -> PrimitiveSet<'a> {
        match self {
            Self::Outcome(outcome) => PrimitiveSet::from(outcome),
            Self::Primitives(set) => *set,
        }
    }
}

/// Files that are being written, and what there is to say of them.
#[derive(Debug, Default)]
struct Writing {
    files: Together,
    notes: Vec<String>,
}

impl Writing {
    fn finish(self) -> Result<Exported, WriteError> {
        Ok(Exported { files: self.files.persist()?, notes: self.notes })
    }

    fn stage(
        &mut self,
        path: &Path,
        format: Format,
        options: &ExportOptions,
        source: Source<'_>,
    ) -> Result<(), WriteError> {
        options.check().map_err(|problem| WriteError::Content { path: path.to_owned(), problem })?;
        match format.kind() {
            Kind::Cloud => self.cloud(path, format, options, source),
            Kind::Primitives => self.primitives(path, format, &source.primitives()),
            Kind::Mesh | Kind::Scene => Err(WriteError::UnknownFormat { path: path.to_owned() }),
        }
    }

    fn cloud(
        &mut self,
        path: &Path,
        format: Format,
        options: &ExportOptions,
        source: Source<'_>,
    ) -> Result<(), WriteError> {
        let Source::Outcome(outcome) = source else {
            return Err(WriteError::OnlyPrimitives { path: path.to_owned(), format });
        };
        self.files.stage(path, |w| {
            let cloud = SegmentedCloud::new(outcome, options)?;
            match format {
                Format::CloudCsv => cloud.csv(w),
                Format::CloudXyz => cloud.xyz(w),
                Format::CloudPcd => cloud.pcd(w, options),
                Format::CloudNpz => cloud.npz(w),
                _ => cloud.ply(w, options.binary),
            }
        })
    }

    fn primitives(&mut self, path: &Path, format: Format, set: &PrimitiveSet<'_>) -> Result<(), WriteError> {
        self.files.stage(path, |w| match format {
            Format::PrimitivesNpz => set.npz(w),
            Format::PrimitivesCsv => set.csv(w),
            _ => set.json(w),
        })
    }
}
