//! What a run knows: the fixed data of the cloud, and the state that the
//! steps change.

use std::sync::Arc;

use nalgebra::Point3;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Gamma};
use serde::{Deserialize, Serialize};

use super::abstraction::UNASSIGNED;
use super::field::Field;
use super::frame::Frame;
use crate::geometry::Superquadric;
use crate::geometry::kernel::PointBlock;
use crate::geometry::neighbors::{KdTree, RadiusGraph};

/// A cluster needs more points than this, all in one connected component.
pub(crate) const SMALLEST_CLUSTER: usize = 20;
/// Neighbours that count for the mean spacing s̄.
const SPACING_NEIGHBORS: usize = 5;
/// Points within this many mean spacings are connected.
const CONNECTION_RADIUS: f64 = 2.0;
/// Most edges that a point keeps in the graph: dense spots stay linear.
const MAX_DEGREE: usize = 48;
/// Floors in mean spacings: of σ (a perfect fit has no noise), and of the
/// semi-axes (a plane has no thickness).
const SIGMA_FLOOR: f64 = 0.05;
const AXIS_FLOOR: f64 = 0.05;

/// The points without their exact twins, in an order of their own.
pub(crate) fn distinct(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let mut places = points.to_vec();
    // +0 makes −0 the same place as 0.
    let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
    places.sort_unstable_by_key(key);
    places.dedup_by_key(|p| key(p));
    places
}

/// The cloud in the normalised frame with what is derived from it once.
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) frame: Frame,
    pub(crate) points: Vec<Point3<f64>>,
    /// The same points as the kernel wants them.
    pub(crate) block: PointBlock,
    /// Mean spacing s̄.
    pub(crate) spacing: f64,
    /// Points within 2·s̄.
    pub(crate) graph: RadiusGraph,
    /// Tangent planes: the way from any place to the cloud.
    pub(crate) field: Field,
}

impl Model {
    pub(crate) fn new(frame: Frame, input: &[Point3<f64>]) -> Self {
        let points: Vec<_> = input.iter().map(|p| frame.normalize(p)).collect();
        let tree = KdTree::new(&points);
        // Twins would make the spacing 0, and all that is measured by it.
        let places = distinct(&points);
        let without_twins = (places.len() < points.len()).then(|| KdTree::new(&places));
        let spacing = without_twins.as_ref().unwrap_or(&tree).mean_spacing(SPACING_NEIGHBORS);
        let graph = RadiusGraph::new(&tree, &points, CONNECTION_RADIUS * spacing, MAX_DEGREE);
        // Twins would leave the tangent planes without a direction.
        let field = match without_twins {
            Some(tree) => Field::new(tree, &places, spacing),
            None => Field::new(tree, &points, spacing),
        };
        Self { frame, block: points.iter().copied().collect(), points, spacing, graph, field }
    }

    pub(crate) fn sigma_floor(&self) -> f64 {
        SIGMA_FLOOR * self.spacing
    }

    pub(crate) fn axis_floor(&self) -> f64 {
        AXIS_FLOOR * self.spacing
    }

    /// The points with these indices.
    pub(crate) fn gather(&self, members: &[u32]) -> Vec<Point3<f64>> {
        members.iter().map(|&i| self.points[i as usize]).collect()
    }

    /// Draws σ of a cluster of n points with Σd² = `sum_d2` from its
    /// conditional: 1/σ² ~ Gamma((n − 1)/2, scale 2/D).
    pub(crate) fn draw_sigma(&self, sum_d2: f64, n: usize, rng: &mut impl Rng) -> f64 {
        let floor = self.sigma_floor();
        let shape = 0.5 * (n.max(2) - 1) as f64;
        // D = 0 is a perfect fit: the floor's worth of noise stands for it.
        let scale = 2.0 / sum_d2.max(floor * floor);
        match Gamma::new(shape, scale) {
            Ok(gamma) => (1.0 / gamma.sample(rng).sqrt()).clamp(floor, 1e3),
            Err(_) => floor,
        }
    }

    /// σ of a cluster without a history: uniform in (0, 1].
    pub(crate) fn draw_first_sigma(&self, rng: &mut impl Rng) -> f64 {
        (1.0 - rng.random::<f64>()).max(self.sigma_floor())
    }
}

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
