//! From input units to scene space: centred, y up, the longest edge of the shape's bounding box of
//! length 1.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use super::camera::Bounds;
use crate::geometry::Superquadric;

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
