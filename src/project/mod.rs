//! The session as a file: saved, opened, and kept all the time in a journal,
//! from which it is recovered after a crash. `docs/session-file.md` has the
//! format, and what is promised of it.

mod autosave;
mod container;
mod error;
mod folder;
mod journal;
mod ledger;
mod raw;
mod reading;
mod saving;
mod shapes;
mod states;
mod writing;

pub use autosave::{Autosave, Event, Origin};
pub use error::OpenError;
pub use folder::user_folder;
pub use reading::{Opened, open};
pub use saving::save;
