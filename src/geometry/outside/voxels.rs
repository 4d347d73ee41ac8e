//! A grid of cubes over a shape, and the cubes that its triangles touch.

use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::geometry::mesh::Triangle;

/// Cells that a grid has, about: what is surveyed in a tenth of a second on one core.
const CELLS: f64 = 3e5;
/// Most cells along the longest edge, for long thin shapes.
const LONGEST: f64 = 192.0;
/// Empty layers around the shape.
const MARGIN: usize = 2;
/// Most cells that all triangles together may touch; a mesh that is folded over
/// itself many times gets a coarser grid.
const TOUCHED: f64 = 3e7;

/// Cubic cells, x fastest. The outermost layers touch no triangle.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    pub(super) dims: [usize; 3],
    origin: Point3<f64>,
    /// Edge of a cell.
    pub(super) cell: f64,
}

impl Grid {
    /// The grid for some triangles of the box [−1, 1]³.
    pub(super) fn over(triangles: &[Triangle]) -> Self {
        let (lo, hi) = super::super::mesh::bounds(triangles.iter().flatten().copied()).unwrap_or_default();
        let extent = hi - lo;
        let longest = extent.max().max(f64::MIN_POSITIVE);
        // What is left of the volume once each extent is at least a twentieth.
        let volume: f64 = extent.iter().map(|e| e.max(0.05 * longest)).product();
        let mut cell = (volume / CELLS).cbrt().max(longest / LONGEST);
        let touched: f64 = triangles
            .iter()
            .map(|[a, b, c]| {
                let (u, v) = ((b - a) / cell, (c - a) / cell);
                2.0 + u.norm() + v.norm() + u.cross(&v).norm()
            })
            .sum();
        cell *= (touched / TOUCHED).sqrt().clamp(1.0, 8.0);
        let dims = [0, 1, 2].map(|k| (extent[k] / cell).ceil() as usize + 1 + 2 * MARGIN);
        // The shape in the middle: what is symmetric stays so.
        let spare = Vector3::from_fn(|k, _| dims[k] as f64 * cell - extent[k]);
        Self { dims, origin: lo - 0.5 * spare, cell }
    }

    pub(super) fn len(&self) -> usize {
        self.dims.iter().product()
    }

    pub(super) fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.dims[1] + y) * self.dims[0] + x
    }

    /// In units of cells; cell (i, j, k) is the box from there to +1.
    pub(super) fn place(&self, p: &Point3<f64>) -> Vector3<f64> {
        (p - self.origin) / self.cell
    }

    /// The cell that a place lies in; `None` outside the grid.
    pub(super) fn cell_at(&self, place: &Vector3<f64>) -> Option<[usize; 3]> {
        let inside = (0..3).all(|k| place[k] >= 0.0 && place[k] < self.dims[k] as f64);
        inside.then(|| [0, 1, 2].map(|k| place[k] as usize))
    }

    /// Which cells a triangle touches, be it by a corner.
    pub(super) fn touched(&self, triangles: &[Triangle]) -> Vec<bool> {
        let touched: Vec<AtomicBool> = (0..self.len()).map(|_| AtomicBool::new(false)).collect();
        triangles.par_iter().with_min_len(64).for_each(|triangle| {
            let corners = triangle.map(|p| self.place(&p));
            let low = corners[0].inf(&corners[1]).inf(&corners[2]);
            let high = corners[0].sup(&corners[1]).sup(&corners[2]);
            let lo = [0, 1, 2].map(|k| low[k].max(0.0) as usize);
            let hi = [0, 1, 2].map(|k| (high[k] as usize + 1).min(self.dims[k]));
            self.touch(&corners, lo, hi, &touched);
        });
        touched.into_iter().map(AtomicBool::into_inner).collect()
    }

    /// Marks the cells of the block `lo..hi` that the triangle touches, by
    /// halving: the cost follows the cells touched, also for long splinters.
    fn touch(&self, corners: &[Vector3<f64>; 3], lo: [usize; 3], hi: [usize; 3], touched: &[AtomicBool]) {
        let size = [0, 1, 2].map(|k| hi[k] - lo[k]);
        if !overlaps(corners, lo, size) {
            return;
        }
        if size == [1; 3] {
            touched[self.index(lo)].store(true, Ordering::Relaxed);
            return;
        }
        let axis = (0..3).max_by_key(|&k| size[k]).unwrap_or(0);
        let middle = lo[axis] + size[axis] / 2;
        let (mut low_end, mut high_start) = (hi, lo);
        low_end[axis] = middle;
        high_start[axis] = middle;
        self.touch(corners, lo, low_end, touched);
        self.touch(corners, high_start, hi, touched);
    }
}

/// Whether a triangle and a block of cells overlap, by the separating axis
/// theorem: the block's faces, the triangle's plane, nine products of edges.
fn overlaps(corners: &[Vector3<f64>; 3], lo: [usize; 3], size: [usize; 3]) -> bool {
    const SLACK: f64 = 1e-9;
    let half = Vector3::from_fn(|k, _| 0.5 * size[k] as f64);
    let center = Vector3::from_fn(|k, _| lo[k] as f64) + half;
    let [a, b, c] = corners.map(|p| p - center);
    for k in 0..3 {
        let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
        if low > half[k] + SLACK || high < -half[k] - SLACK {
            return false;
        }
    }
    let apart = |axis: Vector3<f64>| {
        let (pa, pb, pc) = (axis.dot(&a), axis.dot(&b), axis.dot(&c));
        let reach = half.dot(&axis.abs()) + SLACK * axis.amax();
        pa.min(pb).min(pc) > reach || pa.max(pb).max(pc) < -reach
    };
    let edges = [b - a, c - b, a - c];
    if apart(edges[0].cross(&edges[1])) {
        return false;
    }
    edges.iter().all(|e| {
        !(apart(Vector3::new(0.0, -e.z, e.y))
            || apart(Vector3::new(e.z, 0.0, -e.x))
            || apart(Vector3::new(-e.y, e.x, 0.0)))
    })
}
