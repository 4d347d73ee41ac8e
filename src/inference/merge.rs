//! Merging: propose one primitive for the points of two clusters, and test
//! it. Two rules: the authors' thresholds, and the energy.

use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::abstraction::MergeReport;
use super::checkpoint::RememberedUnion;
use super::energy::{self, Piece};
use super::fit::sum_squared_radial;
use super::params::{MergeRule, Params};
use super::refine::{Layout, merge_reason};
use super::sampler::Cancel;
use super::state::State;
use super::streams::{Purpose, stream};
use super::thresholds::Pair;
use crate::geometry::Superquadric;

/// One primitive for two clusters, in the normalised frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Union {
    pub shape: Superquadric,
    /// Σ d² of the union.
    pub sum_d2: f64,
    /// Why it is acceptable, where the rule remembers that.
    pub reason: String,
}

/// Proposals by the revisions of the two clusters: what did not change since
/// needs no second fit. `None`: tried, and not acceptable.
#[derive(Debug, Clone, Default)]
pub(crate) struct MergeCache(BTreeMap<(u64, u64), Option<Union>>);

impl MergeCache {
    /// The union of two clusters by revision, if it was worth fitting.
    pub(crate) fn get(&self, revisions: (u64, u64)) -> Option<&Union> {
        self.0.get(&revisions)?.as_ref()
    }

    /// The proposals of clusters that are `alive`, by revision, as plain data.
    pub(crate) fn remembered(&self, alive: &BTreeSet<u64>) -> Vec<RememberedUnion> {
        let kept = self.0.iter().filter(|((a, b), _)| alive.contains(a) && alive.contains(b));
        kept.map(|(&revisions, union)| RememberedUnion { revisions, union: union.clone() }).collect()
    }

    pub(crate) fn of(remembered: &[RememberedUnion]) -> Self {
        Self(remembered.iter().map(|r| (r.revisions, r.union.clone())).collect())
    }

    /// Forgets proposals of clusters that are not `alive`, by revision.
    pub(crate) fn retain(&mut self, alive: &BTreeSet<u64>) {
        self.0.retain(|(a, b), _| alive.contains(a) && alive.contains(b));
    }
}

/// Makes the best acceptable merge, if there is one.
pub(crate) fn merge_once(
    state: &mut State,
    cache: &mut MergeCache,
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
    let into = apply(state, params, &[a, b], proposal.shape, proposal.sum_d2);
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
    layout: &Layout<'_>,
    pairs: &BTreeSet<(usize, usize)>,
    before: f64,
    cache: &'c mut MergeCache,
) -> Option<Vec<Candidate<'c>>> {
    let model = &state.model;
    let key = |(a, b): (usize, usize)| (state.clusters[a].revision, state.clusters[b].revision);
    let missing: Vec<(usize, usize)> =
        pairs.iter().copied().filter(|&pair| !cache.0.contains_key(&key(pair))).collect();
    let fitted: Vec<Option<Union>> = missing
        .par_iter()
        .map(|&(a, b)| {
            let glimpse = layout.glance_at_union(&[a, b], before)?;
            let (shape, points) = layout.fit_union(&[a, b], &glimpse, before)?;
            let sum_d2 = sum_squared_radial(&shape, &model.gather(&points));
            Some(Union { shape, sum_d2, reason: String::new() })
        })
        .collect();
    if layout.cancel.is_requested() {
        return None;
    }
    for (&pair, proposal) in missing.iter().zip(fitted) {
        cache.0.insert(key(pair), proposal);
    }
    let gains = pairs.into_par_iter().filter_map(|&(a, b)| {
        let found = cache.0.get(&key((a, b)))?.as_ref()?;
        let gain = before - layout.energy_with(&[a, b], &[Piece::new(model, found.shape)]);
        Some((gain, (a, b), found))
    });
    Some(gains.collect())
}

/// The pair of neighbours whose merge lowers the energy most.
fn best_by_energy(
    state: &State,
    cache: &mut MergeCache,
    params: &Params,
    cancel: &Cancel,
) -> Option<(usize, usize, Union)> {
    let model = &state.model;
    let layout = Layout::of(model, state, params, cancel);
    let before = layout.energy();
    let (gain, (a, b), found) = gains(state, &layout, &layout.neighbors(), before, cache)?
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
    cache: &mut MergeCache,
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

/// Makes one cluster of some by their indices, with this primitive; the largest
/// one's id stays, and is returned.
pub(crate) fn apply(
    state: &mut State,
    params: &Params,
    list: &[usize],
    shape: Superquadric,
    sum_d2: f64,
) -> u32 {
    let members = state.members();
    // (Of equally large ones the first.)
    let keep = list.iter().copied().rev().max_by_key(|&j| members[j].len()).unwrap_or(0);
    let n = list.iter().map(|&j| members[j].len()).sum();
    let mut gone = vec![false; state.clusters.len()];
    for &j in list {
        gone[j] = j != keep;
        for &i in &members[j] {
            state.labels[i as usize] = keep as u32;
            state.frozen[i as usize] = false;
        }
    }
    let revision = state.new_revision();
    let mut rng = stream(params.seed, Purpose::Merge, state.iteration, revision as u32);
    let sigma = state.model.draw_sigma(sum_d2, n, &mut rng);
    let cluster = &mut state.clusters[keep];
    (cluster.shape, cluster.sigma, cluster.revision) = (shape, sigma, revision);
    let into = cluster.id;
    state.remove_clusters(&gone);
    into
}
