//! The program's main job on the real shapes of `tests/data/shapes`: read, run,
//! write; and the result is the shape, in about as many parts as it has.

use std::path::{Path, PathBuf};

use superform::geometry::metrics::{MetricOptions, evaluate};
use superform::io;

use super::batch_common::done;

/// Runs the shape as it is run by default. Its primitives must be as many as
/// `counts` allows, and `chamfer` off it on average at most, in longest edges.
fn assert_good(name: &str, counts: std::ops::RangeInclusive<usize>, chamfer: f64) {
    let shape: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/shapes").join(name);
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &["run", shape.to_str().unwrap(), "-o", "out", "--quiet"]);
    let stored = io::read_primitives(&folder.path().join("out")).unwrap();
    let shapes = stored.shapes();
    assert!(counts.contains(&shapes.len()), "{} primitives, not {counts:?}", shapes.len());
    let options = MetricOptions { samples: 20_000, volume_points: 1000, seed: 1 };
    let reference = io::reference(&io::read(&shape).unwrap(), &options).unwrap();
    let found = evaluate(&shapes, stored.unassigned_share(), &reference);
    assert!(found.chamfer_l1.unwrap() <= chamfer, "Chamfer-L1 {:?}, not {chamfer}", found.chamfer_l1);
    assert!(stored.unassigned_share().unwrap() <= 0.02, "{:?} unassigned", stored.unassigned_share());
    // The labels are of the primitives that were written.
    let segmented = io::read(&folder.path().join("out/segmented.ply")).unwrap();
    let labels = segmented.attributes.labels.unwrap();
    let known = |label: &i64| *label < 0 || stored.primitives.iter().any(|p| i64::from(p.id) == *label);
    assert!(labels.len() >= 1000 && labels.iter().all(known));
}

#[test]
fn a_bench_is_its_boards() {
    assert_good("bench.obj", 5..=16, 0.005);
}

#[test]
fn a_lamp_is_its_foot_arms_and_shade() {
    assert_good("lamp.obj", 5..=16, 0.006);
}

// Of a cloud, the distance is that between points, so that it is never small.

#[test]
fn a_scanned_bottle_is_a_few_round_parts() {
    assert_good("bottle.ply", 2..=8, 0.02);
}

#[test]
fn a_scanned_man_has_head_trunk_and_limbs() {
    assert_good("man.ply", 8..=26, 0.02);
}
