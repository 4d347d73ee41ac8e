//! Pictures of the renderer, checked by what they must show. They need a
//! Vulkan or GL driver (Mesa's lavapipe will do); without one they are skipped,
//! or fail if SUPERFORM_REQUIRE_GPU=1.

mod coplanar;

use std::f32::consts::PI;

use crate::needs::drawn;
use glam::{Vec2, Vec3};
use image::{Rgba, RgbaImage};
use nalgebra::{Point3, Rotation3, Vector3};
use superform::geometry::Superquadric;
use superform::geometry::tessellate::surface_samples;
use superform::render::{
    Background, CameraMatrices, Frame, Highlight, InputStyle, Layers, LineSegment, Offscreen,
    PrimitiveInstance, RenderOptions, SceneTheme, SurfaceStyle,
};

fn offscreen(msaa: u32) -> Option<Offscreen> {
    drawn(Offscreen::new(RenderOptions { msaa }))
}

/// Looks along −z at the origin from a distance of 3.
fn camera(size: [u32; 2]) -> CameraMatrices {
    let aspect = size[0] as f32 / size[1] as f32;
    CameraMatrices::perspective(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, Vec3::Y, 0.6, aspect, 0.01)
}

fn bare(size: [u32; 2]) -> Frame {
    let black = [0.0, 0.0, 0.0, 1.0];
    Frame {
        layers: Layers { grid: false, ..Layers::default() },
        surface_style: SurfaceStyle::Solid,
        depth_cues: 0.0,
        theme: SceneTheme {
            background: Background::Gradient { top: black, bottom: black },
            ..SceneTheme::dark()
        },
        ..Frame::new(size, camera(size))
    }
}

fn sphere(id: u32, center: [f64; 3], radius: f64, color: [u8; 4]) -> PrimitiveInstance {
    PrimitiveInstance {
        id,
        shape: Superquadric::sphere(Point3::from(center), radius),
        color,
        visible: true,
        highlight: Highlight::None,
        ghost: false,
    }
}

fn set_primitives(offscreen: &mut Offscreen, primitives: &[PrimitiveInstance]) {
    let (renderer, device, queue) = offscreen.parts();
    renderer.set_primitives(device, queue, primitives);
}

fn set_points(offscreen: &mut Offscreen, points: &[[f32; 3]], colors: &[[u8; 4]]) {
    let (renderer, device, queue) = offscreen.parts();
    renderer.set_points(device, queue, points);
    renderer.set_point_colors(queue, colors);
}

/// How much of a pixel is not black background.
fn lit(p: &Rgba<u8>) -> bool {
    p.0[..3].iter().any(|&c| c > 24)
}

fn count(picture: &RgbaImage, test: impl Fn(&Rgba<u8>) -> bool) -> usize {
    picture.pixels().filter(|p| test(p)).count()
}

fn is_red(p: &Rgba<u8>) -> bool {
    p[0] > 60 && p[0] / 2 > p[1].max(p[2])
}

fn is_blue(p: &Rgba<u8>) -> bool {
    p[2] > 60 && p[2] / 2 > p[0].max(p[1])
}

const RED: [u8; 4] = [220, 40, 40, 255];
const BLUE: [u8; 4] = [40, 40, 230, 255];

#[test]
fn nothing_in_the_scene_is_background_everywhere() {
    for msaa in [1, 4] {
        let Some(mut offscreen) = offscreen(msaa) else { return };
        let size = [70, 50];
        let theme = SceneTheme {
            background: Background::Gradient { top: [1.0, 0.0, 0.0, 1.0], bottom: [0.0, 0.0, 1.0, 1.0] },
            ..SceneTheme::dark()
        };
        let picture = offscreen.render(&Frame { theme, ..bare(size) }).unwrap();
        assert!(picture.get_pixel(3, 0)[0] > 245 && picture.get_pixel(60, 49)[2] > 245);
        assert!(count(&picture, |p| p[1] > 1 || p[3] != 255) == 0);

        // Empty data of every kind, and styles that would draw it.
        set_primitives(&mut offscreen, &[]);
        set_points(&mut offscreen, &[], &[[1, 2, 3, 255]]);
        let (renderer, device, queue) = offscreen.parts();
        renderer.set_mesh(device, queue, &[], &[]);
        renderer.set_lines(device, queue, &[]);
        for surface_style in [SurfaceStyle::Solid, SurfaceStyle::Translucent, SurfaceStyle::Wire] {
            let picture = offscreen.render(&Frame { surface_style, ..bare(size) }).unwrap();
            assert_eq!(count(&picture, |p| p.0 != [0, 0, 0, 255] && lit(p)), 0);
        }
    }
}

#[test]
fn a_picture_without_area_is_refused_and_does_not_panic() {
    let Some(mut offscreen) = offscreen(1) else { return };
    for size in [[0, 10], [10, 0], [1_000_000, 10]] {
        let error = offscreen.render(&bare(size)).unwrap_err();
        assert!(error.to_string().contains("cannot render"), "{error}");
    }
    // And the next one is drawn.
    assert_eq!(offscreen.render(&bare([1, 1])).unwrap().dimensions(), (1, 1));
}

#[test]
fn a_sphere_covers_the_area_of_its_silhouette_and_has_its_colour() {
    for msaa in [1, 4] {
        let Some(mut offscreen) = offscreen(msaa) else { return };
        set_primitives(&mut offscreen, &[sphere(7, [0.0; 3], 0.5, [60, 200, 90, 255])]);
        let size = [300, 260];
        let picture = offscreen.render(&bare(size)).unwrap();
        // A sphere of radius r at distance d is seen under asin(r/d).
        let angle = (0.5f32 / 3.0).asin();
        let radius = angle.tan() / 0.3f32.tan() * 130.0;
        let covered = count(&picture, lit) as f32;
        let expected = PI * radius * radius;
        assert!((covered - expected).abs() < 0.02 * expected, "{covered} pixels instead of {expected}");
        let middle = picture.get_pixel(150, 130);
        assert!(middle[1] > 130 && middle[1] > 2 * middle[0] && middle[1] > middle[2] + 60, "{middle:?}");
        // The key light comes from the upper left.
        let (bright, dark) = (picture.get_pixel(130, 100), picture.get_pixel(165, 165));
        assert!(u32::from(bright[1]) > u32::from(dark[1]) + 30, "{bright:?} {dark:?}");
    }
}

#[test]
fn a_point_is_round_and_of_the_size_asked_for() {
    let Some(mut offscreen) = offscreen(4) else { return };
    set_points(&mut offscreen, &[[0.0; 3]], &[[255, 255, 255, 255]]);
    for (point_size, pixels_per_point) in [(9.0, 1.0), (20.0, 1.0), (10.0, 2.0)] {
        let frame = Frame { point_size, pixels_per_point, ..bare([101, 101]) };
        let picture = offscreen.render(&frame).unwrap();
        // Each pixel counts by its brightness against its surroundings' full one.
        let diameter = point_size * pixels_per_point;
        let lit_pixels = count(&picture, |p| p[0] > 90) as f32;
        let expected = PI * diameter * diameter / 4.0;
        assert!((lit_pixels - expected).abs() < 0.08 * expected + 6.0, "{lit_pixels} instead of {expected}");
        let inside = |x: f32, y: f32| lit(picture.get_pixel((50.5 + x) as u32, (50.5 + y) as u32));
        let r = 0.5 * diameter;
        assert!(inside(0.0, 0.0) && inside(r - 1.5, 0.0) && inside(0.0, 1.5 - r));
        assert!(!inside(r + 1.5, 0.0) && !inside(0.8 * r + 1.0, 0.8 * r + 1.0) && !inside(0.0, r + 1.5));
    }
}

#[test]
fn hidden_points_and_points_that_are_not_finite_are_not_drawn() {
    let Some(mut offscreen) = offscreen(4) else { return };
    let points = [[0.0; 3], [f32::NAN, 0.0, 0.0], [f32::INFINITY, 0.0, 0.0], [0.0, 0.0, 50.0]];
    set_points(&mut offscreen, &points, &[[255, 255, 255, 0]]);
    let picture = offscreen.render(&Frame { point_size: 30.0, ..bare([64, 64]) }).unwrap();
    assert_eq!(count(&picture, lit), 0);
}

#[test]
fn what_is_nearer_hides_what_is_behind() {
    for msaa in [1, 4] {
        let Some(mut offscreen) = offscreen(msaa) else { return };
        let near = sphere(1, [0.0, 0.0, 0.5], 0.3, RED);
        let far = sphere(2, [0.0, 0.0, -0.5], 0.3, BLUE);
        for order in [[near, far], [far, near]] {
            set_primitives(&mut offscreen, &order);
            let picture = offscreen.render(&bare([80, 80])).unwrap();
            assert!(is_red(picture.get_pixel(40, 40)), "{:?}", picture.get_pixel(40, 40));
        }
        // A point in front of the sphere is seen, one behind it is not.
        set_primitives(&mut offscreen, &[near]);
        set_points(&mut offscreen, &[[0.0, 0.0, 0.9], [0.1, 0.0, -0.5]], &[BLUE, [0, 255, 0, 255]]);
        let picture = offscreen.render(&Frame { point_size: 8.0, ..bare([80, 80]) }).unwrap();
        assert!(is_blue(picture.get_pixel(40, 40)));
        assert_eq!(count(&picture, |p| p[1] > 60 && p[1] / 2 > p[0].max(p[2])), 0);
    }
}

#[test]
fn orthographic_size_does_not_depend_on_depth() {
    let Some(mut offscreen) = offscreen(4) else { return };
    let mut areas = Vec::new();
    for z in [-1.0, 1.0] {
        set_primitives(&mut offscreen, &[sphere(1, [0.0, 0.0, z], 0.25, RED)]);
        let camera = CameraMatrices::orthographic(
            Vec3::new(0.0, 0.0, 3.0),
            Vec3::ZERO,
            Vec3::Y,
            1.0,
            1.0,
            -10.0,
            10.0,
        );
        let picture = offscreen.render(&Frame { camera, ..bare([200, 200]) }).unwrap();
        areas.push(count(&picture, lit) as f32);
    }
    let expected = PI * 50.0 * 50.0;
    assert!(areas.iter().all(|a| (a - expected).abs() < 0.02 * expected), "{areas:?}");
}

#[test]
fn translucent_primitives_let_points_through_and_solid_ones_do_not() {
    let Some(mut offscreen) = offscreen(4) else { return };
    set_primitives(&mut offscreen, &[sphere(1, [0.0; 3], 0.5, BLUE)]);
    set_points(&mut offscreen, &[[0.0; 3]], &[[255, 30, 30, 255]]);
    let middle = |style, offscreen: &mut Offscreen| {
        let frame = Frame { surface_style: style, point_size: 12.0, ..bare([80, 80]) };
        *offscreen.render(&frame).unwrap().get_pixel(40, 40)
    };
    let solid = middle(SurfaceStyle::Solid, &mut offscreen);
    let through = middle(SurfaceStyle::Translucent, &mut offscreen);
    let wire = middle(SurfaceStyle::Wire, &mut offscreen);
    assert!(solid[0] < 110, "{solid:?}");
    assert!(through[0] > 110 && through[2] > 40, "{through:?}");
    assert!(wire[0] > 180 || wire[2] > 100, "{wire:?}");
}

#[test]
fn wires_leave_most_of_the_picture_free() {
    let Some(mut offscreen) = offscreen(4) else { return };
    set_primitives(&mut offscreen, &[sphere(1, [0.0; 3], 0.5, RED)]);
    let picture = offscreen.render(&Frame { surface_style: SurfaceStyle::Wire, ..bare([300, 300]) }).unwrap();
    let solid = offscreen.render(&bare([300, 300])).unwrap();
    let share = count(&picture, |p| p[0] > 100) as f32 / count(&solid, lit) as f32;
    assert!(share > 0.03 && share < 0.4, "{share}");
}

#[test]
fn layers_and_invisible_primitives_are_left_out() {
    let Some(mut offscreen) = offscreen(4) else { return };
    let hidden = PrimitiveInstance { visible: false, ..sphere(1, [0.0; 3], 0.5, RED) };
    set_primitives(&mut offscreen, &[hidden]);
    assert_eq!(count(&offscreen.render(&bare([60, 60])).unwrap(), lit), 0);
    set_primitives(&mut offscreen, &[sphere(1, [0.0; 3], 0.5, RED)]);
    set_points(&mut offscreen, &[[0.0, 0.0, 0.7]], &[BLUE]);
    let frame = bare([60, 60]);
    let layers = Layers { primitives: false, points: false, ..frame.layers };
    assert_eq!(count(&offscreen.render(&Frame { layers, ..frame }).unwrap(), lit), 0);
    assert!(count(&offscreen.render(&frame).unwrap(), is_red) > 100);
}

#[test]
fn selection_draws_an_outline_around_the_silhouette() {
    for msaa in [1, 4] {
        let Some(mut offscreen) = offscreen(msaa) else { return };
        let plain = sphere(1, [0.0; 3], 0.5, BLUE);
        set_primitives(&mut offscreen, &[plain]);
        let before = offscreen.render(&bare([200, 200])).unwrap();
        set_primitives(&mut offscreen, &[PrimitiveInstance { highlight: Highlight::Selected, ..plain }]);
        let after = offscreen.render(&bare([200, 200])).unwrap();
        let orange = |p: &Rgba<u8>| p[0] > 200 && p[1] > 120 && p[2] < 110;
        assert_eq!(count(&before, orange), 0);
        let found = count(&after, orange) as f32;
        let radius = (0.5f32 / 3.0).asin().tan() / 0.3f32.tan() * 100.0;
        // A ring about 1.5 to 2 pixels wide.
        assert!(
            found > 2.0 * PI * radius * 0.8 && found < 2.0 * PI * radius * 3.0,
            "{found}, radius {radius}"
        );
    }
}

#[test]
fn shapes_are_tessellated_again_only_when_they_change() {
    let Some(mut offscreen) = offscreen(1) else { return };
    let one = sphere(1, [0.0; 3], 0.5, RED);
    let two = sphere(2, [0.5, 0.0, 0.0], 0.2, BLUE);
    set_primitives(&mut offscreen, &[one, two]);
    let recoloured = PrimitiveInstance { color: BLUE, highlight: Highlight::Hovered, ..one };
    set_primitives(&mut offscreen, &[two, recoloured]);
    assert_eq!(offscreen.parts().0.tessellations(), 2);
    let moved = PrimitiveInstance { shape: Superquadric::sphere(Point3::new(0.1, 0.0, 0.0), 0.5), ..one };
    set_primitives(&mut offscreen, &[moved, two]);
    assert_eq!(offscreen.parts().0.tessellations(), 3);
    let picture = offscreen.render(&bare([80, 80])).unwrap();
    assert!(is_red(picture.get_pixel(38, 40)));
}

#[test]
fn a_frame_is_drawn_again_only_when_something_changed() {
    let Some(mut offscreen) = offscreen(1) else { return };
    set_primitives(&mut offscreen, &[sphere(1, [0.0; 3], 0.5, RED)]);
    let (renderer, device, queue) = offscreen.parts();
    let prepare = |renderer: &mut superform::render::Renderer, frame: &Frame| {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let drew = renderer.prepare(device, queue, &mut encoder, frame);
        queue.submit([encoder.finish()]);
        drew
    };
    let frame = bare([40, 40]);
    assert!(prepare(renderer, &frame));
    assert!(!prepare(renderer, &frame));
    assert!(prepare(renderer, &Frame { point_size: 7.0, ..frame }));
    renderer.set_points(device, queue, &[[0.0; 3]]);
    assert!(prepare(renderer, &Frame { point_size: 7.0, ..frame }));
    assert!(!prepare(renderer, &Frame { size_px: [0, 40], ..frame }));
    assert!(prepare(renderer, &frame));
}

#[test]
fn a_transparent_background_keeps_the_colour_of_edges() {
    let Some(mut offscreen) = offscreen(4) else { return };
    set_primitives(&mut offscreen, &[sphere(1, [0.0; 3], 0.5, [230, 230, 230, 255])]);
    let mut frame = bare([120, 120]);
    frame.theme.background = Background::Transparent;
    let picture = offscreen.render(&frame).unwrap();
    assert_eq!(picture.get_pixel(2, 2).0, [0, 0, 0, 0]);
    assert_eq!(picture.get_pixel(60, 60)[3], 255);
    let edges = picture.pixels().filter(|p| p[3] > 30 && p[3] < 225);
    assert!(edges.clone().count() > 40);
    assert!(edges.clone().all(|p| p[0] > 60), "edges are not darkened by the background");
}

#[test]
fn the_ghost_is_faint_and_the_solid_input_is_not() {
    let Some(mut offscreen) = offscreen(4) else { return };
    let (renderer, device, queue) = offscreen.parts();
    let vertices = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]];
    renderer.set_mesh(device, queue, &vertices, &[[0, 1, 2], [0, 3, 2], [0, 1, 99]]);
    let ghost = offscreen.render(&bare([80, 80])).unwrap();
    let solid = offscreen.render(&Frame { input_style: InputStyle::Solid, ..bare([80, 80]) }).unwrap();
    let (g, s) = (ghost.get_pixel(40, 42)[0], solid.get_pixel(40, 42)[0]);
    assert!(g > 2 && g < 60 && s > 120, "{g} {s}");
}

#[test]
fn lines_have_their_width_and_survive_behind_the_camera() {
    let Some(mut offscreen) = offscreen(4) else { return };
    let line = |from, to| LineSegment { from, to, color: [255, 255, 255, 255], width: 5.0 };
    let lines = [line([0.0, -5.0, 0.0], [0.0, 5.0, 0.0]), line([0.3, 0.0, 0.0], [0.3, 0.0, 90.0])];
    let (renderer, device, queue) = offscreen.parts();
    renderer.set_lines(device, queue, &lines);
    let picture = offscreen.render(&bare([100, 100])).unwrap();
    // The sum over a row of pixels, edges and all, is the width.
    let width = (0..60).map(|x| f32::from(picture.get_pixel(x, 20)[0]) / 255.0).sum::<f32>();
    assert!((width - 5.0).abs() < 0.3, "{width}");
}

/// Shapes and points like those of a run, for the eye: small ones in the
/// temporary folder, large ones in the folder that SUPERFORM_PICTURES names.
#[test]
fn a_chair_in_all_styles_and_themes() {
    let Some(mut offscreen) = offscreen(4) else { return };
    let (folder, size) = match std::env::var_os("SUPERFORM_PICTURES") {
        Some(folder) => (std::path::PathBuf::from(folder), [1280, 800]),
        None => (std::env::temp_dir().join("superform-pictures"), [480, 300]),
    };
    std::fs::create_dir_all(&folder).unwrap();
    let primitives = chair();
    let mut points = Vec::new();
    let mut colors = Vec::new();
    let areas: f64 = primitives.iter().map(|p| superform::geometry::tessellate::surface_area(&p.shape)).sum();
    for primitive in &primitives {
        for (p, n) in surface_samples(&primitive.shape, (areas / 3500.0).sqrt(), 10_000) {
            let jitter = ((points.len() * 7919) % 101) as f64 / 101.0 - 0.5;
            points.push((p + n * 0.006 * jitter).coords.map(|c| c as f32).into());
            colors.push(primitive.color);
        }
    }
    set_points(&mut offscreen, &points, &colors);
    set_primitives(&mut offscreen, &primitives);
    let close = Frame {
        pixels_per_point: 2.0,
        surface_style: SurfaceStyle::Solid,
        camera: CameraMatrices::perspective(
            Vec3::new(0.6, 0.5, 0.9),
            Vec3::new(0.05, 0.0, 0.05),
            Vec3::Y,
            0.62,
            1.6,
            0.01,
        ),
        ..Frame::new(size, camera(size))
    };
    offscreen.render(&close).unwrap().save(folder.join("chair-close.png")).unwrap();
    let eye = Vec3::new(1.25, 0.85, 1.9);
    let camera = CameraMatrices::perspective(eye, Vec3::new(0.0, -0.04, 0.0), Vec3::Y, 0.62, 1.6, 0.01);
    for (theme_name, theme) in [("dark", SceneTheme::dark()), ("light", SceneTheme::light())] {
        for (style_name, surface_style, points) in [
            ("solid", SurfaceStyle::Solid, false),
            ("solid-points", SurfaceStyle::Solid, true),
            ("translucent", SurfaceStyle::Translucent, true),
            ("wire", SurfaceStyle::Wire, true),
            ("points", SurfaceStyle::Wire, true),
        ] {
            let layers = Layers { points, primitives: style_name != "points", ..Layers::default() };
            let frame = Frame { theme, surface_style, layers, ..Frame::new(size, camera) };
            let picture = offscreen.render(&frame).unwrap();
            picture.save(folder.join(format!("chair-{theme_name}-{style_name}.png"))).unwrap();
            let background = offscreen
                .render(&Frame { layers: Layers { points: false, primitives: false, ..layers }, ..frame })
                .unwrap();
            let changed = picture.pixels().zip(background.pixels()).filter(|(a, b)| a != b).count();
            assert!(
                changed > (size[0] * size[1] / 30) as usize,
                "{theme_name} {style_name}: {changed} pixels"
            );
        }
    }
}

/// Twelve parts: seat, back rest, legs, rails, a cushion, tapered feet.
fn chair() -> Vec<PrimitiveInstance> {
    let palette: [[u8; 3]; 12] = [
        [78, 121, 167],
        [242, 142, 43],
        [225, 87, 89],
        [118, 183, 178],
        [89, 161, 79],
        [237, 201, 72],
        [176, 122, 161],
        [255, 157, 167],
        [156, 117, 95],
        [186, 176, 172],
        [55, 154, 190],
        [150, 200, 90],
    ];
    let part = |eps: [f64; 2], axes: [f64; 3], at: [f64; 3], taper: [f64; 2], turn: [f64; 3]| Superquadric {
        exponents: eps,
        semi_axes: Vector3::from(axes),
        rotation: Rotation3::from_euler_angles(turn[0], turn[1], turn[2]),
        translation: Vector3::from(at),
        taper,
    };
    let up = -std::f64::consts::FRAC_PI_2;
    let shapes = [
        part([0.1, 0.1], [0.25, 0.25, 0.022], [0.0, -0.02, 0.0], [0.0; 2], [up, 0.0, 0.0]),
        part([0.1, 0.3], [0.24, 0.2, 0.018], [0.0, 0.27, -0.24], [0.0; 2], [-0.12, 0.0, 0.0]),
        part([0.1, 1.0], [0.024, 0.024, 0.22], [-0.21, -0.26, 0.21], [0.35, 0.35], [up, 0.0, 0.0]),
        part([0.1, 1.0], [0.024, 0.024, 0.22], [0.21, -0.26, 0.21], [0.35, 0.35], [up, 0.0, 0.0]),
        part([0.1, 0.1], [0.022, 0.022, 0.22], [-0.21, -0.26, -0.21], [0.35, 0.35], [up, 0.0, 0.0]),
        part([0.1, 0.1], [0.022, 0.022, 0.22], [0.21, -0.26, -0.21], [0.35, 0.35], [up, 0.0, 0.0]),
        part([0.1, 1.0], [0.014, 0.014, 0.2], [0.0, -0.36, 0.21], [0.0; 2], [0.0, up, 0.0]),
        part([0.1, 1.0], [0.014, 0.014, 0.2], [0.0, -0.36, -0.21], [0.0; 2], [0.0, up, 0.0]),
        part([0.7, 0.6], [0.2, 0.2, 0.045], [0.0, 0.035, 0.02], [0.0; 2], [up, 0.0, 0.0]),
        part([1.0, 1.0], [0.07, 0.07, 0.07], [-0.02, 0.145, 0.02], [0.0; 2], [0.0; 3]),
        part([0.1, 1.0], [0.06, 0.06, 0.09], [0.62, -0.42, 0.05], [-1.0, -1.0], [up, 0.0, 0.0]),
        part([1.6, 1.6], [0.12, 0.12, 0.12], [-0.62, -0.38, 0.1], [0.0; 2], [up, 0.4, 0.0]),
    ];
    let instance = |(i, shape): (usize, Superquadric)| PrimitiveInstance {
        id: i as u32,
        shape,
        color: [palette[i][0], palette[i][1], palette[i][2], 255],
        visible: true,
        highlight: if i == 8 { Highlight::Selected } else { Highlight::None },
        ghost: false,
    };
    shapes.into_iter().enumerate().map(instance).collect()
}

#[test]
fn rays_and_projection_undo_each_other() {
    let size = [640, 480];
    let eye = Vec3::new(1.0, 2.0, 3.0);
    let cameras = [
        CameraMatrices::perspective(eye, Vec3::ZERO, Vec3::Y, 0.7, 4.0 / 3.0, 0.01),
        CameraMatrices::orthographic(eye, Vec3::ZERO, Vec3::Y, 2.0, 4.0 / 3.0, -10.0, 10.0),
    ];
    for camera in cameras {
        assert!((camera.eye() - eye).length() < 1e-5);
        assert!((camera.forward() + eye.normalize()).length() < 1e-5);
        for pixel in [Vec2::new(0.0, 0.0), Vec2::new(320.0, 240.0), Vec2::new(600.5, 33.25)] {
            let ray = camera.ray(pixel, size);
            let back = camera.project(ray.origin + ray.direction * 2.5, size);
            if !camera.is_orthographic() {
                assert!((back.unwrap() - pixel).length() < 0.01, "{back:?} {pixel}");
            }
            let back = camera.project(ray.origin + ray.direction * 102.0, size).unwrap();
            assert!((back - pixel).length() < 0.01, "{back:?} {pixel}");
        }
        let right = camera.view_from_world.inverse().x_axis.truncate();
        let step = camera.units_per_pixel(Vec3::ZERO, size[1]);
        let [a, b] = [Vec3::ZERO, right * step].map(|p| camera.project(p, size).unwrap());
        assert!(((b - a).length() - 1.0).abs() < 1e-3);
    }
}

/// Ghosts, painted surfaces, lit and selected ones, selected points, for the eye
/// and by the colours that must be there.
#[test]
fn what_stands_out_has_its_colour() {
    let Some(mut offscreen) = offscreen(4) else { return };
    let grey = [120, 120, 120, 255];
    let lit = PrimitiveInstance { highlight: Highlight::Lit, ..sphere(1, [-0.6, 0.25, 0.0], 0.28, grey) };
    let painted = sphere(2, [0.0, 0.25, 0.0], 0.28, grey);
    let ghost = PrimitiveInstance { ghost: true, ..sphere(1, [0.6, 0.25, 0.0], 0.28, grey) };
    set_primitives(&mut offscreen, &[lit, painted, ghost]);
    let vertices = superform::geometry::tessellate::Resolution::SCREEN.vertices();
    let paint = |colors| superform::render::SurfacePaint { id: 2, colors };
    let (renderer, device, queue) = offscreen.parts();
    renderer.set_paint(device, queue, &[paint(vec![[0, 90, 255, 255]; vertices])]);
    let points: Vec<[f32; 3]> = (0..12).map(|i| [-0.7 + 0.12 * i as f32, -0.4, 0.0]).collect();
    let colors: Vec<[u8; 4]> = (0..12).map(|i| [90, 200, 90, if i % 2 == 0 { 128 } else { 255 }]).collect();
    set_points(&mut offscreen, &points, &colors);
    let size = [420, 260];
    let frame = Frame { point_size: 9.0, surface_style: SurfaceStyle::Solid, ..bare(size) };
    let picture = offscreen.render(&frame).unwrap();
    if let Some(folder) = std::env::var_os("SUPERFORM_PICTURES") {
        std::fs::create_dir_all(&folder).unwrap();
        picture.save(std::path::Path::new(&folder).join("stands-out.png")).unwrap();
    }
    let theme = frame.theme;
    let near = |p: &image::Rgba<u8>, c: [f32; 4], tolerance: f32| {
        (0..3).all(|k| (f32::from(p[k]) / 255.0 - c[k]).abs() < tolerance)
    };
    let count = |test: &dyn Fn(&image::Rgba<u8>) -> bool,
                 x: std::ops::Range<u32>,
                 y: std::ops::Range<u32>| {
        x.flat_map(|x| y.clone().map(move |y| (x, y))).filter(|&(x, y)| test(picture.get_pixel(x, y))).count()
    };
    let at = |x: f32, y: f32| frame.camera.project(Vec3::new(x, y, 0.0), size).unwrap();
    let (left, right) = (at(-0.3, 0.0).x as u32, at(0.3, 0.0).x as u32);
    let floor = at(0.0, -0.2).y as u32;
    assert!(count(&|p| near(p, theme.lit, 0.1), 0..left, 0..floor) > 40, "an outline");
    let blue = count(&|p| p[2] > 120 && p[0] < 110, left..right, 0..floor);
    let area = count(&|p| p[3] > 200 && p[0].max(p[2]) > 30, left..right, 0..floor);
    assert!(blue * 10 > area * 8 && area > 1000, "{blue} of {area} are painted");
    let ghostly = count(&|p| p[0] > p[2].saturating_add(40), right..size[0], 0..floor);
    assert!(ghostly > 300, "{ghostly}");
    let chosen = count(&|p| near(p, theme.selected, 0.12), 0..size[0], floor..size[1]);
    let others = count(&|p| p[1] > p[0].saturating_add(40), 0..size[0], floor..size[1]);
    assert!(chosen > 100 && others > 100, "{chosen} selected, {others} not");
    // Paint of another length, and of a shape that has changed, is none.
    let (renderer, device, queue) = offscreen.parts();
    renderer.set_paint(device, queue, &[paint(vec![[0, 90, 255, 255]; 3])]);
    let plain = offscreen.render(&frame).unwrap();
    let c = at(0.0, 0.25);
    let p = plain.get_pixel(c.x as u32, c.y as u32);
    assert!(p[0].abs_diff(p[2]) < 12, "{p:?}");
}
