//! The run as a machine of steps: Algorithm 1 of the paper.

use std::sync::Arc;

use rayon::prelude::*;

use crate::geometry::kernel::Distance;
use crate::geometry::{SampleCloud, kernel};
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::data::abstraction::{
    Abstraction, Figures, MergeReport, Occurrence, Phase, Primitive, UNASSIGNED,
};
use crate::inference::data::change::{Draw, Noise};
use crate::inference::data::model::{Model, distinct, sum_squared_radial};
use crate::inference::data::normalization::Normalization;
use crate::inference::data::random_streams::{Purpose, stream};
use crate::inference::data::state::State;
use crate::inference::fit::k_means::k_means;
use crate::inference::fit::moments::ellipsoid_of_moments;
use crate::inference::fit::points::{Effort, START_SHRINK, fit};
use crate::inference::gibbs::log_joint::log_joint;
use crate::inference::gibbs::separate;
use crate::inference::gibbs::sweep::sweep;
use crate::inference::moves::merge::merge_once;
use crate::inference::moves::merge_search::merge_all;
use crate::inference::moves::paper_merge_test::LATE_ITERATION;
use crate::inference::moves::search;
use crate::inference::moves::union_cache::UnionCache;
use crate::inference::params::{MergeRule, Params, SMALLEST_CLUSTER};

/// Iterations between two merge passes.
const MERGE_INTERVAL: u32 = 15;
/// The fits of the first iterations, and of every so many later ones, explore
/// other starts and configurations than that of the iteration before.
const EXPLORE_FIRST: u32 = 3;
const EXPLORE_INTERVAL: u32 = 6;
/// Mean d² under which a cluster's points are frozen, where freezing is on.
const FREEZE: f64 = 5e-3;

/// A run of the sampler. `Clone` is a checkpoint: a clone continued gives the
/// same bits as the original continued.
#[derive(Debug, Clone)]
pub struct Sampler {
    pub(crate) params: Params,
    pub(crate) state: State,
    pub(crate) phase: Phase,
    pub(crate) cache: UnionCache,
}

impl Sampler {
    /// Starts a run: normalises the cloud and clusters it by k-means.
    pub fn new(cloud: Arc<SampleCloud>, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        params.check().map_err(InferenceError::Params)?;
        Self::start(State::empty(Self::model_of(&cloud, cancel)?), params, cancel)
    }

    /// What depends on the cloud alone.
    pub(crate) fn model_of(cloud: &SampleCloud, cancel: &Cancel) -> Result<Arc<Model>, InferenceError> {
        let normalization = Normalization::of(&cloud.points);
        let places = distinct(&cloud.points);
        let (Some(normalization), true) = (normalization, places.len() > SMALLEST_CLUSTER) else {
            return Err(InferenceError::TooFewPoints { points: places.len() });
        };
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        Ok(Arc::new(Model::new(normalization, &cloud.points, &cloud.viewpoints)))
    }

    /// A run from the start on the same cloud, whose neighbourhoods need not be
    /// found again. Locked primitives stay with their id, shape, σ and points,
    /// and the K clusters start on the other points. Pinned points of others are
    /// let go of: what they were pinned to is gone.
    pub fn restarted(&self, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        params.check().map_err(InferenceError::Params)?;
        Self::start(self.state.only_locked(), params, cancel)
    }

    /// The same without what is locked.
    pub(crate) fn anew(&self, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        params.check().map_err(InferenceError::Params)?;
        Self::start(State::empty(Arc::clone(&self.state.model)), params, cancel)
    }

    /// K clusters on the points that the state has no label for.
    fn start(mut state: State, params: Params, cancel: &Cancel) -> Result<Self, InferenceError> {
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        state.model = state.model.seen(params.sight());
        let mut rng = stream(params.seed, Purpose::KMeans, 0, 0);
        let free: Vec<u32> =
            (0u32..).zip(&state.labels).filter(|(_, l)| **l == UNASSIGNED).map(|(i, _)| i).collect();
        let points = state.model.gather(&free);
        let labels = k_means(&points, params.clusters as usize, &mut rng);
        let kept = state.clusters.len();
        let count = labels.iter().max().map_or(0, |m| *m as usize + 1);
        let mut members = vec![Vec::new(); count];
        for ((i, p), label) in free.into_iter().zip(points).zip(labels) {
            state.labels[i as usize] = kept as u32 + label;
            members[label as usize].push(p);
        }
        for points in &members {
            let shape = ellipsoid_of_moments(points, START_SHRINK, state.model.axis_floor());
            state.open_table(shape, Noise::First(Draw::Cluster(params.seed, Purpose::StartSigma)));
        }
        // k-means may leave a centre without points.
        let empty = members.iter().map(Vec::is_empty);
        state.remove_clusters(&std::iter::repeat_n(false, kept).chain(empty).collect::<Vec<_>>());
        Ok(Self { params, state, phase: Phase::Start, cache: UnionCache::default() })
    }

    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Takes other parameters from the next step on, but for the algorithm, K
    /// (`clusters`), the seed and the viewpoints: those belong to the start of a run and stay.
    pub fn set_params(&mut self, params: Params) -> Result<(), InferenceError> {
        params.check().map_err(InferenceError::Params)?;
        let judged_by = |p: &Params| (p.merge, p.fit_distance, p.primitive_cost, p.alpha);
        if judged_by(&params) != judged_by(&self.params) {
            self.cache = UnionCache::default();
        }
        let Params { algorithm, clusters, seed, seen_from, .. } = self.params;
        self.params = Params { algorithm, clusters, seed, seen_from, ..params };
        Ok(())
    }

    /// Whether nothing is left to do with the present T.
    pub fn is_finished(&self) -> bool {
        self.phase == Phase::Finished && self.state.iteration >= self.params.iterations
    }

    /// Iterations made so far.
    pub fn iteration(&self) -> u32 {
        self.state.iteration
    }

    /// Makes the next Gibbs iteration with the merge pass that belongs to it
    /// or, after the last one, finishes the run. On `Cancelled` the state is
    /// as before the call.
    pub fn step(&mut self, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        let mut next = self.clone();
        let mut occurrences = Vec::new();
        if next.state.iteration < next.params.iterations {
            next.iterate(cancel, &mut occurrences);
            next.phase = Phase::Sampling;
        } else if next.phase != Phase::Finished {
            next.finish(cancel, &mut occurrences);
            next.phase = Phase::Finished;
        }
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        *self = next;
        Ok(occurrences)
    }

    /// Makes the best acceptable merge of two clusters or, where no two make a
    /// better one, of a group; no report if there is none. May be called between
    /// any two steps.
    pub fn step_merge(&mut self, cancel: &Cancel) -> Result<Vec<MergeReport>, InferenceError> {
        let mut state = self.state.clone();
        // The cache stays even when the step is cancelled: it only holds facts.
        let reports = merge_once(&mut state, &mut self.cache, &self.params, cancel);
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        self.state = state;
        if !reports.is_empty() {
            self.settle_after_merge();
        }
        Ok(reports)
    }

    /// After the last iteration merging is a phase of its own.
    pub(crate) fn settle_after_merge(&mut self) {
        if self.phase != Phase::Finished && self.state.iteration >= self.params.iterations {
            self.phase = Phase::Merging;
        }
    }

    fn iterate(&mut self, cancel: &Cancel, occurrences: &mut Vec<Occurrence>) {
        let state = &mut self.state;
        state.iteration += 1;
        separate::separate_and_split(state, &self.params, cancel, occurrences);
        if cancel.is_requested() {
            return;
        }
        sweep(state, &self.params, occurrences);
        self.optimize(cancel);
        if self.params.freeze {
            self.freeze(occurrences);
        }
        if self.state.iteration.is_multiple_of(MERGE_INTERVAL)
            || self.state.iteration == self.params.iterations
        {
            self.merge_all(cancel, occurrences);
        }
    }

    /// Fits every primitive that is not locked to its points and draws its σ. Late in the run
    /// only the largest connected component counts; the others are released.
    fn optimize(&mut self, cancel: &Cancel) {
        let params = self.params;
        let state = &mut self.state;
        let model = state.model.clone();
        let late = state.iteration > LATE_ITERATION;
        let members = state.members();
        let fits: Vec<_> = (0..members.len())
            .into_par_iter()
            .map(|j| {
                if state.clusters[j].locked {
                    return (None, Vec::new(), Vec::new());
                }
                let released: Vec<u32>;
                let mut kept: Vec<u32>;
                if late {
                    let mut parts = state.components(j as u32, &members[j]).into_iter();
                    kept = parts.next().unwrap_or_default();
                    let (pinned, rest): (Vec<u32>, Vec<u32>) =
                        parts.flatten().partition(|&i| state.is_pinned(i));
                    kept.extend(pinned);
                    released = rest.into_iter().filter(|&i| !state.frozen[i as usize]).collect();
                } else {
                    kept = members[j].clone();
                    released = Vec::new();
                }
                let points = model.gather(&kept);
                let turn = state.iteration + state.clusters[j].id;
                let explore = state.iteration <= EXPLORE_FIRST || turn.is_multiple_of(EXPLORE_INTERVAL);
                let effort = if explore { Effort::ITERATION } else { Effort::FOLLOW };
                let warm = [state.clusters[j].shape];
                let found = fit(&points, &warm, model.limits(), effort, params.fit_distance, cancel)
                    .map(|m| (m.shape, sum_squared_radial(&m.shape, &points)));
                (found, kept, released)
            })
            .collect();
        for (j, (found, kept, released)) in fits.into_iter().enumerate() {
            for i in released {
                state.labels[i as usize] = UNASSIGNED;
            }
            if state.clusters[j].locked {
                continue;
            }
            let (shape, noise) = match found {
                Some((shape, sum_d2)) => {
                    (shape, Noise::Conditional(Draw::Cluster(params.seed, Purpose::Sigma), Some(sum_d2)))
                }
                None => (state.clusters[j].shape, Noise::Kept),
            };
            state.renew(j, shape, noise, &kept);
        }
    }

    fn freeze(&mut self, occurrences: &mut Vec<Occurrence>) {
        let members = self.state.members();
        for (cluster, points) in self.state.clusters.iter().zip(&members).filter(|(c, _)| !c.locked) {
            let mean_d2 = self.state.model.sum_d2(&cluster.shape, points) / points.len().max(1) as f64;
            if mean_d2 <= FREEZE && points.iter().any(|&i| !self.state.frozen[i as usize]) {
                occurrences.push(Occurrence::Froze { id: cluster.id });
                for &i in points {
                    self.state.frozen[i as usize] = true;
                }
            }
        }
    }

    fn merge_all(&mut self, cancel: &Cancel, occurrences: &mut Vec<Occurrence>) {
        if self.params.merge == MergeRule::Energy {
            merge_all(&mut self.state, &self.params, cancel, occurrences);
        } else {
            loop {
                let reports = merge_once(&mut self.state, &mut self.cache, &self.params, cancel);
                if reports.is_empty() {
                    break;
                }
                occurrences.extend(reports.into_iter().map(Occurrence::Merged));
            }
        }
        // Proposals of clusters that have changed since are never asked for again.
        let alive = self.state.clusters.iter().map(|c| c.revision).collect();
        self.cache.retain(&alive);
    }

    fn finish(&mut self, cancel: &Cancel, occurrences: &mut Vec<Occurrence>) {
        if self.params.refine {
            search::refine(&mut self.state, &self.params, cancel, occurrences);
        }
    }

    /// The present state in input units.
    pub fn abstraction(&self) -> Abstraction {
        let state = &self.state;
        let normalization = &state.model.normalization;
        let members = state.members();
        let mut tables = Vec::with_capacity(members.len());
        let primitives: Vec<Primitive> = state
            .clusters
            .iter()
            .zip(&members)
            .map(|(cluster, points)| {
                let block = state.model.gather(points).into_iter().collect();
                let mut distances = Vec::new();
                kernel::euclidean_distances(&cluster.shape, &block, &mut distances);
                let sum: f64 = distances.into_iter().map(f64::from).sum();
                let sum_d2 = kernel::cost(&cluster.shape, &block, Distance::Radial);
                tables.push((points.len(), sum_d2, cluster.sigma));
                Primitive {
                    id: cluster.id,
                    shape: normalization.shape(&cluster.shape),
                    sigma: normalization.length(cluster.sigma),
                    points: points.len(),
                    mean_distance: normalization.length(sum / points.len().max(1) as f64),
                    locked: cluster.locked,
                }
            })
            .collect();
        let labels = state
            .labels
            .iter()
            .map(|&l| if l == UNASSIGNED { UNASSIGNED } else { state.clusters[l as usize].id })
            .collect();
        let assigned: usize = primitives.iter().map(|p| p.points).sum();
        let unassigned = state.labels.len() - assigned;
        // The sum of nothing would be −0.
        let sum = primitives.iter().fold(0.0, |sum, p| sum + p.mean_distance * p.points as f64);
        Abstraction {
            phase: self.phase,
            iteration: state.iteration,
            labels,
            pinned: Arc::clone(&state.pinned),
            figures: Figures {
                clusters: primitives.len(),
                unassigned,
                mean_distance: sum / assigned.max(1) as f64,
                log_joint: Some(log_joint(self.params.alpha, self.params.p0, &tables, unassigned)),
            },
            primitives: primitives.into(),
            sighting: state.model.sighting,
        }
    }
}
