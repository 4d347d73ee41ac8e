//! What a name can be that of.

use std::path::Path;

use crate::io;

/// Whether a path can be that of a PNG: by its ending, or because it is no name of
/// a file at all.
pub(super) fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) || io::is_written_through(path)
}

/// What a folder for results is called, as far as it can be told from a file.
///
/// # Errors
/// Where a file seems to be meant.
pub(super) fn folder_for_results(path: &Path) -> Result<(), String> {
    let shown = path.display();
    if path == Path::new("-") {
        let problem = "several results cannot go to standard output; give a folder (write ./- for \
             a folder named -)";
        return Err(problem.to_owned());
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if is_folder(path) || !is_output_ending(&ending) {
        return Ok(());
    }
    Err(format!(
        "{shown} looks like a file, but results go to a folder; give a folder, or write {shown}/ if this is \
         one"
    ))
}

/// Whether a path is a folder, or written as one: with a slash behind it.
pub(super) fn is_folder(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    path.is_dir() || last.is_some_and(|&byte| std::path::is_separator(char::from(byte)))
}

/// Whether an ending is that of a file that people may expect where a folder is
/// written. A folder may be called as the shape is that its results are of.
fn is_output_ending(ending: &str) -> bool {
    const MORE: [&str; 8] = ["png", "jpg", "jpeg", "gif", "pdf", "md", "jsonl", io::SESSION_ENDING];
    let is_written = |ending| io::Format::ALL.iter().any(|format| format.ending() == ending);
    MORE.contains(&ending) || (is_written(ending) && !io::SHAPE_ENDINGS.contains(&ending))
}
