//! Entropies and matchings against their definitions.

use std::collections::BTreeMap;

use proptest::prelude::*;
use rand::RngExt;

use super::rng;

use crate::inference::data::abstraction::UNASSIGNED;
use crate::inference::data::label_uncertainty::{align_labels, aligned, disagreement, label_entropy};

#[test]
fn entropy_is_that_of_the_shares() {
    let states: [&[u32]; 4] = [&[1, 1, 1, 5], &[1, 2, 1, UNASSIGNED], &[1, 3, 2, 5], &[1, 4, 2, UNASSIGNED]];
    let found = label_entropy(&states);
    // ln 1, ln 4, and twice ln 2, of ln 4.
    for (found, expected) in found.iter().zip([0.0, 1.0, 0.5, 0.5]) {
        assert!((found - expected).abs() < 1e-6, "{found} instead of {expected}");
    }
    assert_eq!(label_entropy(&states[..1]), [0.0; 4]);
    assert!(label_entropy(&[]).is_empty());
}

proptest! {
    #[test]
    fn entropy_against_its_definition(
        states in (2usize..9).prop_flat_map(|w| prop::collection::vec(prop::collection::vec(0u32..4, 30), w))
    ) {
        let slices: Vec<&[u32]> = states.iter().map(Vec::as_slice).collect();
        for (i, found) in label_entropy(&slices).into_iter().enumerate() {
            let mut counts = BTreeMap::new();
            for labels in &states {
                *counts.entry(labels[i]).or_insert(0.0) += 1.0;
            }
            let w = states.len() as f64;
            let h: f64 = counts.values().map(|c: &f64| -(c / w) * (c / w).ln()).sum();
            prop_assert!((f64::from(found) - h / w.ln()).abs() < 1e-6);
        }
    }

    #[test]
    fn the_matching_is_the_best_of_all(
        labels in prop::collection::vec((0u32..5, 0u32..6), 1..60)
    ) {
        let (reference, other): (Vec<u32>, Vec<u32>) = labels.into_iter().unzip();
        let matched = align_labels(&reference, &other);
        let agree = |map: &dyn Fn(u32) -> Option<u32>| {
            reference.iter().zip(&other).filter(|(a, b)| map(**b) == Some(**a)).count()
        };
        let found = agree(&|b| matched.get(&b).copied());
        // Each of the five gets one of six, or none.
        let mut best = 0;
        for code in 0..6u32.pow(5) {
            let of: Vec<u32> = (0..5).map(|a| code / 6u32.pow(a) % 6).collect();
            let is_injective = (0..5).all(|i| (0..i).all(|j| of[i] != of[j]));
            if is_injective {
                best = best.max(agree(&|b| of.iter().position(|x| *x == b).map(|a| a as u32)));
            }
        }
        prop_assert_eq!(found, best);
        let mut partners: Vec<u32> = matched.values().copied().collect();
        partners.sort_unstable();
        partners.dedup();
        prop_assert_eq!(partners.len(), matched.len(), "two labels stand for one");
        prop_assert_eq!(disagreement(&reference, &other).iter().filter(|d| !**d).count(), found);
    }
}

#[test]
fn other_names_are_no_disagreement() {
    let mut rng = rng(4);
    let reference: Vec<u32> = (0..5000)
        .map(|_| if rng.random::<f64>() < 0.1 { UNASSIGNED } else { rng.random_range(0..40) })
        .collect();
    let renamed = |l: u32| if l == UNASSIGNED { l } else { 1000 - 7 * l };
    let other: Vec<u32> = reference.iter().map(|&l| renamed(l)).collect();
    assert!(!disagreement(&reference, &other).contains(&true));
    assert_eq!(aligned(&reference, &other), reference);
    let names = align_labels(&reference, &other);
    assert!(reference.iter().filter(|l| **l != UNASSIGNED).all(|&l| names[&renamed(l)] == l));

    // One label falls apart: the larger half keeps the name, the other gets one
    // that nobody has.
    let halves: Vec<u32> =
        (0u32..).zip(&other).map(|(i, &l)| if l == renamed(3) && i % 3 == 0 { 77 } else { l }).collect();
    let back = aligned(&reference, &halves);
    for ((&a, &b), &l) in reference.iter().zip(&back).zip(&halves) {
        assert_eq!(b, if l == 77 { 40 } else { a });
    }
    let apart = disagreement(&reference, &halves).iter().filter(|d| **d).count();
    assert_eq!(apart, halves.iter().filter(|l| **l == 77).count());
    // No label against one is a disagreement, none against none isn't.
    assert_eq!(disagreement(&[UNASSIGNED, UNASSIGNED, 1], &[UNASSIGNED, 5, UNASSIGNED]), [false, true, true]);
    assert!(align_labels(&[], &[]).is_empty());
}
