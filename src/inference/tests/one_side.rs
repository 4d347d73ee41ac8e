//! Shapes that were seen from one side: what nobody saw is not empty.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use rand::RngExt;

use super::{block, rng, run, samples, scene};
use crate::geometry::{SampleCloud, Superquadric, tessellate};
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::Abstraction;
use crate::inference::data::known_space::{KnownSpace, Sighting, Viewpoint};
use crate::inference::params::{Params, SeenFrom};
use crate::inference::runs::run::Run;

fn upper_half(shape: &Superquadric, n: usize) -> Vec<Point3<f64>> {
    samples(shape, n).into_iter().filter(|p| p.z > shape.translation.z).collect()
}

/// Points strewn over a plane outline.
fn sheet(n: usize, inside: impl Fn(f64, f64) -> bool) -> Vec<Point3<f64>> {
    let mut rng = rng(5);
    let mut points = Vec::new();
    while points.len() < n {
        let (x, y) = (rng.random::<f64>(), rng.random::<f64>());
        if inside(x, y) {
            points.push(Point3::new(3.0 * x, 2.0 * y, 0.0));
        }
    }
    points
}

fn seen_from(points: &[Point3<f64>], viewpoint: [f64; 3]) -> Abstraction {
    let cloud = SampleCloud { viewpoints: vec![viewpoint.into()], ..SampleCloud::from_points(points) };
    let mut run = Run::new(Arc::new(cloud), Params::default(), &Cancel::default()).unwrap();
    while !run.is_finished() {
        run.step(&Cancel::default()).unwrap();
    }
    run.abstraction()
}

#[test]
fn half_a_ball_is_a_ball() {
    let ball = Superquadric::sphere(Point3::origin(), 1.0);
    let points = upper_half(&ball, 4000);
    for seed in 1..=3 {
        let a = run(&points, Params { seed, ..Params::default() });
        let Sighting::FoundDirection { towards } = a.sighting else { panic!("{:?}", a.sighting) };
        assert!(towards[2] > 0.99, "{towards:?}");
        assert_eq!(a.primitives.len(), 1, "seed {seed}");
        let found = a.primitives[0].shape;
        assert!(found.translation.norm() < 0.02, "seed {seed}: the centre is {}", found.translation);
        assert!(found.semi_axes.iter().all(|a| (a - 1.0).abs() < 0.02), "seed {seed}: {}", found.semi_axes);
        // From all sides it is what it was: a bowl.
        let bowl = run(&points, Params { seed, seen_from: SeenFrom::All, ..Params::default() });
        assert_eq!(bowl.sighting, Sighting::AllSides);
        assert!(bowl.primitives.len() > 3);
    }
}

#[test]
fn three_faces_of_a_box_are_the_box() {
    let whole = block([0.0; 3], [1.0, 0.5, 0.25]);
    let normals = tessellate::surface_samples(&whole, 0.03, 20000);
    let faces: Vec<Point3<f64>> =
        normals.into_iter().filter(|(_, n)| n.max() > 0.9).map(|(p, _)| p).collect();
    let a = run(&faces, Params::default());
    assert!(matches!(a.sighting, Sighting::FoundDirection { .. }), "{:?}", a.sighting);
    assert_eq!(a.primitives.len(), 1);
    let mut edges: Vec<f64> = a.primitives[0].shape.semi_axes.iter().copied().collect();
    edges.sort_by(f64::total_cmp);
    for (found, truth) in edges.into_iter().zip([0.25, 0.5, 1.0]) {
        assert!((found / truth - 1.0).abs() < 0.06, "{found} for {truth}");
    }
}

#[test]
fn a_sheet_is_one_thin_plate() {
    type Outline = fn(f64, f64) -> bool;
    let outlines: [(&str, Outline); 2] = [("rectangle", |_, _| true), ("triangle", |x, y| x + y < 1.0)];
    for (name, inside) in outlines {
        let points = sheet(3000, inside);
        let a = run(&points, Params::default());
        assert!(a.primitives.len() <= 2, "{name}: {} plates", a.primitives.len());
        for primitive in a.primitives.iter() {
            let shape = primitive.shape;
            assert!(shape.semi_axes.min() < 0.01, "{name}: {} thick", shape.semi_axes.min());
            let thin = shape.semi_axes.imin();
            if name == "rectangle" {
                assert!(thin == 2 || shape.taper[thin] == 0.0, "{name}: {:?}", shape.taper);
            }
        }
    }
}

#[test]
fn whole_bodies_are_seen_from_all_sides() {
    let parts = [block([0.0; 3], [1.0, 0.6, 0.1]), block([0.0, 0.0, 0.7], [0.1, 0.1, 0.7])];
    for points in [scene(&parts, 1500).0, samples(&Superquadric::sphere(Point3::origin(), 1.0), 1500)] {
        let a = run(&points, Params::default());
        assert_eq!(a.sighting, Sighting::AllSides);
        let told = run(&points, Params { seen_from: SeenFrom::All, ..Params::default() });
        assert_eq!(a, told, "what is whole is fitted as ever");
    }
}

#[test]
fn space_is_free_up_to_the_points_and_unknown_behind_them() {
    let cell = |k: usize| 0.03 * k as f64;
    let mut wall: Vec<Point3<f64>> =
        (0..100 * 67).map(|k| Point3::new(cell(k % 100), cell(k / 100), 0.0)).collect();
    // What stands out makes the box of the cloud deep.
    wall.push(Point3::new(0.0, 0.0, 1.0));
    let eye = Point3::new(1.5, 1.0, 4.0);
    let spacing = 0.03;
    let known = KnownSpace::new(&[Viewpoint::Place(eye)], false, &wall, spacing);
    let mut rng = rng(7);
    for _ in 0..500 {
        let on = Point3::new(rng.random_range(0.2..2.8), rng.random_range(0.2..1.8), 0.0);
        let share = rng.random_range(0.05..0.9);
        assert!(known.is_free(&(eye + (on - eye) * share)), "{share} of the way to {on}");
        let behind = on + (on - eye).normalize() * rng.random_range(0.1..2.0);
        assert!(!known.is_free(&behind), "{behind} is behind {on}");
    }
    // Beside the wall nothing ends the line of sight.
    assert!(known.is_free(&Point3::new(-1.0, -1.0, 0.0)));
    // A body in front of the wall holds free space, one behind it none.
    let cost = |z: f64| known.intrusion(&block([1.5, 1.0, z], [0.5, 0.5, 0.2]), |depth| depth);
    assert!(cost(0.5) > 0.0);
    assert_eq!(cost(-0.5), 0.0);
}

#[test]
fn a_room_seen_from_within_is_its_walls() {
    let room = block([0.0; 3], [3.0, 2.5, 1.3]);
    let mut points = samples(&room, 4000);
    let cupboard = block([2.4, 0.0, -0.8], [0.6, 0.6, 0.5]);
    points.retain(|p| !cupboard.contains(p));
    points.extend(samples(&cupboard, 500).into_iter().filter(|p| p.x < 2.9 && p.z > -1.25));
    let eye = [0.0, 0.2, 0.0];
    let a = seen_from(&points, eye);
    assert_eq!(a.sighting, Sighting::Given { viewpoints: 1 });
    assert!(a.primitives.len() >= 6, "{} primitives", a.primitives.len());
    for primitive in a.primitives.iter() {
        assert!(!primitive.shape.contains(&eye.into()), "{:?} holds the viewer", primitive.shape);
        let middle = Point3::from(Vector3::new(1.0, -0.8, 0.3));
        assert!(!primitive.shape.contains(&middle), "{:?} fills the room", primitive.shape);
    }
}

#[test]
fn more_primitives_come_of_a_larger_alpha() {
    // A ring, of which no number of primitives is the true one.
    let mut rng = rng(11);
    let mut points = Vec::new();
    while points.len() < 2500 {
        let [u, v] = [0, 1].map(|_| rng.random_range(0.0..std::f64::consts::TAU));
        let radius = 1.0 + 0.25 * f64::cos(v);
        // The outer side has more area.
        if rng.random_range(0.0..1.25) < radius {
            points.push(Point3::new(radius * u.cos(), radius * u.sin(), 0.25 * v.sin()));
        }
    }
    let count = |alpha: f64| {
        let mut counts: Vec<usize> = (1..=3)
            .map(|seed| run(&points, Params { alpha, seed, ..Params::default() }).primitives.len())
            .collect();
        counts.sort_unstable();
        counts[1]
    };
    let [few, usual, many] = [0.01, 0.5, 10.0].map(count);
    assert!(few <= usual && usual < many, "{few}, {usual}, {many}");
    assert!(many >= 2 * few, "{few}, {usual}, {many}");
}
