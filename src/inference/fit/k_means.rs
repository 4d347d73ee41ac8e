//! k-means with k-means++ seeding: the start of a run, and the cut of a split.

use nalgebra::Point3;
use rand::{Rng, RngExt};
use rayon::prelude::*;

const MAX_ROUNDS: usize = 60;
/// The rounds end where no more than one point in so many changes its centre:
/// what follows does not need it exactly.
const SETTLED: usize = 500;
/// Points that one thread handles at a time.
const CHUNK: usize = 512;

/// Clusters `points` around `k` centres (fewer where there are fewer distinct
/// points); returns a centre's index for each point. Squared Euclidean
/// distance, so that the result turns with the cloud.
pub(crate) fn k_means(points: &[Point3<f64>], k: usize, rng: &mut impl Rng) -> Vec<u32> {
    let mut centers = seeds(points, k, rng);
    let mut labels = vec![0u32; points.len()];
    for _ in 0..MAX_ROUNDS {
        let changed: usize = points
            .par_chunks(CHUNK)
            .zip(labels.par_chunks_mut(CHUNK))
            .map(|(points, labels)| {
                let mut changed = 0;
                for (p, label) in points.iter().zip(labels) {
                    let mut nearest = (f64::INFINITY, 0);
                    for (j, c) in (0u32..).zip(&centers) {
                        let d2 = (p - c).norm_squared();
                        if d2 < nearest.0 {
                            nearest = (d2, j);
                        }
                    }
                    changed += usize::from(nearest.1 != *label);
                    *label = nearest.1;
                }
                changed
            })
            .sum();
        if changed <= points.len() / SETTLED {
            break;
        }
        let mut sums = vec![(nalgebra::Vector3::zeros(), 0usize); centers.len()];
        for (p, label) in points.iter().zip(&labels) {
            let sum = &mut sums[*label as usize];
            sum.0 += p.coords;
            sum.1 += 1;
        }
        for (center, (sum, n)) in centers.iter_mut().zip(sums) {
            if n > 0 {
                *center = Point3::from(sum / n as f64);
            }
        }
    }
    labels
}

/// k-means++: each next centre is drawn with probability proportional to the
/// squared distance from those chosen before.
fn seeds(points: &[Point3<f64>], k: usize, rng: &mut impl Rng) -> Vec<Point3<f64>> {
    if points.is_empty() || k == 0 {
        return Vec::new();
    }
    let mut centers = vec![points[rng.random_range(0..points.len())]];
    let mut d2: Vec<f64> = points.iter().map(|p| (p - centers[0]).norm_squared()).collect();
    while centers.len() < k {
        let total: f64 = d2.iter().sum();
        if total <= 0.0 {
            break;
        }
        let mut u = rng.random::<f64>() * total;
        let chosen = d2
            .iter()
            .position(|&w| {
                u -= w;
                u < 0.0
            })
            .unwrap_or(points.len() - 1);
        let center = points[chosen];
        centers.push(center);
        for (w, p) in d2.iter_mut().zip(points) {
            *w = w.min((p - center).norm_squared());
        }
    }
    centers
}
