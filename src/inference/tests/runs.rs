//! The run as a machine: bits, checkpoints, cancelling, degenerate clouds.

use std::sync::Arc;

use nalgebra::{Point3, Rotation3, Vector3};

use super::{block, cancelled_after, check, delays, gate, rng, run, same_bits, sampler, scene, short};
use crate::geometry::SampleCloud;
use crate::geometry::kernel::Distance;
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::data::abstraction::{Abstraction, Occurrence, Phase, UNASSIGNED};
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::parameters::Setting;
use crate::inference::params::{Algorithm, Params};
use crate::inference::runs::run::Run;

fn on_threads(threads: usize, points: &[Point3<f64>], params: Params) -> Vec<Abstraction> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut sampler = sampler(points, params);
        let mut states = vec![sampler.abstraction()];
        while !sampler.is_finished() {
            sampler.step(&Cancel::default()).unwrap();
            states.push(sampler.abstraction());
        }
        states
    })
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let points = gate(600);
    for params in [short(), Params { iterations: 16, clusters: 12, ..Params::paper() }] {
        let one = on_threads(1, &points, params);
        for threads in [2, 3] {
            let many = on_threads(threads, &points, params);
            assert_eq!(one.len(), many.len());
            for (i, (a, b)) in one.iter().zip(&many).enumerate() {
                assert!(same_bits(a, b), "step {i} differs on {threads} threads");
            }
        }
        let other = on_threads(2, &points, Params { seed: 2, ..params });
        assert_ne!(one[1].labels, other[1].labels, "another seed draws the same");
    }
}

#[test]
fn ids_are_stable_and_what_happens_is_told() {
    let points = gate(600);
    for params in [short(), Params { iterations: 16, clusters: 12, ..Params::paper() }] {
        let mut sampler = sampler(&points, params);
        let before = sampler.abstraction();
        assert_eq!((before.phase, before.iteration), (Phase::Start, 0));
        check(&before, points.len());
        let mut alive: Vec<u32> = before.primitives.iter().map(|p| p.id).collect();
        let mut newest = alive.iter().max().copied().unwrap();
        while !sampler.is_finished() {
            let told = sampler.step(&Cancel::default()).unwrap();
            let now = sampler.abstraction();
            check(&now, points.len());
            let ids: Vec<u32> = now.primitives.iter().map(|p| p.id).collect();
            for occurrence in &told {
                match occurrence {
                    Occurrence::Born { id, points } => {
                        assert!(*id > newest, "an id came back");
                        assert!(*points > 20);
                        newest = *id;
                        alive.push(*id);
                    }
                    Occurrence::Merged(report) => {
                        let (a, b) = report.merged;
                        assert!(a != b && (report.into == a || report.into == b) && report.reason.is_good());
                        assert!(alive.contains(&a) && alive.contains(&b));
                        alive.retain(|id| *id == report.into || (*id != a && *id != b));
                    }
                    Occurrence::Died { id } => {
                        assert!(!ids.contains(id), "{id} died and lives");
                        alive.retain(|a| a != id);
                    }
                    _ => {}
                }
            }
            // The refinement removes small clusters; it may do so silently.
            if now.phase == Phase::Finished {
                assert!(ids.iter().all(|id| alive.contains(id)));
            } else {
                let (mut expected, mut found) = (alive.clone(), ids.clone());
                expected.sort_unstable();
                found.sort_unstable();
                assert_eq!(found, expected, "iteration {}: {told:?}", now.iteration);
            }
        }
        assert_eq!(sampler.abstraction().phase, Phase::Finished);
        assert_eq!(sampler.iteration(), params.iterations);
        // Nothing is left to do: a step more changes nothing.
        let end = sampler.abstraction();
        assert_eq!(sampler.step(&Cancel::default()).unwrap(), []);
        assert!(same_bits(&end, &sampler.abstraction()));
    }
}

#[test]
fn a_clone_is_a_checkpoint() {
    let points = gate(500);
    let mut original = sampler(&points, short());
    for _ in 0..3 {
        original.step(&Cancel::default()).unwrap();
    }
    let mut copy = original.clone();
    let at_copy = copy.abstraction();
    let finish = |s: &mut Sampler| {
        while !s.is_finished() {
            s.step(&Cancel::default()).unwrap();
        }
        s.abstraction()
    };
    let end = finish(&mut original);
    assert!(same_bits(&at_copy, &copy.abstraction()), "the original's steps changed the copy");
    assert!(same_bits(&end, &finish(&mut copy)));
}

#[test]
fn a_run_restarted_on_its_cloud_is_a_run_from_nothing() {
    let cloud = Arc::new(SampleCloud::from_points(&gate(500)));
    let never = Cancel::default();
    let finish = |mut run: Run| {
        while !run.is_finished() {
            run.step(&never).unwrap();
        }
        run.abstraction()
    };
    let mut used = Run::new(cloud.clone(), short(), &never).unwrap();
    used.step(&never).unwrap();
    for params in [Params { seed: 7, ..short() }, Params { algorithm: Algorithm::KMeans, ..short() }] {
        let restarted = used.restarted(params, &never).unwrap();
        let new = Run::new(cloud.clone(), params, &never).unwrap();
        assert!(same_bits(&finish(restarted), &finish(new)));
    }
}

#[test]
fn a_cancelled_step_never_was() {
    let points = gate(500);
    for params in [short(), Params { iterations: 3, clusters: 12, ..Params::paper() }] {
        let mut never = sampler(&points, params);
        let mut often = never.clone();
        let mut cancelled = 0;
        while !never.is_finished() {
            never.step(&Cancel::default()).unwrap();
            let before = often.abstraction();
            let mut done = false;
            for turns in delays() {
                match cancelled_after(turns, |cancel| often.step(cancel)) {
                    Ok(_) => {
                        done = true;
                        break;
                    }
                    Err(InferenceError::Cancelled) => {
                        cancelled += 1;
                        assert!(same_bits(&before, &often.abstraction()), "half a step stayed");
                    }
                    Err(error) => panic!("{error}"),
                }
            }
            if !done {
                often.step(&Cancel::default()).unwrap();
            }
            assert!(same_bits(&never.abstraction(), &often.abstraction()));
        }
        assert!(cancelled > 0);
    }
}

#[test]
fn parameters_at_their_limits() {
    let points = gate(400);
    let (alpha, p0) = (Setting::Alpha.range(), Setting::P0.range());
    let base = Params { iterations: 2, ..short() };
    for params in [
        Params { clusters: 1, ..base },
        Params { clusters: 500, ..base },
        Params { iterations: 1, ..base },
        Params { alpha: alpha.0, p0: p0.0, ..base },
        Params { alpha: alpha.1, p0: p0.1, ..base },
        Params { seed: u64::MAX, ..base },
        Params { clusters: 500, ..Params::paper() },
        Params { fit_distance: Distance::Radial, freeze: true, ..base },
    ] {
        check(&run(&points, params), points.len());
    }
    let cloud = Arc::new(SampleCloud::from_points(&points));
    for (params, word) in [
        (Params { alpha: 0.0, ..base }, "alpha"),
        (Params { alpha: f64::NAN, ..base }, "alpha"),
        (Params { p0: f64::INFINITY, ..base }, "p0"),
        (Params { iterations: 0, ..base }, "iterations"),
        (Params { clusters: 501, ..base }, "clusters"),
    ] {
        let error = Sampler::new(cloud.clone(), params, &Cancel::default()).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
        let mut good = sampler(&points, base);
        assert!(good.set_params(params).is_err());
        assert_eq!(*good.params(), base, "refused parameters were taken over");
    }
}

/// Points whose coordinates are multiples of 2⁻²⁰, so that moving them by
/// whole numbers and scaling by powers of two is exact.
fn on_a_grid(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let unit = f64::from(1u32 << 20);
    points.iter().map(|p| p.map(|c| (c * unit).round() / unit)).collect()
}

#[test]
fn the_result_moves_and_scales_with_the_input() {
    let points = on_a_grid(&gate(500));
    let base = run(&points, short());
    let size = 2.0;
    // Powers of two scale without rounding: the same bits up to the scale.
    for (scale, offset) in [(1.0, 4096.0), (1024.0, 0.0), (2f64.powi(-30), 0.0), (0.001, 0.0), (1000.0, 77.7)]
    {
        let moved: Vec<_> =
            points.iter().map(|p| Point3::from(p.coords * scale + Vector3::repeat(offset))).collect();
        let found = run(&moved, short());
        let same = base.labels.iter().zip(found.labels.iter()).filter(|(a, b)| a == b).count();
        let exact = scale.log2().fract() == 0.0;
        if exact {
            assert_eq!(base.labels, found.labels, "×{scale} + {offset}");
        }
        // Rounding of the input may tip a draw here and there, and then all
        // that follows: the scene still has the same parts.
        assert_eq!(base.primitives.len(), found.primitives.len(), "×{scale} + {offset}");
        if same == points.len() {
            for (a, b) in base.primitives.iter().zip(found.primitives.iter()) {
                let expected = a.shape.scaled(scale, &Vector3::repeat(offset));
                assert!((b.shape.translation - expected.translation).norm() < 1e-6 * size * scale);
                assert!((b.shape.semi_axes - expected.semi_axes).norm() < 1e-6 * size * scale);
                assert!((b.sigma / (a.sigma * scale) - 1.0).abs() < 1e-6);
                assert!((b.mean_distance - a.mean_distance * scale).abs() < 1e-6 * size * scale);
            }
        }
    }
}

#[test]
fn labels_follow_the_order_of_the_input() {
    use rand::seq::SliceRandom;
    // Two boxes far apart: whichever primitives they get, none has points of both.
    let shapes = [block([-3.0, 0.0, 0.0], [0.5, 0.6, 0.7]), block([3.0, 0.0, 0.0], [0.7, 0.4, 0.5])];
    let (points, _) = scene(&shapes, 500);
    let mut shuffled = points;
    shuffled.shuffle(&mut rng(4));
    let turn = Rotation3::new(Vector3::new(0.3, 0.2, 1.0));
    let turned: Vec<_> = shuffled.iter().map(|p| turn * p).collect();
    let a = run(&turned, short());
    check(&a, turned.len());
    for p in a.primitives.iter() {
        let left = p.shape.translation.dot(&(turn * Vector3::x())) < 0.0;
        for (x, label) in shuffled.iter().zip(a.labels.iter()) {
            if *label == p.id {
                assert_eq!(x.x < 0.0, left, "a label belongs to another point");
            }
        }
    }
    assert!(a.labels.iter().filter(|l| **l == UNASSIGNED).count() * 20 < shuffled.len());
}
