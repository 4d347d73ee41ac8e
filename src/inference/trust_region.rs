//! Bounded Levenberg–Marquardt on the signed radial distance of one
//! primitive's points.

use nalgebra::{SVector, Vector3};

use super::sampler::Cancel;
use crate::geometry::Superquadric;
use crate::geometry::kernel::{self, Distance, PointBlock};
use crate::geometry::superquadric::PARAMETERS;

type Vector = SVector<f64, PARAMETERS>;

/// Exponents in fits: the paper's range is (0, 2); at its ends the powers
/// lose their meaning in floating point.
const EXPONENTS: (f64, f64) = (0.1, 1.9);
/// Largest |k|: at 1 the narrow end has no width and r no derivative.
const LARGEST_TAPER: f64 = 0.95;
/// Largest turn of one step, in radians: the linear model of a rotation is
/// no good beyond it.
const LARGEST_TURN: f64 = 0.5;

/// Why the iteration stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stop {
    /// The cost no longer falls by more than the tolerance.
    Converged,
    /// The number of iterations is used up.
    Iterations,
    /// No step improves the cost, however short.
    Stuck,
    /// The cost or the normal equations are not finite.
    NotFinite,
    Cancelled,
}

/// A fitted primitive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Minimum {
    pub(crate) shape: Superquadric,
    /// Σ d² of the points, by the distance that was minimised.
    pub(crate) cost: f64,
    pub(crate) stop: Stop,
}

/// The parameters as LM sees them: the pose as an increment.
fn values(shape: &Superquadric) -> Vector {
    let [e1, e2] = shape.exponents;
    let a = shape.semi_axes;
    let [kx, ky] = shape.taper;
    Vector::from([e1, e2, a.x, a.y, a.z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, kx, ky])
}

fn shape_of(base: &Superquadric, v: &Vector) -> Superquadric {
    Superquadric {
        exponents: [v[0], v[1]],
        semi_axes: Vector3::new(v[2], v[3], v[4]),
        taper: [v[11], v[12]],
        ..base.moved(&Vector3::new(v[5], v[6], v[7]), &Vector3::new(v[8], v[9], v[10]))
    }
}

/// The box of each parameter where the points have the box (`low`, `high`) in
/// the primitive's frame: each semi-axis at most half the extent along it, the
/// centre inside, but for the thickness of the thinnest plate.
fn bounds(low: &Vector3<f64>, high: &Vector3<f64>, smallest_axis: f64) -> (Vector, Vector) {
    let half = ((high - low) * 0.5).map(|h| h.max(2.0 * smallest_axis));
    let (e0, e1) = EXPONENTS;
    let (a0, k, w) = (smallest_axis, LARGEST_TAPER, LARGEST_TURN);
    let (low, high) = (low.add_scalar(-2.0 * a0), high.add_scalar(2.0 * a0));
    (
        Vector::from([e0, e0, a0, a0, a0, -w, -w, -w, low.x, low.y, low.z, -k, -k]),
        Vector::from([e1, e1, half.x, half.y, half.z, w, w, w, high.x, high.y, high.z, k, k]),
    )
}

/// Minimises Σ d² over all 13 parameters from `start`, in at most
/// `iterations` steps, until a step gains less than `tolerance` (relative).
/// Semi-axes stay at or above `smallest_axis`.
pub(crate) fn minimize(
    points: &PointBlock,
    distance: Distance,
    start: &Superquadric,
    smallest_axis: f64,
    iterations: usize,
    tolerance: f64,
    cancel: &Cancel,
) -> Minimum {
    let mut shape = *start;
    let mut cost_now = f64::INFINITY;
    let mut damping = 1e-2;
    let mut stop = Stop::Iterations;
    'outer: for _ in 0..iterations {
        if cancel.is_requested() {
            stop = Stop::Cancelled;
            break;
        }
        let normal = kernel::normal_equations(&shape, points, distance);
        cost_now = normal.cost;
        if !cost_now.is_finite() || !normal.jtj.iter().all(|v| v.is_finite()) {
            stop = Stop::NotFinite;
            break;
        }
        // A perfect fit: nothing is left but rounding.
        if cost_now <= 1e-24 * points.len() as f64 * shape.semi_axes.norm_squared() {
            stop = Stop::Converged;
            break;
        }
        let now = values(&shape);
        let (lo, hi) = bounds(&normal.low, &normal.high, smallest_axis);
        // As the pose moves the box shrinks: what already lies outside may stay.
        let (lo, hi) = (lo.inf(&now), hi.sup(&now));
        // A parameter at its bound with the gradient pushing outward is held.
        let held: [bool; PARAMETERS] = std::array::from_fn(|i| {
            let margin = 1e-9 * (1.0 + now[i].abs());
            (now[i] <= lo[i] + margin && normal.jtr[i] > 0.0)
                || (now[i] >= hi[i] - margin && normal.jtr[i] < 0.0)
        });
        let mean_diagonal = normal.jtj.trace() / PARAMETERS as f64;
        for _ in 0..8 {
            let mut a = normal.jtj;
            let mut g = -normal.jtr;
            for i in 0..PARAMETERS {
                if held[i] {
                    a.row_mut(i).fill(0.0);
                    a.column_mut(i).fill(0.0);
                    a[(i, i)] = 1.0;
                    g[i] = 0.0;
                } else {
                    a[(i, i)] += damping * (a[(i, i)] + 1e-6 * mean_diagonal) + f64::MIN_POSITIVE;
                }
            }
            let Some(factor) = a.cholesky() else {
                damping *= 10.0;
                continue;
            };
            let next = (now + factor.solve(&g)).sup(&lo).inf(&hi);
            let candidate = shape_of(&shape, &next);
            let cost_next = kernel::cost(&candidate, points, distance);
            if cost_next < cost_now {
                let gain = (cost_now - cost_next) / cost_now;
                shape = candidate;
                cost_now = cost_next;
                damping = (damping * 0.2).max(1e-9);
                if gain < tolerance {
                    stop = Stop::Converged;
                    break 'outer;
                }
                continue 'outer;
            }
            damping *= 5.0;
        }
        stop = Stop::Stuck;
        break;
    }
    if !cost_now.is_finite() && stop != Stop::NotFinite {
        cost_now = kernel::cost(&shape, points, distance);
    }
    Minimum { shape, cost: cost_now, stop }
}
