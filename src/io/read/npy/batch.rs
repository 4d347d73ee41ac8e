//! Arrays of more than two dimensions: one cloud on a grid, or several shapes.

use super::grid::Grid;
use crate::io::read::text::counted;

/// With fewer points than this, an entry of an array is no shape of its own.
const SMALLEST_SHAPE: usize = 16;
/// Distances that are looked at.
const PROBES: usize = 4096;

/// How many of the points, from the first one on, are one shape; says what was
/// taken where others might be meant.
pub(super) fn points_of_one_shape(
    grid: &Grid,
    triples: &[f64],
    shown: &str,
    notes: &mut Vec<String>,
) -> usize {
    let all = grid.count();
    let sides: Vec<usize> = grid.rows.iter().map(|(side, _)| *side).filter(|side| *side > 1).collect();
    let (1.., Some(&points)) = (sides.len(), sides.last()) else { return all };
    let shapes = all / points;
    if shapes == 1 {
        return all;
    }
    if points < SMALLEST_SHAPE || is_scan(&sides, triples) {
        notes.push(taken_as_one(shown, all));
        return all;
    }
    notes.push(format!(
        "the array is {shown}, {} of {points} points: only the first was read. To open another, save it \
         separately, for example with np.save(\"shape1.npy\", array[1])",
        counted(shapes, "shape", "shapes")
    ));
    points
}

pub(super) fn taken_as_one(shown: &str, points: usize) -> String {
    format!("the array is {shown}: read as one cloud of {points} points")
}

/// Whether a grid of points is a scan, as of a depth camera: what lies side by
/// side in it does so in space, too. Points of a shape have no such order, and
/// several shapes have nothing to do with each other.
fn is_scan(sides: &[usize], triples: &[f64]) -> bool {
    let &[height, width] = sides else { return false };
    let point = |i: usize| &triples[3 * i..3 * i + 3];
    let distance = |a: usize, b: usize| {
        point(a).iter().zip(point(b)).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    // Odd, so that it doesn't keep to some of the columns.
    let step = (height * width / PROBES) | 1;
    let typical = |down: usize, right: usize| {
        let other = |i: usize| (i / width + down) % height * width + (i % width + right) % width;
        let distances = (0..height * width).step_by(step).map(|i| distance(i, other(i)));
        // Places without a point hold the same everywhere.
        let mut distances: Vec<f64> = distances.filter(|d| d.is_finite() && *d > 0.0).collect();
        let middle = distances.len() / 2;
        if distances.is_empty() { 0.0 } else { *distances.select_nth_unstable_by(middle, f64::total_cmp).1 }
    };
    2.0 * typical(0, 1) < typical(0, width / 2) && 2.0 * typical(1, 0) < typical(height / 2, 0)
}
