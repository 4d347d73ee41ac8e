//! Merging: what becomes one, and that an interrupted attempt leaves no trace.

use std::sync::Arc;

use nalgebra::Point3;

use super::{block, cancelled_after, check, delays, gate, same_bits, sampler, samples, scene, short};
use crate::geometry::kernel::Distance;
use crate::inference::control::Cancel;
use crate::inference::data::model::Model;
use crate::inference::data::normalization::Normalization;
use crate::inference::data::state::{Cluster, State};
use crate::inference::fit::points::{Effort, fit};
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::moves::merge::merge_once;
use crate::inference::moves::union_cache::UnionCache;
use crate::inference::params::{MergeRule, Params};

/// Merges until nothing is left to merge.
fn merge_all(sampler: &mut Sampler) -> usize {
    let mut merges = 0;
    loop {
        let reports = sampler.step_merge(&Cancel::default()).unwrap();
        if reports.is_empty() {
            return merges;
        }
        merges += reports.len();
        let now = sampler.abstraction();
        for report in reports {
            let (a, b) = report.merged;
            let left: Vec<u32> =
                now.primitives.iter().map(|p| p.id).filter(|id| [a, b].contains(id)).collect();
            assert_eq!(left, [report.into]);
        }
    }
}

#[test]
fn a_cancelled_merge_is_not_forgotten() {
    let points = samples(&block([0.0; 3], [1.0, 0.6, 0.4]), 500);
    for rule in [MergeRule::Energy, MergeRule::Paper] {
        let params =
            Params { iterations: 3, clusters: 6, merge: MergeRule::None, refine: false, ..Params::default() };
        let mut start = sampler(&points, params);
        for _ in 0..2 {
            start.step(&Cancel::default()).unwrap();
        }
        start.set_params(Params { merge: rule, ..params }).unwrap();
        let mut never = start.clone();
        let merges = merge_all(&mut never);
        assert!(merges > 0, "{rule:?}: there was something to merge");
        for round in 0..4 {
            let mut often = start.clone();
            let before = often.abstraction();
            for turns in delays().map(|t| t + round * 311) {
                let mut once = often.clone();
                if cancelled_after(turns, |cancel| once.step_merge(cancel)).is_err() {
                    assert!(same_bits(&before, &once.abstraction()));
                    // With whatever the cancelled attempt has left behind.
                    often = once;
                }
            }
            merge_all(&mut often);
            assert!(
                same_bits(&never.abstraction(), &often.abstraction()),
                "{rule:?}: a cancelled attempt changed the merges"
            );
        }
    }
}

/// A run that starts from given labels: the fits of the first iteration give
/// the primitives.
fn from_labels(points: &[Point3<f64>], parts: &[u32]) -> (State, Params) {
    let model = Arc::new(Model::new(Normalization::of(points).unwrap(), points, &[]));
    let count = parts.iter().max().unwrap() + 1;
    let clusters: Vec<Cluster> = (0..count)
        .map(|id| {
            let own: Vec<u32> = (0u32..).zip(parts).filter(|p| *p.1 == id).map(|p| p.0).collect();
            let own = model.gather(&own);
            let limits = model.limits();
            let found =
                fit(&own, &[], limits, Effort::THOROUGH, Distance::FirstOrder, &Cancel::default()).unwrap();
            Cluster { id, revision: u64::from(id), shape: found.shape, sigma: 0.1, locked: false }
        })
        .collect();
    let state = State {
        frozen: vec![false; points.len()],
        labels: parts.to_vec(),
        iteration: 30,
        pinned: Arc::default(),
        next_id: count,
        next_revision: u64::from(count),
        clusters,
        model,
    };
    (state, Params::default())
}

#[test]
fn halves_merge_and_separate_boxes_do_not() {
    let whole = samples(&block([0.0; 3], [1.0, 0.5, 0.4]), 600);
    let halves: Vec<u32> = whole.iter().map(|p| u32::from(p.x > 0.0)).collect();
    let apart = [block([-0.8, 0.0, 0.0], [0.5; 3]), block([0.8, 0.0, 0.0], [0.5; 3])];
    let (apart, of_apart) = scene(&apart, 600);
    // Touching at a corner's edge, one across the other.
    let cross = [block([0.0; 3], [1.0, 0.2, 0.2]), block([0.0, 0.0, 0.8], [0.2, 0.2, 0.6])];
    let (cross, of_cross) = scene(&cross, 600);
    for rule in [MergeRule::Energy, MergeRule::Paper, MergeRule::None] {
        for (name, points, parts, merges) in
            [("halves", &whole, &halves, 1), ("apart", &apart, &of_apart, 0), ("a T", &cross, &of_cross, 0)]
        {
            let (mut state, params) = from_labels(points, parts);
            let params = Params { merge: rule, ..params };
            let mut cache = UnionCache::default();
            let mut found = 0;
            while !merge_once(&mut state, &mut cache, &params, &Cancel::default()).is_empty() {
                found += 1;
            }
            let expected = if rule == MergeRule::None { 0 } else { merges };
            assert_eq!(found, expected, "{name} by {rule:?}");
            assert_eq!(state.clusters.len(), 2 - found);
            if found == 1 {
                assert!(state.labels.iter().all(|l| *l == 0));
            }
            // Asked again with nothing remembered, the answer is the same.
            assert!(
                merge_once(&mut state, &mut UnionCache::default(), &params, &Cancel::default()).is_empty()
            );
        }
    }
}

#[test]
fn one_step_of_a_merge_by_hand_leaves_none_at_the_end() {
    let mut sampler = sampler(&gate(500), Params { refine: false, merge: MergeRule::None, ..short() });
    while !sampler.is_finished() {
        sampler.step(&Cancel::default()).unwrap();
    }
    assert_eq!(sampler.step_merge(&Cancel::default()).unwrap(), []);
    sampler.set_params(Params { merge: MergeRule::Energy, ..*sampler.params() }).unwrap();
    let before = sampler.abstraction().primitives.len();
    let merges = merge_all(&mut sampler);
    assert_eq!(sampler.abstraction().primitives.len() + merges, before);
    check(&sampler.abstraction(), sampler.abstraction().labels.len());
    assert_eq!(sampler.step_merge(&Cancel::default()).unwrap(), []);
}
