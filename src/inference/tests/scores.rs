//! The description length prefers what a person would.

use nalgebra::{Point3, Vector3};

use super::super::fit::{Effort, fit};
use super::super::sampler::Cancel;
use super::super::score::describe;
use super::{block, jitter, noise, samples, scene};
use crate::geometry::kernel::Distance;
use crate::geometry::neighbors::KdTree;
use crate::geometry::{Superquadric, tessellate};

fn fitted(points: &[Point3<f64>]) -> Superquadric {
    let floor = 0.05 * KdTree::new(points).mean_spacing(5);
    fit(points, &[], floor, Effort::THOROUGH, Distance::FirstOrder, &Cancel::default()).unwrap().shape
}

/// The length of a cloud as these parts, each with the primitive that fits it.
fn length(parts: &[Vec<Point3<f64>>]) -> f64 {
    let all: Vec<Point3<f64>> = parts.iter().flatten().copied().collect();
    let spacing = KdTree::new(&all).mean_spacing(5);
    parts.iter().map(|part| describe(&fitted(part), part, all.len(), spacing, 1.0).length).sum()
}

/// Cuts a cloud by a plane through its centroid.
fn halves(points: &[Point3<f64>], normal: [f64; 3]) -> [Vec<Point3<f64>>; 2] {
    let normal = Vector3::from(normal);
    let mean = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / points.len() as f64;
    let (a, b) = points.iter().partition(|p| (p.coords - mean).dot(&normal) < 0.0);
    [a, b]
}

const CUTS: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.7, -0.4]];

#[test]
fn one_primitive_is_shorter_than_its_halves() {
    let cylinder = Superquadric { exponents: [0.1, 1.0], ..block([0.0; 3], [0.5, 0.5, 1.5]) };
    let shapes = [
        ("box", block([0.0; 3], [1.0, 0.6, 0.4])),
        ("plate", block([0.0; 3], [1.0, 1.0, 0.05])),
        ("rod", block([0.0; 3], [0.1, 0.1, 2.0])),
        ("cylinder", cylinder),
        ("cone", Superquadric { taper: [0.8, 0.8], ..cylinder }),
        ("sphere", Superquadric::sphere(Point3::origin(), 1.0)),
    ];
    for (name, shape) in shapes {
        // (Noise as thick as the plate makes it something else.)
        for sigma in [0.0, 0.01, 0.02] {
            let mut points = samples(&shape, 600);
            jitter(&mut points, sigma, 3);
            let whole = length(std::slice::from_ref(&points));
            for normal in CUTS {
                let gain = whole - length(&halves(&points, normal));
                assert!(gain < 0.0, "{name} with σ = {sigma} cut along {normal:?} gains {gain}");
            }
        }
    }
}

#[test]
fn splitting_noise_does_not_pay() {
    for seed in 0..3 {
        let points = noise(400, seed);
        let whole = length(std::slice::from_ref(&points));
        for normal in CUTS {
            let gain = whole - length(&halves(&points, normal));
            assert!(gain < 0.0, "noise {seed} cut along {normal:?} gains {gain}");
        }
    }
}

#[test]
fn a_bridge_between_two_parts_is_longer_than_both() {
    let pairs = [
        ("boxes side by side", [block([-1.0, 0.0, 0.0], [0.5; 3]), block([1.0, 0.0, 0.0], [0.5; 3])]),
        ("two legs", [block([-1.0, 0.0, 0.0], [0.1, 0.1, 1.0]), block([1.0, 0.0, 0.0], [0.1, 0.1, 1.0])]),
        ("a T", [block([0.0, 0.0, 1.1], [1.0, 1.0, 0.1]), block([0.0, 0.0, 0.0], [0.1, 0.1, 1.0])]),
        (
            "plates one above the other",
            [block([0.0; 3], [1.0, 1.0, 0.05]), block([0.0, 0.0, 1.0], [1.0, 1.0, 0.05])],
        ),
    ];
    for (name, pair) in pairs {
        for sigma in [0.0, 0.01] {
            let (mut points, of) = scene(&pair, 700);
            jitter(&mut points, sigma, 4);
            let part = |j: u32| points.iter().zip(&of).filter(|p| *p.1 == j).map(|p| *p.0).collect();
            let gain = length(std::slice::from_ref(&points)) - length(&[part(0), part(1)]);
            assert!(gain > 0.0, "{name}, σ = {sigma}: the bridge is {} shorter", -gain);
        }
    }
}

#[test]
fn the_length_is_the_formula() {
    let shape = block([0.0; 3], [1.0, 0.6, 0.4]);
    let points: Vec<_> = samples(&shape, 300).into_iter().map(|p| p * 1.05).collect();
    let (total, spacing) = (1000, 0.01);
    let d = describe(&shape, &points, total, spacing, 1.0);
    let n = points.len() as f64;
    let rms = (points.iter().map(|p| shape.first_order_distance(p).powi(2)).sum::<f64>() / n).sqrt();
    assert!((d.rms / rms - 1.0).abs() < 1e-9);
    assert_eq!(d.sigma, d.rms, "the noise is above its floor");
    let density = |p: &Point3<f64>| {
        let z = shape.first_order_distance(p) / rms;
        -0.5 * z * z
            - (rms * (2.0 * std::f64::consts::PI).sqrt()).ln()
            - tessellate::surface_area(&shape).ln()
            + (n / total as f64).ln()
    };
    let expected = 6.5 * (total as f64).ln() - points.iter().map(density).sum::<f64>();
    assert!((d.length - expected).abs() < 1e-6 * expected.abs(), "{} {expected}", d.length);
    // The price of a primitive is its parameters', whatever its points cost.
    let dear = describe(&shape, &points, total, spacing, 3.0);
    assert!((dear.length - d.length - 13.0 * (total as f64).ln()).abs() < 1e-6);
}
