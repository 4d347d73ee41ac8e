//! `THIRD-PARTY.md` names every package that the program is built from.
//! `SUPERFORM_WRITE_DOCS=1 cargo test --test repository licences` writes it anew.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Our own packages: all others are other people's.
const OURS: [&str; 2] = ["superform", "superform-window-tests"];

fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Name and version of all packages in `Cargo.lock` but our own.
fn locked() -> BTreeSet<(String, String)> {
    let text = fs::read_to_string(repository().join("Cargo.lock")).unwrap();
    let value = |block: &str, key: &str| {
        let line = block.lines().find_map(|line| line.strip_prefix(key)).unwrap_or_default();
        line.trim_matches([' ', '=', '"']).to_owned()
    };
    let blocks = text.split("[[package]]").skip(1);
    let all = blocks.map(|block| (value(block, "name"), value(block, "version")));
    all.filter(|(name, _)| !OURS.contains(&name.as_str())).collect()
}

/// Name and version of all packages in the page's table.
fn listed(page: &str) -> BTreeSet<(String, String)> {
    page.lines()
        .filter_map(|line| line.strip_prefix("| "))
        .filter_map(|row| {
            let mut cells = row.split(" | ");
            Some((cells.next()?.to_owned(), cells.next()?.to_owned()))
        })
        .filter(|(_, version)| version.starts_with(|c: char| c.is_ascii_digit()))
        .collect()
}

#[test]
fn every_package_is_named() {
    let path = repository().join("THIRD-PARTY.md");
    if std::env::var("SUPERFORM_WRITE_DOCS").is_ok_and(|v| v == "1") {
        fs::write(&path, page()).unwrap();
    }
    let page = fs::read_to_string(&path).unwrap();
    let (locked, listed) = (locked(), listed(&page));
    assert!(locked.len() > 100, "only {} packages in Cargo.lock", locked.len());
    let missing: Vec<_> = locked.symmetric_difference(&listed).collect();
    assert!(
        missing.is_empty(),
        "Cargo.lock and THIRD-PARTY.md differ in {missing:?}; write it anew with \
         SUPERFORM_WRITE_DOCS=1 cargo test --test repository licences"
    );
}

/// The page from what cargo and the packages themselves say.
fn page() -> String {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--all-features"])
        .current_dir(repository())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let shipped = shipped(&metadata);
    let mut packages: Vec<&Value> = metadata["packages"].as_array().unwrap().iter().collect();
    packages.retain(|p| !OURS.contains(&p["name"].as_str().unwrap()));
    packages.sort_by_key(|p| (p["name"].as_str().unwrap(), p["version"].as_str().unwrap()));
    let mut table = String::new();
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in packages {
        let field = |name: &str| package[name].as_str().unwrap_or_default();
        let is_shipped = shipped.contains(field("id"));
        let role = if is_shipped { "program" } else { "tests" };
        let (name, version) = (field("name"), field("version"));
        let _ = writeln!(
            table,
            "| {name} | {version} | {} | {role} | {} |",
            field("license"),
            field("repository")
        );
        let folder = Path::new(field("manifest_path")).parent().unwrap();
        for text in if is_shipped { licence_texts(folder) } else { Vec::new() } {
            texts.entry(text).or_default().push(format!("{name} {version}"));
        }
    }
    let mut page = format!(
        "# Third-party software\n\n\
         Superform is built from the packages below, each under its own licence. Those for “tests” are\n\
         compiled for its tests and benchmarks only. What `cargo deny` allows is in `deny.toml`; the built-in\n\
         assets' licences are in [assets/README.md](assets/README.md).\n\n\
         | package | version | licence | used by | source |\n|---|---|---|---|---|\n{table}\n\
         # Licence texts\n\n\
         As they stand in the packages. Where a package gives a choice, the first of MIT, Zlib, BSD, ISC\n\
         and Apache 2.0 that it has is taken. Apache 2.0 itself is [LICENSE-APACHE](LICENSE-APACHE).\n"
    );
    for (text, packages) in texts {
        let _ = write!(page, "\n## {}\n\n", packages.join(", "));
        for line in text.lines() {
            let _ = writeln!(page, "    {line}");
        }
    }
    page
}

/// Ids of the packages that the program is made of, on any system.
fn shipped(metadata: &Value) -> BTreeSet<String> {
    let nodes: BTreeMap<&str, &Value> = metadata["resolve"]["nodes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|n| (n["id"].as_str().unwrap(), n))
        .collect();
    let root = metadata["resolve"]["root"].as_str().unwrap();
    let mut found = BTreeSet::new();
    let mut waiting = vec![root];
    while let Some(id) = waiting.pop() {
        for dependency in nodes[id]["deps"].as_array().unwrap() {
            let is_normal = dependency["dep_kinds"].as_array().unwrap().iter().any(|k| k["kind"].is_null());
            let next = dependency["pkg"].as_str().unwrap();
            if is_normal && found.insert(next.to_owned()) {
                waiting.push(next);
            }
        }
    }
    found
}

/// The texts of a package's licence, with even line ends.
fn licence_texts(folder: &Path) -> Vec<String> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            let name = path.file_name().unwrap().to_string_lossy().to_ascii_uppercase();
            path.is_file()
                && ["LICENSE", "LICENCE", "COPYING", "UNLICENSE"].iter().any(|n| name.starts_with(n))
        })
        .collect();
    files.sort();
    let like = |part: &str| {
        let with =
            |path: &&PathBuf| path.file_name().unwrap().to_string_lossy().to_ascii_uppercase().contains(part);
        files.iter().find(with).cloned()
    };
    let one = ["MIT", "ZLIB", "BSD", "ISC"].iter().find_map(|part| like(part));
    let read = |path: &PathBuf| {
        let text = String::from_utf8_lossy(&fs::read(path).unwrap()).replace("\r\n", "\n");
        text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n").trim().to_owned()
    };
    let chosen = match one {
        Some(path) => vec![path],
        None => files,
    };
    let is_apache =
        |text: &String| text.contains("Apache License") && text.contains("Version 2.0, January 2004");
    chosen.iter().map(read).filter(|text| !is_apache(text)).collect()
}
