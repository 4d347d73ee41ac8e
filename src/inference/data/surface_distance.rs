//! The cloud as a surface: how far any place is from it, and which way.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use crate::geometry::neighbors::KdTree;

/// Neighbours that give the tangent plane at a point.
const NORMAL_NEIGHBORS: usize = 10;
/// Within so many mean spacings along the tangent plane of its nearest point
/// a place counts as covered: the cloud knows no finer.
const COVERED: f64 = 1.0;

/// Tangent planes at all points of the cloud.
#[derive(Debug)]
pub(crate) struct SurfaceDistance {
    tree: KdTree,
    cells: Cells,
    points: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    bulges: Vec<f64>,
    reach: f64,
}

/// The way from the cloud to a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Offset {
    pub(crate) distance: f64,
    /// Unit vector along which the distance grows; 0 on the surface itself.
    pub(crate) direction: Vector3<f64>,
}

impl SurfaceDistance {
    /// The field of `points`, of which `tree` is the tree.
    pub(crate) fn new(tree: KdTree, points: &[Point3<f64>], spacing: f64) -> Self {
        let (normals, bulges) = points
            .par_iter()
            .map(|p| {
                let near = tree.nearest(p, NORMAL_NEIGHBORS);
                let n = near.len().max(1) as f64;
                let center = near.iter().map(|k| points[k.1 as usize].coords).sum::<Vector3<f64>>() / n;
                let mut covariance = Matrix3::zeros();
                for (_, k) in &near {
                    let v = points[*k as usize].coords - center;
                    covariance += v * v.transpose();
                }
                let eigen = SymmetricEigen::new(covariance);
                let thinnest = eigen.eigenvalues.imin();
                let normal = eigen.eigenvectors.column(thinnest).into_owned();
                (normal, normal.dot(&(center - p.coords)))
            })
            .unzip();
        let cells = Cells::new(&tree, points, spacing);
        Self { tree, cells, points: points.to_vec(), normals, bulges, reach: COVERED * spacing }
    }

    pub(crate) fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// Unit normals of the tangent planes, of either sign.
    pub(crate) fn normals(&self) -> &[Vector3<f64>] {
        &self.normals
    }

    /// How far the middle of each point's neighbours lies above its tangent plane:
    /// below 0 where the surface bulges to the side of the normal.
    pub(crate) fn bulges(&self) -> &[f64] {
        &self.bulges
    }

    /// The nearest point of the cloud, or one about as near where the cloud is
    /// far.
    fn nearest(&self, place: &Point3<f64>) -> Option<u32> {
        let candidates = self.cells.candidates(place);
        if candidates.is_empty() {
            return self.tree.nearest_about(place, FAR_SLACK).map(|found| found.1);
        }
        let mut best = (f64::INFINITY, u32::MAX);
        for &k in candidates {
            let d2 = (place - self.points[k as usize]).norm_squared();
            if d2 < best.0 {
                best = (d2, k);
            }
        }
        Some(best.1)
    }

    /// The offset of a place from the tangent plane at its nearest point, and
    /// beyond the reach of that point from its edge, too.
    pub(crate) fn offset(&self, place: &Point3<f64>) -> Offset {
        let Some(k) = self.nearest(place) else {
            return Offset { distance: 0.0, direction: Vector3::zeros() };
        };
        let v = place - self.points[k as usize];
        let normal = self.normals[k as usize];
        let height = normal.dot(&v);
        let along = v - normal * height;
        let length = along.norm();
        let excess = (length - self.reach).max(0.0);
        let distance = (height * height + excess * excess).sqrt();
        if distance <= f64::MIN_POSITIVE {
            return Offset { distance: 0.0, direction: Vector3::zeros() };
        }
        let sideways = if excess > 0.0 { along * (excess / length) } else { Vector3::zeros() };
        Offset { distance, direction: (normal * height + sideways) / distance }
    }
}

/// A grid that knows for every place near the cloud which points can be the
/// nearest: most surfaces that are asked for are near.
#[derive(Debug)]
struct Cells {
    low: Point3<f64>,
    /// Cells per length.
    per_length: f64,
    size: [usize; 3],
    /// The candidates of each cell: `lists[starts[c]..starts[c + 1]]`, by index;
    /// none where the cloud is far.
    starts: Vec<u32>,
    lists: Vec<u32>,
}

/// Cells for each point at most: finer ones would take more memory than points
/// do, and more time to fill than to look around in.
const CELLS_PER_POINT: f64 = 64.0;
/// Rings of empty cells around those with points that get candidates.
const RINGS: usize = 1;
/// A place that the grid doesn't know takes a point at most this many times as
/// far as the nearest.
const FAR_SLACK: f64 = 1.05;

impl Cells {
    fn new(tree: &KdTree, points: &[Point3<f64>], spacing: f64) -> Self {
        let (mut low, mut high) = (Point3::origin(), Point3::origin());
        if let Some(first) = points.first() {
            (low, high) = points.iter().fold((*first, *first), |(l, h), p| (l.inf(p), h.sup(p)));
        }
        let extent = high - low;
        let least = spacing.max(1e-3 * extent.max());
        let mut edge = if least > 0.0 { least } else { 1.0 };
        let margin = (RINGS + 1) as f64;
        let count = |edge: f64| extent.iter().map(|e| e / edge + 2.0 * margin).product::<f64>();
        while count(edge) > CELLS_PER_POINT * points.len() as f64 + 1000.0 {
            edge *= 1.25;
        }
        let low = low - Vector3::repeat(margin * edge);
        let size = [0, 1, 2].map(|a| (extent[a] / edge + 2.0 * margin).ceil() as usize);
        let mut cells = Self { low, per_length: 1.0 / edge, size, starts: Vec::new(), lists: Vec::new() };
        let mut is_near = vec![false; size.iter().product()];
        for p in points {
            let Some([x, y, z]) = cells.cell(p) else { continue };
            for (dx, dy, dz) in ring(RINGS) {
                is_near[cells.index([x + dx - RINGS, y + dy - RINGS, z + dz - RINGS])] = true;
            }
        }
        let near: Vec<usize> = (0..is_near.len()).filter(|&c| is_near[c]).collect();
        // Whatever is nearest to a place in the cell is as near to its middle as
        // the middle's nearest, but for the way from the middle there and back.
        let diagonal = edge * 3f64.sqrt();
        let candidates: Vec<Vec<u32>> = near
            .par_iter()
            .map(|&c| {
                let middle = cells.middle(c, edge);
                let mut found = Vec::new();
                if let Some((d2, first)) = tree.nearest_one(&middle) {
                    let q = points[first as usize];
                    tree.within(&middle, d2.sqrt() + diagonal * (1.0 + 1e-9), |other, k| {
                        // By how much more than to q the squared way to this one
                        // is, where in the cell that is least.
                        let v = points[k as usize] - q;
                        if other - d2 <= edge * (v.x.abs() + v.y.abs() + v.z.abs()) * (1.0 + 1e-9) {
                            found.push(k);
                        }
                    });
                }
                found.sort_unstable();
                found
            })
            .collect();
        cells.starts = vec![0; is_near.len() + 1];
        for (&c, list) in near.iter().zip(&candidates) {
            cells.starts[c + 1] = list.len() as u32;
        }
        for c in 0..is_near.len() {
            cells.starts[c + 1] += cells.starts[c];
        }
        cells.lists = candidates.concat();
        cells
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.size[1] + y) * self.size[2] + z
    }

    fn middle(&self, cell: usize, edge: f64) -> Point3<f64> {
        let (xy, z) = (cell / self.size[2], cell % self.size[2]);
        let at = Vector3::new((xy / self.size[1]) as f64, (xy % self.size[1]) as f64, z as f64);
        self.low + at.add_scalar(0.5) * edge
    }

    /// The cell of a place; none outside of the grid.
    #[inline]
    fn cell(&self, place: &Point3<f64>) -> Option<[usize; 3]> {
        let at = (place - self.low) * self.per_length;
        let is_inside = at.iter().zip(self.size).all(|(v, n)| *v >= 0.0 && *v < n as f64);
        is_inside.then(|| [at.x as usize, at.y as usize, at.z as usize])
    }

    /// The points that can be nearest to a place, in order of index; none where
    /// the cloud is far.
    #[inline]
    fn candidates(&self, place: &Point3<f64>) -> &[u32] {
        match self.cell(place) {
            Some(cell) => {
                let c = self.index(cell);
                &self.lists[self.starts[c] as usize..self.starts[c + 1] as usize]
            }
            None => &[],
        }
    }
}

/// All cells around one, and itself, counted from the corner.
fn ring(rings: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    let n = 2 * rings + 1;
    (0..n * n * n).map(move |i| (i / (n * n), i / n % n, i % n))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn the_nearest_point_is_that_of_the_tree_but_far_away() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(9);
        let mut place = |scale: f64, flat: f64| {
            Point3::new(rng.random::<f64>() * scale, rng.random::<f64>() * scale, rng.random::<f64>() * flat)
        };
        for (count, flat) in [(1, 1.0), (2, 0.0), (700, 0.0), (700, 1.0)] {
            let points: Vec<Point3<f64>> = (0..count).map(|_| place(1.0, flat)).collect();
            let tree = KdTree::new(&points);
            let field = SurfaceDistance::new(tree.clone(), &points, tree.mean_spacing(5));
            for _ in 0..3000 {
                // Also far from the cloud.
                let q = place(1.4, 1.4) - Vector3::repeat(0.2);
                let (d2, k) = tree.nearest_one(&q).unwrap();
                let found = field.nearest(&q).unwrap();
                if field.cells.candidates(&q).is_empty() {
                    let far = (q - points[found as usize]).norm();
                    assert!(far <= FAR_SLACK * d2.sqrt() * (1.0 + 1e-12));
                } else {
                    assert_eq!(found, k);
                }
            }
        }
    }
}
