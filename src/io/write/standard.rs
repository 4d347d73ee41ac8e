//! Standard output, and the only access to it.

use std::io::{self, Read};

/// Passes everything on to standard output, through to whoever reads it.
///
/// # Errors
/// Where it is full, or nobody reads it: what a program was asked for is lost
/// then, and its exit status must say so.
pub fn print(mut content: impl Read) -> io::Result<()> {
    let mut out = io::stdout().lock();
    io::copy(&mut content, &mut out)?;
    io::Write::flush(&mut out)
}
