//! What lies in a box or a lasso: as a look at every point says.

use glam::{Vec2, Vec3};
use nalgebra::Point3;
use superform::geometry::Superquadric;
use superform::render::region::{points_within, primitives_within};
use superform::render::{
    CameraMatrices, Frame, Highlight, PickScene, PrimitiveInstance, Region, SurfaceStyle,
};

const SIZE: [u32; 2] = [400, 300];

fn cameras() -> [CameraMatrices; 2] {
    let eye = Vec3::new(0.4, 0.3, 3.0);
    [
        CameraMatrices::perspective(eye, Vec3::ZERO, Vec3::Y, 0.6, 4.0 / 3.0, 0.01),
        CameraMatrices::orthographic(eye, Vec3::ZERO, Vec3::Y, 1.8, 4.0 / 3.0, 0.0, 10.0),
    ]
}

fn sphere(id: u32, x: f64, z: f64, radius: f64) -> PrimitiveInstance {
    PrimitiveInstance {
        id,
        shape: Superquadric::sphere(Point3::new(x, 0.0, z), radius),
        color: [255; 4],
        visible: true,
        highlight: Highlight::None,
        ghost: false,
    }
}

/// Points in and around the picture, some behind the camera and some nowhere.
fn cloud() -> Vec<[f32; 3]> {
    let part = |i: u32, step: f32| (i as f32 * step).fract() * 2.0 - 1.0;
    let mut points: Vec<_> =
        (0..4000).map(|i| [part(i, 0.618_034), part(i, 0.754_877_7), part(i, 0.569_840_3)]).collect();
    points.extend((0..50).map(|i| [part(i, 0.618), part(i, 0.755), 5.0]));
    points.push([f32::NAN; 3]);
    points
}

/// Whether the closed line goes around the place an odd number of times, and
/// how far off the line it is.
fn inside(corners: &[Vec2], p: Vec2) -> (bool, f32) {
    let mut is_inside = false;
    let mut distance = f32::INFINITY;
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            is_inside = !is_inside;
        }
        let along = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-9)).clamp(0.0, 1.0);
        distance = distance.min(p.distance(a + (b - a) * along));
    }
    (is_inside, distance)
}

#[test]
fn a_box_and_a_lasso_hold_the_points_that_are_seen_in_them() {
    let points = cloud();
    let mut colors = vec![[255; 4]; points.len()];
    colors[7] = [0; 4];
    let scene = PickScene { points: &points, point_colors: &colors, ..PickScene::default() };
    let star: Vec<Vec2> = (0..9)
        .map(|i| {
            // Crosses itself.
            let a = i as f32 * 4.0 / 9.0 * std::f32::consts::TAU;
            Vec2::new(210.0 + 150.0 * a.cos(), 140.0 + 170.0 * a.sin())
        })
        .collect();
    let (low, high) = (Vec2::new(350.0, 20.0), Vec2::new(60.0, 250.0));
    let corners = vec![low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
    for camera in cameras() {
        let frame = Frame::new(SIZE, camera);
        for (region, corners) in [(Region::Box(low, high), &corners), (Region::Lasso(star.clone()), &star)] {
            let found = points_within(&scene, &frame, &region, false);
            assert!(found.is_sorted() && found.len() > 300, "{}", found.len());
            for (i, p) in points.iter().enumerate() {
                let Some(pixel) = camera.project(Vec3::from_array(*p), SIZE).filter(|p| p.is_finite()) else {
                    assert!(!found.contains(&(i as u32)));
                    continue;
                };
                let (is_inside, distance) = inside(corners, pixel);
                let on_screen = pixel.cmpge(Vec2::ZERO).all() && pixel.x <= 400.0 && pixel.y <= 300.0;
                let expected = is_inside && on_screen && i != 7;
                let is_found = found.binary_search(&(i as u32)).is_ok();
                assert!(is_found == expected || distance < 1.5, "{i} at {pixel}");
            }
        }
    }
}

#[test]
fn what_is_hidden_can_be_left_out() {
    let mut points = cloud();
    points.retain(|p| p[0].hypot(p[1]) < 0.2 && p[2] < 2.0);
    let primitives = [sphere(1, 0.0, 0.5, 0.3), sphere(2, 0.0, -0.6, 0.2), sphere(3, 0.9, 0.0, 0.1)];
    let scene = PickScene { points: &points, primitives: &primitives, ..PickScene::default() };
    let camera =
        CameraMatrices::perspective(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, 0.6, 4.0 / 3.0, 0.01);
    let frame = Frame { surface_style: SurfaceStyle::Solid, ..Frame::new(SIZE, camera) };
    let everywhere = Region::Box(Vec2::ZERO, Vec2::new(400.0, 300.0));
    assert_eq!(points_within(&scene, &frame, &everywhere, false).len(), points.len());
    let visible = points_within(&scene, &frame, &everywhere, true);
    assert!(!visible.is_empty());
    for &i in &visible {
        assert!(points[i as usize][2] > 0.4, "{:?} is behind the ball", points[i as usize]);
    }
    assert_eq!(primitives_within(&scene, &frame, &everywhere, false), [1, 2, 3]);
    assert_eq!(primitives_within(&scene, &frame, &everywhere, true), [1, 3]);
    // Within the ball's face there is none of the points of its surface.
    let spot = Region::Box(Vec2::new(199.0, 149.0), Vec2::new(201.5, 151.5));
    assert_eq!(primitives_within(&scene, &frame, &spot, false), [1, 2]);
    let ghosts = [PrimitiveInstance { ghost: true, ..primitives[0] }];
    let scene = PickScene { primitives: &ghosts, ..PickScene::default() };
    assert!(primitives_within(&scene, &frame, &everywhere, false).is_empty());
}

#[test]
fn regions_of_nothing_hold_nothing() {
    let points = cloud();
    let scene = PickScene { points: &points, ..PickScene::default() };
    let frame = Frame::new(SIZE, cameras()[0]);
    let nan = Vec2::splat(f32::NAN);
    for region in [
        Region::Lasso(vec![]),
        Region::Lasso(vec![nan, nan]),
        Region::Box(Vec2::ONE, Vec2::ONE),
        Region::Box(Vec2::splat(-50.0), Vec2::splat(-10.0)),
        Region::Box(nan, Vec2::ONE),
    ] {
        assert!(points_within(&scene, &frame, &region, true).is_empty(), "{region:?}");
    }
}
