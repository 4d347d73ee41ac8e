//! The start of a fit: centroid and principal axes of the points.

use nalgebra::{Matrix3, Point3, Rotation3, SymmetricEigen, Vector3};

use crate::geometry::Superquadric;

/// Exponents of the box start: sharper ones would leave the fit no gradient.
const BOX_EXPONENT: f64 = 0.3;

/// The ellipsoid of the points' moments: centroid, principal axes (longest
/// along local z, where the taper runs), semi-axes √(5λ) of a solid ellipsoid
/// with the same covariance, times `shrink`; semi-axes at least `floor`.
pub(crate) fn ellipsoid_of_moments(points: &[Point3<f64>], shrink: f64, floor: f64) -> Superquadric {
    let n = points.len().max(1) as f64;
    let mean = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / n;
    let covariance = points.iter().fold(Matrix3::zeros(), |sum, p| {
        let d = p.coords - mean;
        sum + d * d.transpose()
    }) / n;
    let eigen = SymmetricEigen::new(covariance);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let x: Vector3<f64> = eigen.eigenvectors.column(order[0]).into();
    let y: Vector3<f64> = eigen.eigenvectors.column(order[1]).into();
    // Right-handed whatever the signs that the decomposition chose.
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
    let spread = |i: usize| (5.0 * eigen.eigenvalues[order[i]].max(0.0)).sqrt();
    let axis = |i: usize| (shrink * spread(i)).max(floor);
    // Points of a plane lie on a face of their plate, not half-way into it,
    // where every ray but one leads to the far rim.
    let flat = spread(0) < floor && spread(1) > floor;
    let translation = if flat { mean + x * axis(0) } else { mean };
    Superquadric {
        exponents: [1.0, 1.0],
        semi_axes: Vector3::new(axis(0), axis(1), axis(2)),
        rotation,
        translation,
        taper: [0.0, 0.0],
    }
}

/// The points' box in the frame of `moments`, with edges a little rounded: the
/// start from which plates and boards are found.
pub(crate) fn box_of_extents(points: &[Point3<f64>], moments: &Superquadric, floor: f64) -> Superquadric {
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = Vector3::repeat(f64::NEG_INFINITY);
    for p in points {
        let p = moments.local(p);
        low = low.inf(&p);
        high = high.sup(&p);
    }
    let semi_axes = ((high - low) * 0.5).map(|a| a.max(floor));
    // As in the moments, the points of a plane lie on a face.
    let flat = high.x - low.x < floor;
    let center = (low + high) * 0.5 + Vector3::new(if flat { semi_axes.x } else { 0.0 }, 0.0, 0.0);
    Superquadric {
        exponents: [BOX_EXPONENT, BOX_EXPONENT],
        semi_axes,
        rotation: moments.rotation,
        translation: moments.translation + moments.rotation * center,
        taper: [0.0, 0.0],
    }
}

/// The same, but a flat box has the edges of the smallest rectangle around the
/// points: the moments of a square or a disc have no direction.
pub(crate) fn smallest_box(points: &[Point3<f64>], moments: &Superquadric, floor: f64) -> Superquadric {
    let first = box_of_extents(points, moments, floor);
    if first.semi_axes.x >= FLAT * first.semi_axes.y.min(first.semi_axes.z) {
        return first;
    }
    let turned = |k: usize| {
        let angle = std::f64::consts::FRAC_PI_2 * k as f64 / TURNS as f64;
        let rotation = moments.rotation * Rotation3::from_axis_angle(&Vector3::x_axis(), angle);
        box_of_extents(points, &Superquadric { rotation, ..*moments }, floor)
    };
    let area = |shape: &Superquadric| shape.semi_axes.y * shape.semi_axes.z;
    (1..TURNS).map(turned).fold(first, |best, other| if area(&other) < area(&best) { other } else { best })
}

/// A box is flat below this thickness, as a share of its width, and turned by so
/// many steps within a right angle.
const FLAT: f64 = 0.1;
const TURNS: usize = 30;

/// The primitive with its axes renamed so that the old axis `new_z` becomes
/// local z (cyclically: the frame stays right-handed). The exponents change
/// roles and the taper, which ran along the old z, is gone.
pub(crate) fn with_axis_as_z(shape: &Superquadric, new_z: usize) -> Superquadric {
    let m = shape.rotation.matrix();
    let (x, y) = ((new_z + 1) % 3, (new_z + 2) % 3);
    let columns = [x, y, new_z].map(|i| Vector3::from(m.column(i)));
    Superquadric {
        exponents: if new_z == 2 { shape.exponents } else { [shape.exponents[1], shape.exponents[0]] },
        semi_axes: Vector3::new(shape.semi_axes[x], shape.semi_axes[y], shape.semi_axes[new_z]),
        rotation: Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns)),
        translation: shape.translation,
        taper: if new_z == 2 { shape.taper } else { [0.0, 0.0] },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solid_box_gives_its_own_axes() {
        let mut points = Vec::new();
        for i in 0..10 {
            for j in 0..10 {
                for k in 0..10 {
                    points.push(Point3::new(
                        f64::from(i) * 0.3 + 5.0,
                        f64::from(j) * 0.1,
                        f64::from(k) * 0.2,
                    ));
                }
            }
        }
        let e = ellipsoid_of_moments(&points, 1.0, 1e-6);
        assert!((e.translation - Vector3::new(6.35, 0.45, 0.9)).norm() < 1e-12);
        assert!(e.rotation.matrix().column(2)[0].abs() > 0.999, "the longest axis is local z");
        assert!(e.semi_axes.x < e.semi_axes.y && e.semi_axes.y < e.semi_axes.z);
        assert!((e.rotation.matrix().determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn renamed_axes_describe_the_same_ellipsoid() {
        let shape = Superquadric {
            semi_axes: Vector3::new(1.0, 2.0, 3.0),
            rotation: Rotation3::from_euler_angles(0.3, -0.8, 1.1),
            translation: Vector3::new(0.1, 0.2, 0.3),
            ..Superquadric::sphere(Point3::origin(), 1.0)
        };
        for new_z in 0..3 {
            let renamed = with_axis_as_z(&shape, new_z);
            assert!((renamed.rotation.matrix().determinant() - 1.0).abs() < 1e-12);
            let p = Point3::new(0.7, -1.9, 2.2);
            assert!((renamed.radial_distance(&p) - shape.radial_distance(&p)).abs() < 1e-9);
        }
    }
}
