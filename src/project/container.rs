//! The container of a session: a header and framed records, appended one after
//! the other. `docs/session-file.md` has the layout.
//!
//! A record is whole or not there: its checksum covers its frame and its
//! content. Whatever follows the first record that is not whole is not read.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;

use super::error::{Fault, OpenError};

/// Begins every session file. Like PNG's, it shows a transfer that changed line
/// ends or lost the eighth bit.
const MAGIC: [u8; 14] = *b"\x89Superform\r\n\x1a\n";
/// The newest format that is read, and the one that is written.
pub(super) const VERSION: u16 = 1;
/// Magic, format (u16), the program's version (12 bytes of ASCII, filled up
/// with 0) and the CRC-32 of all that.
const HEADER: usize = 32;
const PROGRAM: std::ops::Range<usize> = 16..28;
/// Kind (u8), packing (u8), two bytes of 0, stored and unpacked length (u64),
/// and the CRC-32 of these 20 bytes and the content.
const FRAME: usize = 24;
const CHECKED: usize = 20;
/// Largest session that is read, in bytes.
const LARGEST: u64 = 8 << 30;
/// Deflate makes nothing smaller than this share of what it was.
const MOST_DEFLATED: u64 = 1040;

/// Most bytes that a record becomes, in a file of so many: what is packed has a
/// few bytes for each sample, and each sample 24 in the file, unpacked.
fn most_unpacked(bytes: u64) -> u64 {
    (16 << 20) + 64 * bytes
}

/// What a record holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub(super) enum Kind {
    /// A shape as it was read.
    Shape = 1,
    /// The samples of a shape.
    Cloud = 2,
    /// A shape with its samples and how they came about.
    Loaded = 3,
    /// The state after a step.
    State = 4,
    /// A line of states.
    Branch = 5,
    /// All that undo goes back to.
    Document = 6,
    /// The whole session: the last one counts.
    Head = 7,
}

impl Kind {
    const ALL: [Self; 7] =
        [Self::Shape, Self::Cloud, Self::Loaded, Self::State, Self::Branch, Self::Document, Self::Head];

    fn of(byte: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == byte)
    }

    /// Coordinates hardly get smaller, and large shapes are to be saved at once.
    fn is_packed(self) -> bool {
        !matches!(self, Self::Shape | Self::Cloud)
    }

    /// For people.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Shape => "shape",
            Self::Cloud => "cloud of samples",
            Self::Loaded => "sampled shape",
            Self::State => "state",
            Self::Branch => "branch",
            Self::Document => "document",
            Self::Head => "head",
        }
    }
}

const STORED: u8 = 0;
const DEFLATED: u8 = 1;

/// Writes the header of a new file; returns its length.
pub(super) fn write_header(out: &mut dyn Write) -> io::Result<u64> {
    out.write_all(&header(VERSION, env!("CARGO_PKG_VERSION")))?;
    Ok(HEADER as u64)
}

fn header(version: u16, program: &str) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    header[..14].copy_from_slice(&MAGIC);
    header[14..16].copy_from_slice(&version.to_le_bytes());
    let name = &program.as_bytes()[..program.len().min(PROGRAM.len())];
    header[PROGRAM.start..][..name.len()].copy_from_slice(name);
    let sum = crc32fast::hash(&header[..28]);
    header[28..].copy_from_slice(&sum.to_le_bytes());
    header
}

/// Appends a record; returns its length with the frame.
pub(super) fn write_record(out: &mut dyn Write, kind: Kind, content: &[u8]) -> io::Result<u64> {
    let mut deflated = Vec::new();
    if kind.is_packed() {
        let mut encoder = DeflateEncoder::new(&mut deflated, Compression::fast());
        encoder.write_all(content)?;
        encoder.finish()?;
    }
    let is_smaller = kind.is_packed() && deflated.len() < content.len();
    let (packing, stored) = if is_smaller { (DEFLATED, &deflated[..]) } else { (STORED, content) };
    let mut frame = [0; FRAME];
    frame[0] = kind as u8;
    frame[1] = packing;
    frame[4..12].copy_from_slice(&(stored.len() as u64).to_le_bytes());
    frame[12..20].copy_from_slice(&(content.len() as u64).to_le_bytes());
    let mut sum = crc32fast::Hasher::new();
    sum.update(&frame[..CHECKED]);
    sum.update(stored);
    frame[20..].copy_from_slice(&sum.finalize().to_le_bytes());
    out.write_all(&frame)?;
    out.write_all(stored)?;
    Ok((FRAME + stored.len()) as u64)
}

/// A record that was read whole.
#[derive(Debug)]
pub(super) struct Record {
    pub(super) kind: Kind,
    /// Where its frame begins.
    pub(super) byte: u64,
    is_deflated: bool,
    length: u64,
    stored: Vec<u8>,
}

impl Record {
    /// The content, unpacked.
    pub(super) fn content(&self) -> Result<Cow<'_, [u8]>, Fault> {
        let wrong = |problem: &str| Fault::at(self.byte, format!("a {} {problem}", self.kind.name()));
        if !self.is_deflated {
            return Ok(Cow::Borrowed(&self.stored));
        }
        // Grows with what is really there, whatever length is claimed.
        let mut content = Vec::new();
        DeflateDecoder::new(&self.stored[..])
            .take(self.length + 1)
            .read_to_end(&mut content)
            .map_err(|_| wrong("cannot be decompressed"))?;
        if content.len() as u64 != self.length {
            return Err(wrong("does not have its stated length"));
        }
        Ok(Cow::Owned(content))
    }
}

/// What of a file is whole.
#[derive(Debug)]
pub(super) struct Scan {
    pub(super) records: Vec<Record>,
    /// Why the rest was not read, if there is a rest.
    pub(super) rest: Option<Fault>,
}

/// Reads all records up to the first that is not whole.
pub(super) fn scan(path: &Path) -> Result<Scan, OpenError> {
    let failed = |reason| OpenError::Open { path: path.to_owned(), reason };
    let about = std::fs::metadata(path).map_err(failed)?;
    if !about.is_file() {
        return Err(OpenError::NotAFile { path: path.to_owned() });
    }
    let file = File::open(path).map_err(failed)?;
    let bytes = file.metadata().map_err(failed)?.len();
    if bytes == 0 {
        return Err(OpenError::Empty { path: path.to_owned() });
    }
    if bytes > LARGEST {
        return Err(OpenError::TooLarge { path: path.to_owned(), bytes, limit: LARGEST });
    }
    let mut input = BufReader::with_capacity(1 << 16, file);
    read_header(&mut input, path)?;
    let mut records = Vec::new();
    let mut at = HEADER as u64;
    while at < bytes {
        match read_record(&mut input, at, bytes) {
            Ok((record, end)) => {
                records.push(record);
                at = end;
            }
            Err(Trouble::Fault(problem)) => {
                return Ok(Scan { records, rest: Some(Fault::at(at, problem)) });
            }
            Err(Trouble::Io(reason)) => return Err(failed(reason)),
        }
    }
    Ok(Scan { records, rest: None })
}

fn read_header(input: &mut impl Read, path: &Path) -> Result<(), OpenError> {
    let mut header = Vec::with_capacity(HEADER);
    input
        .take(HEADER as u64)
        .read_to_end(&mut header)
        .map_err(|reason| OpenError::Open { path: path.to_owned(), reason })?;
    let known = header.len().min(MAGIC.len());
    if header[..known] != MAGIC[..known] {
        return Err(OpenError::NotASession { path: path.to_owned() });
    }
    let damaged = |problem: &str| Fault::at(0, problem).in_file(path.to_owned());
    let header: [u8; HEADER] = header.try_into().map_err(|_| damaged("the file ends within its header"))?;
    if header[28..] != crc32fast::hash(&header[..28]).to_le_bytes() {
        return Err(damaged("the header's checksum does not match"));
    }
    let format = u16::from_le_bytes([header[14], header[15]]);
    if format > VERSION {
        let program = String::from_utf8_lossy(&header[PROGRAM]).trim_end_matches('\0').to_owned();
        return Err(OpenError::TooNew { path: path.to_owned(), format, newest: VERSION, program });
    }
    // Format 1 is the oldest.
    if format == 0 { Err(damaged("it has no format version")) } else { Ok(()) }
}

/// Why a record is not whole, or can't be read.
#[derive(Debug)]
enum Trouble {
    Fault(&'static str),
    Io(io::Error),
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        // The file has become shorter since it was measured.
        if error.kind() == io::ErrorKind::UnexpectedEof {
            Self::Fault("a record is truncated")
        } else {
            Self::Io(error)
        }
    }
}

/// The record at byte `at` of a file of `bytes`, and where the next one begins.
fn read_record(input: &mut impl Read, at: u64, bytes: u64) -> Result<(Record, u64), Trouble> {
    if bytes - at < FRAME as u64 {
        return Err(Trouble::Fault("a record is truncated"));
    }
    let mut frame = [0; FRAME];
    input.read_exact(&mut frame)?;
    let number = |at: usize| {
        let mut eight = [0; 8];
        eight.copy_from_slice(&frame[at..at + 8]);
        u64::from_le_bytes(eight)
    };
    let (stored, length) = (number(4), number(12));
    let begin = at + FRAME as u64;
    if stored > bytes - begin {
        return Err(Trouble::Fault("a record is truncated or its length is wrong"));
    }
    // No more than the file has.
    let mut content = Vec::with_capacity(stored as usize);
    input.take(stored).read_to_end(&mut content)?;
    let mut sum = crc32fast::Hasher::new();
    sum.update(&frame[..CHECKED]);
    sum.update(&content);
    if content.len() as u64 != stored || frame[20..] != sum.finalize().to_le_bytes() {
        return Err(Trouble::Fault("a record's checksum does not match"));
    }
    let kind = Kind::of(frame[0]).ok_or(Trouble::Fault("a record has an unknown type"))?;
    let is_deflated = frame[1] == DEFLATED;
    let fits = if is_deflated {
        length / MOST_DEFLATED <= stored && length <= most_unpacked(bytes)
    } else {
        frame[1] == STORED && length == stored
    };
    if !fits {
        return Err(Trouble::Fault("a record has an impossible length"));
    }
    Ok((Record { kind, byte: at, is_deflated, length, stored: content }, begin + stored))
}
