//! The results to render, and their names.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::cli::patterns::{is_pattern, matches};
use crate::io;

/// Something to take a picture of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) path: PathBuf,
    /// For people: of a batch's job its path below the batch's folder.
    pub(super) title: String,
    /// For files: unlike all others, also where upper and lower case are one.
    pub(super) name: String,
}

/// The results that are meant, in the order of what was given, each once. A
/// folder stands for itself, if it holds primitives, and for all below it that
/// do; where none does, for the shapes and sessions in it.
///
/// # Errors
/// Where there is nothing in a folder, or nothing that a pattern matches.
pub(super) fn expand(given: &[PathBuf]) -> Result<Vec<Entry>, String> {
    let mut found: Vec<(PathBuf, String)> = Vec::new();
    for path in given {
        if !is_pattern(path) {
            meant(path, &mut found)?;
            continue;
        }
        let before = found.len();
        for path in matches(path)? {
            meant(&path, &mut found)?;
        }
        if found.len() == before {
            return Err(format!("the pattern {} matches nothing; check the folder", path.display()));
        }
    }
    let mut seen = HashSet::new();
    found.retain(|(path, _)| seen.insert(fs::canonicalize(path).unwrap_or_else(|_| path.clone())));
    Ok(named(found))
}

/// Adds what a path stands for. A file that is not there is taken all the same:
/// it fails when it is its turn.
fn meant(path: &Path, found: &mut Vec<(PathBuf, String)>) -> Result<(), String> {
    if !path.is_dir() {
        found.push((path.to_owned(), title_of(path)));
        return Ok(());
    }
    let before = found.len();
    if io::holds_primitives(path) {
        found.push((path.to_owned(), folder_name(path)));
    }
    below(path, "", found)?;
    if found.len() > before {
        return Ok(());
    }
    let is_meant = |path: &Path| {
        path.is_file() && (io::has_session_ending(path) || io::has_shape_ending(path)) && !is_table(path)
    };
    let shapes = entries(path)?.into_iter().filter(|path| is_meant(path));
    found.extend(shapes.map(|path| (path.clone(), title_of(&path))));
    if found.len() == before {
        return Err(format!(
            "neither a result nor a shape in the folder {}; give the folder of a run or a batch",
            path.display()
        ));
    }
    Ok(())
}

/// Adds the folders below that hold a result.
fn below(folder: &Path, title: &str, found: &mut Vec<(PathBuf, String)>) -> Result<(), String> {
    for path in entries(folder)? {
        // Links to folders are not followed: they may lead in circles.
        if !fs::symlink_metadata(&path).is_ok_and(|about| about.is_dir()) {
            continue;
        }
        let own = path.file_name().unwrap_or_default().to_string_lossy();
        let title = if title.is_empty() { own.into_owned() } else { format!("{title}/{own}") };
        if io::holds_primitives(&path) {
            found.push((path.clone(), title.clone()));
        }
        below(&path, &title, found)?;
    }
    Ok(())
}

/// What is in a folder, by name, without what is hidden.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let failed = |e: std::io::Error| format!("cannot list the folder {}: {e}", folder.display());
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        if !entry.file_name().as_encoded_bytes().starts_with(b".") {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

/// Whether a file is a batch's table.
fn is_table(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("results."))
}

/// The name of a file without its ending; of a run's own files that of its folder.
fn title_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    match path.parent() {
        Some(folder) if ["primitives", "segmented"].contains(&stem.as_str()) => match folder_name(folder) {
            name if name.is_empty() => stem,
            name => name,
        },
        _ => stem,
    }
}

/// Also of `.` and `..`.
fn folder_name(folder: &Path) -> String {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let whole = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    whole.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Gives each a name for files. Where several would share one, files take their
/// endings, too, and then numbers.
fn named(found: Vec<(PathBuf, String)>) -> Vec<Entry> {
    let mut count: HashMap<String, usize> = HashMap::new();
    found.iter().for_each(|(_, title)| *count.entry(title.to_lowercase()).or_default() += 1);
    let mut used = HashSet::new();
    let mut entries = Vec::new();
    for (path, title) in found {
        let is_shared = count[&title.to_lowercase()] > 1;
        let whole = path.file_name().filter(|_| is_shared && path.is_file());
        let title = whole.map_or(title, |name| name.to_string_lossy().into_owned());
        let plain = title.replace(['/', '\\'], "-");
        let plain = if plain.is_empty() { "picture".to_owned() } else { plain };
        let mut name = plain.clone();
        for number in 2.. {
            if used.insert(name.to_lowercase()) {
                break;
            }
            name = format!("{plain}-{number}");
        }
        entries.push(Entry { path, title, name });
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(folder: &Path, name: &str) {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, "").unwrap();
    }

    fn names(given: &[PathBuf]) -> Vec<String> {
        expand(given).unwrap().into_iter().map(|entry| entry.name).collect()
    }

    #[test]
    fn folders_stand_for_their_results_or_for_their_shapes() {
        let temporary = tempfile::tempdir().unwrap();
        let at = |name: &str| temporary.path().join(name);
        for name in [
            "batch/chair/primitives.json",
            "batch/chair/segmented.ply",
            "batch/lamp/alpha=1/primitives.json",
            "batch/lamp/alpha=2/primitives.npz",
            "batch/.superform/half/primitives.json",
            "batch/results.csv",
            "batch/failed/report.json",
            "shapes/b.obj",
            "shapes/a.superform",
            "shapes/notes.md",
            "shapes/results.csv",
            "nothing/notes.md",
        ] {
            touch(temporary.path(), name);
        }
        assert_eq!(names(&[at("batch")]), ["chair", "lamp-alpha=1", "lamp-alpha=2"]);
        let entries = expand(&[at("batch")]).unwrap();
        assert_eq!(entries[1].title, "lamp/alpha=1");
        assert_eq!(names(&[at("batch/chair")]), ["chair"]);
        assert_eq!(names(&[at("batch/chair/primitives.json")]), ["chair"]);
        assert_eq!(names(&[at("shapes")]), ["a", "b"]);
        assert_eq!(names(&[at("batch/lamp/*"), at("batch/chair")]), ["alpha=1", "alpha=2", "chair"]);
        // What is given twice is taken once.
        assert_eq!(names(&[at("batch/chair"), at("batch")]), ["chair", "lamp-alpha=1", "lamp-alpha=2"]);
        let problem = expand(&[at("nothing")]).unwrap_err();
        assert!(problem.contains("neither a result nor a shape"), "{problem}");
        assert!(expand(&[at("shapes/*.stl")]).unwrap_err().contains("matches nothing"));
    }

    #[test]
    fn names_differ() {
        let found = ["a/x.obj", "a/X.ply", "b/y.obj", "c/y.obj"].map(PathBuf::from);
        let temporary = tempfile::tempdir().unwrap();
        let given: Vec<PathBuf> = found.iter().map(|path| temporary.path().join(path)).collect();
        for path in &given {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        assert_eq!(names(&given), ["x.obj", "X.ply", "y.obj", "y.obj-2"]);
        assert_eq!(names(&["missing.ply".into()]), ["missing"]);
    }
}
