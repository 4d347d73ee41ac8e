//! Which empty cells belong to the outside, and which to hollows.
//!
//! The clearance is a landscape turned upside down: water poured in from the
//! roomiest cells down forms basins, which meet at necks. A basin whose neck
//! is much narrower than itself and whose openings are a small part of its
//! border is a *hollow*, such as the inside of a bottle; it is filled. All
//! other basins that can be reached belong to the outside: the room under a
//! table, the inside of an open tin.

use super::voxels::Grid;
use crate::geometry::forest::Forest;

/// Two basins are one where the neck between them is at least this wide,
/// relative to the smaller one.
const NECK: f64 = 0.6;
/// Basins of a smaller inner radius, in cells, are none: the grid can't tell.
const SMALLEST: u32 = 3;
/// A basin with a larger share of openings in its border is no hollow.
const OPENINGS: f64 = 0.1;

/// What a cell is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cell {
    /// A triangle touches it: rays decide.
    Surface,
    /// Empty, and can be reached from outside.
    Outside,
    /// Empty, and is closed off, or as good as that.
    Hollow,
}

/// Tells the cells apart, given their squared clearance.
pub(super) fn tell(grid: &Grid, clearance: &[u32]) -> Vec<Cell> {
    let mut basins = Basins { sets: Forest::of(1), radius2: vec![u32::MAX] };
    let flooded = basins.flood(grid, clearance);
    let is_outside = basins.reached(grid, &flooded);
    flooded
        .into_iter()
        .map(|basin| match basin {
            NONE => Cell::Surface,
            basin if is_outside[basin as usize] => Cell::Outside,
            _ => Cell::Hollow,
        })
        .collect()
}

const NONE: u32 = u32::MAX;

/// A forest of basins; number 0 is the outside.
struct Basins {
    sets: Forest,
    /// Squared inner radius, in cells.
    radius2: Vec<u32>,
}

impl Basins {
    /// The basin of each empty cell, `NONE` for the others.
    fn flood(&mut self, grid: &Grid, clearance: &[u32]) -> Vec<u32> {
        let mut basin_of = vec![NONE; clearance.len()];
        for_each_of_border(grid, |i| basin_of[i] = 0);
        for i in by_falling_clearance(clearance) {
            if basin_of[i as usize] != NONE {
                continue;
            }
            let here = clearance[i as usize];
            let mut met = [NONE; 6];
            let mut roomiest = NONE;
            for (slot, j) in met.iter_mut().zip(neighbors(grid, i as usize)) {
                if basin_of[j] != NONE {
                    *slot = self.sets.root(basin_of[j]);
                    // The outside is never less roomy than another basin.
                    if roomiest == NONE
                        || (self.radius2[*slot as usize], roomiest) > (self.radius2[roomiest as usize], *slot)
                    {
                        roomiest = *slot;
                    }
                }
            }
            if roomiest == NONE {
                roomiest = self.sets.add();
                self.radius2.push(here);
            }
            for other in met.into_iter().filter(|&b| b != NONE && b != roomiest) {
                let smaller = self.radius2[other as usize];
                let is_wide = f64::from(here) >= NECK * NECK * f64::from(smaller);
                if is_wide || smaller < SMALLEST * SMALLEST {
                    self.sets.hang(other, roomiest);
                }
            }
            basin_of[i as usize] = roomiest;
        }
        for basin in &mut basin_of {
            if *basin != NONE {
                *basin = self.sets.root(*basin);
            }
        }
        basin_of
    }

    /// Which basins belong to the outside: the outside itself, and those with
    /// large openings to what belongs to it.
    fn reached(&self, grid: &Grid, basin_of: &[u32]) -> Vec<bool> {
        let mut border = vec![0u32; self.sets.len()];
        let mut shared: Vec<(u32, u32)> = Vec::new();
        for (i, &basin) in basin_of.iter().enumerate() {
            if basin == NONE || basin == 0 {
                continue;
            }
            for j in neighbors(grid, i) {
                let other = basin_of[j];
                border[basin as usize] += u32::from(other != basin);
                if other != NONE && other != basin {
                    shared.push((basin, other));
                }
            }
        }
        let mut is_outside = vec![false; self.sets.len()];
        is_outside[0] = true;
        loop {
            let mut open = vec![0u32; self.sets.len()];
            for &(basin, other) in &shared {
                open[basin as usize] += u32::from(is_outside[other as usize]);
            }
            let mut changed = false;
            for basin in 1..is_outside.len() {
                if !is_outside[basin] && f64::from(open[basin]) > OPENINGS * f64::from(border[basin]) {
                    is_outside[basin] = true;
                    changed = true;
                }
            }
            if !changed {
                return is_outside;
            }
        }
    }
}

/// The empty cells, the roomiest first, in the grid's order among equals.
fn by_falling_clearance(clearance: &[u32]) -> Vec<u32> {
    let most = clearance.iter().copied().max().unwrap_or(0) as usize;
    let mut starts = vec![0u32; most + 1];
    for &d2 in clearance {
        starts[most - d2 as usize] += 1;
    }
    let mut sum = 0;
    for start in &mut starts {
        sum += std::mem::replace(start, sum);
    }
    // Touched cells have no clearance, so they come last.
    let mut order = vec![0; clearance.len()];
    for (i, &d2) in (0u32..).zip(clearance) {
        let place = &mut starts[most - d2 as usize];
        order[*place as usize] = i;
        *place += 1;
    }
    order.truncate(clearance.iter().filter(|&&d2| d2 > 0).count());
    order
}

/// The up to six cells that share a face with one.
fn neighbors(grid: &Grid, i: usize) -> impl Iterator<Item = usize> {
    let [nx, ny, nz] = grid.dims;
    let (x, y, z) = (i % nx, i / nx % ny, i / (nx * ny));
    [
        (x > 0, i.wrapping_sub(1)),
        (x + 1 < nx, i + 1),
        (y > 0, i.wrapping_sub(nx)),
        (y + 1 < ny, i + nx),
        (z > 0, i.wrapping_sub(nx * ny)),
        (z + 1 < nz, i + nx * ny),
    ]
    .into_iter()
    .filter_map(|(exists, j)| exists.then_some(j))
}

fn for_each_of_border(grid: &Grid, mut visit: impl FnMut(usize)) {
    let [nx, ny, nz] = grid.dims;
    for z in 0..nz {
        for y in 0..ny {
            let whole_row = z == 0 || z + 1 == nz || y == 0 || y + 1 == ny;
            let step = if whole_row { 1 } else { (nx - 1).max(1) };
            for x in (0..nx).step_by(step) {
                visit(grid.index([x, y, z]));
            }
        }
    }
}
