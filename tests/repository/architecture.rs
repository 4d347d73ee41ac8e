//! Who may depend on whom, as the table in `src/lib.rs` has it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Each module with those that it may use. `main.rs` may use all.
const ALLOWED: [(&str, &[&str]); 11] = [
    ("geometry", &[]),
    ("inference", &["geometry"]),
    ("io", &["geometry", "inference"]),
    ("worker", &["inference", "io", "geometry"]),
    ("session", &["worker", "inference", "io", "geometry"]),
    ("project", &["session", "worker", "inference", "io", "geometry"]),
    ("render", &["geometry"]),
    ("pictures", &["project", "session", "render", "worker", "inference", "io", "geometry"]),
    ("ui", &["pictures", "session", "render", "worker", "inference", "io", "geometry"]),
    ("cli", &["pictures", "session", "inference", "io", "worker", "geometry"]),
    (
        "app",
        &["ui", "pictures", "project", "session", "render", "worker", "inference", "io", "geometry", "cli"],
    ),
];

/// Crates that only some places may name, by the start of the path below src.
const CRATES: [(&[&str], &[&str]); 2] = [
    (&["egui", "eframe", "egui_wgpu", "egui_plot", "rfd"], &["app", "ui", "pictures/lettering"]),
    (&["wgpu"], &["app", "render", "ui/viewport"]),
];

/// The one file that writes to standard output, where what gets lost is noticed.
const STANDARD_OUTPUT: &str = "io/write/standard.rs";

/// All Rust files below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The code without comments and strings, so that only real paths are seen.
fn code(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let mut in_string = false;
        let mut before = ' ';
        let mut chars = line.chars().peekable();
        while let Some(c) = chars.next() {
            match c {
                '"' if before != '\\' && before != '\'' => in_string = !in_string,
                '/' if !in_string && chars.peek() == Some(&'/') => break,
                _ if !in_string => out.push(c),
                _ => {}
            }
            before = if c == '\\' && before == '\\' { ' ' } else { c };
        }
        out.push('\n');
    }
    out
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// First segments after each `crate::`, also of a group in braces.
fn modules_used(code: &str) -> BTreeSet<String> {
    let word = |text: &str| text.chars().take_while(|c| is_word(*c)).collect::<String>();
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].chars().next_back().is_some_and(is_word) {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        let Some(group) = rest.strip_prefix('{') else {
            found.insert(word(rest));
            continue;
        };
        let (mut depth, mut start) = (0, true);
        for (i, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => start = true,
                _ if start && is_word(c) => {
                    found.insert(word(&group[i..]));
                    start = false;
                }
                _ => {}
            }
        }
    }
    found
}

/// Crates that are named as the start of a path.
fn names_crate(code: &str, name: &str) -> bool {
    code.match_indices(name).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        let after = &code[at + name.len()..];
        let starts = !before.is_some_and(|c| is_word(c) || c == ':' || c == '.');
        let used = code[..at].trim_end().ends_with("use") && after.starts_with([';', ' ']);
        starts && (after.starts_with("::") || used)
    })
}

#[test]
fn modules_depend_only_on_what_the_table_allows() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    assert!(files.len() > 20, "only {} files below {}", files.len(), root.display());
    let mut faults = Vec::new();
    for path in files {
        let name = path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
        let module = name.split('/').next().unwrap().trim_end_matches(".rs");
        let code = code(&fs::read_to_string(&path).unwrap());
        for (crates, places) in CRATES {
            for used in crates.iter().filter(|c| names_crate(&code, c)) {
                if !places.iter().any(|p| name.starts_with(p)) {
                    faults.push(format!("{name} names {used}, which belongs to {places:?}"));
                }
            }
        }
        if name != STANDARD_OUTPUT {
            for way in ["stdout()", "print!(", "println!("] {
                if code.match_indices(way).any(|(at, _)| !code[..at].ends_with('e')) {
                    faults.push(format!("{name} uses {way}, which is for {STANDARD_OUTPUT}"));
                }
            }
        }
        if ["main", "lib"].contains(&module) {
            continue;
        }
        let Some((_, allowed)) = ALLOWED.iter().find(|(m, _)| *m == module) else {
            faults.push(format!("{name} is in no module of the table"));
            continue;
        };
        for used in modules_used(&code) {
            if used != module && !allowed.contains(&used.as_str()) {
                faults.push(format!("{name} uses crate::{used}, which {module} may not"));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn the_table_is_the_one_in_the_documentation() {
    let lib = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    for (module, _) in ALLOWED {
        let row = |line: &str| {
            let cell = line.trim_start_matches("//! |").split('|').next().unwrap_or_default();
            line.starts_with("//! |") && cell.trim().trim_matches(['`', '[', ']']) == module
        };
        assert!(lib.lines().any(row), "src/lib.rs has no row for {module}");
    }
}

#[test]
fn the_reader_of_paths_sees_what_there_is() {
    let text = r#"
use crate::geometry::{SampleCloud, TriMesh};
use crate::{io::{self, Shape}, worker};
fn f() { pub(crate) fn g() {} super::crate_name(); crate::session::x(); } // crate::app
const S: &str = "crate::ui";
"#;
    let found: Vec<String> = modules_used(&code(text)).into_iter().collect();
    assert_eq!(found, ["geometry", "io", "session", "worker"]);
    assert!(names_crate("use egui;", "egui") && names_crate("x: wgpu::Device", "wgpu"));
    assert!(!names_crate("egui_wgpu::Callback", "wgpu") && !names_crate("eframe::wgpu::Device", "wgpu"));
}
