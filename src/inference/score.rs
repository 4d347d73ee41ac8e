//! Description length: one number for "fits well" and "few primitives".
//!
//! A point of a primitive of n points is drawn evenly over the surface (area
//! A) with normal noise σ across it, so N points in clusters cost
//!
//! ```text
//! L = Σ_j n_j·[ln A_j + ½ ln 2πσ_j² + ½ e_j²/σ_j² − ln(n_j/N)] + c·½·13·ln N
//! ```
//!
//! nats, e the root mean square first-order distance and σ = max(e, floor).
//! The last term is the cost of thirteen parameters (Schwarz), times the price
//! c that a person sets (`Params::primitive_cost`). A primitive that spans
//! empty space pays by its area, one that is too many by its parameters.

use nalgebra::Point3;

use crate::geometry::kernel::{self, Distance};
use crate::geometry::superquadric::PARAMETERS;
use crate::geometry::{Superquadric, tessellate};

/// σ below this many mean spacings is not worth bits: it is under the
/// resolution of the cloud.
const SIGMA_FLOOR: f64 = 0.3;

/// What the fit of one cluster costs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Description {
    /// Nats, its parameters included.
    pub(crate) length: f64,
    /// ln A + ½ ln 2πσ².
    pub(crate) per_point: f64,
    /// The noise that the description uses.
    pub(crate) sigma: f64,
    /// Root mean square first-order distance.
    pub(crate) rms: f64,
}

/// The description length of one cluster's points out of `total`, where a
/// primitive costs `primitive_cost` times its thirteen parameters.
pub(crate) fn describe(
    shape: &Superquadric,
    points: &[Point3<f64>],
    total: usize,
    spacing: f64,
    primitive_cost: f64,
) -> Description {
    let n = points.len() as f64;
    let total = total as f64;
    let mean_square = kernel::cost(shape, &points.iter().copied().collect(), Distance::FirstOrder) / n;
    let variance = mean_square.max((SIGMA_FLOOR * spacing).powi(2));
    let area = tessellate::surface_area(shape).max(f64::MIN_POSITIVE);
    let per_point = area.ln() + 0.5 * (2.0 * std::f64::consts::PI * variance).ln();
    let length = n * (per_point + 0.5 * mean_square / variance - (n / total).ln());
    Description {
        length: length + primitive_cost * 0.5 * PARAMETERS as f64 * total.ln(),
        per_point,
        sigma: variance.sqrt(),
        rms: mean_square.sqrt(),
    }
}
