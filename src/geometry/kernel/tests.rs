use super::*;
use nalgebra::{Rotation3, SMatrix, SVector, Vector3};
use rand::{RngExt, SeedableRng};

fn shapes() -> Vec<Superquadric> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    (0..60)
        .map(|_| Superquadric {
            exponents: [rng.random_range(0.1..1.9), rng.random_range(0.1..1.9)],
            semi_axes: Vector3::from_fn(|_, _| rng.random_range(0.02..3.0)),
            rotation: Rotation3::from_euler_angles(rng.random(), rng.random(), rng.random()),
            translation: Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)),
            taper: [rng.random_range(-0.95..0.95), rng.random_range(-0.95..0.95)],
        })
        .collect()
}

fn points(n: usize) -> PointBlock {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(6);
    (0..n).map(|_| Point3::from(Vector3::from_fn(|_, _| rng.random_range(-4.0..4.0)))).collect()
}

#[test]
fn blocks_agree_with_the_reference() {
    let block = points(131);
    let mut out = Vec::new();
    for shape in shapes() {
        distances(&shape, &block, Distance::Radial, &mut out);
        for (p, r) in block.iter().zip(&out) {
            let expected = shape.radial_distance(&p);
            let off = (f64::from(*r) - expected).abs();
            assert!(off <= 2e-5 * (1.0 + expected.abs()), "{r} {expected}");
        }
        distances(&shape, &block, Distance::FirstOrder, &mut out);
        for (p, d) in block.iter().zip(&out) {
            let at = shape.derivatives(&p);
            let expected = at.r.abs() / at.local_gradient.norm().max(0.25);
            let off = (f64::from(d.abs()) - expected).abs();
            assert!(off <= 1e-4 * (1.0 + expected), "{d} {expected}");
        }
    }
}

#[test]
fn normal_equations_agree_with_the_sum_over_points() {
    // Not a multiple of the block or the lanes: the tail counts too.
    let block = points(203);
    for shape in shapes() {
        for distance in [Distance::Radial, Distance::FirstOrder] {
            let found = normal_equations(&shape, &block, distance);
            let mut jtj = SMatrix::<f64, PARAMETERS, PARAMETERS>::zeros();
            let mut jtr = SVector::<f64, PARAMETERS>::zeros();
            let mut low = Vector3::repeat(f64::INFINITY);
            for x in block.iter() {
                let d = shape.derivatives(&x);
                let w = match distance {
                    Distance::Radial => 1.0,
                    Distance::FirstOrder => 1.0 / d.local_gradient.norm().max(0.25),
                };
                let j = SVector::from(d.parameters) * w;
                jtj += j * j.transpose();
                jtr += j * d.r * w;
                low = low.inf(&shape.local(&x));
            }
            assert!((found.jtj - jtj).norm() <= 1e-4 * jtj.norm());
            assert!((found.jtr - jtr).norm() <= 1e-5 * (1.0 + jtr.norm()));
            assert!((found.low - low).norm() < 1e-5);
            assert!((found.cost - cost(&shape, &block, distance)).abs() <= 1e-5 * found.cost);
        }
    }
}

/// Whole weights are repeated points.
#[test]
fn a_weight_counts_as_so_many_points() {
    let once = points(150);
    let weights: Vec<f64> = (0..once.len()).map(|i| (i % 4) as f64).collect();
    let often: PointBlock =
        once.iter().enumerate().flat_map(|(i, p)| std::iter::repeat_n(p, i % 4)).collect();
    for shape in shapes() {
        for distance in [Distance::Radial, Distance::FirstOrder] {
            let weighted = weighted_normal_equations(&shape, &once, &weights, distance);
            let repeated = normal_equations(&shape, &often, distance);
            assert!((weighted.jtj - repeated.jtj).norm() <= 1e-5 * repeated.jtj.norm());
            assert!((weighted.jtr - repeated.jtr).norm() <= 1e-5 * (1.0 + repeated.jtr.norm()));
            let sum = weighted_cost(&shape, &once, &weights, distance);
            assert!((weighted.cost - sum).abs() <= 1e-5 * sum);
            assert!((repeated.cost - sum).abs() <= 1e-5 * sum);
        }
    }
}

/// Beyond the box of the body, the distance is the way to the box.
#[test]
fn far_points_pull_with_the_derivatives_of_the_way_to_the_box() {
    let shape = Superquadric {
        exponents: [0.6, 1.3],
        semi_axes: Vector3::new(0.7, 1.1, 0.9),
        rotation: Rotation3::from_euler_angles(0.4, -0.7, 1.1),
        translation: Vector3::new(0.3, -0.2, 0.5),
        taper: [0.4, -0.3],
    };
    let way = |s: &Superquadric, x: &Point3<f64>| (s.local(x).abs() - s.reach()).map(|v| v.max(0.0)).norm();
    let rounding = 0.02;
    let mut boxed = 0;
    for x in points(300).iter() {
        let beyond = way(&shape, &x);
        let d = shape.derivatives(&x);
        // (With room for the precision of either.)
        if beyond < 1.01 * d.r.abs() / d.local_gradient.norm().max(0.25) {
            continue;
        }
        boxed += 1;
        let found = pseudo_huber_normal_equations(&shape, &std::iter::once(x).collect(), rounding);
        let size = beyond.hypot(rounding);
        assert!((found.cost - (size - rounding)).abs() < 1e-5 * (1.0 + size));
        for k in 0..PARAMETERS {
            let h = 1e-5;
            let slope = (way(&shape.nudged(k, h), &x) - way(&shape.nudged(k, -h), &x)) / (2.0 * h);
            let expected = beyond / size * slope;
            assert!((found.jtr[k] - expected).abs() < 1e-4 * (1.0 + expected.abs()), "{k} {expected}");
            assert!((found.jtj[(k, k)] - slope * slope / size).abs() < 1e-4 * (1.0 + slope * slope / size));
        }
    }
    assert!(boxed > 5, "{boxed} points lie where the box is farther");
}

#[test]
fn pseudo_huber_costs_are_those_of_the_reference() {
    let block = points(203);
    let delta = 0.02;
    for shape in shapes() {
        let expected: f64 = block.iter().map(|x| shape.first_order_distance(&x).hypot(delta) - delta).sum();
        let found = pseudo_huber_cost(&shape, &block, delta);
        assert!((found - expected).abs() <= 1e-4 * expected, "{found} {expected}");
        let equations = pseudo_huber_normal_equations(&shape, &block, delta);
        assert!((equations.cost - found).abs() <= 1e-5 * found);
    }
}
