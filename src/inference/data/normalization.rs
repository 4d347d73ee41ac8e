//! The normalised frame: lengths such that the cloud's bounding box has
//! volume 200, the unit of the paper's thresholds and of p₀.

use nalgebra::{Point3, Vector3};

use crate::geometry::Superquadric;

/// Volume of the bounding box after normalisation.
const BOX_VOLUME: f64 = 200.0;
/// A flat or linear cloud has a box without volume: each extent counts for at
/// least this share of the longest.
const SMALLEST_EXTENT: f64 = 0.05;

/// The similarity `normalised = (input − center)·scale`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Normalization {
    center: Vector3<f64>,
    scale: f64,
}

impl Normalization {
    /// The frame of a cloud; `None` where its points all coincide.
    pub(crate) fn of(points: &[Point3<f64>]) -> Option<Self> {
        let first = *points.first()?;
        let (lo, hi) = points.iter().fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p)));
        let extent = hi - lo;
        let longest = extent.max();
        if longest <= 0.0 || !longest.is_finite() {
            return None;
        }
        // Ratios first: the product of three extents of 1e-120 would underflow.
        let relative = (extent / longest).map(|e| e.max(SMALLEST_EXTENT));
        let scale = (BOX_VOLUME / relative.product()).cbrt() / longest;
        scale.is_finite().then(|| Self { center: nalgebra::center(&lo, &hi).coords, scale })
    }

    pub(crate) fn normalize(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from((p.coords - self.center) * self.scale)
    }

    /// A normalised place in input units.
    pub(crate) fn place(&self, normalised: &Point3<f64>) -> Point3<f64> {
        Point3::from(normalised.coords / self.scale + self.center)
    }

    /// A normalised length in input units.
    pub(crate) fn length(&self, normalised: f64) -> f64 {
        normalised / self.scale
    }

    /// Normalised length of a unit of the input.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// A primitive in input units, normalised.
    pub(crate) fn normalized_shape(&self, input: &Superquadric) -> Superquadric {
        input.scaled(self.scale, &(-self.center * self.scale))
    }

    /// A normalised primitive in input units.
    pub(crate) fn shape(&self, normalised: &Superquadric) -> Superquadric {
        normalised.scaled(1.0 / self.scale, &self.center)
    }
}
