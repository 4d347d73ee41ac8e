//! Picking: the nearest visible thing under the pixel, as the pictures show it.

use glam::{Vec2, Vec3};
use nalgebra::{Point3, Rotation3, Vector3};
use superform::geometry::Superquadric;
use superform::render::picking::pick;
use superform::render::{
    CameraMatrices, Frame, Highlight, Layers, PickId, PickScene, PointIndex, PrimitiveInstance, SurfaceStyle,
};

const SIZE: [u32; 2] = [400, 300];
const CENTER: Vec2 = Vec2::new(200.0, 150.0);

fn perspective() -> CameraMatrices {
    CameraMatrices::perspective(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, Vec3::Y, 0.6, 4.0 / 3.0, 0.01)
}

fn orthographic() -> CameraMatrices {
    let eye = Vec3::new(0.0, 0.0, 3.0);
    CameraMatrices::orthographic(eye, Vec3::ZERO, Vec3::Y, 1.8, 4.0 / 3.0, 0.0, 10.0)
}

fn frame(camera: CameraMatrices) -> Frame {
    Frame { surface_style: SurfaceStyle::Solid, ..Frame::new(SIZE, camera) }
}

fn primitive(id: u32, shape: Superquadric) -> PrimitiveInstance {
    PrimitiveInstance { id, shape, color: [255; 4], visible: true, highlight: Highlight::None, ghost: false }
}

fn sphere(id: u32, z: f64, radius: f64) -> PrimitiveInstance {
    primitive(id, Superquadric::sphere(Point3::new(0.0, 0.0, z), radius))
}

#[test]
fn the_nearest_primitive_is_hit_on_its_surface() {
    let primitives = [sphere(5, -0.5, 0.3), sphere(9, 0.4, 0.2)];
    let scene = PickScene { primitives: &primitives, ..PickScene::default() };
    for camera in [perspective(), orthographic()] {
        let found = pick(&scene, &frame(camera), CENTER).unwrap();
        assert_eq!(found.id, PickId::Primitive(9));
        assert!((found.position - Vec3::new(0.0, 0.0, 0.6)).length() < 1e-3, "{:?}", found.position);
        assert!(pick(&scene, &frame(camera), Vec2::new(3.0, 3.0)).is_none());
    }
    let hidden = [primitives[0], PrimitiveInstance { visible: false, ..primitives[1] }];
    let scene = PickScene { primitives: &hidden, ..scene };
    assert_eq!(pick(&scene, &frame(perspective()), CENTER).unwrap().id, PickId::Primitive(5));
    let none = Layers { primitives: false, ..Layers::default() };
    assert!(pick(&scene, &Frame { layers: none, ..frame(perspective()) }, CENTER).is_none());
}

/// Over the whole picture a sphere is hit exactly inside its outline.
#[test]
fn the_hit_region_is_the_silhouette() {
    let primitives = [sphere(1, 0.0, 0.5)];
    let scene = PickScene { primitives: &primitives, ..PickScene::default() };
    let frame = frame(perspective());
    let radius = (0.5f32 / 3.0).asin().tan() / 0.3f32.tan() * 150.0;
    for y in (0..300).step_by(7) {
        for x in (0..400).step_by(7) {
            let pixel = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let distance = (pixel - CENTER).length();
            if (distance - radius).abs() > 1.5 {
                assert_eq!(pick(&scene, &frame, pixel).is_some(), distance < radius, "{pixel}");
            }
        }
    }
}

#[test]
fn thin_tapered_and_turned_bodies_are_hit() {
    let plate = Superquadric {
        exponents: [0.1, 0.1],
        semi_axes: Vector3::new(0.4, 0.4, 1e-3),
        rotation: Rotation3::from_euler_angles(0.2, 0.3, 0.0),
        translation: Vector3::zeros(),
        taper: [0.0; 2],
    };
    let cone = Superquadric {
        exponents: [0.1, 1.0],
        semi_axes: Vector3::new(0.2, 0.2, 0.4),
        rotation: Rotation3::from_euler_angles(-std::f64::consts::FRAC_PI_2, 0.0, 0.0),
        taper: [-1.0, -1.0],
        ..plate
    };
    let frame = frame(perspective());
    for shape in [plate, cone] {
        let primitives = [primitive(3, shape)];
        let scene = PickScene { primitives: &primitives, ..PickScene::default() };
        let found = pick(&scene, &frame, CENTER).unwrap();
        let p = Point3::new(
            f64::from(found.position.x),
            f64::from(found.position.y),
            f64::from(found.position.z),
        );
        assert!(shape.first_order_distance(&p) < 1e-3, "{p:?}");
    }
    // The cone's apex is up: beside its tip there is nothing, beside its base there is.
    let primitives = [primitive(3, cone)];
    let scene = PickScene { primitives: &primitives, ..PickScene::default() };
    let at = |x, y| pick(&scene, &frame, frame.camera.project(Vec3::new(x, y, 0.0), SIZE).unwrap()).is_some();
    assert!(!at(0.15, 0.3) && at(0.15, -0.3));
}

#[test]
fn points_are_hit_within_their_disc_nearest_first() {
    let points = [[0.0, 0.0, -0.5], [0.0, 0.0, 0.5], [0.3, 0.2, 0.0], [f32::NAN, 0.0, 0.0], [0.0, 0.0, 9.0]];
    let scene = PickScene { points: &points, ..PickScene::default() };
    for camera in [perspective(), orthographic()] {
        let frame = Frame { point_size: 12.0, ..frame(camera) };
        assert_eq!(pick(&scene, &frame, CENTER).unwrap().id, PickId::Point(1));
        let third = camera.project(Vec3::new(0.3, 0.2, 0.0), SIZE).unwrap();
        let beside = |d: f32| pick(&scene, &frame, third + Vec2::new(d, 0.0)).map(|p| p.id);
        assert_eq!(beside(5.0), Some(PickId::Point(2)));
        assert_eq!(beside(9.0), None);
        let colors = [[9, 9, 9, 255], [9, 9, 9, 0], [9, 9, 9, 255]];
        let scene = PickScene { point_colors: &colors, ..scene };
        assert_eq!(pick(&scene, &frame, CENTER).unwrap().id, PickId::Point(0));
    }
    // A point of one pixel is still hit from a little beside it.
    let small = Frame { point_size: 1.0, ..frame(perspective()) };
    assert_eq!(pick(&scene, &small, CENTER + Vec2::new(2.5, 0.0)).unwrap().id, PickId::Point(1));
}

#[test]
fn solid_bodies_hide_points_and_wires_do_not() {
    let primitives = [sphere(4, 0.0, 0.3)];
    let behind = [[0.0, 0.0, -0.6]];
    let on_top = [[0.0, 0.0, 0.299]];
    let hit = |points: &[[f32; 3]], surface_style| {
        let scene = PickScene { points, primitives: &primitives, ..PickScene::default() };
        pick(&scene, &Frame { surface_style, ..frame(perspective()) }, CENTER).unwrap().id
    };
    assert_eq!(hit(&behind, SurfaceStyle::Solid), PickId::Primitive(4));
    assert_eq!(hit(&behind, SurfaceStyle::Wire), PickId::Point(0));
    assert_eq!(hit(&on_top, SurfaceStyle::Solid), PickId::Point(0));
    assert_eq!(hit(&on_top, SurfaceStyle::Translucent), PickId::Point(0));
}

#[test]
fn an_empty_scene_or_picture_has_nothing_to_pick() {
    let scene = PickScene::default();
    assert!(pick(&scene, &frame(perspective()), CENTER).is_none());
    assert!(pick(&scene, &Frame::new([0, 0], perspective()), CENTER).is_none());
    assert!(pick(&scene, &frame(perspective()), Vec2::NAN).is_none());
}

/// The comparison with a plain search over all points, on a cloud of 200,000.
#[test]
fn picking_in_a_large_cloud_finds_what_a_plain_search_finds() {
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
    };
    let points: Vec<[f32; 3]> = (0..200_000).map(|_| [random(), random(), random()]).collect();
    let scene = PickScene { points: &points, ..PickScene::default() };
    let frame = Frame { point_size: 4.0, ..frame(orthographic()) };
    for k in 0..20 {
        let pixel = CENTER + Vec2::new(random(), random()) * 100.0 + k as f32;
        let expected = points
            .iter()
            .enumerate()
            .filter(|(_, p)| {
                let at = frame.camera.project(Vec3::from_array(**p), SIZE).unwrap();
                (at - pixel).length() <= 2.5
            })
            .max_by(|a, b| a.1[2].total_cmp(&b.1[2]));
        match (pick(&scene, &frame, pixel).map(|p| p.id), expected) {
            (Some(PickId::Point(i)), Some((j, _))) => assert_eq!(i, j),
            (found, None) => assert!(found.is_none() || matches!(found, Some(PickId::Point(_)))),
            other => panic!("{other:?}"),
        }
    }
}

/// The index finds what a look at all points finds, from everywhere.
#[test]
fn an_index_changes_nothing_but_the_time() {
    // A spiral on a sphere, on itself in places, with points that are nowhere.
    let points: Vec<[f32; 3]> = (0..20_000)
        .map(|i| {
            let (z, angle) = (1.0 - 2.0 * (i % 9_000) as f32 / 9_000.0, 2.4 * (i % 9_000) as f32);
            let r = (1.0 - z * z).sqrt();
            let p = [0.5 * r * angle.cos(), 0.5 * r * angle.sin(), 0.5 * z];
            if i % 1_000 == 7 { [f32::NAN, 0.0, 0.0] } else { p }
        })
        .collect();
    let colors: Vec<[u8; 4]> =
        (0..points.len()).map(|i| [9, 9, 9, if i % 3 == 0 { 0 } else { 255 }]).collect();
    let index = PointIndex::new(&points);
    let scene = PickScene { points: &points, point_colors: &colors, ..PickScene::default() };
    let indexed = PickScene { point_index: Some(&index), ..scene };
    let inside = CameraMatrices::perspective(Vec3::ZERO, Vec3::X, Vec3::Y, 1.2, 4.0 / 3.0, 0.01);
    let mut hits = 0;
    for camera in [perspective(), orthographic(), inside] {
        let frame = frame(camera);
        for y in (0..300).step_by(11) {
            for x in (0..400).step_by(13) {
                let pixel = Vec2::new(x as f32 + 0.3, y as f32 + 0.6);
                let found = pick(&indexed, &frame, pixel);
                assert_eq!(found, pick(&scene, &frame, pixel), "{pixel}");
                hits += usize::from(found.is_some());
            }
        }
    }
    assert!(hits > 300, "{hits} hits are no test");
}
