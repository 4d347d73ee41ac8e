use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geometry::{SampledPart, SamplingOptions, Surface, sample_mesh};

/// The surface of revolution of a line of (radius, height) about z.
fn revolved(line: &[(f64, f64)]) -> TriMesh {
    const AROUND: u32 = 96;
    let mut mesh = TriMesh::default();
    for &(radius, height) in line {
        mesh.vertices.extend((0..AROUND).map(|i| {
            let (sin, cos) = (2.0 * PI * f64::from(i) / f64::from(AROUND)).sin_cos();
            Point3::new(radius * cos, radius * sin, height)
        }));
    }
    for ring in 0..line.len() as u32 - 1 {
        for i in 0..AROUND {
            let (a, b) = (ring * AROUND + i, ring * AROUND + (i + 1) % AROUND);
            mesh.faces.extend([[a, b, b + AROUND], [a, b + AROUND, a + AROUND]]);
        }
    }
    mesh
}

/// The part of a sphere between two angles from the equator.
fn sphere(radius: f64, from: f64, to: f64) -> TriMesh {
    let steps = (96.0 * (to - from) / PI).round() as usize;
    let angle = |i: usize| from + (to - from) * i as f64 / steps as f64;
    let line: Vec<_> = (0..=steps).map(|i| (radius * angle(i).cos(), radius * angle(i).sin())).collect();
    revolved(&line)
}

fn ball(radius: f64) -> TriMesh {
    sphere(radius, -PI / 2.0, PI / 2.0)
}

fn cuboid(half: [f64; 3]) -> TriMesh {
    let vertices = (0..8)
        .map(|i| {
            let side = |k: usize| if i >> k & 1 == 1 { half[k] } else { -half[k] };
            Point3::new(side(0), side(1), side(2))
        })
        .collect();
    let quads = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    TriMesh { vertices, faces }
}

fn together(parts: &[TriMesh]) -> TriMesh {
    let mut whole = TriMesh::default();
    for part in parts {
        let first = whole.vertices.len() as u32;
        whole.vertices.extend(&part.vertices);
        whole.faces.extend(part.faces.iter().map(|f| f.map(|i| i + first)));
    }
    whole
}

/// A bottle with walls 0.1 thick: body of radius 1, neck of radius `mouth`.
fn bottle(mouth: f64) -> TriMesh {
    let wall = 0.1;
    let outer = [(0.0, 0.0), (1.0, 0.0), (1.0, 3.0), (mouth + wall, 3.8), (mouth + wall, 4.6)];
    let inner = [(mouth, 4.6), (mouth, 3.8), (1.0 - wall, 3.0), (1.0 - wall, wall), (0.0, wall)];
    revolved(&[outer, inner].concat())
}

fn at_random(rng: &mut ChaCha8Rng, half: f64) -> Point3<f64> {
    Point3::from(Vector3::from_fn(|_, _| rng.random_range(-half..half)))
}

/// Volume that the mesh encloses, of points drawn from a cube.
fn volume(mesh: &TriMesh, half: f64) -> f64 {
    let filled = FilledOutside::new(mesh);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let count = 60_000;
    let inside = (0..count).filter(|_| filled.contains(&at_random(&mut rng, half))).count();
    (2.0 * half).powi(3) * inside as f64 / f64::from(count)
}

/// Samples of what is seen, and the share of the area that was left out.
fn seen(mesh: &TriMesh) -> (Vec<Point3<f64>>, f64) {
    let options = SamplingOptions { points: 2000, ..SamplingOptions::default() };
    let cloud = sample_mesh(mesh, &options).unwrap();
    assert_eq!(cloud.points.len(), 2000);
    assert!(matches!(cloud.part, SampledPart::Outside { .. }));
    (cloud.points, cloud.part.left_out())
}

/// The same faces, about half of them turned over.
fn turned_at_random(mut mesh: TriMesh) -> TriMesh {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for face in &mut mesh.faces {
        if rng.random() {
            face.swap(1, 2);
        }
    }
    mesh
}

#[test]
fn a_ball_is_seen_whole_and_is_solid() {
    let ball = ball(1.0);
    assert_eq!(seen(&ball).1, 0.0);
    let expected = 4.0 / 3.0 * PI;
    let found = volume(&ball, 1.1);
    assert!((found / expected - 1.0).abs() < 0.012, "{found} instead of {expected}");
}

/// Sharper than the volume: right next to the surface, on both sides.
#[test]
fn the_triangles_decide_next_to_the_surface() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for mesh in [ball(1.0), together(&[ball(1.0), ball(0.9)])] {
        let filled = FilledOutside::new(&mesh);
        for _ in 0..3000 {
            let direction = at_random(&mut rng, 1.0).coords.normalize();
            // Flat faces lie up to 0.0006 below the sphere.
            assert!(!filled.contains(&Point3::from(direction * 1.0001)));
            assert!(filled.contains(&Point3::from(direction * 0.999)));
            assert!(filled.contains(&Point3::from(direction * rng.random_range(0.0..0.999))));
        }
    }
}

#[test]
fn an_inner_wall_is_not_seen_and_the_hollow_is_filled() {
    let double = turned_at_random(together(&[ball(1.0), ball(0.8)]));
    let (samples, left_out) = seen(&double);
    assert!(samples.iter().all(|p| p.coords.norm() > 0.99));
    assert!((left_out - 0.64 / 1.64).abs() < 0.01, "{left_out}");
    let expected = 4.0 / 3.0 * PI;
    assert!((volume(&double, 1.1) / expected - 1.0).abs() < 0.012);
}

#[test]
fn an_open_bowl_is_seen_from_both_sides_and_encloses_nothing() {
    let thin = sphere(1.0, -PI / 2.0, 0.0);
    assert!(seen(&thin).1 < 0.005);
    assert_eq!(volume(&thin, 1.1), 0.0);
    // With a thickness, that alone is enclosed.
    let thick = together(&[
        sphere(1.0, -PI / 2.0, 0.0),
        sphere(0.8, -PI / 2.0, 0.0),
        revolved(&[(0.8, 0.0), (1.0, 0.0)]),
    ]);
    assert!(seen(&thick).1 < 0.005);
    let expected = 2.0 / 3.0 * PI * (1.0 - 0.512);
    let found = volume(&thick, 1.1);
    assert!((found / expected - 1.0).abs() < 0.03, "{found} instead of {expected}");
}

#[test]
fn a_box_in_a_closed_box_is_not_seen() {
    let nested = together(&[cuboid([1.0, 0.7, 0.5]), cuboid([0.4, 0.3, 0.2])]);
    let (samples, left_out) = seen(&nested);
    assert!(samples.iter().all(|p| p.x.abs() > 0.99 || p.y.abs() > 0.69 || p.z.abs() > 0.49));
    let area = |[a, b, c]: [f64; 3]| a * b + b * c + c * a;
    let (outer, inner) = (area([1.0, 0.7, 0.5]), area([0.4, 0.3, 0.2]));
    assert!((left_out - inner / (inner + outer)).abs() < 0.01, "{left_out}");
    assert!((volume(&nested, 1.1) / 2.8 - 1.0).abs() < 0.02);
}

#[test]
fn a_narrow_mouth_closes_a_bottle_and_a_wide_one_does_not() {
    let narrow = turned_at_random(bottle(0.25));
    let (samples, left_out) = seen(&narrow);
    assert!((0.35..0.5).contains(&left_out), "{left_out} of the area left out");
    // Of the inner wall only what lies next to the mouth.
    let is_inner = |p: &Point3<f64>| {
        let radius = p.x.hypot(p.y);
        (radius < 0.95 && (0.05..3.0).contains(&p.z)) || (radius < 0.3 && (3.8..4.2).contains(&p.z))
    };
    assert_eq!(samples.iter().filter(|p| is_inner(p)).count(), 0);
    let filled = FilledOutside::new(&narrow);
    for (radius, height, expected) in [
        (0.0, 2.0, true),
        (0.8, 0.2, true),
        (0.95, 1.0, true),
        (0.0, 3.9, true),
        (0.0, 4.65, false),
        (1.05, 1.0, false),
    ] {
        assert_eq!(filled.contains(&Point3::new(radius, 0.0, height)), expected, "at {radius}, {height}");
    }

    let wide = bottle(0.85);
    assert!(seen(&wide).1 < 0.05, "{} of an open tin left out", seen(&wide).1);
    let filled = FilledOutside::new(&wide);
    assert!(!filled.contains(&Point3::new(0.0, 0.0, 2.0)) && !filled.contains(&Point3::new(0.85, 0.0, 0.2)));
    assert!(filled.contains(&Point3::new(0.95, 0.0, 2.0)));
}

/// The room under a table, between bars, and in a corner is outside.
#[test]
fn nothing_is_filled_that_is_merely_narrow() {
    let bars: Vec<TriMesh> = (0..12)
        .flat_map(|i| {
            let mut bar = cuboid([0.02, 0.02, 1.0]);
            let angle = f64::from(i) * PI / 6.0;
            bar.vertices.iter_mut().for_each(|p| *p += Vector3::new(angle.cos(), angle.sin(), 0.0));
            [bar]
        })
        .chain([-1.0, 1.0].map(|z| {
            let mut lid = cuboid([1.1, 1.1, 0.02]);
            lid.vertices.iter_mut().for_each(|p| p.z += z);
            lid
        }))
        .collect();
    let cage = together(&bars);
    let filled = FilledOutside::new(&cage);
    assert!(!filled.contains(&Point3::origin()) && !filled.contains(&Point3::new(0.9, 0.0, 0.0)));
    assert!(seen(&cage).1 < 0.05);
}

#[test]
fn scale_place_and_orientation_make_no_difference() {
    let mesh = together(&[bottle(0.25), ball(0.3)]);
    let left_out = seen(&mesh).1;
    let probes: Vec<Point3<f64>> = {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        (0..2000).map(|_| at_random(&mut rng, 1.2) + Vector3::z() * 2.0).collect()
    };
    let filled = FilledOutside::new(&mesh);
    let expected: Vec<bool> = probes.iter().map(|p| filled.contains(p)).collect();
    for (scale, offset) in [(1e-9, 0.0), (1e12, 0.0), (1.0, 1e5), (1e150, 0.0), (1e-150, 0.0)] {
        let moved = |p: &Point3<f64>| Point3::from(p.coords * scale + Vector3::repeat(offset));
        let other = turned_at_random(TriMesh {
            vertices: mesh.vertices.iter().map(moved).collect(),
            faces: mesh.faces.clone(),
        });
        assert!((seen(&other).1 - left_out).abs() < 0.01);
        let filled = FilledOutside::new(&other);
        let differing =
            probes.iter().zip(&expected).filter(|(p, e)| filled.contains(&moved(p)) != **e).count();
        assert!(differing <= 2, "{differing} of 2000 differ at scale {scale} and offset {offset}");
    }
}

#[test]
fn the_number_of_threads_makes_no_difference() {
    let mesh = together(&[bottle(0.25), ball(0.3)]);
    let here = seen(&mesh).0;
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| seen(&mesh).0), here);
    }
}

/// What is left stays as even as all of it.
#[test]
fn samples_of_what_is_seen_are_even() {
    let options = |surface| SamplingOptions { points: 2000, surface, ..SamplingOptions::default() };
    let double = together(&[ball(1.0), ball(0.9), ball(0.8), ball(0.7)]);
    let gaps = |points: &[Point3<f64>]| {
        let tree = crate::geometry::neighbors::KdTree::new(points);
        let gaps: Vec<f64> = points.iter().map(|p| tree.nearest(p, 2)[1].0.sqrt()).collect();
        (gaps.iter().copied().fold(f64::INFINITY, f64::min), gaps.iter().sum::<f64>() / 2000.0)
    };
    let of_double = gaps(&sample_mesh(&double, &options(Surface::Outside)).unwrap().points);
    let of_single = gaps(&sample_mesh(&ball(1.0), &options(Surface::All)).unwrap().points);
    assert!(of_double.0 > 0.93 * of_single.0, "{of_double:?} against {of_single:?}");
    assert!(of_double.1 > 0.97 * of_single.1, "{of_double:?} against {of_single:?}");
}

#[test]
fn what_can_hardly_be_seen_is_sampled_whole_and_told() {
    // Of sixty boxes in one another the outermost has a forty-fourth of the area.
    let layers: Vec<TriMesh> = (0..60).map(|i| cuboid([1.0 - 0.005 * f64::from(i); 3])).collect();
    let options = SamplingOptions { points: 2000, ..SamplingOptions::default() };
    let cloud = sample_mesh(&together(&layers), &options).unwrap();
    assert_eq!((cloud.points.len(), cloud.part), (2000, SampledPart::WholeAsHidden));
    assert!(cloud.part.note().unwrap().contains("all of it was sampled"));
    assert!(cloud.points.iter().any(|p| p.coords.amax() < 0.9));
    let all = SamplingOptions { surface: Surface::All, ..options };
    assert_eq!(sample_mesh(&together(&layers), &all).unwrap().points, cloud.points);
}

#[test]
fn a_mesh_without_an_area_encloses_nothing() {
    for mesh in [TriMesh::default(), TriMesh { vertices: vec![Point3::origin(); 3], faces: vec![[0, 1, 2]] }]
    {
        assert!(!FilledOutside::new(&mesh).contains(&Point3::origin()));
    }
    let ball = FilledOutside::new(&ball(1.0));
    for not_finite in [f64::NAN, f64::INFINITY] {
        assert!(!ball.contains(&Point3::new(not_finite, 0.0, 0.0)));
    }
    assert!(!ball.contains(&Point3::new(1e300, 0.0, 0.0)));
}
