//! From input units to scene space: centred, y up, the longest edge of the shape's bounding box of
//! length 1.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use rayon::prelude::*;

use super::camera::Bounds;
use super::scalar::Scalar;
use crate::geometry::palette::{Colors, UNASSIGNED_COLOR};
use crate::geometry::{NO_SAMPLE, Superquadric};
use crate::inference::UNASSIGNED;
use crate::io::ShapeGeometry;
use crate::worker::LoadedShape;

/// Axis of the input that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UpAxis {
    /// As in OBJ and glTF files.
    #[default]
    Y,
    /// As in most scans and CAD files.
    Z,
}

/// Colours of marked and unmarked points, which differ in lightness and, even
/// for colour-blind people, in hue.
const MARKED_COLOR: [u8; 3] = [255, 150, 0];
const UNMARKED_COLOR: [u8; 3] = [104, 112, 124];

/// Points without a value.
const PLAIN_COLOR: [u8; 3] = [198, 204, 212];

/// scene = scale · R · (input − center), R a turn that brings the up axis to y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneFromInput {
    center: Point3<f64>,
    scale: f64,
    rotation: Rotation3<f64>,
    /// The shape's box in scene units.
    pub bounds: Bounds,
}

impl SceneFromInput {
    /// Computes it from the box of the finite points; without extent, lengths are kept.
    pub fn fit(points: &[Point3<f64>], up: UpAxis) -> Self {
        let input = Bounds::around(points.iter().copied())
            .unwrap_or(Bounds { min: Point3::origin(), max: Point3::origin() });
        let longest = input.size().max();
        let scale = if longest.is_normal() { 1.0 / longest } else { 1.0 };
        let rotation = match up {
            UpAxis::Y => Rotation3::identity(),
            // (x, y, z) ↦ (x, z, −y)
            UpAxis::Z => Rotation3::from_matrix_unchecked(Matrix3::new(
                1.0, 0.0, 0.0, //
                0.0, 0.0, 1.0, //
                0.0, -1.0, 0.0,
            )),
        };
        let half = (rotation * (input.size() * (0.5 * scale))).abs();
        let bounds = Bounds { min: Point3::from(-half), max: Point3::from(half) };
        Self { center: input.center(), scale, rotation, bounds }
    }

    pub fn point(&self, input: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation * ((input - self.center) * self.scale))
    }

    pub fn shape(&self, input: &Superquadric) -> Superquadric {
        let center = self.point(&Point3::from(input.translation));
        Superquadric {
            semi_axes: input.semi_axes * self.scale,
            rotation: self.rotation * input.rotation,
            translation: center.coords,
            ..*input
        }
    }

    /// Inverse of [`SceneFromInput::shape`].
    pub fn shape_in_input(&self, scene: &Superquadric) -> Superquadric {
        let turned_back = self.rotation.inverse();
        let translation = turned_back * scene.translation / self.scale + self.center.coords;
        Superquadric {
            semi_axes: scene.semi_axes / self.scale,
            rotation: turned_back * scene.rotation,
            translation,
            ..*scene
        }
    }

    /// Centre of the shape's box, in input units.
    pub fn center(&self) -> Point3<f64> {
        self.center
    }

    /// Scene units per input unit.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The box of a primitive in scene units, from its local box.
    pub fn bounds_of(&self, input: &Superquadric) -> Option<Bounds> {
        let shape = self.shape(input);
        let h = shape.half_extents();
        let local = Bounds { min: Point3::from(-h), max: Point3::from(h) };
        Bounds::around(local.corners().map(|c| shape.rotation * c + shape.translation))
    }
}

/// Size of a box in input units for display: `1.2 × 0.8 × 0.8`.
pub fn extent_of(points: &[Point3<f64>]) -> Vector3<f64> {
    Bounds::around(points.iter().copied()).map_or_else(Vector3::zeros, |b| b.size())
}

/// The displayed points of a shape, in input units: all points of an input
/// cloud, or the samples of a mesh.
pub fn shown_points(loaded: &LoadedShape) -> &[Point3<f64>] {
    match (&loaded.shape.geometry, &loaded.cloud.sample_of_input) {
        (ShapeGeometry::Cloud(input), Some(_)) => &input.points,
        _ => &loaded.cloud.points,
    }
}

/// The sample of a displayed point; `None` for points without one, such as outliers.
pub fn sample_of_shown(loaded: &LoadedShape, shown: usize) -> Option<usize> {
    match &loaded.cloud.sample_of_input {
        Some(map) => map.get(shown).filter(|&&sample| sample != NO_SAMPLE).map(|&sample| sample as usize),
        None => Some(shown),
    }
}

/// The alpha that marks a selected point in the colours of points; 0 hides
/// one, 255 is the usual.
pub const SELECTED_ALPHA: u8 = 128;

/// What point colours show.
#[derive(Debug, Clone, Copy)]
pub enum Paint<'a> {
    /// The primitive of each, in these colours.
    Clusters(&'a Colors),
    /// The same, with all faded but some, by id.
    Lit(&'a Colors, &'a [u32]),
    /// Colours from the file; grey if there are none.
    Input,
    /// Nothing.
    Plain,
    /// A value for each sample, mapped to colours from [0, 1].
    Scalar(&'a Scalar, fn(f32) -> [u8; 3]),
    /// Whether each sample is marked.
    Marked(&'a [bool]),
}

/// The colours of the shown points, RGBA in sRGB encoding, as `paint` has it:
/// transparent where the sample's label is among `hidden`, grey where there is
/// nothing to tell, with [`SELECTED_ALPHA`] where the sample is `selected`, dark
/// where it is `pinned` (ascending indices, both).
pub fn shown_colors(
    loaded: &LoadedShape,
    labels: &[u32],
    hidden: &BTreeSet<u32>,
    selected: &[u32],
    pinned: &[u32],
    paint: Paint<'_>,
) -> Vec<[u8; 4]> {
    let [r, g, b] = UNASSIGNED_COLOR;
    let unassigned = [r, g, b, 255];
    let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 255];
    let color = |sample: usize| {
        let label = labels.get(sample).copied().unwrap_or(UNASSIGNED);
        if label != UNASSIGNED && !hidden.is_empty() && hidden.contains(&label) {
            return [0; 4];
        }
        match paint {
            Paint::Clusters(colors) if label != UNASSIGNED => opaque(colors.of(label)),
            Paint::Lit(colors, lit) if lit.contains(&label) => opaque(colors.of(label)),
            Paint::Lit(colors, _) if label != UNASSIGNED => opaque(faded(colors.of(label))),
            Paint::Scalar(scalar, map) => scalar.share(sample).map_or(unassigned, |share| opaque(map(share))),
            Paint::Plain => opaque(PLAIN_COLOR),
            Paint::Marked(marks) if marks.get(sample) == Some(&true) => opaque(MARKED_COLOR),
            Paint::Marked(_) => opaque(UNMARKED_COLOR),
            Paint::Clusters(_) | Paint::Lit(..) | Paint::Input => unassigned,
        }
    };
    let mut of_samples: Vec<[u8; 4]> =
        (0..loaded.cloud.points.len()).into_par_iter().with_min_len(1 << 14).map(color).collect();
    for &sample in pinned {
        if let Some([r, g, b, _]) = of_samples.get_mut(sample as usize) {
            [*r, *g, *b] = darkened([*r, *g, *b]);
        }
    }
    for &sample in selected {
        if let Some(c) = of_samples.get_mut(sample as usize).filter(|c| c[3] != 0) {
            c[3] = SELECTED_ALPHA;
        }
    }
    let in_file = match (&loaded.shape.geometry, paint) {
        (ShapeGeometry::Cloud(_), Paint::Input) => loaded.shape.attributes.colors.as_deref(),
        _ => None,
    };
    let Some(map) = &loaded.cloud.sample_of_input else { return of_samples };
    // A point without a sample is in range of nothing.
    let alone = if matches!(paint, Paint::Plain) { opaque(PLAIN_COLOR) } else { unassigned };
    (map, 0..map.len())
        .into_par_iter()
        .with_min_len(1 << 14)
        .map(|(&sample, i)| {
            let color = of_samples.get(sample as usize).copied().unwrap_or(alone);
            match in_file.and_then(|colors| colors.get(i)) {
                Some(&[r, g, b]) => [r, g, b, color[3]],
                None => color,
            }
        })
        .collect()
}

/// A faded colour, next to highlighted ones.
pub fn faded(color: [u8; 3]) -> [u8; 3] {
    mixed(color, UNASSIGNED_COLOR, 0.8)
}

/// The colour of pinned points.
fn darkened(color: [u8; 3]) -> [u8; 3] {
    mixed(color, [0; 3], 0.5)
}

fn mixed(from: [u8; 3], to: [u8; 3], share: f32) -> [u8; 3] {
    std::array::from_fn(|i| (f32::from(from[i]) * (1.0 - share) + f32::from(to[i]) * share).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud() -> Vec<Point3<f64>> {
        vec![Point3::new(1e6, -3.0, 2.0), Point3::new(1e6 + 4.0, -1.0, 3.0)]
    }

    #[test]
    fn the_longest_edge_becomes_one_and_up_becomes_y() {
        for (up, size) in [(UpAxis::Y, [1.0, 0.5, 0.25]), (UpAxis::Z, [1.0, 0.25, 0.5])] {
            let scene = SceneFromInput::fit(&cloud(), up);
            assert!((scene.bounds.size() - Vector3::from(size)).norm() < 1e-9, "{up:?}");
            let seen = Bounds::around(cloud().iter().map(|p| scene.point(p))).expect("a box");
            assert!((seen.min - scene.bounds.min).norm() < 1e-9, "{up:?}");
        }
        let scene = SceneFromInput::fit(&cloud(), UpAxis::Z);
        let step = scene.point(&Point3::new(0.0, 0.0, 1.0)) - scene.point(&Point3::origin());
        assert!((step.normalize() - Vector3::y()).norm() < 1e-9);
        assert!((scene.rotation.matrix().determinant() - 1.0).abs() < 1e-12, "no mirror image");
    }

    #[test]
    fn a_shape_moves_as_its_points_do() {
        let body = Superquadric {
            exponents: [0.5, 1.2],
            semi_axes: Vector3::new(1.0, 2.0, 0.5),
            rotation: Rotation3::new(Vector3::new(0.3, -0.8, 0.1)),
            translation: Vector3::new(1e6 + 1.0, -2.0, 2.5),
            taper: [0.2, -0.3],
        };
        let scene = SceneFromInput::fit(&cloud(), UpAxis::Z);
        let shown = scene.shape(&body);
        let back = scene.shape_in_input(&shown);
        assert!(
            (back.translation - body.translation).norm() < 1e-6
                && back.rotation.angle_to(&body.rotation) < 1e-6
        );
        assert!((back.semi_axes - body.semi_axes).norm() < 1e-9);
        for x in [Point3::new(1e6, 0.0, 2.0), Point3::new(1e6 + 3.0, -1.0, 1.0)] {
            let expected = body.radial_distance(&x) * scene.scale();
            assert!((shown.radial_distance(&scene.point(&x)) - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn clouds_without_extent_keep_finite() {
        for points in [vec![], vec![Point3::new(5.0, 5.0, 5.0)], vec![Point3::new(f64::NAN, 0.0, 0.0)]] {
            let scene = SceneFromInput::fit(&points, UpAxis::Y);
            assert!(scene.scale().is_finite());
            assert!(scene.point(&Point3::new(5.0, 5.0, 5.0)).iter().all(|c| c.is_finite()));
        }
    }
}
