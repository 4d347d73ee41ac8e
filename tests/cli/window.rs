//! The real program with its real window, on a virtual display where there is
//! no other.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc::channel;
use std::time::Duration;

use crate::needs::lacking;

/// A software driver on a busy machine draws slowly.
const PATIENCE: Duration = Duration::from_secs(300);

/// A display of our own, gone when dropped.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// Starts Xvfb on a free number; `None` if it isn't installed.
    fn start() -> Option<Self> {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1600x1000x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut number = String::new();
        BufReader::new(server.stdout.take()?).read_line(&mut number).ok()?;
        Some(Self { server, name: format!(":{}", number.trim()) })
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Runs the program on a display; `None` (and a word on why) where there is
/// none or it can't draw.
fn superform(arguments: &[&str]) -> Option<Output> {
    let given = std::env::var("DISPLAY").ok().filter(|d| !d.is_empty());
    let own = if given.is_none() { Display::start() } else { None };
    let Some(display) = given.or_else(|| own.as_ref().map(|d| d.name.clone())) else {
        lacking("SUPERFORM_REQUIRE_GPU", "there is neither a display nor Xvfb");
        return None;
    };
    let runtime = tempfile::tempdir().unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_superform"))
        .args(arguments)
        .env("DISPLAY", display)
        .env_remove("WAYLAND_DISPLAY")
        .env("XDG_RUNTIME_DIR", runtime.path())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let id = child.id();
    let (sender, receiver) = channel();
    std::thread::spawn(move || sender.send(child.wait_with_output()));
    let Ok(output) = receiver.recv_timeout(PATIENCE) else {
        let _ = Command::new("kill").arg(id.to_string()).status();
        panic!("the window did not close in {PATIENCE:?}");
    };
    let output = output.unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if !output.status.success() && said.contains("cannot open the window") {
        lacking("SUPERFORM_REQUIRE_GPU", said);
        return None;
    }
    Some(output)
}

#[test]
fn the_window_opens_runs_and_is_photographed() {
    let folder = tempfile::tempdir().unwrap();
    let shot = folder.path().join("shot.png");
    let arguments = ["--points", "600", "--iterations", "4", "--clusters", "10", "--screenshot"];
    let Some(output) = superform(&[&arguments[..], &[shot.to_str().unwrap()]].concat()) else { return };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let picture = image::open(&shot).unwrap().to_rgba8();
    assert_eq!(picture.dimensions(), (1440, 900));
    // The panels are of one colour, the 3D view in their midst is not: the shape is in it.
    let colors: std::collections::HashSet<[u8; 4]> = (400..1100)
        .flat_map(|x| (100..650).map(move |y| (x, y)))
        .map(|(x, y)| picture.get_pixel(x, y).0)
        .collect();
    assert!(colors.len() > 200, "the 3D view is blank: {} colours", colors.len());
    assert_eq!(left_over(folder.path()), ["shot.png"]);
}

#[test]
fn a_picture_of_a_broken_shape_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let shape = folder.path().join("broken.obj");
    std::fs::write(&shape, "f 1 2 3\n").unwrap();
    let shot = folder.path().join("shot.png");
    let Some(output) = superform(&[shape.to_str().unwrap(), "--screenshot", shot.to_str().unwrap()]) else {
        return;
    };
    assert!(!output.status.success());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("broken.obj"), "{said}");
    assert_eq!(left_over(folder.path()), ["broken.obj"]);
}

fn left_over(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}
