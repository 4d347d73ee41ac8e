//! The report of a run.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;

use super::outcome::Outcome;
use super::text::json;
use crate::geometry::{Isolated, SampledPart, Surface};
use crate::inference::{MergeReport, Method, Params, Phase, Sighting, UNASSIGNED};
use crate::io::paths::StoredPath;
use crate::io::shape::{Content, Shape, ShapeGeometry};

/// How a run went, for the report.
#[derive(Debug, Clone, Default)]
pub struct RunRecord {
    /// K at the start and after each iteration (or step of a baseline).
    pub clusters: Vec<usize>,
    pub merges: Vec<MergeReport>,
    pub times: PhaseTimes,
    /// The final folder of the report, if it is created elsewhere.
    pub home: Option<PathBuf>,
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
    seen_from: Sighting,
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
    /// Absolute; `null` where it was read from no file.
    path: Option<StoredPath>,
    /// The same from the folder of the report on, with `/` between the names, for
    /// the case that both are moved together.
    relative_path: Option<String>,
    /// The shape that is part of the program.
    built_in: bool,
    /// Size and CRC-32 of the file, to tell whether it is still the same.
    bytes: Option<u64>,
    crc32: Option<String>,
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
    /// Points without a sample.
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

impl<'a> InputEntry<'a> {
    fn new(shape: &'a Shape, folder: &Path) -> Self {
        let (kind, points, faces) = match &shape.geometry {
            ShapeGeometry::Mesh(mesh) => ("mesh", mesh.vertices.len(), mesh.faces.len()),
            ShapeGeometry::Cloud(input) => ("cloud", input.points.len(), 0),
        };
        let path = shape.path.as_deref();
        let absolute = path.and_then(|path| std::path::absolute(path).ok());
        let (bytes, crc32) = match shape.content {
            Some(Content::File { bytes, crc32 }) => (Some(bytes), Some(format!("{crc32:08x}"))),
            Some(Content::BuiltIn) | None => (None, None),
        };
        Self {
            name: &shape.name,
            path: absolute.map(StoredPath),
            relative_path: path.and_then(|path| relative(path, folder)),
            built_in: shape.content == Some(Content::BuiltIn),
            bytes,
            crc32,
            kind,
            points,
            faces,
            notes: &shape.notes,
        }
    }
}

/// The way to a file from a folder; `None` where there is none, as between two
/// drives, or a name is no text.
fn relative(path: &Path, folder: &Path) -> Option<String> {
    let path = path.canonicalize().ok()?;
    let folder = std::path::absolute(folder.join(".")).ok()?;
    // Of a folder that is still to be made what is there already.
    let there = folder.ancestors().find_map(|part| Some((part, part.canonicalize().ok()?)));
    let folder = there.and_then(|(part, real)| Some(real.join(folder.strip_prefix(part).ok()?)))?;
    let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return None;
    }
    let up = folder.components().skip(shared).map(|_| Some(".."));
    let down = path.components().skip(shared).map(|part| part.as_os_str().to_str());
    Some(up.chain(down).collect::<Option<Vec<_>>>()?.join("/"))
}

/// Writes the report of a run as JSON: input, sampling (of a mesh also which
/// part of its surface, and what share of the area was left out, of a cloud
/// how many isolated points), method, parameters, seed, number of points, K by
/// iteration, merges, seconds a phase, unassigned points and mean distance.
/// `folder` is the one that the report goes to.
pub(super) fn report_json(
    w: &mut impl Write,
    folder: &Path,
    outcome: &Outcome<'_>,
    record: &RunRecord,
) -> io::Result<()> {
    let Outcome { shape, cloud, sampling, params, abstraction, .. } = *outcome;
    let labels = cloud.labels_of_input(&abstraction.labels, UNASSIGNED);
    let times = &record.times;
    let file = ReportFile {
        format: "superform-report",
        version: 1,
        program: concat!("superform ", env!("CARGO_PKG_VERSION")),
        input: InputEntry::new(shape, record.home.as_deref().unwrap_or(folder)),
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
        seen_from: abstraction.sighting,
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
