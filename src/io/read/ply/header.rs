//! The header of a PLY file.

use crate::io::error::Fault;
use crate::io::read::scalar::Scalar;
use crate::io::read::text::quoted;

/// A longer header is no header.
const LONGEST: usize = 1 << 20;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Binary { big_endian: bool },
}

/// The type with this name.
fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "char" | "int8" => Scalar::I8,
        "uchar" | "uint8" => Scalar::U8,
        "short" | "int16" => Scalar::I16,
        "ushort" | "uint16" => Scalar::U16,
        "int" | "int32" => Scalar::I32,
        "uint" | "uint32" => Scalar::U32,
        "int64" => Scalar::I64,
        "uint64" => Scalar::U64,
        "float" | "float32" => Scalar::F32,
        "double" | "float64" => Scalar::F64,
        _ => return None,
    })
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    pub(super) fn is_vertex(&self) -> bool {
        ["vertex", "vertices", "point"].iter().any(|n| self.name.eq_ignore_ascii_case(n))
    }

    /// Faces, or strips of them.
    pub(super) fn is_face(&self) -> bool {
        ["face", "faces", "tristrips"].iter().any(|n| self.name.eq_ignore_ascii_case(n))
    }

    pub(super) fn is_edge(&self) -> bool {
        ["edge", "edges"].iter().any(|n| self.name.eq_ignore_ascii_case(n))
    }

    /// The property that lists the vertices of a face: by its name, or else the
    /// first list of whole numbers.
    pub(super) fn face_list(&self) -> Option<usize> {
        let is_list = |p: &Property| matches!(p.kind, Kind::List { .. });
        let named = |p: &Property| ["vertex_indices", "vertex_index"].contains(&p.name.as_str());
        let is_whole = |p: &Property| matches!(p.kind, Kind::List { item, .. } if !item.is_float());
        let place = |wanted: &dyn Fn(&Property) -> bool| self.properties.iter().position(wanted);
        place(&|p| is_list(p) && named(p)).or_else(|| place(&is_whole))
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Bytes up to the first one of the body.
    pub(super) length: usize,
    /// Lines of the header.
    pub(super) lines: usize,
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        // The first line shows how this file ends its lines; a line feed that
        // belongs to binary data must not be taken for a part of the ending.
        let first = bytes.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(bytes.len());
        let ending: &[u8] = match &bytes[first..] {
            [b'\r', b'\n', ..] => b"\r\n",
            [b'\r', ..] => b"\r",
            _ => b"\n",
        };
        let mut has_begun = false;
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut at = 0;
        for line_number in 1.. {
            let rest = &bytes[at..bytes.len().min(LONGEST)];
            let Some(length) = rest.windows(ending.len()).position(|w| w == ending) else {
                // The last line of a file without a body may lack its ending.
                if rest == b"end_header" {
                    at = bytes.len();
                    return Self::finish(encoding, elements, at, line_number);
                }
                return Err(Fault::at_line(line_number, "the header has no end (end_header)"));
            };
            let line = String::from_utf8_lossy(&rest[..length]);
            at += length + ending.len();
            let words: Vec<&str> = line.split_whitespace().collect();
            let fault = |problem: String| Fault::at_line(line_number, problem);
            match words[..] {
                [word] if !has_begun && word.eq_ignore_ascii_case("ply") => has_begun = true,
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, ..] if has_begun => {
                    encoding = Some(match name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::Binary { big_endian: false },
                        "binary_big_endian" => Encoding::Binary { big_endian: true },
                        _ => return Err(fault(format!("unknown format {}", quoted(name)))),
                    });
                }
                ["element", name, count] => {
                    let count = count
                        .parse()
                        .map_err(|_| fault(format!("{} is not a number of elements", quoted(count))))?;
                    elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
                }
                ["property", ref what @ ..] => {
                    let property = property(what)
                        .ok_or_else(|| fault(format!("{} is not a property", quoted(line.trim()))))?;
                    let element = elements
                        .last_mut()
                        .ok_or_else(|| fault("a property comes before the first element".to_owned()))?;
                    element.properties.push(property);
                }
                ["end_header"] => return Self::finish(encoding, elements, at, line_number),
                _ if !has_begun => {
                    return Err(fault("a PLY file starts with the line “ply”".to_owned()));
                }
                _ => return Err(fault(format!("unexpected {} in the header", quoted(line.trim())))),
            }
        }
        Err(Fault::whole("the header has no end (end_header)"))
    }

    fn finish(
        encoding: Option<Encoding>,
        elements: Vec<Element>,
        length: usize,
        lines: usize,
    ) -> Result<Self, Fault> {
        let encoding = encoding.ok_or_else(|| Fault::whole("its header has no format"))?;
        Ok(Self { encoding, elements, length, lines })
    }
}

/// A property from the words after `property`. Names may hold blanks: some
/// programs write them so.
fn property(words: &[&str]) -> Option<Property> {
    let (kind, name) = match words {
        ["list", count, item, name @ ..] => (Kind::List { count: scalar(count)?, item: scalar(item)? }, name),
        [kind, name @ ..] => (Kind::Scalar(scalar(kind)?), name),
        [] => return None,
    };
    (!name.is_empty()).then(|| Property { name: name.join(" ").to_ascii_lowercase(), kind })
}
