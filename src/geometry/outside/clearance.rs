//! How far each empty cell is from the surface: the exact Euclidean distance
//! transform of P. Felzenszwalb and D. Huttenlocher, "Distance Transforms of
//! Sampled Functions", Theory of Computing 8, 2012.

use rayon::prelude::*;

/// More than any squared distance in a grid.
const FAR: u32 = u32::MAX / 4;

/// Squared distance, in cells, from the centre of each cell to that of the
/// nearest touched one; 0 where the cell is touched itself.
pub(super) fn squared_clearance(touched: &[bool], dims: [usize; 3]) -> Vec<u32> {
    let [nx, ny, nz] = dims;
    let mut along_xy: Vec<u32> = touched.iter().map(|&t| if t { 0 } else { FAR }).collect();
    along_xy.par_chunks_mut(nx * ny).for_each(|slab| {
        let mut line = Line::new(nx.max(ny));
        for y in 0..ny {
            line.transform(nx, slab, y * nx, 1);
        }
        for x in 0..nx {
            line.transform(ny, slab, x, nx);
        }
    });
    // Columns along z become contiguous for a moment: each thread has its own.
    let mut columns = vec![0; along_xy.len()];
    columns.par_chunks_mut(nx * nz).enumerate().for_each(|(y, wall)| {
        let mut line = Line::new(nz);
        for z in 0..nz {
            wall[z * nx..(z + 1) * nx].copy_from_slice(&along_xy[(z * ny + y) * nx..][..nx]);
        }
        for x in 0..nx {
            line.transform(nz, wall, x, nx);
        }
    });
    along_xy.par_chunks_mut(nx * ny).enumerate().for_each(|(z, slab)| {
        for y in 0..ny {
            slab[y * nx..(y + 1) * nx].copy_from_slice(&columns[(y * nz + z) * nx..][..nx]);
        }
    });
    along_xy
}

/// Memory for the transform of one line of cells.
struct Line {
    values: Vec<u32>,
    /// Places of the parabolas of the lower envelope, and where each begins.
    places: Vec<usize>,
    begins: Vec<f64>,
}

impl Line {
    fn new(longest: usize) -> Self {
        Self {
            values: Vec::with_capacity(longest),
            places: Vec::with_capacity(longest),
            begins: Vec::with_capacity(longest),
        }
    }

    /// Replaces f by min over q of (p − q)² + f(q), for the `count` cells of
    /// `cells` from `first` on, `stride` apart.
    fn transform(&mut self, count: usize, cells: &mut [u32], first: usize, stride: usize) {
        let Self { values, places, begins } = self;
        values.clear();
        values.extend((0..count).map(|i| cells[first + i * stride]));
        places.clear();
        begins.clear();
        for q in 0..count {
            if values[q] >= FAR {
                continue;
            }
            let height = |p: usize| f64::from(values[p]) + (p * p) as f64;
            let mut begin = f64::NEG_INFINITY;
            while let (Some(&last), Some(&its_begin)) = (places.last(), begins.last()) {
                begin = (height(q) - height(last)) / (2 * (q - last)) as f64;
                if begin > its_begin {
                    break;
                }
                places.pop();
                begins.pop();
                begin = f64::NEG_INFINITY;
            }
            places.push(q);
            begins.push(begin);
        }
        if places.is_empty() {
            return;
        }
        let mut at = 0;
        for p in 0..count {
            while begins.get(at + 1).is_some_and(|&begin| begin < p as f64) {
                at += 1;
            }
            let offset = p.abs_diff(places[at]) as u32;
            cells[first + p * stride] = offset * offset + values[places[at]];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn clearance_is_the_distance_to_the_nearest_touched_cell() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        for dims in [[7, 5, 6], [1, 9, 4], [12, 1, 1]] {
            let [nx, ny, nz] = dims;
            let mut touched: Vec<bool> = (0..nx * ny * nz).map(|_| rng.random_bool(0.03)).collect();
            touched[nx * ny * nz / 2] = true;
            let found = squared_clearance(&touched, dims);
            let place = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)];
            for (i, &d2) in found.iter().enumerate() {
                let nearest = (0..touched.len())
                    .filter(|&j| touched[j])
                    .map(|j| (0..3).map(|k| place(i)[k].abs_diff(place(j)[k]).pow(2)).sum::<usize>())
                    .min();
                assert_eq!(Some(d2 as usize), nearest);
            }
        }
    }
}
