//! The header of a PCD file.

use crate::io::error::Fault;
use crate::io::read::columns::names_of_parts;
use crate::io::read::scalar::Scalar;
use crate::io::read::text::quoted;

/// A longer header is no header.
const LONGEST: usize = 1 << 20;
/// Numbers that a point may have; descriptors have a few hundred.
const MOST_COLUMNS: usize = 1 << 16;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Data {
    Ascii,
    Binary,
    Compressed,
}

/// One number of a point.
#[derive(Debug)]
pub(super) struct Column {
    /// In lower case.
    pub(super) name: String,
    pub(super) scalar: Scalar,
    /// Where it begins in a point, and its field, and how long that is.
    pub(super) offset: usize,
    pub(super) field_offset: usize,
    pub(super) field_size: usize,
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) columns: Vec<Column>,
    pub(super) data: Data,
    pub(super) points: u64,
    /// Bytes of a point; with `points`, no more than fit into 64 bits.
    pub(super) record: u64,
    /// Bytes and lines up to the body.
    pub(super) length: usize,
    pub(super) lines: usize,
    pub(super) fields_line: usize,
    /// Where the sensor was; none where the header has only the default.
    pub(super) viewpoint: Option<[f64; 3]>,
    pub(super) notes: Vec<String>,
}

/// The words of a line, and its number.
#[derive(Debug, Default)]
struct Words {
    line: usize,
    words: Vec<String>,
}

impl Words {
    fn number<T: std::str::FromStr>(&self, i: usize, what: &str) -> Result<T, Fault> {
        let word = self.words.get(i).map_or("", String::as_str);
        word.parse().map_err(|_| Fault::at_line(self.line, format!("{} is not a {what}", quoted(word))))
    }
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        let (mut fields, mut sizes, mut types) = (Words::default(), Words::default(), Words::default());
        let mut viewpoint = Words::default();
        let (mut counts, mut width, mut height, mut points) = (None, None, None, None);
        let (mut at, mut line_number) = (0, 0);
        let data = loop {
            line_number += 1;
            let rest = &bytes[at.min(bytes.len())..bytes.len().min(LONGEST)];
            if rest.is_empty() {
                return Err(Fault::at_line(line_number, "the header has no end (a DATA line)"));
            }
            let end = rest.iter().position(|b| *b == b'\n' || *b == b'\r');
            let line = String::from_utf8_lossy(&rest[..end.unwrap_or(rest.len())]);
            let is_pair = end.is_some_and(|end| rest[end..].starts_with(b"\r\n"));
            at += end.map_or(rest.len(), |end| end + if is_pair { 2 } else { 1 });
            let line = line.trim_start_matches('\u{feff}');
            let mut words = line.split_whitespace().map(str::to_owned);
            let Some(key) = words.next().filter(|w| !w.starts_with('#')) else { continue };
            let words = Words { line: line_number, words: words.collect() };
            match key.to_ascii_uppercase().as_str() {
                "VERSION" => {}
                "VIEWPOINT" => viewpoint = words,
                "FIELDS" | "COLUMNS" => fields = words,
                "SIZE" => sizes = words,
                "TYPE" => types = words,
                "COUNT" => counts = Some(words),
                "WIDTH" => width = Some(words.number::<u64>(0, "width")?),
                "HEIGHT" => height = Some(words.number::<u64>(0, "height")?),
                "POINTS" => points = Some((words.number::<u64>(0, "number of points")?, line_number)),
                "DATA" => {
                    let kind = words.words.first().map(|w| w.to_ascii_lowercase()).unwrap_or_default();
                    break match kind.as_str() {
                        "ascii" => Data::Ascii,
                        "binary" => Data::Binary,
                        "binary_compressed" => Data::Compressed,
                        _ => {
                            let problem = format!(
                                "{} is not one of ascii, binary and binary_compressed",
                                quoted(&kind)
                            );
                            return Err(Fault::at_line(line_number, problem));
                        }
                    };
                }
                _ => {
                    let problem = format!("unexpected {} in a PCD header", quoted(line.trim()));
                    return Err(Fault::at_line(line_number, problem));
                }
            }
        };
        let columns = columns(&fields, &sizes, &types, counts.as_ref())?;
        let record = columns.last().map_or(0, |c| c.field_offset + c.field_size) as u64;
        let grid = width.zip(height.or(Some(1))).and_then(|(w, h)| w.checked_mul(h));
        let (points, line) = points.or(grid.map(|n| (n, line_number))).ok_or_else(|| {
            Fault::at_line(line_number, "the header has no number of points (POINTS, or WIDTH and HEIGHT)")
        })?;
        if points.checked_mul(record).is_none() {
            return Err(Fault::at_line(
                line,
                format!("{points} points are declared, more than any file can contain"),
            ));
        }
        let mut notes = Vec::new();
        if let Some(grid) = grid.filter(|n| *n != points) {
            notes.push(format!("WIDTH times HEIGHT is {grid}, but POINTS is {points}; POINTS was used"));
        }
        let (length, lines) = (at, line_number);
        let place: Option<Vec<f64>> = viewpoint.words.iter().map(|w| w.parse().ok()).collect();
        let viewpoint = match place.as_deref() {
            Some([]) => None,
            Some(&[x, y, z, ref turn @ ..]) if turn.len() == 4 && [x, y, z].iter().all(|c| c.is_finite()) => {
                // Most programs write the origin without knowing.
                Some([x, y, z]).filter(|place| *place != [0.0; 3])
            }
            _ => {
                notes.push("the VIEWPOINT is not seven numbers and was ignored".to_owned());
                None
            }
        };
        Ok(Self { columns, data, points, record, length, lines, fields_line: fields.line, viewpoint, notes })
    }
}

fn columns(
    fields: &Words,
    sizes: &Words,
    types: &Words,
    counts: Option<&Words>,
) -> Result<Vec<Column>, Fault> {
    let expected = fields.words.len();
    if expected == 0 {
        return Err(Fault::whole("its header has no fields (a FIELDS line)"));
    }
    for (words, key) in [(Some(sizes), "SIZE"), (Some(types), "TYPE"), (counts, "COUNT")] {
        if let Some(words) = words.filter(|w| w.words.len() != expected) {
            let problem = format!("{key} has {} entries for {expected} fields", words.words.len());
            return Err(Fault::at_line(words.line.max(1), problem));
        }
    }
    let mut columns = Vec::new();
    let mut offset = 0;
    for (i, field) in fields.words.iter().enumerate() {
        let (size, kind): (usize, &str) = (sizes.number(i, "size")?, &types.words[i]);
        let scalar = match (kind, size) {
            ("I" | "i", 1) => Scalar::I8,
            ("I" | "i", 2) => Scalar::I16,
            ("I" | "i", 4) => Scalar::I32,
            ("I" | "i", 8) => Scalar::I64,
            ("U" | "u", 1) => Scalar::U8,
            ("U" | "u", 2) => Scalar::U16,
            ("U" | "u", 4) => Scalar::U32,
            ("U" | "u", 8) => Scalar::U64,
            ("F" | "f", 2) => Scalar::F16,
            ("F" | "f", 4) => Scalar::F32,
            ("F" | "f", 8) => Scalar::F64,
            _ => {
                let problem = format!("unknown number type {} of size {size}", quoted(kind));
                return Err(Fault::at_line(types.line, problem));
            }
        };
        let count: usize = counts.map_or(Ok(1), |c| c.number(i, "count"))?;
        if count > MOST_COLUMNS || columns.len() + count > MOST_COLUMNS {
            let line = counts.map_or(1, |c| c.line);
            return Err(Fault::at_line(line, format!("a point has more than {MOST_COLUMNS} numbers")));
        }
        let field_size = size * count;
        let names = names_of_parts(&field.to_ascii_lowercase(), count.max(1));
        columns.extend(names.into_iter().take(count).enumerate().map(|(k, name)| Column {
            name,
            scalar,
            offset: offset + k * size,
            field_offset: offset,
            field_size,
        }));
        offset += field_size;
    }
    Ok(columns)
}
