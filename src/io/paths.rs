//! Paths stored in text files.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::read::percent_bytes;

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

#[cfg(all(test, unix))]
mod tests {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;

    use super::*;

    #[test]
    fn paths_come_back_with_every_byte() {
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
