//! LAS and LAZ (airborne and terrestrial laser scans), read with the crate las: coordinates in
//! double precision, colours, classes as labels.
//!
//! The crate allocates whatever a header declares, so headers are first checked against the file.

use std::io::Cursor;

use nalgebra::Point3;

use super::columns::DEGREES;
use super::raw::Raw;
use crate::io::caught::caught;
use crate::io::content::most_unpacked;
use crate::io::error::Fault;
use crate::io::shape::Attributes;
use header::Header;

mod header;

/// Points that are unpacked at once.
const BATCH: u64 = 1 << 16;

pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let header = Header::parse(bytes)?;
    let size = header.points.saturating_mul(u64::from(header.record));
    let room = (bytes.len() - header.offset) as u64 / u64::from(header.record);
    if !header.is_compressed && header.points > room {
        return Err(Fault::at_byte(
            header.count_at,
            format!(
                "the header declares {} points of {} bytes, but the file has room for {room}; the file may \
                 be truncated",
                header.points, header.record
            ),
        ));
    }
    if header.is_compressed {
        if size > most_unpacked(bytes.len()) {
            let problem = format!(
                "the header declares {} points, too many for a file of {} bytes",
                header.points,
                bytes.len()
            );
            return Err(Fault::at_byte(header.count_at, problem));
        }
        header.check_compression(bytes)?;
    }
    if header.points == 0 {
        return Err(Fault::at_byte(header.count_at, "the header declares no points; export the scan again"));
    }
    // The decoder is another's, made for files that are whole: should it give
    // up on a damaged one, that is a fault of the file.
    let damaged = "the points cannot be decompressed; the file is damaged: copy or export it again";
    let source = header.without_appendix(bytes);
    caught(|| points(source, &header)).unwrap_or_else(|_| Err(Fault::at_byte(header.offset, damaged)))
}

fn points(source: Vec<u8>, header: &Header) -> Result<Raw, Fault> {
    let unreadable =
        |e: las::Error| Fault::whole(format!("the header cannot be parsed: {e}; export the scan again"));
    let mut reader = las::Reader::new(Cursor::new(source)).map_err(unreadable)?;
    let mut raw = Raw::default();
    if reader.header().vlrs().iter().any(is_geographic) {
        raw.notes.push(DEGREES.to_owned());
    }
    let (mut colors, mut labels) = (Vec::new(), Vec::new());
    loop {
        let done = raw.points.len();
        let batch = reader.read_points(BATCH.min(header.points - done as u64)).map_err(|e| {
            let problem = format!(
                "of {} declared points, those from {done} on cannot be read ({e}); the file is truncated or \
                 damaged",
                header.points
            );
            Fault::at_byte(header.offset, problem)
        })?;
        raw.points.extend(batch.x().zip(batch.y()).zip(batch.z()).map(|((x, y), z)| Point3::new(x, y, z)));
        labels.extend(batch.classification().map(i64::from));
        if let Some(rgb) = batch.rgb() {
            colors.extend(rgb.map(|(r, g, b)| [r, g, b]));
        }
        if raw.points.len() as u64 >= header.points || raw.points.len() == done {
            break;
        }
    }
    // 0 and 1 stand for points that nobody classified.
    let labels = labels.iter().any(|l| *l > 1).then_some(labels);
    raw.attributes = Attributes { colors: bytes_of(&colors), normals: None, labels };
    Ok(raw)
}

/// Whether a record says that coordinates are longitude and latitude: by the key of
/// GeoTIFF for the model, or as well-known text.
fn is_geographic(record: &las::Vlr) -> bool {
    const MODEL: u16 = 1024;
    const GEOGRAPHIC: u16 = 2;
    match record.record_id {
        34735 => {
            let words: Vec<u16> =
                record.data.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
            words.chunks_exact(4).any(|key| key[0] == MODEL && key[3] == GEOGRAPHIC)
        }
        2112 => {
            let text = String::from_utf8_lossy(&record.data);
            ["GEOGCS", "GEOGCRS"].iter().any(|word| text.contains(word))
                && !["PROJCS", "PROJCRS", "GEOCCS"].iter().any(|word| text.contains(word))
        }
        _ => false,
    }
}

/// Colours of 16 bits a channel, of which many programs fill the lower 8 only;
/// where all are 0, there are none.
fn bytes_of(colors: &[[u16; 3]]) -> Option<Vec<[u8; 3]>> {
    let largest = colors.iter().flatten().copied().max().filter(|max| *max > 0)?;
    let byte = |v: u16| if largest > 255 { (f32::from(v) / 257.0).round() as u8 } else { v as u8 };
    Some(colors.iter().map(|rgb| rgb.map(byte)).collect())
}
