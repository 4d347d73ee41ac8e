//! Grids of every fineness at once: points sorted along a space-filling curve.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Bits an axis of the finest grid.
const DEPTH: usize = 42;

/// A grid of cubic cells over the box [−1, 1]³.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Level {
    /// Halvings of the box.
    pub(super) depth: usize,
    /// Edge of a cell.
    pub(super) cell: f64,
}

impl Level {
    /// The finest grid; points that share a cell of it can't be told apart.
    pub(super) const FINEST: Self = Self { depth: DEPTH, cell: 2.0 / (1u64 << DEPTH) as f64 };
}

/// Points in Morton order: those that share a cell of any grid lie next to
/// each other, and the cells of all grids are counted in one pass.
#[derive(Debug)]
pub(super) struct MortonOrder {
    /// Morton code and index of each point, ascending.
    sorted: Vec<(u128, u32)>,
    /// Number of occupied cells at each depth.
    occupied: Vec<usize>,
}

impl MortonOrder {
    /// Sorts points of the box [−1, 1]³ (others count as on its border).
    pub(super) fn new(points: &[Point3<f64>]) -> Self {
        let mut sorted: Vec<(u128, u32)> =
            points.par_iter().enumerate().map(|(i, p)| (code(p), i as u32)).collect();
        sorted.par_sort_unstable();
        // Two neighbours part at the depth of their highest differing bit.
        let mut parted = vec![0usize; DEPTH + 1];
        for pair in sorted.windows(2) {
            let differing = pair[0].0 ^ pair[1].0;
            if differing != 0 {
                let bit = 127 - differing.leading_zeros() as usize;
                parted[DEPTH - bit / 3] += 1;
            }
        }
        let mut cells = usize::from(!sorted.is_empty());
        let occupied = parted
            .into_iter()
            .map(|n| {
                cells += n;
                cells
            })
            .collect();
        Self { sorted, occupied }
    }

    /// The coarsest level with at least `cells` occupied cells.
    pub(super) fn level_with(&self, cells: usize) -> Option<Level> {
        let depth = self.occupied.iter().position(|&n| n >= cells)?;
        Some(Level { depth, cell: 2.0 / (1u64 << depth) as f64 })
    }

    /// The occupied cells of the given depth: the code and index of each of
    /// their points.
    pub(super) fn cells(&self, depth: usize) -> impl ParallelIterator<Item = &[(u128, u32)]> {
        let shift = 3 * (DEPTH - depth);
        self.sorted.par_chunk_by(move |a, b| a.0 >> shift == b.0 >> shift)
    }

    /// One point (index) of each cell of the given depth: the one nearest to
    /// the mean of the cell's points.
    pub(super) fn thinned(&self, points: &[Point3<f64>], depth: usize) -> Vec<u32> {
        self.cells(depth)
            .map(|cell| {
                let at = |i: u32| points[i as usize].coords;
                let mean = cell.iter().map(|c| at(c.1)).sum::<Vector3<f64>>() / cell.len() as f64;
                let mut best = (f64::INFINITY, u32::MAX);
                for &(_, i) in cell {
                    let candidate = ((at(i) - mean).norm_squared(), i);
                    if candidate < best {
                        best = candidate;
                    }
                }
                best.1
            })
            .collect()
    }
}

/// The Morton code of a point: the bits of its three cell numbers, woven.
fn code(p: &Point3<f64>) -> u128 {
    let top = (1u64 << DEPTH) - 1;
    let weave = |c: f64| spread((((c + 1.0) * 0.5 * (top + 1) as f64) as u64).min(top));
    weave(p.x) << 2 | weave(p.y) << 1 | weave(p.z)
}

/// Puts two zero bits between the lowest 42 bits of `v`.
fn spread(v: u64) -> u128 {
    u128::from(spread_short(v & 0x1f_ffff)) | u128::from(spread_short(v >> 21)) << 63
}

/// Puts two zero bits between the lowest 21 bits of `x`: as many as fit the
/// well-known 64-bit masks.
fn spread_short(mut x: u64) -> u64 {
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// A Morton code of 21 bits an axis, for a point of the box [−1, 1]³ (others
/// count as on its border): points that are near each other get near codes.
pub(crate) fn short_code(p: &Point3<f64>) -> u64 {
    let top = (1u64 << 21) - 1;
    let weave = |c: f64| spread_short((((c + 1.0) * 0.5 * (top + 1) as f64) as u64).min(top));
    weave(p.x) << 2 | weave(p.y) << 1 | weave(p.z)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn spread_moves_each_bit_to_three_times_its_place() {
        for bit in 0..DEPTH {
            assert_eq!(spread(1 << bit), 1u128 << (3 * bit), "bit {bit}");
        }
    }

    #[test]
    fn cells_are_counted_as_a_plain_grid_counts_them() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let points: Vec<Point3<f64>> = (0..2000)
            .map(|_| Point3::new(rng.random::<f64>() * 2.0 - 1.0, rng.random(), rng.random::<f64>().powi(9)))
            .collect();
        let order = MortonOrder::new(&points);
        for depth in 0..12 {
            let side = 2.0 / f64::from(1 << depth);
            let grid = |i: u32| points[i as usize].map(|c| ((c + 1.0) / side).floor() as i64);
            let cells: HashSet<_> = (0..2000).map(grid).collect();
            assert_eq!(order.occupied[depth], cells.len());
            let thinned: HashSet<_> = order.thinned(&points, depth).into_iter().map(grid).collect();
            assert_eq!(thinned, cells, "one point of each cell at depth {depth}");
        }
    }

    #[test]
    fn equal_points_share_the_finest_cell() {
        let p = Point3::new(0.3, -0.7, 1.0);
        let order = MortonOrder::new(&[p, Point3::new(-1.0, -1.0, -1.0), p]);
        assert_eq!(order.level_with(2).map(|l| l.depth), Some(1));
        assert_eq!(order.level_with(3), None);
        assert_eq!(order.thinned(&[p, p, p], DEPTH).len(), 2);
    }
}
