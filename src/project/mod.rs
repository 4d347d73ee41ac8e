//! The session as a file: saved, opened, and kept all the time in a journal,
//! from which it is recovered after a crash. `docs/session-file.md` has the
//! format, and what is promised of it.

mod container;
mod error;
mod folder;
mod journal;
mod keeper;
mod ledger;
mod raw;
mod reading;
mod saving;
mod shapes;
mod states;
mod writing;

use std::path::Path;

pub use error::OpenError;
pub use folder::user_folder;
pub use keeper::{Event, Found, Keeper, Origin};
pub use reading::{Opened, open};
pub use saving::save;
pub use states::Summary;

/// Ending of the names of session files.
pub const ENDING: &str = "superform";

/// Whether a file's name ends as that of a session.
pub fn has_session_ending(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(ENDING))
}
