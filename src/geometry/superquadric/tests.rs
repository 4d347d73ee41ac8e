//! The formulas against closed forms, plain powers and central differences.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Rotation3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::geometry::tessellate;

/// Any primitive that a fit may meet: the exponents and tapers of its bounds,
/// aspect ratios up to 150.
fn any_shape() -> impl Strategy<Value = Superquadric> {
    let exponent = 0.1..=1.9;
    let taper = -0.95..=0.95;
    (
        [exponent.clone(), exponent],
        [-4.0..=1.0, -4.0..=1.0, -4.0..=1.0],
        [-3.0..=3.0, -3.0..=3.0, -3.0..=3.0],
        [-2.0..=2.0, -2.0..=2.0, -2.0..=2.0],
        [taper.clone(), taper],
    )
        .prop_map(|(exponents, logs, turn, t, taper)| Superquadric {
            exponents,
            semi_axes: Vector3::from(logs).map(f64::exp),
            rotation: Rotation3::new(Vector3::from(turn)),
            translation: Vector3::from(t),
            taper,
        })
}

/// A direction with every coordinate in 0.05..1, signs mixed.
fn any_direction() -> impl Strategy<Value = Vector3<f64>> {
    let c = || (0.05..1.0f64, any::<bool>()).prop_map(|(v, negative)| if negative { -v } else { v });
    (c(), c(), c()).prop_map(|(x, y, z)| Vector3::new(x, y, z))
}

/// H of a normalised point by the definition, in plain powers.
fn h_by_powers(n: &Vector3<f64>, [e1, e2]: [f64; 2]) -> f64 {
    // Taken out of the powers, which would leave the range of floating point.
    let largest = n.amax();
    let m = (n / largest).map(f64::abs);
    let section = (m.x.powf(2.0 / e2) + m.y.powf(2.0 / e2)).powf(e2 / e1);
    (section + m.z.powf(2.0 / e1)).powf(e1) * largest * largest
}

/// The normalised surface point in a direction.
fn surface(direction: &Vector3<f64>, exponents: [f64; 2]) -> Vector3<f64> {
    direction / h_by_powers(direction, exponents).sqrt()
}

/// A local point from a normalised one, with the taper as r knows it.
fn world(shape: &Superquadric, n: &Vector3<f64>) -> Point3<f64> {
    let q = n.component_mul(&shape.semi_axes);
    let [sx, sy] = shape.taper_factors(q.z);
    Point3::from(shape.rotation * Vector3::new(q.x * sx, q.y * sy, q.z) + shape.translation)
}

/// Five-point central difference: its error falls with the fourth power of h.
fn slope(h: f64, f: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 512,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn derivatives_are_those_of_central_differences(
        shape in any_shape(),
        direction in any_direction(),
        reach in 0.1..3.0f64,
    ) {
        let n = surface(&direction, shape.exponents) * reach;
        // The taper stops at the caps: a kink there.
        prop_assume!((n.z.abs() - 1.0).abs() > 0.02);
        let x = world(&shape, &n);
        let p = shape.local(&x);
        let q = shape.untapered(&p);
        let d = shape.derivatives(&x);
        prop_assert!((d.r - shape.radial_distance(&x)).abs() <= 1e-12 * (d.r.abs() + q.norm()));

        // In natural units of each parameter, over which r is smooth, its
        // derivatives are no larger than r and |q| (times the narrow end's 1/s).
        let [sx, sy] = shape.taper_factors(p.z);
        let narrow = sx.min(sy);
        let length = p.abs().min().min(narrow * shape.semi_axes.z);
        let angle = length / p.norm();
        let unit = |i: usize| match i {
            0 | 1 => shape.exponents[i].powi(2),
            2..=4 => shape.semi_axes[i - 2] * narrow * 0.1,
            5..=7 => angle * 0.1,
            8..=10 => length * 0.1,
            _ => narrow * 0.1,
        };
        let tolerance = 1e-6 * (d.r.abs() + q.norm());
        for i in 0..PARAMETERS {
            let found = slope(1e-3 * unit(i), |h| shape.nudged(i, h).radial_distance(&x));
            let error = (found - d.parameters[i]).abs() * unit(i);
            prop_assert!(error <= tolerance, "parameter {i}: {found} by differences, {:?}", d);
        }
        let gradient = shape.rotation * d.local_gradient;
        for i in 0..3 {
            let h = 1e-4 * length;
            let found = slope(h, |h| {
                let mut y = x;
                y[i] += h;
                shape.radial_distance(&y)
            });
            prop_assert!((found - gradient[i]).abs() * length * 0.1 <= tolerance, "∂r/∂x[{i}]");
        }
    }

    #[test]
    fn along_a_ray_r_is_what_is_left_to_the_surface(
        shape in any_shape(),
        direction in any_direction(),
        reach in 0.01..2.0f64,
    ) {
        let n = surface(&direction, shape.exponents);
        let on = shape.world_from_normalized(&n);
        let q = n.component_mul(&shape.semi_axes).norm();
        prop_assert!(shape.radial_distance(&on).abs() <= 1e-8 * q, "r = {} on the surface", shape.radial_distance(&on));

        let x = world(&shape, &(n * reach));
        let r = shape.radial_distance(&x);
        prop_assert!((r - q * (1.0 - reach)).abs() <= 1e-8 * q * reach.max(1.0));
        if (reach - 1.0).abs() > 1e-6 {
            prop_assert_eq!(r > 0.0, reach < 1.0);
            prop_assert_eq!(shape.contains(&x), reach < 1.0);
            prop_assert_eq!(shape.log_implicit(&x) < 0.0, reach < 1.0);
        }
    }

    #[test]
    fn the_centre_and_the_axes_are_finite(shape in any_shape(), reach in 0.0..3.0f64) {
        for axis in [Vector3::x(), Vector3::y(), Vector3::z(), Vector3::zeros()] {
            for sign in [-1.0, 1.0] {
                let x = world(&shape, &(axis * sign * reach));
                let d = shape.derivatives(&x);
                prop_assert!(d.r.is_finite() && d.parameters.iter().all(|v| v.is_finite()), "{d:?} at {x}");
                prop_assert!(d.local_gradient.iter().all(|v| v.is_finite()));
                prop_assert!(shape.first_order_distance(&x).is_finite());
                // On an axis the surface is one semi-axis away.
                let a = axis.component_mul(&shape.semi_axes).norm();
                // (Near the centre the floor under the logarithms takes over.)
                if reach > 0.02 && a > 0.0 {
                    prop_assert!((d.r - a * (1.0 - reach)).abs() <= 1e-3 * a, "{} for {}", d.r, a * (1.0 - reach));
                }
            }
        }
        // The deepest point is inside, by about the smallest semi-axis.
        let deep = shape.radial_distance(&Point3::from(shape.translation));
        prop_assert!(deep > 0.0 && deep <= shape.semi_axes.max() * 2.0, "{deep}");
    }

    #[test]
    fn r_scales_with_the_primitive(shape in any_shape(), direction in any_direction(), log in -20.0..20.0f64) {
        let (s, offset) = (log.exp(), Vector3::new(3.0, -1.0, 0.5) * log.exp());
        let x = world(&shape, &(direction * 1.3));
        let scaled = shape.scaled(s, &offset);
        let r = shape.radial_distance(&x);
        let there = scaled.radial_distance(&Point3::from(x.coords * s + offset));
        // Subtracting the centre again costs digits: their share of the thinnest axis.
        let lost = 1e-14 * 20.0 / shape.semi_axes.min();
        prop_assert!((there / s - r).abs() <= 100.0 * lost * (1.0 + r.abs()) / shape.exponents[0].min(shape.exponents[1]));
        prop_assert!((scaled.volume() / (shape.volume() * s.powi(3)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn moving_keeps_the_frame_orthonormal(shape in any_shape(), turn in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0]) {
        let mut s = shape;
        for _ in 0..300 {
            s = s.moved(&Vector3::from(turn), &Vector3::from(turn));
        }
        let m = s.rotation.matrix();
        prop_assert!((m.tr_mul(m) - Matrix3::identity()).norm() < 1e-14);
        prop_assert!((m.determinant() - 1.0).abs() < 1e-14);
        // One step is the right perturbation: a point moves with the body.
        let (w, t) = (Vector3::from(turn), Vector3::new(0.1, 0.2, 0.3));
        let local = Vector3::new(0.3, -0.2, 0.7);
        let moved = shape.moved(&w, &t);
        let expected = shape.rotation * (Rotation3::new(w) * local + t) + shape.translation;
        prop_assert!((moved.rotation * local + moved.translation - expected).norm() < 1e-12);
    }
}

fn shape(exponents: [f64; 2], a: [f64; 3], taper: [f64; 2]) -> Superquadric {
    Superquadric {
        exponents,
        semi_axes: a.into(),
        rotation: Rotation3::new(Vector3::new(0.4, -1.0, 0.3)),
        translation: Vector3::new(5.0, -2.0, 1.0),
        taper,
    }
}

#[test]
fn volumes_of_known_bodies() {
    let a = [0.7, 1.1, 2.3];
    let product = a[0] * a[1] * a[2];
    // ε → 0 sharpens the edges; what they still lack is of the order of ε².
    let e = 1e-3;
    let cases = [
        ("ellipsoid", shape([1.0, 1.0], a, [0.0, 0.0]), 4.0 / 3.0 * PI * product, 1e-12),
        ("box", shape([e, e], a, [0.0, 0.0]), 8.0 * product, 1e-4),
        ("elliptic cylinder", shape([e, 1.0], a, [0.0, 0.0]), 2.0 * PI * product, 1e-4),
        ("octahedron", shape([2.0, 2.0], a, [0.0, 0.0]), 8.0 / 6.0 * product, 1e-12),
        ("cone", shape([e, 1.0], a, [1.0, 1.0]), PI * 4.0 * a[0] * a[1] * 2.0 * a[2] / 3.0, 1e-4),
        ("pyramid", shape([e, e], a, [-1.0, -1.0]), 16.0 * a[0] * a[1] * 2.0 * a[2] / 3.0, 1e-4),
        // A wedge: one half-width grows from 0 to 2a, the other stays.
        ("wedge", shape([e, e], a, [1.0, 0.0]), 8.0 * product, 1e-4),
        // A frustum of radii 0.5 and 1.5: πh/3·(R² + Rr + r²).
        (
            "frustum",
            shape([e, 1.0], [1.0, 1.0, 1.0], [0.5, 0.5]),
            PI * 2.0 / 3.0 * (2.25 + 0.75 + 0.25),
            1e-4,
        ),
        // Opposite tapers: a section (1 + kw)(1 − kw), which is less than the plain box.
        ("twisted wedge", shape([e, e], a, [0.6, -0.6]), 8.0 * product * (1.0 - 0.36 / 3.0), 1e-4),
    ];
    for (name, shape, expected, tolerance) in cases {
        let found = shape.volume();
        assert!((found / expected - 1.0).abs() < tolerance, "{name}: {found}, not {expected}");
    }
}

#[test]
fn volume_is_that_of_what_it_contains_and_the_box_is_tight() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    const DRAWS: usize = 20_000;
    for exponents in [[0.1, 0.1], [0.3, 1.0], [1.0, 0.5], [1.2, 1.2], [1.6, 0.7], [1.9, 1.9]] {
        for taper in [[0.0, 0.0], [0.9, 0.9], [-0.95, 0.4], [0.7, -0.7]] {
            let s = shape(exponents, [0.7, 1.1, 2.3], taper);
            let half = s.half_extents();
            let inside = (0..DRAWS)
                .filter(|_| {
                    let p = half.map(|h| h * rng.random_range(-1.0..1.0));
                    s.contains(&Point3::from(s.rotation * p + s.translation))
                })
                .count();
            let share = s.volume() / (8.0 * half.product());
            // Five standard errors of a binomial share.
            let error = 5.0 * (share * (1.0 - share) / DRAWS as f64).sqrt();
            let found = inside as f64 / DRAWS as f64;
            assert!((found - share).abs() < error, "{exponents:?} {taper:?}: {found}, not {share}");

            let mut reach = Vector3::zeros();
            for (x, _) in tessellate::surface_samples(&s, 0.02, 40_000) {
                reach = reach.sup(&s.local(&x).abs());
            }
            for i in 0..3 {
                let part = reach[i] / half[i];
                // The widest height is searched in 32 steps, the surface in samples.
                assert!(part < 1.003 && part > 0.93, "{exponents:?} {taper:?}: axis {i} reaches {part}");
            }
        }
    }
}

#[test]
fn a_thin_plate_is_measured_across_not_along_the_ray() {
    let plate = Superquadric {
        exponents: [0.1, 0.1],
        semi_axes: Vector3::new(10.0, 10.0, 0.1),
        ..Superquadric::sphere(Point3::origin(), 1.0)
    };
    for x in [0.0, 2.0, 8.0] {
        let p = Point3::new(x, 0.3 * x, 0.104);
        // The error is of second order: 4 % at 4 % of the half thickness, and
        // a little of the rounded edges.
        assert!((plate.first_order_distance(&p) / 0.004 - 1.0).abs() < 0.06);
        if x > 0.0 {
            assert!(plate.radial_distance(&p).abs() > 0.03 * x, "the ray is nearly parallel to the plate");
        }
    }
    // On a sphere both are the distance itself.
    let sphere = Superquadric::sphere(Point3::new(1.0, 2.0, 3.0), 2.0);
    for angle in [0.0, 0.4, FRAC_PI_2] {
        let p = Point3::new(1.0 + 3.0 * f64::cos(angle), 2.0 + 3.0 * f64::sin(angle), 3.0);
        assert!((sphere.radial_distance(&p) + 1.0).abs() < 1e-9);
        assert!((sphere.first_order_distance(&p) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_primitive_with_a_parameter_that_means_nothing_is_not_valid() {
    let good = shape([0.5, 1.0], [1.0, 1.0, 1.0], [0.2, -1.0]);
    assert!(good.is_valid());
    let bad = [
        Superquadric { exponents: [0.0, 1.0], ..good },
        Superquadric { exponents: [f64::NAN, 1.0], ..good },
        Superquadric { semi_axes: Vector3::new(1.0, -1.0, 1.0), ..good },
        Superquadric { semi_axes: Vector3::new(1.0, f64::INFINITY, 1.0), ..good },
        Superquadric { translation: Vector3::new(f64::NAN, 0.0, 0.0), ..good },
        Superquadric { taper: [1.01, 0.0], ..good },
        Superquadric { taper: [0.0, f64::NAN], ..good },
    ];
    for s in bad {
        assert!(!s.is_valid(), "{s:?}");
    }
}
