//! Tells the program its version, with the commit that it was built from, and
//! the tests whether the shapes are there that some of them need.
#![allow(clippy::print_stdout)] // That is how a build script speaks.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let version = env!("CARGO_PKG_VERSION");
    let version = match commit() {
        Some(commit) => format!("{version} ({commit})"),
        None => version.to_owned(),
    };
    println!("cargo:rustc-env=SUPERFORM_VERSION={version}");
    look_for_test_shapes();
}

/// Sets `shared_data` where the folder of test shapes lies beside the
/// repository, or must: without it the tests that need it are ignored, and
/// listed as such. (Whether a file is there that was not is looked at only when
/// the variable changes: cargo would build anew each time that it is missing.)
fn look_for_test_shapes() {
    const REQUIRED: &str = "SUPERFORM_REQUIRE_DATA";
    const TABLE: &str = "../shared/data/SOURCES.csv";
    println!("cargo:rustc-check-cfg=cfg(shared_data)");
    println!("cargo:rerun-if-env-changed={REQUIRED}");
    let is_there = Path::new(TABLE).exists();
    if is_there {
        println!("cargo:rerun-if-changed={TABLE}");
    }
    if is_there || std::env::var_os(REQUIRED).is_some_and(|v| v == "1") {
        println!("cargo:rustc-cfg=shared_data");
    }
}

/// The commit, where it is known: not in what was unpacked from a package, and
/// not while developing, where every commit would build the whole program anew.
fn commit() -> Option<String> {
    if std::env::var("PROFILE").as_deref() != Ok("release") || !Path::new(".git").exists() {
        return None;
    }
    // HEAD alone changes only when another branch is checked out.
    for name in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", name]).filter(|p| Path::new(p).exists()) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    let commit = git(&["rev-parse", "--short=10", "HEAD"])?;
    let is_changed = git(&["status", "--porcelain", "--untracked-files=no"]).is_some();
    Some(if is_changed { commit + ", changed" } else { commit })
}

/// What a git command says, if it says anything.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|o| o.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (!text.is_empty()).then_some(text)
}
