//! Clouds from NumPy arrays (`.npy`) and archives of them (`.npz`).

use std::borrow::Cow;

use super::columns::{Color, Gatherer, Nameless, Roles};
use super::raw::Raw;
use super::text::counted;
use crate::io::error::Fault;
use crate::io::npy::{Header, shown};
use grid::Grid;

mod archive;
mod batch;
mod grid;

pub(super) use archive::parse as parse_archive;

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
