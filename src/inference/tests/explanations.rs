//! The odds that are shown are those that are drawn from.

use std::sync::Arc;

use nalgebra::Point3;
use rand::RngExt;

use super::{gate, rng, short};
use crate::geometry::SampleCloud;
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::UNASSIGNED;
use crate::inference::data::restaurant::expected_tables;
use crate::inference::data::state::State;
use crate::inference::gibbs::log_joint::log_joint;
use crate::inference::gibbs::sweep::sweep;
use crate::inference::params::{Algorithm, Params};
use crate::inference::runs::checkpoint::Checkpoint;
use crate::inference::runs::edit::Edit;
use crate::inference::runs::explain::{explain, new_table_distance, normalised_scale};
use crate::inference::runs::run::Run;

fn never() -> Cancel {
    Cancel::default()
}

fn stepped(points: &[Point3<f64>], params: Params, steps: usize) -> Run {
    let mut run = Run::new(Arc::new(SampleCloud::from_points(points)), params, &never()).unwrap();
    for _ in 0..steps {
        run.step(&never()).unwrap();
    }
    run
}

/// A sample that several tables want, by their odds.
fn torn(points: &[Point3<f64>], saved: &Checkpoint) -> u32 {
    let least =
        |i: &u32| explain(points, saved, *i).unwrap().tables.iter().fold(0.0, |m, t| t.probability.max(m));
    (0..points.len() as u32).min_by(|a, b| least(a).total_cmp(&least(b))).unwrap()
}

#[test]
fn the_terms_make_the_odds_and_the_odds_sum_to_one() {
    let points = gate(500);
    let run = stepped(&points, short(), 3);
    let saved = run.checkpoint();
    let a = run.abstraction();
    let scale = normalised_scale(&points).unwrap();
    for sample in (0..points.len() as u32).step_by(17) {
        let e = explain(&points, &saved, sample).unwrap();
        let label = a.labels[sample as usize];
        assert_eq!(e.present, (label != UNASSIGNED).then_some(label));
        assert_eq!(e.tables.len(), a.primitives.len());
        let mut sum = e.new.probability;
        for (t, p) in e.tables.iter().zip(a.primitives.iter()) {
            assert_eq!((t.id, t.n as usize), (p.id, p.points - usize::from(label == p.id)));
            let d = p.shape.radial_distance(&points[sample as usize]).abs();
            assert!((t.distance_input - d).abs() < 1e-9 && (t.distance - d * scale).abs() < 1e-9);
            assert!((t.sigma - p.sigma * scale).abs() < 1e-9);
            assert!((t.weight - t.n * t.density * 0.5).abs() <= 1e-15 * t.weight);
            sum += t.probability;
        }
        assert_eq!(e.new.weight, saved.params.alpha * saved.params.p0);
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }
    assert!(explain(&points, &saved, points.len() as u32).is_none());
    assert!(explain(&points[1..], &saved, 0).is_none(), "a state of another cloud");
    let baseline = stepped(&points, Params { algorithm: Algorithm::KMeans, ..short() }, 0);
    assert!(explain(&points, &baseline.checkpoint(), 0).is_none());
}

#[test]
fn a_sweep_draws_by_these_odds() {
    const SWEEPS: u64 = 4000;
    let points = gate(400);
    // A likely new table, so that it is seen to be drawn.
    let params = Params { alpha: 20.0, p0: 1.0, ..short() };
    let run = stepped(&points, params, 2);
    let mut saved = run.checkpoint();
    let sample = torn(&points, &saved);
    let e = explain(&points, &saved, sample).unwrap();
    saved.frozen = (0..points.len() as u32).filter(|i| *i != sample).collect();
    let model = Arc::clone(&run.sampler().state.model);
    let base: State = saved.state(model);
    // What the cleaning after the draws does depends on where it came to lie.
    let near = |state: &State, j: u32| {
        let parts = state.components(j, &state.members()[j as usize]);
        parts.len() < 2 || parts[0].contains(&sample)
    };
    let mut counts = vec![0.0; e.tables.len() + 1];
    let mut loose = vec![false; e.tables.len()];
    for (j, loose) in loose.iter_mut().enumerate() {
        let mut there = base.clone();
        there.labels[sample as usize] = j as u32;
        *loose = !near(&there, j as u32);
    }
    for seed in 0..SWEEPS {
        let mut state = base.clone();
        sweep(&mut state, &Params { seed, ..params }, &mut Vec::new());
        let label = state.labels[sample as usize];
        let id = state.clusters.get(label as usize).map(|c| c.id);
        let place = id.and_then(|id| e.tables.iter().position(|t| t.id == id)).unwrap_or(e.tables.len());
        counts[place] += 1.0;
    }
    // A table that it is not connected with hands it on, to others and itself,
    // but never to a new one: that one's odds, and the order of the others hold.
    let expected = e.new.probability * SWEEPS as f64;
    let spread = (expected * (1.0 - e.new.probability)).sqrt().max(1.0);
    let new = counts[e.tables.len()];
    assert!((new - expected).abs() < 5.0 * spread, "a new table {new} times, not {expected}");
    assert!(expected > 50.0, "nothing was to be seen");
    let passed_on: f64 = e.tables.iter().zip(&loose).filter(|(_, l)| **l).map(|(t, _)| t.probability).sum();
    let total = 1.0 - e.new.probability;
    for ((t, count), _) in e.tables.iter().zip(&counts).zip(&loose).filter(|(_, loose)| !**loose) {
        // Directly, or handed on by the odds among all tables.
        let p = t.probability + passed_on * t.probability / total;
        let (expected, spread) = (p * SWEEPS as f64, (p * (1.0 - p) * SWEEPS as f64).sqrt().max(1.0));
        assert!((count - expected).abs() < 5.0 * spread, "{} drawn {count} times, not {expected}", t.id);
    }
}

#[test]
fn nobody_may_join_a_locked_table() {
    let points = gate(400);
    let mut run = stepped(&points, short(), 2);
    let id = run.abstraction().primitives[0].id;
    run.edit(&Edit::Lock { id, locked: true }, &never()).unwrap();
    let (saved, a) = (run.checkpoint(), run.abstraction());
    for sample in (0..points.len() as u32).step_by(23) {
        let e = explain(&points, &saved, sample).unwrap();
        assert_eq!(e.tables[0].probability, 0.0);
        assert_eq!(e.held.is_some(), a.labels[sample as usize] == id);
    }
}

#[test]
fn the_log_joint_moves_by_the_odds() {
    let points = gate(400);
    let run = stepped(&points, Params { alpha: 2.0, ..short() }, 2);
    let saved = run.checkpoint();
    let joint = |labels: &[u32]| {
        let state = run.resumed(&Checkpoint { labels: labels.to_vec(), ..saved.clone() }, &never()).unwrap();
        state.abstraction().figures.log_joint.unwrap()
    };
    let waiting = saved.labels.iter().filter(|l| **l == UNASSIGNED).count() as f64;
    let sample = torn(&points, &saved);
    let e = explain(&points, &saved, sample).unwrap();
    let mut labels = saved.labels.clone();
    labels[sample as usize] = UNASSIGNED;
    let out = joint(&labels);
    let others = waiting - f64::from(u32::from(e.present.is_none()));
    let new = ((saved.params.alpha + others) * saved.params.p0).ln();
    let mut compared = 0;
    for (j, t) in (0u32..).zip(&e.tables).filter(|(_, t)| t.weight > 1e-12 && t.n > 0.0) {
        labels[sample as usize] = j;
        let gain = joint(&labels) - out;
        assert!((gain - (t.weight.ln() - new)).abs() < 1e-3, "{gain} against {}", t.weight.ln() - new);
        compared += 1;
    }
    assert!(compared > 1);
    // Tables with no point and an empty cloud have a density, too.
    assert_eq!(log_joint(1.0, 0.1, &[(0, 0.0, 0.3)], 0), 0.0);
    let baseline = stepped(&points, Params { algorithm: Algorithm::KMeans, ..short() }, 1);
    assert_eq!(baseline.abstraction().figures.log_joint, None);
}

#[test]
fn the_prior_in_the_log_joint_sums_to_one() {
    // Over all partitions of four points without anyone waiting: the restaurant's
    // probabilities sum to 1. σ = 1/√(8π) makes ½·N(0; σ) = 1.
    let sigma = 1.0 / (8.0 * std::f64::consts::PI).sqrt();
    for alpha in [0.01, 0.5, 3.0] {
        let partitions: [(&[usize], f64); 5] =
            [(&[4], 1.0), (&[3, 1], 4.0), (&[2, 2], 3.0), (&[2, 1, 1], 6.0), (&[1, 1, 1, 1], 1.0)];
        let sum: f64 = partitions
            .iter()
            .map(|(sizes, ways)| {
                let tables: Vec<_> = sizes.iter().map(|&n| (n, 0.0, sigma)).collect();
                ways * log_joint(alpha, 0.1, &tables, 0).exp()
            })
            .sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }
}

#[test]
fn alpha_as_a_number_of_tables() {
    for alpha in [1e-3, 0.5, 1.0, 7.3, 100.0] {
        for n in [0, 1, 2, 63, 64, 65, 1000, 20_000] {
            let sum: f64 = (0..n).rev().map(|i| alpha / (alpha + i as f64)).sum();
            assert!((expected_tables(alpha, n) - sum).abs() < 1e-9 * sum.max(1.0), "α = {alpha}, n = {n}");
        }
        // A restaurant that fills guest by guest.
        const EVENINGS: usize = 2000;
        let mut rng = rng(11);
        let n = 300;
        let counts: Vec<f64> = (0..EVENINGS)
            .map(|_| (0..n).filter(|&i| rng.random::<f64>() * (alpha + i as f64) < alpha).count() as f64)
            .collect();
        let mean = counts.iter().sum::<f64>() / EVENINGS as f64;
        let variance: f64 = (0..n).map(|i| alpha / (alpha + i as f64)).map(|p| p * (1.0 - p)).sum();
        // Passed with a probability of 6e-7.
        let limit = 5.0 * (variance / EVENINGS as f64).sqrt() + 1e-9;
        assert!((mean - expected_tables(alpha, n)).abs() < limit.max(0.01), "α = {alpha}: {mean}");
    }
    assert!(expected_tables(0.5, 3_000_000_000) < 13.0, "billions of guests take no time");
}

#[test]
fn p0_as_the_distance_at_which_a_new_table_wins() {
    for (alpha, p0, n, sigma) in [(0.5, 0.1, 300.0, 0.2), (3.0, 1e-4, 25.0, 0.01), (0.5, 0.1, 1.0, 1.0)] {
        let d = new_table_distance(alpha, p0, n, sigma).unwrap();
        let z: f64 = d / sigma;
        let table = n * 0.5 * (-0.5 * z * z).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt());
        assert!((table / (alpha * p0) - 1.0).abs() < 1e-9);
        assert!(new_table_distance(2.0 * alpha, p0, n, sigma).is_none_or(|nearer| nearer < d));
    }
    assert_eq!(new_table_distance(100.0, 10.0, 1.0, 1.0), None);
    assert_eq!(new_table_distance(0.5, 0.1, 0.0, 1.0), None);
}
