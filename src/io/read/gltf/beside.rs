//! The external files that a scene refers to.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::buffers::{is_data, names_of};

/// Size limit of a text that is searched for buffers.
const LARGEST: u64 = 256 << 20;
/// How much of a file must be blank to be no text of a scene.
const HEAD: u64 = 4 << 10;

/// The external buffer files of a glTF or GLB file; none for other files or unreadable ones.
pub fn buffers_beside(path: &Path) -> Vec<PathBuf> {
    let scene: Value = text(path).and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default();
    let folder = path.parent().unwrap_or(Path::new(""));
    let buffers = scene["buffers"].as_array().into_iter().flatten();
    buffers
        .filter_map(|buffer| buffer["uri"].as_str())
        .filter(|uri| !is_data(uri))
        .flat_map(names_of)
        .map(|name| folder.join(name))
        .collect()
}

/// The JSON text of the scene, if it looks like one.
fn text(path: &Path) -> Option<Vec<u8>> {
    // Opening a pipe would wait, and take what is in it.
    if !path.is_file() {
        return None;
    }
    let mut file = File::open(path).ok()?;
    let mut text = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut text).ok()?;
    if let Some(header) = text.first_chunk::<20>().filter(|header| header.starts_with(b"glTF")) {
        let length = u32::from_le_bytes([header[12], header[13], header[14], header[15]]);
        let rest = u64::from(length).min(LARGEST) + 20;
        file.take(rest.saturating_sub(text.len() as u64)).read_to_end(&mut text).ok()?;
        text.truncate(rest as usize);
        text.drain(..20);
        return Some(text);
    }
    let is_text = text.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'{');
    if !is_text || file.metadata().ok()?.len() > LARGEST {
        return None;
    }
    file.read_to_end(&mut text).ok()?;
    Some(text)
}
