//! Scenes that a person would describe without hesitation.

use std::collections::BTreeMap;

use super::{block, check, jitter, run, samples, scene};
use crate::geometry::Superquadric;
use crate::inference::data::abstraction::{Abstraction, UNASSIGNED};
use crate::inference::params::Params;

/// The share of points whose primitive is the one that most of its points'
/// part is given to: what a one-to-one matching would count as right.
fn agreement(a: &Abstraction, parts: &[u32]) -> f64 {
    let mut counts: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (&label, &part) in a.labels.iter().zip(parts) {
        if label != UNASSIGNED {
            *counts.entry((label, part)).or_default() += 1;
        }
    }
    // Largest overlaps first, each primitive and each part once.
    let mut order: Vec<_> = counts.into_iter().collect();
    order.sort_by_key(|&(key, n)| (std::cmp::Reverse(n), key));
    let (mut labels, mut taken, mut right) = (Vec::new(), Vec::new(), 0);
    for ((label, part), n) in order {
        if !labels.contains(&label) && !taken.contains(&part) {
            labels.push(label);
            taken.push(part);
            right += n;
        }
    }
    right as f64 / parts.len() as f64
}

fn table() -> [Superquadric; 5] {
    let leg = |x: f64, y: f64| block([x, y, 0.0], [0.08, 0.08, 0.7]);
    [
        block([0.0, 0.0, 0.75], [1.0, 0.7, 0.06]),
        leg(0.85, 0.55),
        leg(-0.85, 0.55),
        leg(0.85, -0.55),
        leg(-0.85, -0.55),
    ]
}

#[test]
fn a_table_is_a_top_and_four_legs() {
    let (points, parts) = scene(&table(), 1500);
    for seed in 1..=3 {
        let a = run(&points, Params { seed, ..Params::default() });
        check(&a, points.len());
        let agreement = agreement(&a, &parts);
        assert!((5..=6).contains(&a.primitives.len()), "seed {seed}: {} primitives", a.primitives.len());
        assert!(agreement >= 0.95, "seed {seed}: only {agreement} of the labels agree");
    }
}

#[test]
fn a_can_is_one_primitive() {
    let can = Superquadric { exponents: [0.1, 1.0], ..block([3.0, 1.0, 0.0], [0.5, 0.5, 0.9]) };
    let mut points = samples(&can, 1000);
    jitter(&mut points, 0.005, 1);
    for seed in 1..=3 {
        let a = run(&points, Params { seed, ..Params::default() });
        check(&a, points.len());
        assert_eq!(a.primitives.len(), 1, "seed {seed}");
        assert!((a.primitives[0].shape.volume() / can.volume() - 1.0).abs() < 0.05);
        assert!(a.figures.unassigned * 50 < points.len(), "{} points unassigned", a.figures.unassigned);
    }
}
