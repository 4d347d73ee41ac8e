//! NumPy arrays (`.npy`) and archives of them (`.npz`).
//!
//! Headers are parsed here because existing crates multiply dimensions without overflow checks and
//! follow nested brackets to any depth. Archives are opened with a library.

use std::borrow::Cow;

use super::columns::{Color, Gatherer, Nameless, Roles};
use super::raw::Raw;
use super::text::counted;
use crate::io::error::Fault;
use header::{Header, shown};

mod archive;
mod batch;
mod header;

pub(super) use archive::parse as parse_archive;

/// Columns that a point may have, where columns have no names.
const WIDEST: usize = 16;

pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let header = Header::parse(bytes)?;
    let body = &bytes[header.length..];
    if header.size > body.len() as u64 {
        return Err(Fault::at_byte(
            header.length,
            format!(
                "the header declares an array of {}, {} bytes, but there are {}; the file may be truncated",
                shown(&header.shape),
                header.size,
                body.len()
            ),
        ));
    }
    Array { header, body: Cow::Borrowed(body) }.cloud()
}

/// An array whose bytes are all there.
struct Array<'a> {
    header: Header,
    body: Cow<'a, [u8]>,
}

/// How the numbers of an array are points or triples of anything.
#[derive(Debug, Clone)]
struct Grid {
    /// Sides over which the points are spread, the outermost first, each with
    /// how far it is from one entry to the next.
    rows: Vec<(usize, usize)>,
    /// Numbers of a point, and how far it is from one to the next.
    width: usize,
    stride: usize,
    /// Whether the numbers of a point stand in rows, its points in columns.
    turned: bool,
}

impl Grid {
    /// Rows of at least three numbers, if the shape can mean that.
    fn of(header: &Header) -> Option<Self> {
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
    fn of_numbers(header: &Header) -> Option<Self> {
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
    fn count(&self) -> usize {
        self.rows.iter().map(|(side, _)| side).product()
    }
}

impl Array<'_> {
    fn cloud(&self) -> Result<Raw, Fault> {
        let header = &self.header;
        if header.is_structured {
            return self.records();
        }
        let Some(grid) = Grid::of(header) else {
            let problem = format!(
                "the array is {} of {}; points need one row of three coordinates each (N×3)",
                shown(&header.shape),
                header.type_name
            );
            return Err(Fault::whole(problem));
        };
        let mut raw = Raw::default();
        if grid.turned {
            raw.notes.push(format!("the array is {}: its columns were read as points", shown(&header.shape)));
        }
        let mut triples = self.rows(&grid, 0, 3);
        let count = batch::points_of_one_shape(&grid, &triples, &shown(&header.shape), &mut raw.notes);
        triples.truncate(3 * count);
        raw.points = triples.chunks_exact(3).map(|p| [p[0], p[1], p[2]].into()).collect();
        let width = grid.width - 3;
        let mut values = self.rows(&grid, 3, width);
        values.truncate(width * count);
        raw.attributes = Nameless { values: &values, width, scalars_first: false }.attributes(&mut raw.notes);
        Ok(raw)
    }

    /// So many columns from the first of them on, row by row.
    fn rows(&self, grid: &Grid, first: usize, width: usize) -> Vec<f64> {
        let count = grid.count();
        let mut values = Vec::with_capacity(count * width);
        for row in 0..count {
            let (mut rest, mut at) = (row, 0);
            for (side, stride) in grid.rows.iter().rev() {
                at += rest % side * stride;
                rest /= side;
            }
            values.extend((first..first + width).map(|column| self.number(at + column * grid.stride)));
        }
        values
    }

    /// A number of an array of numbers.
    fn number(&self, element: usize) -> f64 {
        let column = &self.header.columns[0];
        column.scalar.value(&self.body[element * self.header.element..], column.big_endian)
    }

    /// Elements with named parts.
    fn records(&self) -> Result<Raw, Fault> {
        let header = &self.header;
        let names: Vec<&str> = header.columns.iter().map(|c| c.name.as_str()).collect();
        let Some(roles) = Roles::of(&names) else {
            let problem = format!("its fields are {}, but x, y and z are needed", names.join(", "));
            return Err(Fault::whole(problem));
        };
        let count = header.size as usize / header.element.max(1);
        let mut gatherer = Gatherer::new(roles, count);
        let mut row = vec![0.0; header.columns.len()];
        for element in self.body.chunks_exact(header.element.max(1)).take(count) {
            for (slot, column) in row.iter_mut().zip(&header.columns) {
                *slot = column.scalar.value(&element[column.offset..], column.big_endian);
            }
            gatherer.push(&row);
        }
        let whole = match roles.color {
            Some(Color::Channels(columns)) => columns.iter().all(|&c| !header.columns[c].scalar.is_float()),
            _ => true,
        };
        let mut raw = Raw::default();
        if header.shape.iter().filter(|side| **side > 1).count() > 1 {
            raw.notes.push(batch::taken_as_one(&shown(&header.shape), count));
        }
        gatherer.finish(whole, &mut raw);
        Ok(raw)
    }
}

/// "12 arrays", with their names and shapes.
fn listed(arrays: &[(String, Header)]) -> String {
    const MOST: usize = 12;
    let shown =
        arrays.iter().take(MOST).map(|(name, h)| format!("{name} ({} {})", shown(&h.shape), h.type_name));
    let more = if arrays.len() > MOST { ", …" } else { "" };
    format!("{}: {}{more}", counted(arrays.len(), "array", "arrays"), shown.collect::<Vec<_>>().join(", "))
}
