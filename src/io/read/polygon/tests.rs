//! Triangles cover their polygon, once, and nothing else.

use nalgebra::{Isometry3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::geometry::TriMesh;
use crate::io::ShapeGeometry;
use crate::io::read::raw::Raw;

fn read(points: &[Point3<f64>]) -> TriMesh {
    let mut raw = Raw { points: points.to_vec(), ..Raw::default() };
    raw.polygon(&(0..points.len() as u32).collect::<Vec<_>>());
    match raw.checked("a polygon".to_owned()).unwrap().geometry {
        ShapeGeometry::Mesh(mesh) => mesh,
        ShapeGeometry::Cloud(_) => TriMesh::default(),
    }
}

fn triangles(mesh: &TriMesh) -> impl Iterator<Item = [Point3<f64>; 3]> {
    mesh.faces.iter().map(|face| mesh.corners(face).unwrap())
}

/// Twice the area, along the normal.
fn twice_area([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

fn twice_shoelace(polygon: &[Point2<f64>]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(a, b)| a.x * b.y - a.y * b.x).sum()
}

fn edges(polygon: &[Point2<f64>]) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> {
    polygon.iter().copied().zip(polygon.iter().copied().cycle().skip(1))
}

/// Whether a place is inside, or as good as on an edge.
fn is_inside(polygon: &[Point2<f64>], p: Point2<f64>) -> bool {
    let is_crossed = |(a, b): (Point2<f64>, Point2<f64>)| {
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    let is_near = |(a, b): (Point2<f64>, Point2<f64>)| {
        let along = b - a;
        let t = ((p - a).dot(&along) / along.norm_squared().max(1e-300)).clamp(0.0, 1.0);
        (a + t * along - p).norm() < 1e-6
    };
    edges(polygon).filter(|edge| is_crossed(*edge)).count() % 2 == 1 || edges(polygon).any(is_near)
}

/// Reads a polygon at some place in space, and sees that its triangles are it.
fn expect_covered(polygon: &[Point2<f64>], place: Isometry3<f64>, scale: f64) {
    let to_space = |p: &Point2<f64>| place * Point3::new(scale * p.x, scale * p.y, 0.0);
    let mesh = read(&polygon.iter().map(to_space).collect::<Vec<_>>());
    let expected = twice_shoelace(polygon);
    let normal = place * Vector3::z() * expected.signum();
    let mut found = 0.0;
    for corners in triangles(&mesh) {
        let along = twice_area(corners).dot(&normal) / (scale * scale);
        assert!(along > -1e-6 * expected.abs(), "turned: {along} {polygon:?}");
        found += twice_area(corners).norm() / (scale * scale);
        for [u, v] in [[1. / 3., 1. / 3.], [0.01, 0.01], [0.98, 0.01], [0.01, 0.98], [0.5, 0.49]] {
            let p = corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
            let p = place.inverse_transform_point(&p) / scale;
            assert!(is_inside(polygon, p.xy()), "{p} is not in {polygon:?}");
        }
    }
    let part = (found - expected.abs()).abs() / expected.abs();
    assert!(part < 1e-5, "{found}, not {expected}: {polygon:?}");
}

fn places() -> impl Strategy<Value = (Isometry3<f64>, f64)> {
    let axis = prop_oneof![
        Just([0.0; 3]),
        Just([std::f64::consts::PI, 0.0, 0.0]),
        Just([0.0, std::f64::consts::FRAC_PI_2, 0.0]),
        prop::array::uniform3(-3.0..3.0f64),
    ];
    // Sizes with the offsets at which they can still be told.
    let scale = prop_oneof![
        Just((1.0, Vector3::zeros())),
        Just((1e12, Vector3::repeat(1e12))),
        Just((1e-9, Vector3::zeros())),
        Just((1e-9, Vector3::repeat(1e-3))),
        Just((1e70, Vector3::zeros())),
        Just((1e-70, Vector3::zeros())),
        Just((30.0, Vector3::new(450_000.0, 5_400_000.0, 120.0))),
    ];
    (axis, scale).prop_map(|(axis, (scale, offset))| {
        let turn: UnitQuaternion<f64> = Rotation3::new(Vector3::from(axis)).into();
        (Isometry3::from_parts(Translation3::from(offset), turn), scale)
    })
}

/// Corners all around a middle, at any distance.
fn stars() -> impl Strategy<Value = Vec<Point2<f64>>> {
    prop::collection::vec((0.05..1.0f64, -0.4..0.4f64), 3..120).prop_map(|corners| {
        let step = std::f64::consts::TAU / corners.len() as f64;
        let corner = |(i, (radius, jitter)): (usize, &(f64, f64))| {
            let (sin, cos) = ((i as f64 + jitter) * step).sin_cos();
            Point2::new(radius * cos, radius * sin)
        };
        corners.iter().enumerate().map(corner).collect()
    })
}

/// Any polygon whose edges don't cross: of random corners, which are
/// disentangled; on a coarse grid, so that many lie on a line.
fn tangles() -> impl Strategy<Value = Vec<Point2<f64>>> {
    let free = prop::collection::vec((0.0..1.0f64, 0.0..1.0f64), 4..24);
    let grid = prop::collection::vec((0u8..6, 0u8..6), 4..14)
        .prop_map(|all| all.into_iter().map(|(x, y)| (f64::from(x) / 5.0, f64::from(y) / 5.0)).collect());
    prop_oneof![free, grid].prop_filter_map("no area", |corners: Vec<(f64, f64)>| {
        let mut polygon: Vec<Point2<f64>> = Vec::new();
        for (x, y) in corners {
            if !polygon.contains(&Point2::new(x, y)) {
                polygon.push(Point2::new(x, y));
            }
        }
        let turn = |a: Point2<f64>, b: Point2<f64>, c: Point2<f64>| (b - a).perp(&(c - a));
        let n = polygon.len();
        let crossing = |polygon: &[Point2<f64>]| {
            let at = |i: usize| polygon[i % n];
            let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
            pairs.into_iter().find(|&(i, j)| {
                let (a, b, c, d) = (at(i), at(i + 1), at(j), at(j + 1));
                // Proper crossings; touching ones are sorted out below.
                turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0
            })
        };
        for _ in 0..1000 {
            let Some((i, j)) = crossing(&polygon) else { break };
            polygon[i + 1..=j].reverse();
        }
        // A corner on another's edge may stand for an overlap.
        let touches = (0..n).any(|k| {
            (0..n).filter(|&i| i != k && (i + 1) % n != k).any(|i| {
                let (a, b, p) = (polygon[i], polygon[(i + 1) % n], polygon[k]);
                turn(a, b, p).abs() < 1e-9 && (p - a).dot(&(p - b)) <= 0.0
            })
        });
        let is_sound =
            n > 3 && crossing(&polygon).is_none() && !touches && twice_shoelace(&polygon).abs() > 0.02;
        is_sound.then_some(polygon)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn stars_are_covered_once(polygon in stars(), (place, scale) in places(), turned: bool) {
        let mut polygon = polygon;
        if turned {
            polygon.reverse();
        }
        prop_assume!(twice_shoelace(&polygon).abs() > 0.02);
        expect_covered(&polygon, place, scale);
    }

    #[test]
    fn any_simple_polygon_is_covered_once(polygon in tangles(), (place, scale) in places()) {
        expect_covered(&polygon, place, scale);
    }

    /// Whatever was read of convex polygons stays as it was.
    #[test]
    fn convex_polygons_are_fans(
        angles in prop::collection::btree_set(0u16..2000, 3..40),
        (place, scale) in places(),
        bumps in prop::collection::vec(-1e-3..1e-3f64, 40),
        is_flat: bool,
    ) {
        let point = |(angle, bump): (&u16, f64)| {
            let (sin, cos) = (f64::from(*angle) * std::f64::consts::TAU / 2000.0).sin_cos();
            place * Point3::new(scale * cos, 2.0 * scale * sin, if is_flat { 0.0 } else { scale * bump })
        };
        let wide = angles.iter().zip(angles.iter().skip(1)).all(|(a, b)| b - a > 20);
        prop_assume!(is_flat || wide);
        let points: Vec<_> = angles.iter().zip(bumps).map(point).collect();
        let fan = (2..points.len()).map(|i| [points[0], points[i - 1], points[i]]);
        prop_assert!(triangles(&read(&points)).eq(fan.filter(crate::geometry::mesh::has_area)));
    }

    /// No polygon is too odd for an answer: crossing, folded, or with corners
    /// that repeat or lie on a line.
    #[test]
    fn no_polygon_panics(
        corners in prop::collection::vec(prop::array::uniform3(prop_oneof![
            (-2i8..3).prop_map(f64::from),
            -1.0..1.0f64,
            prop::sample::select(vec![f64::NAN, f64::INFINITY, 1e308, -1e308, 1e-310, 1e12]),
        ]), 3..100),
    ) {
        let points: Vec<_> = corners.into_iter().map(Point3::from).collect();
        prop_assert!(points.iter().all(|p| !p.iter().all(|c| c.is_finite())) || read(&points).faces.len() < 100);
    }
}

/// Polygons that touch themselves, as programs write them.
#[test]
fn corners_may_repeat_and_lie_on_a_line() {
    let cases: [(&str, f64, &[[f64; 2]]); 7] = [
        ("an L", 5.0, &[[3., 1.], [1., 1.], [1., 3.], [0., 3.], [0., 0.], [3., 0.]]),
        (
            "an L with corners on its lines",
            5.0,
            &[
                [3., 1.],
                [2., 1.],
                [1., 1.],
                [1., 2.],
                [1., 3.],
                [0., 3.],
                [0., 1.],
                [0., 0.],
                [1., 0.],
                [2., 0.],
                [3., 0.],
            ],
        ),
        (
            "repeated corners",
            5.0,
            &[
                [3., 1.],
                [3., 1.],
                [1., 1.],
                [1., 3.],
                [1., 3.],
                [1., 3.],
                [0., 3.],
                [0., 0.],
                [3., 0.],
                [3., 1.],
            ],
        ),
        (
            "a hole through a bridge",
            15.0,
            &[
                [0., 0.],
                [4., 0.],
                [4., 4.],
                [0., 4.],
                [0., 0.],
                [1., 1.],
                [1., 2.],
                [2., 2.],
                [2., 1.],
                [1., 1.],
            ],
        ),
        ("a spike", 4.0, &[[0., 0.], [2., 0.], [2., 1.], [3., 1.], [2., 1.], [2., 2.], [0., 2.]]),
        (
            "two squares at a corner",
            2.0,
            &[[0., 0.], [1., 0.], [1., 1.], [2., 1.], [2., 2.], [1., 2.], [1., 1.], [0., 1.]],
        ),
        (
            "a comb",
            12.5,
            &[
                [0., 0.],
                [5., 0.],
                [5., 5.],
                [4., 5.],
                [4., 1.],
                [3., 1.],
                [3., 5.],
                [2., 5.],
                [2., 1.],
                [1., 1.],
                [1., 1.],
            ],
        ),
    ];
    for (what, area, corners) in cases {
        for start in 0..corners.len() {
            let mut polygon: Vec<Point2<f64>> = corners.iter().map(|c| Point2::from(*c)).collect();
            polygon.rotate_left(start);
            for turned in [false, true] {
                if turned {
                    polygon.reverse();
                }
                assert!((twice_shoelace(&polygon).abs() - 2.0 * area).abs() < 1e-9, "{what}: {polygon:?}");
                let place = Isometry3::new(Vector3::new(1e6, 0.0, 3.0), Vector3::new(0.3, -1.0, 0.5));
                expect_covered(&polygon, Isometry3::identity(), 1.0);
                expect_covered(&polygon, place, 0.1);
            }
        }
    }
}

/// A corner on an edge is one of a neighbour, too: without it the two gape.
#[test]
fn no_corner_is_lost() {
    let corners =
        [[3., 1.], [2., 1.], [1., 1.], [1., 2.], [1., 3.], [0., 3.], [0., 1.], [0., 0.], [1., 0.], [2., 0.]];
    // From the middle all are seen, and the fan that fits stays.
    for first in (0..corners.len()).filter(|&i| corners[i].iter().any(|c| *c > 1.0)) {
        let mut points: Vec<_> = corners.iter().map(|[x, y]| Point3::new(*x, *y, x + 0.5 * y)).collect();
        points.rotate_left(first);
        let mesh = read(&points);
        assert_eq!((mesh.vertices.len(), mesh.faces.len()), (10, 8), "{mesh:?}");
    }
    // Bent so far that in its plane, a corner lies behind an edge.
    let bent = [[-5., 0., 5.], [5., 0., 5.], [5., 0., -5.], [-5., 0., -5.], [0., 5., -5.]];
    assert_eq!(read(&bent.map(Point3::from)).vertices.len(), 5);
}
