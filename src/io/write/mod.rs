//! Results as files: the segmented cloud, the primitives, the report.

mod animation;

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

pub use animation::{AnimationFormat, AnimationWriter, LARGEST_GIF};

use super::read::primitives;
use super::{Shape, ShapeGeometry, WriteError};
use crate::geometry::palette::{Colors, UNASSIGNED_COLOR};
use crate::geometry::{Isolated, SampleCloud, SampledPart, SamplingOptions, Surface};
use crate::inference::{Abstraction, MergeReport, Method, Params, Phase, Primitive, UNASSIGNED};

/// Names of the files that [`write_run`] puts into a folder.
pub const SEGMENTED_FILE: &str = "segmented.ply";
pub const PRIMITIVES_FILE: &str = "primitives.json";
pub const REPORT_FILE: &str = "report.json";

/// A state of a run with all that it came from: what the files are made of.
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

/// How a run went, for the report.
#[derive(Debug, Clone, Default)]
pub struct RunRecord {
    /// K at the start and after each iteration (or step of a baseline).
    pub clusters: Vec<usize>,
    pub merges: Vec<MergeReport>,
    pub times: PhaseTimes,
}

/// Time that each phase of a run took.
#[derive(Debug, Clone, Copy, Default)]
pub struct PhaseTimes {
    pub read: Duration,
    pub sample: Duration,
    /// Normalisation and k-means.
    pub start: Duration,
    /// Gibbs iterations, with the merge passes between them, or the steps of a
    /// baseline.
    pub iterations: Duration,
    /// The merges after the last iteration.
    pub merge: Duration,
}

/// Writes the segmented cloud as binary little-endian PLY: for each point
/// `x y z` (double, input units), `red green blue` (uchar, the palette's
/// colour of the primitive) and `label` (int, the primitive's id in
/// `primitives.json`; −1 where the point belongs to none).
///
/// For an input cloud these are all its points in input order, each with the
/// label of the sample that stands for it; points that are not finite are
/// written as they were, with label −1. For an input mesh its samples are the
/// cloud.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_segmented_ply(path: &Path, outcome: &Outcome<'_>) -> Result<(), WriteError> {
    let file = staged(path, |w| segmented_ply(w, outcome))?;
    persist(file, path)
}

/// Writes the primitives as JSON: `{"format": "superform-primitives",
/// "version": 1, …, "primitives": [{"id", "eps": [ε1, ε2], "scale": [ax, ay,
/// az], "rotation": [rows of world_from_local], "translation", "taper": [kx,
/// ky], "sigma", "points", "mean_distance"}]}`, lengths in input units. The
/// same run gives the same bytes.
///
/// # Errors
/// Where the file can't be written or a primitive has a parameter that is not
/// finite. It is written whole or not at all.
pub fn write_primitives_json(path: &Path, outcome: &Outcome<'_>) -> Result<(), WriteError> {
    let file = staged(path, |w| primitives_json(w, outcome))?;
    persist(file, path)
}

/// Writes a picture as PNG.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_picture(path: &Path, picture: &image::RgbaImage) -> Result<(), WriteError> {
    let file = staged(path, |w| picture.write_to(w, image::ImageFormat::Png).map_err(io::Error::other))?;
    persist(file, path)
}

/// Writes some bytes as a file.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), WriteError> {
    let file = staged(path, |w| w.write_all(content))?;
    persist(file, path)
}

/// Writes a file piece by piece.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_streamed(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    let file = staged(path, |w| content(w))?;
    persist(file, path)
}

/// Writes the report of a run as JSON: input, sampling (of a mesh also which
/// part of its surface, and what share of the area was left out, of a cloud
/// how many isolated points), method,
/// parameters, seed, number of points, K by iteration, merges, seconds a phase, unassigned
/// points and mean distance.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_report_json(path: &Path, outcome: &Outcome<'_>, record: &RunRecord) -> Result<(), WriteError> {
    let file = staged(path, |w| report_json(w, outcome, record))?;
    persist(file, path)
}

/// Writes all three files into a folder, which is made if it isn't there; all
/// of them or none. Returns their paths.
///
/// # Errors
/// Where one of them can't be written; then none is, and a folder made for
/// them is gone again.
pub fn write_run(
    folder: &Path,
    outcome: &Outcome<'_>,
    record: &RunRecord,
) -> Result<[PathBuf; 3], WriteError> {
    let made = !folder.exists();
    fs::create_dir_all(folder).map_err(|reason| WriteError::Io { path: folder.to_owned(), reason })?;
    let paths = [SEGMENTED_FILE, PRIMITIVES_FILE, REPORT_FILE].map(|name| folder.join(name));
    let mut placed: Vec<&Path> = Vec::new();
    let written = (|| {
        // All content is on disk, under temporary names, before the first of
        // the names is taken.
        let files = [
            staged(&paths[0], |w| segmented_ply(w, outcome))?,
            staged(&paths[1], |w| primitives_json(w, outcome))?,
            staged(&paths[2], |w| report_json(w, outcome, record))?,
        ];
        for (file, path) in files.into_iter().zip(&paths) {
            persist(file, path)?;
            placed.push(path);
        }
        Ok(())
    })();
    if written.is_err() {
        for path in placed {
            let _ = fs::remove_file(path);
        }
    }
    if written.is_err() && made {
        // Only goes if it is empty, as it should be.
        let _ = fs::remove_dir(folder);
    }
    written.map(|()| paths)
}

/// A temporary file with the content, in the folder of `path`. It goes when
/// it is dropped.
fn staged(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<&mut fs::File>) -> io::Result<()>,
) -> Result<NamedTempFile, WriteError> {
    let failed = |reason| WriteError::Io { path: path.to_owned(), reason };
    if path.is_dir() {
        return Err(WriteError::IsAFolder { path: path.to_owned() });
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".superform-").suffix(".part");
    // Temporary files are private by default; results follow the umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The kind alone: the full text names the temporary file, which means nothing to anybody.
    let mut file = builder.tempfile_in(folder).map_err(|e| failed(e.kind().into()))?;
    let mut writer = BufWriter::with_capacity(1 << 18, file.as_file_mut());
    content(&mut writer).and_then(|()| writer.flush()).map_err(failed)?;
    drop(writer);
    file.as_file().sync_all().map_err(failed)?;
    Ok(file)
}

/// Gives a temporary file its name, in place of what stood there.
fn persist(file: NamedTempFile, path: &Path) -> Result<(), WriteError> {
    file.persist(path).map(drop).map_err(|e| WriteError::Io { path: path.to_owned(), reason: e.error })
}

/// What can't be said in a file is an error of its content.
fn unfit(problem: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem.into())
}

fn segmented_ply(w: &mut impl Write, outcome: &Outcome<'_>) -> io::Result<()> {
    let Outcome { shape, cloud, abstraction, colors, .. } = *outcome;
    let points = match &shape.geometry {
        ShapeGeometry::Mesh(_) => &cloud.points,
        ShapeGeometry::Cloud(input) => &input.points,
    };
    let labels = cloud.labels_of_input(&abstraction.labels, UNASSIGNED);
    if labels.len() != points.len() {
        return Err(unfit("the labels belong to another cloud"));
    }
    write!(
        w,
        "ply\nformat binary_little_endian 1.0\ncomment superform {}\n\
         comment label: id of the primitive, -1 for none\nelement vertex {}\n\
         property double x\nproperty double y\nproperty double z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         property int label\nend_header\n",
        env!("CARGO_PKG_VERSION"),
        points.len()
    )?;
    for (p, &label) in points.iter().zip(&labels) {
        let (color, label) = if label == UNASSIGNED {
            (UNASSIGNED_COLOR, -1)
        } else {
            (colors.of(label), i32::try_from(label).map_err(|_| unfit("an id is too large for a label"))?)
        };
        for c in p.iter() {
            w.write_all(&c.to_le_bytes())?;
        }
        w.write_all(&color)?;
        w.write_all(&label.to_le_bytes())?;
    }
    Ok(())
}

/// One entry of `primitives.json`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct PrimitiveEntry {
    pub(in crate::io) id: u32,
    pub(in crate::io) eps: [f64; 2],
    pub(in crate::io) scale: [f64; 3],
    pub(in crate::io) rotation: [[f64; 3]; 3],
    pub(in crate::io) translation: [f64; 3],
    pub(in crate::io) taper: [f64; 2],
    pub(in crate::io) sigma: f64,
    pub(in crate::io) points: usize,
    pub(in crate::io) mean_distance: f64,
}

impl PrimitiveEntry {
    fn new(p: &Primitive) -> io::Result<Self> {
        if !(p.shape.is_valid() && p.sigma.is_finite() && p.mean_distance.is_finite()) {
            return Err(unfit(format!("primitive {} has a parameter that is not valid", p.id)));
        }
        let rotation = p.shape.rotation.matrix();
        Ok(Self {
            id: p.id,
            eps: p.shape.exponents,
            scale: p.shape.semi_axes.into(),
            rotation: [0, 1, 2].map(|row| [0, 1, 2].map(|column| rotation[(row, column)])),
            translation: p.shape.translation.into(),
            taper: p.shape.taper,
            sigma: p.sigma,
            points: p.points,
            mean_distance: p.mean_distance,
        })
    }
}

#[derive(Debug, Serialize)]
struct PrimitivesFile<'a> {
    format: &'static str,
    version: u32,
    program: &'static str,
    input: &'a str,
    units: &'static str,
    rotation: &'static str,
    seed: u64,
    points: usize,
    sampling_seed: u64,
    method: Option<Method>,
    params: &'a Params,
    primitives: Vec<PrimitiveEntry>,
}

fn primitives_json(w: &mut impl Write, outcome: &Outcome<'_>) -> io::Result<()> {
    let file = PrimitivesFile {
        format: primitives::FORMAT,
        version: primitives::VERSION,
        program: concat!("superform ", env!("CARGO_PKG_VERSION")),
        input: &outcome.shape.name,
        units: "those of the input",
        rotation: "world from local, rows",
        seed: outcome.params.seed,
        points: outcome.cloud.points.len(),
        sampling_seed: outcome.sampling.seed,
        method: Method::of(outcome.params),
        params: outcome.params,
        primitives: outcome
            .abstraction
            .primitives
            .iter()
            .map(PrimitiveEntry::new)
            .collect::<Result<_, _>>()?,
    };
    json(w, &file)
}

#[derive(Debug, Serialize)]
struct ReportFile<'a> {
    format: &'static str,
    version: u32,
    program: &'static str,
    input: InputEntry<'a>,
    /// `null` where the parameters are those of no named method.
    method: Option<Method>,
    params: &'a Params,
    seed: u64,
    sampling_seed: u64,
    points_wanted: usize,
    points: usize,
    /// Of a mesh.
    surface: Option<SurfaceEntry>,
    /// Of a cloud.
    isolated: Option<IsolatedEntry>,
    phase: Phase,
    iterations: u32,
    clusters_at_iteration: &'a [usize],
    merges: &'a [MergeReport],
    primitives: usize,
    unassigned_points: usize,
    unassigned_input_points: usize,
    mean_distance: f64,
    seconds: Seconds,
}

#[derive(Debug, Serialize)]
struct InputEntry<'a> {
    name: &'a str,
    path: Option<&'a Path>,
    kind: &'static str,
    points: usize,
    faces: usize,
    notes: &'a [String],
}

/// What of a mesh was sampled.
#[derive(Debug, Serialize)]
struct SurfaceEntry {
    asked_for: Surface,
    sampled: Surface,
    area_left_out: f64,
    note: Option<String>,
}

impl SurfaceEntry {
    fn new(asked_for: Surface, part: &SampledPart) -> Self {
        let sampled = match part {
            SampledPart::Outside { .. } => Surface::Outside,
            SampledPart::Whole | SampledPart::Connected { .. } | SampledPart::WholeAsHidden => Surface::All,
        };
        Self { asked_for, sampled, area_left_out: part.left_out(), note: part.note() }
    }
}

/// What became of a cloud's isolated points.
#[derive(Debug, Serialize)]
struct IsolatedEntry {
    asked_for: Isolated,
    points_left_out: usize,
    /// Those of them that no sample stands for.
    points_unlabelled: usize,
    note: Option<String>,
}

impl IsolatedEntry {
    fn new(asked_for: Isolated, part: &SampledPart) -> Self {
        let (points_left_out, points_unlabelled) = match *part {
            SampledPart::Connected { isolated, unlabelled, .. } => (isolated, unlabelled),
            SampledPart::Whole | SampledPart::Outside { .. } | SampledPart::WholeAsHidden => (0, 0),
        };
        Self { asked_for, points_left_out, points_unlabelled, note: part.note() }
    }
}

#[derive(Debug, Serialize)]
struct Seconds {
    read: f64,
    sample: f64,
    start: f64,
    iterations: f64,
    merge: f64,
}

fn report_json(w: &mut impl Write, outcome: &Outcome<'_>, record: &RunRecord) -> io::Result<()> {
    let Outcome { shape, cloud, sampling, params, abstraction, .. } = *outcome;
    let (kind, points, faces) = match &shape.geometry {
        ShapeGeometry::Mesh(mesh) => ("mesh", mesh.vertices.len(), mesh.faces.len()),
        ShapeGeometry::Cloud(input) => ("cloud", input.points.len(), 0),
    };
    let labels = cloud.labels_of_input(&abstraction.labels, UNASSIGNED);
    let times = &record.times;
    let file = ReportFile {
        format: "superform-report",
        version: 1,
        program: concat!("superform ", env!("CARGO_PKG_VERSION")),
        input: InputEntry {
            name: &shape.name,
            path: shape.path.as_deref(),
            kind,
            points,
            faces,
            notes: &shape.notes,
        },
        method: Method::of(params),
        params,
        seed: params.seed,
        sampling_seed: sampling.seed,
        points_wanted: sampling.points,
        points: cloud.points.len(),
        surface: match &shape.geometry {
            ShapeGeometry::Mesh(_) => Some(SurfaceEntry::new(sampling.surface, &cloud.part)),
            ShapeGeometry::Cloud(_) => None,
        },
        isolated: match &shape.geometry {
            ShapeGeometry::Mesh(_) => None,
            ShapeGeometry::Cloud(_) => Some(IsolatedEntry::new(sampling.isolated, &cloud.part)),
        },
        phase: abstraction.phase,
        iterations: abstraction.iteration,
        clusters_at_iteration: &record.clusters,
        merges: &record.merges,
        primitives: abstraction.primitives.len(),
        unassigned_points: abstraction.figures.unassigned,
        unassigned_input_points: labels.iter().filter(|&&l| l == UNASSIGNED).count(),
        mean_distance: abstraction.figures.mean_distance,
        seconds: Seconds {
            read: times.read.as_secs_f64(),
            sample: times.sample.as_secs_f64(),
            start: times.start.as_secs_f64(),
            iterations: times.iterations.as_secs_f64(),
            merge: times.merge.as_secs_f64(),
        },
    };
    json(w, &file)
}

fn json(w: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *w, value)?;
    writeln!(w)
}
