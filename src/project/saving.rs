//! A session as a file of its own.

use std::path::Path;

use super::container::write_header;
use super::ledger::Ledger;
use super::writing::Writing;
use crate::io::{WriteError, write_streamed};
use crate::session::workspace::Workspace;

/// Writes the session, with nothing that it doesn't need.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn save(path: &Path, workspace: &Workspace) -> Result<(), WriteError> {
    write_streamed(path, |out| {
        write_header(out)?;
        Writing { ledger: &mut Ledger::default(), out }.in_two_heads(workspace)
    })
}
