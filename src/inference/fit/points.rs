//! The fit of one primitive to its points: several starts, and the two
//! switches between similar configurations of Liu et al. (EMS, CVPR 2022).

use nalgebra::{Point3, Rotation3, Vector3};

use crate::geometry::Superquadric;
use crate::geometry::kernel::{Distance, PointBlock};
use crate::inference::control::Cancel;
use crate::inference::data::limits::Limits;
use crate::inference::fit::levenberg_marquardt::{Minimum, Objective, Stop, Target, minimize};
use crate::inference::fit::moments::{box_of_extents, ellipsoid_of_moments, smallest_box, with_axis_as_z};

/// The moments start of the paper is four times smaller than the points.
pub(crate) const START_SHRINK: f64 = 0.25;
/// A configuration must be better by this share to be taken over.
const BETTER: f64 = 0.98;
/// Switches of configuration in one fit.
const MAX_SWITCHES: usize = 2;

/// Points whose box is thinner than this share of its width are tried as a
/// plate, too, which the moments hardly ever grow into.
const PLATE: f64 = 0.1;

/// Starts and configurations are tried on about this many of the points;
/// thirteen parameters need no more to be told apart.
const PROBE_POINTS: usize = 170;

/// How much work a fit may do.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Try the moments and the similar configurations, not the warm starts
    /// alone.
    pub(crate) explore: bool,
    /// LM steps to try a start or a configuration with.
    pub(crate) probe: usize,
    /// LM steps for the best one.
    pub(crate) polish: usize,
    /// Relative gain under which a step ends the polish.
    pub(crate) tolerance: f64,
}

impl Effort {
    /// Inside the Gibbs iterations: the next one goes on from here.
    pub(crate) const ITERATION: Self = Self { explore: true, probe: 6, polish: 8, tolerance: 1e-3 };
    /// The same where little has changed since the last exploration.
    pub(crate) const FOLLOW: Self = Self { explore: false, ..Self::ITERATION };
    /// To see whether a merge is worth a thorough fit.
    pub(crate) const ROUGH: Self = Self { explore: true, probe: 5, polish: 3, tolerance: 1e-2 };
    /// For merges and the end of a run, where nothing follows that could mend.
    pub(crate) const THOROUGH: Self = Self { explore: true, probe: 8, polish: 40, tolerance: 1e-4 };
}

/// Fits a primitive to `points` from the moments, from their box if it is a
/// plate, and from the primitives
/// `warm`; of all starts and configurations the one with the smallest Σ d².
/// Semi-axes and centre stay within `limits`.
///
/// The radial distance leads from afar, where the first-order one knows
/// little; the polish then minimises `distance` itself.
///
/// `None` when the fit was cancelled or no start gives a finite cost.
pub(crate) fn fit(
    points: &[Point3<f64>],
    warm: &[Superquadric],
    limits: Limits,
    effort: Effort,
    distance: Distance,
    cancel: &Cancel,
) -> Option<Minimum> {
    let block: PointBlock = points.iter().copied().collect();
    let stride = (points.len() / PROBE_POINTS).max(1);
    let few: PointBlock = points.iter().step_by(stride).copied().collect();
    let probe = |start: &Superquadric| {
        let m = minimize(&few, Distance::Radial, start, limits, effort.probe, effort.tolerance, cancel);
        let pull = limits.pull * few.len() as f64;
        let target = Target { points: &few, distance, weights: None, area: None, pull };
        Minimum { cost: target.cost(&m.shape), ..m }
    };
    let mut starts = warm.to_vec();
    if effort.explore {
        let moments = ellipsoid_of_moments(points, START_SHRINK, limits.smallest_axis);
        let plate = if limits.reach > 1.0 {
            smallest_box(points, &moments, limits.smallest_axis)
        } else {
            box_of_extents(points, &moments, limits.smallest_axis)
        };
        if plate.semi_axes.x < PLATE * plate.semi_axes.y {
            starts.push(plate);
        }
        starts.push(moments);
    }
    let mut best = match starts[..] {
        // Nothing to choose from.
        [shape] if !effort.explore => Minimum { shape, cost: f64::INFINITY, stop: Stop::Iterations },
        _ => starts.iter().map(probe).min_by(|a, b| a.cost.total_cmp(&b.cost))?,
    };

    for _ in 0..if effort.explore { MAX_SWITCHES } else { 0 } {
        let better = similar_configurations(&best.shape)
            .into_iter()
            // (Duality shortens two axes.)
            .map(|start| {
                probe(&Superquadric {
                    semi_axes: start.semi_axes.map(|a| a.max(limits.smallest_axis)),
                    ..start
                })
            })
            .find(|m| m.cost < best.cost - (1.0 - BETTER) * best.cost.abs());
        match better {
            Some(m) => best = m,
            None => break,
        }
    }
    best = minimize(&block, distance, &best.shape, limits, effort.polish, effort.tolerance, cancel);
    let usable = best.cost.is_finite() && best.shape.is_valid() && best.stop != Stop::Cancelled;
    (usable && !cancel.is_requested()).then_some(best)
}

/// Bodies with the extents of some points that the points alone can't tell from
/// others: the box in the frame of `like`, which may be one of its faces; for
/// points of a sheet the smallest plate around them, in several outlines.
pub(crate) fn boxes_and_plates(points: &[Point3<f64>], like: &Superquadric, floor: f64) -> Vec<Superquadric> {
    let plate = smallest_box(points, &ellipsoid_of_moments(points, 1.0, floor), floor);
    let mut found = outlines(&plate);
    if !found.is_empty() {
        found.push(plate);
    }
    found.push(box_of_extents(points, like, floor));
    found
}

/// A plate with other outlines of the same extents: an ellipse, and triangles.
/// None where the box is no plate.
fn outlines(whole: &Superquadric) -> Vec<Superquadric> {
    let thin = whole.semi_axes.imin();
    // The thin axis becomes x.
    let plate = with_axis_as_z(whole, (thin + 2) % 3);
    if plate.semi_axes.x > PLATE * plate.semi_axes.y.min(plate.semi_axes.z) {
        return Vec::new();
    }
    let disc = Superquadric { exponents: [plate.exponents[0], 1.0], ..with_axis_as_z(&plate, 0) };
    let mut found = vec![disc];
    for axis in [1, 2] {
        let along = with_axis_as_z(&plate, axis);
        for sign in [-1.0, 1.0] {
            // Tapered across its width, not its thickness.
            let taper =
                if along.semi_axes.x > along.semi_axes.y { [0.9 * sign, 0.0] } else { [0.0, 0.9 * sign] };
            let mut semi_axes = along.semi_axes;
            semi_axes[if taper[0] != 0.0 { 0 } else { 1 }] /= 1.9;
            found.push(Superquadric { taper, semi_axes, ..along });
        }
    }
    found
}

/// Configurations whose surface resembles that of `shape`, but from which the
/// fit can descend elsewhere:
/// *axis mismatch*, each of the other two axes as the axis of the profile, and
/// *duality*, a square section of ε2 turned by 45° is nearly one of 2 − ε2.
pub(crate) fn similar_configurations(shape: &Superquadric) -> Vec<Superquadric> {
    let mut found = vec![with_axis_as_z(shape, 0), with_axis_as_z(shape, 1)];
    for axis in [2, 0, 1] {
        let as_z = with_axis_as_z(shape, axis);
        let (ax, ay) = (as_z.semi_axes.x, as_z.semi_axes.y);
        if (ax - ay).abs() <= 0.1 * ax.max(ay) {
            let e2 = as_z.exponents[1];
            // A square's half-diagonal is √2 times its half-side, with a linear
            // passage between the box (0), the circle (1) and the diamond (2).
            let sqrt2 = std::f64::consts::SQRT_2;
            let length = if e2 <= 1.0 {
                (1.0 - sqrt2) * e2 + sqrt2
            } else {
                (sqrt2 / 2.0 - 1.0) * e2 + 2.0 - sqrt2 / 2.0
            };
            let a = 0.5 * (ax + ay) * length;
            found.push(Superquadric {
                exponents: [as_z.exponents[0], 2.0 - e2],
                semi_axes: Vector3::new(a, a, as_z.semi_axes.z),
                rotation: as_z.rotation
                    * Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_4),
                taper: [0.0, 0.0],
                ..as_z
            });
        }
    }
    found
}
