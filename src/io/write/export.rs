//! Exports a result in one of the registered formats.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::atomic::Together;
use super::cloud::{SegmentedCloud, mean_place};
use super::formats::{ExportOptions, Format, Kind};
use super::params::{PrimitiveSet, primitives_text};
use super::parts::{Parts, input_mesh};
use super::place::is_written_through;
use super::robot::{self, Robot};
use super::{Outcome, glb, meshes};
use crate::io::{ShapeGeometry, WriteError};

/// What was written.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Exported {
    /// The requested file, and the files it refers to.
    pub files: Vec<PathBuf>,
    /// What of the result the file can't say, one sentence each.
    pub notes: Vec<String>,
}

/// Writes the result to a file of the format, with the files it refers to (materials, meshes) next to it: all or none.
///
/// # Errors
/// If a file cannot be written, an option is out of range, the format needs a mesh but the input is not one, or the format cannot represent the result.
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
    writing.stage(path, format, options, source)?;
    writing.finish()
}

/// Writes the result to a folder under several names, which determine the formats ([`Format::from_path`]): all files or none. The folder is created if missing.
///
/// # Errors
/// As [`export`], or if a name has no known format.
pub fn export_all(
    folder: &Path,
    names: &[String],
    options: &ExportOptions,
    outcome: &Outcome<'_>,
) -> Result<Exported, WriteError> {
    let mut writing = Writing::default();
    writing.files.folder(folder)?;
    writing.all(folder, names, options, outcome)?;
    writing.finish()
}

/// About how many bytes the files will take; what is text or compressed is
/// estimated.
pub fn estimated_size(format: Format, options: &ExportOptions, outcome: &Outcome<'_>) -> u64 {
    let Outcome { shape, cloud, abstraction, .. } = outcome;
    let samples = cloud.points.len() as u64;
    let (points, vertices, faces) = match &shape.geometry {
        ShapeGeometry::Mesh(mesh) => (&cloud.points, &mesh.vertices, mesh.faces.len() as u64),
        ShapeGeometry::Cloud(input) => (&input.points, &input.points, 0),
    };
    let count = points.len() as u64;
    let primitives = abstraction.primitives.len() as u64;
    let own = match &shape.geometry {
        ShapeGeometry::Mesh(_) => None,
        ShapeGeometry::Cloud(_) => options.input_attributes.then_some(&shape.attributes),
    };
    let one = |there: bool| u64::from(there);
    let (normals, labels, tints) = own
        .map_or((0, 0, 0), |a| (one(a.normals.is_some()), one(a.labels.is_some()), one(a.colors.is_some())));
    let shown = one(options.colors);
    let row = || mean_place(points) + 3 + 12 * shown + 36 * normals + 4 * labels + 12 * tints;
    let surface = options.surface();
    let (v, f) = match format.kind() {
        Kind::Scene => (primitives * surface.vertices() as u64, primitives * surface.faces_len() as u64),
        // How much cutting adds depends on the boundaries.
        _ if options.split_boundaries => (vertices.len() as u64 + 8 * samples, faces + 16 * samples),
        _ => (vertices.len() as u64, faces),
    };
    // Bytes of a normal, of a place as text, of a number as text.
    let normal = one(format.kind() == Kind::Scene);
    let place = if normal == 1 { 57 } else { mean_place(vertices) };
    let digits = 1 + u64::from(v.max(1).ilog10());
    match format {
        Format::CloudPly if options.binary => {
            count * (28 + 3 * shown + 12 * normals + 4 * labels + 3 * tints) + 400
        }
        Format::CloudPcd if options.binary => {
            let place = if options.doubles { 24 } else { 12 };
            count * (place + 4 + 4 * shown + 12 * normals + 4 * labels) + 300
        }
        Format::CloudPly | Format::CloudPcd | Format::CloudCsv | Format::CloudXyz => count * row() + 300,
        // Coordinates hardly shrink, labels and colours to a small part.
        Format::CloudNpz => count * (23 + normals * 11 + labels + tints) + 1500,
        Format::PrimitivesJson | Format::PrimitivesCsv => {
            primitives_text(format, &PrimitiveSet::from(outcome)).map_or(0, |text| text.len() as u64)
        }
        Format::PrimitivesNpz => 2500 + 23 * samples + 200 * primitives,
        Format::MeshPly | Format::SurfacesPly if options.binary => {
            v * (24 + 12 * normal) + f * (17 + 3 * shown) + 400
        }
        Format::MeshPly | Format::SurfacesPly => {
            v * (place + 36 * normal) + f * (3 * digits + 8 + 12 * shown) + 400
        }
        Format::MeshObj | Format::SurfacesObj => {
            v * (place + 2 + 36 * normal)
                + f * (3 * digits + 5 + (3 * digits + 6) * normal)
                + 100 * primitives
        }
        Format::MeshGlb | Format::SurfacesGlb => v * (12 + 12 * normal) + f * 12 + 700 * primitives + 400,
        Format::MeshStl | Format::SurfacesStl if options.binary => 84 + 50 * f,
        Format::MeshStl | Format::SurfacesStl => f * (3 * place + 100),
        Format::Urdf | Format::Mjcf => robot::size(primitives, options),
    }
}

/// The files that [`export`] would write over, as far as they are there, and the
/// one that it is for.
pub fn outputs(path: &Path, format: Format, options: &ExportOptions) -> Vec<PathBuf> {
    let mut outputs = vec![path.to_owned()];
    if matches!(format, Format::MeshObj | Format::SurfacesObj) && options.colors {
        outputs.extend(materials(path));
    }
    if matches!(format, Format::Urdf | Format::Mjcf) {
        let there = fs::read_dir(robot::meshes_folder(path)).into_iter().flatten().flatten();
        outputs.extend(there.filter(|entry| robot::is_mesh(&entry.file_name())).map(|entry| entry.path()));
    }
    outputs
}

/// The colour file next to an OBJ, if one can be written.
fn materials(path: &Path) -> Option<PathBuf> {
    // The OBJ is text, and must be able to name it.
    let name = path.with_extension("mtl").file_name()?.to_string_lossy().into_owned();
    (!is_written_through(path)).then(|| path.with_file_name(name))
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
            Self::Primitives(_) => Err(WriteError::OnlyPrimitives { path: path.to_owned(), format }),
        }
    }
}

/// What can't be written says so of its file.
fn content(path: &Path) -> impl Fn(io::Error) -> WriteError {
    move |e| WriteError::Content { path: path.to_owned(), problem: e.to_string() }
}

/// Files that are being written, and what there is to say of them.
#[derive(Debug, Default)]
pub(super) struct Writing {
    pub(super) files: Together,
    notes: Vec<String>,
}

impl Writing {
    /// Adds files of a folder, with formats from their names.
    pub(super) fn all(
        &mut self,
        folder: &Path,
        names: &[String],
        options: &ExportOptions,
        outcome: &Outcome<'_>,
    ) -> Result<(), WriteError> {
        for name in names {
            let path = folder.join(name);
            let format = Format::from_path(Path::new(name), None)
                .ok_or_else(|| WriteError::UnknownFormat { path: path.clone() })?;
            self.stage(&path, format, options, Source::Outcome(outcome))?;
        }
        Ok(())
    }

    pub(super) fn finish(self) -> Result<Exported, WriteError> {
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
            Kind::Mesh => {
                let outcome = source.outcome(path, format)?;
                let mesh = input_mesh(outcome)
                    .ok_or_else(|| WriteError::NeedsMesh { path: path.to_owned(), format })?;
                let parts = Parts::of_mesh(mesh, outcome, options).map_err(content(path))?;
                self.parts(path, format, options, &parts)
            }
            Kind::Scene if matches!(format, Format::Urdf | Format::Mjcf) => {
                self.robot(path, format, options, &source.primitives())
            }
            Kind::Scene => {
                let set = source.primitives();
                let parts = Parts::of_primitives(&set, options.surface()).map_err(content(path))?;
                self.parts(path, format, options, &parts)
            }
        }
    }

    fn cloud(
        &mut self,
        path: &Path,
        format: Format,
        options: &ExportOptions,
        source: Source<'_>,
    ) -> Result<(), WriteError> {
        let outcome = source.outcome(path, format)?;
        let cloud = SegmentedCloud::new(outcome, options).map_err(content(path))?;
        if format == Format::CloudPcd && !options.doubles {
            self.notes.extend(cloud.single_precision().map_err(content(path))?);
        }
        self.files.stage(path, |w| match format {
            Format::CloudCsv => cloud.csv(w),
            Format::CloudXyz => cloud.xyz(w),
            Format::CloudPcd => cloud.pcd(w, options),
            Format::CloudNpz => cloud.npz(w),
            _ => cloud.ply(w, options.binary),
        })
    }

    /// A mesh in parts, of the input or of the primitives.
    fn parts(
        &mut self,
        path: &Path,
        format: Format,
        options: &ExportOptions,
        parts: &Parts,
    ) -> Result<(), WriteError> {
        let ExportOptions { binary, colors, .. } = *options;
        match format {
            Format::MeshPly | Format::SurfacesPly => {
                self.files.stage(path, |w| meshes::ply(w, parts, binary, colors))
            }
            Format::MeshGlb | Format::SurfacesGlb => {
                self.notes.extend(glb::single_precision(parts).map_err(content(path))?);
                self.files.stage(path, |w| glb::glb(w, parts, colors))
            }
            Format::MeshStl | Format::SurfacesStl if !binary => {
                self.files.stage(path, |w| meshes::stl_text(w, parts))
            }
            Format::MeshStl | Format::SurfacesStl => {
                self.notes.extend(parts.single_precision().map_err(content(path))?);
                self.files.stage(path, |w| meshes::stl_binary(w, parts, colors))
            }
            _ => {
                let materials = materials(path).filter(|_| colors);
                if colors && materials.is_none() {
                    let lost = "an OBJ stores its colours in a second file, which cannot be \
                         written here; they are omitted";
                    self.notes.push(lost.to_owned());
                }
                let name = materials.as_deref().and_then(Path::file_name).map(|n| n.to_string_lossy());
                self.files.stage(path, |w| meshes::obj(w, parts, name.as_deref()))?;
                match materials {
                    Some(materials) => self.files.stage(&materials, |w| meshes::mtl(w, parts)),
                    None => Ok(()),
                }
            }
        }
    }

    fn robot(
        &mut self,
        path: &Path,
        format: Format,
        options: &ExportOptions,
        set: &PrimitiveSet<'_>,
    ) -> Result<(), WriteError> {
        if is_written_through(path) {
            let problem = format!(
                "{format} stores meshes in separate files, which cannot be written here; give a file name"
            );
            return Err(WriteError::Content { path: path.to_owned(), problem });
        }
        let robot = Robot::new(set, options, robot::name(path)).map_err(content(path))?;
        let text = if format == Format::Urdf { robot.urdf() } else { robot.mjcf() };
        self.files.stage(path, |w| w.write_all(text.as_bytes()))?;
        let folder = robot::meshes_folder(path);
        self.files.folder(&folder)?;
        for (name, mesh) in robot.meshes() {
            self.files.stage(&folder.join(name), |w| meshes::stl_binary(w, mesh, false))?;
        }
        self.notes.extend(robot.notes());
        Ok(())
    }

    fn primitives(&mut self, path: &Path, format: Format, set: &PrimitiveSet<'_>) -> Result<(), WriteError> {
        self.files.stage(path, |w| match format {
            Format::PrimitivesNpz => set.npz(w),
            Format::PrimitivesCsv => set.csv(w),
            _ => set.json(w),
        })
    }
}
