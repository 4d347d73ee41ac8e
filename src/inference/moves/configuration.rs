//! The primitives of one moment with all that a proposal is judged by.

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::geometry::{Superquadric, kernel};
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::UNASSIGNED;
use crate::inference::data::limits::Limits;
use crate::inference::data::model::Model;
use crate::inference::data::state::State;
use crate::inference::fit::points::{Effort, boxes_and_plates, fit};
use crate::inference::fit::symmetric::{Detail, PSEUDO_HUBER_DELTA, Surroundings, pseudo_huber};
use crate::inference::objective::energy;
use crate::inference::objective::energy::{OUTLIER_SPACINGS, PrimitiveTerms, is_lonely};
use crate::inference::objective::energy_cache::EnergyCache;
use crate::inference::params::{Params, SMALLEST_CLUSTER};

/// Steps of the two-way fit of a primitive that is only proposed; it is
/// polished when it has been accepted.
const PROPOSAL_STEPS: usize = 8;
/// A lonely point is an outlier beyond this many times the root mean square
/// distance of its primitive's points (and [`OUTLIER_SPACINGS`]).
const OUTLIER_SIGMAS: f64 = 4.0;

/// Primitives that one may go on behind another with, at most.
const ACROSS: usize = 3;

/// A proposal is given up where its shapes, before their two-way fit, are worse
/// than what they replace by more than so many prices of a primitive: a union
/// at first glance, a union fitted to its points, and the parts of a cut fitted
/// to theirs. Of the proposals that come out well these keep 97 in 100.
const HOPELESS_ROUGH: f64 = 3.0;
/// Points that a first look is taken at.
const ROUGH_POINTS: usize = 200;
const HOPELESS_UNION: f64 = 2.0;
const HOPELESS_CUT: f64 = 3.0;

/// Primitives, their points, and their surroundings.
pub(crate) struct Configuration<'a> {
    pub(crate) model: &'a Model,
    pub(crate) params: &'a Params,
    pub(crate) cancel: &'a Cancel,
    pub(crate) cache: EnergyCache,
    /// The points of each primitive.
    pub(crate) members: Vec<Vec<u32>>,
    /// Primitives that stay as they are.
    pub(crate) locked: Vec<bool>,
    /// Points that stay with their primitive; empty where there are none.
    held: Vec<bool>,
}

/// Which primitive one of a configuration is, and in which version.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Version {
    /// Its index in the state; none where a move has made it.
    pub(crate) place: Option<usize>,
    pub(crate) id: u32,
    pub(crate) revision: u64,
}

/// A first look at a union.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoughUnion {
    shape: Superquadric,
    /// By how many prices of a primitive the energy would rise.
    pub(crate) rise: f64,
}

/// Some primitives in the place of others.
#[derive(Debug, Clone)]
pub(crate) struct Proposal {
    /// Indices of the primitives that it replaces.
    pub(crate) removed: Vec<usize>,
    pub(crate) added: Vec<PrimitiveTerms>,
    /// The points of each of them.
    pub(crate) members: Vec<Vec<u32>>,
    /// By how much the energy falls.
    pub(crate) gain: f64,
}

impl<'a> Configuration<'a> {
    /// Primitives that no points belong to yet, and nobody has tied.
    pub(crate) fn new(
        model: &'a Model,
        shapes: &[Superquadric],
        params: &'a Params,
        cancel: &'a Cancel,
    ) -> Self {
        let primitives = shapes.par_iter().map(|shape| PrimitiveTerms::new(model, *shape)).collect();
        let cache = EnergyCache::new(model, primitives);
        let (members, locked) = (vec![Vec::new(); shapes.len()], vec![false; shapes.len()]);
        Self { model, params, cancel, cache, members, locked, held: Vec::new() }
    }

    /// The state as a configuration: its labels are the members.
    pub(crate) fn of(model: &'a Model, state: &State, params: &'a Params, cancel: &'a Cancel) -> Self {
        let shapes: Vec<Superquadric> = state.clusters.iter().map(|c| c.shape).collect();
        let locked: Vec<bool> = state.clusters.iter().map(|c| c.locked).collect();
        let is_free = state.pinned.is_empty() && !locked.contains(&true);
        let count = if is_free { 0 } else { state.labels.len() as u32 };
        let held = (0..count).map(|i| state.is_held(i)).collect();
        Self { members: state.members(), locked, held, ..Self::new(model, &shapes, params, cancel) }
    }

    pub(crate) fn primitives(&self) -> &[PrimitiveTerms] {
        self.cache.primitives()
    }

    /// Changes the list of primitives.
    pub(crate) fn change_primitives(&mut self, change: impl FnOnce(&mut Vec<PrimitiveTerms>)) {
        let mut primitives = self.cache.take_primitives();
        change(&mut primitives);
        self.cache = EnergyCache::new(self.model, primitives);
    }

    fn is_held(&self, i: u32) -> bool {
        self.held.get(i as usize).is_some_and(|held| *held)
    }

    /// Whether a person has tied the primitive, or points to it.
    pub(crate) fn is_tied(&self, j: usize) -> bool {
        self.locked[j] || self.members[j].iter().any(|&i| self.is_held(i))
    }

    /// Gives every point to the nearest primitive, but for outliers and those
    /// that are held.
    pub(crate) fn assign(&mut self) {
        let mut members = vec![Vec::new(); self.primitives().len()];
        let present = if self.held.is_empty() { Vec::new() } else { self.labels() };
        for (i, nearest) in (0u32..).zip(self.cache.nearest()) {
            let stays = self.is_held(i).then(|| present[i as usize]);
            if let Some(j) = stays.or(nearest) {
                members[j as usize].push(i);
            }
        }
        for (primitive, list) in self.primitives().iter().zip(&mut members) {
            let square = |i: &u32| f64::from(primitive.distances[*i as usize]).powi(2);
            // (Outliers themselves may not stretch the limit.)
            let inner: Vec<f64> = list.iter().filter(|i| !is_lonely(self.model, **i)).map(square).collect();
            let rms = (inner.iter().sum::<f64>() / inner.len().max(1) as f64).sqrt();
            let limit = (OUTLIER_SPACINGS * self.model.spacing).max(OUTLIER_SIGMAS * rms);
            list.retain(|&i| {
                f64::from(primitive.distances[i as usize]) <= limit
                    || !is_lonely(self.model, i)
                    || self.is_held(i)
            });
        }
        self.members = members;
    }

    /// Labels by index of primitive.
    pub(crate) fn labels(&self) -> Vec<u32> {
        let mut labels = vec![UNASSIGNED; self.model.points.len()];
        for (j, list) in (0u32..).zip(&self.members) {
            for &i in list {
                labels[i as usize] = j;
            }
        }
        labels
    }

    /// Pairs of primitives that are not locked and of which some points are
    /// neighbours (or, where one side is seen, that are near each other), each with the smaller index first.
    pub(crate) fn neighbors(&self) -> BTreeSet<(usize, usize)> {
        let labels = self.labels();
        let mut pairs = BTreeSet::new();
        for (i, &a) in (0u32..).zip(&labels) {
            for &k in self.model.graph.of(i) {
                let b = labels[k as usize];
                if a < b && b != UNASSIGNED && !self.locked[a as usize] && !self.locked[b as usize] {
                    pairs.insert((a as usize, b as usize));
                }
            }
        }
        if self.model.known.is_some() {
            pairs.extend(self.across());
        }
        pairs
    }

    /// Each primitive with those that are nearest to it for its size: what is seen of
    /// a body on either side of another is not connected.
    fn across(&self) -> BTreeSet<(usize, usize)> {
        let free: Vec<usize> = (0..self.primitives().len()).filter(|&j| !self.locked[j]).collect();
        let mut found = BTreeSet::new();
        for &a in &free {
            let apart = |b: usize| self.primitives()[a].apart(&self.primitives()[b]);
            let mut others: Vec<usize> = free.iter().copied().filter(|&b| b != a && apart(b) < 1.0).collect();
            others.sort_by(|&b, &c| apart(b).total_cmp(&apart(c)));
            found.extend(others.into_iter().take(ACROSS).map(|b| (a.min(b), a.max(b))));
        }
        found
    }

    pub(crate) fn energy(&self) -> f64 {
        self.cache.error() + energy::price(self.model, self.params, self.primitives().len())
    }

    /// The energy with the primitives `added` in the place of those at `removed`.
    pub(crate) fn energy_with(&self, removed: &[usize], added: &[PrimitiveTerms]) -> f64 {
        let count = self.primitives().len() - removed.len() + added.len();
        self.cache.error_with(self.model, removed, added) + energy::price(self.model, self.params, count)
    }

    /// What the next primitive would cost.
    pub(crate) fn price_of_one_more(&self) -> f64 {
        let count = self.primitives().len();
        let price = |count| energy::price(self.model, self.params, count);
        price(count + 1) - price(count)
    }

    /// What the points and the visible surface of each primitive add to the
    /// energy: about the most that a change of it alone can save.
    pub(crate) fn own_errors(&self) -> Vec<f64> {
        (0..self.primitives().len()).map(|j| self.points_error(j) + self.cache.surface_cost(j)).collect()
    }

    fn points_error(&self, j: usize) -> f64 {
        let distances = &self.primitives()[j].distances;
        self.members[j]
            .iter()
            .map(|&i| pseudo_huber(f64::from(distances[i as usize]), self.model.spacing))
            .sum()
    }

    /// The best primitive for some points by its distance to them alone; where
    /// one side is seen also the best of any size, since the smallest may be too
    /// small. None where no fit comes to anything.
    pub(crate) fn fit_points(
        &self,
        points: &[u32],
        warm: &[Superquadric],
        effort: Effort,
    ) -> Vec<Superquadric> {
        let gathered = self.model.gather(points);
        let limits = self.model.limits();
        let of_any_size = (limits.pull > 0.0).then_some(Limits { pull: 0.0, ..limits });
        let fitted = |limits| fit(&gathered, warm, limits, effort, self.params.fit_distance, self.cancel);
        std::iter::once(limits).chain(of_any_size).filter_map(fitted).map(|m| m.shape).collect()
    }

    /// The best two-way fit to some points from several starts, next to
    /// `others`.
    pub(crate) fn fit_symmetric(
        &self,
        points: &[u32],
        starts: &[Superquadric],
        others: &[Superquadric],
        steps: usize,
        detail: Detail,
    ) -> Option<Superquadric> {
        let around = Surroundings::new(self.model, others);
        let gathered = self.model.gather(points);
        starts
            .iter()
            .filter_map(|start| around.fit(&gathered, start, steps, detail, self.cancel))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|best| best.0)
    }

    /// The primitives that may hide some of the surface of primitive `j`.
    pub(crate) fn around(&self, j: usize) -> impl Iterator<Item = &Superquadric> {
        let primitive = &self.primitives()[j];
        let others = self
            .primitives()
            .iter()
            .enumerate()
            .filter(move |(k, other)| *k != j && primitive.may_touch(other));
        others.map(|(_, other)| &other.shape)
    }

    pub(crate) fn others(&self, without: &[usize]) -> Vec<Superquadric> {
        let kept = self.primitives().iter().enumerate().filter(|(j, _)| !without.contains(j));
        kept.map(|(_, primitive)| primitive.shape).collect()
    }

    /// By how many prices of a primitive the energy would rise with these shapes
    /// in the place of some primitives.
    fn rise(&self, removed: &[usize], shapes: &[Superquadric], before: f64) -> f64 {
        let added: Vec<PrimitiveTerms> =
            shapes.iter().map(|s| PrimitiveTerms::with(self.model, *s, Detail::Rough)).collect();
        (self.energy_with(removed, &added) - before) / self.price_of_one_more()
    }

    /// New shapes in the place of some primitives, against the energy `before`;
    /// `None` unless it falls.
    fn propose(
        &self,
        removed: Vec<usize>,
        parts: Vec<(Superquadric, Vec<u32>)>,
        before: f64,
    ) -> Option<Proposal> {
        let (added, members): (Vec<PrimitiveTerms>, Vec<Vec<u32>>) =
            parts.into_iter().map(|(shape, points)| (PrimitiveTerms::new(self.model, shape), points)).unzip();
        let gain = before - self.energy_with(&removed, &added);
        (gain > 0.0 && !self.cancel.is_requested()).then_some(Proposal { removed, added, members, gain })
    }

    /// Leaves a primitive out.
    pub(crate) fn propose_removal(&self, j: usize, before: f64) -> Option<Proposal> {
        self.propose(vec![j], Vec::new(), before)
    }

    /// One primitive for the points of several.
    pub(crate) fn propose_merge(&self, list: &[usize], before: f64) -> Option<Proposal> {
        self.propose_union(list, &self.rough_union(list, before)?, before)
    }

    /// The same from the first look on.
    pub(crate) fn propose_union(&self, list: &[usize], rough: &RoughUnion, before: f64) -> Option<Proposal> {
        let (shape, points) = self.fit_union(list, rough, before)?;
        self.propose(list.to_vec(), vec![(shape, points)], before)
    }

    /// The points of several primitives, in order of index.
    pub(crate) fn union(&self, list: &[usize]) -> Vec<u32> {
        let mut points: Vec<u32> = list.iter().flat_map(|&j| self.members[j].iter().copied()).collect();
        points.sort_unstable();
        points
    }

    /// A first look at one primitive for the points of several; `None` where it
    /// is far from being worth having.
    pub(crate) fn rough_union(&self, list: &[usize], before: f64) -> Option<RoughUnion> {
        let points = self.union(list);
        let mut shapes = self.rough_shapes(list, &points);
        // The points alone say as much in most cases.
        let gathered = self.model.gather(&points).into_iter().collect();
        let alone: f64 = list.iter().map(|&j| self.points_error(j)).sum();
        let most = alone + HOPELESS_ROUGH * self.price_of_one_more() * list.len() as f64;
        let delta = PSEUDO_HUBER_DELTA * self.model.spacing;
        shapes.retain(|shape| kernel::pseudo_huber_cost(shape, &gathered, delta) <= most);
        self.best_of(list, shapes, before).filter(|rough| rough.rise < HOPELESS_ROUGH)
    }

    /// The shape in the place of some primitives by which the energy rises least.
    fn best_of(&self, list: &[usize], shapes: Vec<Superquadric>, before: f64) -> Option<RoughUnion> {
        let unions =
            shapes.into_iter().map(|shape| RoughUnion { shape, rise: self.rise(list, &[shape], before) });
        unions.min_by(|a, b| a.rise.total_cmp(&b.rise))
    }

    fn rough_shapes(&self, list: &[usize], points: &[u32]) -> Vec<Superquadric> {
        let largest = list.iter().max_by_key(|&&j| self.members[j].len());
        let Some(&largest) = largest.filter(|_| points.len() > SMALLEST_CLUSTER) else { return Vec::new() };
        let few: Vec<u32> = points.iter().step_by(points.len().div_ceil(ROUGH_POINTS)).copied().collect();
        let shape = self.primitives()[largest].shape;
        let mut shapes = self.fit_points(&few, &[shape], Effort::ROUGH);
        if self.model.known.is_some() {
            shapes.extend(boxes_and_plates(&self.model.gather(points), &shape, self.model.axis_floor()));
        }
        shapes
    }

    /// A first look, however little it is worth having.
    pub(crate) fn any_rough_union(&self, list: &[usize], before: f64) -> Option<RoughUnion> {
        self.best_of(list, self.rough_shapes(list, &self.union(list)), before)
    }

    /// One primitive for the points of several, however little it is worth
    /// having.
    pub(crate) fn any_union(&self, list: &[usize]) -> Option<Superquadric> {
        let points = self.union(list);
        let starts = self.fit_points(&points, &self.rough_shapes(list, &points), Effort::THOROUGH);
        self.fit_symmetric(&points, &starts, &self.others(list), PROPOSAL_STEPS, Detail::Rough)
    }

    /// One primitive for the points of several, from the first look on, and
    /// those points; `None` where it is far from being worth having.
    pub(crate) fn fit_union(
        &self,
        list: &[usize],
        rough: &RoughUnion,
        before: f64,
    ) -> Option<(Superquadric, Vec<u32>)> {
        let points = self.union(list);
        let mut starts = self.fit_points(&points, &[rough.shape], Effort::THOROUGH);
        if self.model.known.is_some() {
            // Points on one side leave open what the energy has told.
            starts.push(rough.shape);
        }
        starts.retain(|start| self.rise(list, &[*start], before) <= HOPELESS_UNION);
        let shape =
            self.fit_symmetric(&points, &starts, &self.others(list), PROPOSAL_STEPS, Detail::Rough)?;
        Some((shape, points))
    }

    /// Moves points that are held into the part that has most of them.
    fn keep_together(&self, parts: &mut [Vec<u32>]) {
        let held: Vec<usize> = parts.iter().map(|p| p.iter().filter(|&&i| self.is_held(i)).count()).collect();
        let Some(most) = (0..parts.len()).filter(|&k| held[k] > 0).max_by_key(|&k| held[k]) else { return };
        let mut moved = Vec::new();
        for (k, part) in parts.iter_mut().enumerate().filter(|(k, _)| *k != most) {
            if held[k] > 0 {
                moved.extend(part.extract_if(.., |i| self.is_held(*i)));
            }
        }
        parts[most].extend(moved);
        parts[most].sort_unstable();
    }

    /// One primitive for each part of the points of one; `part` gives the part
    /// of each of its points. Parts that are too small are left to the others.
    pub(crate) fn propose_cut(&self, j: usize, part: &[u32], before: f64) -> Option<Proposal> {
        let count = part.iter().max().map_or(0, |p| *p as usize + 1);
        let mut parts = vec![Vec::new(); count];
        for (&i, &p) in self.members[j].iter().zip(part) {
            parts[p as usize].push(i);
        }
        self.keep_together(&mut parts);
        parts.retain(|p| p.len() > SMALLEST_CLUSTER || p.iter().any(|&i| self.is_held(i)));
        if parts.len() < 2 {
            return None;
        }
        // Not from the whole, which is near each part's points as well.
        let fitted: Vec<Vec<Superquadric>> =
            parts.iter().map(|p| self.fit_points(p, &[], Effort::THOROUGH)).collect();
        let starts: Vec<Superquadric> = fitted.iter().map(|s| s.first().copied()).collect::<Option<_>>()?;
        if self.rise(&[j], &starts, before) > HOPELESS_CUT {
            return None;
        }
        let around = self.others(&[j]);
        let mut added = Vec::with_capacity(parts.len());
        for (k, points) in parts.iter().enumerate() {
            let siblings = starts.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, s)| *s);
            let others: Vec<Superquadric> = around.iter().copied().chain(siblings).collect();
            let shape = self.fit_symmetric(points, &fitted[k], &others, PROPOSAL_STEPS, Detail::Rough)?;
            added.push((shape, points.clone()));
        }
        self.propose(vec![j], added, before)
    }
}

/// Each primitive with all its neighbours, and all that are connected: of a
/// hollow body's two walls no two patches make a better one, all together do.
pub(crate) fn groups(count: usize, pairs: &BTreeSet<(usize, usize)>) -> Vec<Vec<usize>> {
    let stars = neighborhoods(count, pairs).into_iter().map(|star| star.into_iter().collect());
    let found: BTreeSet<Vec<usize>> = stars.chain(components(count, pairs)).collect();
    found.into_iter().filter(|list| list.len() > 2).collect()
}

/// All primitives that are connected, by pairs.
pub(crate) fn components(count: usize, pairs: &BTreeSet<(usize, usize)>) -> Vec<Vec<usize>> {
    let near = neighborhoods(count, pairs);
    let mut seen = vec![false; count];
    let mut found = Vec::new();
    for first in 0..count {
        let mut component = Vec::new();
        let mut next = vec![first];
        while let Some(j) = next.pop() {
            if !std::mem::replace(&mut seen[j], true) {
                component.push(j);
                next.extend(&near[j]);
            }
        }
        component.sort_unstable();
        found.push(component);
    }
    found
}

/// Each primitive with its neighbours.
fn neighborhoods(count: usize, pairs: &BTreeSet<(usize, usize)>) -> Vec<BTreeSet<usize>> {
    let mut near: Vec<BTreeSet<usize>> = (0..count).map(|j| BTreeSet::from([j])).collect();
    for &(a, b) in pairs {
        near[a].insert(b);
        near[b].insert(a);
    }
    near
}
