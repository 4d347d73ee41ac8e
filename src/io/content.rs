//! The bytes of files, and how many of them there may be.

use std::fs;
use std::io::Read;
use std::path::Path;

use super::error::ReadError;

/// Largest file that is read, in bytes.
const LARGEST: u64 = 8 << 30;

/// Maximum decompressed size for this compressed size: clouds compress to about
/// a tenth; anything below a hundredth is not a cloud.
pub(super) fn most_unpacked(packed: usize) -> u64 {
    (16 << 20) + 100 * packed as u64
}

/// The bytes of a regular file that is neither empty nor too large.
pub(super) fn content(path: &Path) -> Result<Vec<u8>, ReadError> {
    let open = |reason| ReadError::Open { path: path.to_owned(), reason };
    let about = fs::metadata(path).map_err(open)?;
    if !about.is_file() {
        return Err(ReadError::NotAFile { path: path.to_owned() });
    }
    if about.len() > LARGEST {
        return Err(ReadError::TooLarge { path: path.to_owned(), bytes: about.len(), limit: LARGEST });
    }
    let mut bytes = Vec::with_capacity(about.len() as usize);
    fs::File::open(path).and_then(|file| file.take(LARGEST).read_to_end(&mut bytes)).map_err(open)?;
    if bytes.is_empty() {
        return Err(ReadError::Empty { path: path.to_owned() });
    }
    Ok(bytes)
}
