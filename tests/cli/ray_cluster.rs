//! The example for Ray keeps its promises: see `examples/ray/test_ray.py`.
//!
//! Needs Linux and a Python with ray (`SUPERFORM_PYTHON`, or `python3`). Where
//! that is missing it says so and is skipped, or fails if
//! SUPERFORM_REQUIRE_PYTHON=1.

use std::path::Path;
use std::process::Command;

use crate::needs::lacking;

#[test]
fn killing_a_worker_loses_nothing() {
    let python = std::env::var("SUPERFORM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let has_ray =
        Command::new(&python).args(["-c", "import ray"]).output().is_ok_and(|output| output.status.success());
    if !(cfg!(target_os = "linux") && has_ray) {
        let why = format!("{python} has no ray (pip install ray), or this is not Linux");
        return lacking("SUPERFORM_REQUIRE_PYTHON", why);
    }
    let test = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/ray/test_ray.py");
    let output =
        Command::new(&python).arg(test).env("SUPERFORM", env!("CARGO_BIN_EXE_superform")).output().unwrap();
    let [said, errors] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success(), "{said}\n{errors}");
}
