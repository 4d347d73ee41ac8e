//! Merging: propose one primitive for the points of two clusters, and test
//! it. Two rules: the authors' thresholds, and the energy.

use std::collections::BTreeSet;
use std::collections::btree_map::Entry;

use rayon::prelude::*;

use crate::geometry::Superquadric;
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::MergeReport;
use crate::inference::data::change::{Change, Draw, Identity, Noise, Successor};
use crate::inference::data::random_streams::Purpose;
use crate::inference::data::state::State;
use crate::inference::moves::configuration::Configuration;
use crate::inference::moves::paper_merge_test::Pair;
use crate::inference::moves::search::merge_reason;
use crate::inference::moves::union_cache::{Union, UnionCache};
use crate::inference::objective::energy;
use crate::inference::objective::energy::PrimitiveTerms;
use crate::inference::params::{MergeRule, Params};

/// Makes the best acceptable merge, if there is one.
pub(crate) fn merge_once(
    state: &mut State,
    cache: &mut UnionCache,
    params: &Params,
    cancel: &Cancel,
) -> Option<MergeReport> {
    let (a, b, proposal) = match params.merge {
        MergeRule::None => return None,
        MergeRule::Energy => best_by_energy(state, cache, params, cancel)?,
        MergeRule::Paper => {
            let members = state.members();
            let pairs = in_order_of_size(state, &members);
            first_by_thresholds(state, &members, &pairs, cache, params, cancel)?
        }
    };
    if cancel.is_requested() {
        return None;
    }
    let merged = (state.clusters[a].id, state.clusters[b].id);
    let change = union_change(state, params, &[a, b], proposal.shape, proposal.sum_d2);
    let into = state.apply(change)[0];
    Some(MergeReport { merged, into, reason: proposal.reason })
}

/// A pair of clusters, the energy that their merge would save, and the one
/// primitive in their place.
pub(crate) type Candidate<'c> = (f64, (usize, usize), &'c Union);

/// What the merges of some pairs would save, as far as their unions are worth
/// fitting. Fits are remembered, what a merge gains is not: it changes with the
/// neighbours, too. `None` when cancelled.
pub(crate) fn gains<'c>(
    state: &State,
    configuration: &Configuration<'_>,
    pairs: &BTreeSet<(usize, usize)>,
    before: f64,
    cache: &'c mut UnionCache,
) -> Option<Vec<Candidate<'c>>> {
    let model = &state.model;
    let key = |(a, b): (usize, usize)| (state.clusters[a].revision, state.clusters[b].revision);
    let missing: Vec<(usize, usize)> =
        pairs.iter().copied().filter(|&pair| !cache.0.contains_key(&key(pair))).collect();
    let fitted: Vec<Option<Union>> = missing
        .par_iter()
        .map(|&(a, b)| {
            let rough = configuration.rough_union(&[a, b], before)?;
            let (shape, points) = configuration.fit_union(&[a, b], &rough, before)?;
            let sum_d2 = model.sum_d2(&shape, &points);
            Some(Union { shape, sum_d2, reason: String::new() })
        })
        .collect();
    if configuration.cancel.is_requested() {
        return None;
    }
    for (&pair, proposal) in missing.iter().zip(fitted) {
        cache.0.insert(key(pair), proposal);
    }
    let gains = pairs.into_par_iter().filter_map(|&(a, b)| {
        let found = cache.0.get(&key((a, b)))?.as_ref()?;
        let gain = before - configuration.energy_with(&[a, b], &[PrimitiveTerms::new(model, found.shape)]);
        Some((gain, (a, b), found))
    });
    Some(gains.collect())
}

/// The pair of neighbours whose merge lowers the energy most.
fn best_by_energy(
    state: &State,
    cache: &mut UnionCache,
    params: &Params,
    cancel: &Cancel,
) -> Option<(usize, usize, Union)> {
    let model = &state.model;
    let configuration = Configuration::of(model, state, params, cancel);
    let before = configuration.energy();
    let (gain, (a, b), found) = gains(state, &configuration, &configuration.neighbors(), before, cache)?
        .into_iter()
        .filter(|candidate| candidate.0 > 0.0)
        .max_by(|x, y| x.0.total_cmp(&y.0))?;
    let reason = merge_reason(gain / energy::scale(model));
    Some((a, b, Union { reason, ..found.clone() }))
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
    let noise = Noise::Conditional(Draw::ByRevision(params.seed, Purpose::Merge), Some(sum_d2));
    let union = Successor { identity: Identity::Same(largest), shape, members: points, noise };
    Change { removed: list.to_vec(), added: vec![union], ..Change::default() }
}
