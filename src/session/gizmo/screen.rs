//! Conversion between scene space and logical pixels.

use nalgebra::{Point3, Vector2, Vector3};

use crate::session::camera::Camera;

/// A camera with the size of its picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    camera: Camera,
    size: Vector2<f64>,
}

impl Screen {
    /// `size` in logical pixels; the camera takes its form.
    pub fn new(camera: &Camera, size: Vector2<f64>) -> Self {
        let size = size.map(|s| s.max(1.0));
        Self { camera: Camera { aspect: size.x / size.y, ..*camera }, size }
    }

    /// Where a scene point is seen, from the upper left corner; `None` at or
    /// behind the eye.
    pub fn pixel(&self, point: &Point3<f64>) -> Option<Vector2<f64>> {
        let seen = self.camera.project(point)?;
        let pixel = Vector2::new((1.0 + seen.x) * self.size.x, (1.0 - seen.y) * self.size.y) * 0.5;
        pixel.iter().all(|c| c.is_finite()).then_some(pixel)
    }

    /// The viewing ray through a pixel: a point of it and its unit direction.
    pub fn ray(&self, pixel: Vector2<f64>) -> (Point3<f64>, Vector3<f64>) {
        let camera = &self.camera;
        let half = camera.half_extent();
        let x = (2.0 * pixel.x / self.size.x - 1.0) * half.x;
        let y = (1.0 - 2.0 * pixel.y / self.size.y) * half.y;
        let on_target = camera.target + camera.right() * x + camera.up() * y;
        if camera.orthographic {
            // From far enough that all is in front.
            (on_target - camera.forward() * 1e3, camera.forward())
        } else {
            (camera.eye(), (on_target - camera.eye()).normalize())
        }
    }

    /// Unit vector into the picture, at its centre.
    pub fn forward(&self) -> Vector3<f64> {
        self.camera.forward()
    }

    /// Unit vector from the eye to a point.
    pub fn sight(&self, point: &Point3<f64>) -> Vector3<f64> {
        if self.camera.orthographic {
            return self.camera.forward();
        }
        (point - self.camera.eye()).try_normalize(1e-12).unwrap_or_else(|| self.camera.forward())
    }

    /// Scene units a logical pixel at the depth of a point.
    pub fn units_per_pixel(&self, point: &Point3<f64>) -> f64 {
        let camera = &self.camera;
        let at_target = 2.0 * camera.half_extent().y / self.size.y;
        if camera.orthographic {
            return at_target;
        }
        let depth = camera.distance + (point - camera.target).dot(&camera.forward());
        at_target * depth.max(1e-6) / camera.distance
    }
}
