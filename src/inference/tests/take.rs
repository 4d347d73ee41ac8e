//! Primitives from elsewhere as a state: shown as they are, and gone on from.

use std::sync::Arc;

use super::{check, gate, short};
use crate::geometry::{SampleCloud, Superquadric};
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::{Abstraction, Occurrence, Phase, Primitive, UNASSIGNED};
use crate::inference::runs::edit::Edit;
use crate::inference::runs::run::Run;

fn run(seed: u64, steps: usize) -> Run {
    let cloud = Arc::new(SampleCloud::from_points(&gate(600)));
    let params = crate::inference::params::Params { seed, ..short() };
    let mut run = Run::new(cloud, params, &Cancel::default()).unwrap();
    for _ in 0..steps {
        run.step(&Cancel::default()).unwrap();
    }
    run
}

fn listed(a: &Abstraction) -> Vec<(u32, Superquadric)> {
    a.primitives.iter().map(|p| (p.id, p.shape)).collect()
}

fn take(run: &mut Run, shapes: Vec<(u32, Superquadric)>) -> Result<Vec<Occurrence>, String> {
    let primitive =
        |(id, shape)| Primitive { id, shape, sigma: 0.0, points: 0, mean_distance: 0.0, locked: false };
    take_all(run, shapes.into_iter().map(primitive).collect(), Vec::new())
}

fn take_all(run: &mut Run, primitives: Vec<Primitive>, labels: Vec<u32>) -> Result<Vec<Occurrence>, String> {
    run.edit(&Edit::Take { primitives, labels }, &Cancel::default()).map_err(|e| e.to_string())
}

#[test]
fn labels_and_noise_that_are_known_are_kept() {
    let result = run(1, 4).abstraction();
    let mut second = run(2, 3);
    let mut primitives = result.primitives.to_vec();
    primitives[0].sigma = 0.0;
    take_all(&mut second, primitives.clone(), result.labels.to_vec()).unwrap();
    let taken = second.abstraction();
    check(&taken, result.labels.len());
    assert_eq!(taken.labels, result.labels);
    for (given, found) in primitives.iter().zip(taken.primitives.iter()) {
        assert_eq!(given.points, found.points);
        let kept = (given.sigma - found.sigma).abs() <= 1e-12 * given.sigma;
        assert_eq!(kept, given.sigma > 0.0, "what is not known is drawn: {found:?}");
    }
    assert!(taken.primitives[0].sigma > 0.0);
    // It goes on from there, and labels of another cloud are refused.
    second.resample(2).unwrap();
    second.step(&Cancel::default()).unwrap();
    let error = take_all(&mut second, primitives.clone(), vec![0; 3]).unwrap_err();
    assert!(error.contains("labels for 3 samples, but the cloud has 600"), "{error}");
    primitives[1].sigma = 1e300;
    assert!(take_all(&mut second, primitives, Vec::new()).unwrap_err().contains("σ of primitive"));
}

#[test]
fn a_result_that_is_taken_is_the_same_result() {
    let mut first = run(1, 0);
    while !first.is_finished() {
        first.step(&Cancel::default()).unwrap();
    }
    let result = first.abstraction();
    // Another run, elsewhere in its course, with other ids.
    let mut second = run(2, 3);
    let told = take(&mut second, listed(&result)).unwrap();
    assert_eq!(told, [Occurrence::Taken { primitives: result.primitives.len() }]);
    let taken = second.abstraction();
    check(&taken, result.labels.len());
    assert_eq!(taken.phase, Phase::Finished);
    for (a, b) in result.primitives.iter().zip(taken.primitives.iter()) {
        assert_eq!(a.id, b.id);
        assert!((a.shape.translation - b.shape.translation).norm() < 1e-12);
        assert!((a.shape.semi_axes - b.shape.semi_axes).norm() < 1e-12);
        assert_eq!(a.shape.exponents, b.shape.exponents);
    }
    // The refinement ends with the same rule for labels.
    let same = result.labels.iter().zip(taken.labels.iter()).filter(|(a, b)| a == b).count();
    assert!(same * 1000 >= 999 * result.labels.len(), "{same} of {} labels", result.labels.len());
}

#[test]
fn sampling_goes_on_from_what_was_taken() {
    let mut run = run(1, 3);
    let one = run.abstraction().primitives[0].clone();
    take(&mut run, vec![(77, one.shape)]).unwrap();
    assert!(run.abstraction().labels.iter().all(|l| [77, UNASSIGNED].contains(l)));
    run.resample(4).unwrap();
    while !run.is_finished() {
        run.step(&Cancel::default()).unwrap();
        check(&run.abstraction(), 600);
    }
    // Ids that were taken are not given out again.
    let ids: Vec<u32> = run.abstraction().primitives.iter().map(|p| p.id).collect();
    assert!(ids.iter().all(|id| *id >= 77), "{ids:?}");
}

#[test]
fn what_can_not_be_sampled_is_refused_and_nothing_changes() {
    let mut run = run(1, 3);
    let before = run.checkpoint();
    let good = run.abstraction().primitives[0].shape;
    let far = Superquadric { translation: good.translation.add_scalar(1e9), ..good };
    let flat = Superquadric { exponents: [0.0, 1.0], ..good };
    let odd = Superquadric { taper: [f64::NAN, 0.0], ..good };
    for (list, part) in [
        (vec![], "no primitives"),
        (vec![(3, good), (3, good)], "used twice"),
        (vec![(u32::MAX, good)], "too large"),
        (vec![(1, good), (2, far)], "primitive 2"),
        (vec![(5, flat)], "primitive 5"),
        (vec![(6, odd)], "primitive 6"),
    ] {
        let error = take(&mut run, list).unwrap_err();
        assert!(error.contains(part), "{error}");
        assert_eq!(run.checkpoint(), before);
    }
    let id = run.abstraction().primitives[0].id;
    run.edit(&Edit::Lock { id, locked: true }, &Cancel::default()).unwrap();
    assert!(take(&mut run, vec![(1, good)]).unwrap_err().contains("locked"));
}
