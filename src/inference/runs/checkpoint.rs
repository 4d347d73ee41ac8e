//! A run as plain data: all that it needs to go on but the cloud.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::geometry::Superquadric;
use crate::geometry::brief::Brief;
use crate::geometry::kernel::Distance;
use crate::geometry::theta::Bounds;
use crate::inference::control::InferenceError;
use crate::inference::data::abstraction::{Phase, UNASSIGNED};
use crate::inference::data::limits::{MOST_IDS, is_sigma};
use crate::inference::data::model::Model;
use crate::inference::data::state::{Cluster, State};
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::moves::union_cache::UnionCache;
use crate::inference::params::{Algorithm, Params};

/// All that a run needs to go on, but the cloud: what [`crate::inference::runs::run::Run::resume`]
/// makes of it continues with the same bits as the run that it was taken of.
///
/// Lengths are in the normalised frame, where the cloud's bounding box has
/// volume 200: converted to input units and back they would lose bits.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// The parameters in force.
    pub params: Params,
    pub phase: Phase,
    /// Gibbs iterations, or steps of a baseline, made so far.
    pub iteration: u32,
    pub clusters: Vec<Cluster>,
    /// For each sample the index into `clusters`, or [`UNASSIGNED`].
    pub labels: Vec<u32>,
    /// Samples that sweeps pass over, in ascending order.
    pub frozen: Vec<u32>,
    /// Samples whose label no step changes, in ascending order.
    pub pinned: Vec<u32>,
    /// The id of the next cluster that is born.
    pub next_id: u32,
    /// The next revision that a cluster gets.
    pub next_revision: u64,
    /// What a baseline has left to do.
    pub work: Remaining,
}

impl fmt::Debug for Checkpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Checkpoint")
            .field("phase", &self.phase)
            .field("iteration", &self.iteration)
            .field("clusters", &Brief::of_told(&self.clusters))
            .field("labels", &Brief::of(&self.labels))
            .field("frozen", &Brief::of(&self.frozen))
            .field("pinned", &Brief::of(&self.pinned))
            .finish_non_exhaustive()
    }
}

/// What a run has left to do besides what its state tells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Remaining {
    /// Of the sampler nothing.
    Sampler,
    /// K-means: the clusters from this index on have no fit yet.
    Fits(usize),
    /// EMS: the one primitive, from the first step on.
    One(Option<Recovered>),
    /// Hierarchical EMS: parts of the cloud without a primitive, the next one
    /// last.
    Parts(Vec<Part>),
}

/// A connected part of the cloud that has no primitive yet.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Samples, at least one.
    pub points: Vec<u32>,
    /// Primitives that have been taken out of what it is a rest of.
    pub depth: u32,
}

impl fmt::Debug for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Part").field("points", &Brief::of(&self.points)).field("depth", &self.depth).finish()
    }
}

/// How far EMS has come with one primitive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Recovered {
    pub shape: Superquadric,
    pub sigma: f64,
    /// Mean log-likelihood of the points, in nats.
    pub likelihood: f64,
    pub rounds: u32,
    pub switches: u32,
    pub is_done: bool,
    /// w₀ and the distance that the likelihood was computed with.
    pub outlier_prior: f64,
    pub distance: Distance,
}

/// Iterations, ids and revisions of a sound checkpoint lie below these: the
/// random streams have room for so many.
const MOST_ITERATIONS: u32 = 1 << 24;
const MOST_REVISIONS: u64 = 1 << 62;

fn is_ascending(list: &[u32], below: usize) -> bool {
    list.windows(2).all(|w| w[0] < w[1]) && list.last().is_none_or(|&i| (i as usize) < below)
}

impl Checkpoint {
    /// Says what of it can't be, if something can't, for a cloud of `points`
    /// samples.
    pub(crate) fn check(&self, points: usize) -> Result<(), InferenceError> {
        self.problem(points).map_or(Ok(()), |problem| Err(InferenceError::Checkpoint(problem)))
    }

    fn problem(&self, points: usize) -> Option<String> {
        if let Err(problem) = self.params.check() {
            return Some(problem);
        }
        if self.labels.len() != points {
            let labels = self.labels.len();
            return Some(format!("it has labels for {labels} samples, but the cloud has {points}"));
        }
        let count = self.clusters.len();
        let dangling = |l: &&u32| **l != UNASSIGNED && **l as usize >= count;
        if let Some(label) = self.labels.iter().find(dangling) {
            return Some(format!("a sample is labelled {label}, but there are {count} clusters"));
        }
        if !is_ascending(&self.frozen, points) || !is_ascending(&self.pinned, points) {
            return Some("its lists of frozen and pinned samples are out of order".to_owned());
        }
        if self.pinned.iter().any(|&i| self.labels[i as usize] == UNASSIGNED) {
            return Some("a pinned sample has no label".to_owned());
        }
        if self.iteration >= MOST_ITERATIONS || self.next_id > MOST_IDS || self.next_revision > MOST_REVISIONS
        {
            return Some("its counters are out of range".to_owned());
        }
        let mut ids: Vec<u32> = self.clusters.iter().map(|c| c.id).collect();
        ids.sort_unstable();
        ids.dedup();
        if ids.len() < count || ids.last().is_some_and(|&id| id >= self.next_id) {
            return Some("two clusters have the same id, or an id is too large".to_owned());
        }
        for Cluster { id, revision, shape, sigma, .. } in &self.clusters {
            if shape.check(&Bounds::RUN).is_err() {
                return Some(format!("the shape of primitive {id} is out of range"));
            }
            if !is_sigma(*sigma) {
                return Some(format!("σ of primitive {id} is {sigma}"));
            }
            if *revision >= self.next_revision {
                return Some(format!("primitive {id} has an invalid revision"));
            }
        }
        self.problem_of_work(points)
    }

    fn problem_of_work(&self, points: usize) -> Option<String> {
        let is_fine = match (&self.work, self.params.algorithm) {
            (Remaining::Sampler, Algorithm::Sampler) => true,
            (Remaining::Fits(at), Algorithm::KMeans) => *at <= self.clusters.len(),
            (Remaining::One(recovered), Algorithm::Ems) => {
                self.clusters.len() == 1
                    && recovered.is_none_or(|r| {
                        r.shape.check(&Bounds::RUN).is_ok()
                            && is_sigma(r.sigma)
                            && r.rounds < MOST_ITERATIONS
                            && r.switches < MOST_ITERATIONS
                            && r.likelihood.is_finite()
                            && Params { outlier_prior: r.outlier_prior, ..self.params }.check().is_ok()
                    })
            }
            (Remaining::Parts(parts), Algorithm::HierarchicalEms) => parts.iter().all(|part| {
                let mut sorted = part.points.clone();
                sorted.sort_unstable();
                !sorted.is_empty() && is_ascending(&sorted, points) && part.depth < MOST_ITERATIONS
            }),
            _ => false,
        };
        (!is_fine).then(|| "its remaining work does not match its algorithm and state".to_owned())
    }

    /// The state that it was taken of, on that state's model.
    pub(crate) fn state(&self, model: Arc<Model>) -> State {
        let mut frozen = vec![false; self.labels.len()];
        for &i in &self.frozen {
            frozen[i as usize] = true;
        }
        State {
            model,
            clusters: self.clusters.clone(),
            labels: self.labels.clone(),
            frozen,
            pinned: self.pinned.as_slice().into(),
            iteration: self.iteration,
            next_id: self.next_id,
            next_revision: self.next_revision,
        }
    }

    /// That of a sampler; a baseline puts its own work in.
    pub(crate) fn of(sampler: &Sampler) -> Self {
        let Sampler { params, state, phase, .. } = sampler;
        let frozen = (0u32..).zip(&state.frozen).filter(|(_, f)| **f).map(|(i, _)| i).collect();
        Self {
            params: *params,
            phase: *phase,
            iteration: state.iteration,
            clusters: state.clusters.clone(),
            labels: state.labels.clone(),
            frozen,
            pinned: state.pinned.to_vec(),
            next_id: state.next_id,
            next_revision: state.next_revision,
            work: Remaining::Sampler,
        }
    }

    /// The sampler that a checked one was taken of, without what a baseline
    /// adds.
    pub(crate) fn sampler(&self, model: Arc<Model>) -> Sampler {
        Sampler {
            params: self.params,
            phase: self.phase,
            cache: UnionCache::default(),
            state: self.state(model.seen(self.params.sight())),
        }
    }
}
