//! The header of a NumPy array: a Python dictionary of its type, order and shape.

use crate::io::error::Fault;
use crate::io::read::columns::names_of_parts;
use crate::io::read::scalar::Scalar;
use crate::io::read::text::quoted;

pub(in crate::io) const MAGIC: &[u8] = b"\x93NUMPY";
/// A longer header is no header: NumPy itself refuses more than 10000 bytes.
pub(in crate::io) const LONGEST: usize = 1 << 16;
/// Lists in lists in lists, at most.
const DEEPEST: usize = 8;
/// Numbers that an element may have.
const MOST_COLUMNS: usize = 1 << 12;

/// A number of an element.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::io) struct Column {
    /// In lower case; empty where an element is one number.
    pub(in crate::io) name: String,
    pub(in crate::io) scalar: Scalar,
    pub(in crate::io) big_endian: bool,
    pub(in crate::io) offset: usize,
}

#[derive(Debug, Clone)]
pub(in crate::io) struct Header {
    /// As the file writes it.
    pub(in crate::io) type_name: String,
    pub(in crate::io) columns: Vec<Column>,
    /// Whether elements have names for their parts.
    pub(in crate::io) is_structured: bool,
    /// Where an element is a text: of characters of four bytes, or of one.
    pub(super) text: Option<Text>,
    /// Bytes of an element.
    pub(in crate::io) element: usize,
    pub(in crate::io) fortran_order: bool,
    pub(in crate::io) shape: Vec<u64>,
    /// Bytes of the whole array, and where they begin.
    pub(in crate::io) size: u64,
    pub(in crate::io) length: usize,
}

/// How the characters of a text are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Text {
    Bytes,
    Utf32 { big_endian: bool },
}

impl Text {
    /// Longest text, in characters.
    const LONGEST: usize = 4096;

    /// What a type says, with the bytes of a text.
    fn of(code: &str) -> Option<(Self, usize)> {
        let big_endian = code.starts_with('>');
        let kind = code.trim_start_matches(['<', '>', '=', '|']);
        let length = kind.get(1..)?.parse().ok().filter(|n| (1..=Self::LONGEST).contains(n))?;
        match kind.as_bytes()[0] {
            b'S' => Some((Self::Bytes, length)),
            b'U' => Some((Self::Utf32 { big_endian }, 4 * length)),
            _ => None,
        }
    }
}

impl Header {
    /// From the first bytes of an array of numbers, of which there may be more.
    pub(in crate::io) fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        Self::of(bytes, |_| None)
    }

    /// The same of an array of numbers or of texts.
    pub(super) fn parse_any(bytes: &[u8]) -> Result<Self, Fault> {
        Self::of(bytes, Text::of)
    }

    /// `text` tells texts, and how many bytes each has, by their type.
    fn of(bytes: &[u8], text: fn(&str) -> Option<(Text, usize)>) -> Result<Self, Fault> {
        let fault = |at: usize, problem: &str| Fault::at_byte(at, problem);
        if !bytes.starts_with(MAGIC) {
            return Err(fault(0, "a NumPy array starts with “\\x93NUMPY”"));
        }
        let (start, length) = match bytes[MAGIC.len()..] {
            [1, _, a, b, ..] => (10, usize::from(u16::from_le_bytes([a, b]))),
            [2 | 3, _, a, b, c, d, ..] => (12, u32::from_le_bytes([a, b, c, d]) as usize),
            [version, _, ..] if version > 3 || version == 0 => {
                let problem = format!("unknown NumPy format version {version}; save it as version 1");
                return Err(fault(6, &problem));
            }
            _ => return Err(fault(bytes.len(), "the header is truncated")),
        };
        if length > LONGEST {
            return Err(fault(8, &format!("the header has {length} bytes; the limit is {LONGEST}")));
        }
        let literal = bytes.get(start..start + length).ok_or_else(|| {
            fault(8, &format!("a header of {length} bytes is declared, but the file is shorter"))
        })?;
        let mut parser = Parser { text: literal, at: 0 };
        let Some(Value::Dict(entries)) = parser.value(0) else {
            return Err(fault(start + parser.at, "the header is not a valid dictionary"));
        };
        let entry = |key: &str| {
            let value = entries.iter().find(|(k, _)| k == key).map(|(_, v)| v);
            value.ok_or_else(|| fault(start, &format!("the header lacks “{key}”")))
        };
        let Value::Bool(fortran_order) = *entry("fortran_order")? else {
            return Err(fault(start, "“fortran_order” is neither True nor False"));
        };
        let Value::List(sides) = entry("shape")? else {
            return Err(fault(start, "the shape is not a tuple"));
        };
        let side = |v: &Value| if let Value::Int(n) = v { Some(*n) } else { None };
        let shape: Option<Vec<u64>> = sides.iter().map(side).collect();
        let shape =
            shape.ok_or_else(|| fault(start, "the shape contains something other than whole numbers"))?;
        let mut layout = Layout::default();
        let descr = entry("descr")?;
        let text = if let Value::Text(code) = descr { text(code) } else { None };
        match text {
            Some((_, size)) => layout.size = size,
            None => layout.add("", descr, 0).map_err(|problem| fault(start, &problem))?,
        }
        let elements = shape.iter().try_fold(1u64, |product, n| product.checked_mul(*n));
        let size = elements.and_then(|n| n.checked_mul(layout.size as u64)).ok_or_else(|| {
            fault(
                start,
                &format!("an array of {} is declared, more than any file can contain", shown(&shape)),
            )
        })?;
        Ok(Self {
            type_name: if let Value::Text(name) = descr { name.clone() } else { "structured".to_owned() },
            columns: layout.columns,
            is_structured: matches!(descr, Value::List(_)),
            text: text.map(|(kind, _)| kind),
            element: layout.size,
            fortran_order,
            shape,
            size,
            length: start + length,
        })
    }
}

/// "1000×3"
pub(in crate::io) fn shown(shape: &[u64]) -> String {
    if shape.is_empty() {
        return "no dimension".to_owned();
    }
    shape.iter().map(u64::to_string).collect::<Vec<_>>().join("×")
}

/// The numbers of an element, one after another.
#[derive(Debug, Default)]
struct Layout {
    columns: Vec<Column>,
    size: usize,
}

impl Layout {
    fn add(&mut self, name: &str, kind: &Value, depth: usize) -> Result<(), String> {
        match kind {
            Value::Text(code) => self.number(name, code, 1),
            // [('x', '<f4'), ('normal', '<f4', (3,)), …]
            Value::List(fields) if depth == 0 => {
                for field in fields {
                    let Value::List(parts) = field else { return Err("a field is not a tuple".to_owned()) };
                    // A title may stand before the name.
                    let name = match parts.first() {
                        Some(Value::Text(name)) => name,
                        Some(Value::List(both)) => match both.last() {
                            Some(Value::Text(name)) => name,
                            _ => return Err("a field has no name".to_owned()),
                        },
                        _ => return Err("a field has no name".to_owned()),
                    };
                    let count = match parts.get(2) {
                        None => 1,
                        Some(Value::Int(n)) => *n,
                        Some(Value::List(sides)) => sides
                            .iter()
                            .try_fold(1u64, |product, v| match v {
                                Value::Int(n) => product.checked_mul(*n),
                                _ => None,
                            })
                            .ok_or("the shape of a field cannot be parsed")?,
                        Some(_) => return Err("the shape of a field cannot be parsed".to_owned()),
                    };
                    match parts.get(1) {
                        Some(Value::Text(code)) => self.number(&name.to_lowercase(), code, count)?,
                        _ => {
                            return Err(format!(
                                "the field {} is a nested record, which is not supported",
                                quoted(name)
                            ));
                        }
                    }
                }
                Ok(())
            }
            _ => Err("the number type cannot be parsed".to_owned()),
        }
    }

    fn number(&mut self, name: &str, code: &str, count: u64) -> Result<(), String> {
        let (order, kind) = match code.as_bytes() {
            [order @ (b'<' | b'>' | b'=' | b'|'), ..] => (*order, &code[1..]),
            _ => (b'=', code),
        };
        let digits = kind.trim_start_matches(|c: char| !c.is_ascii_digit());
        let letter = &kind[..kind.len() - digits.len()];
        let scalar = match kind {
            "i1" => Scalar::I8,
            "u1" | "b1" | "?" => Scalar::U8,
            "i2" => Scalar::I16,
            "u2" => Scalar::U16,
            "i4" => Scalar::I32,
            "u4" => Scalar::U32,
            "i8" => Scalar::I64,
            "u8" => Scalar::U64,
            "f2" => Scalar::F16,
            "f4" => Scalar::F32,
            "f8" => Scalar::F64,
            _ => {
                // What stands between the numbers of a record is stepped over.
                let width = match letter {
                    "V" | "S" | "a" => 1,
                    "U" => 4,
                    "M" | "m" | "c" if !name.is_empty() => 1,
                    "O" => {
                        return Err("it contains Python objects, which are not loaded because they could \
                             run any code; save an array of numbers"
                            .to_owned());
                    }
                    _ => {
                        return Err(format!(
                            "it contains {}, not integers or floating-point numbers",
                            quoted(code)
                        ));
                    }
                };
                let digits: String = digits.chars().take_while(char::is_ascii_digit).collect();
                let size = digits.parse::<usize>().ok().and_then(|n| n.checked_mul(width));
                let size = size.zip(usize::try_from(count).ok()).and_then(|(a, b)| a.checked_mul(b));
                let end = size.and_then(|n| self.size.checked_add(n)).filter(|_| !name.is_empty());
                self.size = end.ok_or_else(|| format!("it contains {}, not numbers", quoted(code)))?;
                return Ok(());
            }
        };
        let count =
            usize::try_from(count).ok().filter(|n| self.columns.len().saturating_add(*n) <= MOST_COLUMNS);
        let count = count.ok_or_else(|| format!("an element has more than {MOST_COLUMNS} numbers"))?;
        for name in names_of_parts(name, count.max(1)).into_iter().take(count) {
            self.columns.push(Column { name, scalar, big_endian: order == b'>', offset: self.size });
            self.size = self.size.checked_add(scalar.size()).ok_or("an element is too large")?;
        }
        Ok(())
    }
}

/// What of Python's literals stands in such headers.
#[derive(Debug, Clone, PartialEq)]
enum Value {
    Text(String),
    Int(u64),
    Bool(bool),
    /// A list or a tuple.
    List(Vec<Value>),
    Dict(Vec<(String, Value)>),
}

struct Parser<'a> {
    text: &'a [u8],
    at: usize,
}

impl Parser<'_> {
    fn peek(&mut self) -> Option<u8> {
        while self.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    /// Takes the next character if it is that one.
    fn takes(&mut self, wanted: u8) -> bool {
        let is_it = self.peek() == Some(wanted);
        self.at += usize::from(is_it);
        is_it
    }

    fn value(&mut self, depth: usize) -> Option<Value> {
        if depth > DEEPEST {
            return None;
        }
        match self.peek()? {
            quote @ (b'\'' | b'"') => {
                let rest = &self.text[self.at + 1..];
                let length = rest.iter().position(|b| *b == quote)?;
                self.at += length + 2;
                Some(Value::Text(String::from_utf8_lossy(&rest[..length]).into_owned()))
            }
            b'{' => {
                self.at += 1;
                let mut entries = Vec::new();
                while !self.takes(b'}') {
                    let Value::Text(key) = self.value(depth + 1)? else { return None };
                    if !self.takes(b':') {
                        return None;
                    }
                    entries.push((key, self.value(depth + 1)?));
                    if !self.takes(b',') && self.peek()? != b'}' {
                        return None;
                    }
                }
                Some(Value::Dict(entries))
            }
            open @ (b'(' | b'[') => {
                self.at += 1;
                let close = if open == b'(' { b')' } else { b']' };
                let mut entries = Vec::new();
                while !self.takes(close) {
                    entries.push(self.value(depth + 1)?);
                    if !self.takes(b',') && self.peek()? != close {
                        return None;
                    }
                }
                Some(Value::List(entries))
            }
            b'0'..=b'9' => {
                let mut value = 0u64;
                while let Some(digit) = self.text.get(self.at).filter(|b| b.is_ascii_digit()) {
                    value = value.checked_mul(10)?.checked_add(u64::from(digit - b'0'))?;
                    self.at += 1;
                }
                // Python 2 wrote long numbers so.
                self.at += usize::from(self.text.get(self.at) == Some(&b'L'));
                Some(Value::Int(value))
            }
            _ => {
                for (word, value) in [("True", true), ("False", false)] {
                    if self.text[self.at..].starts_with(word.as_bytes()) {
                        self.at += word.len();
                        return Some(Value::Bool(value));
                    }
                }
                None
            }
        }
    }
}
