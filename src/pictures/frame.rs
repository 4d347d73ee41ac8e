//! Everything but the data that decides how a picture looks: the same for the
//! window and for pictures without one.

use crate::render::{CameraMatrices, Frame, Grid, Layers, SceneTheme, SurfaceStyle};
use crate::session::camera::Camera;
use crate::session::scalar::round_down;
use crate::session::scene::SceneFromInput;
use crate::session::view::{self, ColorBy, Layer, View};

/// The frame of a picture of any size. `pixels_per_point` is what sizes of
/// points and lines are multiplied with.
pub fn sized(
    view: &View,
    scene: &SceneFromInput,
    camera: &Camera,
    size_px: [u32; 2],
    pixels_per_point: f32,
    theme: SceneTheme,
) -> Frame {
    let aspect = size_px[0].max(1) as f32 / size_px[1].max(1) as f32;
    Frame {
        pixels_per_point,
        layers: Layers {
            input: view.shows(Layer::Input),
            // What is told on the surfaces is not hidden behind points.
            points: view.shows(Layer::Points) && view.color_by != ColorBy::SurfaceDistance,
            primitives: view.shows(Layer::Primitives),
            grid: view.shows(Layer::Grid),
            lines: false,
        },
        surface_style: match view.surface_style {
            view::SurfaceStyle::Solid => SurfaceStyle::Solid,
            view::SurfaceStyle::Translucent => SurfaceStyle::Translucent,
            view::SurfaceStyle::Wire => SurfaceStyle::Wire,
        },
        point_size: view.point_size,
        grid: grid(scene),
        theme,
        ..Frame::new(size_px, matrices(camera, aspect))
    }
}

/// Lines at round numbers of input units, about ten along the shape.
fn grid(scene: &SceneFromInput) -> Grid {
    let bounds = &scene.bounds;
    let spacing = cell(scene) * scene.scale();
    let radius = (2.2 * bounds.size().x.max(bounds.size().z)).clamp(0.8, 2.5);
    let mut grid = Grid::horizontal(bounds.min.y as f32, spacing as f32);
    // The input's coordinates that are 0 lie on lines.
    let zero = scene.point(&nalgebra::Point3::origin());
    grid.origin.x = (zero.x - (zero.x / spacing).round() * spacing) as f32;
    grid.origin.z = (zero.z - (zero.z / spacing).round() * spacing) as f32;
    grid.radius = radius as f32;
    grid
}

/// Length of a cell of the grid, in input units.
pub fn cell(scene: &SceneFromInput) -> f64 {
    round_down(0.13 / scene.scale())
}

fn matrices(camera: &Camera, aspect: f32) -> CameraMatrices {
    let vec3 = |v: [f64; 3]| glam::Vec3::from(v.map(|c| c as f32));
    let (eye, target) = (vec3(camera.eye().coords.into()), vec3(camera.target.coords.into()));
    let up = vec3(camera.up().into());
    if camera.orthographic {
        let height = 2.0 * camera.half_extent().y as f32;
        let far = 50.0 + 2.0 * camera.distance as f32;
        CameraMatrices::orthographic(eye, target, up, height, aspect, -50.0, far)
    } else {
        let near = (0.01 * camera.distance as f32).clamp(1e-5, 0.05);
        CameraMatrices::perspective(eye, target, up, camera.fov_y() as f32, aspect, near)
    }
}
