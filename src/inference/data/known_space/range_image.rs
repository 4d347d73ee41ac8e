//! How far each line of sight from a viewpoint is free.

use nalgebra::{Matrix3, Point3, Vector3};

use super::viewpoint::Viewpoint;

/// Mean spacings that a pixel is wide where the cloud is.
const PIXEL: f64 = 0.5;
/// Pixels along an edge at most: of an image from outside, and of each of the
/// six that surround a viewpoint.
const LARGEST: f64 = 512.0;
const LARGEST_OF_SIX: f64 = 256.0;
/// The field of view of an image from outside ends here, in tangents: about 75°
/// to each side.
const WIDEST: f64 = 4.0;

/// All lines of sight from one viewpoint.
#[derive(Debug)]
pub(super) struct View {
    pub(super) viewpoint: Viewpoint,
    images: Vec<RangeImage>,
    /// Range up to which a line of sight that meets no point is free.
    without_return: f64,
    /// The box of the cloud.
    low: Point3<f64>,
    high: Point3<f64>,
}

/// A plane image: the range at which each pixel's line of sight comes near to
/// the cloud first.
#[derive(Debug)]
struct RangeImage {
    /// Rows: right, up, forward.
    axes: Matrix3<f64>,
    low: [f64; 2],
    pixel: f64,
    size: [usize; 2],
    range: Vec<f32>,
}

impl View {
    /// The cloud as spheres of radius `clearance`, seen from the viewpoint.
    pub(super) fn new(viewpoint: &Viewpoint, points: &[Point3<f64>], spacing: f64, clearance: f64) -> Self {
        let first = points.first().copied().unwrap_or_default();
        let (low, high) = points.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
        let center = nalgebra::center(&low, &high);
        let is_inside = match viewpoint {
            Viewpoint::Place(eye) => (0..3).all(|a| eye[a] >= low[a] && eye[a] <= high[a]),
            Viewpoint::Direction(_) => false,
        };
        let forward = -viewpoint.direction_from(&center);
        let axes: Vec<Matrix3<f64>> = if is_inside {
            let all = [Vector3::x(), Vector3::y(), Vector3::z()];
            all.into_iter().flat_map(|a| [a, -a]).map(|forward| frame(&forward)).collect()
        } else {
            vec![frame(&forward)]
        };
        let mut view = Self {
            viewpoint: *viewpoint,
            images: Vec::new(),
            without_return: if is_inside { f64::NEG_INFINITY } else { f64::INFINITY },
            low,
            high,
        };
        for axes in axes {
            view.images.push(view.image(axes, points, spacing, clearance, is_inside));
        }
        view
    }

    fn image(
        &self,
        axes: Matrix3<f64>,
        points: &[Point3<f64>],
        spacing: f64,
        clearance: f64,
        is_one_of_six: bool,
    ) -> RangeImage {
        let seen: Vec<([f64; 2], f64)> = points.iter().filter_map(|p| self.project(&axes, p)).collect();
        let mut ranges: Vec<f64> = seen.iter().map(|s| s.1).collect();
        ranges.sort_unstable_by(f64::total_cmp);
        let typical = ranges.get(ranges.len() / 2).copied().unwrap_or(1.0).max(spacing);
        let is_parallel = matches!(self.viewpoint, Viewpoint::Direction(_));
        let unit = if is_parallel { 1.0 } else { 1.0 / typical };
        let (mut low, mut high) = ([-1.0; 2], [1.0; 2]);
        if !is_one_of_six {
            let margin = 2.0 * clearance * unit;
            for a in 0..2 {
                let most = if is_parallel { f64::INFINITY } else { WIDEST };
                let least_of = seen.iter().map(|s| s.0[a]).fold(f64::INFINITY, f64::min);
                let most_of = seen.iter().map(|s| s.0[a]).fold(f64::NEG_INFINITY, f64::max);
                low[a] = (least_of - margin).max(-most);
                high[a] = (most_of + margin).min(most);
            }
        }
        let longest = (high[0] - low[0]).max(high[1] - low[1]).max(f64::MIN_POSITIVE);
        let largest = if is_one_of_six { LARGEST_OF_SIX } else { LARGEST };
        let pixel = (PIXEL * spacing * unit).max(longest / largest);
        let size = [0, 1].map(|a| (((high[a] - low[a]) / pixel).ceil() as usize).max(1));
        let mut image = RangeImage { axes, low, pixel, size, range: vec![f32::INFINITY; size[0] * size[1]] };
        for p in points {
            self.splat(&mut image, p, clearance);
        }
        image
    }

    /// The image coordinates of a place and its range; none behind the viewer.
    fn project(&self, axes: &Matrix3<f64>, place: &Point3<f64>) -> Option<([f64; 2], f64)> {
        match self.viewpoint {
            Viewpoint::Place(eye) => {
                let q = axes * (place - eye);
                (q.z > 0.0).then(|| ([q.x / q.z, q.y / q.z], q.norm()))
            }
            Viewpoint::Direction(_) => {
                let q = axes * place.coords;
                Some(([q.x, q.y], q.z))
            }
        }
    }

    /// Lets a sphere end the lines of sight that enter it.
    fn splat(&self, image: &mut RangeImage, p: &Point3<f64>, radius: f64) {
        let Some((at, range)) = self.project(&image.axes, p) else { return };
        let is_parallel = matches!(self.viewpoint, Viewpoint::Direction(_));
        let stretch = 1.0 + at[0] * at[0] + at[1] * at[1];
        // A sphere about the viewer itself is no obstacle.
        if !is_parallel && range < 2.0 * radius {
            return;
        }
        let reach = if is_parallel { radius } else { 1.3 * stretch * radius / range };
        let from = [0, 1].map(|a| ((at[a] - reach - image.low[a]) / image.pixel).floor().max(0.0) as usize);
        let to = [0, 1].map(|a| {
            let last = ((at[a] + reach - image.low[a]) / image.pixel).floor() + 1.0;
            (last.max(0.0) as usize).min(image.size[a])
        });
        for y in from[1]..to[1] {
            for x in from[0]..to[0] {
                let u = image.low[0] + (x as f64 + 0.5) * image.pixel;
                let v = image.low[1] + (y as f64 + 0.5) * image.pixel;
                // The foot of the perpendicular from the centre to the line.
                let (foot, aside) = if is_parallel {
                    (range, (u - at[0]).powi(2) + (v - at[1]).powi(2))
                } else {
                    let cos = (1.0 + u * at[0] + v * at[1]) / ((1.0 + u * u + v * v) * stretch).sqrt();
                    (range * cos, range * range * (1.0 - cos * cos).max(0.0))
                };
                let inward = radius * radius - aside;
                if inward > 0.0 {
                    let entry = (foot - inward.sqrt()) as f32;
                    let known = &mut image.range[y * image.size[0] + x];
                    *known = known.min(entry);
                }
            }
        }
    }

    /// Range of a place, and that up to which its line of sight is free.
    fn ranges(&self, place: &Point3<f64>) -> Option<(f64, f64)> {
        for image in &self.images {
            let Some((at, range)) = self.project(&image.axes, place) else { continue };
            let cell = [0, 1].map(|a| ((at[a] - image.low[a]) / image.pixel).floor());
            if (0..2).all(|a| cell[a] >= 0.0 && cell[a] < image.size[a] as f64) {
                let free = f64::from(image.range[cell[1] as usize * image.size[0] + cell[0] as usize]);
                return Some((range, if free.is_finite() { free } else { self.without_return }));
            }
        }
        None
    }

    pub(super) fn is_free(&self, place: &Point3<f64>) -> bool {
        match self.ranges(place) {
            Some((range, free)) => range < free,
            // Outside of the image nothing is behind the place.
            None => self.without_return > 0.0,
        }
    }

    /// The place at a share of the free part of the line of sight to a point,
    /// where that crosses the box of the cloud; none where no part is free.
    pub(super) fn free_place(&self, p: &Point3<f64>, share: f64) -> Option<Point3<f64>> {
        let (range, free) = self.ranges(p)?;
        let back = self.viewpoint.direction_from(p);
        // Backwards from the point to where the line leaves the box.
        let mut leaves = match self.viewpoint {
            Viewpoint::Place(_) => range,
            Viewpoint::Direction(_) => f64::INFINITY,
        };
        for a in 0..3 {
            let bound = if back[a] > 0.0 { self.high[a] } else { self.low[a] };
            if back[a] != 0.0 {
                leaves = leaves.min(((bound - p[a]) / back[a]).max(0.0));
            }
        }
        let begins = range - free;
        (leaves.is_finite() && begins < leaves).then(|| p + back * (begins + share * (leaves - begins)))
    }
}

/// Rows right, up, forward.
pub(super) fn frame(forward: &Vector3<f64>) -> Matrix3<f64> {
    let other = if forward.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let right = forward.cross(&other).normalize();
    let up = right.cross(forward);
    Matrix3::from_rows(&[right.transpose(), up.transpose(), forward.transpose()])
}
