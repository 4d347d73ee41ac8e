//! Merges before they are made.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{gate, same_bits};
use crate::geometry::SampleCloud;
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::{MergeReason, Occurrence};
use crate::inference::params::{MergeRule, Params};
use crate::inference::runs::edit::Edit;
use crate::inference::runs::merge_proposal::{MergeProposal, TestQuantity};
use crate::inference::runs::run::Run;

fn never() -> Cancel {
    Cancel::default()
}

/// Before any merge pass.
fn paused(merge: MergeRule) -> Run {
    let params = Params { iterations: 3, clusters: 12, merge, ..Params::default() };
    let mut run = Run::new(Arc::new(SampleCloud::from_points(&gate(500))), params, &never()).unwrap();
    for _ in 0..2 {
        run.step(&never()).unwrap();
    }
    run
}

#[test]
fn proposing_and_accepting_is_the_step() {
    for merge in [MergeRule::Energy, MergeRule::Paper] {
        let mut by_step = paused(merge);
        let mut by_hand = by_step.clone();
        let mut merges = 0;
        loop {
            let before = by_hand.abstraction();
            let proposal = by_hand.propose_merge(&[], &never()).unwrap();
            assert!(same_bits(&before, &by_hand.abstraction()), "a look has changed the state");
            let report = by_step.step_merge(&never()).unwrap();
            // (By energy a pair that the search gives up may look better here.)
            let Some(report) = report.first().cloned() else {
                assert!(proposal.is_none_or(|p| !p.is_acceptable || merge == MergeRule::Energy));
                break;
            };
            let proposal = proposal.unwrap();
            assert!(proposal.is_acceptable);
            assert_eq!(
                (proposal.pair, proposal.into, &proposal.reason),
                (report.merged, report.into, &report.reason)
            );
            // Through text, as it may come back.
            let text = serde_json::to_string(&proposal).unwrap();
            let proposal: MergeProposal = serde_json::from_str(&text).unwrap();
            let told =
                by_hand.edit(&Edit::AcceptMerge { proposal: Box::new(proposal.clone()) }, &never()).unwrap();
            assert_eq!(told, [Occurrence::Merged(report)]);
            assert!(same_bits(&by_step.abstraction(), &by_hand.abstraction()));
            assert_eq!(by_step.checkpoint(), by_hand.checkpoint());
            let shown =
                by_hand.abstraction().primitives.iter().find(|p| p.id == proposal.into).unwrap().shape;
            assert_eq!(shown, proposal.union, "another union than the one shown");
            // It can't be accepted twice.
            let error =
                by_hand.edit(&Edit::AcceptMerge { proposal: Box::new(proposal) }, &never()).unwrap_err();
            assert!(
                error.to_string().contains("primitive") || error.to_string().contains("new proposal"),
                "{error}"
            );
            merges += 1;
        }
        assert!(merges > 1, "{merge:?}");
    }
}

#[test]
fn skipped_pairs_do_not_come_back_and_the_worst_can_be_seen() {
    for merge in [MergeRule::Energy, MergeRule::Paper, MergeRule::None] {
        let mut run = paused(merge);
        let before = run.abstraction();
        let mut skipped = Vec::new();
        let mut seen = BTreeSet::new();
        let mut refused = 0;
        while let Some(p) = run.propose_merge(&skipped, &never()).unwrap() {
            let (a, b) = p.pair;
            assert!(seen.insert((a.min(b), a.max(b))), "{a} and {b} were skipped");
            assert!(p.into == a || p.into == b);
            assert!(p.union.is_valid() && !p.numbers.is_empty());
            assert!(p.numbers.iter().all(|n| n.value.is_finite()));
            let is_late = p.is_acceptable && refused > 0;
            // (By energy a pair that the search has given up may look better here.)
            assert!(!is_late || merge == MergeRule::Energy, "a better one came later");
            refused += usize::from(!p.is_acceptable);
            // Either order skips.
            skipped.push((b, a));
        }
        assert!(seen.len() > 3, "{merge:?}: only {seen:?}");
        if merge == MergeRule::None {
            assert_eq!(refused, seen.len(), "merging is off");
        }
        assert!(same_bits(&before, &run.abstraction()), "a look has changed the state");
    }
}

#[test]
fn the_gain_is_what_its_numbers_say() {
    let mut run = paused(MergeRule::Energy);
    let p = run.propose_merge(&[], &never()).unwrap().unwrap();
    let number = |name| p.numbers.iter().find(|n| n.quantity == name).unwrap().value;
    let gain = number(TestQuantity::ErrorBefore) + number(TestQuantity::CostSaved)
        - number(TestQuantity::ErrorAfter);
    assert!((gain - number(TestQuantity::Gain)).abs() < 1e-12);
    assert_eq!(p.is_acceptable, gain > 0.0);
    assert!(matches!(p.reason, MergeReason::Energy { gain: told } if (told - gain).abs() < 1e-12));
}

#[test]
fn any_pair_can_be_looked_at() {
    for merge in [MergeRule::Energy, MergeRule::Paper, MergeRule::None] {
        let mut run = paused(merge);
        let a = run.abstraction();
        // The two farthest apart.
        let far = |x: f64| {
            a.primitives
                .iter()
                .max_by(|p, q| {
                    let key = |p: &crate::inference::data::abstraction::Primitive| {
                        p.shape.translation.x * x + p.shape.translation.z
                    };
                    key(p).total_cmp(&key(q))
                })
                .unwrap()
                .id
        };
        let (left, right) = (far(-1.0), far(1.0));
        let p = run.propose_merge_of(left, right, &never()).unwrap();
        assert!(!p.is_acceptable, "{merge:?}: {:?}", p.reason);
        // The person may know better.
        run.edit(&Edit::AcceptMerge { proposal: Box::new(p.clone()) }, &never()).unwrap();
        assert_eq!(run.abstraction().primitives.len() + 1, a.primitives.len());
        assert!(run.propose_merge_of(left, left, &never()).is_err());
        assert!(run.propose_merge_of(p.into, 999, &never()).is_err());
        run.edit(&Edit::Lock { id: p.into, locked: true }, &never()).unwrap();
        let other = run.abstraction().primitives.iter().map(|q| q.id).find(|id| *id != p.into).unwrap();
        assert!(run.propose_merge_of(p.into, other, &never()).unwrap_err().to_string().contains("locked"));
    }
}
