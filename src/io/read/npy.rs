//! NumPy arrays (`.npy`) and archives of them (`.npz`).
//!
//! Headers are read here because the crates for them multiply sides of shapes
//! without a check and follow brackets as deep as a file likes; the archive
//! itself is a library's.

use std::borrow::Cow;

use super::columns::{Color, Gatherer, Nameless, Roles};
use super::raw::Raw;
use super::text::counted;
use crate::io::error::Fault;
use header::{Header, shown};

mod archive;
mod header;

pub(super) use archive::parse as parse_archive;

/// Columns that a point may have, where columns have no names.
const WIDEST: u64 = 16;

pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let header = Header::parse(bytes)?;
    let body = &bytes[header.length..];
    if header.size > body.len() as u64 {
        return Err(Fault::at_byte(
            header.length,
            format!(
                "an array of {} is announced, {} bytes, but there are {}; the file may have been cut short",
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
#[derive(Debug, Clone, Copy)]
struct Grid {
    rows: usize,
    width: usize,
    /// Whether rows and columns change places.
    turned: bool,
}

impl Grid {
    /// Rows of at least three numbers, if the shape can mean that.
    fn of(header: &Header) -> Option<Self> {
        if header.is_structured || header.columns.len() != 1 {
            return None;
        }
        let [rows @ .., width] = &header.shape[..] else { return None };
        let count = rows.iter().product::<u64>();
        if rows.is_empty() || header.size == 0 {
            return None;
        }
        let turned = if (3..=WIDEST).contains(width) {
            false
        } else if rows.len() == 1 && (3..=WIDEST).contains(&rows[0]) && *width > WIDEST {
            true
        } else {
            return None;
        };
        let (rows, width) = if turned { (*width, count) } else { (count, *width) };
        Some(Self { rows: usize::try_from(rows).ok()?, width: usize::try_from(width).ok()?, turned })
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
                "the array is {} of {}; points need a row of three coordinates each (N×3)",
                shown(&header.shape),
                header.type_name
            );
            return Err(Fault::whole(problem));
        };
        let mut raw = Raw::default();
        if grid.turned {
            raw.notes
                .push(format!("the array is {}: its columns were taken as the points", shown(&header.shape)));
        }
        let triples = self.rows(grid, 0, 3);
        raw.points = triples.chunks_exact(3).map(|p| [p[0], p[1], p[2]].into()).collect();
        let width = grid.width - 3;
        let values = self.rows(grid, 3, width);
        raw.attributes = Nameless { values: &values, width, scalars_first: false }.attributes(&mut raw.notes);
        Ok(raw)
    }

    /// So many columns from the first of them on, row by row.
    fn rows(&self, grid: Grid, first: usize, width: usize) -> Vec<f64> {
        let header = &self.header;
        // Sides from the outermost to the innermost, with how far it is from
        // one entry to the next.
        let mut strides = vec![1usize; header.shape.len()];
        let sides: Vec<usize> = header.shape.iter().map(|n| *n as usize).collect();
        if header.fortran_order {
            for i in 1..sides.len() {
                strides[i] = strides[i - 1] * sides[i - 1];
            }
        } else {
            for i in (1..sides.len()).rev() {
                strides[i - 1] = strides[i] * sides[i];
            }
        }
        let last = sides.len() - 1;
        let place = |row: usize, column: usize| {
            if grid.turned {
                return column * strides[0] + row * strides[1];
            }
            let (mut rest, mut at) = (row, column * strides[last]);
            for i in (0..last).rev() {
                at += rest % sides[i] * strides[i];
                rest /= sides[i];
            }
            at
        };
        let mut values = Vec::with_capacity(grid.rows * width);
        for row in 0..grid.rows {
            for column in first..first + width {
                values.push(self.number(place(row, column)));
            }
        }
        values
    }

    /// A number of an array of numbers.
    fn number(&self, element: usize) -> f64 {
        let column = &self.header.columns[0];
        column.scalar.value(&self.body[element * self.header.element..], column.big_endian)
    }

    /// The numbers of an array of any shape, in the order of the file.
    fn numbers(&self) -> impl Iterator<Item = f64> {
        let count = self.header.size as usize / self.header.element.max(1);
        (0..count).map(|i| self.number(i))
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
