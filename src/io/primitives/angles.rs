//! A rotation as yaw, pitch and roll.

use nalgebra::Rotation3;

/// Angles of R = Rz(yaw)·Ry(pitch)·Rx(roll), in radians: yaw and roll in
/// (−π, π], pitch in [−π/2, π/2]. The product is R to the last digits also where
/// pitch is ±π/2 and yaw is a matter of choice.
pub(in crate::io) fn yaw_pitch_roll(rotation: &Rotation3<f64>) -> [f64; 3] {
    let m = rotation.matrix();
    let yaw = m[(1, 0)].atan2(m[(0, 0)]);
    let pitch = (-m[(2, 0)]).atan2(m[(0, 0)].hypot(m[(1, 0)]));
    // Roll is what is left once the yaw is taken back.
    let (s, c) = yaw.sin_cos();
    let roll = (s * m[(0, 2)] - c * m[(1, 2)]).atan2(c * m[(1, 1)] - s * m[(0, 1)]);
    [yaw, pitch, roll]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn angles_give_the_rotation_back_also_where_they_are_not_unique() {
        let mut rotations = vec![Rotation3::identity(), Rotation3::from_euler_angles(PI, 0.0, PI)];
        for pitch in [-FRAC_PI_2, FRAC_PI_2, FRAC_PI_2 - 1e-9, 1e-12 - FRAC_PI_2, 0.3] {
            for (roll, yaw) in [(0.0, 0.0), (1.0, -2.0), (3.1, 2.9), (-0.4, 1e-9)] {
                rotations.push(Rotation3::from_euler_angles(roll, pitch, yaw));
                rotations.push(Rotation3::new(Vector3::new(roll, pitch, yaw)));
            }
        }
        for rotation in rotations {
            let [yaw, pitch, roll] = yaw_pitch_roll(&rotation);
            let back = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw)
                * Rotation3::from_axis_angle(&Vector3::y_axis(), pitch)
                * Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
            let off = (back.matrix() - rotation.matrix()).amax();
            assert!(off < 1e-15 * 4.0, "{off}: {yaw} {pitch} {roll}");
        }
    }
}
