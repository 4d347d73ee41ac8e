//! Primitives are measured against a reference.

use nalgebra::Point3;

use super::body::Body;
use super::figures::{Metrics, mean};
use super::reference::Reference;
use super::union;
use crate::geometry::Superquadric;
use crate::geometry::neighbors::KdTree;

/// How far a sample is pushed outward before it is looked for in others.
const PUSH: f64 = 1e-4;

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
