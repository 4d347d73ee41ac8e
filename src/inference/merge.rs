//! Merging: propose one primitive for the points of two clusters, and test
//! it. Two rules: the authors' thresholds, and the energy.

use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::abstraction::MergeReport;
use super::adjust::LATE_ITERATION;
use super::checkpoint::RememberedUnion;
use super::energy::{self, Piece};
use super::fit::{Effort, fit, sum_squared_radial};
use super::params::{MergeRule, Params};
use super::refine::{Layout, merge_reason};
use super::sampler::Cancel;
use super::state::State;
use super::streams::{Purpose, stream};
use crate::geometry::Superquadric;

/// Paper: the pair must fill this share of what holds both.
const FILL: f64 = 0.7;
/// Paper: mean squared relative radial error under which a union is good.
const RELATIVE: f64 = 5e-3;
/// Paper: mean d² under which a union is good, in the first pass and later.
const MEAN_D2: (f64, f64) = (1e-3, 1e-2);

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
        MergeRule::Paper => first_by_thresholds(state, &state.members(), cache, params, cancel)?,
    };
    if cancel.is_requested() {
        return None;
    }
    Some(apply(state, params, a, b, proposal))
}

fn union(members: &[Vec<u32>], a: usize, b: usize) -> Vec<u32> {
    let mut all: Vec<u32> = members[a].iter().chain(&members[b]).copied().collect();
    all.sort_unstable();
    all
}

/// The pair of neighbours whose merge lowers the energy most. Fits are
/// remembered, what a merge gains is not: it changes with the neighbours, too.
fn best_by_energy(
    state: &State,
    cache: &mut MergeCache,
    params: &Params,
    cancel: &Cancel,
) -> Option<(usize, usize, Union)> {
    let model = &state.model;
    let layout = Layout::of(model, state, params, cancel);
    let before = layout.energy();
    let key = |(a, b): (usize, usize)| (state.clusters[a].revision, state.clusters[b].revision);
    let pairs = layout.neighbors();
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
    if cancel.is_requested() {
        return None;
    }
    for (&pair, proposal) in missing.iter().zip(fitted) {
        cache.0.insert(key(pair), proposal);
    }
    let (gain, (a, b), found) = pairs
        .into_par_iter()
        .filter_map(|(a, b)| {
            let found = cache.0.get(&key((a, b)))?.as_ref()?;
            let gain = before - layout.energy_with(&[a, b], &[Piece::new(model, found.shape)]);
            (gain > 0.0).then_some((gain, (a, b), found))
        })
        .collect::<Vec<_>>()
        .into_iter()
        .max_by(|x, y| x.0.total_cmp(&y.0))?;
    let reason = merge_reason(gain / energy::scale(model));
    Some((a, b, Union { reason, ..found.clone() }))
}

/// The paper's order: clusters by size, the largest against every smaller one.
fn first_by_thresholds(
    state: &State,
    members: &[Vec<u32>],
    cache: &mut MergeCache,
    params: &Params,
    cancel: &Cancel,
) -> Option<(usize, usize, Union)> {
    let mut order: Vec<usize> = (0..members.len()).collect();
    order.sort_by_key(|&j| (std::cmp::Reverse(members[j].len()), j));
    for (rank, &a) in order.iter().enumerate() {
        for &b in &order[rank + 1..] {
            let key = (state.clusters[a].revision, state.clusters[b].revision);
            let proposal = match cache.0.entry(key) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(unknown) => {
                    let proposal = propose_by_thresholds(state, members, (a, b), params, cancel);
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
    }
    None
}

fn propose_by_thresholds(
    state: &State,
    members: &[Vec<u32>],
    (a, b): (usize, usize),
    params: &Params,
    cancel: &Cancel,
) -> Option<Union> {
    let model = &state.model;
    let (first, second) = (&state.clusters[a].shape, &state.clusters[b].shape);
    let parts = [model.gather(&members[a]), model.gather(&members[b])];
    let points = model.gather(&union(members, a, b));
    let box_volume = |points: &[nalgebra::Point3<f64>]| {
        let mut lo = Vector3::repeat(f64::INFINITY);
        let mut hi = Vector3::repeat(f64::NEG_INFINITY);
        for p in points {
            let p = first.local(p);
            lo = lo.inf(&p);
            hi = hi.sup(&p);
        }
        (hi - lo).product()
    };
    if box_volume(&parts[0]) + box_volume(&parts[1]) < FILL * box_volume(&points) {
        return None;
    }
    let m =
        fit(&points, &[*first, *second], model.axis_floor(), Effort::THOROUGH, params.fit_distance, cancel)?;
    if first.volume() + second.volume() < FILL * m.shape.volume() {
        return None;
    }
    let relative = |shape: &Superquadric, points: &[nalgebra::Point3<f64>]| {
        let sum: f64 = points
            .iter()
            .map(|p| {
                let q = shape.untapered(&shape.local(p)).norm().max(model.axis_floor());
                (shape.radial_distance(p) / q).powi(2)
            })
            .sum();
        sum / points.len().max(1) as f64
    };
    let mean_d2 = |shape: &Superquadric, points: &[nalgebra::Point3<f64>]| {
        sum_squared_radial(shape, points) / points.len().max(1) as f64
    };
    let joint_relative = relative(&m.shape, &points);
    let worse_relative = relative(first, &parts[0]).max(relative(second, &parts[1]));
    let n = points.len().max(1) as f64;
    let joint = mean_d2(&m.shape, &points);
    let worse = mean_d2(first, &parts[0]).max(mean_d2(second, &parts[1]));
    let limit = if state.iteration <= LATE_ITERATION { MEAN_D2.0 } else { MEAN_D2.1 };
    let reason = if joint_relative <= worse_relative {
        format!("relative error² {joint_relative:.1e} is no worse than {worse_relative:.1e} of the two alone")
    } else if joint_relative < RELATIVE {
        format!("relative error² {joint_relative:.1e} is below {RELATIVE:.1e}")
    } else if joint < limit {
        format!("mean d² {joint:.1e} is below {limit:.1e}")
    } else if joint < worse {
        format!("mean d² {joint:.1e} is less than {worse:.1e} of the two alone")
    } else {
        return None;
    };
    Some(Union { shape: m.shape, sum_d2: joint * n, reason })
}

/// Replaces clusters `a` and `b` by the proposal; the larger one's id stays.
fn apply(state: &mut State, params: &Params, a: usize, b: usize, proposal: Union) -> MergeReport {
    let members = state.members();
    let (keep, drop) = if members[b].len() > members[a].len() { (b, a) } else { (a, b) };
    let n = members[a].len() + members[b].len();
    for &i in &members[drop] {
        state.labels[i as usize] = keep as u32;
    }
    for &i in members[a].iter().chain(&members[b]) {
        state.frozen[i as usize] = false;
    }
    let revision = state.new_revision();
    let mut rng = stream(params.seed, Purpose::Merge, state.iteration, revision as u32);
    let sigma = state.model.draw_sigma(proposal.sum_d2, n, &mut rng);
    let (into, merged) = (state.clusters[keep].id, (state.clusters[a].id, state.clusters[b].id));
    let cluster = &mut state.clusters[keep];
    (cluster.shape, cluster.sigma, cluster.revision) = (proposal.shape, sigma, revision);
    let mut gone = vec![false; state.clusters.len()];
    gone[drop] = true;
    state.remove_clusters(&gone);
    MergeReport { merged, into, reason: proposal.reason }
}
