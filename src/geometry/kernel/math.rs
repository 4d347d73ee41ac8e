//! Logarithm and exponential, branch-free, for loops that the compiler
//! vectorises.

/// e^x, relative error under 2e-7; x below −87 counts as −87. Above 88 it is
/// meaningless.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    const MAGIC: f32 = 12_582_912.0; // 1.5·2²³: the sum's low bits are the integer
    let x = x.max(-87.0);
    let shifted = x * std::f32::consts::LOG2_E + MAGIC;
    let k = shifted - MAGIC;
    // ln 2 in two parts, so that x − k·ln 2 keeps its low bits.
    let r = (x - k * 0.693_359_4) - k * -2.121_944_4e-4;
    let mut p = 1.0 / 5040.0;
    p = p * r + 1.0 / 720.0;
    p = p * r + 1.0 / 120.0;
    p = p * r + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    p = p * r + 1.0;
    p = p * r + 1.0;
    p * f32::from_bits((shifted.to_bits() << 23).wrapping_add(0x3f80_0000))
}

/// ln x for positive normal x, error under 2e-7·(1 + |ln x|).
#[inline(always)]
pub(super) fn ln(x: f32) -> f32 {
    // x = 2^k·m with m in [√½, √2).
    const SQRT_HALF: u32 = 0x3f35_04f3;
    let shifted = x.to_bits().wrapping_sub(SQRT_HALF);
    let k = (shifted as i32 >> 23) as f32;
    let m = f32::from_bits((shifted & 0x007f_ffff).wrapping_add(SQRT_HALF));
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let mut p = 2.0 / 9.0;
    p = p * s2 + 2.0 / 7.0;
    p = p * s2 + 2.0 / 5.0;
    p = p * s2 + 2.0 / 3.0;
    p = p * s2 + 2.0;
    k * std::f32::consts::LN_2 + s * p
}

/// The same as [`exp`] in double precision; x below −700 counts as −700.
#[inline(always)]
pub(super) fn exp_f64(x: f64) -> f64 {
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5·2⁵²
    let x = x.max(-700.0);
    let shifted = x * std::f64::consts::LOG2_E + MAGIC;
    let k = shifted - MAGIC;
    let r = (x - k * 6.931_471_803_691_238e-1) - k * 1.908_214_929_270_587_7e-10;
    const C: [f64; 12] = [
        1.0,
        1.0,
        1.0 / 2.0,
        1.0 / 6.0,
        1.0 / 24.0,
        1.0 / 120.0,
        1.0 / 720.0,
        1.0 / 5040.0,
        1.0 / 40320.0,
        1.0 / 362_880.0,
        1.0 / 3_628_800.0,
        1.0 / 39_916_800.0,
    ];
    let mut p = C[11];
    let mut i = 11;
    while i > 0 {
        i -= 1;
        p = p * r + C[i];
    }
    p * f64::from_bits((shifted.to_bits() << 52).wrapping_add(0x3ff0_0000_0000_0000))
}

/// ln φ(u, v; ε), ψ, 1 − ψ and the entropy of ψ; see
/// [`crate::geometry::superquadric`].
#[inline(always)]
pub(super) fn log_phi(u: f32, v: f32, eps: f32, inv_eps: f32) -> (f32, f32, f32, f32) {
    let delta = (u - v) * inv_eps;
    let size = delta.abs();
    let e = exp(-size);
    let l = ln(1.0 + e);
    let large = 1.0 / (1.0 + e);
    let small = e * large;
    let (psi, rest) = if delta >= 0.0 { (large, small) } else { (small, large) };
    (u.max(v) + eps * l, psi, rest, l + size * small)
}

#[inline(always)]
pub(super) fn log_phi_value(u: f32, v: f32, eps: f32, inv_eps: f32) -> f32 {
    u.max(v) + eps * ln(1.0 + exp(-((u - v) * inv_eps).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_and_exponential_keep_their_error() {
        for i in 0..200_000 {
            let x = -87.0 + i as f32 * 8e-4;
            if x < 87.0 {
                assert!((f64::from(exp(x)) / f64::from(x).exp() - 1.0).abs() < 2e-7, "exp({x})");
            }
            let y = (i as f32 * 3e-4 - 30.0).exp();
            let expected = f64::from(y).ln();
            assert!((f64::from(ln(y)) - expected).abs() < 2e-7 * (1.0 + expected.abs()), "ln({y})");
            let x = -690.0 + f64::from(i) * 3.4e-3;
            assert!((exp_f64(x) / x.exp() - 1.0).abs() < 2e-14, "exp({x})");
        }
    }
}
