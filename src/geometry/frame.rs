//! The frame in which shapes of any size and place are computed alike.

use nalgebra::{Point3, Vector3};

use super::mesh::bounds;

/// The shape's box, centred, its longest edge 2. Far offsets and extreme units
/// cost no precision there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    center: Vector3<f64>,
    half_extent: f64,
}

impl Frame {
    pub(super) fn around(points: impl IntoIterator<Item = Point3<f64>>) -> Self {
        let (lo, hi) = bounds(points).unwrap_or((Point3::origin(), Point3::origin()));
        // Halved before they are added: sums near the largest number overflow.
        let (lo, hi) = (lo.coords * 0.5, hi.coords * 0.5);
        let half_extent = (hi - lo).max();
        Self { center: lo + hi, half_extent: if half_extent > 0.0 { half_extent } else { 1.0 } }
    }

    pub(super) fn local(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from((p.coords - self.center) / self.half_extent)
    }

    pub(super) fn input(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from(p.coords * self.half_extent + self.center)
    }
}
