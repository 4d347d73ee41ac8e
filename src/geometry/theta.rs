//! θ, the parameters of a primitive: their names, their order, their bounds, θ
//! as a vector, and what makes a θ valid. A further deformation starts here.

use std::fmt;

use nalgebra::{Matrix3, Point3, Rotation3, SVector, Vector3};

/// Number of parameters of a primitive.
pub const PARAMETERS: usize = 13;

/// A tapered superquadric θ = (ε1, ε2, ax, ay, az, R, t, kx, ky).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Superquadric {
    /// Shape exponents (ε1, ε2): ε1 along the profile (north to south), ε2
    /// around the equator. Near 0 a box, 1 an ellipsoid, 2 an octahedron.
    pub exponents: [f64; 2],
    /// Semi-axes (ax, ay, az), a length.
    pub semi_axes: Vector3<f64>,
    /// world_from_local.
    pub rotation: Rotation3<f64>,
    /// Centre in world coordinates.
    pub translation: Vector3<f64>,
    /// Tapering (kx, ky) along local z, each in [−1, 1].
    pub taper: [f64; 2],
}

/// θ as an optimiser sees it, in the order of [`PARAMETER_NAMES`]. The pose is
/// an increment: the right perturbation R ← R·exp(ω^), t ← t + R·τ.
pub type Theta = SVector<f64, PARAMETERS>;

/// The parameters in the order of [`Theta`].
pub const PARAMETER_NAMES: [&str; PARAMETERS] =
    ["ε1", "ε2", "ax", "ay", "az", "ωx", "ωy", "ωz", "τx", "τy", "τz", "kx", "ky"];

/// Where ε1 and ε2, the semi-axes, ω, τ and the taper begin.
pub const EXPONENTS_AT: usize = 0;
pub const SEMI_AXES_AT: usize = 2;
pub const TURN_AT: usize = 5;
pub const SHIFT_AT: usize = 8;
pub const TAPER_AT: usize = 11;

/// The parameters that shape the surface, whatever the pose.
pub fn shaping() -> impl Iterator<Item = usize> {
    (0..TURN_AT).chain(TAPER_AT..PARAMETERS)
}

/// Limits of the parameters, each from and to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub exponents: (f64, f64),
    /// A length.
    pub semi_axes: (f64, f64),
    /// Of kx and ky.
    pub taper: (f64, f64),
    /// Of each coordinate of the centre, by size.
    pub farthest: f64,
}

impl Bounds {
    /// What is a body at all.
    pub const ANY: Self = Self {
        exponents: (f64::MIN_POSITIVE, f64::MAX),
        semi_axes: (f64::MIN_POSITIVE, f64::MAX),
        taper: (-1.0, 1.0),
        farthest: f64::MAX,
    };
    /// What a run can hold, in the normalised frame, where clouds are some 40
    /// long at most.
    pub const RUN: Self =
        Self { exponents: (0.01, 2.0), semi_axes: (1e-9, 1e4), taper: (-1.0, 1.0), farthest: 1e4 };
    /// What fits find: the paper's exponents lie in (0, 2), but at the ends the
    /// powers lose their meaning in floating point; where a taper is 1 the
    /// narrow end has no width and r no derivative.
    pub const FITS: Self = Self { exponents: (0.1, 1.9), taper: (-0.95, 0.95), ..Self::ANY };
}

/// Why numbers make no primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Invalid {
    Exponent(f64, (f64, f64)),
    SemiAxis(f64, (f64, f64)),
    Taper(f64, (f64, f64)),
    Center(f64, f64),
    /// The matrix of the rotation is not orthonormal, or mirrors.
    Rotation,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut number = |name: &str, value: f64, (low, high): (f64, f64)| {
            let is_open = (low, high) == (f64::MIN_POSITIVE, f64::MAX);
            if is_open {
                write!(f, "the {name} {value} is not a positive number")
            } else {
                write!(f, "the {name} {value} is not between {low} and {high}")
            }
        };
        match *self {
            Self::Exponent(value, bounds) => number("exponent", value, bounds),
            Self::SemiAxis(value, bounds) => number("semi-axis", value, bounds),
            Self::Taper(value, bounds) => number("taper", value, bounds),
            Self::Center(value, _) if !value.is_finite() => write!(f, "the centre is not finite"),
            Self::Center(value, farthest) => number("coordinate of the centre", value, (-farthest, farthest)),
            Self::Rotation => f.write_str("the rotation matrix is not a rotation"),
        }
    }
}

impl std::error::Error for Invalid {}

/// By how much RᵀR may differ from the identity.
const ROTATION_SLACK: f64 = 1e-6;

impl Superquadric {
    /// A sphere of radius `radius` around `center`.
    pub fn sphere(center: Point3<f64>, radius: f64) -> Self {
        Self {
            exponents: [1.0, 1.0],
            semi_axes: Vector3::repeat(radius),
            rotation: Rotation3::identity(),
            translation: center.coords,
            taper: [0.0, 0.0],
        }
    }

    /// θ with the pose at rest.
    pub fn theta(&self) -> Theta {
        let [e1, e2] = self.exponents;
        let a = self.semi_axes;
        let [kx, ky] = self.taper;
        Theta::from([e1, e2, a.x, a.y, a.z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, kx, ky])
    }

    /// The primitive with the parameters `theta`, whose pose moves this one's:
    /// the retraction onto SO(3).
    pub fn retracted(&self, theta: &Theta) -> Self {
        let three = |from: usize| Vector3::new(theta[from], theta[from + 1], theta[from + 2]);
        Self {
            exponents: [theta[EXPONENTS_AT], theta[EXPONENTS_AT + 1]],
            semi_axes: three(SEMI_AXES_AT),
            taper: [theta[TAPER_AT], theta[TAPER_AT + 1]],
            ..self.moved(&three(TURN_AT), &three(SHIFT_AT))
        }
    }

    /// Moves the pose by the right perturbation R ← R·exp(ω^), t ← t + R·τ,
    /// and keeps R orthonormal.
    pub fn moved(&self, omega: &Vector3<f64>, tau: &Vector3<f64>) -> Self {
        let rotation = self.rotation * Rotation3::new(*omega);
        Self {
            rotation: orthonormal(&rotation),
            translation: self.translation + self.rotation * tau,
            ..*self
        }
    }

    /// All numbers that make up the primitive.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let pose = self.rotation.matrix().iter().chain(&self.translation);
        let rest = self.semi_axes.iter().chain(&self.exponents).chain(&self.taper);
        pose.chain(rest).copied()
    }

    /// Says which parameter is not within `bounds`, if one isn't.
    ///
    /// # Errors
    /// The first that isn't, or isn't finite.
    pub fn check(&self, bounds: &Bounds) -> Result<(), Invalid> {
        let outside = |values: &[f64], (low, high): (f64, f64)| {
            values.iter().copied().find(|v| !(*v >= low && *v <= high))
        };
        if let Some(e) = outside(&self.exponents, bounds.exponents) {
            return Err(Invalid::Exponent(e, bounds.exponents));
        }
        if let Some(a) = outside(self.semi_axes.as_slice(), bounds.semi_axes) {
            return Err(Invalid::SemiAxis(a, bounds.semi_axes));
        }
        if let Some(k) = outside(&self.taper, bounds.taper) {
            return Err(Invalid::Taper(k, bounds.taper));
        }
        if let Some(t) = outside(self.translation.as_slice(), (-bounds.farthest, bounds.farthest)) {
            return Err(Invalid::Center(t, bounds.farthest));
        }
        let m = self.rotation.matrix();
        let is_rotation =
            (m.transpose() * m - Matrix3::identity()).amax() < ROTATION_SLACK && m.determinant() > 0.0;
        if is_rotation { Ok(()) } else { Err(Invalid::Rotation) }
    }

    /// The primitive with one of its parameters moved.
    #[cfg(test)]
    pub(crate) fn nudged(&self, parameter: usize, by: f64) -> Self {
        let mut theta = self.theta();
        theta[parameter] += by;
        self.retracted(&theta)
    }

    /// Whether it is a body at all.
    pub fn is_valid(&self) -> bool {
        self.check(&Bounds::ANY).is_ok()
    }
}

/// One Gram–Schmidt pass: products of many rotations drift.
fn orthonormal(rotation: &Rotation3<f64>) -> Rotation3<f64> {
    let m = rotation.matrix();
    let x = m.column(0).normalize();
    let y = (m.column(1) - x * x.dot(&m.column(1))).normalize();
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn theta_there_and_back_is_the_same_primitive() {
        let shape = Superquadric {
            exponents: [0.3, 1.7],
            semi_axes: Vector3::new(1.0, 2.0, 3.0),
            rotation: Rotation3::from_euler_angles(0.1, 0.2, 0.3),
            translation: Vector3::new(4.0, 5.0, 6.0),
            taper: [0.5, -0.25],
        };
        let back = shape.retracted(&shape.theta());
        assert!(shape.numbers().zip(back.numbers()).all(|(a, b)| (a - b).abs() < 1e-15), "{back:?}");
        // Each slot moves what its name says.
        for (i, name) in PARAMETER_NAMES.iter().enumerate() {
            let moved = shape.nudged(i, 0.01);
            let is_pose = name.starts_with(['ω', 'τ']);
            assert_eq!(moved.translation != shape.translation, name.starts_with('τ'), "{name}");
            assert_eq!(shaping().all(|k| moved.theta()[k] == shape.theta()[k]), is_pose, "{name}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_limits() {
        let good = Superquadric::sphere(Point3::new(1.0, 2.0, 3.0), 1.0);
        assert_eq!(good.check(&Bounds::FITS), Ok(()));
        let e = Superquadric { exponents: [1.0, f64::NAN], ..good };
        assert!(matches!(e.check(&Bounds::ANY), Err(Invalid::Exponent(..))));
        let e = Superquadric { exponents: [2.5, 1.0], ..good };
        let problem = e.check(&Bounds::RUN).unwrap_err().to_string();
        assert_eq!(problem, "the exponent 2.5 is not between 0.01 and 2");
        let a = Superquadric { semi_axes: Vector3::new(1.0, 0.0, 1.0), ..good };
        assert_eq!(
            a.check(&Bounds::ANY).unwrap_err().to_string(),
            "the semi-axis 0 is not a positive number"
        );
        let k = Superquadric { taper: [0.0, -0.96], ..good };
        assert!(k.is_valid() && matches!(k.check(&Bounds::FITS), Err(Invalid::Taper(..))));
        let mirrored = Rotation3::from_matrix_unchecked(-Matrix3::identity());
        assert_eq!(Superquadric { rotation: mirrored, ..good }.check(&Bounds::ANY), Err(Invalid::Rotation));
        let far = Superquadric { translation: Vector3::new(0.0, f64::INFINITY, 0.0), ..good };
        assert!(matches!(far.check(&Bounds::ANY), Err(Invalid::Center(..))));
    }
}
