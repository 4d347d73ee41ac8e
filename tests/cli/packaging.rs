//! What is installed on Linux: the program, its menu entry, icon, file types,
//! completions and manual pages.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/linux")
}

fn install(arguments: &[&str]) -> Output {
    Command::new(assets().join("install.sh")).args(arguments).output().unwrap()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut waiting = vec![folder.to_owned()];
    while let Some(folder) = waiting.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { waiting.push(path) } else { found.push(path) }
        }
    }
    found
}

#[test]
fn it_is_installed_and_taken_away_again() {
    let folder = tempfile::tempdir().unwrap();
    let prefix = folder.path().join("a prefix");
    let arguments = [prefix.to_str().unwrap(), env!("CARGO_BIN_EXE_superform")];
    let output = install(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for (file, part) in [
        ("share/applications/superform.desktop", "Exec=superform %f"),
        ("share/mime/packages/superform.xml", "*.superform"),
        ("share/icons/hicolor/scalable/apps/superform.svg", "<svg"),
        ("share/bash-completion/completions/superform", "complete"),
        ("share/zsh/site-functions/_superform", "#compdef superform"),
        ("share/fish/vendor_completions.d/superform.fish", "complete -c superform"),
        ("share/man/man1/superform.1", ".TH superform 1"),
        ("share/man/man1/superform-run.1", ".TH superform-run 1"),
    ] {
        let text = fs::read_to_string(prefix.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(text.contains(part), "{file} has no {part}");
    }
    let version = Command::new(prefix.join("bin/superform")).arg("--version").output().unwrap();
    assert!(String::from_utf8_lossy(&version.stdout).starts_with("superform "));
    let output = install(&["--remove", prefix.to_str().unwrap()]);
    assert!(output.status.success());
    // What the desktop's own programs have made of it is theirs.
    let left: Vec<_> =
        files(&prefix).into_iter().filter(|path| path.to_string_lossy().contains("superform")).collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn without_a_program_it_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let output = install(&[folder.path().to_str().unwrap(), "/nowhere/superform"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cargo build --release"));
    assert!(files(folder.path()).is_empty());
}

#[test]
fn the_menu_entry_opens_what_the_types_are_defined_for() {
    let text = fs::read_to_string(assets().join("superform.desktop")).unwrap();
    let entry: HashMap<&str, &str> = text.lines().filter_map(|line| line.split_once('=')).collect();
    assert!(text.starts_with("[Desktop Entry]\n"));
    for key in ["Type", "Name", "Exec", "Icon", "Categories", "MimeType"] {
        assert!(entry.contains_key(key), "no {key}");
    }
    let types = fs::read_to_string(assets().join("superform.xml")).unwrap();
    // Those that freedesktop.org's own list has.
    let known = ["model/obj", "model/stl", "model/gltf+json", "model/gltf-binary"];
    for kind in entry["MimeType"].split_terminator(';') {
        assert!(
            known.contains(&kind) || types.contains(&format!("type=\"{kind}\"")),
            "{kind} is not defined"
        );
    }
}
