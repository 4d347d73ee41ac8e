//! STL, binary and ASCII: separate triangles. Corners at the same position become one vertex.
//!
//! Files can mislead in both directions: binary files may start with `solid`, and declared counts
//! may be wrong. The file size therefore decides what is binary, and counts are checked before
//! memory is allocated. Existing crates trust both.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use nalgebra::Point3;

use super::raw::Raw;
use super::text::{decode, lines, number, quoted};
use crate::io::error::Fault;

/// Bytes before the first triangle of a binary file: 80 of header, 4 of count.
const HEADER: usize = 84;
/// Bytes of a triangle: normal, three corners, and two for attributes.
const TRIANGLE: usize = 50;

/// The number of triangles that a binary file announces.
fn announced(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..HEADER)?;
    Some(u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]])))
}

/// Whether the length is exactly that of a binary STL with as many triangles
/// as it announces.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    announced(bytes).is_some_and(|n| bytes.len() as u64 == HEADER as u64 + TRIANGLE as u64 * n)
}

/// Whether a text begins as an ASCII STL does.
pub(super) fn is_ascii(text: &str) -> bool {
    let mut words = text.split_ascii_whitespace().map(str::to_ascii_lowercase);
    words.next().is_some_and(|w| w == "solid") && words.any(|w| w == "facet" || w == "endsolid")
}

pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    // A text has no zeros, but for some that fill up its end; a binary STL has
    // them in its count, at the latest.
    let length = bytes.iter().rposition(|b| !matches!(b, 0 | 0x1a)).map_or(0, |last| last + 1);
    let is_text = length > 0 && !is_binary(bytes) && !bytes[..length].contains(&0);
    let is_utf16 = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
    let raw = if is_utf16 {
        ascii(&decode(bytes))
    } else if is_text {
        ascii(&decode(&bytes[..length]))
    } else {
        binary(bytes)
    }?;
    if raw.triangles.is_empty() {
        return Err(Fault::whole("it has no triangles; export the shape again"));
    }
    Ok(raw)
}

/// Triangles whose corners at the same place are one vertex, in order of their
/// first appearance.
#[derive(Debug, Default)]
struct Soup {
    raw: Raw,
    index_of: HashMap<[u64; 3], u32, BuildHasherDefault<PlaceHasher>>,
    /// Corners of the facet that was added last.
    facet: Vec<u32>,
}

/// A quick hash of coordinates: each is mixed in by a multiplication to twice
/// the width, whose halves are folded (the usual hash takes half of the time
/// of reading).
#[derive(Debug, Default)]
struct PlaceHasher(u64);

impl Hasher for PlaceHasher {
    fn write(&mut self, bytes: &[u8]) {
        for part in bytes.chunks(8) {
            let mut eight = [0; 8];
            eight[..part.len()].copy_from_slice(part);
            self.write_u64(u64::from_le_bytes(eight));
        }
    }

    fn write_u64(&mut self, value: u64) {
        let product = u128::from(self.0 ^ value ^ 0x2545_f491_4f6c_dd1d) * 0x9e37_79b9_7f4a_7c15;
        self.0 = (product >> 64) as u64 ^ product as u64;
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

impl Soup {
    fn add(&mut self, corners: &[[f64; 3]]) -> Result<(), Fault> {
        self.facet.clear();
        for corner in corners {
            // Adding zero makes both zeros one place.
            let next = u32::try_from(self.raw.points.len())
                .map_err(|_| Fault::whole("it has too many vertices; simplify the mesh"))?;
            let index = *self.index_of.entry(corner.map(|c| (c + 0.0).to_bits())).or_insert(next);
            if index == next {
                self.raw.points.push(Point3::from(*corner));
            }
            self.facet.push(index);
        }
        self.raw.polygon(&self.facet);
        Ok(())
    }
}

fn binary(bytes: &[u8]) -> Result<Raw, Fault> {
    let cut = "the file may be truncated";
    let Some(count) = announced(bytes) else {
        return Err(Fault::at_byte(bytes.len(), format!("the header of a binary STL ends here; {cut}")));
    };
    let room = (bytes.len() - HEADER) / TRIANGLE;
    // Programs that write as they go leave the count open.
    let is_open = count == 0 && room > 0 && (bytes.len() - HEADER).is_multiple_of(TRIANGLE);
    let count = if is_open { room as u64 } else { count };
    if count > room as u64 {
        let problem =
            format!("the header declares {count} triangles, but the file has room for at most {room}; {cut}");
        return Err(Fault::at_byte(80, problem));
    }
    let mut soup = Soup::default();
    soup.raw.triangles.reserve_exact(count as usize);
    for triangle in bytes[HEADER..].chunks_exact(TRIANGLE).take(count as usize) {
        let value = |at: usize| {
            f64::from(f32::from_le_bytes([
                triangle[at],
                triangle[at + 1],
                triangle[at + 2],
                triangle[at + 3],
            ]))
        };
        soup.add(&[0, 1, 2].map(|corner| [0, 1, 2].map(|axis| value(12 + 12 * corner + 4 * axis))))?;
    }
    if is_open {
        soup.raw
            .notes
            .push(format!("the header declares no triangles, but there are {count}; all were read"));
    }
    if is_binary(bytes) || is_open || count == 0 {
        return Ok(soup.raw);
    }
    let surplus = bytes.len() - HEADER - TRIANGLE * count as usize;
    soup.raw.notes.push(format!("{surplus} bytes after the {count} declared triangles were ignored"));
    Ok(soup.raw)
}

/// Words in any layout: what matters is `vertex` with its numbers, and where a
/// facet ends.
fn ascii(text: &str) -> Result<Raw, Fault> {
    let mut soup = Soup::default();
    let mut corners: Vec<[f64; 3]> = Vec::new();
    let (mut has_begun, mut is_open, mut last) = (false, false, 1);
    // Numbers may stand on the next line, so that a word is told to those who wait.
    let mut missing: Vec<f64> = Vec::new();
    let mut wanted = Wanted::Keyword;
    for (line_number, line) in lines(text) {
        // A name may be any text, or none, but is not longer than its line.
        if wanted == Wanted::Name {
            wanted = Wanted::Keyword;
        }
        let mut words = line.split_whitespace();
        while let Some(word) = words.next() {
            last = line_number;
            let lower = word.to_ascii_lowercase();
            match wanted {
                Wanted::Corner => {
                    missing.push(number(word).ok_or_else(|| {
                        Fault::at_line(line_number, format!("{} is not a number", quoted(word)))
                    })?);
                    if let [x, y, z] = missing[..] {
                        corners.push([x, y, z]);
                        missing.clear();
                        wanted = Wanted::Keyword;
                    }
                    continue;
                }
                Wanted::Normal if !["outer", "loop", "vertex", "endfacet"].contains(&lower.as_str()) => {
                    continue;
                }
                Wanted::Name => {
                    let next = words.clone().next();
                    if lower != "facet" || !next.is_some_and(|next| next.eq_ignore_ascii_case("normal")) {
                        continue;
                    }
                }
                Wanted::Normal | Wanted::End | Wanted::Keyword => {}
            }
            let is_end = wanted == Wanted::End;
            wanted = Wanted::Keyword;
            match lower.as_str() {
                "endsolid" => (is_open, wanted) = (false, Wanted::Name),
                "solid" if is_end => (is_open, wanted) = (false, Wanted::Name),
                "solid" => (has_begun, is_open, wanted) = (true, true, Wanted::Name),
                "loop" | "facet" if is_end => facet(&mut soup, &mut corners, line_number)?,
                "facet" => (has_begun, wanted) = (true, Wanted::Normal),
                "vertex" if has_begun => wanted = Wanted::Corner,
                "outer" | "loop" if has_begun => {}
                "endloop" | "endfacet" if has_begun => facet(&mut soup, &mut corners, line_number)?,
                // In two words.
                "end" if has_begun => wanted = Wanted::End,
                "color" if has_begun => break,
                _ if word.starts_with(['#', ';']) || word.starts_with("//") => break,
                // Between one solid and the next.
                _ if has_begun && !is_open && corners.is_empty() => break,
                _ => {
                    let problem = format!("unexpected {} in an STL mesh", quoted(word));
                    return Err(Fault::at_line(line_number, problem));
                }
            }
        }
    }
    if !corners.is_empty() || !matches!(wanted, Wanted::Keyword | Wanted::Name) {
        return Err(Fault::at_line(last, "a facet is incomplete; the file may be truncated"));
    }
    if is_open {
        soup.raw.notes.push("the file has no endsolid and may be truncated".to_owned());
    }
    Ok(soup.raw)
}

/// What the next word of an ASCII file must be.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wanted {
    Keyword,
    /// Any words to the end of the line, or to the first facet.
    Name,
    /// Any words, up to where the corners begin.
    Normal,
    /// A coordinate of a corner.
    Corner,
    /// What is ended.
    End,
}

/// Closes a facet, which may have more corners than three.
fn facet(soup: &mut Soup, corners: &mut Vec<[f64; 3]>, line: usize) -> Result<(), Fault> {
    match corners.len() {
        // `endfacet` after `endloop`.
        0 => {}
        1 | 2 => return Err(Fault::at_line(line, "a facet needs three corners")),
        _ => soup.add(corners)?,
    }
    corners.clear();
    Ok(())
}
