//! Expands names, patterns and folders to input files.

use std::collections::HashSet;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::rows::is_table;
use super::staging::RECORD_FILE;
use crate::cli::patterns::{is_pattern, matches};
use crate::io;

/// Number of bytes examined to decide whether a text file in a folder is a cloud.
const LOOKED_AT: u64 = 8192;

/// Whether this is the name of a single file, not a pattern or folder.
pub(in crate::cli) fn is_one_file(given: &Path) -> bool {
    !given.is_dir() && !is_pattern(given)
}

/// The files that are meant, in the order of what was given, each once. A
/// folder stands for the shapes in it, by name, and with `recursive` for those
/// below, too; a pattern for what it matches. What lies in `output` by an
/// earlier run is no shape. Files that are not there are taken all the same:
/// they fail when it is their turn.
///
/// # Errors
/// Where a pattern matches nothing, or a folder has no shape.
pub(super) fn expand(given: &[PathBuf], recursive: bool, output: &Path) -> Result<Vec<PathBuf>, String> {
    let mut listing = Listing { recursive, output, found: Vec::new() };
    for path in given {
        if is_pattern(path) {
            listing.matches(path)?;
        } else if path.is_dir() {
            let before = listing.found.len();
            listing.folder(path)?;
            if listing.found.len() == before {
                let deeper = if recursive { "" } else { ", or add --recursive to include subfolders" };
                return Err(format!(
                    "no shapes in the folder {}; choose another one{deeper}",
                    path.display()
                ));
            }
        } else {
            listing.found.push(path.clone());
        }
    }
    // One file may be meant twice: by its name, and by a pattern.
    let mut seen = HashSet::new();
    listing.found.retain(|path| seen.insert(fs::canonicalize(path).unwrap_or_else(|_| path.clone())));
    Ok(listing.found)
}

#[derive(Debug)]
struct Listing<'a> {
    recursive: bool,
    output: &'a Path,
    found: Vec<PathBuf>,
}

impl Listing<'_> {
    fn matches(&mut self, pattern: &Path) -> Result<(), String> {
        let before = self.found.len();
        for path in matches(pattern)? {
            if path.is_dir() {
                self.folder(&path)?;
            } else {
                self.found.push(path);
            }
        }
        if self.found.len() == before {
            let shown = pattern.display();
            return Err(format!("the pattern {shown} matches no shapes; check the folder and the ending"));
        }
        Ok(())
    }

    fn folder(&mut self, folder: &Path) -> Result<(), String> {
        let failed = |e: std::io::Error| format!("cannot list the folder {}: {e}", folder.display());
        let mut entries: Vec<PathBuf> = Vec::new();
        for entry in fs::read_dir(folder).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            if !entry.file_name().as_encoded_bytes().starts_with(b".") {
                entries.push(entry.path());
            }
        }
        entries.sort();
        let is_output = same(folder, self.output);
        for path in &entries {
            if path.is_file() && is_shape(path) && !(is_output && is_table(path)) {
                self.found.push(path.clone());
            }
        }
        // Links to folders are not followed: they may lead in circles.
        let is_folder = |path: &Path| fs::symlink_metadata(path).is_ok_and(|about| about.is_dir());
        let recursive = self.recursive;
        for path in entries.iter().filter(|path| recursive && is_folder(path)) {
            if !same(path, self.output) && !path.join(RECORD_FILE).exists() {
                self.folder(path)?;
            }
        }
        Ok(())
    }
}

fn same(a: &Path, b: &Path) -> bool {
    matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}

/// Whether a file in a folder counts as a shape: by its extension; text files
/// and tables only if they contain points.
fn is_shape(path: &Path) -> bool {
    let is_text =
        path.extension().is_some_and(|e| e.eq_ignore_ascii_case("txt") || e.eq_ignore_ascii_case("csv"));
    io::has_shape_ending(path) && (!is_text || holds_points(path))
}

/// Whether one of the first lines starts with two numbers.
fn holds_points(path: &Path) -> bool {
    let mut bytes = Vec::new();
    // A file that can't be read is taken: then it is told why.
    if fs::File::open(path).and_then(|file| file.take(LOOKED_AT).read_to_end(&mut bytes)).is_err() {
        return true;
    }
    if bytes.is_empty() || bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return true;
    }
    let text = String::from_utf8_lossy(&bytes);
    text.lines().any(|line| {
        let mut fields = line
            .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .map(|field| field.trim_matches('"'))
            .filter(|field| !field.is_empty());
        let mut number = || fields.next().is_some_and(|field| field.parse::<f64>().is_ok());
        number() && number()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(folder: &Path, name: &str, content: &str) {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    fn names(folder: &Path, found: &[PathBuf]) -> Vec<String> {
        let name = |path: &PathBuf| path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/");
        found.iter().map(name).collect()
    }

    #[test]
    fn folders_and_patterns_stand_for_their_shapes() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        for name in
            ["b.obj", "a.ply", "notes.md", ".hidden.obj", "deep/c.stl", "deep/deeper/d.OFF", "[x].obj"]
        {
            touch(folder, name, "");
        }
        touch(folder, "sources.csv", "file,licence\na.ply,CC0\n");
        touch(folder, "points.csv", "x,y,z\n1,2,3\n");
        let expand = |given: &[&str], recursive| {
            let given: Vec<PathBuf> = given.iter().map(|g| folder.join(g)).collect();
            expand(&given, recursive, &folder.join("out")).map(|found| names(folder, &found))
        };
        assert_eq!(expand(&[""], false).unwrap(), ["[x].obj", "a.ply", "b.obj", "points.csv"]);
        assert_eq!(
            expand(&[""], true).unwrap(),
            ["[x].obj", "a.ply", "b.obj", "points.csv", "deep/c.stl", "deep/deeper/d.OFF"]
        );
        assert_eq!(expand(&["*.obj"], false).unwrap(), ["[x].obj", "b.obj"]);
        // A file of that name goes before a pattern; what is not there is kept.
        assert_eq!(expand(&["[x].obj", "gone.ply"], false).unwrap(), ["[x].obj", "gone.ply"]);
        // Each once, in the order in which it was given.
        assert_eq!(expand(&["b.obj", "*.obj", "./b.obj"], false).unwrap(), ["b.obj", "[x].obj"]);
        assert_eq!(expand(&["**/*.stl"], false).unwrap(), ["deep/c.stl"]);
        for (given, words) in [("*.xyz", "*.xyz matches no shapes"), ("deep/deeper/[", "invalid pattern")] {
            let problem = expand(&[given], false).unwrap_err();
            assert!(problem.contains(words), "{problem}");
        }
        touch(folder, "empty/readme", "");
        assert!(expand(&["empty"], false).unwrap_err().contains("no shapes in the folder"));
    }

    #[test]
    fn results_of_earlier_runs_are_no_shapes() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        touch(folder, "a.xyz", "1 2 3\n");
        touch(folder, "results.csv", "job,name\n1,2\n");
        touch(folder, "results.0-of-2.csv", "job,name\n1,2\n");
        touch(folder, "a/segmented.ply", "");
        touch(folder, "a/job.json", "{}");
        touch(folder, "out/b/segmented.ply", "");
        let here = [folder.to_owned()];
        assert_eq!(names(folder, &expand(&here, true, folder).unwrap()), ["a.xyz", "out/b/segmented.ply"]);
        let found = expand(&here, true, &folder.join("out")).unwrap();
        assert_eq!(names(folder, &found), ["a.xyz", "results.0-of-2.csv", "results.csv"]);
    }
}
