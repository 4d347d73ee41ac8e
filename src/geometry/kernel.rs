//! The radial distance for blocks of points: the hot loop of the program.
//!
//! The same formulas as [`Superquadric::derivatives`], which stays the
//! reference, written branch-free over arrays so that the compiler vectorises
//! them, with polynomial logarithm and exponential (absolute error under
//! 1e-13, tested). No fused multiply-add: the result is the same bits on every
//! machine, whatever instruction set is chosen at run time.

use multiversion::multiversion;
use nalgebra::{Point3, SMatrix, SVector, Vector3};

use super::superquadric::{LOG_FLOOR, PARAMETERS, Superquadric, TAPER_FLOOR};

/// Points that one pass of the inner loop handles.
const BLOCK: usize = 64;
/// Independent partial sums: one vector register's worth and more.
const LANES: usize = 8;
/// Gradients below this are not divided by: see
/// [`Superquadric::first_order_distance`], which is this distance bounded from
/// below by the way to the body's box.
pub(crate) const SMALLEST_SLOPE: f64 = 0.25;

/// Points as a structure of arrays.
#[derive(Debug, Clone, Default)]
pub struct PointBlock {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl PointBlock {
    pub fn len(&self) -> usize {
        self.x.len()
    }

    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    pub fn iter(&self) -> impl Iterator<Item = Point3<f64>> {
        self.x.iter().zip(&self.y).zip(&self.z).map(|((&x, &y), &z)| Point3::new(x, y, z))
    }
}

impl FromIterator<Point3<f64>> for PointBlock {
    fn from_iter<I: IntoIterator<Item = Point3<f64>>>(points: I) -> Self {
        let mut block = Self::default();
        for p in points {
            block.x.push(p.x);
            block.y.push(p.y);
            block.z.push(p.z);
        }
        block
    }
}

/// What a residual measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Distance {
    /// The paper's signed radial distance r.
    Radial,
    /// r/|∇r|, the signed first-order Euclidean distance.
    FirstOrder,
}

/// JᵀJ, Jᵀr and Σr² of a block of points, and their box in the primitive's
/// frame. For [`Distance::FirstOrder`] the weight 1/|∇r| is held constant in
/// J, as in iteratively reweighted least squares.
#[derive(Debug, Clone)]
pub struct NormalEquations {
    pub jtj: SMatrix<f64, PARAMETERS, PARAMETERS>,
    pub jtr: SVector<f64, PARAMETERS>,
    pub cost: f64,
    pub low: Vector3<f64>,
    pub high: Vector3<f64>,
}

/// The primitive as the inner loop wants it.
struct Coefficients {
    r: [[f64; 3]; 3],
    t: [f64; 3],
    inv_a: [f64; 3],
    e1: f64,
    e2: f64,
    inv_e1: f64,
    inv_e2: f64,
    kx: f64,
    ky: f64,
    floor: f64,
}

impl Coefficients {
    fn new(s: &Superquadric) -> Self {
        let m = s.rotation.matrix();
        Self {
            // Columns of R are rows of Rᵀ.
            r: std::array::from_fn(|c| std::array::from_fn(|k| m[(k, c)])),
            t: s.translation.into(),
            inv_a: s.semi_axes.map(|a| 1.0 / a).into(),
            e1: s.exponents[0],
            e2: s.exponents[1],
            inv_e1: 1.0 / s.exponents[0],
            inv_e2: 1.0 / s.exponents[1],
            kx: s.taper[0],
            ky: s.taper[1],
            floor: LOG_FLOOR * s.semi_axes.min().powi(2),
        }
    }
}

/// e^x for x in about [−745, 700]; clamped below.
#[inline(always)]
fn exp(x: f64) -> f64 {
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5·2⁵²: the sum's low bits are the integer
    let x = x.max(-700.0);
    let shifted = x * std::f64::consts::LOG2_E + MAGIC;
    let k = shifted - MAGIC;
    // ln 2 in two parts, so that x − k·ln 2 keeps its low bits.
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

/// ln x for positive normal x.
#[inline(always)]
fn ln(x: f64) -> f64 {
    // x = 2^k·m with m in [√½, √2).
    const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    let shifted = x.to_bits().wrapping_sub(SQRT_HALF).wrapping_add(1024 << 52);
    let k = f64::from_bits((shifted >> 52) | 0x4330_0000_0000_0000) - (4_503_599_627_370_496.0 + 1024.0);
    let m = f64::from_bits((shifted & 0x000f_ffff_ffff_ffff).wrapping_add(SQRT_HALF));
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let mut p = 1.0 / 19.0;
    let mut d = 19.0;
    while d > 1.0 {
        d -= 2.0;
        p = p * s2 + 1.0 / d;
    }
    k * std::f64::consts::LN_2 + 2.0 * s * p
}

/// ln φ(u, v; ε), ψ and the entropy of ψ; see [`super::superquadric`].
#[inline(always)]
fn log_phi(u: f64, v: f64, eps: f64, inv_eps: f64) -> (f64, f64, f64) {
    let delta = (u - v) * inv_eps;
    let size = delta.abs();
    let e = exp(-size);
    let l = ln(1.0 + e);
    let small = e / (1.0 + e);
    let psi = if delta >= 0.0 { 1.0 - small } else { small };
    (u.max(v) + eps * l, psi, l + size * small)
}

#[inline(always)]
fn log_phi_value(u: f64, v: f64, eps: f64, inv_eps: f64) -> f64 {
    u.max(v) + eps * ln(1.0 + exp(-((u - v) * inv_eps).abs()))
}

/// A point's local coordinates.
#[inline(always)]
fn local(c: &Coefficients, x: f64, y: f64, z: f64) -> [f64; 3] {
    let (dx, dy, dz) = (x - c.t[0], y - c.t[1], z - c.t[2]);
    [
        c.r[0][0] * dx + c.r[0][1] * dy + c.r[0][2] * dz,
        c.r[1][0] * dx + c.r[1][1] * dy + c.r[1][2] * dz,
        c.r[2][0] * dx + c.r[2][1] * dy + c.r[2][2] * dz,
    ]
}

/// Signed radial distance alone.
#[inline(always)]
fn radial(c: &Coefficients, x: f64, y: f64, z: f64) -> f64 {
    let [px, py, pz] = local(c, x, y, z);
    let w = (pz * c.inv_a[2]).clamp(-1.0, 1.0);
    let qx = px / (c.kx * w + 1.0).max(TAPER_FLOOR);
    let qy = py / (c.ky * w + 1.0).max(TAPER_FLOOR);
    let (nx, ny, nz) = (qx * c.inv_a[0], qy * c.inv_a[1], pz * c.inv_a[2]);
    let g = log_phi_value(ln(nx * nx + LOG_FLOOR), ln(ny * ny + LOG_FLOOR), c.e2, c.inv_e2);
    let h = log_phi_value(g, ln(nz * nz + LOG_FLOOR), c.e1, c.inv_e1);
    (qx * qx + qy * qy + pz * pz + c.floor).sqrt() * (exp(-0.5 * h) - 1.0)
}

/// r, the local gradient, and the 13 derivatives.
#[inline(always)]
fn derivatives(c: &Coefficients, p: [f64; 3]) -> (f64, [f64; 3], [f64; PARAMETERS]) {
    let [px, py, pz] = p;
    let [ix, iy, iz] = c.inv_a;
    let raw = pz * iz;
    let w = raw.clamp(-1.0, 1.0);
    let free = if raw.abs() < 1.0 { 1.0 } else { 0.0 };
    let (tx, ty) = (c.kx * w + 1.0, c.ky * w + 1.0);
    let (isx, isy) = (1.0 / tx.max(TAPER_FLOOR), 1.0 / ty.max(TAPER_FLOOR));
    let fx = if tx > TAPER_FLOOR { 1.0 } else { 0.0 };
    let fy = if ty > TAPER_FLOOR { 1.0 } else { 0.0 };
    let (qx, qy) = (px * isx, py * isy);
    let (nx, ny) = (qx * ix, qy * iy);
    let (x2, y2, z2) = (nx * nx + LOG_FLOOR, ny * ny + LOG_FLOOR, raw * raw + LOG_FLOOR);
    let (g, psi2, entropy2) = log_phi(ln(x2), ln(y2), c.e2, c.inv_e2);
    let (h, psi1, entropy1) = log_phi(g, ln(z2), c.e1, c.inv_e1);

    let n = (qx * qx + qy * qy + pz * pz + c.floor).sqrt();
    let excess = exp(-0.5 * h) - 1.0;
    let r = n * excess;
    let by_h = -0.5 * n * (excess + 1.0);
    let (hx, hy, hz) = (psi1 * psi2, psi1 * (1.0 - psi2), 1.0 - psi1);
    // Twice ∂r/∂h·∂h/∂u, over the floored square: shared by ∂/∂q and ∂/∂a.
    let (ux, uy, uz) = (2.0 * by_h * hx / x2, 2.0 * by_h * hy / y2, 2.0 * by_h * hz / z2);
    let pull = excess / n;
    let gx = qx * (pull + ux * ix * ix);
    let gy = qy * (pull + uy * iy * iy);
    let gz = pz * (pull + uz * iz * iz);
    let by_sx = -gx * qx * isx * fx;
    let by_sy = -gy * qy * isy * fy;
    let by_w = free * (by_sx * c.kx + by_sy * c.ky);
    let gp = [gx * isx, gy * isy, gz + by_w * iz];
    let parameters = [
        by_h * entropy1,
        by_h * psi1 * entropy2,
        -ux * nx * nx * ix,
        -uy * ny * ny * iy,
        -uz * raw * raw * iz - by_w * raw * iz,
        gp[1] * pz - gp[2] * py,
        gp[2] * px - gp[0] * pz,
        gp[0] * py - gp[1] * px,
        -gp[0],
        -gp[1],
        -gp[2],
        by_sx * w,
        by_sy * w,
    ];
    (r, gp, parameters)
}

/// What r is multiplied by where the local gradient is `g`.
#[inline(always)]
fn weight(distance: Distance, g: [f64; 3]) -> f64 {
    match distance {
        Distance::Radial => 1.0,
        Distance::FirstOrder => 1.0 / (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]).sqrt().max(SMALLEST_SLOPE),
    }
}

/// Signed distances of all points of a block, appended nowhere: `out` is
/// overwritten and has the block's length.
pub fn distances(shape: &Superquadric, points: &PointBlock, distance: Distance, out: &mut Vec<f64>) {
    out.resize(points.len(), 0.0);
    let c = Coefficients::new(shape);
    match distance {
        Distance::Radial => radial_pass(&c, &points.x, &points.y, &points.z, out),
        Distance::FirstOrder => first_order_pass(&c, &points.x, &points.y, &points.z, out),
    }
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn radial_pass(c: &Coefficients, x: &[f64], y: &[f64], z: &[f64], out: &mut [f64]) {
    for (((o, &x), &y), &z) in out.iter_mut().zip(x).zip(y).zip(z) {
        *o = radial(c, x, y, z);
    }
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn first_order_pass(c: &Coefficients, x: &[f64], y: &[f64], z: &[f64], out: &mut [f64]) {
    for (((o, &x), &y), &z) in out.iter_mut().zip(x).zip(y).zip(z) {
        let (r, g, _) = derivatives(c, local(c, x, y, z));
        *o = r * weight(Distance::FirstOrder, g);
    }
}

/// The first-order distances |r|/|∇r|, each at least the way to the body's box:
/// [`Superquadric::first_order_distance`] of a block.
pub fn euclidean_distances(shape: &Superquadric, points: &PointBlock, out: &mut Vec<f64>) {
    out.resize(points.len(), 0.0);
    let c = Coefficients::new(shape);
    euclidean_pass(&c, shape.reach().into(), &points.x, &points.y, &points.z, out);
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn euclidean_pass(c: &Coefficients, reach: [f64; 3], x: &[f64], y: &[f64], z: &[f64], out: &mut [f64]) {
    for (((o, &x), &y), &z) in out.iter_mut().zip(x).zip(y).zip(z) {
        let p = local(c, x, y, z);
        let (r, g, _) = derivatives(c, p);
        let over: [f64; 3] = std::array::from_fn(|i| (p[i].abs() - reach[i]).max(0.0));
        let beyond = (over[0] * over[0] + over[1] * over[1] + over[2] * over[2]).sqrt();
        *o = (r * weight(Distance::FirstOrder, g)).abs().max(beyond);
    }
}

/// Replaces each signed distance d by `factor·exp(−d²/(2σ²))`.
pub fn gaussian(distances: &mut [f64], factor: f64, sigma: f64) {
    gaussian_pass(distances, factor, -0.5 / (sigma * sigma));
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn gaussian_pass(values: &mut [f64], factor: f64, exponent: f64) {
    for v in values {
        let e = exponent * *v * *v;
        // Below this the true value is under 1e-300: no point can tell it from 0.
        *v = if e < -690.0 { 0.0 } else { factor * exp(e) };
    }
}

/// Σ d² over the block.
pub fn cost(shape: &Superquadric, points: &PointBlock, distance: Distance) -> f64 {
    sum_of_blocks(shape, points, distance, |_, d| d.iter().map(|d| d * d).sum())
}

/// Σ w·d² over the block, one weight a point.
pub fn weighted_cost(shape: &Superquadric, points: &PointBlock, weights: &[f64], distance: Distance) -> f64 {
    sum_of_blocks(shape, points, distance, |from, d| {
        d.iter().zip(&weights[from..from + d.len()]).map(|(d, w)| w * d * d).sum()
    })
}

/// The sum of what `add` makes of the index of the first point and the
/// distances of each few points: all of them are never held.
fn sum_of_blocks(
    shape: &Superquadric,
    points: &PointBlock,
    distance: Distance,
    add: impl Fn(usize, &[f64]) -> f64,
) -> f64 {
    let mut sum = 0.0;
    let c = Coefficients::new(shape);
    let mut buffer = [0.0; BLOCK];
    let mut from = 0;
    while from < points.len() {
        let to = (from + BLOCK).min(points.len());
        let out = &mut buffer[..to - from];
        let (x, y, z) = (&points.x[from..to], &points.y[from..to], &points.z[from..to]);
        match distance {
            Distance::Radial => radial_pass(&c, x, y, z, out),
            Distance::FirstOrder => first_order_pass(&c, x, y, z, out),
        }
        sum += add(from, out);
        from = to;
    }
    sum
}

/// The normal equations of a block; N×13 is never held.
pub fn normal_equations(shape: &Superquadric, points: &PointBlock, distance: Distance) -> NormalEquations {
    equations(shape, points, None, distance)
}

/// The normal equations of Σ w·d², one weight a point: JᵀWJ, JᵀWr and the
/// weighted cost. The box is that of all points.
pub fn weighted_normal_equations(
    shape: &Superquadric,
    points: &PointBlock,
    weights: &[f64],
    distance: Distance,
) -> NormalEquations {
    equations(shape, points, Some(weights), distance)
}

fn equations(
    shape: &Superquadric,
    points: &PointBlock,
    weights: Option<&[f64]>,
    distance: Distance,
) -> NormalEquations {
    let c = Coefficients::new(shape);
    let mut sums = Sums::default();
    let mut from = 0;
    while from < points.len() {
        let to = (from + BLOCK).min(points.len());
        let (x, y, z) = (&points.x[from..to], &points.y[from..to], &points.z[from..to]);
        accumulate(&c, x, y, z, weights.map(|w| &w[from..to]), distance, &mut sums);
        from = to;
    }
    let total = |lanes: &[f64; LANES]| lanes.iter().sum::<f64>();
    let entry = |i: usize, j: usize| total(&sums.jtj[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)]);
    let fold = |lanes: &[[f64; LANES]; 3], f: fn(f64, f64) -> f64| {
        Vector3::from(lanes.map(|l| l.into_iter().reduce(f).unwrap_or(0.0)))
    };
    NormalEquations {
        jtj: SMatrix::from_fn(entry),
        jtr: SVector::from_fn(|i, _| total(&sums.jtr[i])),
        cost: total(&sums.cost),
        low: fold(&sums.low, f64::min),
        high: fold(&sums.high, f64::max),
    }
}

/// Lane-wise partial sums; the lower triangle of JᵀJ row by row.
struct Sums {
    jtj: [[f64; LANES]; PARAMETERS * (PARAMETERS + 1) / 2],
    jtr: [[f64; LANES]; PARAMETERS],
    cost: [f64; LANES],
    low: [[f64; LANES]; 3],
    high: [[f64; LANES]; 3],
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            jtj: [[0.0; LANES]; PARAMETERS * (PARAMETERS + 1) / 2],
            jtr: [[0.0; LANES]; PARAMETERS],
            cost: [0.0; LANES],
            low: [[f64::INFINITY; LANES]; 3],
            high: [[f64::NEG_INFINITY; LANES]; 3],
        }
    }
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn accumulate(
    c: &Coefficients,
    x: &[f64],
    y: &[f64],
    z: &[f64],
    weights: Option<&[f64]>,
    distance: Distance,
    sums: &mut Sums,
) {
    let mut j = [[0.0; BLOCK]; PARAMETERS];
    let mut p = [[0.0; BLOCK]; 3];
    let mut r = [0.0; BLOCK];
    let n = x.len().min(BLOCK);
    for i in 0..n {
        let at = local(c, x[i], y[i], z[i]);
        let (ri, g, d) = derivatives(c, at);
        let w = weight(distance, g);
        r[i] = ri * w;
        for k in 0..PARAMETERS {
            j[k][i] = d[k] * w;
        }
        for k in 0..3 {
            p[k][i] = at[k];
        }
    }
    if let Some(weights) = weights {
        for i in 0..n {
            let root = weights[i].sqrt();
            r[i] *= root;
            for column in &mut j {
                column[i] *= root;
            }
        }
    }
    // The tail of a short block is zero in J and r; for the box it repeats a point.
    let padded = n.next_multiple_of(LANES);
    for axis in &mut p {
        for i in n..padded {
            axis[i] = axis[0];
        }
    }
    for from in (0..padded).step_by(LANES) {
        for l in 0..LANES {
            sums.cost[l] += r[from + l] * r[from + l];
        }
        for ((low, high), axis) in sums.low.iter_mut().zip(&mut sums.high).zip(&p) {
            for l in 0..LANES {
                low[l] = low[l].min(axis[from + l]);
                high[l] = high[l].max(axis[from + l]);
            }
        }
    }
    let mut entry = 0;
    for a in 0..PARAMETERS {
        let mut g = sums.jtr[a];
        for from in (0..padded).step_by(LANES) {
            for l in 0..LANES {
                g[l] += j[a][from + l] * r[from + l];
            }
        }
        sums.jtr[a] = g;
        for b in 0..=a {
            let mut s = sums.jtj[entry];
            for from in (0..padded).step_by(LANES) {
                for l in 0..LANES {
                    s[l] += j[a][from + l] * j[b][from + l];
                }
            }
            sums.jtj[entry] = s;
            entry += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use rand::{RngExt, SeedableRng};

    fn shapes() -> Vec<Superquadric> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        (0..60)
            .map(|_| Superquadric {
                exponents: [rng.random_range(0.1..1.9), rng.random_range(0.1..1.9)],
                semi_axes: Vector3::from_fn(|_, _| rng.random_range(0.02..3.0)),
                rotation: Rotation3::from_euler_angles(rng.random(), rng.random(), rng.random()),
                translation: Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)),
                taper: [rng.random_range(-0.95..0.95), rng.random_range(-0.95..0.95)],
            })
            .collect()
    }

    fn points(n: usize) -> PointBlock {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(6);
        (0..n).map(|_| Point3::from(Vector3::from_fn(|_, _| rng.random_range(-4.0..4.0)))).collect()
    }

    #[test]
    fn logarithm_and_exponential_keep_their_error() {
        for i in 0..200_000 {
            let x = -690.0 + f64::from(i) * 7e-3;
            if x < 690.0 {
                assert!((exp(x) / x.exp() - 1.0).abs() < 2e-14, "exp({x})");
            }
            let y = (f64::from(i) * 3e-4 - 30.0).exp();
            assert!((ln(y) - y.ln()).abs() < 1e-13 * (1.0 + y.ln().abs()), "ln({y})");
        }
    }

    #[test]
    fn blocks_agree_with_the_reference() {
        let block = points(131);
        let mut out = Vec::new();
        for shape in shapes() {
            distances(&shape, &block, Distance::Radial, &mut out);
            for (p, r) in block.iter().zip(&out) {
                let expected = shape.radial_distance(&p);
                assert!((r - expected).abs() <= 1e-10 * (1.0 + expected.abs()), "{r} {expected}");
            }
            distances(&shape, &block, Distance::FirstOrder, &mut out);
            for (p, d) in block.iter().zip(&out) {
                let at = shape.derivatives(&p);
                let expected = at.r.abs() / at.local_gradient.norm().max(SMALLEST_SLOPE);
                assert!((d.abs() - expected).abs() <= 1e-9 * (1.0 + expected), "{d} {expected}");
            }
        }
    }

    #[test]
    fn normal_equations_agree_with_the_sum_over_points() {
        // Not a multiple of the block or the lanes: the tail counts too.
        let block = points(203);
        for shape in shapes() {
            for distance in [Distance::Radial, Distance::FirstOrder] {
                let found = normal_equations(&shape, &block, distance);
                let mut jtj = SMatrix::<f64, PARAMETERS, PARAMETERS>::zeros();
                let mut jtr = SVector::<f64, PARAMETERS>::zeros();
                let mut low = Vector3::repeat(f64::INFINITY);
                for x in block.iter() {
                    let d = shape.derivatives(&x);
                    let w = match distance {
                        Distance::Radial => 1.0,
                        Distance::FirstOrder => 1.0 / d.local_gradient.norm().max(SMALLEST_SLOPE),
                    };
                    let j = SVector::from(d.parameters) * w;
                    jtj += j * j.transpose();
                    jtr += j * d.r * w;
                    low = low.inf(&shape.local(&x));
                }
                assert!((found.jtj - jtj).norm() <= 1e-9 * jtj.norm());
                assert!((found.jtr - jtr).norm() <= 1e-9 * (1.0 + jtr.norm()));
                assert!((found.low - low).norm() < 1e-12);
                assert!((found.cost - cost(&shape, &block, distance)).abs() <= 1e-9 * found.cost);
            }
        }
    }

    /// Whole weights are repeated points.
    #[test]
    fn a_weight_counts_as_so_many_points() {
        let once = points(150);
        let weights: Vec<f64> = (0..once.len()).map(|i| (i % 4) as f64).collect();
        let often: PointBlock =
            once.iter().enumerate().flat_map(|(i, p)| std::iter::repeat_n(p, i % 4)).collect();
        for shape in shapes() {
            for distance in [Distance::Radial, Distance::FirstOrder] {
                let weighted = weighted_normal_equations(&shape, &once, &weights, distance);
                let repeated = normal_equations(&shape, &often, distance);
                assert!((weighted.jtj - repeated.jtj).norm() <= 1e-9 * repeated.jtj.norm());
                assert!((weighted.jtr - repeated.jtr).norm() <= 1e-9 * (1.0 + repeated.jtr.norm()));
                let sum = weighted_cost(&shape, &once, &weights, distance);
                assert!((weighted.cost - sum).abs() <= 1e-9 * sum);
                assert!((repeated.cost - sum).abs() <= 1e-9 * sum);
            }
        }
    }
}
