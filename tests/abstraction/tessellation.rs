//! The tessellated surface: closed, outward, of the right size, with the
//! right normals; sample points: on the surface, even, in proportion to area.

use std::collections::HashMap;
use std::f64::consts::PI;

use nalgebra::{Point3, Rotation3, Vector3};
use superform::geometry::Superquadric;
use superform::geometry::tessellate::{
    Resolution, Surface, parameter_lines, surface_area, surface_samples, surface_samples_into, tessellate,
};

fn shape(eps: [f64; 2], axes: [f64; 3], taper: [f64; 2]) -> Superquadric {
    Superquadric {
        exponents: eps,
        semi_axes: Vector3::from(axes),
        rotation: Rotation3::from_euler_angles(0.3, -0.8, 1.9),
        translation: Vector3::new(0.4, -1.1, 2.3),
        taper,
    }
}

/// A grid over the whole range of the parameters.
fn all_shapes() -> Vec<Superquadric> {
    let exponents = [0.05, 0.1, 0.5, 1.0, 1.5, 1.9, 2.0];
    let axes = [[1.0, 1.0, 1.0], [2.0, 0.5, 1.0], [1.0, 1e-4, 1.0], [1.0, 1.0, 1e-4], [1e-4, 1e-4, 1.0]];
    let tapers = [[0.0, 0.0], [0.5, -0.5], [-1.0, -1.0], [1.0, 0.0], [1.0, -1.0]];
    let mut shapes = Vec::new();
    for e1 in exponents {
        for e2 in exponents {
            for a in axes {
                shapes.extend(tapers.map(|k| shape([e1, e2], a, k)));
            }
        }
    }
    shapes
}

fn volume(surface: &Surface) -> f64 {
    let center = surface.vertices[0].coords;
    let at = |i: u32| surface.vertices[i as usize].coords - center;
    surface.faces.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c))) / 6.0).sum()
}

fn area(surface: &Surface) -> f64 {
    let at = |i: u32| surface.vertices[i as usize];
    surface.faces.iter().map(|&[a, b, c]| 0.5 * (at(b) - at(a)).cross(&(at(c) - at(a))).norm()).sum()
}

#[test]
fn each_edge_belongs_to_two_triangles_of_opposite_direction() {
    for resolution in
        [Resolution::default(), Resolution { profile: 2, section: 2 }, Resolution { profile: 5, section: 8 }]
    {
        let mut edges = HashMap::new();
        for [a, b, c] in resolution.faces() {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        for (&(a, b), &count) in &edges {
            assert_eq!(count, 1, "edge {a}–{b}");
            assert!(edges.contains_key(&(b, a)), "edge {a}–{b} is open");
        }
        let vertices = resolution.vertices() as i64;
        let faces = resolution.faces().len() as i64;
        // Euler's formula for one closed surface without holes: V − E + F = 2.
        assert_eq!(vertices - edges.len() as i64 / 2 + faces, 2);
        assert_eq!(
            tessellate(&shape([1.0, 1.0], [1.0; 3], [0.0; 2]), resolution).vertices.len() as i64,
            vertices
        );
    }
}

#[test]
fn volume_by_the_divergence_theorem_is_the_closed_form() {
    let fine = Resolution { profile: 32, section: 32 };
    for s in all_shapes() {
        let surface = tessellate(&s, fine);
        let (found, expected) = (volume(&surface), s.volume());
        assert!(
            (found - expected).abs() < 0.01 * expected,
            "{:?} {:?} {:?}: {found} instead of {expected}",
            s.exponents,
            s.semi_axes.as_slice(),
            s.taper
        );
    }
}

#[test]
fn vertices_lie_on_the_surface_and_are_finite() {
    for s in all_shapes() {
        let surface = tessellate(&s, Resolution::default());
        for (v, n) in surface.vertices.iter().zip(&surface.normals) {
            assert!(v.iter().all(|c| c.is_finite()), "{s:?}");
            assert!((n.norm() - 1.0).abs() < 1e-9, "{s:?}: normal {n:?}");
            // Near an apex and near the poles of an untapered box the radial
            // distance is ill-conditioned; a first-order distance is not.
            let p = s.local(v);
            let narrow = s.taper.iter().any(|k| k * p.z / s.semi_axes.z + 1.0 < 0.03);
            if !narrow {
                let r = s.radial_distance(v).abs();
                assert!(r < 1e-5 * s.semi_axes.max(), "{s:?}: r = {r} at {p:?}");
            }
        }
    }
}

#[test]
fn normals_are_those_of_the_implicit_function() {
    for s in all_shapes() {
        // Where F is smooth; on thin shapes the logarithm's floor shows.
        if s.exponents.iter().any(|&e| e > 1.5) || s.semi_axes.min() < 0.01 {
            continue;
        }
        for (v, n) in surface_pairs(&s) {
            let p = s.local(&v);
            let near_axis = p.component_div(&s.semi_axes).iter().any(|c| c.abs() < 1e-3);
            let narrow = s.taper.iter().any(|k| k * p.z / s.semi_axes.z + 1.0 < 0.05);
            // At the caps the reference clamps its taper and changes sides.
            let cap = p.z.abs() > s.semi_axes.z * (1.0 - 1e-9);
            if near_axis || narrow || cap {
                continue;
            }
            let reference = -(s.rotation * s.derivatives(&v).local_gradient).normalize();
            assert!(n.dot(&reference) > 1.0 - 1e-6, "{s:?} at {p:?}: {n:?} instead of {reference:?}");
        }
    }
}

fn surface_pairs(s: &Superquadric) -> Vec<(Point3<f64>, Vector3<f64>)> {
    let surface = tessellate(s, Resolution::default());
    surface.vertices.into_iter().zip(surface.normals).collect()
}

#[test]
fn triangles_face_the_way_their_normals_point() {
    for s in all_shapes() {
        // A sheet that is thinner than the taper's shear has no side to speak of.
        if s.semi_axes.z < 0.01 && s.taper[0] != s.taper[1] {
            continue;
        }
        let surface = tessellate(&s, Resolution::default());
        let whole = area(&surface);
        let (mut wrong, mut sum) = (0.0, 0.0);
        for f in &surface.faces {
            let [a, b, c] = f.map(|i| surface.vertices[i as usize]);
            let cross = 0.5 * (b - a).cross(&(c - a));
            let mean: Vector3<f64> = f.iter().map(|&i| surface.normals[i as usize]).sum();
            sum += cross.norm();
            if cross.dot(&mean) < 0.0 {
                wrong += cross.norm();
            }
        }
        assert!(wrong < 5e-3 * whole, "{s:?}: {wrong} of {sum}");
    }
}

#[test]
fn a_box_has_flat_faces_and_crisp_edges() {
    let s = Superquadric { rotation: Rotation3::identity(), ..shape([0.1, 0.1], [1.0, 0.7, 0.2], [0.0; 2]) };
    let surface = tessellate(&s, Resolution::default());
    // Where a triangle lies on a face, away from the edges, its normals are the face's.
    for f in &surface.faces {
        let corners = f.map(|i| s.local(&surface.vertices[i as usize]).component_div(&s.semi_axes));
        for axis in 0..3 {
            let others = [(axis + 1) % 3, (axis + 2) % 3];
            if corners.iter().all(|c| others.iter().all(|&o| c[o].abs() < 0.7)) {
                for &i in f {
                    let n = surface.normals[i as usize];
                    assert!(n[axis].abs() > 0.999, "normal {n:?} on face {axis}");
                }
            }
        }
    }
    // No triangle of some size bridges an edge: neighbouring normals differ little.
    let whole = area(&surface);
    for f in &surface.faces {
        let [a, b, c] = f.map(|i| surface.vertices[i as usize]);
        let share = 0.5 * (b - a).cross(&(c - a)).norm() / whole;
        let n = f.map(|i| surface.normals[i as usize]);
        let least = n[0].dot(&n[1]).min(n[1].dot(&n[2])).min(n[2].dot(&n[0]));
        assert!(least > 0.8 || share < 1e-3, "normals differ by {} over {share}", least.acos());
    }
}

/// Known areas: sphere, prolate and oblate spheroid, box and cylinder limits.
#[test]
fn areas_of_known_bodies() {
    let spheroid = |a: f64, c: f64| {
        if c > a {
            let e = (1.0 - a * a / (c * c)).sqrt();
            2.0 * PI * a * a * (1.0 + c / (a * e) * e.asin())
        } else {
            let e = (1.0 - c * c / (a * a)).sqrt();
            2.0 * PI * a * a + PI * c * c / e * ((1.0 + e) / (1.0 - e)).ln()
        }
    };
    let cases = [
        ("sphere", [1.0, 1.0], [1.5, 1.5, 1.5], 4.0 * PI * 2.25),
        ("prolate", [1.0, 1.0], [1.0, 1.0, 5.0], spheroid(1.0, 5.0)),
        ("oblate", [1.0, 1.0], [3.0, 3.0, 0.3], spheroid(3.0, 0.3)),
        ("box", [0.002, 0.002], [1.0, 2.0, 0.5], 8.0 * (2.0 + 1.0 + 0.5)),
        ("thin box", [0.002, 0.002], [1.0, 2.0, 0.001], 8.0 * (2.0 + 0.002 + 0.001)),
        ("cylinder", [0.002, 1.0], [1.0, 1.0, 3.0], 2.0 * PI + 2.0 * PI * 6.0),
        ("octahedron", [2.0, 2.0], [1.0, 1.0, 1.0], 4.0 * 3.0f64.sqrt()),
    ];
    for (name, eps, axes, expected) in cases {
        let found = surface_area(&shape(eps, axes, [0.0; 2]));
        assert!((found - expected).abs() < 0.01 * expected, "{name}: {found} instead of {expected}");
    }
    // A cone: a cylinder tapered to its apex, r = 2 at the base, height 2.
    let cone = surface_area(&shape([0.002, 1.0], [1.0, 1.0, 1.0], [-1.0, -1.0]));
    let expected = PI * 4.0 + PI * 2.0 * 8.0f64.sqrt();
    assert!((cone - expected).abs() < 0.01 * expected, "cone: {cone} instead of {expected}");
}

#[test]
fn the_fast_area_is_that_of_a_fine_mesh() {
    for s in all_shapes() {
        let expected = area(&tessellate(&s, Resolution { profile: 48, section: 48 }));
        let found = surface_area(&s);
        // Sheets that the taper folds by more than their thickness are the hardest.
        let tolerance = if s.semi_axes.min() < 0.01 { 0.02 } else { 0.01 };
        assert!((found - expected).abs() < tolerance * expected, "{s:?}: {found} instead of {expected}");
    }
}

#[test]
fn samples_are_bounded_finite_and_on_the_surface() {
    for s in all_shapes() {
        for (spacing, max) in [(0.1, 300), (1e-6, 200), (1e9, 50), (0.0, 20), (f64::NAN, 20), (0.05, 0)] {
            let samples = surface_samples(&s, spacing, max);
            assert!(samples.len() <= max);
            assert!(max == 0 || !samples.is_empty(), "{s:?} {spacing}");
            for (p, n) in &samples {
                assert!(
                    p.iter().all(|c| c.is_finite()) && (n.norm() - 1.0).abs() < 1e-9,
                    "{s:?}: {p:?} {n:?}"
                );
            }
        }
    }
    let s = shape([0.4, 1.3], [1.0, 0.6, 0.8], [0.3, -0.2]);
    for (p, _) in surface_samples(&s, 0.1, 1000) {
        assert!(s.first_order_distance(&p) < 0.01, "{}", s.first_order_distance(&p));
    }
    let broken = Superquadric { semi_axes: Vector3::new(1.0, f64::NAN, 1.0), ..s };
    assert!(surface_samples(&broken, 0.1, 100).is_empty());
    assert_eq!(surface_area(&broken), 0.0);
}

#[test]
fn samples_are_deterministic_and_as_many_as_the_area_asks_for() {
    let s = shape([0.3, 0.8], [1.0, 0.4, 0.7], [0.2, 0.0]);
    let samples = surface_samples(&s, 0.1, 100_000);
    let expected = surface_area(&s) / 0.01;
    assert!((samples.len() as f64 - expected).abs() <= 1.0);
    let mut again = vec![(Point3::origin(), Vector3::x())];
    surface_samples_into(&s, 0.1, 100_000, &mut again);
    assert_eq!(samples, again);
}

/// Counts in the six directions of a box against the areas of its faces.
#[test]
fn samples_are_in_proportion_to_area() {
    let axes = [1.0, 0.5, 0.25];
    let s = Superquadric { rotation: Rotation3::identity(), ..shape([0.02, 0.02], axes, [0.0; 2]) };
    let samples = surface_samples(&s, 0.03, 100_000);
    let whole = 8.0 * (0.5 + 0.25 + 0.125);
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let expected = 4.0 * axes[(axis + 1) % 3] * axes[(axis + 2) % 3] / whole;
            let on = |n: &Vector3<f64>| n[axis] * sign > 0.9;
            let found = samples.iter().filter(|(_, n)| on(n)).count() as f64 / samples.len() as f64;
            assert!((found - expected).abs() < 0.1 * expected, "face {axis} {sign}: {found}, {expected}");
        }
    }
}

/// Neither holes nor heaps: the nearest neighbour of each sample and the
/// nearest sample of each surface point are about a spacing away.
#[test]
fn samples_are_evenly_spaced() {
    let cases = [
        shape([1.0, 1.0], [1.0; 3], [0.0; 2]),
        shape([0.1, 0.1], [1.0, 0.6, 0.3], [0.0; 2]),
        shape([0.1, 1.0], [0.3, 0.3, 1.0], [0.0; 2]),
        shape([0.1, 0.1], [1.0, 0.05, 1.0], [0.0; 2]),
        shape([0.1, 1.0], [1.0, 1.0, 0.05], [0.0; 2]),
        shape([0.5, 0.5], [0.5, 0.5, 1.0], [-0.9, -0.9]),
    ];
    let spacing = 0.15;
    for s in cases {
        let samples = surface_samples(&s, spacing, 10_000);
        let nearest = |p: &Point3<f64>, but: usize| {
            let others = samples.iter().enumerate().filter(|&(i, _)| i != but);
            others.map(|(_, (q, _))| (q - p).norm()).fold(f64::INFINITY, f64::min)
        };
        let gaps: Vec<f64> = samples.iter().enumerate().map(|(i, (p, _))| nearest(p, i)).collect();
        // No heaps, not even at a pole: a ball of the spacing's radius around a
        // sample holds π others on average.
        let crowd = |p: &Point3<f64>| samples.iter().filter(|(q, _)| (q - p).norm() < spacing).count() - 1;
        let crowd = samples.iter().map(|(p, _)| crowd(p)).max().unwrap();
        assert!(s.semi_axes.min() < spacing || crowd <= 8, "{s:?}: {crowd} within a spacing");
        let mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
        assert!(mean > 0.55 * spacing && mean < 1.2 * spacing, "{s:?}: mean gap {mean}");
        let surface = tessellate(&s, Resolution::default());
        let worst = surface.vertices.iter().map(|v| nearest(v, usize::MAX)).fold(0.0, f64::max);
        assert!(worst < 1.35 * spacing, "{s:?}: hole of {worst}");
    }
}

#[test]
fn parameter_lines_follow_the_surface_and_the_edges() {
    let s = Superquadric { rotation: Rotation3::identity(), ..shape([0.1, 0.1], [1.0, 0.7, 0.4], [0.0; 2]) };
    let lines = parameter_lines(&s, Resolution { profile: 4, section: 4 });
    assert_eq!(lines.len(), 16 + 7);
    for (p, n) in lines.iter().flatten() {
        assert!(s.radial_distance(p).abs() < 1e-6 && (n.norm() - 1.0).abs() < 1e-9);
    }
    // A vertical edge of the box is a line: somewhere |x| and |y| are both nearly full.
    let on_edge = |p: &Point3<f64>| {
        let q = s.local(p).component_div(&s.semi_axes);
        q.x.abs() > 0.96 && q.y.abs() > 0.96 && q.z.abs() < 0.5
    };
    assert_eq!(lines[..16].iter().filter(|line| line.iter().any(|(p, _)| on_edge(p))).count(), 4);
}
