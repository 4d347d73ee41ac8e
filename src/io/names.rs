//! Names by which the program's own files are known.

use std::path::Path;

/// Names of the files that [`write_run`](super::write_run) puts into a folder.
pub const SEGMENTED_FILE: &str = "segmented.ply";
pub const PRIMITIVES_FILE: &str = "primitives.json";
pub const REPORT_FILE: &str = "report.json";

/// Names by which primitives are looked for in a folder, the first of them first.
pub(super) const PRIMITIVES_FILES: [&str; 3] = [PRIMITIVES_FILE, "primitives.npz", "primitives.csv"];

/// Ending of the names of session files.
pub const SESSION_ENDING: &str = "superform";

/// Whether a file's name ends as that of a session.
pub fn has_session_ending(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(SESSION_ENDING))
}
