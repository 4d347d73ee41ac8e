//! The fit of one primitive in both directions: its points lie near its
//! surface, and its surface near the cloud, but for what other primitives
//! hide. Least squares on the points alone lets a primitive stick out over
//! empty space, where it costs nothing.

use nalgebra::{Point3, Vector3};

use crate::geometry::kernel::{self, NormalEquations, PointBlock};
use crate::geometry::theta::{PARAMETERS, SEMI_AXES_AT, TAPER_AT};
use crate::geometry::{Superquadric, tessellate};
use crate::inference::control::Cancel;
use crate::inference::data::known_space::KnownSpace;
use crate::inference::data::limits::Limits;
use crate::inference::data::model::Model;
use crate::inference::data::surface_distance::SurfaceDistance;
use crate::inference::fit::area::area_of_ellipsoid;
use crate::inference::fit::levenberg_marquardt::{Objective, descend};

/// Distances above so many mean spacings count by their first power, as in the
/// Chamfer distance; those below, which the cloud can't tell from 0, by their
/// square.
pub(crate) const PSEUDO_HUBER_DELTA: f64 = 0.12;
/// Area of the surface that one point stands for, in squared mean spacings:
/// 0.85 on a square lattice, 0.87 on a hexagonal one, somewhat more for blue noise.
const AREA_PER_POINT: f64 = 0.9;
/// Surface this many mean spacings inside another primitive is hidden: faces by
/// which two primitives abut don't count.
const HIDDEN: f64 = 0.1;
/// What a point's worth of surface in unknown space adds, in mean spacings: so
/// little that of the bodies that explain the points the smallest wins.
const UNKNOWN: f64 = 0.01;
/// What the square of a taper costs each point, in mean spacings, where one side
/// is seen: little, so that points decide where they can.
const TAPER: f64 = 0.05;
/// Samples of one primitive at most.
const MAX_SAMPLES: usize = 1500;
/// Points and samples of one primitive at most in a fit that need not be the
/// last: thirteen parameters ask for no more.
const ROUGH: usize = 350;
/// Logarithms of coordinates stay above that of this.
const SMALLEST_COORDINATE: f64 = 1e-9;

/// √(d² + δ²) − δ: the distance itself beyond δ, its square/2δ below.
pub(crate) fn pseudo_huber(d: f64, spacing: f64) -> f64 {
    let delta = PSEUDO_HUBER_DELTA * spacing;
    (d * d + delta * delta).sqrt() - delta
}

/// What a point's worth of surface at `place` adds, which is `distance` away from
/// the cloud: where nobody has looked, little.
pub(crate) fn surface_cost(
    known: Option<&KnownSpace>,
    place: &Point3<f64>,
    distance: f64,
    spacing: f64,
) -> f64 {
    let cost = pseudo_huber(distance, spacing);
    if is_unknown(known, place, cost, spacing) { UNKNOWN * spacing } else { cost }
}

/// What the tapers of a body of `area` points' worth cost where one side is seen.
pub(crate) fn taper_cost(shape: &Superquadric, area: f64, spacing: f64) -> f64 {
    TAPER * spacing * area * shape.taper.iter().map(|k| k * k).sum::<f64>()
}

/// Whether a place that would cost so much, were it free, isn't known to be.
fn is_unknown(known: Option<&KnownSpace>, place: &Point3<f64>, cost: f64, spacing: f64) -> bool {
    known.is_some_and(|known| cost > UNKNOWN * spacing && !known.is_free(place))
}

/// A sample of a primitive's surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfaceSample {
    pub(crate) place: Point3<f64>,
    /// The place moved outward: hidden if another primitive contains this.
    pub(crate) outside: Point3<f64>,
}

/// Samples of a surface, as dense as the cloud, and how many points' worth of
/// area each stands for.
pub(crate) fn sample_surface(
    shape: &Superquadric,
    spacing: f64,
    detail: Detail,
) -> (Vec<SurfaceSample>, f64) {
    let most = detail.most();
    let apart = AREA_PER_POINT.sqrt() * spacing;
    let samples = tessellate::surface_samples(shape, apart, most);
    let weight = if samples.len() == most {
        tessellate::surface_area(shape) / (apart * apart * samples.len() as f64)
    } else {
        1.0
    };
    let samples = samples
        .into_iter()
        .map(|(place, normal)| SurfaceSample { place, outside: place + normal * (HIDDEN * spacing) })
        .collect();
    (samples, weight)
}

/// How closely a fit looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Detail {
    /// At some of the points, and as few samples of the surface.
    Rough,
    Full,
}

impl Detail {
    /// Points and samples at most.
    fn most(self) -> usize {
        match self {
            Self::Rough => ROUGH,
            Self::Full => MAX_SAMPLES,
        }
    }
}

/// What a primitive is fitted against.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub(crate) surface: &'a SurfaceDistance,
    /// Mean spacing s̄.
    pub(crate) spacing: f64,
    pub(crate) limits: Limits,
    /// What is free; all space without points where there is none.
    pub(crate) known: Option<&'a KnownSpace>,
    /// Primitives whose inside hides surface.
    pub(crate) others: &'a [Superquadric],
}

impl<'a> Surroundings<'a> {
    pub(crate) fn new(model: &'a Model, others: &'a [Superquadric]) -> Self {
        Self {
            surface: &model.surface,
            spacing: model.spacing,
            limits: model.limits(),
            known: model.known.as_deref(),
            others,
        }
    }

    /// Minimises the two-way error of `points` from `start` in at most `steps`
    /// steps. Returns the primitive and its error, Σ of [`pseudo_huber`] distances of
    /// the points and, a point's worth of area each, of the visible surface;
    /// `None` if it was cancelled or comes to nothing. A rough error is an
    /// estimate from those points and samples that were looked at.
    pub(crate) fn fit(
        &self,
        points: &[Point3<f64>],
        start: &Superquadric,
        steps: usize,
        detail: Detail,
        cancel: &Cancel,
    ) -> Option<(Superquadric, f64)> {
        let stride = match detail {
            Detail::Rough => points.len().div_ceil(detail.most()).max(1),
            Detail::Full => 1,
        };
        let seen: PointBlock = points.iter().step_by(stride).copied().collect();
        let mut objective = SymmetricError {
            surroundings: *self,
            point_weight: points.len() as f64 / seen.len().max(1) as f64,
            points: seen,
            samples: Vec::new(),
            unknown: 0.0,
            rest: 0.0,
            free: PointBlock::default(),
            detail,
            sample_weight: 1.0,
        };
        let found = descend(
            &mut objective,
            start,
            self.limits,
            steps,
            if self.known.is_some() { 0.1 * TOLERANCE } else { TOLERANCE },
            cancel,
        );
        if cancel.is_requested() || !found.shape.is_valid() {
            return None;
        }
        // Each step has samples of its own; the last ones judge.
        objective.resample(&found.shape);
        let cost = objective.cost(&found.shape);
        cost.is_finite().then_some((found.shape, cost))
    }
}

/// Relative gain under which a step ends the fit.
const TOLERANCE: f64 = 1e-3;

struct SymmetricError<'a> {
    surroundings: Surroundings<'a>,
    points: PointBlock,
    /// Points that each of them stands for.
    point_weight: f64,
    /// Visible samples by their place on the primitive, normalised untapered
    /// coordinates: they stay while θ moves, until the next linearisation.
    samples: Vec<Vector3<f64>>,
    detail: Detail,
    /// Points' worth of area of a sample.
    sample_weight: f64,
    /// Cost of the surface in unknown space, by [`area_of_ellipsoid`].
    unknown: f64,
    /// Its part of the cost at the last linearisation, which no fit can save.
    rest: f64,
    /// Free places inside of the body.
    free: PointBlock,
}

impl SymmetricError<'_> {
    fn resample(&mut self, shape: &Superquadric) {
        let Surroundings { spacing, others, .. } = self.surroundings;
        let reach = shape.reach().norm();
        let near: Vec<&Superquadric> = others
            .iter()
            .filter(|o| (o.translation - shape.translation).norm() < reach + o.reach().norm())
            .collect();
        let (samples, weight) = sample_surface(shape, spacing, self.detail);
        self.sample_weight = weight;
        self.samples.clear();
        let mut unknown = 0usize;
        let visible = samples.iter().filter(|s| !near.iter().any(|o| o.contains(&s.outside)));
        for s in visible {
            if self.is_unknown(&s.place) {
                unknown += 1;
            } else {
                let place = shape.untapered(&shape.local(&s.place)).component_div(&shape.semi_axes);
                self.samples.push(place);
            }
        }
        if let Some(known) = self.surroundings.known {
            let cost = unknown as f64 * weight * UNKNOWN * spacing;
            self.unknown = cost / area_of_ellipsoid(&shape.semi_axes).0;
            self.free = known.inside(shape);
        }
    }

    fn is_unknown(&self, place: &Point3<f64>) -> bool {
        let Surroundings { surface, spacing, known, .. } = self.surroundings;
        known.is_some()
            && is_unknown(known, place, pseudo_huber(surface.offset(place).distance, spacing), spacing)
    }

    /// What the square of a taper costs; nothing where all sides are seen.
    fn taper_price(&self) -> f64 {
        let Surroundings { spacing, known, .. } = self.surroundings;
        let one = if known.is_some() { TAPER * spacing } else { 0.0 };
        one * self.point_weight * self.points.len() as f64
    }

    /// What a free place inside of the body counts, against a point.
    fn free_weight(&self) -> f64 {
        self.surroundings.known.map_or(0.0, KnownSpace::weight)
    }
}

impl Objective for SymmetricError<'_> {
    fn linearize(&mut self, shape: &Superquadric) -> NormalEquations {
        self.resample(shape);
        let Surroundings { surface, spacing, known, .. } = self.surroundings;
        let delta = PSEUDO_HUBER_DELTA * spacing;
        // Iteratively reweighted least squares: ρ(d) has the slope d/√(d² + δ²).
        let size = |d: f64| (d * d + delta * delta).sqrt();

        let mut normal = kernel::pseudo_huber_normal_equations(shape, &self.points, delta);
        normal.jtj *= self.point_weight;
        normal.jtr *= self.point_weight;
        normal.cost *= self.point_weight;
        let mut add = |row: &[f64; PARAMETERS], d: f64, weight: f64| {
            let w = weight / size(d);
            for i in 0..PARAMETERS {
                normal.jtr[i] += w * row[i] * d;
                for j in 0..PARAMETERS {
                    normal.jtj[(i, j)] += w * row[i] * row[j];
                }
            }
        };
        let mut error = 0.0;
        for n in &self.samples {
            let offset = surface.offset(&shape.world_from_normalized(n));
            if offset.distance > 0.0 {
                add(&surface_row(shape, n, &offset.direction), offset.distance, self.sample_weight);
                error += pseudo_huber(offset.distance, spacing);
            }
        }
        normal.cost += self.sample_weight * error;
        if !self.free.is_empty() {
            let weight = self.free_weight();
            let free = kernel::pseudo_huber_normal_equations(shape, &self.free, delta);
            normal.jtj += free.jtj * weight;
            normal.jtr += free.jtr * weight;
            normal.cost += free.cost * weight;
        }
        if known.is_some() {
            let price = self.taper_price();
            for (k, taper) in shape.taper.into_iter().enumerate() {
                normal.jtr[TAPER_AT + k] += 2.0 * price * taper;
                normal.jtj[(TAPER_AT + k, TAPER_AT + k)] += 2.0 * price;
                normal.cost += price * taper * taper;
            }
        }
        if self.unknown > 0.0 {
            let (area, gradient) = area_of_ellipsoid(&shape.semi_axes);
            self.rest = self.unknown * area;
            normal.cost += self.rest;
            for axis in 0..3 {
                normal.jtr[SEMI_AXES_AT + axis] += self.unknown * gradient[axis];
            }
        }
        normal
    }

    fn cost(&self, shape: &Superquadric) -> f64 {
        let Surroundings { surface, spacing, .. } = self.surroundings;
        let there = kernel::pseudo_huber_cost(shape, &self.points, PSEUDO_HUBER_DELTA * spacing);
        let back: f64 = self
            .samples
            .iter()
            .map(|n| pseudo_huber(surface.offset(&shape.world_from_normalized(n)).distance, spacing))
            .sum();
        let free = if self.free.is_empty() {
            0.0
        } else {
            let inside = self.free.iter().filter(|p| shape.contains(p)).collect();
            kernel::pseudo_huber_cost(shape, &inside, PSEUDO_HUBER_DELTA * spacing)
        };
        self.point_weight * there
            + self.sample_weight * back
            + self.free_weight() * free
            + self.unknown * area_of_ellipsoid(&shape.semi_axes).0
            + self.taper_price() * shape.taper.iter().map(|k| k * k).sum::<f64>()
    }

    fn scale(&self, cost: f64) -> f64 {
        (cost - self.rest).max(f64::MIN_POSITIVE)
    }

    fn least(&self, _: &Superquadric) -> f64 {
        1e-9 * self.surroundings.spacing * self.point_weight * self.points.len() as f64
    }
}

/// ∂(u·s)/∂θ of the surface point s that has the normalised coordinates n: the
/// angles of the parametrisation stay, u is a fixed direction.
fn surface_row(shape: &Superquadric, n: &Vector3<f64>, u: &Vector3<f64>) -> [f64; PARAMETERS] {
    let [e1, e2] = shape.exponents;
    let [kx, ky] = shape.taper;
    let a = shape.semi_axes;
    let g = shape.rotation.matrix().tr_mul(u);
    let ln = |v: f64| v.abs().max(SMALLEST_COORDINATE).ln();
    let (lx, ly, lz) = (ln(n.x), ln(n.y), ln(n.z));
    // ln ρ of the section's radius: ρ^(2/ε2) = |nx|^(2/ε2) + |ny|^(2/ε2).
    let top = lx.max(ly);
    let rho = top + 0.5 * e2 * (((lx - top) * 2.0 / e2).exp() + ((ly - top) * 2.0 / e2).exp()).ln();
    let (sx, sy) = (kx * n.z + 1.0, ky * n.z + 1.0);
    // cos^ε1 η and its like: the derivative by ε is the value times its own
    // logarithm over ε.
    let (x1, y1, z1) = (n.x * rho / e1, n.y * rho / e1, n.z * lz / e1);
    let (x2, y2) = (n.x * (lx - rho) / e2, n.y * (ly - rho) / e2);
    let p = Vector3::new(a.x * n.x * sx, a.y * n.y * sy, a.z * n.z);
    let turn = p.cross(&g);
    [
        g.x * a.x * (x1 * sx + n.x * kx * z1) + g.y * a.y * (y1 * sy + n.y * ky * z1) + g.z * a.z * z1,
        g.x * a.x * x2 * sx + g.y * a.y * y2 * sy,
        g.x * n.x * sx,
        g.y * n.y * sy,
        g.z * n.z,
        turn.x,
        turn.y,
        turn.z,
        g.x,
        g.y,
        g.z,
        g.x * a.x * n.x * n.z,
        g.y * a.y * n.y * n.z,
    ]
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;
    use crate::geometry::neighbors::KdTree;

    fn odd_shape() -> Superquadric {
        Superquadric {
            exponents: [0.6, 1.3],
            semi_axes: Vector3::new(0.7, 1.1, 0.9),
            rotation: Rotation3::from_euler_angles(0.4, -0.7, 1.1),
            translation: Vector3::new(0.3, -0.2, 0.5),
            taper: [0.4, -0.3],
        }
    }

    fn check(row: [f64; PARAMETERS], value: impl Fn(&Superquadric) -> f64) {
        let shape = odd_shape();
        for (k, analytic) in row.into_iter().enumerate() {
            let h = 1e-5;
            let numeric = (value(&shape.nudged(k, h)) - value(&shape.nudged(k, -h))) / (2.0 * h);
            assert!((analytic - numeric).abs() < 1e-6 * (1.0 + numeric.abs()), "{k}: {analytic} {numeric}");
        }
    }

    #[test]
    fn surface_rows_are_the_derivatives_at_fixed_angles() {
        let u = Vector3::new(0.2, -0.9, 0.4).normalize();
        for (eta, omega) in [(0.3, 0.4), (-0.9, 2.0), (1.2, -2.5), (0.1, -0.8)] {
            let (eta, omega): (f64, f64) = (eta, omega);
            let power = |v: f64, e: f64| v.signum() * v.abs().powf(e);
            let normalized = |s: &Superquadric| {
                let [e1, e2] = s.exponents;
                let ring = power(eta.cos(), e1);
                Vector3::new(
                    ring * power(omega.cos(), e2),
                    ring * power(omega.sin(), e2),
                    power(eta.sin(), e1),
                )
            };
            let along = |s: &Superquadric| u.dot(&s.world_from_normalized(&normalized(s)).coords);
            let shape = odd_shape();
            let row = surface_row(&shape, &normalized(&shape), &u);
            check(row, along);
        }
    }

    #[test]
    fn a_primitive_that_sticks_out_is_drawn_back() {
        // A square column whose top is open to all sides but up: points say
        // nothing against a longer one, the empty space does.
        let truth = Superquadric {
            exponents: [0.1, 0.1],
            semi_axes: Vector3::new(0.3, 0.3, 1.0),
            rotation: Rotation3::identity(),
            translation: Vector3::zeros(),
            taper: [0.0, 0.0],
        };
        let points: Vec<Point3<f64>> =
            tessellate::surface_samples(&truth, 0.05, 5000).into_iter().map(|s| s.0).collect();
        // Only the lower half belongs to this primitive.
        let mine: Vec<Point3<f64>> = points.iter().filter(|p| p.z < 0.0).copied().collect();
        let surface = SurfaceDistance::new(KdTree::new(&mine), &mine, 0.05);
        let start = Superquadric {
            semi_axes: Vector3::new(0.3, 0.3, 0.8),
            translation: Vector3::new(0.0, 0.0, -0.3),
            ..truth
        };
        let limits = Limits::surrounded(0.0025);
        let around = Surroundings { surface: &surface, spacing: 0.05, limits, known: None, others: &[] };
        let (found, _) = around.fit(&mine, &start, 30, Detail::Full, &Cancel::default()).unwrap();
        let top = found.translation.z + found.half_extents().z;
        assert!(top < 0.1, "it reaches up to {top}");
        // The same where another primitive hides what sticks out: then it may.
        let other = Superquadric {
            semi_axes: Vector3::new(0.4, 0.4, 0.6),
            translation: Vector3::new(0.0, 0.0, 0.6),
            ..truth
        };
        let around = Surroundings { others: &[other], ..around };
        let (_, hidden) = around.fit(&mine, &start, 0, Detail::Full, &Cancel::default()).unwrap();
        let around = Surroundings { others: &[], ..around };
        let (_, open) = around.fit(&mine, &start, 0, Detail::Full, &Cancel::default()).unwrap();
        assert!(hidden < 0.5 * open, "{hidden} {open}");
    }
}
