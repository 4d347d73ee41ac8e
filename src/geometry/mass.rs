//! Volume, centroid and moments of inertia of a tapered superquadric, in closed
//! form.
//!
//! With w = z/az the section at height w is a superellipse of exponent ε2,
//! scaled by g(w) = (1 − |w|^(2/ε1))^(ε1/2) and, along x and y, by 1 + kx·w and
//! 1 + ky·w. So every moment is a product of one over the section and one over
//! the profile,
//!
//! ```text
//! S(p, q) = ∫∫ |x|ᵖ|y|^q over |x|^(2/ε2) + |y|^(2/ε2) ≤ 1
//!         = ε2²·Γ((p+1)·ε2/2)·Γ((q+1)·ε2/2) / Γ(1 + (p+q+2)·ε2/2)
//! P(m, n) = ∫ |w|ᵐ·g(w)ⁿ over |w| ≤ 1 = ε1·B((m+1)·ε1/2, n·ε1/2 + 1)
//! ```
//!
//! and the taper multiplies the profile's integrand by a polynomial in w, of
//! which the even part counts for ∫1, ∫x², ∫y² and ∫z², the odd one for ∫z.

use nalgebra::{Point3, Vector3};

use super::Superquadric;

/// Mass properties of a body of density 1, in its local frame. By its symmetry
/// in x and y the local axes are the principal axes of inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// In cubic units.
    pub volume: f64,
    /// Centre of mass, on the local z axis.
    pub centroid: Point3<f64>,
    /// Ixx, Iyy and Izz about the centroid; the products of inertia are 0.
    /// In units to the fifth power.
    pub inertia: Vector3<f64>,
}

impl Superquadric {
    /// Volume, centroid and inertia of the solid.
    pub fn mass_properties(&self) -> MassProperties {
        let [e1, e2] = self.exponents;
        let [kx, ky] = self.taper;
        let a = &self.semi_axes;
        let section = |p: f64, q: f64| {
            let half = 0.5 * e2;
            let log = libm::lgamma((p + 1.0) * half) + libm::lgamma((q + 1.0) * half)
                - libm::lgamma(1.0 + (p + q + 2.0) * half);
            e2 * e2 * log.exp()
        };
        let profile = |m: f64, n: f64| {
            let (x, y) = ((m + 1.0) * e1 * 0.5, n * e1 * 0.5 + 1.0);
            e1 * (libm::lgamma(x) + libm::lgamma(y) - libm::lgamma(x + y)).exp()
        };
        let box_volume = a.product();
        let area = section(0.0, 0.0);
        let volume = box_volume * area * (profile(0.0, 2.0) + kx * ky * profile(2.0, 2.0));
        let height = a.z * box_volume * area * (kx + ky) * profile(2.0, 2.0) / volume;
        let square_z = a.z * a.z * box_volume * area * (profile(2.0, 2.0) + kx * ky * profile(4.0, 2.0));
        // (1 + k·w)³·(1 + l·w) has the even part 1 + 3k(k + l)·w² + k³l·w⁴.
        let square = |axis: f64, k: f64, l: f64| {
            let even =
                profile(0.0, 4.0) + 3.0 * k * (k + l) * profile(2.0, 4.0) + k.powi(3) * l * profile(4.0, 4.0);
            axis * axis * box_volume * section(2.0, 0.0) * even
        };
        let (square_x, square_y) = (square(a.x, kx, ky), square(a.y, ky, kx));
        let about_centroid = square_z - volume * height * height;
        MassProperties {
            volume,
            centroid: Point3::new(0.0, 0.0, height),
            inertia: Vector3::new(square_y + about_centroid, square_x + about_centroid, square_x + square_y),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Rotation3};

    use super::super::tessellate::{Resolution, tessellate};
    use super::*;

    fn local(eps: [f64; 2], axes: [f64; 3], taper: [f64; 2]) -> Superquadric {
        Superquadric {
            exponents: eps,
            semi_axes: Vector3::from(axes),
            rotation: Rotation3::identity(),
            translation: Vector3::zeros(),
            taper,
        }
    }

    /// Volume, centroid and inertia of a closed surface, by summing tetrahedra.
    fn of_surface(shape: &Superquadric) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let surface = tessellate(shape, Resolution { profile: 64, section: 64 });
        let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for face in &surface.faces {
            let [a, b, c] = face.map(|i| surface.vertices[i as usize].coords);
            let v = a.dot(&b.cross(&c)) / 6.0;
            let sum = a + b + c;
            volume += v;
            first += v * sum / 4.0;
            let squares = a * a.transpose() + b * b.transpose() + c * c.transpose();
            second += v / 20.0 * (squares + sum * sum.transpose());
        }
        let centroid = first / volume;
        second -= volume * centroid * centroid.transpose();
        (volume, centroid, Matrix3::identity() * second.trace() - second)
    }

    #[test]
    fn known_bodies_have_their_textbook_inertia() {
        let (a, b, c) = (1.5, 0.7, 2.0);
        let ellipsoid = local([1.0, 1.0], [a, b, c], [0.0; 2]).mass_properties();
        let m = 4.0 / 3.0 * std::f64::consts::PI * a * b * c;
        assert!((ellipsoid.volume / m - 1.0).abs() < 1e-12);
        let expected = Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) * m / 5.0;
        assert!((ellipsoid.inertia - expected).amax() < 1e-12 * expected.amax());
        let cuboid = local([1e-6, 1e-6], [a, b, c], [0.0; 2]).mass_properties();
        let m = 8.0 * a * b * c;
        let expected = Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) * m / 3.0;
        assert!((cuboid.volume / m - 1.0).abs() < 1e-5);
        assert!((cuboid.inertia - expected).amax() < 1e-5 * expected.amax());
        // Fully tapered, a cylinder is a cone: its centroid lies a quarter of
        // the height above the base.
        let cone = local([1e-6, 1.0], [a, a, c], [-1.0, -1.0]).mass_properties();
        let h = 2.0 * c;
        assert!((cone.centroid.z - (h / 4.0 - c)).abs() < 1e-5 * h);
        let (r, m) = (2.0 * a, std::f64::consts::PI * (2.0 * a) * (2.0 * a) * h / 3.0);
        assert!((cone.inertia.z / (0.3 * m * r * r) - 1.0).abs() < 1e-5);
        let across = 3.0 / 80.0 * m * (4.0 * r * r + h * h);
        assert!((cone.inertia.x / across - 1.0).abs() < 1e-5);
    }

    #[test]
    fn closed_forms_agree_with_the_tessellated_body() {
        for eps in [[0.1, 0.1], [0.3, 1.0], [1.0, 0.5], [1.0, 1.6], [1.7, 0.8], [2.0, 2.0]] {
            for taper in [[0.0, 0.0], [0.4, -0.6], [1.0, 1.0], [-0.9, 0.2], [-1.0, 1.0]] {
                let shape = local(eps, [1.0, 0.6, 1.7], taper);
                let exact = shape.mass_properties();
                assert!((exact.volume / shape.volume() - 1.0).abs() < 1e-12);
                let (volume, centroid, inertia) = of_surface(&shape);
                let about = format!("{eps:?} {taper:?}: {exact:?} {volume} {centroid} {inertia}");
                assert!((volume / exact.volume - 1.0).abs() < 4e-3, "{about}");
                assert!((centroid - exact.centroid.coords).amax() < 2e-3, "{about}");
                let off = inertia - Matrix3::from_diagonal(&exact.inertia);
                assert!(off.amax() < 8e-3 * exact.inertia.amax(), "{about}");
            }
        }
    }
}
