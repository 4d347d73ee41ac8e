//! The frames in which shapes of any size and place are computed alike.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::mesh::bounds;

/// Coordinates beyond this are cut off: their squares would overflow.
const FARTHEST: f64 = 1e120;

/// A place and a size that become 0 and 1. Far offsets and extreme units cost no
/// precision there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) center: Vector3<f64>,
    /// The length that becomes 1.
    pub(super) unit: f64,
}

impl Frame {
    /// The shape's box, centred, its longest edge 2.
    pub(super) fn around(points: impl IntoIterator<Item = Point3<f64>>) -> Self {
        let (center, half) = middle(points).unwrap_or_default();
        Self { center, unit: if half > 0.0 { half } else { 1.0 } }
    }

    /// The shape's box, centred, its longest edge 1; `None` where there are no points or no
    /// extent.
    pub(super) fn of_edge(points: impl IntoIterator<Item = Point3<f64>>) -> Option<Self> {
        let (center, half) = middle(points)?;
        let unit = 2.0 * half;
        (unit > 0.0 && unit.is_finite()).then_some(Self { center, unit })
    }

    /// Centred on the medians of the coordinates, in units of their median
    /// distance from there along the axis where that is largest. A few points,
    /// however far, do not change it. As [`Frame::around`] where half of the
    /// points share a place.
    pub(super) fn amid(points: &[Point3<f64>]) -> Self {
        let median = |values: &mut [f64]| {
            let middle = values.len() / 2;
            if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
        };
        let axes: Vec<(f64, f64)> = (0..3)
            .into_par_iter()
            .map(|axis| {
                let mut values: Vec<f64> = points.iter().map(|p| p[axis]).collect();
                let center = median(&mut values);
                values.iter_mut().for_each(|v| *v = (*v - center).abs());
                (center, median(&mut values))
            })
            .collect();
        let center = Vector3::from_fn(|axis, _| axes[axis].0);
        let spread = Vector3::from_fn(|axis, _| axes[axis].1);
        let unit = spread.max();
        if unit > 0.0 && unit.is_finite() {
            Self { center, unit }
        } else {
            Self::around(points.iter().copied())
        }
    }

    pub(super) fn local(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from(((p.coords - self.center) / self.unit).map(|c| c.clamp(-FARTHEST, FARTHEST)))
    }

    pub(super) fn input(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from(p.coords * self.unit + self.center)
    }
}

/// The middle of a box, and half of its longest edge.
fn middle(points: impl IntoIterator<Item = Point3<f64>>) -> Option<(Vector3<f64>, f64)> {
    let (lo, hi) = bounds(points)?;
    // Halved before they are added: sums near the largest number overflow.
    let (lo, hi) = (lo.coords * 0.5, hi.coords * 0.5);
    Some((lo + hi, (hi - lo).max()))
}
