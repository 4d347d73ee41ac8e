//! Arrays in an `.npz` archive.

use std::borrow::Cow;
use std::io::{Cursor, Read};

use zip::ZipArchive;

use super::header::{Header, Text};
use crate::io::error::Fault;

/// Most bytes that an array may unpack to.
const LARGEST: u64 = 1 << 30;

/// An archive of arrays, whose members are unpacked when they are asked for.
pub(in crate::io) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
}

/// An array of numbers or texts, in C order.
#[derive(Debug)]
pub(in crate::io) struct Array {
    pub(in crate::io) shape: Vec<usize>,
    header: Header,
    data: Vec<u8>,
}

impl<'a> Archive<'a> {
    pub(in crate::io) fn new(bytes: &'a [u8]) -> Result<Self, Fault> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|e| {
            Fault::whole(format!("the archive is damaged ({e}); it may not have been written completely"))
        })?;
        Ok(Self { zip })
    }

    /// Names of all arrays, sorted.
    pub(in crate::io) fn names(&self) -> Vec<String> {
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

    /// The array of that name; `None` where there is none.
    pub(in crate::io) fn get(&mut self, name: &str) -> Result<Option<Array>, Fault> {
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
        let header = Header::parse_any(bytes).map_err(|fault| format!("can't be read: {}", fault.problem))?;
        if header.is_structured {
            return Err("has values of several types, which is not supported".to_owned());
        }
        if header.fortran_order {
            return Err("is in Fortran order; save it with np.ascontiguousarray".to_owned());
        }
        let data = &bytes[header.length..];
        let size = usize::try_from(header.size).ok();
        let shape = header.shape.iter().map(|&side| usize::try_from(side)).collect::<Result<Vec<_>, _>>();
        match (size.and_then(|size| data.get(..size)), shape) {
            (Some(data), Ok(shape)) => Ok(Self { shape, data: data.to_vec(), header }),
            _ => {
                let shape = &header.shape;
                Err(format!("should have shape {shape:?}, but is truncated at {} bytes", data.len()))
            }
        }
    }

    /// Numbers of the values from place `from` on, or what is wrong with them.
    pub(in crate::io) fn numbers(&self, from: usize, count: usize) -> Result<Vec<f64>, String> {
        let width = self.header.element;
        let bytes = from
            .checked_mul(width)
            .zip(from.checked_add(count).and_then(|end| end.checked_mul(width)))
            .and_then(|(start, end)| self.data.get(start..end))
            .ok_or_else(|| "is too short".to_owned())?;
        let column = self.header.columns.first().ok_or("contains strings instead of numbers")?;
        Ok(bytes.chunks_exact(width).map(|value| column.scalar.value(value, column.big_endian)).collect())
    }

    /// The text at a place; `None` where the array holds none.
    pub(in crate::io) fn text(&self, at: usize) -> Option<String> {
        let kind = self.header.text?;
        let value = self.data.chunks_exact(self.header.element).nth(at)?;
        let text = match kind {
            Text::Bytes => String::from_utf8_lossy(value).into_owned(),
            Text::Utf32 { big_endian } => {
                let code =
                    |c: &[u8; 4]| if big_endian { u32::from_be_bytes(*c) } else { u32::from_le_bytes(*c) };
                let character = |c| char::from_u32(code(c)).unwrap_or(char::REPLACEMENT_CHARACTER);
                value.as_chunks::<4>().0.iter().map(character).collect()
            }
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
