//! What a state of a run can hold and a fit can reach, in the normalised frame.

use nalgebra::{Point3, Vector3};

use crate::geometry::Superquadric;
use crate::geometry::theta::Bounds;
use crate::inference::data::known_space::Viewpoint;

/// Ids lie below this: the random streams have room for so many.
pub(crate) const MOST_IDS: u32 = 1 << 30;

/// What a fit may not go beyond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limits {
    /// Floor of the semi-axes.
    pub(crate) smallest_axis: f64,
    /// How far semi-axes and centre may go, in half-extents of the points: 1, or
    /// more for a body of which only one side is seen, along the line of sight
    /// where that is known.
    pub(crate) reach: f64,
    pub(crate) viewpoint: Option<Viewpoint>,
    /// Semi-axes below this are thinner than the points can tell: they have no
    /// taper.
    pub(crate) finest: f64,
    /// Price of the logarithm of the area for each point, a squared length: of
    /// the bodies that explain points on one side the smallest is the likeliest.
    pub(crate) pull: f64,
}

impl Limits {
    /// Those of a body that points surround.
    pub(crate) fn surrounded(smallest_axis: f64) -> Self {
        Self { smallest_axis, reach: 1.0, viewpoint: None, finest: 0.0, pull: 0.0 }
    }

    /// The reach along each axis of a body.
    pub(crate) fn reaches(&self, shape: &Superquadric) -> Vector3<f64> {
        let along = self.viewpoint.map(|viewpoint| {
            let sight = viewpoint.direction_from(&Point3::from(shape.translation));
            shape.rotation.matrix().tr_mul(&sight).map(|c| c * c)
        });
        along.unwrap_or(Vector3::repeat(1.0)).map(|share| 1.0 + (self.reach - 1.0) * share)
    }

    /// The tapers without those that nothing can tell: along an axis that is too
    /// short, or of one.
    pub(crate) fn told_taper(&self, semi_axes: &Vector3<f64>, taper: [f64; 2]) -> [f64; 2] {
        let is_told = |a: f64| a >= self.finest && semi_axes.z >= self.finest;
        [(semi_axes.x, taper[0]), (semi_axes.y, taper[1])].map(|(a, k)| if is_told(a) { k } else { 0.0 })
    }
}

/// Whether it is a normalised σ that a run can hold.
pub(crate) fn is_sigma(sigma: f64) -> bool {
    sigma > 0.0 && sigma <= Bounds::RUN.farthest
}
