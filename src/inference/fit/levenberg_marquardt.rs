//! Bounded Levenberg–Marquardt on the signed radial distance of one
//! primitive's points.

use nalgebra::Vector3;

use crate::geometry::kernel::{self, Distance, NormalEquations, PointBlock};
use crate::geometry::theta::{Bounds, PARAMETERS, SEMI_AXES_AT, TURN_AT, Theta, shaping};
use crate::geometry::{Superquadric, tessellate};
use crate::inference::control::Cancel;
use crate::inference::data::limits::Limits;
use crate::inference::fit::area::area_of_ellipsoid;

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
    /// What was minimised: Σ d² of the points, by the distance asked for.
    pub(crate) cost: f64,
    pub(crate) stop: Stop,
}

/// What is minimised: Σ w·d², w = 1 where there are no weights, plus
/// [`Area::price`] times the logarithm of the area, plus `pull` times that of an
/// ellipsoid of the same size.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target<'a> {
    pub(crate) points: &'a PointBlock,
    pub(crate) distance: Distance,
    /// One weight a point.
    pub(crate) weights: Option<&'a [f64]>,
    pub(crate) area: Option<Area>,
    pub(crate) pull: f64,
}

/// The term `price · ln(A + margin)` of a shape of surface area A. Points that
/// show only one side of a body leave its size open; the smallest body that
/// explains them is the likeliest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Area {
    pub(crate) price: f64,
    pub(crate) margin: f64,
}

impl Area {
    fn cost(&self, shape: &Superquadric) -> f64 {
        self.price * (tessellate::surface_area(shape) + self.margin).ln()
    }

    /// The derivatives of the cost by the parameters that shape the surface.
    fn gradient(&self, shape: &Superquadric) -> Theta {
        let at = shape.theta();
        let mut gradient = Theta::zeros();
        for i in shaping() {
            let step = if (SEMI_AXES_AT..TURN_AT).contains(&i) { 1e-3 * at[i] } else { 1e-3 };
            let by = |step: f64| {
                let mut moved = at;
                moved[i] += step;
                self.cost(&shape.retracted(&moved))
            };
            gradient[i] = (by(step) - by(-step)) / (2.0 * step);
        }
        gradient
    }
}

/// A cost that [`descend`] can go down.
pub(crate) trait Objective {
    /// The normal equations at a shape, and what else the cost is to hold on to
    /// until the next call.
    fn linearize(&mut self, shape: &Superquadric) -> NormalEquations;
    fn cost(&self, shape: &Superquadric) -> f64;
    /// A cost that is nothing but rounding.
    fn least(&self, shape: &Superquadric) -> f64;
    /// What a gain is compared with.
    fn scale(&self, cost: f64) -> f64 {
        cost
    }
}

impl Objective for Target<'_> {
    fn cost(&self, shape: &Superquadric) -> f64 {
        let sum = match self.weights {
            Some(weights) => kernel::weighted_cost(shape, self.points, weights, self.distance),
            None => kernel::cost(shape, self.points, self.distance),
        };
        let pull = if self.pull > 0.0 { self.pull * area_of_ellipsoid(&shape.semi_axes).0.ln() } else { 0.0 };
        sum + pull + self.area.map_or(0.0, |area| area.cost(shape))
    }

    fn linearize(&mut self, shape: &Superquadric) -> NormalEquations {
        let mut normal = match self.weights {
            Some(weights) => kernel::weighted_normal_equations(shape, self.points, weights, self.distance),
            None => kernel::normal_equations(shape, self.points, self.distance),
        };
        if let Some(area) = self.area {
            // Halves, as JᵀJ and Jᵀr are half the derivatives of Σ d². The
            // curvature is that of a square whose root has the same slope.
            let gradient = 0.5 * area.gradient(shape);
            normal.jtr += gradient;
            normal.jtj += gradient * gradient.transpose() * (2.0 / area.price.max(f64::MIN_POSITIVE));
            normal.cost += area.cost(shape);
        }
        if self.pull > 0.0 {
            let (area, gradient) = area_of_ellipsoid(&shape.semi_axes);
            normal.cost += self.pull * area.ln();
            for axis in 0..3 {
                let slope = 0.5 * self.pull * gradient[axis] / area;
                normal.jtr[SEMI_AXES_AT + axis] += slope;
                normal.jtj[(SEMI_AXES_AT + axis, SEMI_AXES_AT + axis)] += slope / shape.semi_axes[axis];
            }
        }
        normal
    }

    fn least(&self, shape: &Superquadric) -> f64 {
        if self.area.is_some() || self.pull > 0.0 {
            f64::NEG_INFINITY
        } else {
            1e-24 * self.points.len() as f64 * shape.semi_axes.norm_squared()
        }
    }

    /// The logarithm of an area has no zero of its own, but its price is about
    /// the size of Σ w·d².
    fn scale(&self, cost: f64) -> f64 {
        self.area.map_or(if self.pull > 0.0 { cost.abs().max(self.pull) } else { cost }, |area| area.price)
    }
}

/// The box of each parameter where the points have the box (`low`, `high`) in
/// the primitive's frame: each semi-axis at most half the extent along it,
/// times the reach, the centre inside, but for the thickness of the thinnest
/// plate.
fn bounds(low: &Vector3<f64>, high: &Vector3<f64>, shape: &Superquadric, limits: Limits) -> (Theta, Theta) {
    let Limits { smallest_axis, .. } = limits;
    let reach = limits.reaches(shape);
    let extent = (high - low) * 0.5;
    let half = extent.component_mul(&reach).map(|h| h.max(2.0 * smallest_axis));
    let Bounds { exponents: (e0, e1), taper: (k0, k1), .. } = Bounds::FITS;
    let (a0, w) = (smallest_axis, LARGEST_TURN);
    let beyond = extent.component_mul(&reach.add_scalar(-1.0)).add_scalar(2.0 * a0);
    let (low, high) = (low - beyond, high + beyond);
    (
        Theta::from([e0, e0, a0, a0, a0, -w, -w, -w, low.x, low.y, low.z, k0, k0]),
        Theta::from([e1, e1, half.x, half.y, half.z, w, w, w, high.x, high.y, high.z, k1, k1]),
    )
}

/// Minimises Σ d² over all 13 parameters from `start`, in at most
/// `iterations` steps, until a step gains less than `tolerance` (relative).
/// Semi-axes and centre stay within `limits`.
pub(crate) fn minimize(
    points: &PointBlock,
    distance: Distance,
    start: &Superquadric,
    limits: Limits,
    iterations: usize,
    tolerance: f64,
    cancel: &Cancel,
) -> Minimum {
    let mut target =
        Target { points, distance, weights: None, area: None, pull: limits.pull * points.len() as f64 };
    descend(&mut target, start, limits, iterations, tolerance, cancel)
}

/// [`minimize`] for any cost.
pub(crate) fn descend(
    objective: &mut impl Objective,
    start: &Superquadric,
    limits: Limits,
    iterations: usize,
    tolerance: f64,
    cancel: &Cancel,
) -> Minimum {
    let mut shape = limits.told(*start);
    let mut cost_now = f64::INFINITY;
    let mut damping = 1e-2;
    let mut stop = Stop::Iterations;
    'outer: for _ in 0..iterations {
        if cancel.is_requested() {
            stop = Stop::Cancelled;
            break;
        }
        let normal = objective.linearize(&shape);
        cost_now = normal.cost;
        if !cost_now.is_finite() || !normal.jtj.iter().all(|v| v.is_finite()) {
            stop = Stop::NotFinite;
            break;
        }
        // A perfect fit: nothing is left but rounding.
        if cost_now <= objective.least(&shape) {
            stop = Stop::Converged;
            break;
        }
        let now = shape.theta();
        let (lo, hi) = bounds(&normal.low, &normal.high, &shape, limits);
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
            let candidate = limits.told(shape.retracted(&next));
            let cost_next = objective.cost(&candidate);
            if cost_next < cost_now {
                let gain = (cost_now - cost_next) / objective.scale(cost_now);
                shape = candidate;
                cost_now = cost_next;
                damping = (damping * 0.2).max(1e-5);
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
        cost_now = objective.cost(&shape);
    }
    Minimum { shape, cost: cost_now, stop }
}
