//! How the area of a body grows with its size.

use nalgebra::Vector3;

/// Exponent of Thomsen's approximation to the area of an ellipsoid.
const THOMSEN: f64 = 1.6075;

/// The area of an ellipsoid by Thomsen's formula, and its derivatives by the
/// semi-axes: how the area of any body grows with its size.
pub(crate) fn area_of_ellipsoid(semi_axes: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let powers = semi_axes.map(|a| a.powf(THOMSEN));
    let others = Vector3::new(powers.y + powers.z, powers.x + powers.z, powers.x + powers.y);
    let mean = (powers.x * powers.y + powers.x * powers.z + powers.y * powers.z) / 3.0;
    let area = 4.0 * std::f64::consts::PI * mean.powf(1.0 / THOMSEN);
    let by_power = powers.component_mul(&others).component_div(semi_axes) / (3.0 * mean);
    (area, by_power * area)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::geometry::{Superquadric, tessellate};

    #[test]
    fn the_area_is_that_of_an_ellipsoid_with_its_derivatives() {
        for [x, y, z] in [[1.0, 1.0, 1.0], [0.4, 1.0, 2.5], [3.0, 0.2, 0.3]] {
            let semi_axes = Vector3::new(x, y, z);
            let (area, gradient) = area_of_ellipsoid(&semi_axes);
            let shape = Superquadric { semi_axes, ..Superquadric::sphere(Point3::origin(), 1.0) };
            let exact = tessellate::surface_area(&shape);
            assert!((area / exact - 1.0).abs() < 0.02, "{area} {exact}");
            for axis in 0..3 {
                let by = |step: f64| {
                    let mut moved = semi_axes;
                    moved[axis] += step;
                    area_of_ellipsoid(&moved).0
                };
                let numeric = (by(1e-6) - by(-1e-6)) / 2e-6;
                assert!((gradient[axis] - numeric).abs() < 1e-6 * area, "{} {numeric}", gradient[axis]);
            }
        }
    }
}
