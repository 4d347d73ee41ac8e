//! The guide says what the program does: its list of keys is the program's own,
//! and what it shows and points to is there.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use superform::session::verb::{EVERYWHERE, Group, MOUSE, Verb};

/// Set, the list of keys is written instead of compared.
const WRITE: &str = "SUPERFORM_WRITE_DOCS";

fn guide() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide")
}

/// A text as a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// The keys of a verb, as a cell of a table.
fn keys_of(verb: Verb) -> String {
    let keys: Vec<String> = verb.shortcuts().map(|shortcut| format!("`{shortcut}`")).collect();
    cell(&keys.join(", "))
}

/// The page of keys and commands.
fn page() -> String {
    let mut page = String::from(
        "# Keys and commands\n\n\
         This page is generated from the program. In the program, `F1` shows the keys and `Ctrl+P` finds any \
         command by name, including those without a key. On macOS, Ctrl is the Command key.\n\n\
         A key shared by several commands runs whichever applies: `Space` runs or pauses.\n",
    );
    for group in Group::ALL {
        write!(page, "\n## {}\n\n| key | command | description |\n|---|---|---|\n", group.text()).unwrap();
        for verb in Verb::ALL.iter().filter(|verb| verb.entry().group == group) {
            let entry = verb.entry();
            let (text, tooltip) = (cell(entry.text), cell(entry.tooltip));
            writeln!(page, "| {} | {text} | {tooltip} |", keys_of(*verb)).unwrap();
        }
    }
    for (title, rows) in [("Mouse in the 3D view", MOUSE), ("Everywhere", EVERYWHERE)] {
        write!(page, "\n## {title}\n\n| input | action |\n|---|---|\n").unwrap();
        for (key, text) in rows {
            writeln!(page, "| {} | {} |", cell(key), cell(text)).unwrap();
        }
    }
    page
}

#[test]
fn the_list_of_keys_is_the_programs() {
    let path = guide().join("keys.md");
    if std::env::var_os(WRITE).is_some() {
        fs::write(&path, page()).unwrap();
        return;
    }
    // Some systems check text out with their own line ends.
    let written = fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    let differing = written.lines().zip(page().lines().map(str::to_owned)).find(|(a, b)| *a != b.as_str());
    assert!(
        written == page(),
        "{} is not what the program says (first difference: {differing:?}); {WRITE}=1 cargo test --test repository guide \
         writes it anew",
        path.display()
    );
}

/// What a page links to or shows: the text between `](` and `)`.
pub(crate) fn targets(page: &str) -> Vec<String> {
    page.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(to, _)| to.to_owned()).collect()
}

/// The name by which a heading is linked to.
fn anchor(heading: &str) -> String {
    let letters = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = letters.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn links_and_pictures_of_the_guide_are_there() {
    let mut shown = Vec::new();
    let mut pages = 0;
    for entry in fs::read_dir(guide()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "md") {
            continue;
        }
        pages += 1;
        let text = fs::read_to_string(&path).unwrap();
        for target in targets(&text).into_iter().filter(|target| !target.starts_with("http")) {
            let (file, part) = target.split_once('#').unwrap_or((&target, ""));
            let to = if file.is_empty() { path.clone() } else { guide().join(file) };
            assert!(to.is_file(), "{} points to {target}, which is not there", path.display());
            if !part.is_empty() {
                let there = fs::read_to_string(&to).unwrap();
                let mut headings = there.lines().filter(|line| line.starts_with('#')).map(anchor);
                assert!(headings.any(|heading| heading == part), "{} has no part {target}", path.display());
            }
            shown.push(fs::canonicalize(to).unwrap());
        }
    }
    assert!(pages > 5, "the guide has {pages} pages");
    // Nothing lies about that no page shows.
    for entry in fs::read_dir(guide().join("pictures")).into_iter().flatten() {
        let picture = fs::canonicalize(entry.unwrap().path()).unwrap();
        assert!(shown.contains(&picture), "no page shows {}", picture.display());
    }
}
