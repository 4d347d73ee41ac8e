//! The end of a run: the sampler has found the parts; what remains is done by
//! descent on the description length (see [`super::score`]): points go to the
//! primitive that explains them best, primitives are refitted, split where
//! two explain more than they cost, and merged where one does.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::abstraction::{Occurrence, UNASSIGNED};
use super::adjust::bridges;
use super::fit::{Effort, fit, sum_squared_radial};
use super::kmeans::kmeans;
use super::merge::{MergeCache, merge_once};
use super::params::Params;
use super::sampler::Cancel;
use super::score::{Description, describe};
use super::state::{Cluster, SMALLEST_CLUSTER, State};
use super::streams::{Purpose, stream};
use crate::geometry::Superquadric;
use crate::geometry::kernel::{self, Distance};

/// Rounds of assignment, fit, split and merge at most.
const ROUNDS: u32 = 6;
/// Random cuts that are tried of each cluster.
const CUTS: u32 = 2;
/// A lonely point farther than this many mean spacings from every primitive
/// (and this many standard deviations of its noise) is an outlier and stays
/// unassigned; lonely is who has fewer neighbours than a surface gives.
const OUTLIER_SPACINGS: f64 = 2.0;
const OUTLIER_SIGMAS: f64 = 4.0;
const LONELY: usize = 4;

/// Refines the state until nothing changes any more.
pub(crate) fn refine(
    state: &mut State,
    cache: &mut MergeCache,
    params: &Params,
    cancel: &Cancel,
    occurrences: &mut Vec<Occurrence>,
) {
    state.frozen.fill(false);
    let mut settled = Settled::default();
    for _ in 0..ROUNDS {
        let before = state.labels.clone();
        assign(state);
        refit(state, &mut settled, params, cancel);
        let split = split_all(state, &mut settled, params, cancel, occurrences);
        let mut merged = false;
        while let Some(report) = merge_once(state, cache, params, cancel) {
            merged = true;
            occurrences.push(Occurrence::Merged(report));
        }
        if cancel.is_requested() || (!split && !merged && before == state.labels) {
            break;
        }
    }
    assign(state);
    let model = state.model.clone();
    for (j, points) in state.members().iter().enumerate() {
        let cluster = &mut state.clusters[j];
        let sum_d2 = sum_squared_radial(&cluster.shape, &model.gather(points));
        let mut rng = stream(params.seed, Purpose::Refined, state.iteration, cluster.id);
        cluster.sigma = model.draw_sigma(sum_d2, points.len(), &mut rng);
    }
    // The last assignment moved points under unchanged revisions.
    *cache = MergeCache::default();
}

/// What need not be tried again.
#[derive(Default)]
struct Settled {
    /// By id, the revision and the points of a cluster when it was last fitted.
    fitted: BTreeMap<u32, (u64, Vec<u32>)>,
    /// Revisions of clusters that no cut has improved.
    whole: BTreeSet<u64>,
}

/// Description of every cluster's present points.
fn describe_all(state: &State, primitive_cost: f64) -> Vec<Description> {
    let members = state.members();
    let model = &state.model;
    (0..members.len())
        .into_par_iter()
        .map(|j| {
            let points = model.gather(&members[j]);
            describe(&state.clusters[j].shape, &points, model.points.len(), model.spacing, primitive_cost)
        })
        .collect()
}

/// Gives each point to the primitive under which it costs least, and removes
/// clusters that end up too small. A cluster keeps only its largest connected
/// component: the others go where they cost least among their neighbours.
fn assign(state: &mut State) {
    // Each round but the last removes a cluster, so this ends.
    while !assign_once(state) {}
}

/// One assignment; whether every cluster came out large enough.
fn assign_once(state: &mut State) -> bool {
    let model = state.model.clone();
    let total = model.points.len() as f64;
    let members = state.members();
    let gone: Vec<bool> = members.iter().map(|m| m.len() <= SMALLEST_CLUSTER).collect();
    state.remove_clusters(&gone);
    if state.clusters.is_empty() {
        return true;
    }
    // What a point costs has no share in what its primitive does.
    let described = describe_all(state, 0.0);
    let members = state.members();
    // ln A + ½ ln 2πσ² − ln(n/N), and σ, of each cluster.
    let terms: Vec<(f64, f64)> = described
        .iter()
        .zip(&members)
        .map(|(d, m)| (d.per_point - (m.len() as f64 / total).ln(), d.sigma))
        .collect();
    // By cluster, then by point.
    let prices: Vec<Vec<f64>> = state
        .clusters
        .par_iter()
        .zip(&terms)
        .map(|(cluster, (base, sigma))| {
            let mut prices = Vec::new();
            kernel::distances(&cluster.shape, &model.block, Distance::FirstOrder, &mut prices);
            for d in &mut prices {
                *d = base + 0.5 * (*d / sigma).powi(2);
            }
            prices
        })
        .collect();
    let cheapest = |i: usize, allowed: &dyn Fn(u32) -> bool| {
        (0u32..)
            .zip(&prices)
            .filter(|(j, _)| allowed(*j))
            .min_by(|a, b| a.1[i].total_cmp(&b.1[i]))
            .map_or(UNASSIGNED, |best| best.0)
    };
    let mut labels: Vec<u32> =
        (0..model.points.len()).into_par_iter().map(|i| cheapest(i, &|_| true)).collect();
    // Points cut off from the largest component of their cluster look for a
    // neighbour that has one; a few rounds let labels travel into islands.
    std::mem::swap(&mut state.labels, &mut labels);
    for _ in 0..4 {
        let mut islands: Vec<u32> = Vec::new();
        for (j, m) in (0u32..).zip(state.members()) {
            islands.extend(state.components(j, &m).into_iter().skip(1).flatten());
        }
        if islands.is_empty() {
            break;
        }
        let mut moved = Vec::new();
        for &i in &islands {
            let own = state.labels[i as usize];
            let around: Vec<u32> =
                model.graph.of(i).iter().map(|&k| state.labels[k as usize]).filter(|&l| l != own).collect();
            let label = cheapest(i as usize, &|j| around.contains(&j));
            if label != UNASSIGNED {
                moved.push((i, label));
            }
        }
        for (i, label) in moved {
            state.labels[i as usize] = label;
        }
    }
    for (i, p) in (0u32..).zip(&model.points) {
        let label = &mut state.labels[i as usize];
        if *label != UNASSIGNED && model.graph.of(i).len() < LONELY {
            let limit = (OUTLIER_SPACINGS * model.spacing).max(OUTLIER_SIGMAS * terms[*label as usize].1);
            if state.clusters[*label as usize].shape.first_order_distance(p) > limit {
                *label = UNASSIGNED;
            }
        }
    }
    state.members().iter().all(|m| m.len() > SMALLEST_CLUSTER)
}

/// Fits the primitives whose points changed since they were last fitted.
fn refit(state: &mut State, settled: &mut Settled, params: &Params, cancel: &Cancel) {
    let members = state.members();
    let changed = |j: usize| {
        let cluster = &state.clusters[j];
        settled.fitted.get(&cluster.id).is_none_or(|(r, m)| *r != cluster.revision || *m != members[j])
    };
    let stale: Vec<usize> = (0..members.len()).filter(|&j| changed(j)).collect();
    let model = state.model.clone();
    let fits: Vec<_> = stale
        .par_iter()
        .map(|&j| {
            let points = model.gather(&members[j]);
            let found = fit(
                &points,
                &[state.clusters[j].shape],
                model.axis_floor(),
                Effort::THOROUGH,
                params.fit_distance,
                cancel,
            )?;
            let total = model.points.len();
            let length = |shape| describe(shape, &points, total, model.spacing, params.primitive_cost).length;
            (length(&found.shape) < length(&state.clusters[j].shape)).then_some(found.shape)
        })
        .collect();
    for (j, shape) in stale.into_iter().zip(fits) {
        if let Some(shape) = shape {
            state.clusters[j].shape = shape;
        }
        // Its points have changed even where its shape has not.
        let revision = state.new_revision();
        state.clusters[j].revision = revision;
        settled.fitted.insert(state.clusters[j].id, (revision, members[j].clone()));
    }
}

/// Tries to cut every cluster in two; keeps the cuts that shorten the
/// description. Says whether there was one.
fn split_all(
    state: &mut State,
    settled: &mut Settled,
    params: &Params,
    cancel: &Cancel,
    occurrences: &mut Vec<Occurrence>,
) -> bool {
    let members = state.members();
    let model = state.model.clone();
    let total = model.points.len();
    let described = describe_all(state, params.primitive_cost);
    type Cut = (f64, [(Vec<u32>, Superquadric); 2]);
    let cuts: Vec<Option<Cut>> = (0..members.len())
        .into_par_iter()
        .map(|j| {
            let points = model.gather(&members[j]);
            // A bridge is cut at any price.
            let least =
                if bridges(&model, &state.clusters[j].shape, &members[j]) { f64::NEG_INFINITY } else { 0.0 };
            let mut best: Option<Cut> = None;
            if settled.whole.contains(&state.clusters[j].revision) {
                return None;
            }
            for attempt in 0..CUTS {
                let revision = state.clusters[j].revision as u32;
                let mut rng = stream(params.seed, Purpose::Cut, attempt, revision);
                let half = kmeans(&points, 2, &mut rng);
                let mut length = 0.0;
                let mut parts = Vec::with_capacity(2);
                for side in 0..2 {
                    let keep: Vec<u32> =
                        members[j].iter().zip(&half).filter(|h| *h.1 == side).map(|h| *h.0).collect();
                    if keep.len() <= SMALLEST_CLUSTER {
                        break;
                    }
                    let part = model.gather(&keep);
                    let warm = [state.clusters[j].shape];
                    let Some(m) =
                        fit(&part, &warm, model.axis_floor(), Effort::THOROUGH, params.fit_distance, cancel)
                    else {
                        break;
                    };
                    length += describe(&m.shape, &part, total, model.spacing, params.primitive_cost).length;
                    parts.push((keep, m.shape));
                }
                let gain = described[j].length - length;
                if let Ok(parts) = <[_; 2]>::try_from(parts)
                    && gain > best.as_ref().map_or(least, |b| b.0)
                {
                    best = Some((gain, parts));
                }
            }
            best
        })
        .collect();
    if cancel.is_requested() {
        return false;
    }
    let mut any = false;
    for (j, cut) in cuts.into_iter().enumerate() {
        let Some((gain, [first, second])) = cut else {
            settled.whole.insert(state.clusters[j].revision);
            continue;
        };
        any = true;
        let id = state.new_id();
        occurrences.push(Occurrence::Cut { id: state.clusters[j].id, gain });
        occurrences.push(Occurrence::Born { id, points: second.0.len() });
        let other = state.clusters.len() as u32;
        for &i in &second.0 {
            state.labels[i as usize] = other;
        }
        let sigma = state.clusters[j].sigma;
        state.clusters[j].shape = first.1;
        let revision = state.new_revision();
        state.clusters[j].revision = revision;
        let revision = state.new_revision();
        state.clusters.push(Cluster { id, revision, shape: second.1, sigma });
    }
    any
}
