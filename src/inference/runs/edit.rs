//! What a person may change in the state of the sampler.

use std::fmt;
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::Superquadric;
use crate::geometry::brief::Brief;
use crate::geometry::theta::{Bounds, Invalid};
use crate::inference::control::{Cancel, InferenceError, Outcome, refuse};
use crate::inference::data::abstraction::{MergeReport, Occurrence, Phase, Primitive, UNASSIGNED};
use crate::inference::data::change::{Change, Draw, Identity, Noise, Successor};
use crate::inference::data::random_streams::{Purpose, stream};
use crate::inference::data::state::Cluster;
use crate::inference::fit::k_means::k_means;
use crate::inference::fit::points::{Effort, fit};
use crate::inference::fit::symmetric::{Detail, Surroundings};
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::moves::configuration::Configuration;
use crate::inference::moves::merge::union_change;
use crate::inference::moves::union_cache::Union;
use crate::inference::objective::energy::PrimitiveTerms;
use crate::inference::parameters::Setting;
use crate::inference::params::{MergeRule, SMALLEST_CLUSTER};
use crate::inference::runs::merge_proposal::MergeProposal;

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
    /// A primitive needs at least so many points.
    pub const FEWEST_POINTS: usize = SMALLEST_CLUSTER + 1;
}

/// Cuts by k-means that are tried when a primitive is cut in two, besides the
/// three across its axes.
const CUTS: u32 = 3;
/// Steps of the two-way fit after an edit: nothing follows that could mend.
const FIT_STEPS: usize = 25;

fn listed(ids: &[u32]) -> Vec<u32> {
    let mut ids = ids.to_vec();
    ids.sort_unstable();
    ids.dedup();
    ids
}

impl Sampler {
    pub(crate) fn edit(&mut self, edit: &Edit, cancel: &Cancel) -> Outcome<Vec<Occurrence>> {
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

    pub(crate) fn resample(&mut self, more: u32) -> Outcome<()> {
        let iterations = self.state.iteration.saturating_add(more.max(1));
        if iterations > Setting::Iterations.most() {
            let (made, most) = (self.state.iteration, Setting::Iterations.most());
            return refuse(format!(
                "the run already has {made} of at most {most} iterations; ask for fewer, or reset the run"
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
            || refuse(format!("there is no primitive {id} in this state; select another one")),
            Ok,
        )
    }

    /// The index of a primitive that may be changed.
    pub(crate) fn unlocked(&self, id: u32) -> Outcome<usize> {
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

    /// Whether the parameters test_cluster primitives by both directions.
    fn is_symmetric(&self) -> bool {
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
        let fit_points =
            fit(&gathered, warm, model.limits(), Effort::THOROUGH, self.params.fit_distance, cancel);
        let mut found = fit_points.map(|m| m.shape);
        if let Some(start) = found.filter(|_| self.is_symmetric()) {
            let others: Vec<Superquadric> = self
                .state
                .clusters
                .iter()
                .enumerate()
                .filter(|(j, _)| !without.contains(j))
                .map(|(_, c)| c.shape)
                .collect();
            let around = Surroundings::new(model, &others);
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

    /// A cluster with this primitive, whose σ is drawn from its points.
    fn successor(&self, identity: Identity, shape: Superquadric, members: Vec<u32>) -> Successor {
        let noise = Noise::Conditional(Draw::Revision(self.params.seed, Purpose::Edit), None);
        Successor { identity, shape, members, noise }
    }

    /// Gives a cluster its primitive.
    fn give(&mut self, j: usize, shape: Superquadric) {
        let added = vec![self.successor(Identity::Same(j), shape, self.members_of(j))];
        self.state.apply(Change { removed: vec![j], added, ..Change::default() });
    }

    /// Takes points, in ascending order, out of all clusters but `target`. Those
    /// that lose all of theirs die.
    fn withdraw(&self, samples: &[u32], target: Option<usize>) -> (Change, Vec<usize>) {
        let (mut change, mut dead) = (Change::default(), Vec::new());
        for (j, mut members) in self.state.members().into_iter().enumerate() {
            let before = members.len();
            members.retain(|i| samples.binary_search(i).is_err());
            if Some(j) == target || members.len() == before {
                continue;
            }
            change.removed.push(j);
            if members.is_empty() {
                dead.push(j);
            } else {
                let shape = self.state.clusters[j].shape;
                change.added.push(Successor {
                    identity: Identity::Same(j),
                    shape,
                    members,
                    noise: Noise::Kept,
                });
            }
        }
        (change, dead)
    }

    fn died(&self, dead: &[usize]) -> Vec<Occurrence> {
        dead.iter().map(|&j| Occurrence::Died { id: self.state.clusters[j].id }).collect()
    }

    fn set_shape(&mut self, id: u32, shape: &Superquadric) -> Outcome<Vec<Occurrence>> {
        let j = self.unlocked(id)?;
        let model = &self.state.model;
        let normalised = model.normalization.normalized_shape(shape);
        // (Converted there and back, a limit itself may be off by rounding.)
        let slack = |(low, high): (f64, f64)| (low - 1e-9, high + 1e-9);
        let bounds = Bounds {
            exponents: slack(Bounds::FITS.exponents),
            taper: slack(Bounds::FITS.taper),
            ..Bounds::RUN
        };
        normalised.check(&bounds).map_err(|problem| match problem {
            Invalid::Exponent(e, _) => Invalid::Exponent(e, Bounds::FITS.exponents),
            Invalid::Taper(k, _) => Invalid::Taper(k, Bounds::FITS.taper),
            other => other,
        })?;
        let least = model.axis_floor();
        if !normalised.semi_axes.iter().all(|a| *a >= least * (1.0 - 1e-9)) {
            let least = model.normalization.length(least);
            return refuse(format!(
                "a semi-axis must be at least {least:.3e}, a twentieth of the points' spacing"
            ));
        }
        let members = self.members_of(j);
        let edited =
            Successor { identity: Identity::Same(j), shape: normalised, members, noise: Noise::Kept };
        self.state.apply(Change { removed: vec![j], added: vec![edited], ..Change::default() });
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
            return refuse("a merge needs at least two primitives; select another one");
        }
        let list: Vec<usize> = ids.iter().map(|&id| self.unlocked(id)).collect::<Outcome<_>>()?;
        let mut points: Vec<u32> = list.iter().flat_map(|&j| self.members_of(j)).collect();
        points.sort_unstable();
        let warm: Vec<Superquadric> = list.iter().map(|&j| self.state.clusters[j].shape).collect();
        let shape = self.fitted(&points, &warm, &list, cancel)?;
        let sum_d2 = self.state.model.sum_d2(&shape, &points);
        let change = union_change(&self.state, &self.params, &list, shape, sum_d2);
        let into = self.state.apply(change)[0];
        self.settle_after_merge();
        Ok(vec![Occurrence::Joined { ids, into }])
    }

    fn accept_merge(&mut self, proposal: &MergeProposal) -> Outcome<Vec<Occurrence>> {
        let (a, b) = proposal.pair;
        let list = [self.unlocked(a)?, self.unlocked(b)?];
        let revisions = list.map(|j| self.state.clusters[j].revision);
        if a == b || revisions != [proposal.revisions.0, proposal.revisions.1] {
            return refuse(format!(
                "{a} and {b} have changed since their merge was proposed; request a new proposal"
            ));
        }
        let Union { shape, sum_d2, .. } = proposal.normalised;
        if !(shape.check(&Bounds::RUN).is_ok() && sum_d2 >= 0.0 && sum_d2.is_finite()) {
            return refuse("the proposed primitive is not valid; request a new proposal");
        }
        let change = union_change(&self.state, &self.params, &list, shape, sum_d2);
        let into = self.state.apply(change)[0];
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
            return refuse(format!(
                "{n} points are too few for two primitives, which need at least {least} each"
            ));
        }
        let state = &self.state;
        let model = &state.model;
        let points = model.gather(&members);
        let Cluster { shape, revision, .. } = &state.clusters[j];
        let cuts: Vec<Vec<bool>> = (0..CUTS)
            .map(|attempt| {
                let mut rng = stream(self.params.seed, Purpose::Cut, 2 << 8 | attempt, *revision as u32);
                k_means(&points, 2, &mut rng).into_iter().map(|part| part == 1).collect()
            })
            .chain((0..3).map(|axis| points.iter().map(|p| shape.local(p)[axis] > 0.0).collect()))
            .collect();
        let configuration = Configuration::of(model, state, &self.params, cancel);
        let candidates = cuts.into_par_iter().filter_map(|cut| {
            let parts = self.parts(&members, &cut);
            let shapes = [0, 1].map(|k| self.fitted(&parts[k], &[], &[j], cancel));
            let [Ok(first), Ok(second)] = shapes else { return None };
            let added = [first, second].map(|s| PrimitiveTerms::new(model, s));
            Some((configuration.energy_with(&[j], &added), parts, [first, second]))
        });
        let candidates: Vec<_> = candidates.collect();
        let best = candidates.into_iter().min_by(|x, y| x.0.total_cmp(&y.0));
        let Some((_, [kept, left], [first, second])) = best else {
            return refuse(format!(
                "primitive {id} cannot be split into two parts with enough points; select the points of one part \
                 and create a new cluster from them"
            ));
        };
        debug_assert!(kept.len() >= left.len());
        let added =
            vec![self.successor(Identity::Same(j), first, kept), self.successor(Identity::New, second, left)];
        let ids = self.state.apply(Change { removed: vec![j], added, ..Change::default() });
        Ok(vec![Occurrence::Halved { id, into: ids[1] }])
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
        let (mut removed, mut told) = (Vec::new(), Vec::new());
        for &id in &ids {
            let j = self.unlocked(id)?;
            removed.push(j);
            told.push(Occurrence::Deleted { id, points: self.members_of(j).len() });
        }
        self.state.apply(Change { removed, ..Change::default() });
        Ok(told)
    }

    fn new_cluster(&mut self, samples: &[u32], cancel: &Cancel) -> Outcome<Vec<Occurrence>> {
        let samples = self.movable(samples)?;
        let (_, mut told) = self.create(&samples, cancel)?;
        // They have left what they were pinned to.
        self.state.pinned = self.without(&samples);
        told.rotate_right(1);
        Ok(told)
    }

    /// Makes a fitted cluster of some points; the last occurrence says so.
    fn create(&mut self, samples: &[u32], cancel: &Cancel) -> Outcome<(u32, Vec<Occurrence>)> {
        let (mut change, dead) = self.withdraw(samples, None);
        // What has held them hides nothing of their surface.
        let shape = self.fitted(samples, &[], &change.removed, cancel)?;
        let mut told = self.died(&dead);
        change.added.push(self.successor(Identity::New, shape, samples.to_vec()));
        let id = self.state.apply(change).pop().unwrap_or(UNASSIGNED);
        told.push(Occurrence::Created { id, points: samples.len() });
        Ok((id, told))
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
                let cluster = &self.state.clusters[j];
                let (mut change, dead) = self.withdraw(&samples, Some(j));
                let members = listed(&[self.members_of(j), samples.clone()].concat());
                let without: Vec<usize> = dead.iter().copied().chain([j]).collect();
                let shape = self.fitted(&members, &[cluster.shape], &without, cancel)?;
                let (id, told) = (cluster.id, self.died(&dead));
                change.removed.push(j);
                change.added.push(self.successor(Identity::Same(j), shape, members));
                self.state.apply(change);
                (id, told)
            }
            None => self.create(&samples, cancel)?,
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
            return refuse("none of these points is pinned");
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
