//! Opens results: the primitives in a file together with their shape.

use std::collections::HashSet;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use nalgebra::Point3;
use serde::Deserialize;

use super::shapes::{built_in, read};
use crate::geometry::tessellate::{Resolution, tessellate};
use crate::geometry::{Isolated, NO_SAMPLE, SampleCloud, SamplingOptions, Surface, TriMesh, sample_cloud};
use crate::inference::{Edit, UNASSIGNED};
use crate::io::content::content;
use crate::io::error::ReadError;
use crate::io::names::{PRIMITIVES_FILES, REPORT_FILE, SEGMENTED_FILE};
use crate::io::paths::StoredPath;
use crate::io::primitives::StoredPrimitives;
use crate::io::primitives::schema::{COLUMNS, FORMAT, arrays};
use crate::io::shape::{Attributes, Content, PointCloud, Shape, ShapeGeometry};

/// How much of a file is looked at.
const HEAD: u64 = 4 << 10;
/// Arrays that tell primitives from points in an NPZ file.
const ARRAYS: [&str; 4] = [arrays::SCALE, arrays::ROTATION, arrays::TRANSLATION, arrays::EXPONENTS];

/// Whether a file, or the folder of a run, holds primitives rather than a shape,
/// as far as its beginning tells. Not of CSV files of any name: 13 columns of
/// numbers may be points with their attributes.
pub fn holds_primitives(path: &Path) -> bool {
    if path.is_dir() {
        return PRIMITIVES_FILES.iter().any(|name| path.join(name).is_file());
    }
    let Ok(file) = File::open(path) else { return false };
    let mut head = Vec::new();
    if (&file).take(HEAD).read_to_end(&mut head).is_err() {
        return false;
    }
    if head.starts_with(b"PK\x03\x04") {
        let Ok(archive) = zip::ZipArchive::new(file) else { return false };
        return ARRAYS.iter().all(|name| archive.index_for_name(&format!("{name}.npy")).is_some());
    }
    let text = String::from_utf8_lossy(&head);
    let first = text.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
    let is_table = first.split(',').map(str::trim).eq(COLUMNS);
    // Ours says so in its first line.
    let is_ours = text.strip_prefix("# ").is_some_and(|text| text.starts_with(FORMAT));
    is_table || is_ours || (text.trim_start().starts_with('{') && text.contains(FORMAT))
}

/// What the shape of a result is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FoundAs {
    /// What was abstracted.
    Input,
    /// The segmented cloud next to the primitives.
    Segmented,
    /// The points in the primitives' own file.
    Points,
    /// No more than the primitives themselves.
    Surfaces,
}

/// Points with the labels that the run gave them.
#[derive(Debug, Clone)]
pub struct LabelledPoints {
    /// All points, in order.
    pub points: Vec<Point3<f64>>,
    /// Id of the primitive of each, or [`UNASSIGNED`].
    pub labels: Vec<u32>,
}

impl LabelledPoints {
    /// All finite points as samples of the shape, and their labels.
    pub fn samples_of(&self, shape: &Shape) -> (SampleCloud, Vec<u32>) {
        let cloud = SampleCloud::from_points(&self.points);
        let map = cloud.sample_of_input.iter().flatten();
        let labels =
            map.zip(&self.labels).filter(|(sample, _)| **sample != NO_SAMPLE).map(|(_, label)| *label);
        let labels = labels.collect();
        match &shape.geometry {
            // The samples of a mesh stand for none of its vertices.
            ShapeGeometry::Mesh(_) => (SampleCloud { sample_of_input: None, ..cloud }, labels),
            ShapeGeometry::Cloud(_) => (cloud, labels),
        }
    }
}

/// A result with all that it belongs to, as far as it can be found.
#[derive(Debug)]
pub struct OpenedResult {
    pub stored: StoredPrimitives,
    /// What the primitives stand for. Its notes tell what it is, where it is not
    /// The abstracted shape. Notes describe it if it is not the input.
    pub shape: Shape,
    pub found_as: FoundAs,
    /// The segmented cloud next to the primitives.
    pub segmented: Option<LabelledPoints>,
    /// The sampling options of the run, as far as known.
    pub sampling: SamplingOptions,
}

/// Finds what primitives stand for: the shape that is named (`input`), or the one
/// that the report beside them tells; that is looked for where the report says,
/// from its own folder on and then absolutely, and taken only where its content
/// is that of then. Without it the segmented cloud beside them, the points in
/// their own file, or their surfaces take its place, and the shape's notes say
/// why.
///
/// # Errors
/// Where a file that is named or stands beside can't be read.
pub fn open_result(mut stored: StoredPrimitives, input: Option<&Path>) -> Result<OpenedResult, ReadError> {
    let report = Report::beside(&stored);
    let found = match (input, &report) {
        (Some(path), _) => Ok(read(path)?),
        (None, Ok(report)) => report.input.find(&stored.path)?,
        (None, Err(why)) => Err(why.clone()),
    };
    let (input, why) = match found {
        Ok(shape) => (Some(shape), String::new()),
        Err(why) => (None, why),
    };
    let report = report.ok();
    let sampling = sampling_of(&stored, report.as_ref());
    let beside = stored.path.with_file_name(SEGMENTED_FILE);
    let cloud = if beside.is_file() && beside != stored.path { Some(read(&beside)?) } else { None };
    let segmented = cloud.as_ref().and_then(|cloud| {
        let labelled = labelled(cloud, &stored);
        let is_of_it =
            labelled.as_ref().is_some_and(|l| belongs(l.points.len(), input.as_ref(), &report, &stored));
        if !is_of_it {
            stored.notes.push(format!(
                "{SEGMENTED_FILE} next to the primitives belongs to a different run and was ignored"
            ));
        }
        labelled.filter(|_| is_of_it)
    });
    if let Some(shape) = input {
        return Ok(OpenedResult { stored, shape, found_as: FoundAs::Input, segmented, sampling });
    }
    let (shape, found_as, of) = match cloud.filter(|_| segmented.is_some()) {
        // Its labels and colours are ours, and not the input's.
        Some(cloud) => {
            let attributes = Attributes { colors: None, labels: None, ..cloud.attributes };
            (
                Shape { attributes, ..cloud },
                FoundAs::Segmented,
                "the points of the segmented cloud next to them",
            )
        }
        None if has_points(&stored.path) => {
            (read(&stored.path)?, FoundAs::Points, "the points in their file")
        }
        None => (surfaces(&stored), FoundAs::Surfaces, "the surfaces of the primitives"),
    };
    let name = match (&stored.input, stored.path.file_name()) {
        (Some(input), _) => input.clone(),
        (None, Some(name)) => name.to_string_lossy().into_owned(),
        (None, None) => "primitives".to_owned(),
    };
    let mut notes = shape.notes;
    notes.push(format!(
        "the shape of these primitives was not found ({why}); using {of} instead. To see the primitives on \
         the shape, open the shape and import them"
    ));
    let shape = Shape { name, path: None, content: None, notes, ..shape };
    Ok(OpenedResult { stored, shape, found_as, segmented, sampling })
}

impl OpenedResult {
    /// The samples of the run with their labels; `None` where these are not
    /// known, or are not those of the shape.
    pub fn samples(&self) -> Option<(SampleCloud, Vec<u32>)> {
        let segmented = self.segmented.as_ref()?;
        // Those of a mesh are all there is in its segmented cloud.
        let input = match &self.shape.geometry {
            ShapeGeometry::Cloud(input) if !self.was_mesh() => input,
            _ => return Some(segmented.samples_of(&self.shape)),
        };
        // Sampled as then, each sample has the label of all points that it stands for.
        let cloud = sample_cloud(&input.points, &self.sampling).ok()?;
        let map = cloud.sample_of_input.as_ref()?;
        let mut of_samples = vec![None; cloud.points.len()];
        for (&sample, &label) in map.iter().zip(&segmented.labels).filter(|(sample, _)| **sample != NO_SAMPLE)
        {
            if *of_samples[sample as usize].get_or_insert(label) != label {
                return None;
            }
        }
        let labels = of_samples.into_iter().map(|label| label.unwrap_or(UNASSIGNED)).collect();
        Some((cloud, labels))
    }

    /// Whether the shape is the samples of a mesh that is gone: as many as the
    /// run had.
    fn was_mesh(&self) -> bool {
        let points = self.segmented.as_ref().map(|segmented| segmented.points.len());
        self.found_as == FoundAs::Segmented && points == self.stored.points
    }

    /// The change that makes the result the state of a run on samples with these
    /// labels, or without any known.
    pub fn taken(&self, labels: Vec<u32>) -> Edit {
        Edit::Take { primitives: self.stored.primitives.clone(), labels }
    }
}

/// Possible locations of the shape of a result folder, from its report.
pub(in crate::io) fn places_of_shape(folder: &Path) -> Vec<PathBuf> {
    let path = folder.join(REPORT_FILE);
    let report: Option<Report> = content(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    report.map_or_else(Vec::new, |report| report.input.places(&path))
}

/// What a report says of the shape of its run.
#[derive(Debug, Deserialize)]
struct Report {
    input: Input,
    seed: Option<u64>,
    points: Option<usize>,
    primitives: Option<usize>,
    points_wanted: Option<usize>,
    sampling_seed: Option<u64>,
    surface: Option<Wish<Surface>>,
    isolated: Option<Wish<Isolated>>,
}

#[derive(Debug, Deserialize)]
struct Wish<T> {
    asked_for: T,
}

/// Early reports contain neither size and checksum nor a relative path.
#[derive(Debug, Deserialize)]
struct Input {
    name: String,
    path: Option<StoredPath>,
    relative_path: Option<StoredPath>,
    built_in: Option<bool>,
    bytes: Option<u64>,
    crc32: Option<String>,
    kind: String,
    points: usize,
    faces: usize,
}

impl Report {
    /// The report next to the primitives, if it belongs to the same run; otherwise the reason.
    fn beside(stored: &StoredPrimitives) -> Result<Self, String> {
        let path = stored.path.with_file_name(REPORT_FILE);
        let Ok(bytes) = content(&path) else {
            return Err(format!("there is no {REPORT_FILE} next to them that names it"));
        };
        let report: Self = serde_json::from_slice(&bytes)
            .map_err(|error| format!("the {REPORT_FILE} next to them cannot be read: {error}"))?;
        // What a file doesn't tell can't differ.
        let differ = |a: Option<u64>, b: Option<u64>| a.zip(b).is_some_and(|(a, b)| a != b);
        let is_other = stored.input.as_ref().is_some_and(|name| *name != report.input.name)
            || differ(stored.seed, report.seed)
            || differ(stored.sampling_seed, report.sampling_seed)
            || differ(stored.points.map(|n| n as u64), report.points.map(|n| n as u64))
            || differ(Some(stored.primitives.len() as u64), report.primitives.map(|n| n as u64));
        if is_other {
            Err(format!("the {REPORT_FILE} next to them belongs to a different run"))
        } else {
            Ok(report)
        }
    }
}

impl Input {
    /// The shape, or why it is not to be had.
    fn find(&self, beside: &Path) -> Result<Result<Shape, String>, ReadError> {
        // Without a path, early reports were of the built-in shape.
        if self.built_in.unwrap_or(self.path.is_none()) {
            let shape = built_in()?;
            let why = "the built-in shape has changed in this version";
            return Ok(if self.has_counts_of(&shape) { Ok(shape) } else { Err(why.to_owned()) });
        }
        let places = self.places(beside);
        for place in &places {
            if let Some(shape) = self.read_if_same(place)? {
                return Ok(Ok(shape));
            }
        }
        let listed: Vec<String> = places.iter().map(|place| place.display().to_string()).collect();
        Ok(Err(match places.iter().find(|place| place.is_file()) {
            Some(changed) => format!("the content of {} has changed since", changed.display()),
            None if listed.is_empty() => format!("{REPORT_FILE} contains no path"),
            None => format!("not found at {}", listed.join(" or at ")),
        }))
    }

    /// Possible locations of the shape, from the report next to a file.
    fn places(&self, beside: &Path) -> Vec<PathBuf> {
        let folder = beside.parent().unwrap_or(Path::new(""));
        let written =
            [&self.relative_path, &self.path].into_iter().flatten().map(|stored| stored.0.as_path());
        // A path of the first versions may be one from where they were started.
        let mut places: Vec<PathBuf> =
            written.map(|path| way(folder, path)).chain(self.path.clone().map(|stored| stored.0)).collect();
        let mut seen = HashSet::new();
        places.retain(|place| seen.insert(place.clone()));
        places
    }

    /// The shape in a file, if it is what it was then.
    fn read_if_same(&self, path: &Path) -> Result<Option<Shape>, ReadError> {
        let Ok(about) = std::fs::metadata(path) else { return Ok(None) };
        // What is of another size need not be read.
        if !about.is_file() || self.bytes.is_some_and(|bytes| bytes != about.len()) {
            return Ok(None);
        }
        let shape = match read(path) {
            Ok(shape) => shape,
            // It can't be what was read then.
            Err(ReadError::Open { path, reason }) => return Err(ReadError::Open { path, reason }),
            Err(_) => return Ok(None),
        };
        let is_same = match (self.bytes, &self.crc32, shape.content) {
            (Some(known), Some(sum), Some(Content::File { bytes, crc32 })) => {
                known == bytes && u32::from_str_radix(sum, 16) == Ok(crc32)
            }
            _ => self.has_counts_of(&shape),
        };
        Ok(is_same.then_some(shape))
    }

    fn has_counts_of(&self, shape: &Shape) -> bool {
        let counts = match &shape.geometry {
            ShapeGeometry::Mesh(mesh) => ("mesh", mesh.vertices.len(), mesh.faces.len()),
            ShapeGeometry::Cloud(cloud) => ("cloud", cloud.points.len(), 0),
        };
        counts == (self.kind.as_str(), self.points, self.faces)
    }
}

/// The place that a path means from a folder on, without the way back up.
fn way(folder: &Path, path: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut place = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    for part in path.components() {
        match part {
            Component::ParentDir => drop(place.pop()),
            Component::CurDir => {}
            // An absolute path begins anew.
            part => place.push(part),
        }
    }
    place
}

fn sampling_of(stored: &StoredPrimitives, report: Option<&Report>) -> SamplingOptions {
    let usual = SamplingOptions::default();
    let (least, most) = SamplingOptions::POINTS;
    let points = report.and_then(|report| report.points_wanted).or(stored.points).unwrap_or(usual.points);
    SamplingOptions {
        points: points.clamp(least, most),
        seed: report.and_then(|report| report.sampling_seed).or(stored.sampling_seed).unwrap_or(usual.seed),
        surface: report.and_then(|r| r.surface.as_ref()).map_or(usual.surface, |wish| wish.asked_for),
        isolated: report.and_then(|r| r.isolated.as_ref()).map_or(usual.isolated, |wish| wish.asked_for),
    }
}

/// The points of a segmented cloud with the ids that are primitives'; `None`
/// where it is no cloud with labels.
fn labelled(cloud: &Shape, stored: &StoredPrimitives) -> Option<LabelledPoints> {
    let ShapeGeometry::Cloud(PointCloud { points }) = &cloud.geometry else { return None };
    let ids: HashSet<u32> = stored.primitives.iter().map(|p| p.id).collect();
    let known = |label: &i64| u32::try_from(*label).ok().filter(|id| ids.contains(id)).unwrap_or(UNASSIGNED);
    let labels = cloud.attributes.labels.as_ref()?.iter().map(known).collect();
    Some(LabelledPoints { points: points.clone(), labels })
}

/// Whether a segmented cloud with this many points can belong to the run: it has
/// all points of a cloud, or all samples of a mesh.
fn belongs(points: usize, input: Option<&Shape>, report: &Option<Report>, stored: &StoredPrimitives) -> bool {
    let of_input = match (input.map(|shape| &shape.geometry), report) {
        (Some(ShapeGeometry::Cloud(cloud)), _) => Some(cloud.points.len()),
        (None, Some(report)) if report.input.kind == "cloud" => Some(report.input.points),
        (None, None) => None,
        _ => stored.points,
    };
    of_input.is_none_or(|expected| expected == points)
}

/// Whether an NPZ file of primitives has the points, too.
fn has_points(path: &Path) -> bool {
    let archive = File::open(path).ok().and_then(|file| zip::ZipArchive::new(file).ok());
    archive.is_some_and(|archive| archive.index_for_name(&format!("{}.npy", arrays::CLOUD)).is_some())
}

fn surfaces(stored: &StoredPrimitives) -> Shape {
    let resolution = Resolution::SCREEN;
    let mut mesh = TriMesh::default();
    for primitive in &stored.primitives {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(tessellate(&primitive.shape, resolution).vertices);
        mesh.faces.extend(resolution.faces().into_iter().map(|face| face.map(|i| i + first)));
    }
    Shape {
        name: String::new(),
        path: None,
        content: None,
        geometry: ShapeGeometry::Mesh(mesh),
        attributes: Default::default(),
        viewpoints: Vec::new(),
        notes: Vec::new(),
    }
}
