//! Where a shape was looked at from.

use nalgebra::{Point3, Vector3};

/// A place to look from, in the frame of the cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Viewpoint {
    Place(Point3<f64>),
    /// Infinitely far: the unit vector towards the viewer.
    Direction(Vector3<f64>),
}

impl Viewpoint {
    /// The unit vector from a place towards the viewer.
    pub(crate) fn direction_from(&self, place: &Point3<f64>) -> Vector3<f64> {
        match self {
            Self::Place(eye) => (eye - place).try_normalize(0.0).unwrap_or_else(Vector3::z),
            Self::Direction(towards) => *towards,
        }
    }
}
