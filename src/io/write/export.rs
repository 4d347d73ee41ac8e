//! Writing a result in a format of the table.

use std::path::{Path, PathBuf};

use super::atomic::unfit;
use super::cloud::{CloudCounts, SegmentedCloud};
use super::formats::{Format, PrimitivesFormat, Writer};
use super::options::ExportOptions;
use super::outcome::Outcome;
use super::parts::{Parts, PartsCounts, input_mesh};
use super::robot;
use super::writing::{Writing, content};
use crate::io::error::WriteError;
use crate::io::primitives::PrimitiveSet;

/// What was written.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Exported {
    /// The requested file, and the files it refers to.
    pub files: Vec<PathBuf>,
    /// What of the result the file can't say, one sentence each.
    pub notes: Vec<String>,
}

/// Writes the result to a file of the format, with the files it refers to
/// (materials, meshes) next to it: all or none.
///
/// # Errors
/// If a file cannot be written, an option is out of range, the format needs a
/// mesh but the input is not one, or the format cannot represent the result.
pub fn export(
    path: &Path,
    format: Format,
    options: &ExportOptions,
    outcome: &Outcome<'_>,
) -> Result<Exported, WriteError> {
    alone(path, format, options, Source::Outcome(outcome))
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
    alone(path, format, options, Source::Primitives(set))
}

/// Writes one file, and those that it refers to.
fn alone(
    path: &Path,
    format: Format,
    options: &ExportOptions,
    source: Source<'_>,
) -> Result<Exported, WriteError> {
    let mut writing = Writing::default();
    stage(&mut writing, path, format, options, source)?;
    finish(writing)
}

/// About how many bytes the files will take; what is text or compressed is
/// estimated.
pub fn estimated_size(format: Format, options: &ExportOptions, outcome: &Outcome<'_>) -> u64 {
    let primitives = outcome.abstraction.primitives.len() as u64;
    match format.writer() {
        Writer::Cloud(format) => (format.size)(&CloudCounts::of(outcome, options), options),
        Writer::Numbers(PrimitivesFormat::Text(_)) => {
            primitives_text(format, &PrimitiveSet::from(outcome)).map_or(0, |text| text.len() as u64)
        }
        Writer::Numbers(PrimitivesFormat::Archive(_)) => {
            2500 + 23 * outcome.cloud.points.len() as u64 + 200 * primitives
        }
        Writer::Mesh(format) => (format.size)(&PartsCounts::of_mesh(outcome, options), options),
        Writer::Surfaces(format) => (format.size)(&PartsCounts::of_surfaces(outcome, options), options),
        Writer::Robot(_) => robot::size(primitives, options),
    }
}

/// The primitives as a text, for the clipboard: JSON or CSV.
///
/// # Errors
/// Where the format has no text, or a primitive has a parameter that is not
/// valid.
pub fn primitives_text(format: Format, set: &PrimitiveSet<'_>) -> Result<String, WriteError> {
    let mut text = Vec::new();
    match format.writer() {
        Writer::Numbers(PrimitivesFormat::Text(write)) => write(&mut text, set),
        Writer::Numbers(PrimitivesFormat::Archive(_))
        | Writer::Cloud(_)
        | Writer::Mesh(_)
        | Writer::Surfaces(_)
        | Writer::Robot(_) => Err(unfit(format!("{format} is not a text format; use JSON or CSV"))),
    }
    .and_then(|()| String::from_utf8(text).map_err(|e| unfit(e.to_string())))
    .map_err(|e| WriteError::Content { path: Path::new("the text").to_owned(), problem: e.to_string() })
}

/// The files that [`export`] would write over, as far as they are there, and the
/// one that it is for.
pub fn outputs(path: &Path, format: Format, options: &ExportOptions) -> Vec<PathBuf> {
    let mut outputs = vec![path.to_owned()];
    match format.writer() {
        Writer::Mesh(format) | Writer::Surfaces(format) => outputs.extend((format.beside)(path, options)),
        Writer::Robot(_) => outputs.extend(robot::meshes_there(path)),
        Writer::Cloud(_) | Writer::Numbers(_) => {}
    }
    outputs
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

    fn outcome(self, path: &Path, format: Format) -> Result<&'a Outcome<'a>, WriteError> {
        match self {
            Self::Outcome(outcome) => Ok(outcome),
            Self::Primitives(_) => {
                Err(WriteError::OnlyPrimitives { path: path.to_owned(), format: format.name() })
            }
        }
    }
}

/// Adds files of a folder, each in the format that its name tells.
pub(super) fn stage_all(
    writing: &mut Writing,
    folder: &Path,
    names: &[String],
    outcome: &Outcome<'_>,
) -> Result<(), WriteError> {
    for name in names {
        let path = folder.join(name);
        let format = Format::from_path(Path::new(name), None)
            .ok_or_else(|| WriteError::UnknownFormat { path: path.clone() })?;
        stage(writing, &path, format, &ExportOptions::default(), Source::Outcome(outcome))?;
    }
    Ok(())
}

pub(super) fn finish(writing: Writing) -> Result<Exported, WriteError> {
    Ok(Exported { files: writing.files.persist()?, notes: writing.notes })
}

fn stage(
    writing: &mut Writing,
    path: &Path,
    format: Format,
    options: &ExportOptions,
    source: Source<'_>,
) -> Result<(), WriteError> {
    options.check().map_err(|problem| WriteError::Content { path: path.to_owned(), problem })?;
    match format.writer() {
        Writer::Cloud(writer) => {
            let outcome = source.outcome(path, format)?;
            let cloud = SegmentedCloud::new(outcome, options).map_err(content(path))?;
            (writer.write)(writing, path, &cloud, options)
        }
        Writer::Numbers(PrimitivesFormat::Text(write)) => {
            writing.files.stage(path, |w| write(w, &source.primitives()))
        }
        Writer::Numbers(PrimitivesFormat::Archive(write)) => {
            writing.files.stage(path, |w| write(w, &source.primitives()))
        }
        Writer::Mesh(writer) => {
            let outcome = source.outcome(path, format)?;
            let mesh = input_mesh(outcome)
                .ok_or_else(|| WriteError::NeedsMesh { path: path.to_owned(), format: format.name() })?;
            let parts = Parts::of_mesh(mesh, outcome, options).map_err(content(path))?;
            (writer.write)(writing, path, &parts, options)
        }
        Writer::Surfaces(writer) => {
            let parts =
                Parts::of_primitives(&source.primitives(), options.surface()).map_err(content(path))?;
            (writer.write)(writing, path, &parts, options)
        }
        Writer::Robot(model) => {
            robot::stage(writing, path, (format.name(), model), options, &source.primitives())
        }
    }
}
