//! The program as a process.
#![allow(dead_code)] // Each test file uses its part.

use std::path::Path;
use std::process::{Command, Output};

/// The program in `folder`, where there is no display.
pub(crate) fn program(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_superform"));
    command.args(args).current_dir(folder);
    // Drivers must not complain of the last two.
    for name in
        ["RUST_LOG", "DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET", "XDG_RUNTIME_DIR", "NODEVICE_SELECT"]
    {
        command.env_remove(name);
    }
    command
}

/// Runs the program in `folder`.
pub(crate) fn superform(folder: &Path, args: &[&str]) -> Output {
    program(folder, args).output().unwrap()
}

/// Runs it, and it must go well; gives what it says.
pub(crate) fn done(folder: &Path, args: &[&str]) -> (String, String) {
    let output = superform(folder, args);
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    (text(&output.stdout), text(&output.stderr))
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

pub(crate) fn stderr(output: &Output) -> String {
    text(&output.stderr)
}
