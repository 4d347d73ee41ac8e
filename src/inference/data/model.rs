//! The cloud in the normalised frame, with all that depends on it alone.

use std::sync::Arc;

use nalgebra::Point3;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Gamma};

use crate::geometry::Superquadric;
use crate::geometry::kernel::{self, Distance, PointBlock};
use crate::geometry::neighbors::{KdTree, RadiusGraph};
use crate::inference::data::known_space::{KnownSpace, Sighting, Viewpoint, find_viewpoints};
use crate::inference::data::limits::Limits;
use crate::inference::data::normalization::Normalization;
use crate::inference::data::surface_distance::SurfaceDistance;
use crate::inference::params::SeenFrom;

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
/// Bodies thinner than twice this many mean spacings have no taper.
const FINEST: f64 = 0.5;
/// A ball whose visible cap is a third of its diameter deep is found whole.
const ONE_SIDED_REACH: f64 = 3.0;
/// Error in mean spacings whose square, for each point, is as much as twice the
/// area, or nearly.
const PULL: f64 = 0.01;

/// The points without their exact twins, in an order of their own.
pub(crate) fn distinct(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let mut places = points.to_vec();
    // +0 makes −0 the same place as 0.
    let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
    places.sort_unstable_by_key(key);
    places.dedup_by_key(|p| key(p));
    places
}

/// Σ r² of points to a primitive: the statistic of the paper's noise model,
/// whatever distance the fit minimises.
pub(crate) fn sum_squared_radial(shape: &Superquadric, points: &[Point3<f64>]) -> f64 {
    kernel::cost(shape, &points.iter().copied().collect(), Distance::Radial)
}

/// The cloud in the normalised frame with what is derived from it once. A clone
/// shares what is large.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub(crate) normalization: Normalization,
    pub(crate) points: Arc<Vec<Point3<f64>>>,
    /// The same points as the kernel wants them.
    pub(crate) block: Arc<PointBlock>,
    /// Mean spacing s̄.
    pub(crate) spacing: f64,
    /// Points within 2·s̄.
    pub(crate) graph: Arc<RadiusGraph>,
    /// Tangent planes: the way from any place to the cloud.
    pub(crate) surface: Arc<SurfaceDistance>,
    /// Places that the cloud was seen from, as they were given.
    viewpoints: Vec<Point3<f64>>,
    seen_from: SeenFrom,
    /// What is free; all space without points where there is none.
    pub(crate) known: Option<Arc<KnownSpace>>,
    /// Whence the cloud is taken to have been seen, in input units.
    pub(crate) sighting: Sighting,
}

impl Model {
    /// The model of a cloud that was seen from all sides, with the viewpoints
    /// that it may have been seen from, too; both in input units.
    pub(crate) fn new(
        normalization: Normalization,
        input: &[Point3<f64>],
        viewpoints: &[Point3<f64>],
    ) -> Self {
        let points: Vec<_> = input.iter().map(|p| normalization.normalize(p)).collect();
        let tree = KdTree::new(&points);
        // Twins would make the spacing 0, and all that is measured by it.
        let places = distinct(&points);
        let without_twins = (places.len() < points.len()).then(|| KdTree::new(&places));
        let spacing = without_twins.as_ref().unwrap_or(&tree).mean_spacing(SPACING_NEIGHBORS);
        let graph = RadiusGraph::new(&tree, &points, CONNECTION_RADIUS * spacing, MAX_DEGREE);
        // Twins would leave the tangent planes without a direction.
        let surface = match without_twins {
            Some(tree) => SurfaceDistance::new(tree, &places, spacing),
            None => SurfaceDistance::new(tree, &points, spacing),
        };
        Self {
            normalization,
            block: Arc::new(points.iter().copied().collect()),
            points: Arc::new(points),
            spacing,
            graph: Arc::new(graph),
            surface: Arc::new(surface),
            viewpoints: viewpoints.iter().map(|v| normalization.normalize(v)).collect(),
            seen_from: SeenFrom::All,
            known: None,
            sighting: Sighting::AllSides,
        }
    }

    /// The same cloud, seen from elsewhere.
    pub(crate) fn seen(self: &Arc<Self>, seen_from: SeenFrom) -> Arc<Self> {
        if seen_from == self.seen_from {
            return Arc::clone(self);
        }
        let viewpoints = match seen_from {
            SeenFrom::All => Vec::new(),
            _ if !self.viewpoints.is_empty() => {
                self.viewpoints.iter().map(|v| Viewpoint::Place(*v)).collect()
            }
            _ => {
                let (found, shows_all) = find_viewpoints(&self.surface, self.spacing);
                if shows_all || seen_from == SeenFrom::OneSide { found } else { Vec::new() }
            }
        };
        let sighting = match viewpoints[..] {
            [] => Sighting::AllSides,
            _ if !self.viewpoints.is_empty() => Sighting::Given { viewpoints: self.viewpoints.len() },
            [Viewpoint::Direction(towards), ..] => Sighting::FoundDirection { towards: towards.into() },
            [Viewpoint::Place(eye), ..] => {
                Sighting::FoundPlace { viewpoint: self.normalization.place(&eye).into() }
            }
        };
        let known = (!viewpoints.is_empty()).then(|| {
            Arc::new(KnownSpace::new(&viewpoints, self.viewpoints.is_empty(), &self.points, self.spacing))
        });
        Arc::new(Self { seen_from, known, sighting, ..Self::clone(self) })
    }

    /// What the fit of a primitive may not go beyond. A body of which one side
    /// is seen reaches beyond its points.
    pub(crate) fn limits(&self) -> Limits {
        let surrounded = Limits::surrounded(self.axis_floor());
        match &self.known {
            None => surrounded,
            Some(known) => Limits {
                finest: FINEST * self.spacing,
                reach: ONE_SIDED_REACH,
                viewpoint: known.viewpoint(),
                pull: (PULL * self.spacing).powi(2),
                ..surrounded
            },
        }
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

    /// Σ r² of some points to a primitive: the statistic of the paper's noise
    /// model, whatever distance the fits minimise.
    pub(crate) fn sum_d2(&self, shape: &Superquadric, members: &[u32]) -> f64 {
        sum_squared_radial(shape, &self.gather(members))
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
