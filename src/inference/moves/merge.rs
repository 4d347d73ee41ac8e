//! Merging: propose one primitive for the points of two clusters, and test
//! it. Two rules: the authors' thresholds, and the energy.

use std::collections::btree_map::Entry;

use crate::geometry::Superquadric;
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::{MergeReason, MergeReport};
use crate::inference::data::change::{Change, Draw, Identity, Noise, Successor};
use crate::inference::data::random_streams::Purpose;
use crate::inference::data::state::State;
use crate::inference::moves::merge_search::MergeSearch;
use crate::inference::moves::paper_merge_test::Pair;
use crate::inference::moves::union_cache::{Union, UnionCache};
use crate::inference::objective::energy;
use crate::inference::params::{MergeRule, Params};

/// Makes the best acceptable merge; no report where there is none. A group of
/// more than two gives one report for each that joins the largest.
pub(crate) fn merge_once(
    state: &mut State,
    cache: &mut UnionCache,
    params: &Params,
    cancel: &Cancel,
) -> Vec<MergeReport> {
    let model = state.model.clone();
    let found = match params.merge {
        MergeRule::None => None,
        MergeRule::Energy => {
            let best = MergeSearch::new(&model, state, params, cancel).best(|_| true);
            best.map(|(list, proposal)| {
                let shape = proposal.added[0].shape;
                let sum_d2 = model.sum_d2(&shape, &proposal.members[0]);
                let reason = MergeReason::Energy { gain: proposal.gain / energy::scale(&model) };
                (list, Union { shape, sum_d2, reason })
            })
        }
        MergeRule::Paper => {
            let members = state.members();
            let pairs = in_order_of_size(state, &members);
            let first = first_by_thresholds(state, &members, &pairs, cache, params, cancel);
            first.map(|(a, b, union)| (vec![a, b], union))
        }
    };
    let Some((list, union)) = found.filter(|_| !cancel.is_requested()) else { return Vec::new() };
    let ids: Vec<u32> = list.iter().map(|&j| state.clusters[j].id).collect();
    let into = state.apply(union_change(state, params, &list, union.shape, union.sum_d2))[0];
    let report = |merged| MergeReport { merged, into, reason: union.reason.clone() };
    match ids[..] {
        [a, b] => vec![report((a, b))],
        _ => ids.into_iter().filter(|id| *id != into).map(|id| report((into, id))).collect(),
    }
}

/// The paper's order: clusters by size, the largest against every smaller one.
pub(crate) fn in_order_of_size(state: &State, members: &[Vec<u32>]) -> Vec<(usize, usize)> {
    let mut order: Vec<usize> = (0..members.len()).filter(|&j| !state.clusters[j].locked).collect();
    order.sort_by_key(|&j| (std::cmp::Reverse(members[j].len()), j));
    let pairs =
        order.iter().enumerate().flat_map(|(rank, &a)| order[rank + 1..].iter().map(move |&b| (a, b)));
    pairs.collect()
}

/// The first of the pairs whose union passes the thresholds.
pub(crate) fn first_by_thresholds(
    state: &State,
    members: &[Vec<u32>],
    pairs: &[(usize, usize)],
    cache: &mut UnionCache,
    params: &Params,
    cancel: &Cancel,
) -> Option<(usize, usize, Union)> {
    for &(a, b) in pairs {
        let key = (state.clusters[a].revision, state.clusters[b].revision);
        let proposal = match cache.0.entry(key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(unknown) => {
                let pair = Pair::new(state, members, a, b);
                let proposal = pair.acceptable_union(params, cancel);
                // A cancelled fit says nothing about the pair.
                if cancel.is_requested() {
                    return None;
                }
                unknown.insert(proposal)
            }
        };
        if let Some(p) = proposal {
            return Some((a, b, p.clone()));
        }
    }
    None
}

/// One cluster, with this primitive, in the place of some by their indices: the
/// largest one's id stays.
pub(crate) fn union_change(
    state: &State,
    params: &Params,
    list: &[usize],
    shape: Superquadric,
    sum_d2: f64,
) -> Change {
    let members = state.members();
    // (Of equally large ones the first.)
    let largest = list.iter().copied().rev().max_by_key(|&j| members[j].len()).unwrap_or(0);
    let mut points: Vec<u32> = list.iter().flat_map(|&j| members[j].iter().copied()).collect();
    points.sort_unstable();
    let noise = Noise::Conditional(Draw::Revision(params.seed, Purpose::Merge), Some(sum_d2));
    let union = Successor { identity: Identity::Same(largest), shape, members: points, noise };
    Change { removed: list.to_vec(), added: vec![union], ..Change::default() }
}
