//! Arrays in an `.npz` archive.

use std::borrow::Cow;
use std::io::{Cursor, Read};

use zip::ZipArchive;

use crate::io::error::Fault;
use crate::io::read::scalar::Scalar;

/// Most bytes that an array may unpack to.
const LARGEST: u64 = 1 << 30;

/// An archive of arrays, whose members are unpacked when they are asked for.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
}

/// An array of any type, in C order.
#[derive(Debug)]
pub(super) struct Array {
    pub(super) shape: Vec<usize>,
    kind: u8,
    /// Bytes a value.
    width: usize,
    is_big_endian: bool,
    data: Vec<u8>,
}

impl<'a> Archive<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, Fault> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|e| {
            Fault::whole(format!("the archive is damaged ({e}); it may not have been written completely"))
        })?;
        Ok(Self { zip })
    }

    /// Names of all arrays, sorted.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.members().map(|n| n.trim_end_matches(".npy").to_owned()).collect();
        names.sort();
        names
    }

    /// Members whose names can be read.
    fn members(&self) -> impl Iterator<Item = Cow<'_, str>> {
        self.zip.file_names().filter_map(Result::ok)
    }

    fn has(&self, name: &str) -> bool {
        self.members().any(|n| n.strip_suffix(".npy") == Some(name))
    }

    /// The array with this name; `None` if it does not exist.
    pub(super) fn get(&mut self, name: &str) -> Result<Option<Array>, Fault> {
        if !self.has(name) {
            return Ok(None);
        }
        let wrong = |problem: String| Fault::whole(format!("the array \"{name}\" {problem}"));
        let member = self
            .zip
            .by_name(&format!("{name}.npy"))
            .map_err(|e| wrong(format!("cannot be decompressed: {e}")))?;
        let mut bytes = Vec::new();
        member
            .take(LARGEST + 1)
            .read_to_end(&mut bytes)
            .map_err(|e| wrong(format!("cannot be decompressed: {e}")))?;
        if bytes.len() as u64 > LARGEST {
            return Err(wrong(format!("decompresses to more than {LARGEST} bytes")));
        }
        Array::parse(&bytes).map(Some).map_err(wrong)
    }
}

impl Array {
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let damaged = || "has no valid NumPy header".to_owned();
        let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or_else(damaged)?;
        let (length, from) = match rest {
            [1, _, a, b, ..] => (usize::from(u16::from_le_bytes([*a, *b])), 4),
            [2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, 6),
            _ => return Err(damaged()),
        };
        let head = rest.get(from..).and_then(|r| r.get(..length)).ok_or_else(damaged)?;
        let head = String::from_utf8_lossy(head);
        let data = &rest[from + length..];

        let after = |key: &str| head.split_once(&format!("'{key}':")).map(|(_, after)| after.trim_start());
        let descr = after("descr").and_then(|t| t.strip_prefix('\'')?.split('\'').next());
        let descr = descr.ok_or("has values of several types, which is not supported")?;
        if after("fortran_order").is_none_or(|t| !t.starts_with("False")) {
            return Err("is in Fortran order; save it with np.ascontiguousarray".to_owned());
        }
        let sizes =
            after("shape").and_then(|t| t.strip_prefix('(')?.split(')').next()).ok_or_else(damaged)?;
        let shape = sizes
            .split(',')
            .map(str::trim)
            .filter(|size| !size.is_empty())
            .map(|size| size.parse::<usize>().map_err(|_| damaged()))
            .collect::<Result<Vec<_>, _>>()?;

        let mut characters = descr.chars();
        let (order, kind) = (characters.next(), characters.next());
        let size = characters.as_str().parse::<usize>().ok();
        let (Some(order), Some(kind), Some(size)) = (order, kind, size) else {
            return Err(format!("is of type {descr}, which is not supported"));
        };
        let width = match (kind, size) {
            ('f', 2 | 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1) => size,
            ('S', 1..=4096) => size,
            ('U', 1..=4096) => 4 * size,
            _ => {
                return Err(format!("is of type {descr}, which is not supported; save it as numbers"));
            }
        };
        let wanted = shape.iter().try_fold(width, |n, &size| n.checked_mul(size));
        if wanted.is_none_or(|n| n > data.len()) {
            return Err(format!("should have shape {shape:?}, but is truncated at {} bytes", data.len()));
        }
        let data = data[..wanted.unwrap_or(0)].to_vec();
        Ok(Self { shape, kind: kind as u8, width, is_big_endian: order == '>', data })
    }

    /// Numbers of the values from place `from` on, or what is wrong with them.
    pub(super) fn numbers(&self, from: usize, count: usize) -> Result<Vec<f64>, String> {
        let bytes = from
            .checked_mul(self.width)
            .zip(from.checked_add(count).and_then(|end| end.checked_mul(self.width)))
            .and_then(|(start, end)| self.data.get(start..end))
            .ok_or_else(|| "is too short".to_owned())?;
        let scalar = self.scalar().ok_or("contains strings instead of numbers")?;
        Ok(bytes.chunks_exact(self.width).map(|value| scalar.value(value, self.is_big_endian)).collect())
    }

    /// How the numbers are stored; `None` for texts.
    fn scalar(&self) -> Option<Scalar> {
        Some(match (self.kind, self.width) {
            (b'f', 2) => Scalar::F16,
            (b'f', 4) => Scalar::F32,
            (b'f', 8) => Scalar::F64,
            (b'i', 1) => Scalar::I8,
            (b'i', 2) => Scalar::I16,
            (b'i', 4) => Scalar::I32,
            (b'i', 8) => Scalar::I64,
            (b'u' | b'b', 1) => Scalar::U8,
            (b'u', 2) => Scalar::U16,
            (b'u', 4) => Scalar::U32,
            (b'u', 8) => Scalar::U64,
            _ => return None,
        })
    }

    /// The string at an index; `None` if the array contains no strings.
    pub(super) fn text(&self, at: usize) -> Option<String> {
        let value = self.data.chunks_exact(self.width).nth(at)?;
        let text: String = match self.kind {
            b'S' => String::from_utf8_lossy(value).into_owned(),
            b'U' => value
                .chunks_exact(4)
                .map(|c| {
                    let c = [c[0], c[1], c[2], c[3]];
                    let code = if self.is_big_endian { u32::from_be_bytes(c) } else { u32::from_le_bytes(c) };
                    char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER)
                })
                .collect(),
            _ => return None,
        };
        Some(text.trim_end_matches('\0').to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let head = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((head.len() as u16).to_le_bytes());
        bytes.extend(head.bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn numbers_of_all_widths_and_byte_orders() {
        for (descr, data, expected) in [
            ("<f2", &[0x00, 0x3c, 0x00, 0xc0, 0x01, 0x00][..], vec![1.0, -2.0, 2f64.powi(-24)]),
            (">f4", &[0x3f, 0x80, 0, 0], vec![1.0]),
            ("<i2", &[0xff, 0xff], vec![-1.0]),
            (">u2", &[1, 0], vec![256.0]),
            ("|b1", &[1, 0], vec![1.0, 0.0]),
            ("|i1", &[0x80], vec![-128.0]),
        ] {
            let array = Array::parse(&npy(descr, &format!("({},)", expected.len()), data)).unwrap();
            assert_eq!(array.numbers(0, expected.len()).unwrap(), expected, "{descr}");
            assert!(array.numbers(1, expected.len()).is_err());
            assert!(array.numbers(usize::MAX, 2).is_err());
        }
    }

    #[test]
    fn heads_that_claim_too_much_are_refused() {
        for (descr, shape) in [
            ("<f8", "(2,)"),
            ("<f8", "(18446744073709551615, 18446744073709551615)"),
            ("<f8", "(-1,)"),
            ("|O", "(1,)"),
            ("<c16", "(0,)"),
            ("", "()"),
        ] {
            assert!(Array::parse(&npy(descr, shape, &[0; 8])).is_err(), "{descr} {shape}");
        }
        let whole = npy("<f8", "(1,)", &[0; 8]);
        assert!(Array::parse(&whole).is_ok());
        for end in 0..whole.len() {
            assert!(Array::parse(&whole[..end]).is_err());
        }
    }
}
