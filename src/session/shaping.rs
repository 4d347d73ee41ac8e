//! The shape of a primitive while it is edited: the draft, its limits, round steps, angles.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Point3, Rotation3, Vector3};

use super::gizmo::{Handle, angle_between};
use crate::geometry::Superquadric;
use crate::geometry::theta::Bounds;

/// A change to a primitive during a drag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapeDraft {
    /// Of the primitive.
    pub id: u32,
    /// In input units.
    pub shape: Superquadric,
    /// Turns about x, y and z in radians that make up the shape's rotation, where
    /// they were set as such.
    pub angles: Option<[f64; 3]>,
}

/// The draft that is shown in place of a primitive's shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shaping {
    pub(super) id: u32,
    pub(super) shape: Superquadric,
    /// The edit is on its way to the worker.
    pub(super) is_sent: bool,
}

/// Limits of the parameters in manual edits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapeLimits {
    /// Longest edge of the shape's box, in input units.
    pub extent: f64,
    /// Centre of that box.
    pub center: Point3<f64>,
}

impl ShapeLimits {
    /// Of ε1 and ε2, as fits keep them.
    pub const EXPONENTS: (f64, f64) = Bounds::FITS.exponents;
    /// Of kx and ky, as fits keep them.
    pub const TAPER: (f64, f64) = Bounds::FITS.taper;
    /// Semi-axes in longest edges of the shape's box.
    const SEMI_AXES: (f64, f64) = (1e-3, 10.0);
    /// Largest distance of a primitive's centre from the shape's, in the same unit.
    const REACH: f64 = 20.0;

    /// Of ax, ay and az, in input units.
    pub fn semi_axes(&self) -> (f64, f64) {
        let (low, high) = Self::SEMI_AXES;
        (low * self.extent, high * self.extent)
    }

    /// Of one coordinate of t, in input units.
    pub fn translation(&self, axis: usize) -> (f64, f64) {
        let reach = Self::REACH * self.extent;
        (self.center[axis] - reach, self.center[axis] + reach)
    }

    /// The nearest shape within the limits.
    pub fn clamped(&self, shape: &Superquadric) -> Superquadric {
        let within = |v: f64, (low, high): (f64, f64)| v.clamp(low, high);
        Superquadric {
            exponents: shape.exponents.map(|e| within(e, Self::EXPONENTS)),
            semi_axes: shape.semi_axes.map(|a| within(a, self.semi_axes())),
            rotation: shape.rotation,
            translation: Vector3::from_fn(|axis, _| within(shape.translation[axis], self.translation(axis))),
            taper: shape.taper.map(|k| within(k, Self::TAPER)),
        }
    }
}

/// Angles (x, y, z) with R = Rz·Ry·Rx, of all that give R those nearest to
/// `near`.
pub(super) fn angles_near(rotation: &Rotation3<f64>, near: [f64; 3]) -> [f64; 3] {
    let (x, y, z) = rotation.euler_angles();
    let mut candidates = vec![[x, y, z], [x + PI, PI - y, z + PI]];
    if (y.abs() - FRAC_PI_2).abs() < 1e-6 {
        // Only x ∓ z is determined.
        let turn = near[0] - x;
        candidates.push([near[0], y, z + turn * y.signum()]);
    }
    let wrap = |angle: f64, near: f64| angle + TAU * ((near - angle) / TAU).round();
    let distance = |angles: &[f64; 3]| -> f64 { (0..3).map(|i| (angles[i] - near[i]).powi(2)).sum() };
    candidates
        .into_iter()
        .map(|angles| std::array::from_fn(|i| wrap(angles[i], near[i])))
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(near)
}

/// A round length of about a hundredth of `extent`: 1, 2 or 5 times a power of
/// ten.
pub fn round_step(extent: f64) -> f64 {
    let wanted = 0.01 * extent;
    let power = 10_f64.powf(wanted.log10().floor());
    let share = wanted / power;
    let step = if share < 1.5 {
        1.0
    } else if share < 3.5 {
        2.0
    } else if share < 7.5 {
        5.0
    } else {
        10.0
    };
    step * power
}

/// What a drag of a handle made of `start`, in round steps: 15° for turns,
/// `step` for lengths, 0.1 for the others.
pub fn snapped(handle: Handle, start: &Superquadric, dragged: &Superquadric, step: f64) -> Superquadric {
    let round = |v: f64, step: f64| (v / step).round() * step;
    let mut shape = *dragged;
    match handle {
        Handle::MoveAxis(_) | Handle::MovePlane(_) | Handle::MoveFree => {
            let local = start.rotation.inverse() * (dragged.translation - start.translation);
            shape.translation = start.translation + start.rotation * local.map(|v| round(v, step));
        }
        Handle::RotateAxis(_) | Handle::RotateView => {
            let turn = dragged.rotation * start.rotation.inverse();
            shape.rotation = turn.axis().map_or(start.rotation, |axis| {
                Rotation3::from_axis_angle(
                    &axis,
                    round(angle_between(&start.rotation, &dragged.rotation), PI / 12.0),
                ) * start.rotation
            });
        }
        Handle::ScaleAxis(axis) => {
            shape.semi_axes[axis] = round(shape.semi_axes[axis], step).max(step);
        }
        Handle::ScaleUniform => {
            let factor = round(dragged.semi_axes.x / start.semi_axes.x, 0.1).max(0.1);
            shape.semi_axes = start.semi_axes * factor;
        }
        Handle::Taper(which) => shape.taper[which] = round(shape.taper[which], 0.1),
        Handle::Exponent(which) => shape.exponents[which] = round(shape.exponents[which], 0.1),
    }
    shape
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn rotation([x, y, z]: [f64; 3]) -> Rotation3<f64> {
        Rotation3::from_euler_angles(x, y, z)
    }

    proptest! {
        #[test]
        fn angles_give_the_rotation_and_do_not_jump(
            at in prop::array::uniform3(-7.0..7.0),
            step in prop::array::uniform3(-0.02..0.02),
        ) {
            let next: [f64; 3] = std::array::from_fn(|i| at[i] + step[i]);
            let found = angles_near(&rotation(next), at);
            prop_assert!(angle_between(&rotation(found), &rotation(next)) < 1e-6);
            for i in 0..3 {
                prop_assert!((found[i] - next[i]).abs() < 1e-6 || at[1].cos().abs() < 0.05, "{found:?}, {next:?}");
            }
        }

        #[test]
        fn shapes_are_brought_within_their_limits(
            exponents in prop::array::uniform2(-3.0..5.0),
            axes in prop::array::uniform3(-1e3..1e3),
            center in prop::array::uniform3(-1e4..1e4),
            taper in prop::array::uniform2(-3.0..3.0),
        ) {
            let limits = ShapeLimits { extent: 3.0, center: Point3::new(100.0, 0.0, -5.0) };
            let shape = Superquadric {
                exponents,
                semi_axes: axes.into(),
                rotation: Rotation3::identity(),
                translation: center.into(),
                taper,
            };
            let clamped = limits.clamped(&shape);
            prop_assert!(clamped.is_valid());
            prop_assert_eq!(limits.clamped(&clamped), clamped);
        }
    }

    #[test]
    fn steps_are_round() {
        for (extent, step) in [(1.0, 0.01), (3.0, 0.02), (60.0, 0.5), (0.009, 1e-4)] {
            assert!((round_step(extent) / step - 1.0).abs() < 1e-9, "{extent}: {}", round_step(extent));
        }
        let start = Superquadric::sphere(Point3::new(1.0, 2.0, 3.0), 1.03);
        let mut dragged = start.moved(&Vector3::new(0.0, 0.0, 0.5), &Vector3::zeros());
        let turned = snapped(Handle::RotateAxis(2), &start, &dragged, 0.1);
        assert!((angle_between(&start.rotation, &turned.rotation) - 30_f64.to_radians()).abs() < 1e-9);
        dragged.translation.x += 0.337;
        let moved = snapped(Handle::MoveAxis(0), &start, &dragged, 0.1);
        assert!((moved.translation.x - 1.3).abs() < 1e-9);
        dragged.semi_axes.y = 1.26;
        assert!((snapped(Handle::ScaleAxis(1), &start, &dragged, 0.1).semi_axes.y - 1.3).abs() < 1e-9);
        dragged.taper[0] = 0.44;
        assert!((snapped(Handle::Taper(0), &start, &dragged, 0.1).taper[0] - 0.4).abs() < 1e-9);
    }

    #[test]
    fn a_turn_through_the_pole_goes_on() {
        let mut angles = [0.3, 0.0, -0.4];
        for i in 1..=300 {
            let pitch = f64::from(i) * 0.02;
            let set = [0.3, pitch, -0.4];
            angles = angles_near(&rotation(set), angles);
            assert!(angle_between(&rotation(angles), &rotation(set)) < 1e-6, "{pitch}");
        }
    }
}
