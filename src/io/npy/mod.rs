//! NumPy's arrays and archives of them, to files and back.
//!
//! Headers are read here because the crates for them multiply sides of shapes
//! without a check and follow brackets as deep as a file likes; the archive
//! itself is a library's.

mod arrays;
mod header;
mod writer;

pub(super) use arrays::{Archive, Array};
pub(super) use header::{Header, LONGEST, shown};
pub(super) use writer::Npz;
