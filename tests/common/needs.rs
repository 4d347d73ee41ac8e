//! What some tests need and a machine may lack: a driver to draw with, a Python.
#![allow(dead_code)] // Each test binary uses its part.

use std::fmt::Display;
use std::io::Write as _;

/// Passes on what has been made with the graphics driver.
pub(crate) fn drawn<T, E: Display>(made: Result<T, E>) -> Option<T> {
    made.inspect_err(|why| lacking("SUPERFORM_REQUIRE_GPU", why)).ok()
}

/// Skips the calling test, or fails it if `variable` is 1.
pub(crate) fn lacking(variable: &str, why: impl Display) {
    assert!(std::env::var_os(variable).is_none_or(|v| v != "1"), "{variable}=1, but {why}");
    skipped(why);
}

/// Says that the calling test is skipped, or a part of it. It is not printed as
/// tests print, since the harness hides what tests that pass have printed.
pub(crate) fn skipped(why: impl Display) {
    let test = std::thread::current();
    let test = test.name().unwrap_or("a test");
    let _ = writeln!(std::io::stderr(), "skipped: {test}: {why}");
}
