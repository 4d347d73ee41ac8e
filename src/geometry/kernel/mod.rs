//! The radial distance for blocks of points: the hot loop of the program.
//!
//! The same formulas as [`Superquadric::derivatives`], which stays the
//! reference, in single precision and branch-free over arrays, so that the
//! compiler vectorises them. In clouds of size 1 to 10 a radial distance is off
//! by less than 2e-5 of itself plus 2e-5 (tested); clouds know no finer. Sums
//! are carried over to double precision. No fused multiply-add: the
//! result is the same bits on every machine, whatever instruction set is chosen
//! at run time.

mod equations;
mod math;

use multiversion::multiversion;
use nalgebra::Point3;

use super::superquadric::{LOG_FLOOR, TAPER_FLOOR};
use super::theta::{PARAMETERS, Superquadric};
pub use equations::{
    NormalEquations, normal_equations, pseudo_huber_normal_equations, weighted_normal_equations,
};
use math::{exp, exp_f64, ln, log_phi, log_phi_value};

/// Points that one step of the inner loops handles: the widest vector register
/// and a multiple of all others.
const LANES: usize = 16;
/// Gradients below this are not divided by: see
/// [`Superquadric::first_order_distance`], which is this distance bounded from
/// below by the way to the body's box.
const SMALLEST_SLOPE: f32 = 0.25;

/// Points as a structure of arrays, in single precision; the last register is
/// filled up with the last point.
#[derive(Debug, Clone, Default)]
pub struct PointBlock {
    x: Vec<[f32; LANES]>,
    y: Vec<[f32; LANES]>,
    z: Vec<[f32; LANES]>,
    len: usize,
}

impl PointBlock {
    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub fn iter(&self) -> impl Iterator<Item = Point3<f64>> {
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|c| c.as_flattened());
        let places = x.iter().zip(y).zip(z).take(self.len);
        places.map(|((&x, &y), &z)| Point3::new(f64::from(x), f64::from(y), f64::from(z)))
    }
}

impl FromIterator<Point3<f64>> for PointBlock {
    fn from_iter<I: IntoIterator<Item = Point3<f64>>>(points: I) -> Self {
        let mut block = Self::default();
        for p in points {
            let lane = block.len % LANES;
            for (axis, v) in [&mut block.x, &mut block.y, &mut block.z].into_iter().zip(p.iter()) {
                let v = *v as f32;
                match axis.last_mut() {
                    Some(last) if lane > 0 => last[lane..].fill(v),
                    _ => axis.push([v; LANES]),
                }
            }
            block.len += 1;
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

/// [`Distance`] for the inner loops, and the first-order distance bounded from
/// below by the way to the body's box.
const RADIAL: u8 = 0;
const FIRST_ORDER: u8 = 1;
const EUCLIDEAN: u8 = 2;

impl Distance {
    fn mode(self) -> u8 {
        match self {
            Self::Radial => RADIAL,
            Self::FirstOrder => FIRST_ORDER,
        }
    }
}

/// The primitive as the inner loop wants it.
struct Coefficients {
    r: [[f32; 3]; 3],
    t: [f32; 3],
    a: [f32; 3],
    inv_a: [f32; 3],
    e1: f32,
    e2: f32,
    inv_e1: f32,
    inv_e2: f32,
    kx: f32,
    ky: f32,
    /// Signs of the tapers, 0 for none.
    sign: [f32; 2],
    reach: [f32; 3],
    floor: f32,
}

impl Coefficients {
    fn new(s: &Superquadric) -> Self {
        let m = s.rotation.matrix();
        let single = |v: nalgebra::Vector3<f64>| -> [f32; 3] { v.map(|c| c as f32).into() };
        let [e1, e2] = s.exponents;
        let sign = |k: f64| if k == 0.0 { 0.0 } else { k.signum() as f32 };
        Self {
            // Columns of R are rows of Rᵀ.
            r: std::array::from_fn(|c| std::array::from_fn(|k| m[(k, c)] as f32)),
            t: single(s.translation),
            a: single(s.semi_axes),
            inv_a: single(s.semi_axes.map(|a| 1.0 / a)),
            e1: e1 as f32,
            e2: e2 as f32,
            inv_e1: (1.0 / e1) as f32,
            inv_e2: (1.0 / e2) as f32,
            kx: s.taper[0] as f32,
            ky: s.taper[1] as f32,
            sign: s.taper.map(sign),
            reach: single(s.reach()),
            floor: (LOG_FLOOR * s.semi_axes.min().powi(2)) as f32,
        }
    }
}

const SQUARE_FLOOR: f32 = LOG_FLOOR as f32;
const LEAST_TAPER: f32 = TAPER_FLOOR as f32;

/// A point's local coordinates.
#[inline(always)]
fn local(c: &Coefficients, x: f32, y: f32, z: f32) -> [f32; 3] {
    let (dx, dy, dz) = (x - c.t[0], y - c.t[1], z - c.t[2]);
    [
        c.r[0][0] * dx + c.r[0][1] * dy + c.r[0][2] * dz,
        c.r[1][0] * dx + c.r[1][1] * dy + c.r[1][2] * dz,
        c.r[2][0] * dx + c.r[2][1] * dy + c.r[2][2] * dz,
    ]
}

/// Signed radial distance alone.
#[inline(always)]
fn radial(c: &Coefficients, x: f32, y: f32, z: f32) -> f32 {
    let [px, py, pz] = local(c, x, y, z);
    let w = (pz * c.inv_a[2]).clamp(-1.0, 1.0);
    let qx = px / (c.kx * w + 1.0).max(LEAST_TAPER);
    let qy = py / (c.ky * w + 1.0).max(LEAST_TAPER);
    let (nx, ny, nz) = (qx * c.inv_a[0], qy * c.inv_a[1], pz * c.inv_a[2]);
    let g = log_phi_value(ln(nx * nx + SQUARE_FLOOR), ln(ny * ny + SQUARE_FLOOR), c.e2, c.inv_e2);
    let h = log_phi_value(g, ln(nz * nz + SQUARE_FLOOR), c.e1, c.inv_e1);
    (qx * qx + qy * qy + pz * pz + c.floor).sqrt() * (exp(-0.5 * h) - 1.0)
}

/// r, the local gradient, and the 13 derivatives.
#[inline(always)]
fn derivatives(c: &Coefficients, p: [f32; 3]) -> (f32, [f32; 3], [f32; PARAMETERS]) {
    let [px, py, pz] = p;
    let [ix, iy, iz] = c.inv_a;
    let raw = pz * iz;
    let w = raw.clamp(-1.0, 1.0);
    let free = if raw.abs() < 1.0 { 1.0 } else { 0.0 };
    let (tx, ty) = (c.kx * w + 1.0, c.ky * w + 1.0);
    let (isx, isy) = (1.0 / tx.max(LEAST_TAPER), 1.0 / ty.max(LEAST_TAPER));
    let fx = if tx > LEAST_TAPER { 1.0 } else { 0.0 };
    let fy = if ty > LEAST_TAPER { 1.0 } else { 0.0 };
    let (qx, qy) = (px * isx, py * isy);
    let (nx, ny) = (qx * ix, qy * iy);
    let (x2, y2, z2) = (nx * nx + SQUARE_FLOOR, ny * ny + SQUARE_FLOOR, raw * raw + SQUARE_FLOOR);
    let (g, psi2, rest2, entropy2) = log_phi(ln(x2), ln(y2), c.e2, c.inv_e2);
    let (h, psi1, rest1, entropy1) = log_phi(g, ln(z2), c.e1, c.inv_e1);

    let n = (qx * qx + qy * qy + pz * pz + c.floor).sqrt();
    let excess = exp(-0.5 * h) - 1.0;
    let r = n * excess;
    let by_h = -0.5 * n * (excess + 1.0);
    let (hx, hy, hz) = (psi1 * psi2, psi1 * rest2, rest1);
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
fn weight<const MODE: u8>(g: [f32; 3]) -> f32 {
    match MODE {
        RADIAL => 1.0,
        _ => 1.0 / (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]).sqrt().max(SMALLEST_SLOPE),
    }
}

/// The distance of one point: signed, but for the Euclidean one.
#[inline(always)]
fn measure_one<const MODE: u8>(c: &Coefficients, x: f32, y: f32, z: f32) -> f32 {
    if MODE == RADIAL {
        return radial(c, x, y, z);
    }
    let p = local(c, x, y, z);
    let (r, g, _) = derivatives(c, p);
    let d = r * weight::<MODE>(g);
    if MODE == FIRST_ORDER {
        return d;
    }
    let over: [f32; 3] = std::array::from_fn(|a| (p[a].abs() - c.reach[a]).max(0.0));
    d.abs().max((over[0] * over[0] + over[1] * over[1] + over[2] * over[2]).sqrt())
}

/// The sum of the lanes, by halves.
#[inline(always)]
fn sum(lanes: &[f32; LANES]) -> f32 {
    let mut lanes = *lanes;
    let mut half = LANES / 2;
    while half > 0 {
        for l in 0..half {
            lanes[l] += lanes[l + half];
        }
        half /= 2;
    }
    lanes[0]
}

/// Signed distances of all points of a block; `out` is overwritten and has the
/// block's length.
pub fn distances(shape: &Superquadric, points: &PointBlock, distance: Distance, out: &mut Vec<f32>) {
    measure_all(shape, points, distance.mode(), out);
}

/// The first-order distances |r|/|∇r|, each at least the way to the body's box:
/// [`Superquadric::first_order_distance`] of a block.
pub fn euclidean_distances(shape: &Superquadric, points: &PointBlock, out: &mut Vec<f32>) {
    measure_all(shape, points, EUCLIDEAN, out);
}

/// [`distances`] of the points from number `from` up to `to`; `from` is a
/// multiple of 16.
pub fn distances_of_some(
    shape: &Superquadric,
    points: &PointBlock,
    (from, to): (usize, usize),
    distance: Distance,
    out: &mut Vec<f32>,
) {
    debug_assert!(from.is_multiple_of(LANES) && from <= to && to <= points.len());
    measure(shape, points, (from, to), distance.mode(), out);
}

fn measure_all(shape: &Superquadric, points: &PointBlock, mode: u8, out: &mut Vec<f32>) {
    measure(shape, points, (0, points.len()), mode, out);
}

fn measure(
    shape: &Superquadric,
    points: &PointBlock,
    (from, to): (usize, usize),
    mode: u8,
    out: &mut Vec<f32>,
) {
    let c = Coefficients::new(shape);
    let range = from / LANES..to.div_ceil(LANES);
    let (x, y, z) = (&points.x[range.clone()], &points.y[range.clone()], &points.z[range]);
    out.clear();
    out.resize(x.len() * LANES, 0.0);
    let (chunks, _) = out.as_chunks_mut::<LANES>();
    match mode {
        RADIAL => radial_pass(&c, x, y, z, chunks),
        FIRST_ORDER => first_order_pass(&c, x, y, z, chunks),
        _ => euclidean_pass(&c, x, y, z, chunks),
    }
    out.truncate(to - from);
}

type Lanes = [f32; LANES];

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn radial_pass(c: &Coefficients, x: &[Lanes], y: &[Lanes], z: &[Lanes], out: &mut [Lanes]) {
    pass::<RADIAL>(c, x, y, z, out);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn first_order_pass(c: &Coefficients, x: &[Lanes], y: &[Lanes], z: &[Lanes], out: &mut [Lanes]) {
    pass::<FIRST_ORDER>(c, x, y, z, out);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn euclidean_pass(c: &Coefficients, x: &[Lanes], y: &[Lanes], z: &[Lanes], out: &mut [Lanes]) {
    pass::<EUCLIDEAN>(c, x, y, z, out);
}

#[inline(always)]
fn pass<const MODE: u8>(c: &Coefficients, x: &[Lanes], y: &[Lanes], z: &[Lanes], out: &mut [Lanes]) {
    for (((out, x), y), z) in out.iter_mut().zip(x).zip(y).zip(z) {
        for l in 0..LANES {
            out[l] = measure_one::<MODE>(c, x[l], y[l], z[l]);
        }
    }
}

/// `factor·exp(−d²/(2σ²))` of each distance d, in double precision: what is far
/// from everything still differs.
pub fn gaussian(distances: &[f32], factor: f64, sigma: f64, out: &mut Vec<f64>) {
    out.clear();
    out.resize(distances.len(), 0.0);
    gaussian_pass(distances, factor, -0.5 / (sigma * sigma), out);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn gaussian_pass(distances: &[f32], factor: f64, exponent: f64, out: &mut [f64]) {
    for (out, d) in out.iter_mut().zip(distances) {
        let d = f64::from(*d);
        let e = exponent * d * d;
        // Below this the true value is under 1e-300: no point can tell it from 0.
        *out = if e < -690.0 { 0.0 } else { factor * exp_f64(e) };
    }
}

/// Σ d² over the block.
pub fn cost(shape: &Superquadric, points: &PointBlock, distance: Distance) -> f64 {
    total(shape, points, distance.mode(), 0.0)
}

/// Σ w·d² over the block, one weight a point.
pub fn weighted_cost(shape: &Superquadric, points: &PointBlock, weights: &[f64], distance: Distance) -> f64 {
    let mut d = Vec::new();
    distances(shape, points, distance, &mut d);
    d.iter().zip(weights).map(|(&d, w)| w * f64::from(d * d)).sum()
}

/// Σ (√(d² + δ²) − δ) over the block, d as in [`euclidean_distances`] and
/// δ = `rounding`.
pub fn pseudo_huber_cost(shape: &Superquadric, points: &PointBlock, rounding: f64) -> f64 {
    total(shape, points, EUCLIDEAN, rounding as f32)
}

fn total(shape: &Superquadric, points: &PointBlock, mode: u8, delta: f32) -> f64 {
    /// Registers of points between two carries to double precision.
    const CARRY: usize = 64;
    let c = Coefficients::new(shape);
    let mut total = 0.0;
    let mut from = 0;
    while from < points.x.len() {
        let to = (from + CARRY).min(points.x.len());
        let (x, y, z) = (&points.x[from..to], &points.y[from..to], &points.z[from..to]);
        let valid = points.len - from * LANES;
        total += f64::from(match mode {
            RADIAL => radial_cost(&c, x, y, z, valid),
            FIRST_ORDER => first_order_cost(&c, x, y, z, valid),
            _ => euclidean_cost(&c, x, y, z, valid, delta),
        });
        from = to;
    }
    total
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn radial_cost(c: &Coefficients, x: &[Lanes], y: &[Lanes], z: &[Lanes], valid: usize) -> f32 {
    add_up::<RADIAL>(c, x, y, z, valid, 0.0)
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn first_order_cost(c: &Coefficients, x: &[Lanes], y: &[Lanes], z: &[Lanes], valid: usize) -> f32 {
    add_up::<FIRST_ORDER>(c, x, y, z, valid, 0.0)
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn euclidean_cost(c: &Coefficients, x: &[Lanes], y: &[Lanes], z: &[Lanes], valid: usize, delta: f32) -> f32 {
    add_up::<EUCLIDEAN>(c, x, y, z, valid, delta)
}

/// The costs of the first `valid` points.
#[inline(always)]
fn add_up<const MODE: u8>(
    c: &Coefficients,
    x: &[Lanes],
    y: &[Lanes],
    z: &[Lanes],
    valid: usize,
    delta: f32,
) -> f32 {
    let mut sums = [0.0f32; LANES];
    for (k, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
        let mut costs = [0.0f32; LANES];
        for l in 0..LANES {
            let d = measure_one::<MODE>(c, x[l], y[l], z[l]);
            costs[l] = if MODE == EUCLIDEAN { (d * d + delta * delta).sqrt() - delta } else { d * d };
        }
        // What repeats the last point doesn't count.
        for cost in costs.iter_mut().skip(valid - k * LANES) {
            *cost = 0.0;
        }
        for l in 0..LANES {
            sums[l] += costs[l];
        }
    }
    sum(&sums)
}

#[cfg(test)]
mod tests;
