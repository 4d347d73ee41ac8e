//! The tapered superquadric: radial distance, its Jacobian, volume.
//!
//! A local point is `p = Rᵀ(x − t)`. The taper runs along local z: with
//! `w = pz/az` the untapered point is `q = (px/sx, py/sy, pz)`,
//! `sx = kx·w + 1`, `sy = ky·w + 1`. On q the implicit function is
//!
//! ```text
//! F = ((|qx|/ax)^(2/ε2) + (|qy|/ay)^(2/ε2))^(ε2/ε1) + (|qz|/az)^(2/ε1)
//! ```
//!
//! and `H = F^ε1` is homogeneous of degree 2, so that the signed radial
//! distance (positive inside) is `r = |q|·(H^(−1/2) − 1)`; the paper's noise
//! model lives on `d = |r|`. Everything is evaluated in logarithms, where no
//! exponent overflows: with `u = ln(q²/a²)` per axis,
//!
//! ```text
//! ln φ(u, v; ε) = ε·ln(e^(u/ε) + e^(v/ε))     ψ = ∂ln φ/∂u = softmax weight of u
//! ∂ ln φ/∂ε = −ψ ln ψ − (1 − ψ) ln(1 − ψ)     ln H = ln φ(ln φ(ux, uy; ε2), uz; ε1)
//! ```

use nalgebra::{Point3, Vector3};

use super::theta::{PARAMETERS, Superquadric};

/// Added to q²/a² under the logarithm, so that an axis of 0 stays finite.
pub(crate) const LOG_FLOOR: f64 = 1e-12;
/// The taper factor changes sign past the apex of a fully tapered primitive;
/// it is kept above this value.
pub const TAPER_FLOOR: f64 = 0.02;

/// `ln φ(u, v; ε)`, the weight ψ of `u`, and the entropy of ψ (= ∂ ln φ/∂ε).
#[inline(always)]
fn log_phi(u: f64, v: f64, eps: f64) -> (f64, f64, f64) {
    let delta = (u - v) / eps;
    let e = (-delta.abs()).exp();
    let l = e.ln_1p();
    let small = e / (1.0 + e);
    let psi = if delta >= 0.0 { 1.0 - small } else { small };
    (u.max(v) + eps * l, psi, l + delta.abs() * small)
}

/// `ln φ` alone.
#[inline(always)]
fn log_phi_value(u: f64, v: f64, eps: f64) -> f64 {
    u.max(v) + eps * (-((u - v) / eps).abs()).exp().ln_1p()
}

/// Radial distance at a point, with its gradients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialDerivatives {
    /// Signed radial distance r, positive inside.
    pub r: f64,
    /// ∂r/∂p, p the local point; ∂r/∂x = R·∂r/∂p.
    pub local_gradient: Vector3<f64>,
    /// ∂r/∂(ε1, ε2, ax, ay, az, ω, τ, kx, ky), where the pose moves by the
    /// right perturbation R ← R·exp(ω^), t ← t + R·τ.
    pub parameters: [f64; PARAMETERS],
}

impl Superquadric {
    /// The point in the primitive's frame, p = Rᵀ(x − t).
    #[inline(always)]
    pub fn local(&self, x: &Point3<f64>) -> Vector3<f64> {
        self.rotation.matrix().tr_mul(&(x.coords - self.translation))
    }

    /// Taper factors (sx, sy) at local height `pz`: w = pz/az is clamped to
    /// the primitive's extent and the factor floored, so that neither sign
    /// nor size runs away beyond the caps.
    #[inline(always)]
    pub fn taper_factors(&self, pz: f64) -> [f64; 2] {
        let w = (pz / self.semi_axes.z).clamp(-1.0, 1.0);
        [(self.taper[0] * w + 1.0).max(TAPER_FLOOR), (self.taper[1] * w + 1.0).max(TAPER_FLOOR)]
    }

    /// The untapered local point q.
    #[inline(always)]
    pub fn untapered(&self, p: &Vector3<f64>) -> Vector3<f64> {
        let [sx, sy] = self.taper_factors(p.z);
        Vector3::new(p.x / sx, p.y / sy, p.z)
    }

    /// ln H at an untapered local point: 0 on the surface, negative inside.
    #[inline(always)]
    fn log_h(&self, q: &Vector3<f64>) -> f64 {
        let u = q.component_div(&self.semi_axes).map(|v| (v * v + LOG_FLOOR).ln());
        let [e1, e2] = self.exponents;
        log_phi_value(log_phi_value(u.x, u.y, e2), u.z, e1)
    }

    /// Signed radial distance r of a world point (positive inside); the
    /// paper's d is |r|.
    #[inline]
    pub fn radial_distance(&self, x: &Point3<f64>) -> f64 {
        let q = self.untapered(&self.local(x));
        let h = self.log_h(&q);
        let floor = LOG_FLOOR * self.semi_axes.min().powi(2);
        (q.norm_squared() + floor).sqrt() * (-0.5 * h).exp_m1()
    }

    /// ln F (not ln H) at a world point: 0 on the surface, negative inside.
    pub fn log_implicit(&self, x: &Point3<f64>) -> f64 {
        self.log_h(&self.untapered(&self.local(x))) / self.exponents[0]
    }

    /// Whether the point lies strictly inside.
    pub fn contains(&self, x: &Point3<f64>) -> bool {
        if (x.coords - self.translation).norm_squared() >= self.reach().norm_squared() {
            return false;
        }
        let q = self.untapered(&self.local(x));
        let n = q.component_div(&self.semi_axes).abs();
        // Logarithms are for what simpler bodies leave open: the box around
        // it, the octahedron inside and the ellipsoid on one side or the other.
        if n.max() >= 1.0 {
            return false;
        }
        let [least, most] =
            [self.exponents[0].min(self.exponents[1]), self.exponents[0].max(self.exponents[1])];
        if most <= 2.0 && n.sum() < 1.0 {
            return true;
        }
        let in_ellipsoid = n.norm_squared() < 1.0;
        if in_ellipsoid && most <= 1.0 {
            return true;
        }
        if !in_ellipsoid && least >= 1.0 {
            return false;
        }
        self.log_h(&q) < 0.0
    }

    /// First-order Euclidean distance |r|/|∇ₓr| of a world point to the
    /// surface: near the surface the distance itself, unlike |r|, which on thin
    /// plates grows with the distance from the centre.
    pub fn first_order_distance(&self, x: &Point3<f64>) -> f64 {
        let d = self.derivatives(x);
        // Along the untapered ray the slope is exactly 1, so |∇r| is never small
        // but for the widening by the taper, by 1 + |k| ≤ 2.
        let linear = d.r.abs() / d.local_gradient.norm().max(0.25);
        // Beyond the rim of a thin plate the gradient points across the plate,
        // and the linear model claims less than the way to the body's box.
        let beyond = (self.local(x).abs() - self.reach()).map(|v| v.max(0.0)).norm();
        linear.max(beyond)
    }

    /// Half-extents of a local box that holds the body: a·(1 + |k|).
    pub(crate) fn reach(&self) -> Vector3<f64> {
        let [kx, ky] = self.taper.map(f64::abs);
        self.semi_axes.component_mul(&Vector3::new(1.0 + kx, 1.0 + ky, 1.0))
    }

    /// Radial distance with all derivatives, at a world point.
    #[inline]
    pub fn derivatives(&self, x: &Point3<f64>) -> RadialDerivatives {
        let p = self.local(x);
        let [kx, ky] = self.taper;
        let (ax, ay, az) = (self.semi_axes.x, self.semi_axes.y, self.semi_axes.z);
        let [e1, e2] = self.exponents;

        let raw = p.z / az;
        let w = raw.clamp(-1.0, 1.0);
        let free = if raw.abs() < 1.0 { 1.0 } else { 0.0 };
        let (tx, ty) = (kx * w + 1.0, ky * w + 1.0);
        let (sx, sy) = (tx.max(TAPER_FLOOR), ty.max(TAPER_FLOOR));
        let (fx, fy) = (if tx > TAPER_FLOOR { 1.0 } else { 0.0 }, if ty > TAPER_FLOOR { 1.0 } else { 0.0 });
        let q = Vector3::new(p.x / sx, p.y / sy, p.z);

        let square = |v: f64, a: f64| (v / a) * (v / a);
        let (x2, y2, z2) = (square(q.x, ax), square(q.y, ay), square(q.z, az));
        let (g, psi2, entropy2) = log_phi((x2 + LOG_FLOOR).ln(), (y2 + LOG_FLOOR).ln(), e2);
        let (h, psi1, entropy1) = log_phi(g, (z2 + LOG_FLOOR).ln(), e1);

        let n = (q.norm_squared() + LOG_FLOOR * self.semi_axes.min().powi(2)).sqrt();
        let excess = (-0.5 * h).exp_m1();
        let r = n * excess;
        // ∂r/∂h, and ∂h/∂u of the three axes.
        let by_h = -0.5 * n * (excess + 1.0);
        let (hx, hy, hz) = (psi1 * psi2, psi1 * (1.0 - psi2), 1.0 - psi1);
        // ∂u/∂ln a = −2·share, share = q²/(q² + floor·a²).
        let share = |v2: f64| v2 / (v2 + LOG_FLOOR);
        let (cx, cy, cz) = (hx * share(x2), hy * share(y2), hz * share(z2));

        let by_q = |v: f64, a: f64, hv: f64, v2: f64| {
            v * (excess / n + by_h * hv * 2.0 / (a * a * (v2 + LOG_FLOOR)))
        };
        let gq = Vector3::new(by_q(q.x, ax, hx, x2), by_q(q.y, ay, hy, y2), by_q(q.z, az, hz, z2));
        // ∂r/∂s of the two taper factors: q = p/s.
        let by_sx = -gq.x * q.x / sx * fx;
        let by_sy = -gq.y * q.y / sy * fy;
        let by_w = by_sx * kx + by_sy * ky;

        let gp = Vector3::new(gq.x / sx, gq.y / sy, gq.z + free * by_w / az);
        let turn = gp.cross(&p);
        RadialDerivatives {
            r,
            local_gradient: gp,
            parameters: [
                by_h * entropy1,
                by_h * psi1 * entropy2,
                -2.0 * by_h * cx / ax,
                -2.0 * by_h * cy / ay,
                -2.0 * by_h * cz / az - free * by_w * raw / az,
                turn.x,
                turn.y,
                turn.z,
                -gp.x,
                -gp.y,
                -gp.z,
                by_sx * w,
                by_sy * w,
            ],
        }
    }

    /// The world point of a normalised untapered point `n` (each coordinate
    /// in units of its semi-axis): scale, taper, rotate, translate.
    #[inline]
    pub fn world_from_normalized(&self, n: &Vector3<f64>) -> Point3<f64> {
        let sx = (self.taper[0] * n.z + 1.0).max(0.0);
        let sy = (self.taper[1] * n.z + 1.0).max(0.0);
        let p =
            Vector3::new(n.x * self.semi_axes.x * sx, n.y * self.semi_axes.y * sy, n.z * self.semi_axes.z);
        Point3::from(self.rotation * p + self.translation)
    }

    /// Volume in closed form. The untapered body has
    /// V₀ = 2·ax·ay·az·ε1·ε2·B(ε1/2, ε1 + 1)·B(ε2/2, ε2/2 + 1); the taper
    /// multiplies the section at height w by 1 + (kx + ky)w + kx·ky·w², whose
    /// odd part vanishes, so V = V₀·(1 + kx·ky·⟨w²⟩) with
    /// ⟨w²⟩ = B(3ε1/2, ε1 + 1)/B(ε1/2, ε1 + 1).
    pub fn volume(&self) -> f64 {
        let [e1, e2] = self.exponents;
        let profile = beta(e1 / 2.0, e1 + 1.0);
        let section = beta(e2 / 2.0, e2 / 2.0 + 1.0);
        let mean_w2 = beta(1.5 * e1, e1 + 1.0) / profile;
        2.0 * self.semi_axes.product()
            * e1
            * e2
            * profile
            * section
            * (1.0 + self.taper[0] * self.taper[1] * mean_w2)
    }

    /// Half-extents of the tight local box of the tapered body.
    pub fn half_extents(&self) -> Vector3<f64> {
        // Over |w| ≤ 1 the section's half-width is (1 − |w|^(2/ε1))^(ε1/2)·(1 + k·w)·a:
        // widest somewhere between the equator (1) and the caps (1 + |k|).
        let e1 = self.exponents[0];
        let widest = |k: f64| {
            (0..=32)
                .map(|i| {
                    let w = f64::from(i) / 32.0;
                    (1.0 - w.powf(2.0 / e1)).max(0.0).powf(e1 / 2.0) * (1.0 + k.abs() * w)
                })
                .fold(1.0, f64::max)
        };
        Vector3::new(
            self.semi_axes.x * widest(self.taper[0]),
            self.semi_axes.y * widest(self.taper[1]),
            self.semi_axes.z,
        )
    }

    /// The same body after x ↦ scale·x + offset.
    pub fn scaled(&self, scale: f64, offset: &Vector3<f64>) -> Self {
        Self { semi_axes: self.semi_axes * scale, translation: self.translation * scale + offset, ..*self }
    }
}

/// Euler's beta function.
fn beta(a: f64, b: f64) -> f64 {
    (libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b)).exp()
}

#[cfg(test)]
mod tests;
