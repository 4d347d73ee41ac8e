//! File name patterns as in shells, also for names that are not valid text.

use std::fs;
use std::path::{Component, Path, PathBuf};

use glob::{MatchOptions, Pattern};

/// As shells have it: hidden files want to be named.
const OPTIONS: MatchOptions =
    MatchOptions { case_sensitive: true, require_literal_separator: true, require_literal_leading_dot: true };

/// Whether a pattern is meant: something with `*`, `?` or `[` that is no file.
pub(super) fn is_pattern(given: &Path) -> bool {
    given.as_os_str().as_encoded_bytes().iter().any(|byte| b"*?[".contains(byte)) && !given.exists()
}

/// All that a pattern matches, by name.
///
/// # Errors
/// Where it makes no sense, or a folder can't be listed.
pub(super) fn matches(pattern: &Path) -> Result<Vec<PathBuf>, String> {
    let mut found = vec![PathBuf::new()];
    for part in pattern.components() {
        let Component::Normal(part) = part else {
            found.iter_mut().for_each(|path| path.push(part));
            continue;
        };
        // What is no text in it stands for what is no text in names.
        let text = part.to_string_lossy();
        let compiled =
            Pattern::new(&text).map_err(|e| format!("invalid pattern {}: {}", pattern.display(), e.msg))?;
        let mut next = Vec::new();
        for path in found {
            if text == "**" {
                folders(&path, &mut next)?;
            } else if text.contains(['*', '?', '[']) {
                let names = entries(&path)?.into_iter();
                next.extend(names.filter(|entry| compiled.matches_with(&name(entry), OPTIONS)));
            } else if path.join(part).symlink_metadata().is_ok() {
                next.push(path.join(part));
            }
        }
        found = next;
    }
    Ok(found)
}

/// Adds a folder and all below it.
fn folders(folder: &Path, found: &mut Vec<PathBuf>) -> Result<(), String> {
    found.push(folder.to_owned());
    for entry in entries(folder)? {
        // Links to folders are not followed: they may lead in circles.
        let is_folder = entry.symlink_metadata().is_ok_and(|about| about.is_dir());
        if is_folder && !name(&entry).starts_with('.') {
            folders(&entry, found)?;
        }
    }
    Ok(())
}

/// What is in a folder, by name; nothing is in what is none.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    if !listed.is_dir() {
        return Ok(Vec::new());
    }
    let failed = |e: std::io::Error| format!("cannot list the folder {}: {e}", listed.display());
    let mut found = Vec::new();
    for entry in fs::read_dir(listed).map_err(failed)? {
        found.push(folder.join(entry.map_err(failed)?.file_name()));
    }
    found.sort();
    Ok(found)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(root: &Path, pattern: impl AsRef<Path>) -> Vec<PathBuf> {
        assert!(is_pattern(&root.join(&pattern)));
        let found = matches(&root.join(pattern)).unwrap();
        found.iter().map(|path| path.strip_prefix(root).unwrap().to_owned()).collect()
    }

    #[test]
    fn patterns_match_as_in_a_shell() {
        let root = tempfile::tempdir().unwrap();
        for name in ["a/x.obj", "a/b/y.obj", "a/b/.z.obj", "a/.git/w.obj", "x.obj/v.obj", "u.ply"] {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        let found = |pattern: &str| found(root.path(), pattern);
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        assert_eq!(found("*"), paths(&["a", "u.ply", "x.obj"]));
        assert_eq!(found("*/[xv].obj"), paths(&["a/x.obj", "x.obj/v.obj"]));
        assert_eq!(found("**/*.obj"), paths(&["x.obj", "a/x.obj", "a/b/y.obj", "x.obj/v.obj"]));
        assert_eq!(found("a/?/*"), paths(&["a/b/y.obj"]));
        assert_eq!(found("a/.*/w.obj"), paths(&["a/.git/w.obj"]));
        assert_eq!(found("*.stl"), paths(&[]));
        assert!(!is_pattern(&root.path().join("u.ply")));
        assert!(matches(&root.path().join("a/[")).unwrap_err().contains("invalid pattern"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn names_and_patterns_need_not_be_text() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt as _;
        let root = tempfile::tempdir().unwrap();
        let name = Path::new(OsStr::from_bytes(b"st\xfchle.obj"));
        fs::write(root.path().join(name), "").unwrap();
        assert_eq!(found(root.path(), "*.obj"), [name]);
        assert_eq!(found(root.path(), OsStr::from_bytes(b"st\xfch*.obj")), [name]);
    }
}
