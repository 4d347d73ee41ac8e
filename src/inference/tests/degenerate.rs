//! Clouds that are no shape.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

use super::{check, gate, noise, samples, short};
use crate::geometry::{SampleCloud, Superquadric};
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::params::Params;

#[test]
fn degenerate_clouds_give_an_error_or_finite_results() {
    let line =
        |n: u32| (0..n).map(|i| Point3::new(f64::from(i), 2.0 * f64::from(i), 0.0)).collect::<Vec<_>>();
    let plane: Vec<_> = (0..400).map(|i| Point3::new(f64::from(i % 20), f64::from(i / 20), 7.0)).collect();
    let shape = gate(300);
    let scaled = |s: f64| shape.iter().map(|p| p * s).collect::<Vec<_>>();
    let mut two = shape.clone();
    two.extend(shape.iter().map(|p| p + Vector3::x() * 1e7));
    let mut outlier = shape.clone();
    outlier.push(Point3::new(1e6, 1e6, 1e6));
    let utm = shape.iter().map(|p| p + Vector3::new(500_000.0, 5_400_000.0, 300.0)).collect();
    let twins: Vec<_> = shape.iter().flat_map(|p| [*p; 8]).collect();
    let few_places: Vec<_> = (0..300).map(|i| Point3::new(f64::from(i % 3), f64::from(i % 2), 0.0)).collect();
    let places: Vec<_> = (0..300).map(|i| Point3::new(f64::from(i % 30), f64::from(i % 2), 0.0)).collect();
    let clouds: Vec<(&str, Vec<Point3<f64>>)> = vec![
        ("nothing", vec![]),
        ("one point", vec![Point3::origin()]),
        ("one point often", vec![Point3::new(1.0, 2.0, 3.0); 100]),
        ("20 points", noise(20, 1)),
        ("21 points", noise(21, 1)),
        ("25 points", samples(&Superquadric::sphere(Point3::origin(), 1.0), 25)),
        ("a short line", line(25)),
        ("a line", line(300)),
        ("a plane", plane),
        ("noise", noise(400, 2)),
        ("nanometres in metres", scaled(1e-9)),
        ("1e12", scaled(1e12)),
        ("1e-150", scaled(1e-150)),
        ("1e150", scaled(1e150)),
        ("two lumps far apart", two),
        ("one far outlier", outlier),
        ("UTM", utm),
        ("every point eight times", twins),
        ("six places", few_places),
        ("thirty places, ten times each", places),
    ];
    for (name, points) in clouds {
        for params in [Params { iterations: 6, ..short() }, Params { iterations: 6, ..Params::paper() }] {
            match Sampler::new(Arc::new(SampleCloud::from_points(&points)), params, &Cancel::default()) {
                Err(InferenceError::TooFewPoints { points: n }) => {
                    assert!(n <= 20, "{name}: {n} points are enough");
                }
                Err(error) => panic!("{name}: {error}"),
                Ok(mut sampler) => {
                    let small = sampler.abstraction();
                    check(&small, points.len());
                    while !sampler.is_finished() {
                        sampler.step(&Cancel::default()).unwrap();
                        check(&sampler.abstraction(), points.len());
                    }
                }
            }
        }
    }
}
