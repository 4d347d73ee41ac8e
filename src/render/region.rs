//! What lies within a box or a line drawn around it on the screen.

use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::frame::{Frame, PrimitiveInstance};
use super::picking::{self, PickScene, point_radius};
use crate::geometry::tessellate::{Resolution, surface_vertices};

/// Points of a primitive's surface that are looked at.
const SURFACE: Resolution = Resolution { profile: 10, section: 10 };
/// Points a task.
const CHUNK: usize = 1 << 14;
/// Pixels along the side of a cell of the map of what is in front.
const CELL: f32 = 3.0;

/// A part of the screen, in physical pixels, y down.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    /// Two opposite corners.
    Box(Vec2, Vec2),
    /// The corners of a closed line. What it goes around an even number of
    /// times is outside.
    Lasso(Vec<Vec2>),
}

/// The pixels of a region, so that a point is looked up and not computed.
#[derive(Debug)]
struct Mask {
    low: Vec2,
    high: Vec2,
    /// Of a lasso: whether each pixel of the box is inside, row by row.
    pixels: Option<(usize, Vec<bool>)>,
}

impl Mask {
    /// `None` where the region has no pixel within a picture of `size`.
    fn new(region: &Region, size: Vec2) -> Option<Self> {
        let corners: Vec<Vec2> = match region {
            Region::Box(a, b) => vec![*a, *b],
            Region::Lasso(corners) => corners.iter().copied().filter(|c| c.is_finite()).collect(),
        };
        let least = corners.iter().copied().reduce(Vec2::min)?;
        let most = corners.iter().copied().reduce(Vec2::max)?;
        let (low, high) = (least.max(Vec2::ZERO), most.min(size));
        if !(low.x < high.x && low.y < high.y) {
            return None;
        }
        let pixels = matches!(region, Region::Lasso(_)).then(|| {
            let [width, height] = (high - low).ceil().as_uvec2().to_array().map(|n| n.max(1) as usize);
            let mut inside = vec![false; width * height];
            for (row, line) in inside.chunks_mut(width).enumerate() {
                fill(line, &corners, low + Vec2::new(0.0, row as f32 + 0.5));
            }
            (width, inside)
        });
        Some(Self { low, high, pixels })
    }

    fn contains(&self, pixel: Vec2) -> bool {
        // Comparisons that are false where there is no number.
        let in_box = pixel.x >= self.low.x
            && pixel.y >= self.low.y
            && pixel.x <= self.high.x
            && pixel.y <= self.high.y;
        in_box
            && self.pixels.as_ref().is_none_or(|(width, inside)| {
                let [x, y] = (pixel - self.low).to_array().map(|c| c as usize);
                inside.get(y * width + x.min(width - 1)).copied().unwrap_or(false)
            })
    }

    /// A pixel inside, as near to the middle as there is one.
    fn middle(&self) -> Option<Vec2> {
        let center = 0.5 * (self.low + self.high);
        if self.contains(center) {
            return Some(center);
        }
        let (width, inside) = self.pixels.as_ref()?;
        let places = inside.iter().enumerate().filter(|(_, is_in)| **is_in);
        places
            .map(|(i, _)| self.low + Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5))
            .min_by(|a, b| a.distance_squared(center).total_cmp(&b.distance_squared(center)))
    }
}

/// Marks the pixels of one row that the closed line goes around an odd number
/// of times; `start` is the row's left end, at half its height.
fn fill(line: &mut [bool], corners: &[Vec2], start: Vec2) {
    let mut crossings: Vec<f32> = corners
        .iter()
        .zip(corners.iter().cycle().skip(1))
        .filter(|(a, b)| (a.y <= start.y) != (b.y <= start.y))
        .map(|(a, b)| a.x + (start.y - a.y) / (b.y - a.y) * (b.x - a.x) - start.x)
        .collect();
    crossings.sort_by(f32::total_cmp);
    for pair in crossings.as_chunks::<2>().0 {
        // The pixels whose centres lie between.
        let [from, to] = pair.map(|x| (x + 0.5).max(0.0) as usize);
        if let Some(between) = line.get_mut(from..to.min(line.len()).max(from)) {
            between.fill(true);
        }
    }
}

/// The rows of the projection to pixels: x·w, y·w and w of a scene point.
#[derive(Debug, Clone, Copy)]
struct Projection([Vec4; 3]);

impl Projection {
    fn new(frame: &Frame) -> Self {
        let clip = frame.camera.clip_from_world();
        let [x, y, w] = [clip.row(0), clip.row(1), clip.row(3)];
        let half = 0.5 * Vec2::new(frame.size_px[0] as f32, frame.size_px[1] as f32);
        Self([(w + x) * half.x, (w - y) * half.y, w])
    }

    /// Not a number behind the camera.
    fn pixel(&self, p: Vec3) -> Vec2 {
        let [x, y, w] = self.0.map(|row| row.truncate().dot(p) + row.w);
        if w > 0.0 { Vec2::new(x, y) / w } else { Vec2::NAN }
    }
}

/// Depth along the view of the nearest thing in each cell of a region.
struct DepthMap {
    low: Vec2,
    width: usize,
    nearest: Vec<f32>,
}

impl DepthMap {
    fn new(scene: &PickScene<'_>, frame: &Frame, mask: &Mask, projection: Projection) -> Self {
        let [width, height] =
            ((mask.high - mask.low) / CELL).ceil().as_uvec2().to_array().map(|n| n.max(1) as usize);
        let mut map = Self { low: mask.low, width, nearest: vec![f32::INFINITY; width * height] };
        let depth_row = -frame.camera.view_from_world.row(2);
        if frame.layers.primitives && frame.surface_style == super::SurfaceStyle::Solid {
            map.nearest = (0..width * height)
                .into_par_iter()
                .map(|i| {
                    let cell = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
                    let ray = frame.camera.ray(mask.low + cell * CELL, frame.size_px);
                    let depth =
                        |t: f64| depth_row.dot(Vec4::from((ray.origin + ray.direction * t as f32, 1.0)));
                    scene
                        .primitives
                        .iter()
                        .filter(|p| p.visible && !p.ghost)
                        .filter_map(|p| picking::hit(&p.shape, &ray))
                        .map(depth)
                        .fold(f32::INFINITY, f32::min)
                })
                .collect();
        }
        if frame.layers.points {
            for (i, p) in scene.points.iter().enumerate() {
                let p = Vec3::from_array(*p);
                let place = ((projection.pixel(p) - mask.low) / CELL).floor();
                if !(place.x >= 0.0 && place.y >= 0.0 && place.x < width as f32 && place.y < height as f32)
                    || scene.point_colors.get(i).is_some_and(|c| c[3] == 0)
                {
                    continue;
                }
                let cell = &mut map.nearest[place.y as usize * width + place.x as usize];
                *cell = cell.min(depth_row.dot(Vec4::from((p, 1.0))));
            }
        }
        map
    }

    /// Whether nothing hides a thing of this depth; `slack` is how much it
    /// stands out.
    fn shows(&self, pixel: Vec2, depth: f32, slack: f32) -> bool {
        let place = ((pixel - self.low) / CELL).max(Vec2::ZERO);
        let x = (place.x as usize).min(self.width - 1);
        self.nearest.get(place.y as usize * self.width + x).is_none_or(|nearest| depth <= nearest + slack)
    }
}

/// Indices of the points that are drawn within the region, ascending; with
/// `visible_only` without those that something else hides.
pub fn points_within(scene: &PickScene<'_>, frame: &Frame, region: &Region, visible_only: bool) -> Vec<u32> {
    let size = Vec2::new(frame.size_px[0] as f32, frame.size_px[1] as f32);
    let Some(mask) = Mask::new(region, size).filter(|_| frame.layers.points) else { return Vec::new() };
    let projection = Projection::new(frame);
    let map = visible_only.then(|| DepthMap::new(scene, frame, &mask, projection));
    let depth_row = -frame.camera.view_from_world.row(2);
    let is_within = |i: usize, p: &[f32; 3]| {
        let p = Vec3::from_array(*p);
        let pixel = projection.pixel(p);
        if !mask.contains(pixel) || scene.point_colors.get(i).is_some_and(|c| c[3] == 0) {
            return false;
        }
        map.as_ref().is_none_or(|map| {
            let depth = depth_row.dot(Vec4::from((p, 1.0)));
            let slack =
                (2.0 * point_radius(frame, depth) + CELL) * frame.camera.units_per_pixel(p, frame.size_px[1]);
            map.shows(pixel, depth, slack)
        })
    };
    let chunks = scene.points.par_chunks(CHUNK).enumerate().map(|(k, chunk)| {
        let within = chunk.iter().enumerate().filter(|(i, p)| is_within(k * CHUNK + i, p));
        within.map(|(i, _)| (k * CHUNK + i) as u32).collect::<Vec<_>>()
    });
    chunks.collect::<Vec<_>>().concat()
}

/// Ids of the primitives whose drawn bodies reach into the region, in their
/// order; with `visible_only` those of which something else hides all that
/// does are left out.
pub fn primitives_within(
    scene: &PickScene<'_>,
    frame: &Frame,
    region: &Region,
    visible_only: bool,
) -> Vec<u32> {
    let size = Vec2::new(frame.size_px[0] as f32, frame.size_px[1] as f32);
    let Some(mask) = Mask::new(region, size).filter(|_| frame.layers.primitives) else { return Vec::new() };
    let projection = Projection::new(frame);
    // A primitive is not to be hidden by its own points.
    let solid = Frame {
        surface_style: super::SurfaceStyle::Solid,
        layers: super::Layers { points: false, ..frame.layers },
        ..*frame
    };
    let map = visible_only.then(|| DepthMap::new(scene, &solid, &mask, projection));
    let depth_row = -frame.camera.view_from_world.row(2);
    // A region within one body holds none of the points of its surface.
    let middle = mask.middle().map(|pixel| frame.camera.ray(pixel, frame.size_px));
    let reaches_in = |primitive: &&PrimitiveInstance| {
        let on_surface = |p: Vec3| {
            let pixel = projection.pixel(p);
            let shows = || {
                map.as_ref().is_none_or(|map| {
                    let slack = 2.0 * CELL * frame.camera.units_per_pixel(p, frame.size_px[1]);
                    map.shows(pixel, depth_row.dot(Vec4::from((p, 1.0))), slack)
                })
            };
            mask.contains(pixel) && shows()
        };
        surface_vertices(&primitive.shape, SURFACE)
            .any(|(p, _)| on_surface(Vec3::new(p.x as f32, p.y as f32, p.z as f32)))
            || middle.as_ref().is_some_and(|ray| {
                picking::hit(&primitive.shape, ray)
                    .is_some_and(|t| on_surface(ray.origin + ray.direction * t as f32))
            })
    };
    let drawn: Vec<_> =
        scene.primitives.iter().filter(|p| p.visible && !p.ghost && p.shape.is_valid()).collect();
    drawn.into_par_iter().filter(reaches_in).map(|p| p.id).collect()
}
