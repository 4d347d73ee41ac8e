//! What a run knows: the fixed data of the cloud, and the state that the
//! steps change.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::geometry::Superquadric;
use crate::inference::data::abstraction::UNASSIGNED;
use crate::inference::data::model::Model;

/// One cluster: a table of the restaurant with its dish, in the normalised
/// frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cluster {
    /// Stable through the run.
    pub id: u32,
    /// Changes whenever the shape or the points do, never repeats.
    pub revision: u64,
    pub shape: Superquadric,
    /// Noise σ.
    pub sigma: f64,
    /// Whether the sampler leaves it and its points alone.
    pub locked: bool,
}

/// The state that steps change. A clone is a checkpoint.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) model: Arc<Model>,
    pub(crate) clusters: Vec<Cluster>,
    /// For each point the index of its cluster, or [`UNASSIGNED`].
    pub(crate) labels: Vec<u32>,
    /// Points that sweeps pass over.
    pub(crate) frozen: Vec<bool>,
    /// Points whose label no step changes, in ascending order; each has one.
    pub(crate) pinned: Arc<[u32]>,
    pub(crate) iteration: u32,
    pub(crate) next_id: u32,
    pub(crate) next_revision: u64,
}

impl State {
    /// No clusters, and no labels.
    pub(crate) fn empty(model: Arc<Model>) -> Self {
        let points = model.points.len();
        Self {
            model,
            clusters: Vec::new(),
            labels: vec![UNASSIGNED; points],
            frozen: vec![false; points],
            pinned: Arc::default(),
            iteration: 0,
            next_id: 0,
            next_revision: 0,
        }
    }

    /// The locked clusters with their points, before the first iteration.
    pub(crate) fn only_locked(&self) -> Self {
        let unlocked: Vec<bool> = self.clusters.iter().map(|c| !c.locked).collect();
        let mut kept = Self {
            clusters: self.clusters.clone(),
            labels: self.labels.clone(),
            pinned: Arc::clone(&self.pinned),
            ..Self::empty(Arc::clone(&self.model))
        };
        kept.remove_clusters(&unlocked);
        kept.next_id = kept.clusters.iter().map(|c| c.id + 1).max().unwrap_or(0);
        kept.next_revision = kept.clusters.iter().map(|c| c.revision + 1).max().unwrap_or(0);
        kept
    }

    /// The points of each cluster, in order of index.
    pub(crate) fn members(&self) -> Vec<Vec<u32>> {
        let mut members = vec![Vec::new(); self.clusters.len()];
        for (i, &label) in (0u32..).zip(&self.labels) {
            if label != UNASSIGNED {
                members[label as usize].push(i);
            }
        }
        members
    }

    /// Whether a person has said where the point belongs.
    pub(crate) fn is_pinned(&self, i: u32) -> bool {
        self.pinned.binary_search(&i).is_ok()
    }

    /// Whether no step may change the point's label: it is pinned, or its
    /// cluster is locked.
    pub(crate) fn is_held(&self, i: u32) -> bool {
        let cluster = self.clusters.get(self.labels[i as usize] as usize);
        cluster.is_some_and(|c| c.locked) || self.is_pinned(i)
    }

    pub(crate) fn new_id(&mut self) -> u32 {
        self.next_id += 1;
        self.next_id - 1
    }

    pub(crate) fn new_revision(&mut self) -> u64 {
        self.next_revision += 1;
        self.next_revision - 1
    }

    /// Removes the clusters that `gone` marks; their points become unassigned.
    pub(crate) fn remove_clusters(&mut self, gone: &[bool]) {
        let mut kept = 0;
        let renumbered: Vec<u32> = gone
            .iter()
            .map(|&g| {
                if g {
                    UNASSIGNED
                } else {
                    kept += 1;
                    kept - 1
                }
            })
            .collect();
        let mut gone = gone.iter();
        self.clusters.retain(|_| !gone.next().copied().unwrap_or(false));
        for label in &mut self.labels {
            if *label != UNASSIGNED {
                *label = renumbered[*label as usize];
            }
        }
        if self.pinned.iter().any(|&i| self.labels[i as usize] == UNASSIGNED) {
            let left = |i: &&u32| self.labels[**i as usize] != UNASSIGNED;
            self.pinned = self.pinned.iter().filter(left).copied().collect();
        }
    }

    /// The connected components of a cluster's members, largest first.
    pub(crate) fn components(&self, cluster: u32, members: &[u32]) -> Vec<Vec<u32>> {
        self.model.graph.components(members, |i| self.labels[i as usize] == cluster)
    }
}
