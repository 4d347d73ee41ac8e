//! The values in the body of a PLY file, in sequence.

use std::borrow::Cow;

use super::header::{Element, Kind};
use crate::io::error::Fault;
use crate::io::read::scalar::Scalar;
use crate::io::read::text::{counted, number, quoted};

/// A body that is read from front to back.
pub(super) trait Values {
    /// The largest number of such elements that the rest can hold, by their
    /// smallest size; `None` where an element takes no room.
    fn most(&self, element: &Element) -> Option<u64>;

    /// Begins the next element.
    fn start(&mut self, element: &Element) -> Result<(), Fault>;

    /// The value of a scalar. A list is appended nowhere or put into `list`,
    /// and its length returned.
    fn property(&mut self, kind: Kind, list: Option<&mut Vec<f64>>) -> Result<f64, Fault>;

    /// A fault at the present place.
    fn fault(&self, problem: String) -> Fault;

    /// Ends the last element and reports what was ignored.
    fn end(&mut self) -> Option<String>;
}

/// The length of a list, which may be a number of any type.
fn length(count: f64) -> Result<u64, String> {
    if count >= 0.0 && count.fract() == 0.0 {
        Ok(count as u64)
    } else {
        Err(format!("{count} is not a valid list length; expected a whole number"))
    }
}

/// Values parted by blanks, each element on a line of its own. Where there are
/// fewer lines than elements, they follow one another, whatever the lines.
#[derive(Debug)]
pub(super) struct AsciiValues<'a> {
    rest: &'a [u8],
    line_number: usize,
    line: Cow<'a, str>,
    /// Where in `line` the next value is looked for.
    at: usize,
    ignores_lines: bool,
    /// Lines that hold more than their element, and the first of them.
    surplus: (usize, usize),
}

impl<'a> AsciiValues<'a> {
    /// For this many elements.
    pub(super) fn new(rest: &'a [u8], header_lines: usize, elements: u64) -> Self {
        let lines = rest.split(|b| matches!(b, b'\n' | b'\r')).filter(|line| !line.trim_ascii().is_empty());
        let ignores_lines = (lines.count() as u64) < elements;
        Self { rest, line_number: header_lines, line: "".into(), at: 0, ignores_lines, surplus: (0, 0) }
    }

    fn is_line_done(&self) -> bool {
        self.line[self.at..].trim_start().is_empty()
    }

    /// Advances to the next non-empty line; `false` at the end.
    fn next_line(&mut self) -> bool {
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
            self.line = String::from_utf8_lossy(&self.rest[..end]);
            self.at = 0;
            let after = &self.rest[end..];
            self.rest = after.strip_prefix(b"\r\n").unwrap_or(after.get(1..).unwrap_or_default());
            self.line_number += 1;
            if !self.is_line_done() {
                return true;
            }
        }
        false
    }

    /// Counts the line among those with a surplus, if something is left on it.
    fn finish_line(&mut self) {
        if !self.is_line_done() {
            let (lines, first) = self.surplus;
            self.surplus = (lines + 1, if lines == 0 { self.line_number } else { first });
            self.at = self.line.len();
        }
    }

    fn token(&mut self) -> Option<&str> {
        if self.ignores_lines && self.is_line_done() {
            self.next_line();
        }
        let rest = &self.line[self.at..];
        let rest = rest.trim_start();
        let start = self.line.len() - rest.len();
        let length = rest.find(char::is_whitespace).unwrap_or(rest.len());
        self.at = start + length;
        (length > 0).then(|| &self.line[start..start + length])
    }

    fn value(&mut self) -> Result<f64, Fault> {
        let ignores_lines = self.ignores_lines;
        let Some(token) = self.token() else {
            let problem = match ignores_lines {
                true => "the file ends in the middle of its data; it may be truncated",
                false => "the line has fewer values than the header declares",
            };
            return Err(self.fault(problem.to_owned()));
        };
        let value = number(token).ok_or_else(|| format!("{} is not a number", quoted(token)));
        value.map_err(|problem| self.fault(problem))
    }
}

impl Values for AsciiValues<'_> {
    fn most(&self, element: &Element) -> Option<u64> {
        // A digit and what parts it from the next.
        let size = 2 * element.properties.len() as u64;
        let left = self.line.len() - self.at + self.rest.len();
        (size > 0).then(|| (left as u64 + 1) / size)
    }

    fn start(&mut self, element: &Element) -> Result<(), Fault> {
        if self.ignores_lines && !self.is_line_done() {
            return Ok(());
        }
        self.finish_line();
        if self.next_line() {
            return Ok(());
        }
        Err(self.fault(format!(
            "the file ends before the last of {} elements “{}”; it may be truncated",
            element.count, element.name
        )))
    }

    fn property(&mut self, kind: Kind, list: Option<&mut Vec<f64>>) -> Result<f64, Fault> {
        match kind {
            Kind::Scalar(_) => self.value(),
            Kind::List { .. } => {
                let count = self.value()?;
                let length = length(count).map_err(|problem| self.fault(problem))?;
                let mut unused = Vec::new();
                let list = list.unwrap_or(&mut unused);
                list.clear();
                // A line that is too short ends this, whatever the count.
                for _ in 0..length {
                    list.push(self.value()?);
                }
                Ok(count)
            }
        }
    }

    fn end(&mut self) -> Option<String> {
        self.finish_line();
        let (lines, first) = self.surplus;
        let holds = counted(lines, "line has", "lines have");
        let note =
            format!("{holds} more values than the header declares, from line {first} on; they were ignored");
        (lines > 0).then_some(note)
    }

    fn fault(&self, problem: String) -> Fault {
        Fault::at_line(self.line_number, problem)
    }
}

/// Values without gaps, of the size that the header gives them.
#[derive(Debug)]
pub(super) struct BinaryValues<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl<'a> BinaryValues<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize, big_endian: bool) -> Self {
        Self { bytes, at, big_endian }
    }

    fn take(&mut self, size: usize) -> Result<&'a [u8], Fault> {
        let taken = self.at.checked_add(size).and_then(|end| self.bytes.get(self.at..end));
        match taken {
            Some(bytes) => {
                self.at += size;
                Ok(bytes)
            }
            None => Err(Fault::at_byte(
                self.bytes.len(),
                "the file ends in the middle of its data; it may be truncated",
            )),
        }
    }

    #[inline]
    fn scalar(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        let big_endian = self.big_endian;
        self.take(scalar.size()).map(|bytes| scalar.value(bytes, big_endian))
    }
}

impl Values for BinaryValues<'_> {
    fn most(&self, element: &Element) -> Option<u64> {
        let smallest = |kind| match kind {
            Kind::Scalar(scalar) => scalar.size(),
            Kind::List { count, .. } => count.size(),
        };
        let size: usize = element.properties.iter().map(|p| smallest(p.kind)).sum();
        (size > 0).then(|| ((self.bytes.len() - self.at) / size) as u64)
    }

    fn start(&mut self, _: &Element) -> Result<(), Fault> {
        Ok(())
    }

    fn end(&mut self) -> Option<String> {
        None
    }

    fn property(&mut self, kind: Kind, list: Option<&mut Vec<f64>>) -> Result<f64, Fault> {
        match kind {
            Kind::Scalar(scalar) => self.scalar(scalar),
            Kind::List { count, item } => {
                let at = self.at;
                let count = self.scalar(count)?;
                let length = length(count).map_err(|problem| Fault::at_byte(at, problem))?;
                match list {
                    Some(list) => {
                        list.clear();
                        for _ in 0..length {
                            list.push(self.scalar(item)?);
                        }
                    }
                    None => {
                        self.take((length as usize).saturating_mul(item.size()))?;
                    }
                }
                Ok(count)
            }
        }
    }

    fn fault(&self, problem: String) -> Fault {
        Fault::at_byte(self.at, problem)
    }
}
