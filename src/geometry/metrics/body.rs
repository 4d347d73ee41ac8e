//! The primitives as bodies: what is inside, and samples of their surface.

use std::ops::Range;

use nalgebra::{Point3, Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::triangles::{area, random_point, running_sum};
use crate::geometry::Superquadric;
use crate::geometry::frame::Frame;
use crate::geometry::tessellate::{Resolution, surface_vertices};

/// The surfaces' triangles are fine enough for their area to be even within
/// a fraction of a percent.
pub(super) const RESOLUTION: Resolution = Resolution { profile: 48, section: 48 };
/// Exponents below this are a box already.
const LEAST_EXPONENT: f64 = 1e-3;
/// Taper factors below this are an apex.
const LEAST_FACTOR: f64 = 1e-12;

/// A primitive in the reference's frame.
#[derive(Debug, Clone)]
pub(super) struct Body {
    shape: Superquadric,
    /// A box around it, along the frame's axes.
    pub(super) lo: Point3<f64>,
    pub(super) hi: Point3<f64>,
}

impl Body {
    pub(super) fn new(shape: &Superquadric, frame: &Frame) -> Self {
        let shape = Superquadric {
            exponents: shape.exponents.map(|e| e.max(LEAST_EXPONENT)),
            semi_axes: shape.semi_axes / frame.unit,
            translation: frame.local(&shape.translation.into()).coords,
            ..*shape
        };
        let reach = shape.rotation.matrix().abs() * shape.half_extents();
        let center = Point3::from(shape.translation);
        Self { shape, lo: center - reach, hi: center + reach }
    }

    /// ‖n‖, 1 on the surface, of a point in units of the semi-axes, untapered:
    /// F^(ε1/2), homogeneous of degree 1.
    #[inline]
    fn gauge(&self, n: &Vector3<f64>) -> f64 {
        let norm = |u: f64, v: f64, power: f64| {
            let (u, v) = (u.abs(), v.abs());
            let (small, large) = (u.min(v), u.max(v));
            if large > 0.0 { large * (1.0 + (small / large).powf(power)).powf(1.0 / power) } else { 0.0 }
        };
        let [e1, e2] = self.shape.exponents;
        norm(norm(n.x, n.y, 2.0 / e2), n.z, 2.0 / e1)
    }

    /// Whether a point lies strictly inside.
    #[inline]
    pub(super) fn contains(&self, x: &Point3<f64>) -> bool {
        if (0..3).any(|axis| x[axis] <= self.lo[axis] || x[axis] >= self.hi[axis]) {
            return false;
        }
        let p = self.shape.local(x);
        let w = p.z / self.shape.semi_axes.z;
        let (sx, sy) = (self.shape.taper[0] * w + 1.0, self.shape.taper[1] * w + 1.0);
        if w.abs() >= 1.0 || sx <= LEAST_FACTOR || sy <= LEAST_FACTOR {
            return false;
        }
        let n = Vector3::new(p.x / (sx * self.shape.semi_axes.x), p.y / (sy * self.shape.semi_axes.y), w);
        // Every body lies within the box and holds, by its exponents, the ball
        // or the octahedron: few points need the powers.
        if n.amax() >= 1.0 {
            return false;
        }
        let [e1, e2] = self.shape.exponents;
        let widest = e1.max(e2);
        if (widest <= 1.0 && n.norm_squared() < 1.0) || (widest <= 2.0 && n.lp_norm(1) < 1.0) {
            return true;
        }
        self.gauge(&n) < 1.0
    }
}

/// Whether a point lies in any of the bodies but `except`.
#[inline]
pub(super) fn inside_any(bodies: &[Body], x: &Point3<f64>, except: Option<usize>) -> bool {
    bodies.iter().enumerate().any(|(j, body)| Some(j) != except && body.contains(x))
}

/// Draws points from a body's surface, evenly by area.
#[derive(Debug)]
pub(super) struct SurfaceSampler<'a> {
    body: &'a Body,
    /// In the primitive's own frame.
    vertices: Vec<Point3<f64>>,
    faces: &'a [[u32; 3]],
    /// Sum of the areas up to and including each face.
    area_up_to: Vec<f64>,
}

impl<'a> SurfaceSampler<'a> {
    /// `faces` are those of [`RESOLUTION`].
    pub(super) fn new(body: &'a Body, faces: &'a [[u32; 3]]) -> Self {
        let local =
            Superquadric { rotation: Rotation3::identity(), translation: Vector3::zeros(), ..body.shape };
        let vertices: Vec<Point3<f64>> = surface_vertices(&local, RESOLUTION).map(|v| v.0).collect();
        let area_up_to = running_sum(faces.iter().map(|f| area(&f.map(|i| vertices[i as usize]))));
        Self { body, vertices, faces, area_up_to }
    }

    pub(super) fn area(&self) -> f64 {
        self.area_up_to.last().copied().unwrap_or(0.0)
    }

    /// The `range` of `count` points, each with the outward normal of its
    /// face, in the reference's frame. The i-th point comes from the i-th of
    /// `count` equal shares of the area.
    pub(super) fn draw(
        &self,
        count: usize,
        range: Range<usize>,
        rng: &mut ChaCha8Rng,
    ) -> impl Iterator<Item = (Point3<f64>, Vector3<f64>)> {
        let share = self.area() / count as f64;
        let shape = self.body.shape;
        range.map(move |i| {
            let at = (i as f64 + rng.random::<f64>()) * share;
            let face = self.area_up_to.partition_point(|&a| a <= at).min(self.faces.len() - 1);
            let [a, b, c] = self.faces[face].map(|i| self.vertices[i as usize]);
            let p = random_point(&[a, b, c], rng);
            let w = p.z / shape.semi_axes.z;
            let (sx, sy) =
                ((shape.taper[0] * w + 1.0).max(LEAST_FACTOR), (shape.taper[1] * w + 1.0).max(LEAST_FACTOR));
            let n = Vector3::new(p.x / (sx * shape.semi_axes.x), p.y / (sy * shape.semi_axes.y), w);
            let gauge = self.body.gauge(&n);
            let on_surface = if gauge > 0.0 { n / gauge } else { n };
            let normal = (b - a).cross(&(c - a));
            let length = normal.norm();
            let normal = if length > 0.0 { shape.rotation * normal / length } else { Vector3::zeros() };
            (shape.world_from_normalized(&on_surface), normal)
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::SeedableRng;

    use super::*;

    fn shapes() -> impl Strategy<Value = Superquadric> {
        let axes = prop::array::uniform3(0.05f64..0.6);
        let rest = (prop::array::uniform2(0.1f64..1.9), prop::array::uniform2(-1.0f64..1.0));
        (axes, rest, prop::array::uniform3(-3.0f64..3.0)).prop_map(|(axes, (exponents, taper), turn)| {
            Superquadric {
                exponents,
                semi_axes: axes.into(),
                rotation: Rotation3::new(turn.into()),
                translation: Vector3::new(1.0, -2.0, 0.5),
                taper,
            }
        })
    }

    /// A frame that changes nothing.
    const WORLD: Frame = Frame { center: Vector3::new(0.0, 0.0, 0.0), unit: 1.0 };

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn inside_is_where_the_implicit_function_is_negative(shape in shapes(), seed in 0u64..1000) {
            let body = Body::new(&shape, &WORLD);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            for _ in 0..200 {
                let t = Vector3::new(rng.random::<f64>(), rng.random(), rng.random()) * 1.2
                    - Vector3::repeat(0.1);
                let x = body.lo + (body.hi - body.lo).component_mul(&t);
                // Taper factors below the floor of the radial distance differ.
                let [sx, sy] = shape.taper_factors(shape.local(&x).z);
                let value = shape.log_implicit(&x);
                if sx.min(sy) > 0.021 && value.abs() > 1e-6 {
                    prop_assert_eq!(body.contains(&x), shape.contains(&x), "{} {:?}", value, x);
                }
            }
        }

        #[test]
        fn samples_lie_on_the_surface_and_normals_lead_out(shape in shapes(), seed in 0u64..1000) {
            let body = Body::new(&shape, &WORLD);
            let faces = RESOLUTION.faces();
            let sampler = SurfaceSampler::new(&body, &faces);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut out = 0;
            for (x, normal) in sampler.draw(300, 0..300, &mut rng) {
                let [sx, sy] = shape.taper_factors(shape.local(&x).z);
                if sx.min(sy) > 0.05 {
                    prop_assert!(shape.first_order_distance(&x) < 1e-4);
                }
                // At the tips of stars a facet may lie across the surface.
                out += usize::from(!body.contains(&(x + normal * 1e-4)));
            }
            prop_assert!(out >= 285, "{} of 300", out);
        }
    }

    #[test]
    fn a_sphere_is_sampled_evenly() {
        let shape = Superquadric::sphere(Point3::new(2.0, 0.0, 0.0), 0.5);
        let body = Body::new(&shape, &WORLD);
        let faces = RESOLUTION.faces();
        let sampler = SurfaceSampler::new(&body, &faces);
        assert!((sampler.area() / std::f64::consts::PI - 1.0).abs() < 2e-3);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let n = 20_000;
        // Archimedes: every height of a sphere has the same area.
        let mut slices = [0; 10];
        for (x, _) in sampler.draw(n, 0..n, &mut rng) {
            slices[((x.z + 0.5) * 10.0).clamp(0.0, 9.0) as usize] += 1;
        }
        assert!(slices.iter().all(|s| (*s as f64 - 2000.0).abs() < 60.0), "{slices:?}");
    }
}
