//! How the numbers of an array are points.

use crate::io::npy::Header;

/// Columns that a point may have, where columns have no names.
const WIDEST: usize = 16;

/// How the numbers of an array are points or triples of anything.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    /// Sides over which the points are spread, the outermost first, each with
    /// how far it is from one entry to the next.
    pub(super) rows: Vec<(usize, usize)>,
    /// Numbers of a point, and how far it is from one to the next.
    pub(super) width: usize,
    pub(super) stride: usize,
    /// Whether the numbers of a point stand in rows, its points in columns.
    pub(super) turned: bool,
}

impl Grid {
    /// Rows of at least three numbers, if the shape can mean that.
    pub(super) fn of(header: &Header) -> Option<Self> {
        if header.is_structured {
            return None;
        }
        let mut rows = Self::sides(header)?;
        let is_point = |(side, _): (usize, usize)| (3..=WIDEST).contains(&side);
        let (last, before) = (rows.len().checked_sub(1)?, rows.len().checked_sub(2)?);
        let turned = !is_point(rows[last]) && rows[last].0 > WIDEST && is_point(rows[before]);
        if !turned && !is_point(rows[last]) {
            return None;
        }
        let (width, stride) = rows.remove(if turned { before } else { last });
        Some(Self { rows, width, stride, turned })
    }

    /// One number each, in an array of any shape.
    pub(super) fn of_numbers(header: &Header) -> Option<Self> {
        Some(Self { rows: Self::sides(header)?, width: 1, stride: 0, turned: false })
    }

    /// The sides of an array of numbers, with how far it is from one entry to
    /// the next.
    fn sides(header: &Header) -> Option<Vec<(usize, usize)>> {
        if header.columns.len() != 1 || header.size == 0 {
            return None;
        }
        let sides: Option<Vec<usize>> = header.shape.iter().map(|n| usize::try_from(*n).ok()).collect();
        let mut sides: Vec<(usize, usize)> = sides?.into_iter().map(|side| (side, 1)).collect();
        let mut stride = 1;
        let mut set = |(side, step): &mut (usize, usize)| (*step, stride) = (stride, stride * *side);
        if header.fortran_order {
            sides.iter_mut().for_each(&mut set);
        } else {
            sides.iter_mut().rev().for_each(&mut set);
        }
        Some(sides)
    }

    /// Number of points.
    pub(super) fn count(&self) -> usize {
        self.rows.iter().map(|(side, _)| side).product()
    }
}
