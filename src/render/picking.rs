//! What lies under a pixel, found on the CPU: points by their distance on the
//! screen, primitives by following the viewing ray through their body.

use glam::{Vec2, Vec3, Vec4};
use nalgebra::{Point3, Vector3};

use super::frame::{Frame, PrimitiveInstance, Ray, SurfaceStyle};
use super::point_index::PointIndex;
use crate::geometry::Superquadric;

/// A point may be missed by this many logical pixels.
const TOLERANCE: f32 = 3.0;
/// How much a near point can be larger than the frame's point size; the same
/// as in points.wgsl.
const LARGEST: f32 = 3.0;
/// Steps of the way through a primitive's box.
const STEPS: u32 = 64;

/// The thing under the pointer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PickId {
    /// Index into [`PickScene::points`].
    Point(usize),
    /// Id of a primitive.
    Primitive(u32),
}

/// A hit, nearest to the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pick {
    pub id: PickId,
    /// Where the thing was hit, in scene space: the pivot of a double-click.
    pub position: Vec3,
}

/// What can be hit. Borrowed from whoever uploads the same to the renderer.
#[derive(Debug, Clone, Copy, Default)]
pub struct PickScene<'a> {
    pub points: &'a [[f32; 3]],
    /// One a point, or empty; points of alpha 0 are not hit.
    pub point_colors: &'a [[u8; 4]],
    /// That of the points: without it all of them are looked at.
    pub point_index: Option<&'a PointIndex>,
    pub primitives: &'a [PrimitiveInstance],
}

/// What `frame` shows at the pixel position `pixel` (physical pixels, y down):
/// the nearest point or primitive of the visible layers, `None` for the
/// background. A primitive drawn as wires is hit where its surface would be,
/// but lets points behind it be hit.
pub fn pick(scene: &PickScene<'_>, frame: &Frame, pixel: Vec2) -> Option<Pick> {
    if frame.size_px.contains(&0) || !pixel.is_finite() {
        return None;
    }
    let ray = frame.camera.ray(pixel, frame.size_px);
    let depth = |position: Vec3| (position - ray.origin).dot(ray.direction);
    let primitive = if frame.layers.primitives { nearest_primitive(scene.primitives, &ray) } else { None };
    let point = if frame.layers.points { nearest_point(scene, frame, pixel) } else { None };
    match (primitive, point) {
        (Some(body), Some(point)) => {
            // A splat stands out of the surface that it lies on by its radius.
            let radius = 0.5 * frame.point_size * frame.pixels_per_point;
            let lift = 2.0 * radius * frame.camera.units_per_pixel(point.position, frame.size_px[1]);
            let through = frame.surface_style == SurfaceStyle::Wire;
            let in_front = depth(point.position) - lift <= depth(body.position);
            Some(if through || in_front { point } else { body })
        }
        (body, point) => body.or(point),
    }
}

/// Radius of a point that is drawn at a depth along the view, in pixels; as
/// points.wgsl has it.
pub(super) fn point_radius(frame: &Frame, depth: f32) -> f32 {
    let radius = 0.5 * frame.point_size * frame.pixels_per_point.max(0.25);
    let reference = (-frame.camera.view_from_world.w_axis.z).max(0.3);
    let growth = if frame.camera.is_orthographic() {
        1.0
    } else {
        (reference / depth.max(1e-6)).sqrt().clamp(0.4, LARGEST)
    };
    (radius * growth).max(0.5)
}

/// The point nearest to the camera of those drawn over the pixel; failing
/// that, of those within the tolerance.
fn nearest_point(scene: &PickScene<'_>, frame: &Frame, pixel: Vec2) -> Option<Pick> {
    let size = Vec2::new(frame.size_px[0] as f32, frame.size_px[1] as f32);
    let scale = frame.pixels_per_point.max(0.25);
    let radius = 0.5 * frame.point_size * scale;
    let clip_from_world = frame.camera.clip_from_world();
    let [row_x, row_y, row_z, row_w] = [0, 1, 2, 3].map(|i| clip_from_world.row(i));
    let depth_row = -frame.camera.view_from_world.row(2);
    // Rows that give the pixel offset from the pointer, times w: no division
    // for the many points that are elsewhere.
    let ndc = Vec2::new(2.0 * pixel.x / size.x - 1.0, 1.0 - 2.0 * pixel.y / size.y);
    let x = (row_x - row_w * ndc.x) * (0.5 * size.x);
    let y = (row_y - row_w * ndc.y) * (0.5 * size.y);
    let reach = (radius * LARGEST).max(TOLERANCE * scale) + 0.5;

    // Best of the points over the pixel, and of those that nearly are.
    let (mut over, mut near) = ((f32::INFINITY, None::<usize>), (f32::INFINITY, None));
    let mut look = |i: usize| {
        let Some(&[px, py, pz]) = scene.points.get(i) else { return };
        let along = |row: Vec4| row.x * px + row.y * py + row.z * pz + row.w;
        let w = along(row_w);
        let (dx, dy) = (along(x), along(y));
        let limit = reach * w;
        // The comparisons are false for a point that is not finite.
        if !(w > 0.0 && dx.abs() <= limit && dy.abs() <= limit) {
            return;
        }
        if scene.point_colors.get(i).is_some_and(|c| c[3] == 0) {
            return;
        }
        // In front of the near plane (reversed depth: z > w) nothing is drawn.
        if along(row_z) > w {
            return;
        }
        let depth = along(depth_row);
        let distance = dx.hypot(dy) / w;
        let best = if distance <= point_radius(frame, depth) + 0.5 {
            &mut over
        } else if distance <= TOLERANCE * scale {
            &mut near
        } else {
            return;
        };
        if depth < best.0 || (depth == best.0 && best.1.is_some_and(|other| i < other)) {
            *best = (depth, Some(i));
        }
    };
    match scene.point_index {
        Some(index) => {
            let limit = row_w * reach;
            index.within([row_w, limit - x, limit + x, limit - y, limit + y]).for_each(&mut look);
        }
        None => (0..scene.points.len()).for_each(&mut look),
    }
    over.1.or(near.1).map(|i| Pick { id: PickId::Point(i), position: Vec3::from_array(scene.points[i]) })
}

fn nearest_primitive(primitives: &[PrimitiveInstance], ray: &Ray) -> Option<Pick> {
    primitives
        .iter()
        .filter(|p| p.visible && !p.ghost && p.shape.is_valid())
        .filter_map(|p| Some((hit(&p.shape, ray)?, p.id)))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(t, id)| Pick { id: PickId::Primitive(id), position: ray.origin + ray.direction * t as f32 })
}

/// Distance along the ray to the first point on the body.
pub(super) fn hit(shape: &Superquadric, ray: &Ray) -> Option<f64> {
    let origin = Point3::from(ray.origin.as_dvec3().to_array());
    let direction = Vector3::from(ray.direction.as_dvec3().to_array());
    let local_origin = shape.local(&origin);
    let local_direction = shape.rotation.inverse() * direction;
    let half = shape.half_extents();
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let (o, d) = (local_origin[axis], local_direction[axis]);
        // Half-extents a little larger: `half_extents` is sampled.
        let h = 1.001 * half[axis];
        if d.abs() < 1e-12 {
            if o.abs() > h {
                return None;
            }
            continue;
        }
        let (a, b) = ((-h - o) / d, (h - o) / d);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    if enter > leave {
        return None;
    }
    let inside = |t: f64| shape.contains(&(origin + direction * t));
    let mut outside = enter;
    for k in 0..=STEPS {
        let t = enter + (leave - enter) * f64::from(k) / f64::from(STEPS);
        if inside(t) {
            let mut body = t;
            for _ in 0..40 {
                let middle = 0.5 * (outside + body);
                if inside(middle) {
                    body = middle;
                } else {
                    outside = middle;
                }
            }
            return Some(body);
        }
        outside = t;
    }
    None
}
