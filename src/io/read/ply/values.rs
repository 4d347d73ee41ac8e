//! The numbers of a PLY file's body, one after another.

use super::header::{Element, Kind};
use crate::io::error::Fault;
use crate::io::read::scalar::Scalar;
use crate::io::read::text::{number, quoted};

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
}

/// One element a line, values parted by blanks.
#[derive(Debug)]
pub(super) struct AsciiValues<'a> {
    rest: &'a [u8],
    line_number: usize,
    line: std::borrow::Cow<'a, str>,
    /// Where in `line` the next value is looked for.
    at: usize,
}

impl<'a> AsciiValues<'a> {
    pub(super) fn new(rest: &'a [u8], header_lines: usize) -> Self {
        Self { rest, line_number: header_lines, line: "".into(), at: 0 }
    }

    fn token(&mut self) -> Option<&str> {
        let rest = &self.line[self.at..];
        let rest = rest.trim_start();
        let start = self.line.len() - rest.len();
        let length = rest.find(char::is_whitespace).unwrap_or(rest.len());
        self.at = start + length;
        (length > 0).then(|| &self.line[start..start + length])
    }

    fn value(&mut self) -> Result<f64, Fault> {
        let line = self.line_number;
        let token = self
            .token()
            .ok_or_else(|| Fault::at_line(line, "the line holds fewer values than the header announces"))?;
        number(token).ok_or_else(|| Fault::at_line(line, format!("{} is not a number", quoted(token))))
    }
}

impl Values for AsciiValues<'_> {
    fn most(&self, element: &Element) -> Option<u64> {
        // A digit and what parts it from the next.
        let size = 2 * element.properties.len() as u64;
        (size > 0).then(|| (self.rest.len() as u64 + 1) / size)
    }

    fn start(&mut self, element: &Element) -> Result<(), Fault> {
        if !self.line[self.at..].trim().is_empty() {
            return Err(self.fault("the line holds more values than the header announces".to_owned()));
        }
        loop {
            if self.rest.is_empty() {
                return Err(self.fault(format!(
                    "the file ends before the last of {} elements “{}”; it may have been cut short",
                    element.count, element.name
                )));
            }
            let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
            self.line = String::from_utf8_lossy(&self.rest[..end]);
            self.at = 0;
            let after = &self.rest[end..];
            self.rest = after.strip_prefix(b"\r\n").unwrap_or(after.get(1..).unwrap_or_default());
            self.line_number += 1;
            if !self.line.trim().is_empty() {
                return Ok(());
            }
        }
    }

    fn property(&mut self, kind: Kind, list: Option<&mut Vec<f64>>) -> Result<f64, Fault> {
        match kind {
            Kind::Scalar(_) => self.value(),
            Kind::List { .. } => {
                let count = self.value()?;
                if !(count >= 0.0 && count.fract() == 0.0) {
                    return Err(self.fault(format!("{count} is not the length of a list")));
                }
                let mut unused = Vec::new();
                let list = list.unwrap_or(&mut unused);
                list.clear();
                // A line that is too short ends this, whatever the count.
                for _ in 0..count as u64 {
                    list.push(self.value()?);
                }
                Ok(count)
            }
        }
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
                "the file ends in the middle of its data; it may have been cut short",
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

    fn property(&mut self, kind: Kind, list: Option<&mut Vec<f64>>) -> Result<f64, Fault> {
        match kind {
            Kind::Scalar(scalar) => self.scalar(scalar),
            Kind::List { count, item } => {
                let at = self.at;
                let count = self.scalar(count)?;
                if count < 0.0 {
                    return Err(Fault::at_byte(at, format!("{count} is not the length of a list")));
                }
                match list {
                    Some(list) => {
                        list.clear();
                        for _ in 0..count as u64 {
                            list.push(self.scalar(item)?);
                        }
                    }
                    None => {
                        self.take((count as usize).saturating_mul(item.size()))?;
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
