//! The energy prefers what a person would.

use nalgebra::{Point3, Vector3};

use super::{block, jitter, samples, scene};
use crate::geometry::Superquadric;
use crate::geometry::kernel::Distance;
use crate::inference::control::Cancel;
use crate::inference::data::model::Model;
use crate::inference::data::normalization::Normalization;
use crate::inference::fit::points::{Effort, fit};
use crate::inference::objective::energy;
use crate::inference::objective::energy::PrimitiveTerms;
use crate::inference::objective::energy_cache::EnergyCache;
use crate::inference::params::Params;

/// The energy of a cloud as these parts, each with the primitive that fits it.
fn energy(parts: &[Vec<Point3<f64>>]) -> f64 {
    let all: Vec<Point3<f64>> = parts.iter().flatten().copied().collect();
    let model = Model::new(Normalization::of(&all).unwrap(), &all, &[]);
    let fitted = |part: &Vec<Point3<f64>>| {
        let points: Vec<_> = part.iter().map(|p| model.normalization.normalize(p)).collect();
        let found =
            fit(&points, &[], model.limits(), Effort::THOROUGH, Distance::FirstOrder, &Cancel::default());
        PrimitiveTerms::new(&model, found.unwrap().shape)
    };
    let primitives: Vec<PrimitiveTerms> = parts.iter().map(fitted).collect();
    let price = energy::price(&model, &Params::default(), primitives.len());
    EnergyCache::new(&model, primitives).error() + price
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
fn one_primitive_is_cheaper_than_its_halves() {
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
            let whole = energy(std::slice::from_ref(&points));
            for normal in CUTS {
                let gain = whole - energy(&halves(&points, normal));
                assert!(gain < 0.0, "{name} with σ = {sigma} cut along {normal:?} gains {gain}");
            }
        }
    }
}

#[test]
fn a_bridge_between_two_parts_is_dearer_than_both() {
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
            let gain = energy(std::slice::from_ref(&points)) - energy(&[part(0), part(1)]);
            assert!(gain > 0.0, "{name}, σ = {sigma}: the bridge is {} cheaper", -gain);
        }
    }
}

#[test]
fn the_error_is_both_sides_of_the_chamfer_distance() {
    // A sphere whose points all lie 5 % farther out.
    let sphere = Superquadric::sphere(Point3::origin(), 1.0);
    let points: Vec<_> = samples(&sphere, 2000).into_iter().map(|p| p * 1.05).collect();
    let model = Model::new(Normalization::of(&points).unwrap(), &points, &[]);
    let unit = 1.0 / model.normalization.length(1.0);
    let primitive = |radius: f64| {
        let center = model.normalization.normalize(&Point3::origin());
        PrimitiveTerms::new(&model, Superquadric::sphere(center, radius * unit))
    };
    // In mean spacings an error of 0.05, less the rounding of at most 0.12 of
    // one; the tangent planes' own error is small.
    let one_side = 0.05 * unit / model.spacing;
    let error = |primitives: &[&PrimitiveTerms]| {
        EnergyCache::new(&model, primitives.iter().copied().cloned().collect()).error()
    };
    let mean = error(&[&primitive(1.0)]) / energy::scale(&model);
    assert!((mean - one_side).abs() < 0.15 + 0.05 * one_side, "{mean} {one_side}");
    // The true one costs hardly anything.
    assert!(error(&[&primitive(1.05)]) / energy::scale(&model) < 0.05);
    // What another primitive hides adds nothing, what sticks out does.
    let (outer, inner) = (primitive(1.05), primitive(0.5));
    let alone = error(&[&outer]);
    assert!((error(&[&outer, &inner]) - alone).abs() < 1e-9);
    let mut beside = inner.shape;
    beside.translation += Vector3::new(2.0 * unit, 0.0, 0.0);
    assert!(error(&[&outer, &PrimitiveTerms::new(&model, beside)]) > 2.0 * alone);
}

#[test]
fn the_price_of_a_primitive_is_its_cost_times_the_default() {
    let points = samples(&block([0.0; 3], [1.0, 0.6, 0.4]), 300);
    let model = Model::new(Normalization::of(&points).unwrap(), &points, &[]);
    let price =
        |count, primitive_cost| energy::price(&model, &Params { primitive_cost, ..Params::default() }, count);
    let one = price(1, 1.0);
    assert!((price(1, 3.0) / one - 3.0).abs() < 1e-12);
    // Each next one costs, and costs less than the one before.
    let next: Vec<f64> = (0..50).map(|k| price(k + 1, 1.0) - price(k, 1.0)).collect();
    assert!(next.iter().all(|p| *p > 0.0) && next.is_sorted_by(|a, b| a > b));
    assert_eq!(price(0, 1.0), 0.0);
    assert!(one > 0.0 && one < 0.1 * energy::scale(&model));
}

/// A few primitives that overlap, and a cloud near them.
fn heap() -> (Model, Vec<PrimitiveTerms>) {
    let shapes: Vec<Superquadric> = (0..7)
        .map(|k| {
            let t = f64::from(k);
            block([t.sin(), (1.7 * t).cos(), 0.3 * t], [0.8 - 0.05 * t, 0.5, 0.4 + 0.05 * t])
        })
        .collect();
    let mut points = scene(&shapes, 900).0;
    jitter(&mut points, 0.02, 5);
    // A lonely one.
    points.push(Point3::new(4.0, 4.0, 4.0));
    let model = Model::new(Normalization::of(&points).unwrap(), &points, &[]);
    let unit = 1.0 / model.normalization.length(1.0);
    let primitive = |s: &Superquadric| {
        let center = model.normalization.normalize(&Point3::from(s.translation));
        let semi_axes = s.semi_axes * unit;
        PrimitiveTerms::new(&model, Superquadric { semi_axes, translation: center.coords, ..*s })
    };
    let primitives = shapes.iter().map(primitive).collect();
    (model, primitives)
}

#[test]
fn the_error_with_some_replaced_is_that_of_the_new_whole() {
    let (model, primitives) = heap();
    let (mut first, rest) = (primitives[..5].to_vec(), primitives[5..].to_vec());
    // One that all others hide, and more of them than are remembered.
    let mut small = first[2].shape;
    small.semi_axes *= 0.05;
    first.push(PrimitiveTerms::new(&model, small));
    for k in 0..5 {
        let grown = Superquadric { semi_axes: small.semi_axes * (4.0 + f64::from(k)), ..small };
        first.insert(0, PrimitiveTerms::new(&model, grown));
    }
    let cache = EnergyCache::new(&model, first.clone());
    for removed in [vec![], vec![0], vec![2, 4], vec![0, 1, 2, 3], vec![0, 1, 2, 3, 4, 7]] {
        for added in [&rest[..0], &rest[..1], &rest[1..], &rest[..]] {
            let kept = first.iter().enumerate().filter(|(j, _)| !removed.contains(j)).map(|(_, p)| p);
            let whole = EnergyCache::new(&model, kept.chain(added).cloned().collect()).error();
            let quick = cache.error_with(&model, &removed, added);
            assert!((quick - whole).abs() < 1e-9 * whole, "{removed:?}: {quick} {whole}");
        }
    }
}
