//! How well an abstraction stands for its shape.
//!
//! Lengths are measured in units of the longest edge of the reference's box.
//!
//! | figure | definition |
//! |---|---|
//! | accuracy | mean distance to the reference of points drawn evenly from the surface of the primitives' union |
//! | completeness | mean distance of points drawn evenly from the reference to the nearest of those points |
//! | Chamfer-L1 | (accuracy + completeness)/2 |
//! | IoU | volume of primitives ∩ reference over that of primitives ∪ reference |
//!
//! A point belongs to the surface of the union if it, pushed outward by 1e-4,
//! is in no other primitive: so the faces by which two primitives abut don't
//! count, and of two that coincide both do. The distance to a mesh is exact,
//! that to a cloud is the distance to its nearest point. The inside of a mesh
//! is where its generalised winding number is above ½, once vertices of the
//! same place are merged, double faces left out and patches turned outward.
//!
//! What a [`Reference`] needs is prepared once; [`evaluate`] measures any
//! number of states against it. The same seed gives the same bits on any
//! number of threads.

mod body;
mod clean;
mod nearest;
mod orient;
mod reference;
mod triangles;
mod union;
mod winding;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Superquadric;
use super::mesh::bounds;
use super::neighbors::KdTree;
use body::Body;

pub use nearest::Nearest;
pub use reference::{Reference, ReferenceError};

/// How far a sample is pushed outward before it is looked for in others.
const PUSH: f64 = 1e-4;
/// Samples that are measured one after the other.
const CHUNK: usize = 2048;

/// How finely is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MetricOptions {
    /// Samples of each of the two surfaces.
    pub samples: usize,
    /// Points in the reference's box that volumes are counted by.
    pub volume_points: usize,
    pub seed: u64,
}

impl Default for MetricOptions {
    fn default() -> Self {
        Self { samples: 100_000, volume_points: 100_000, seed: 1 }
    }
}

impl MetricOptions {
    /// Limits of the number of samples and of volume points.
    pub const SAMPLES: (usize, usize) = (100, 10_000_000);

    /// Says which option is out of its limits, if one is.
    ///
    /// # Errors
    /// One sentence that names it and the limits.
    pub fn check(&self) -> Result<(), String> {
        let (least, most) = Self::SAMPLES;
        for (name, value) in [("samples", self.samples), ("volume points", self.volume_points)] {
            if !(least..=most).contains(&value) {
                return Err(format!(
                    "the number of {name} is {value}, but must be between {least} and {most}"
                ));
            }
        }
        Ok(())
    }
}

/// The figures of one state; lengths in units of the reference's longest edge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    pub primitives: usize,
    /// Share of the samples that belong to no primitive, where it is known.
    pub unassigned_share: Option<f64>,
    /// `None`, like its two parts, where the primitives have no surface.
    pub chamfer_l1: Option<f64>,
    /// Primitives → reference.
    pub accuracy: Option<f64>,
    /// Reference → primitives.
    pub completeness: Option<f64>,
    /// `None` where the reference encloses no volume; `iou_missing` says why.
    pub iou: Option<f64>,
    /// Standard error of the IoU, from the number of points that decide it.
    pub iou_error: Option<f64>,
    pub iou_missing: Option<String>,
    /// IoU against the reference with its hollows filled, where
    /// [`Reference::with_filled`] was told what they are.
    pub iou_outside: Option<f64>,
    /// Volumes, in cubes of the longest edge: of the union and, where it has
    /// one, of the reference.
    pub volume: Option<f64>,
    pub reference_volume: Option<f64>,
    /// Share of the primitives' surface that lies inside other primitives.
    pub buried_share: Option<f64>,
}

/// Measures primitives (in the reference's input units) against a reference.
/// Shapes with a parameter that is not valid count as primitives but have
/// neither surface nor volume.
pub fn evaluate(shapes: &[Superquadric], unassigned_share: Option<f64>, reference: &Reference) -> Metrics {
    let frame = &reference.frame;
    let bodies: Vec<Body> = shapes.iter().filter(|s| s.is_valid()).map(|s| Body::new(s, frame)).collect();
    let surface = union::sample(&bodies, reference.options.samples, PUSH, reference.options.seed);
    let accuracy = reference.mean_distance_of(&surface.points);
    let completeness = (!surface.points.is_empty()).then(|| {
        let tree = KdTree::new(&surface.points);
        mean(&reference.samples, |chunk| {
            chunk.iter().filter_map(|p| tree.nearest_one(p)).map(|(d2, _)| d2.sqrt()).sum()
        })
    });
    let mut metrics = Metrics {
        primitives: shapes.len(),
        unassigned_share,
        chamfer_l1: accuracy.zip(completeness).map(|(a, c)| 0.5 * (a + c)),
        accuracy,
        completeness,
        iou: None,
        iou_error: None,
        iou_missing: None,
        iou_outside: None,
        volume: None,
        reference_volume: None,
        buried_share: surface.buried_share,
    };
    match &reference.volume {
        Err(why) => metrics.iou_missing = Some(why.clone()),
        Ok(volume) => volume.measure(&bodies, reference.options.seed, &mut metrics),
    }
    metrics
}

/// An estimate of [`Metrics::chamfer_l1`] in a fraction of the time: the mean
/// over at most `probes` points of each surface, evenly spread, against the same
/// points as ever, so that what differs is chance alone. `None` where the
/// primitives have no surface.
pub fn estimate_chamfer(shapes: &[Superquadric], reference: &Reference, probes: usize) -> Option<f64> {
    let frame = &reference.frame;
    let bodies: Vec<Body> = shapes.iter().filter(|s| s.is_valid()).map(|s| Body::new(s, frame)).collect();
    let surface = union::sample(&bodies, reference.options.samples, PUSH, reference.options.seed).points;
    let accuracy = reference.mean_distance_of(&spread(&surface, probes))?;
    let tree = KdTree::new(&surface);
    let completeness = mean(&spread(&reference.samples, probes), |chunk| {
        chunk.iter().filter_map(|p| tree.nearest_one(p)).map(|(d2, _)| d2.sqrt()).sum()
    });
    Some(0.5 * (accuracy + completeness))
}

/// At most `count` of the points, the same number left out between any two.
fn spread(points: &[Point3<f64>], count: usize) -> Vec<Point3<f64>> {
    points.iter().copied().step_by(points.len().div_ceil(count.max(1)).max(1)).collect()
}

/// Mean over points, the chunks in parallel but summed in their order.
fn mean(points: &[Point3<f64>], sum: impl Fn(&[Point3<f64>]) -> f64 + Sync + Send) -> f64 {
    let sums: Vec<f64> = points.par_chunks(CHUNK).map(sum).collect();
    sums.iter().sum::<f64>() / points.len() as f64
}

/// The frame of all measuring: the reference's box, centred, its longest edge
/// 1. Far offsets and extreme units cost no precision there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Frame {
    center: Vector3<f64>,
    /// Longest edge in input units.
    unit: f64,
}

impl Frame {
    /// `None` where there are no points or no extent.
    fn around(points: impl IntoIterator<Item = Point3<f64>>) -> Option<Self> {
        let (lo, hi) = bounds(points)?;
        // Halved before they are added: sums near the largest number overflow.
        let (lo, hi) = (lo.coords * 0.5, hi.coords * 0.5);
        let unit = 2.0 * (hi - lo).max();
        (unit > 0.0 && unit.is_finite()).then_some(Self { center: lo + hi, unit })
    }

    fn local(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from((p.coords - self.center) / self.unit)
    }

    fn input(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from(p.coords * self.unit + self.center)
    }
}

#[cfg(test)]
mod tests;
