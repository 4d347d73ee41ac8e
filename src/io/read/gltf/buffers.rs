//! Buffers of a glTF file: in the binary part, in the JSON as base64, or in a separate file.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::schema::Buffer;
use crate::io::content::content;
use crate::io::error::Fault;
use crate::io::paths::{path_of, percent_bytes};
use crate::io::read::text::quoted;

/// The JSON and the binary part of a GLB file.
pub(super) fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let word = |at: usize| {
        let bytes = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    };
    if let Some(version) = word(4).filter(|v| *v != 2) {
        let problem =
            format!("it is binary glTF {version}, but only glTF 2 is supported; export the shape again");
        return Err(Fault::at_byte(4, problem));
    }
    let (mut at, mut json, mut binary) = (12, None, None);
    while json.is_none() || (binary.is_none() && at < bytes.len()) {
        let (Some(length), Some(kind)) = (word(at), word(at + 4)) else {
            // A few bytes of padding behind the JSON do no harm.
            if json.is_some() {
                break;
            }
            return Err(Fault::at_byte(at, "its JSON part is missing; the file may be truncated"));
        };
        let start = at + 8;
        let rest = bytes.get(start..).unwrap_or_default();
        // The padding of the last part may be counted, and yet not be there.
        let is_whole = rest.len() as u64 + 4 > u64::from(length);
        let part = &rest[..rest.len().min(length as usize)];
        if !is_whole {
            let there = rest.len();
            let problem = format!(
                "a part of {length} bytes starts here, but there are {there}; the file is truncated: copy \
                 or export it again"
            );
            return Err(Fault::at_byte(at, problem));
        }
        match &kind.to_le_bytes() {
            b"JSON" => json = json.or(Some(part)),
            b"BIN\0" => binary = Some(part),
            _ => {}
        }
        at = next_part(bytes, start + part.len());
    }
    let json = json.unwrap_or_default();
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    // Some pad it with zeros rather than blanks.
    let end = json.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    Ok((&json[..end], binary))
}

/// Where the part behind one that ends at `end` begins: at a multiple of 4, or
/// before that in files that were not padded.
fn next_part(bytes: &[u8], end: usize) -> usize {
    let is_part = |at: &usize| matches!(bytes.get(at + 4..at + 8), Some(b"JSON" | b"BIN\0"));
    (end..end + 4).find(is_part).unwrap_or(end.next_multiple_of(4))
}

/// The bytes of a buffer.
pub(super) fn load<'a>(
    index: usize,
    buffer: &Buffer,
    blob: Option<&'a [u8]>,
    folder: Option<&Path>,
) -> Result<Cow<'a, [u8]>, Fault> {
    let Some(uri) = &buffer.uri else {
        return blob
            .filter(|_| index == 0)
            .map(Cow::Borrowed)
            .ok_or_else(|| Fault::whole(format!("buffer {index} has no content; export the shape again")));
    };
    if is_data(uri) {
        let (about, data) = uri[5..].split_once(',').unwrap_or_default();
        let data = percent_bytes(data);
        let is_base64 =
            about.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
        let decoded = if is_base64 { base64(&data) } else { Some(data).filter(|_| !about.is_empty()) };
        let problem =
            || Fault::whole(format!("buffer {index} is not valid base64 data; export the shape again"));
        return decoded.map(Cow::Owned).ok_or_else(problem);
    }
    let names = names_of(uri);
    if uri.contains("://") || names[0].is_absolute() {
        let problem = format!(
            "its buffer {} is in a different location; save it next to the file or embed it",
            quoted(uri)
        );
        return Err(Fault::whole(problem));
    }
    let Some(folder) = folder else {
        let problem = format!("its buffer {} is a separate file; embed it", quoted(uri));
        return Err(Fault::whole(problem));
    };
    let name = names.iter().find(|name| folder.join(name).is_file()).unwrap_or(&names[0]);
    let problem = |e| Fault::whole(format!("its buffer is a second file that cannot be read: {e}"));
    content(&folder.join(name)).map(Cow::Owned).map_err(problem)
}

/// Whether a URI is the data itself.
pub(super) fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|start| start.eq_ignore_ascii_case("data:"))
}

/// The names that a URI may mean: some write a name as it is, or with the
/// strokes of Windows.
pub(super) fn names_of(uri: &str) -> [PathBuf; 3] {
    let name = percent_bytes(uri);
    let slashed = name.iter().map(|&byte| if byte == b'\\' { b'/' } else { byte }).collect();
    [path_of(name), PathBuf::from(uri), path_of(slashed)]
}

/// Bytes from base64, with or without its padding; `None` where it isn't that.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    // Lines may be broken.
    let text: Vec<u8> = text.iter().copied().filter(|c| !c.is_ascii_whitespace()).collect();
    let digits = text.split(|&c| c == b'=').next().unwrap_or_default();
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    for group in digits.chunks(4) {
        let mut bits = 0u32;
        for &c in group {
            let six = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' | b'-' => 62,
                b'/' | b'_' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(six);
        }
        let missing = 4 - group.len();
        let whole = (bits << (6 * missing)).to_be_bytes();
        bytes.extend_from_slice(&whole[1..4 - missing.min(3)]);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_with_and_without_padding() {
        for (text, bytes) in
            [("", ""), ("Zg==", "f"), ("Zg", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg==", "foob")]
        {
            assert_eq!(base64(text.as_bytes()).as_deref(), Some(bytes.as_bytes()), "{text}");
        }
        assert_eq!(base64(b"-_+/"), Some(vec![0xfb, 0xff, 0xbf]));
        assert_eq!(base64(b"Zm 9\r\nv"), Some(b"foo".to_vec()));
        assert_eq!(base64(b"Zm~9"), None);
    }
}
