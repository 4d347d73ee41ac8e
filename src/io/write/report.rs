//! The report of a run.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

use serde::Serialize;

use super::atomic::Staged;
use super::{Outcome, json};
use crate::geometry::{Isolated, SampledPart, Surface};
use crate::inference::{MergeReport, Method, Params, Phase, UNASSIGNED};
use crate::io::{ShapeGeometry, StoredPath, WriteError};

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

/// Writes the report of a run as JSON: input, sampling (of a mesh also which
/// part of its surface, and what share of the area was left out, of a cloud
/// how many isolated points), method,
/// parameters, seed, number of points, K by iteration, merges, seconds a phase, unassigned
/// points and mean distance.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_report_json(path: &Path, outcome: &Outcome<'_>, record: &RunRecord) -> Result<(), WriteError> {
    Staged::with(path, |w| report_json(w, outcome, record))?.persist()
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
    path: Option<Cow<'a, str>>,
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

pub(super) fn report_json(w: &mut impl Write, outcome: &Outcome<'_>, record: &RunRecord) -> io::Result<()> {
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
            path: shape.path.as_deref().map(StoredPath::text),
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
