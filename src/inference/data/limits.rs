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
    /// Semi-axes below this are shorter than the points can tell.
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

    /// A body without what points can't tell of it where it is thinner than
    /// [`Limits::finest`]: across that axis it is flat, and has no taper along it
    /// nor of it. (A first-order distance would take a thin body with a sharp rim to
    /// be near everything in its plane.)
    pub(crate) fn told(&self, shape: Superquadric) -> Superquadric {
        let [x, y, z] = [0, 1, 2].map(|axis| shape.semi_axes[axis] < self.finest);
        let [e1, e2] = shape.exponents;
        let [kx, ky] = shape.taper;
        let flat = Bounds::FITS.exponents.0;
        Superquadric {
            exponents: [if z { flat } else { e1 }, if x || y { flat } else { e2 }],
            taper: [if x || z { 0.0 } else { kx }, if y || z { 0.0 } else { ky }],
            ..shape
        }
    }
}

/// Whether it is a normalised σ that a run can hold.
pub(crate) fn is_sigma(sigma: f64) -> bool {
    sigma > 0.0 && sigma <= Bounds::RUN.farthest
}
