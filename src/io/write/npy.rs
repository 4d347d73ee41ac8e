//! NumPy arrays and archives of them.

use std::io::{self, Seek, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// An archive of arrays, `.npz`, as `np.load` reads it without pickle.
pub(super) struct Npz<W: Write + Seek> {
    zip: ZipWriter<W>,
}

impl<W: Write + Seek> Npz<W> {
    pub(super) fn new(w: W) -> Self {
        Self { zip: ZipWriter::new(w) }
    }

    /// Adds an array of `N`-byte values, in C order. There must be as many as
    /// the shape says.
    pub(super) fn add<const N: usize>(
        &mut self,
        name: &str,
        descr: &str,
        shape: &[usize],
        values: impl IntoIterator<Item = [u8; N]>,
    ) -> io::Result<()> {
        // No time of day: the same result gives the same bytes.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(3))
            .last_modified_time(zip::DateTime::default())
            .large_file(shape.iter().product::<usize>() * N > 1 << 30);
        self.zip.start_file(format!("{name}.npy"), options).map_err(io::Error::other)?;
        self.zip.write_all(&header(descr, shape))?;
        let mut buffer = Vec::with_capacity(1 << 16);
        for value in values {
            buffer.extend_from_slice(&value);
            if buffer.len() + N > 1 << 16 {
                self.zip.write_all(&buffer)?;
                buffer.clear();
            }
        }
        self.zip.write_all(&buffer)
    }

    pub(super) fn doubles<'a>(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl IntoIterator<Item = &'a f64>,
    ) -> io::Result<()> {
        self.add(name, "<f8", shape, values.into_iter().map(|v| v.to_le_bytes()))
    }

    /// Adds an array of one text.
    pub(super) fn text(&mut self, name: &str, text: &str) -> io::Result<()> {
        let characters: Vec<char> = text.chars().collect();
        // NumPy has no texts of no length in files.
        let length = characters.len().max(1);
        let padded = characters.into_iter().chain(std::iter::repeat('\0')).take(length);
        self.add(name, &format!("<U{length}"), &[1], padded.map(|c| u32::from(c).to_le_bytes()))
    }

    pub(super) fn finish(self) -> io::Result<()> {
        self.zip.finish().map(drop).map_err(io::Error::other)
    }
}

/// The head of a `.npy` file of version 1.
fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let sizes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({sizes}), }}");
    // Magic, version, length, text, blanks and a newline fill multiples of 64.
    let filled = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((filled as u16).to_le_bytes());
    bytes.extend(format!("{text:<width$}\n", width = filled - 1).into_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_aligned_and_end_with_a_newline() {
        for shape in [&[1][..], &[1, 5500, 30], &[0, 3], &[1_000_000_000, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3]] {
            let head = header("<f8", shape);
            assert_eq!(head.len() % 64, 0);
            assert_eq!(head.last(), Some(&b'\n'));
            let length = usize::from(u16::from_le_bytes([head[8], head[9]]));
            assert_eq!(head.len(), 10 + length);
        }
        assert!(String::from_utf8_lossy(&header("<i4", &[7])).contains("'shape': (7, ), }"));
    }
}
