//! Names of jobs, which are the names of their folders.
//!
//! A job is named after its file without the extension. If several files would share a name (even
//! if only by case, which is the same folder on some systems), all of them also get their
//! extension, and then as many parent folders as needed: `chair`, `chair.obj`, `old-chair.obj`.
//! Names depend on which files are given, but not on their order.

use std::collections::{HashMap, HashSet};
use std::path::{Component, Path, PathBuf};

use super::fingerprint::fingerprint;

/// Longest part of a name, in bytes: file systems take 255, and something may be
/// added.
const LONGEST: usize = 120;

/// What a job's name is made from.
#[derive(Debug, Clone)]
pub(super) struct Origin<'a> {
    pub(super) input: &'a Path,
    /// A name that was given to it, with `/` between its parts.
    pub(super) given: Option<&'a str>,
    /// What tells it from other jobs on the same input: settings of its own.
    pub(super) settings: String,
}

/// A name for each, all different, and safe on any file system.
pub(super) fn names(origins: &[Origin<'_>]) -> Vec<String> {
    let by_input = input_names(origins);
    let taken = |name: &str| name.to_lowercase();
    let mut count: HashMap<String, usize> = HashMap::new();
    by_input.iter().for_each(|name| *count.entry(taken(name)).or_default() += 1);
    let mut used = HashSet::new();
    let mut names = Vec::new();
    for (origin, name) in origins.iter().zip(by_input) {
        // Several jobs on one input are told apart by their settings.
        let name = match count[&taken(&name)] {
            1 => name,
            _ if origin.settings.is_empty() || origin.given.is_some() => name,
            _ => format!("{name}/{}", safe(&origin.settings)),
        };
        let mut unique = name.clone();
        for number in 2.. {
            if used.insert(taken(&unique)) {
                break;
            }
            unique = format!("{name}-{number}");
        }
        names.push(unique);
    }
    names
}

/// The names as far as the inputs give them: the same for the same input.
fn input_names(origins: &[Origin<'_>]) -> Vec<String> {
    let inputs: Vec<&Path> = {
        let mut seen = HashSet::new();
        origins.iter().filter(|o| o.given.is_none()).map(|o| o.input).filter(|i| seen.insert(*i)).collect()
    };
    let given: HashSet<String> =
        origins.iter().filter_map(|o| o.given).map(|name| nested(name).to_lowercase()).collect();
    let mut detail = vec![0; inputs.len()];
    let mut names: Vec<String> = inputs.iter().map(|input| called(input, 0)).collect();
    loop {
        let mut count: HashMap<String, usize> = HashMap::new();
        names.iter().for_each(|name| *count.entry(name.to_lowercase()).or_default() += 1);
        let mut changed = false;
        for (at, input) in inputs.iter().enumerate() {
            let name = names[at].to_lowercase();
            if (count[&name] > 1 || given.contains(&name)) && detail[at] < most_detail(input) {
                detail[at] += 1;
                names[at] = called(input, detail[at]);
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    let by_input: HashMap<&Path, &String> = inputs.iter().copied().zip(&names).collect();
    origins
        .iter()
        .map(|origin| match origin.given {
            Some(name) => nested(name),
            None => by_input.get(origin.input).map_or_else(String::new, |name| (*name).clone()),
        })
        .collect()
}

/// What a path is called: 0 is the stem, 1 the file's name, more take folders.
fn called(path: &Path, detail: usize) -> String {
    let file = PathBuf::from(path.file_name().unwrap_or(path.as_os_str()));
    if detail == 0 {
        return safe(&file.file_stem().unwrap_or(file.as_os_str()).to_string_lossy());
    }
    let mut parts: Vec<_> = folders(path).take(detail - 1).collect();
    parts.reverse();
    parts.push(file.to_string_lossy().into_owned());
    safe(&parts.join("-"))
}

fn most_detail(path: &Path) -> usize {
    folders(path).count() + 1
}

/// The names of the folders of a path, the innermost first.
fn folders(path: &Path) -> impl Iterator<Item = String> {
    path.components().rev().skip(1).filter_map(|part| match part {
        Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
        _ => None,
    })
}

/// A given name as a path below the folder of all results.
pub(super) fn nested(name: &str) -> String {
    let parts: Vec<String> =
        name.split(['/', '\\']).filter(|part| !part.trim().is_empty()).map(safe).collect();
    if parts.is_empty() { safe("") } else { parts.join("/") }
}

/// A name that any file system takes, as close to the text as can be.
pub(super) fn safe(text: &str) -> String {
    let mut name: String = text
        .chars()
        .map(|c| if c.is_control() || r#"/\:*?"<>|"#.contains(c) { '_' } else { c })
        .collect::<String>()
        // Windows drops these; a dot in front hides a folder elsewhere.
        .trim_start_matches(|c: char| c == '.' || c.is_whitespace())
        .trim_end_matches(|c: char| c == '.' || c.is_whitespace())
        .to_owned();
    if name.is_empty() {
        name = "shape".to_owned();
    }
    let first = name.split('.').next().unwrap_or_default().to_uppercase();
    let is_device = ["CON", "PRN", "AUX", "NUL"].contains(&first.as_str())
        || ["COM", "LPT"].iter().any(|device| {
            first.strip_prefix(device).is_some_and(|n| n.len() == 1 && n.chars().all(|c| c.is_ascii_digit()))
        });
    // Names that the folder of all results needs for itself.
    let is_table = first == "RESULTS" && name.contains('.');
    if is_device || is_table {
        name.insert(0, '_');
    }
    if name.len() > LONGEST {
        let mark = fingerprint(&[name.as_bytes()]);
        let end = (0..=LONGEST - mark.len() - 1).rev().find(|&i| name.is_char_boundary(i)).unwrap_or(0);
        name = format!("{}-{mark}", &name[..end]);
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(paths: &[&str]) -> Vec<String> {
        let origins: Vec<Origin<'_>> = paths
            .iter()
            .map(|path| Origin { input: Path::new(*path), given: None, settings: String::new() })
            .collect();
        names(&origins)
    }

    #[test]
    fn names_are_as_short_as_they_can_be() {
        assert_eq!(of(&["a/chair.obj", "b/table.ply"]), ["chair", "table"]);
        assert_eq!(of(&["chair.obj", "chair.ply", "Table.ply"]), ["chair.obj", "chair.ply", "Table"]);
        assert_eq!(of(&["a/chair.obj", "b/chair.obj"]), ["a-chair.obj", "b-chair.obj"]);
        assert_eq!(of(&["x/a/chair.obj", "y/a/chair.obj"]), ["x-a-chair.obj", "y-a-chair.obj"]);
        // The same folder on some systems.
        assert_eq!(of(&["Chair.obj", "chair.ply"]), ["Chair.obj", "chair.ply"]);
        // One that has no more folders to take.
        assert_eq!(of(&["chair.obj", "b/chair.obj"]), ["chair.obj", "b-chair.obj"]);
        // The order doesn't matter.
        assert_eq!(of(&["b/chair.obj", "chair.obj"]), ["b-chair.obj", "chair.obj"]);
        assert_eq!(of(&["../chair.obj", "chair.obj"]), ["chair.obj", "chair.obj-2"]);
        assert_eq!(of(&["стул.obj", "椅子 1.ply"]), ["стул", "椅子 1"]);
    }

    #[test]
    fn jobs_on_one_input_are_told_apart_by_their_settings() {
        let origin = |path, given, settings: &str| Origin {
            input: Path::new(path),
            given,
            settings: settings.to_owned(),
        };
        let found = names(&[
            origin("chair.obj", None, "alpha=0.1"),
            origin("chair.obj", None, "alpha=2,p0=1"),
            origin("chair.obj", None, ""),
            origin("chair.obj", None, "alpha=0.1"),
            origin("table.obj", None, "alpha=0.1"),
            origin("x.obj", Some("table"), ""),
            origin("x.obj", Some("group/one: two"), "seed=3"),
        ]);
        assert_eq!(
            found,
            [
                "chair/alpha=0.1",
                "chair/alpha=2,p0=1",
                "chair",
                "chair/alpha=0.1-2",
                "table.obj",
                "table",
                "group/one_ two"
            ]
        );
    }

    #[test]
    fn names_are_safe_everywhere() {
        for (text, expected) in [
            ("a/b\\c:d*e?f\"g<h>i|j\u{7}", "a_b_c_d_e_f_g_h_i_j_"),
            ("..", "shape"),
            ("", "shape"),
            (".hidden. ", "hidden"),
            ("con", "_con"),
            ("COM1.tar", "_COM1.tar"),
            ("common", "common"),
            ("results.csv", "_results.csv"),
            ("results", "results"),
            ("α=0.5,p0=1", "α=0.5,p0=1"),
        ] {
            assert_eq!(safe(text), expected);
        }
        let (one, other) = (safe(&"椅".repeat(100)), safe(&("椅".repeat(99) + "x")));
        assert!(one.len() <= LONGEST && other.len() <= LONGEST && one != other, "{one} {other}");
        assert_eq!(nested("/a/../b/"), "a/shape/b");
    }
}
