//! Fingerprints of a job's input, settings and files, to detect changes.

use std::collections::HashMap;
use std::fs::File;
use std::io::{ErrorKind, Read, Result};
use std::path::{Path, PathBuf};

use crate::geometry::SamplingOptions;
use crate::inference::Params;
use crate::io;

/// A fingerprint of some bytes (FNV-1a).
pub(in crate::cli) fn fingerprint(parts: &[&[u8]]) -> String {
    let mut hash = Hash::default();
    for part in parts {
        // The length keeps parts from running into each other.
        hash.take(&part.len().to_le_bytes());
        hash.take(part);
    }
    hash.text()
}

#[derive(Debug, Clone, Copy)]
struct Hash(u64);

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    fn take(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    fn text(self) -> String {
        format!("{:016x}", self.0)
    }
}

/// Calls `take` with the bytes of a file, piece by piece.
pub(super) fn pieces(path: &Path, mut take: impl FnMut(&[u8])) -> Result<u64> {
    let mut file = File::open(path)?;
    let mut buffer = vec![0; 1 << 20];
    let mut bytes = 0;
    loop {
        match file.read(&mut buffer) {
            Ok(0) => return Ok(bytes),
            Ok(n) => {
                take(&buffer[..n]);
                bytes += n as u64;
            }
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
}

/// Fingerprints of inputs by their content; those that were asked for are
/// remembered.
#[derive(Debug, Default)]
pub(super) struct Inputs(HashMap<PathBuf, Option<String>>);

impl Inputs {
    /// Of a file and, if it is a glTF text, of the buffers beside it; `None`
    /// where it can't be read.
    pub(super) fn content(&mut self, path: &Path) -> Option<String> {
        self.0.entry(path.to_owned()).or_insert_with(|| content(path).ok()).clone()
    }
}

/// The content of a file and of what belongs to it.
///
/// # Errors
/// Where the file can't be read.
pub(super) fn content(path: &Path) -> Result<String> {
    let mut hash = Hash::default();
    if !path.is_file() {
        return Err(ErrorKind::NotFound.into());
    }
    pieces(path, |piece| hash.take(piece))?;
    for buffer in io::buffers_beside(path) {
        // What is not there is told by whoever reads the shape.
        let length = pieces(&buffer, |piece| hash.take(piece)).unwrap_or(0);
        hash.take(&length.to_le_bytes());
    }
    Ok(hash.text())
}

/// What a result depends on: the program, the input and the settings.
pub(super) fn of_job(
    content: &str,
    sampling: &SamplingOptions,
    params: &Params,
    exports: &[String],
) -> serde_json::Result<String> {
    let sampling = (sampling.points, sampling.seed, sampling.surface, sampling.isolated);
    let settings = serde_json::to_vec(&(sampling, params, exports))?;
    Ok(fingerprint(&[env!("SUPERFORM_VERSION").as_bytes(), content.as_bytes(), &settings]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fingerprints_tell_parts_apart() {
        assert_eq!(fingerprint(&[b"a", b"b"]), fingerprint(&[b"a", b"b"]));
        assert_ne!(fingerprint(&[b"ab", b""]), fingerprint(&[b"a", b"b"]));
    }

    #[test]
    fn inputs_are_told_by_their_content() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        let write = |name: &str, text: &str| std::fs::write(place(name), text).unwrap();
        write("a.xyz", "1 2 3");
        write("copy.xyz", "1 2 3");
        write("b.xyz", "1 2 4");
        let of = |name: &str| content(&place(name)).unwrap();
        assert_eq!(of("a.xyz"), of("copy.xyz"));
        assert_ne!(of("a.xyz"), of("b.xyz"));
        assert!(content(&place("gone.xyz")).is_err());
        // The buffers of a scene belong to it.
        write("scene.gltf", "{\"buffers\": [{\"uri\": \"my%20d%C3%A4ta.bin\"}, {\"uri\": \"data:,\"}]}");
        let without = of("scene.gltf");
        write("my däta.bin", "one");
        let one = of("scene.gltf");
        write("my däta.bin", "two");
        assert!(without != one && one != of("scene.gltf"));
    }

    #[test]
    fn every_setting_counts() {
        let (sampling, params) = (SamplingOptions::default(), Params::default());
        let usual = of_job("a", &sampling, &params, &[]).unwrap();
        assert_eq!(usual, of_job("a", &sampling, &params, &[]).unwrap());
        assert_ne!(usual, of_job("a", &sampling, &params, &["a.csv".to_owned()]).unwrap());
        for (content, sampling, params) in [
            ("b", sampling, params),
            ("a", SamplingOptions { points: 100, ..sampling }, params),
            ("a", SamplingOptions { seed: 2, ..sampling }, params),
            ("a", sampling, Params { alpha: 0.6, ..params }),
            ("a", sampling, Params { refine: false, ..params }),
        ] {
            assert_ne!(usual, of_job(content, &sampling, &params, &[]).unwrap());
        }
    }
}
