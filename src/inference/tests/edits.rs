//! Changes by hand: each does what it says, whole or not at all.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use rand::RngExt;

use super::{cancelled_after, check, gate, rng, same_bits, short};
use crate::geometry::SampleCloud;
use crate::geometry::theta::Bounds;
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::data::abstraction::{Abstraction, Occurrence, Phase, UNASSIGNED};
use crate::inference::params::{Algorithm, MergeRule, Params};
use crate::inference::runs::edit::Edit;
use crate::inference::runs::run::Run;

fn never() -> Cancel {
    Cancel::default()
}

fn run_on(points: &[Point3<f64>], params: Params, steps: usize) -> Run {
    let mut run = Run::new(Arc::new(SampleCloud::from_points(points)), params, &never()).unwrap();
    for _ in 0..steps {
        run.step(&never()).unwrap();
    }
    run
}

fn edited(run: &mut Run, edit: &Edit) -> Vec<Occurrence> {
    run.edit(edit, &never()).unwrap()
}

/// What the edit is refused with; the state is as before.
fn refused(run: &mut Run, edit: &Edit) -> String {
    let before = run.checkpoint();
    let error = run.edit(edit, &never()).unwrap_err();
    assert_eq!(run.checkpoint(), before, "half an edit stayed");
    assert!(matches!(error, InferenceError::Edit(_) | InferenceError::Shape(_)));
    error.to_string()
}

fn samples_of(a: &Abstraction, id: u32) -> Vec<u32> {
    (0u32..).zip(a.labels.iter()).filter(|(_, l)| **l == id).map(|(i, _)| i).collect()
}

/// Ids from the one with most points to the one with fewest.
fn by_size(a: &Abstraction) -> Vec<u32> {
    let mut order: Vec<_> = a.primitives.iter().map(|p| (std::cmp::Reverse(p.points), p.id)).collect();
    order.sort_unstable();
    order.into_iter().map(|o| o.1).collect()
}

#[test]
fn a_shape_is_taken_as_given_and_a_refit_finds_back() {
    let points = gate(500);
    let mut run = run_on(&points, short(), 9);
    assert!(run.is_finished());
    let before = run.abstraction();
    let first = before.primitives[0].clone();
    let size = 2.0;
    let moved = first.shape.moved(&Vector3::new(0.05, 0.1, -0.05), &Vector3::new(0.05, 0.0, 0.1));
    let told = edited(&mut run, &Edit::SetShape { id: first.id, shape: moved });
    assert_eq!(told, [Occurrence::Edited { id: first.id }]);
    let after = run.abstraction();
    check(&after, points.len());
    assert_eq!((after.phase, &after.labels), (Phase::Finished, &before.labels));
    let shape = after.primitives[0].shape;
    assert!((shape.translation - moved.translation).norm() < 1e-12 * size);
    assert!((shape.semi_axes - moved.semi_axes).norm() < 1e-12 * size);
    assert!((shape.rotation.matrix() - moved.rotation.matrix()).norm() < 1e-12);
    assert!(after.primitives[0].mean_distance > 2.0 * first.mean_distance);
    // A finished run makes no step of its own.
    assert!(run.step(&never()).unwrap().is_empty());

    assert_eq!(edited(&mut run, &Edit::Refit { id: first.id }), [Occurrence::Refitted { id: first.id }]);
    let again = run.abstraction();
    assert!(again.primitives[0].mean_distance < 1.2 * first.mean_distance + 1e-3);
}

#[test]
fn shapes_out_of_their_limits_are_refused_in_words() {
    let mut run = run_on(&gate(400), short(), 1);
    let primitive = run.abstraction().primitives[0].clone();
    let (id, shape) = (primitive.id, primitive.shape);
    let mut broken = [shape; 7];
    broken[0].exponents[0] = 2.5;
    broken[1].exponents[1] = f64::NAN;
    broken[2].taper[1] = -1.0;
    broken[3].semi_axes.y = 0.5 * run.smallest_axis();
    broken[4].translation.x = f64::INFINITY;
    broken[5].semi_axes.x = 1e30;
    broken[6].rotation = nalgebra::Rotation3::from_matrix_unchecked(nalgebra::Matrix3::identity() * 2.0);
    let words = ["exponent 2.5", "exponent NaN", "taper", "semi-axis", "centre", "semi-axis", "rotation"];
    for (shape, word) in broken.into_iter().zip(words) {
        let text = refused(&mut run, &Edit::SetShape { id, shape });
        assert!(text.contains(word), "{text}");
    }
    // The limits themselves are within.
    let mut least = shape;
    least.semi_axes.y = run.smallest_axis();
    least.exponents = [Bounds::FITS.exponents.0, Bounds::FITS.exponents.1];
    least.taper = [Bounds::FITS.taper.1, Bounds::FITS.taper.0];
    edited(&mut run, &Edit::SetShape { id, shape: least });
}

#[test]
fn any_primitives_become_one() {
    let points = gate(500);
    for params in [short(), Params { clusters: 12, ..Params::paper() }] {
        let mut run = run_on(&points, params, 2);
        let before = run.abstraction();
        let ids = by_size(&before)[1..4].to_vec();
        let told = edited(&mut run, &Edit::Merge { ids: ids.clone() });
        let mut sorted = ids.clone();
        sorted.sort_unstable();
        assert_eq!(told, [Occurrence::Joined { ids: sorted, into: ids[0] }], "the largest one's id stays");
        let after = run.abstraction();
        check(&after, points.len());
        assert_eq!(after.primitives.len() + 2, before.primitives.len());
        for (old, new) in before.labels.iter().zip(after.labels.iter()) {
            assert_eq!(*new, if ids.contains(old) { ids[0] } else { *old });
        }
        // The sampler goes on from there.
        run.step(&never()).unwrap();
        check(&run.abstraction(), points.len());
    }
}

#[test]
fn a_primitive_over_two_parts_is_cut_between_them() {
    let points = gate(600);
    let mut run = run_on(&points, short(), 9);
    let ids = by_size(&run.abstraction());
    edited(&mut run, &Edit::Merge { ids });
    let one = run.abstraction();
    assert_eq!(one.primitives.len(), 1);
    let id = one.primitives[0].id;
    let told = edited(&mut run, &Edit::Split { id });
    let two = run.abstraction();
    check(&two, points.len());
    let [Occurrence::Halved { id: kept, into }] = told[..] else { panic!("{told:?}") };
    assert_eq!((kept, two.primitives.len()), (id, 2));
    let [larger, smaller] = [kept, into].map(|id| samples_of(&two, id).len());
    assert!(larger >= smaller && smaller > 20);
    assert_eq!(larger + smaller, one.primitives[0].points);
    assert!(two.figures.mean_distance < one.figures.mean_distance);
}

#[test]
fn deleted_primitives_leave_their_points_behind() {
    let points = gate(500);
    let mut run = run_on(&points, short(), 2);
    let before = run.abstraction();
    let ids = by_size(&before)[..2].to_vec();
    let lost: usize = ids.iter().map(|&id| samples_of(&before, id).len()).sum();
    edited(&mut run, &Edit::Delete { ids });
    let after = run.abstraction();
    check(&after, points.len());
    assert_eq!(after.figures.unassigned, before.figures.unassigned + lost);
    // Even all of them: the sampler starts new tables.
    let ids: Vec<u32> = after.primitives.iter().map(|p| p.id).collect();
    edited(&mut run, &Edit::Delete { ids });
    assert_eq!(run.abstraction().primitives.len(), 0);
    while !run.is_finished() {
        run.step(&never()).unwrap();
        check(&run.abstraction(), points.len());
    }
    assert!(!run.abstraction().primitives.is_empty(), "nothing was born again");
}

/// Samples of the right-hand post.
fn right_post(points: &[Point3<f64>]) -> Vec<u32> {
    (0u32..).zip(points).filter(|(_, p)| p.x > 0.5 && p.z > 0.12).map(|(i, _)| i).collect()
}

#[test]
fn selected_points_become_a_cluster_of_their_own() {
    let points = gate(600);
    let mut run = run_on(&points, short(), 0);
    let ids = by_size(&run.abstraction());
    edited(&mut run, &Edit::Merge { ids });
    let post = right_post(&points);
    let told = edited(&mut run, &Edit::NewCluster { samples: post.clone() });
    let [Occurrence::Created { id, points: n }] = told[..] else { panic!("{told:?}") };
    let after = run.abstraction();
    check(&after, points.len());
    assert_eq!((n, samples_of(&after, id)), (post.len(), post.clone()));
    let primitive = after.primitives.iter().find(|p| p.id == id).unwrap();
    assert!(
        (primitive.shape.translation - Vector3::new(0.7, 0.0, 0.6)).norm() < 0.1,
        "{:?}",
        primitive.shape
    );
    // Whoever loses all points dies.
    let told = edited(&mut run, &Edit::NewCluster { samples: post });
    assert!(matches!(told[..], [Occurrence::Created { .. }, Occurrence::Died { id: dead }] if dead == id));
}

#[test]
fn pinned_points_stay_together_until_they_are_released() {
    let points = gate(600);
    for params in [short(), Params { iterations: 17, clusters: 12, ..Params::paper() }] {
        let mut run = run_on(&points, params, 2);
        // Of both posts, which no primitive would hold together.
        let both: Vec<u32> = (0u32..).zip(&points).filter(|(_, p)| p.z > 0.95).map(|(i, _)| i).collect();
        let told = edited(&mut run, &Edit::Together { samples: both.clone() });
        assert!(matches!(told[0], Occurrence::Pinned { points, .. } if points == both.len()), "{told:?}");
        while !run.is_finished() {
            run.step(&never()).unwrap();
            let a = run.abstraction();
            check(&a, points.len());
            assert_eq!(&a.pinned[..], &both[..]);
            let label = a.labels[both[0] as usize];
            assert_ne!(label, UNASSIGNED);
            assert!(both.iter().all(|&i| a.labels[i as usize] == label), "iteration {}", a.iteration);
        }
        let told = edited(&mut run, &Edit::Release { samples: (0..points.len() as u32).collect() });
        assert_eq!(told, [Occurrence::Released { points: both.len() }]);
        assert!(run.abstraction().pinned.is_empty());
        run.resample(3).unwrap();
        while !run.is_finished() {
            run.step(&never()).unwrap();
        }
        let a = run.abstraction();
        let label = a.labels[both[0] as usize];
        assert!(both.iter().any(|&i| a.labels[i as usize] != label), "they were not let go of");
    }
}

#[test]
fn a_finished_run_goes_on_when_asked() {
    let points = gate(400);
    let mut run = run_on(&points, Params { iterations: 2, clusters: 8, ..Params::default() }, 3);
    assert!(run.is_finished());
    let end = run.abstraction();
    run.resample(2).unwrap();
    let now = run.abstraction();
    assert_eq!((now.phase, &now.labels, &now.primitives), (Phase::Sampling, &end.labels, &end.primitives));
    assert_eq!((run.params().iterations, run.is_finished()), (4, false));
    while !run.is_finished() {
        run.step(&never()).unwrap();
    }
    assert_eq!((run.iteration(), run.abstraction().phase), (4, Phase::Finished));
    // A larger T does the same.
    let params = Params { iterations: 5, ..*run.params() };
    run.set_params(params).unwrap();
    assert!(!run.is_finished());
    run.step(&never()).unwrap();
    assert_eq!((run.iteration(), run.abstraction().phase), (5, Phase::Sampling));
    assert!(run.resample(u32::MAX).unwrap_err().to_string().contains("most"));
}

#[test]
fn what_cannot_be_done_is_refused_in_words() {
    let points = gate(400);
    let mut run = run_on(&points, short(), 1);
    let a = run.abstraction();
    let (id, other) = (a.primitives[0].id, a.primitives[1].id);
    let some: Vec<u32> = (0..10).collect();
    let its = samples_of(&a, id);
    for (edit, word) in [
        (Edit::Refit { id: 999 }, "no primitive 999"),
        (Edit::Lock { id: 999, locked: true }, "no primitive 999"),
        (Edit::Merge { ids: vec![id] }, "two"),
        (Edit::Merge { ids: vec![id, id] }, "two"),
        (Edit::Delete { ids: vec![] }, "select"),
        (Edit::NewCluster { samples: some.clone() }, "too few"),
        (Edit::NewCluster { samples: vec![] }, "select"),
        (Edit::NewCluster { samples: vec![1 << 20] }, "no sample"),
        (Edit::Together { samples: vec![] }, "select"),
        (Edit::Release { samples: some }, "pinned"),
    ] {
        let text = refused(&mut run, &edit);
        assert!(text.contains(word), "{edit:?}: {text}");
    }
    edited(&mut run, &Edit::Lock { id, locked: true });
    assert!(edited(&mut run, &Edit::Lock { id, locked: true }).is_empty(), "it was locked already");
    for edit in [
        Edit::SetShape { id, shape: a.primitives[0].shape },
        Edit::Refit { id },
        Edit::Merge { ids: vec![id, other] },
        Edit::Split { id },
        Edit::Delete { ids: vec![other, id] },
        Edit::NewCluster { samples: its.clone() },
        Edit::Together { samples: its },
    ] {
        let text = refused(&mut run, &edit);
        assert!(text.contains(&format!("primitive {id}")) && text.contains("unlock"), "{text}");
    }
    let params = Params { algorithm: Algorithm::KMeans, ..short() };
    let mut baseline = run_on(&points, params, 1);
    let error = baseline.edit(&Edit::Delete { ids: vec![0] }, &never()).unwrap_err();
    assert!(error.to_string().contains("K-means"), "{error}");
    assert!(baseline.resample(1).is_err());
    assert!(baseline.propose_merge(&[], &never()).is_err());
}

#[test]
fn a_cancelled_edit_never_was() {
    let points = gate(500);
    let mut run = run_on(&points, short(), 2);
    let ids = by_size(&run.abstraction());
    let mut cancelled = 0;
    for turns in super::delays() {
        for edit in [Edit::Merge { ids: ids.clone() }, Edit::Split { id: ids[0] }, Edit::Refit { id: ids[0] }]
        {
            let before = run.checkpoint();
            let mut copy = run.clone();
            if let Err(error) = cancelled_after(turns, |cancel| copy.edit(&edit, cancel)) {
                assert!(matches!(error, InferenceError::Cancelled), "{error}");
                assert_eq!(copy.checkpoint(), before);
                cancelled += 1;
            }
        }
    }
    assert!(cancelled > 0);
    run.step(&never()).unwrap();
}

/// Some edit or step, as `rng` has it; most make sense.
fn anything(run: &mut Run, rng: &mut impl RngExt) -> bool {
    let a = run.abstraction();
    let n = a.labels.len() as u32;
    let ids: Vec<u32> = a.primitives.iter().map(|p| p.id).collect();
    let mut id = || if ids.is_empty() { 7 } else { ids[rng.random_range(0..ids.len())] };
    let (first, second) = (id(), id());
    let from = rng.random_range(0..n);
    let samples: Vec<u32> = (from..(from + rng.random_range(1..120)).min(n + 1)).collect();
    let nudge = Vector3::from_fn(|_, _| 0.2 * (rng.random::<f64>() - 0.5));
    let shape = a.primitives.iter().find(|p| p.id == first).map(|p| p.shape.moved(&nudge, &nudge));
    let edit = match rng.random_range(0..14) {
        0 | 1 => return run.step(&never()).is_ok(),
        2 => return run.step_merge(&never()).is_ok(),
        3 => return run.resample(1).is_ok(),
        4 => match run.propose_merge(&[(first, second)], &never()).unwrap() {
            Some(proposal) => Edit::AcceptMerge { proposal: Box::new(proposal) },
            None => return true,
        },
        5 => match shape {
            Some(shape) => Edit::SetShape { id: first, shape },
            None => return true,
        },
        6 => Edit::Refit { id: first },
        7 => Edit::Lock { id: first, locked: rng.random() },
        8 => Edit::Merge { ids: vec![first, second] },
        9 => Edit::Split { id: first },
        10 => Edit::Delete { ids: vec![first] },
        11 => Edit::NewCluster { samples },
        12 => Edit::Together { samples },
        _ => Edit::Release { samples },
    };
    let before = run.checkpoint();
    match run.edit(&edit, &never()) {
        Ok(_) => true,
        Err(InferenceError::Edit(text)) => {
            assert_eq!(run.checkpoint(), before, "{edit:?}: half an edit stayed");
            assert!(text.len() > 20, "{text}");
            false
        }
        Err(error) => panic!("{edit:?}: {error}"),
    }
}

#[test]
fn whatever_a_person_does_leaves_a_sound_state_and_can_be_done_again() {
    let points = gate(300);
    for (seed, merge) in [(1, MergeRule::Energy), (2, MergeRule::Paper), (3, MergeRule::None)] {
        let params = Params { iterations: 4, clusters: 6, merge, freeze: seed == 2, ..Params::default() };
        let mut one = run_on(&points, params, 0);
        let (mut first, mut second) = (rng(seed), rng(seed));
        let mut made = 0;
        for turn in 0..60 {
            // The same from a checkpoint, on another number of threads.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1 + turn % 3).build().unwrap();
            let mut two = one.resumed(&one.checkpoint(), &never()).unwrap();
            made += usize::from(anything(&mut one, &mut first));
            pool.install(|| anything(&mut two, &mut second));
            check(&one.abstraction(), points.len());
            assert!(same_bits(&one.abstraction(), &two.abstraction()), "turn {turn}");
            assert_eq!(one.checkpoint(), two.checkpoint(), "turn {turn}");
        }
        assert!(made > 20, "most were refused");
    }
}
