//! Paths stored in text files.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Beginning of a path that is no text, and is written byte by byte.
const URI: &str = "file:";

/// A path as it is kept in a file: as it is where it is text, else percent-encoded
/// behind `file:`, so that it comes back with every byte.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredPath(pub PathBuf);

impl StoredPath {
    /// A path as text.
    pub fn text(path: &Path) -> Cow<'_, str> {
        match path.to_str() {
            Some(text) if !text.starts_with(URI) => Cow::Borrowed(text),
            _ => Cow::Owned(encoded(path)),
        }
    }

    /// A path from its text.
    pub fn of(text: &str) -> Self {
        Self(match text.strip_prefix(URI) {
            Some(encoded) => path_of(percent_bytes(encoded)),
            None => PathBuf::from(text),
        })
    }
}

impl Serialize for StoredPath {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&Self::text(&self.0))
    }
}

impl<'de> Deserialize<'de> for StoredPath {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self::of(&String::deserialize(deserializer)?))
    }
}

fn encoded(path: &Path) -> String {
    let mut text = URI.to_owned();
    for &byte in path.as_os_str().as_encoded_bytes() {
        if byte.is_ascii_alphanumeric() || b"/\\:-_.~".contains(&byte) {
            text.push(char::from(byte));
        } else {
            text.push_str(&format!("%{byte:02X}"));
        }
    }
    text
}

/// `a%20b` becomes `a b`.
pub(super) fn percent_bytes(uri: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = |c: u8| char::from(c).to_digit(16);
        (bytes, rest) = match (first, tail) {
            (b'%', [high, low, tail @ ..]) if hex(*high).is_some() && hex(*low).is_some() => {
                let byte = hex(*high).unwrap_or_default() * 16 + hex(*low).unwrap_or_default();
                bytes.push(byte as u8);
                (bytes, tail)
            }
            _ => {
                bytes.push(*first);
                (bytes, tail)
            }
        };
    }
    bytes
}

#[cfg(unix)]
pub(super) fn path_of(bytes: Vec<u8>) -> PathBuf {
    use std::os::unix::ffi::OsStringExt as _;
    std::ffi::OsString::from_vec(bytes).into()
}

/// What is no text has no bytes of its own elsewhere.
#[cfg(not(unix))]
pub(super) fn path_of(bytes: Vec<u8>) -> PathBuf {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_signs_are_decoded() {
        assert_eq!(percent_bytes("a%20b%C3%BC.bin"), "a bü.bin".as_bytes());
        assert_eq!(percent_bytes("100%"), b"100%");
        assert_eq!(percent_bytes("%zz%4%E4"), b"%zz%4\xe4");
    }

    #[cfg(unix)]
    #[test]
    fn paths_come_back_with_every_byte() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt as _;
        for bytes in [&b"/shapes/chair.obj"[..], b"a%20b.obj", "Stühle/ü.ply".as_bytes(), b"", b"file:x"] {
            let path = PathBuf::from(OsStr::from_bytes(bytes));
            let text = serde_json::to_string(&StoredPath(path.clone())).unwrap();
            assert_eq!(serde_json::from_str::<StoredPath>(&text).unwrap(), StoredPath(path), "{text}");
        }
        let path = PathBuf::from(OsStr::from_bytes(b"/St\xfchle/50% \"x\".obj"));
        assert_eq!(StoredPath::text(&path), "file:/St%FChle/50%25%20%22x%22.obj");
        assert_eq!(StoredPath::of(&StoredPath::text(&path)).0, path);
    }
}
