//! What a person may change in the state of the sampler.

use std::fmt;
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::abstraction::{MergeReport, Occurrence, Phase, Primitive, UNASSIGNED};
use super::checkpoint::is_sound;
use super::energy::Piece;
use super::fit::{Effort, fit, sum_squared_radial};
use super::kmeans::kmeans;
use super::merge::{self, Union};
use super::params::{MergeRule, Params};
use super::proposal::MergeProposal;
use super::refine::Layout;
use super::sampler::{Cancel, InferenceError, Sampler};
use super::state::{Cluster, SMALLEST_CLUSTER};
use super::streams::{Purpose, stream};
use super::trust_region::{EXPONENTS, LARGEST_TAPER};
use super::two_way::{Detail, Surroundings};
use crate::geometry::Superquadric;
use crate::geometry::brief::Brief;

/// A change by hand. Primitives are told by id, samples by their index in the
/// cloud; lengths are in input units.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Edit {
    /// Gives a primitive another shape, in input units; its points and σ stay.
    SetShape { id: u32, shape: Superquadric },
    /// Fits a primitive to its points; σ follows.
    Refit { id: u32 },
    /// Lets the sampler leave a primitive and its points alone, or no more.
    Lock { id: u32, locked: bool },
    /// Makes one primitive, fitted to all their points, of two or more,
    /// whatever the test says; the largest one's id stays.
    Merge { ids: Vec<u32> },
    /// Makes one primitive, exactly the shown one, of two.
    AcceptMerge { proposal: Box<MergeProposal> },
    /// Cuts a primitive in two, the best of a few cuts; the larger part keeps
    /// the id.
    Split { id: u32 },
    /// Deletes primitives; their points become unassigned.
    Delete { ids: Vec<u32> },
    /// Takes samples out of their clusters and makes them one of their own.
    NewCluster { samples: Vec<u32> },
    /// "These belong together": all join the primitive that holds most of them,
    /// or a new one if none does, which is fitted again, and they are pinned:
    /// no step takes them from it.
    Together { samples: Vec<u32> },
    /// Lets go of pinned samples.
    Release { samples: Vec<u32> },
    /// Takes these primitives, in input units, in place of all, and the run is
    /// finished. Samples have these labels (ids; one each), or without any each
    /// joins the nearest primitive but for outliers. A σ of 0 is drawn anew.
    Take { primitives: Vec<Primitive>, labels: Vec<u32> },
}

impl fmt::Debug for Edit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SetShape { id, .. } => write!(f, "SetShape({id})"),
            Self::Refit { id } => write!(f, "Refit({id})"),
            Self::Lock { id, locked } => write!(f, "Lock({id}, {locked})"),
            Self::Merge { ids } => write!(f, "Merge({:?})", Brief::of(ids)),
            Self::AcceptMerge { proposal } => write!(f, "AcceptMerge({proposal:?})"),
            Self::Split { id } => write!(f, "Split({id})"),
            Self::Delete { ids } => write!(f, "Delete({:?})", Brief::of(ids)),
            Self::NewCluster { samples } => write!(f, "NewCluster({:?})", Brief::of(samples)),
            Self::Together { samples } => write!(f, "Together({:?})", Brief::of(samples)),
            Self::Release { samples } => write!(f, "Release({:?})", Brief::of(samples)),
            Self::Take { primitives, .. } => write!(f, "Take({:?})", Brief::of_told(primitives)),
        }
    }
}

impl Edit {
    /// Limits of the exponents ε1 and ε2, as fits keep them.
    pub const EXPONENTS: (f64, f64) = EXPONENTS;
    /// Largest |kx| and |ky|, as fits keep them.
    pub const LARGEST_TAPER: f64 = LARGEST_TAPER;
    /// A primitive needs at least so many points.
    pub const FEWEST_POINTS: usize = SMALLEST_CLUSTER + 1;
}

/// Cuts by k-means that are tried when a primitive is cut in two, besides the
/// three across its axes.
const CUTS: u32 = 3;
/// Steps of the two-way fit after an edit: nothing follows that could mend.
const FIT_STEPS: usize = 25;

pub(super) type Outcome<T> = Result<T, InferenceError>;

pub(super) fn refuse<T>(problem: impl Into<String>) -> Outcome<T> {
    Err(InferenceError::Edit(problem.into()))
}

fn listed(ids: &[u32]) -> Vec<u32> {
    let mut ids = ids.to_vec();
    ids.sort_unstable();
    ids.dedup();
    ids
}

impl Sampler {
    pub(super) fn edit(&mut self, edit: &Edit, cancel: &Cancel) -> Outcome<Vec<Occurrence>> {
        let mut next = self.clone();
        let told = match edit {
            Edit::SetShape { id, shape } => next.set_shape(*id, shape),
            Edit::Refit { id } => next.refit(*id, cancel),
            Edit::Lock { id, locked } => next.lock(*id, *locked),
            Edit::Merge { ids } => next.merge(ids, cancel),
            Edit::AcceptMerge { proposal } => next.accept_merge(proposal),
            Edit::Split { id } => next.split(*id, cancel),
            Edit::Delete { ids } => next.delete(ids),
            Edit::NewCluster { samples } => next.new_cluster(samples, cancel),
            Edit::Together { samples } => next.together(samples, cancel),
            Edit::Release { samples } => next.release(samples),
            Edit::Take { primitives, labels } => next.take(primitives, labels, cancel),
        };
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        let told = told?;
        *self = next;
        Ok(told)
    }

    pub(super) fn resample(&mut self, more: u32) -> Outcome<()> {
        let iterations = self.state.iteration.saturating_add(more.max(1));
        if iterations > Params::ITERATIONS.1 {
            let (made, most) = (self.state.iteration, Params::ITERATIONS.1);
            return refuse(format!(
                "{made} iterations are made, and a run has {most} at most; ask for fewer, or reset"
            ));
        }
        self.params.iterations = iterations;
        if self.phase != Phase::Start {
            self.phase = Phase::Sampling;
        }
        Ok(())
    }

    fn index_of(&self, id: u32) -> Outcome<usize> {
        self.state.clusters.iter().position(|c| c.id == id).map_or_else(
            || refuse(format!("there is no primitive {id} in this state; select one that there is")),
            Ok,
        )
    }

    /// The index of a primitive that may be changed.
    pub(super) fn unlocked(&self, id: u32) -> Outcome<usize> {
        let j = self.index_of(id)?;
        if self.state.clusters[j].locked {
            return refuse(format!("primitive {id} is locked; unlock it first"));
        }
        Ok(j)
    }

    /// Indices of samples that may be moved, in ascending order.
    fn movable(&self, samples: &[u32]) -> Outcome<Vec<u32>> {
        let samples = listed(samples);
        let count = self.state.labels.len();
        if let Some(i) = samples.iter().find(|i| **i as usize >= count) {
            return refuse(format!("there is no sample {i}; the cloud has {count}"));
        }
        if samples.is_empty() {
            return refuse("no points are selected; select some first");
        }
        for &i in &samples {
            let cluster = self.state.clusters.get(self.state.labels[i as usize] as usize);
            if let Some(cluster) = cluster.filter(|c| c.locked) {
                let id = cluster.id;
                return refuse(format!(
                    "some of the points belong to primitive {id}, which is locked; unlock it first"
                ));
            }
        }
        Ok(samples)
    }

    fn members_of(&self, j: usize) -> Vec<u32> {
        let labels = (0u32..).zip(&self.state.labels);
        labels.filter(|(_, l)| **l as usize == j).map(|(i, _)| i).collect()
    }

    /// Whether the parameters judge primitives by both directions.
    fn is_two_way(&self) -> bool {
        self.params.refine || self.params.merge == MergeRule::Energy
    }

    /// The best primitive for some points, next to all but those at `without`.
    fn fitted(
        &self,
        points: &[u32],
        warm: &[Superquadric],
        without: &[usize],
        cancel: &Cancel,
    ) -> Outcome<Superquadric> {
        let n = points.len();
        if n <= SMALLEST_CLUSTER {
            return refuse(format!("{n} points are too few; a primitive needs more than {SMALLEST_CLUSTER}"));
        }
        let model = &self.state.model;
        let gathered = model.gather(points);
        let floor = model.axis_floor();
        let one_way = fit(&gathered, warm, floor, Effort::THOROUGH, self.params.fit_distance, cancel);
        let mut found = one_way.map(|m| m.shape);
        if let Some(start) = found.filter(|_| self.is_two_way()) {
            let others: Vec<Superquadric> = self
                .state
                .clusters
                .iter()
                .enumerate()
                .filter(|(j, _)| !without.contains(j))
                .map(|(_, c)| c.shape)
                .collect();
            let around = Surroundings {
                field: &model.field,
                spacing: model.spacing,
                smallest_axis: floor,
                others: &others,
            };
            let fits = std::iter::once(&start)
                .chain(warm)
                .filter_map(|start| around.fit(&gathered, start, FIT_STEPS, Detail::Full, cancel));
            found = fits.min_by(|a, b| a.1.total_cmp(&b.1)).map(|best| best.0);
        }
        match found {
            Some(shape) => Ok(shape),
            None if cancel.is_requested() => Err(InferenceError::Cancelled),
            None => refuse(format!("no primitive can be fitted to these {n} points; select others")),
        }
    }

    /// Gives a cluster its primitive, and draws σ from its points.
    fn give(&mut self, j: usize, shape: Superquadric) {
        let members = self.members_of(j);
        let state = &mut self.state;
        for &i in &members {
            state.frozen[i as usize] = false;
        }
        let revision = state.new_revision();
        let sum_d2 = sum_squared_radial(&shape, &state.model.gather(&members));
        let mut rng = stream(self.params.seed, Purpose::Edit, state.iteration, revision as u32);
        let sigma = state.model.draw_sigma(sum_d2, members.len(), &mut rng);
        let cluster = &mut state.clusters[j];
        (cluster.shape, cluster.sigma, cluster.revision) = (shape, sigma, revision);
    }

    /// A new cluster without points, whose primitive is still to be given.
    fn add(&mut self, shape: Superquadric) -> usize {
        let state = &mut self.state;
        let (id, revision, sigma) = (state.new_id(), state.new_revision(), state.model.sigma_floor());
        state.clusters.push(Cluster { id, revision, shape, sigma, locked: false });
        state.clusters.len() - 1
    }

    /// Moves points to a cluster. Clusters that lose all of theirs die.
    fn move_to(&mut self, samples: &[u32], j: usize) -> Vec<Occurrence> {
        let id = self.state.clusters[j].id;
        let mut lost = vec![false; self.state.clusters.len()];
        for &i in samples {
            let label = std::mem::replace(&mut self.state.labels[i as usize], j as u32);
            if label != UNASSIGNED && label as usize != j {
                lost[label as usize] = true;
            }
            self.state.frozen[i as usize] = false;
        }
        let members = self.state.members();
        let mut gone = vec![false; lost.len()];
        for (k, _) in lost.iter().enumerate().filter(|(_, lost)| **lost) {
            gone[k] = members[k].is_empty();
            self.state.clusters[k].revision = self.state.new_revision();
        }
        let dead = self.state.clusters.iter().zip(&gone).filter(|(c, gone)| **gone && c.id != id);
        let told = dead.map(|(c, _)| Occurrence::Died { id: c.id }).collect();
        self.state.remove_clusters(&gone);
        told
    }

    fn set_shape(&mut self, id: u32, shape: &Superquadric) -> Outcome<Vec<Occurrence>> {
        let j = self.unlocked(id)?;
        let model = &self.state.model;
        let (e, k) = (Edit::EXPONENTS, Edit::LARGEST_TAPER);
        // (Converted there and back, a limit itself may be off by rounding.)
        let slack = 1e-9;
        let normalised = model.frame.normalized_shape(shape);
        let least = model.axis_floor();
        if !shape.exponents.iter().all(|v| (e.0 - slack..=e.1 + slack).contains(v)) {
            return refuse(format!("ε1 and ε2 must lie between {} and {}", e.0, e.1));
        }
        if !shape.taper.iter().all(|v| v.abs() <= k + slack) {
            return refuse(format!("the taper must lie between −{k} and {k}"));
        }
        if !normalised.semi_axes.iter().all(|a| *a >= least * (1.0 - slack)) {
            let least = model.frame.length(least);
            return refuse(format!(
                "a semi-axis must be at least {least:.3e}, a twentieth of the points' spacing"
            ));
        }
        if !is_sound(&normalised) {
            return refuse("the shape is too large or too far from the cloud, or its rotation is none");
        }
        for i in self.members_of(j) {
            self.state.frozen[i as usize] = false;
        }
        let revision = self.state.new_revision();
        let cluster = &mut self.state.clusters[j];
        (cluster.shape, cluster.revision) = (normalised, revision);
        Ok(vec![Occurrence::Edited { id }])
    }

    fn refit(&mut self, id: u32, cancel: &Cancel) -> Outcome<Vec<Occurrence>> {
        let j = self.unlocked(id)?;
        let shape = self.fitted(&self.members_of(j), &[self.state.clusters[j].shape], &[j], cancel)?;
        self.give(j, shape);
        Ok(vec![Occurrence::Refitted { id }])
    }

    fn lock(&mut self, id: u32, locked: bool) -> Outcome<Vec<Occurrence>> {
        let j = self.index_of(id)?;
        if std::mem::replace(&mut self.state.clusters[j].locked, locked) == locked {
            return Ok(Vec::new());
        }
        Ok(vec![if locked { Occurrence::Locked { id } } else { Occurrence::Unlocked { id } }])
    }

    fn merge(&mut self, ids: &[u32], cancel: &Cancel) -> Outcome<Vec<Occurrence>> {
        let ids = listed(ids);
        if ids.len() < 2 {
            return refuse("a merge needs two primitives or more; select another one");
        }
        let list: Vec<usize> = ids.iter().map(|&id| self.unlocked(id)).collect::<Outcome<_>>()?;
        let mut points: Vec<u32> = list.iter().flat_map(|&j| self.members_of(j)).collect();
        points.sort_unstable();
        let warm: Vec<Superquadric> = list.iter().map(|&j| self.state.clusters[j].shape).collect();
        let shape = self.fitted(&points, &warm, &list, cancel)?;
        let sum_d2 = sum_squared_radial(&shape, &self.state.model.gather(&points));
        let into = merge::apply(&mut self.state, &self.params, &list, shape, sum_d2);
        self.settle_after_merge();
        Ok(vec![Occurrence::Joined { ids, into }])
    }

    fn accept_merge(&mut self, proposal: &MergeProposal) -> Outcome<Vec<Occurrence>> {
        let (a, b) = proposal.pair;
        let list = [self.unlocked(a)?, self.unlocked(b)?];
        let revisions = list.map(|j| self.state.clusters[j].revision);
        if a == b || revisions != [proposal.revisions.0, proposal.revisions.1] {
            return refuse(format!(
                "{a} and {b} have changed since their merge was proposed; have it proposed again"
            ));
        }
        let Union { shape, sum_d2, .. } = proposal.normalised;
        if !(is_sound(&shape) && sum_d2 >= 0.0 && sum_d2.is_finite()) {
            return refuse("the proposed primitive is none; have it proposed again");
        }
        let into = merge::apply(&mut self.state, &self.params, &list, shape, sum_d2);
        self.settle_after_merge();
        let reason = proposal.reason.clone();
        Ok(vec![Occurrence::Merged(MergeReport { merged: (a, b), into, reason })])
    }

    /// The best of some cuts by the energy.
    fn split(&mut self, id: u32, cancel: &Cancel) -> Outcome<Vec<Occurrence>> {
        let j = self.unlocked(id)?;
        let members = self.members_of(j);
        let (n, least) = (members.len(), SMALLEST_CLUSTER + 1);
        if n < 2 * least {
            return refuse(format!("{n} points are too few for two primitives, which need {least} each"));
        }
        let state = &self.state;
        let model = &state.model;
        let points = model.gather(&members);
        let Cluster { shape, revision, .. } = &state.clusters[j];
        let cuts: Vec<Vec<bool>> = (0..CUTS)
            .map(|attempt| {
                let mut rng = stream(self.params.seed, Purpose::Cut, 2 << 8 | attempt, *revision as u32);
                kmeans(&points, 2, &mut rng).into_iter().map(|part| part == 1).collect()
            })
            .chain((0..3).map(|axis| points.iter().map(|p| shape.local(p)[axis] > 0.0).collect()))
            .collect();
        let layout = Layout::of(model, state, &self.params, cancel);
        let candidates = cuts.into_par_iter().filter_map(|cut| {
            let parts = self.parts(&members, &cut);
            let shapes = [0, 1].map(|k| self.fitted(&parts[k], &[], &[j], cancel));
            let [Ok(first), Ok(second)] = shapes else { return None };
            let added = [first, second].map(|s| Piece::new(model, s));
            Some((layout.energy_with(&[j], &added), parts, [first, second]))
        });
        let candidates: Vec<_> = candidates.collect();
        let best = candidates.into_iter().min_by(|x, y| x.0.total_cmp(&y.0));
        let Some((_, [kept, left], [first, second])) = best else {
            return refuse(format!(
                "no cut of primitive {id} leaves each part points enough; select those of one part and make \
                 a new cluster of them"
            ));
        };
        debug_assert!(kept.len() >= left.len());
        let new = self.add(second);
        for &i in &left {
            self.state.labels[i as usize] = new as u32;
        }
        self.give(j, first);
        self.give(new, second);
        Ok(vec![Occurrence::Halved { id, into: self.state.clusters[new].id }])
    }

    /// The two parts of a cut, the larger first; pinned points stay together.
    fn parts(&self, members: &[u32], cut: &[bool]) -> [Vec<u32>; 2] {
        let pinned = |(i, _): &(&u32, &bool)| self.state.is_pinned(**i);
        let (there, all) = members
            .iter()
            .zip(cut)
            .filter(pinned)
            .fold((0, 0), |(there, all), (_, cut)| (there + usize::from(*cut), all + 1));
        let mut parts = [Vec::new(), Vec::new()];
        for (&i, &cut) in members.iter().zip(cut) {
            let side = if self.state.is_pinned(i) { 2 * there > all } else { cut };
            parts[usize::from(side)].push(i);
        }
        parts.sort_by_key(|part| std::cmp::Reverse(part.len()));
        parts
    }

    fn delete(&mut self, ids: &[u32]) -> Outcome<Vec<Occurrence>> {
        let ids = listed(ids);
        if ids.is_empty() {
            return refuse("no primitive is selected; select one first");
        }
        let mut gone = vec![false; self.state.clusters.len()];
        let mut told = Vec::new();
        for &id in &ids {
            let j = self.unlocked(id)?;
            gone[j] = true;
            let members = self.members_of(j);
            for &i in &members {
                self.state.frozen[i as usize] = false;
            }
            told.push(Occurrence::Deleted { id, points: members.len() });
        }
        self.state.remove_clusters(&gone);
        Ok(told)
    }

    fn new_cluster(&mut self, samples: &[u32], cancel: &Cancel) -> Outcome<Vec<Occurrence>> {
        let samples = self.movable(samples)?;
        let mut told = self.create(&samples, cancel)?;
        // They have left what they were pinned to.
        self.state.pinned = self.without(&samples);
        told.rotate_right(1);
        Ok(told)
    }

    /// Makes a fitted cluster of some points; the last occurrence says so.
    fn create(&mut self, samples: &[u32], cancel: &Cancel) -> Outcome<Vec<Occurrence>> {
        // What has held them hides nothing of their surface.
        let mut sources: Vec<usize> =
            samples.iter().map(|&i| self.state.labels[i as usize] as usize).collect();
        sources.sort_unstable();
        sources.dedup();
        let shape = self.fitted(samples, &[], &sources, cancel)?;
        let new = self.add(shape);
        let id = self.state.clusters[new].id;
        let mut told = self.move_to(samples, new);
        let new = self.index_of(id)?;
        self.give(new, shape);
        told.push(Occurrence::Created { id, points: samples.len() });
        Ok(told)
    }

    fn together(&mut self, samples: &[u32], cancel: &Cancel) -> Outcome<Vec<Occurrence>> {
        let samples = self.movable(samples)?;
        let mut counts = vec![0usize; self.state.clusters.len()];
        for &i in &samples {
            if let Some(count) = counts.get_mut(self.state.labels[i as usize] as usize) {
                *count += 1;
            }
        }
        let most = (0..counts.len()).rev().filter(|&j| counts[j] > 0).max_by_key(|&j| counts[j]);
        let (id, mut told) = match most {
            Some(j) => {
                let id = self.state.clusters[j].id;
                let told = self.move_to(&samples, j);
                let j = self.index_of(id)?;
                let warm = [self.state.clusters[j].shape];
                let shape = self.fitted(&self.members_of(j), &warm, &[j], cancel)?;
                self.give(j, shape);
                (id, told)
            }
            None => {
                let told = self.create(&samples, cancel)?;
                (self.state.next_id - 1, told)
            }
        };
        let pinned: Vec<u32> = self.state.pinned.iter().chain(&samples).copied().collect();
        self.state.pinned = listed(&pinned).into();
        told.push(Occurrence::Pinned { id, points: samples.len() });
        told.reverse();
        Ok(told)
    }

    fn release(&mut self, samples: &[u32]) -> Outcome<Vec<Occurrence>> {
        let kept = self.without(&listed(samples));
        let points = self.state.pinned.len() - kept.len();
        if points == 0 {
            return refuse("none of these points is pinned; there is nothing to release");
        }
        self.state.pinned = kept;
        Ok(vec![Occurrence::Released { points }])
    }

    /// The pinned points without some, which are in ascending order.
    fn without(&self, samples: &[u32]) -> Arc<[u32]> {
        let pinned = self.state.pinned.iter().copied();
        pinned.filter(|i| samples.binary_search(i).is_err()).collect()
    }
}
