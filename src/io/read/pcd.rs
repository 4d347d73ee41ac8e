//! PCD (Point Cloud Library): ASCII, binary and compressed, with any fields in any order.
//!
//! Parsed here because the header must be checked against the file before memory is allocated, and
//! errors must name their line or byte. LZF decompression uses a library.

use nalgebra::Point3;

use super::columns::{Color, Gatherer, Roles};
use super::raw::Raw;
use super::scalar::Scalar;
use super::text::{lines, number, quoted};
use crate::io::error::Fault;
use header::{Data, Header};

mod header;

/// Whether a text begins as a PCD file does.
pub(super) fn is_pcd(text: &str) -> bool {
    let has_line = |words: &[&str]| {
        lines(text).take(30).any(|(_, l)| l.split_whitespace().next().is_some_and(|w| words.contains(&w)))
    };
    text.trim_start().starts_with("# .PCD")
        || (has_line(&["FIELDS", "COLUMNS"]) && has_line(&["SIZE", "DATA"]))
}

/// Most that LZF can make of a byte: three of them copy 264.
const MOST_LZF: u64 = 88;

pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let header = Header::parse(bytes)?;
    let names: Vec<&str> = header.columns.iter().map(|c| c.name.as_str()).collect();
    let Some(roles) = Roles::of(&names) else {
        let problem = format!("its fields are {}, but x, y and z are needed", names.join(", "));
        return Err(Fault::at_line(header.fields_line, problem));
    };
    let viewpoints = header.viewpoint.into_iter().map(Point3::from).collect();
    let mut raw = Raw { notes: header.notes.clone(), viewpoints, ..Raw::default() };
    match header.data {
        Data::Ascii => ascii(bytes, &header, roles, &mut raw)?,
        Data::Binary => {
            let body = &bytes[header.length..];
            let room = body.len() as u64 / header.record.max(1);
            if header.points > room {
                return Err(too_few(&header, room));
            }
            binary(body, &header, roles, false, &mut raw);
        }
        Data::Compressed => {
            let body = unpacked(bytes, &header)?;
            binary(&body, &header, roles, true, &mut raw);
        }
    }
    Ok(raw)
}

fn too_few(header: &Header, room: u64) -> Fault {
    Fault::at_byte(
        header.length,
        format!(
            "the header declares {} points of {} bytes, but the file has room for {room}; the file may be \
             truncated",
            header.points, header.record
        ),
    )
}

/// Whether colours are whole numbers.
fn whole_colors(header: &Header, roles: Roles) -> bool {
    match roles.color {
        Some(Color::Channels(columns)) => columns.iter().all(|&c| !header.columns[c].scalar.is_float()),
        _ => true,
    }
}

/// Points of a body that has been found long enough: one after another, or one
/// field after another.
fn binary(body: &[u8], header: &Header, roles: Roles, by_field: bool, raw: &mut Raw) {
    let count = header.points as usize;
    let mut gatherer = Gatherer::new(roles, count);
    let mut row = vec![0.0; header.columns.len()];
    for point in 0..count {
        for (i, (slot, column)) in row.iter_mut().zip(&header.columns).enumerate() {
            let at = if by_field {
                column.field_offset * count + column.field_size * point + column.offset - column.field_offset
            } else {
                header.record as usize * point + column.offset
            };
            // The bits of a packed colour are those of a whole number.
            let scalar = match column.scalar {
                Scalar::F32 if roles.color == Some(Color::Packed(i)) => Scalar::U32,
                scalar => scalar,
            };
            *slot = scalar.value(&body[at..], false);
        }
        gatherer.push(&row);
    }
    gatherer.finish(whole_colors(header, roles), raw);
}

/// The content of a compressed body.
fn unpacked(bytes: &[u8], header: &Header) -> Result<Vec<u8>, Fault> {
    let at = header.length;
    let size = |at: usize| {
        let b = bytes.get(at..at + 4)?;
        Some(u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])))
    };
    let (Some(packed), Some(whole)) = (size(at), size(at + 4)) else {
        return Err(Fault::at_byte(
            at,
            "the sizes of the compressed data are missing; the file is truncated",
        ));
    };
    let body = bytes.get(at + 8..).unwrap_or_default();
    if packed > body.len() as u64 {
        let problem = format!(
            "{packed} bytes of compressed data are declared, but there are {}; the file is truncated",
            body.len()
        );
        return Err(Fault::at_byte(at, problem));
    }
    let needed = header.record * header.points;
    if whole < needed {
        return Err(too_few(header, whole / header.record.max(1)));
    }
    if needed == 0 {
        return Ok(Vec::new());
    }
    let damaged =
        |why: &str| Fault::at_byte(at + 8, format!("the compressed data {why}; export the cloud again"));
    if whole > packed * MOST_LZF {
        return Err(damaged(&format!("of {packed} bytes cannot expand to the declared {whole}")));
    }
    let body =
        lzf::decompress(&body[..packed as usize], whole as usize).map_err(|_| damaged("are damaged"))?;
    if (body.len() as u64) < needed {
        return Err(damaged(&format!("expand to {} bytes, not {needed}", body.len())));
    }
    Ok(body)
}

/// One point a line.
fn ascii(bytes: &[u8], header: &Header, roles: Roles, raw: &mut Raw) -> Result<(), Fault> {
    let text = String::from_utf8_lossy(&bytes[header.length..]);
    // A digit and what parts it from the next.
    let room = (text.len() as u64 + 1) / (2 * header.columns.len().max(1)) as u64;
    let mut gatherer = Gatherer::new(roles, header.points.min(room) as usize);
    let mut row = Vec::with_capacity(header.columns.len());
    let packed = |i: usize| roles.color == Some(Color::Packed(i));
    let (mut done, mut surplus, mut last) = (0, 0, header.lines);
    for (i, line) in lines(&text) {
        let line_number = header.lines + i;
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        last = line_number;
        if done == header.points {
            surplus += 1;
            continue;
        }
        row.clear();
        for token in line.split_whitespace() {
            let value = number(token)
                .ok_or_else(|| Fault::at_line(line_number, format!("{} is not a number", quoted(token))))?;
            // A colour in a float is written as that, or as the whole number that its bits are.
            let is_bits = token.bytes().all(|b| b.is_ascii_digit());
            let is_float = packed(row.len())
                && !is_bits
                && header.columns.get(row.len()).is_some_and(|c| c.scalar == Scalar::F32);
            row.push(if is_float { f64::from((value as f32).to_bits()) } else { value });
        }
        if row.len() != header.columns.len() {
            let problem =
                format!("the line holds {} values, but its fields need {}", row.len(), header.columns.len());
            return Err(Fault::at_line(line_number, problem));
        }
        gatherer.push(&row);
        done += 1;
    }
    if done < header.points {
        let problem = format!(
            "the header declares {} points, but there are {done}; the file may be truncated",
            header.points
        );
        return Err(Fault::at_line(last, problem));
    }
    if surplus > 0 {
        raw.notes.push(format!("ignored {surplus} lines after the {done} declared points"));
    }
    gatherer.finish(whole_colors(header, roles), raw);
    Ok(())
}
