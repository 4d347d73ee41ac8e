//! Checks of a LAS header before the decoder is used.

use crate::io::error::Fault;

/// Bytes of the header of the oldest version.
const SHORTEST: usize = 227;
/// Least bytes of a point, by its format.
const RECORDS: [u16; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];
/// Bytes of a variable length record before its content.
const VLR: usize = 54;

#[derive(Debug)]
pub(super) struct Header {
    /// Bytes of the header, up to the variable length records.
    size: usize,
    records: u32,
    /// Where the points begin.
    pub(super) offset: usize,
    pub(super) is_compressed: bool,
    /// Bytes of an unpacked point.
    pub(super) record: u16,
    pub(super) points: u64,
    /// Where their number stands.
    pub(super) count_at: usize,
    has_appendix: bool,
}

/// Little-endian numbers at a place in the file.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn get<const N: usize>(self, at: usize) -> Result<[u8; N], Fault> {
        at.checked_add(N)
            .and_then(|end| self.0.get(at..end))
            .and_then(|bytes| bytes.try_into().ok())
            .ok_or_else(|| {
                Fault::at_byte(self.0.len(), "the file ends here, but more data is declared; it is truncated")
            })
    }

    fn u16(self, at: usize) -> Result<u16, Fault> {
        self.get(at).map(u16::from_le_bytes)
    }

    fn u32(self, at: usize) -> Result<u32, Fault> {
        self.get(at).map(u32::from_le_bytes)
    }

    fn u64(self, at: usize) -> Result<u64, Fault> {
        self.get(at).map(u64::from_le_bytes)
    }
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        let file = Bytes(bytes);
        let [major, minor] = file.get(24)?;
        if major != 1 || minor > 4 {
            let problem = format!("it is LAS {major}.{minor}, but only 1.0 to 1.4 are supported; convert it");
            return Err(Fault::at_byte(24, problem));
        }
        let size = usize::from(file.u16(94)?);
        let offset = file.u32(96)? as usize;
        let records = file.u32(100)?;
        let least = if minor == 4 { 375 } else { SHORTEST };
        if size < least || size > bytes.len() {
            let problem = format!(
                "the header declares {size} bytes; it needs {least}, and the file has {}",
                bytes.len()
            );
            return Err(Fault::at_byte(94, problem));
        }
        if offset < size || offset >= bytes.len() {
            let problem = format!(
                "the points should start at byte {offset}, but the file has {} bytes; it may be truncated",
                bytes.len()
            );
            return Err(Fault::at_byte(96, problem));
        }
        if u64::from(records) * VLR as u64 > (offset - size) as u64 {
            let problem =
                format!("{records} records are declared before the points, but there is no room for them");
            return Err(Fault::at_byte(100, problem));
        }
        let [format] = file.get(104)?;
        let record = file.u16(105)?;
        let needed = RECORDS.get(usize::from(format & 0x3f));
        let Some(needed) = needed else {
            return Err(Fault::at_byte(104, format!("unknown point format {}; convert it", format & 0x3f)));
        };
        if record < *needed {
            let problem = format!("a point of format {} needs {needed} bytes, not {record}", format & 0x3f);
            return Err(Fault::at_byte(105, problem));
        }
        let legacy = u64::from(file.u32(107)?);
        let (points, count_at) =
            if legacy == 0 && minor == 4 { (file.u64(247)?, 247) } else { (legacy, 107) };
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            let at = 131 + 8 * i;
            let scale = f64::from_le_bytes(file.get(at)?);
            let origin = f64::from_le_bytes(file.get(at + 24)?);
            if !(scale.is_finite() && scale != 0.0 && origin.is_finite()) {
                let problem =
                    format!("{axis} has the scale {scale} and the offset {origin}; export the scan again");
                return Err(Fault::at_byte(at, problem));
            }
        }
        let is_compressed = format & 0xc0 != 0;
        Ok(Self { size, records, offset, is_compressed, record, points, count_at, has_appendix: minor == 4 })
    }

    /// The file without the records after its points, whose sizes may be any.
    pub(super) fn without_appendix(&self, bytes: &[u8]) -> Vec<u8> {
        let mut source = bytes.to_vec();
        if self.has_appendix {
            source[235..247].fill(0);
        }
        source
    }

    /// Checks the sizes that the compressed data claim.
    pub(super) fn check_compression(&self, bytes: &[u8]) -> Result<(), Fault> {
        let file = Bytes(bytes);
        let about = self.compression(file)?;
        let fault = |at: usize, problem: String| Err(Fault::at_byte(at, problem));
        let compressor = file.u16(about)?;
        let number_of_items = file.u16(about + 32)?;
        if !(1..=3).contains(&compressor) || number_of_items == 0 || number_of_items > 32 {
            return fault(about, "unknown compression; convert the file with LAStools".to_owned());
        }
        let (mut sum, mut layers) = (0u32, 0u64);
        for i in 0..usize::from(number_of_items) {
            let at = about + 34 + 6 * i;
            let (kind, size, version) = (file.u16(at)?, file.u16(at + 2)?, file.u16(at + 4)?);
            // Size, and layers where the data lie in those; 0 for any size.
            let (needed, parts, in_layers) = match kind {
                0 => (0, 0, false),
                6 => (20, 0, false),
                7 => (8, 0, false),
                8 => (6, 0, false),
                9 | 13 => (29, 1, kind == 13),
                10 => (30, 9, true),
                11 => (6, 1, true),
                12 => (8, 2, true),
                14 => (0, u64::from(size), true),
                _ => return fault(at, format!("unknown compressed parts of type {kind}")),
            };
            let goes_first = matches!(kind, 6 | 10);
            if (needed != 0 && size != needed)
                || size == 0
                || version == 0
                || in_layers != (compressor == 3)
                || goes_first != (i == 0)
            {
                return fault(at, format!("unexpected compressed part of type {kind} with {size} bytes"));
            }
            sum += u32::from(size);
            layers += parts;
        }
        if sum != u32::from(self.record) {
            let problem =
                format!("the compressed parts of a point have {sum} bytes in total, not {}", self.record);
            return fault(about + 32, problem);
        }
        self.check_chunk_table(file, compressor)?;
        if compressor == 3 { self.check_layers(file, about, layers) } else { Ok(()) }
    }

    /// Where the record about the compression has its content.
    fn compression(&self, file: Bytes<'_>) -> Result<usize, Fault> {
        let mut at = self.size;
        for _ in 0..self.records {
            let user: [u8; 16] = file.get(at + 2)?;
            let (id, length) = (file.u16(at + 18)?, usize::from(file.u16(at + 20)?));
            let content = at + VLR;
            if content + length > self.offset {
                let problem = format!("a record of {length} bytes does not fit before the points");
                return Err(Fault::at_byte(at + 20, problem));
            }
            if id == 22204 && user.starts_with(b"laszip encoded") {
                if length < 34 {
                    return Err(Fault::at_byte(at + 20, "the record about the compression is too short"));
                }
                return Ok(content);
            }
            at = content + length;
        }
        Err(Fault::at_byte(
            self.size,
            "the points are compressed, but the record that describes how is missing; export the scan again",
        ))
    }

    /// The number of chunks, for each of which memory is set aside.
    fn check_chunk_table(&self, file: Bytes<'_>, compressor: u16) -> Result<(), Fault> {
        if compressor == 1 {
            return Ok(());
        }
        let mut table = file.u64(self.offset)?;
        if (table as i64) <= self.offset as i64 {
            table = file.u64(file.0.len().saturating_sub(8))?;
        }
        let Some(at) = usize::try_from(table).ok().filter(|at| at.saturating_add(8) <= file.0.len()) else {
            let problem =
                format!("the chunk table should be at byte {table}, beyond the end; the file is truncated");
            return Err(Fault::at_byte(self.offset, problem));
        };
        let chunks = file.u32(at + 4)?;
        if u64::from(chunks) > self.points || chunks as usize > file.0.len() {
            return Err(Fault::at_byte(
                at + 4,
                format!("{chunks} chunks are declared for {} points", self.points),
            ));
        }
        Ok(())
    }

    /// The sizes of the layers of each chunk: a first point, a count, sizes,
    /// and as many bytes as those say.
    fn check_layers(&self, file: Bytes<'_>, about: usize, layers: u64) -> Result<(), Fault> {
        let chunk_size = u64::from(file.u32(about + 12)?);
        let mut at = self.offset + 8;
        let mut left = self.points;
        while left > 0 {
            let count_at = at + usize::from(self.record);
            let count = u64::from(file.u32(count_at)?);
            let mut end = count_at as u64 + 4 + 4 * layers;
            for layer in 0..layers as usize {
                end += u64::from(file.u32(count_at + 4 + 4 * layer)?);
            }
            if end > file.0.len() as u64 || count == 0 {
                let problem = format!(
                    "a chunk of {count} points should end at byte {end}, but the file has {} bytes; it is \
                     truncated",
                    file.0.len()
                );
                return Err(Fault::at_byte(count_at, problem));
            }
            at = end as usize;
            // In chunks of one size, that many points are taken whatever they say.
            let is_fixed = chunk_size != 0 && chunk_size != u64::from(u32::MAX);
            left = left.saturating_sub(if is_fixed { chunk_size } else { count });
        }
        Ok(())
    }
}
