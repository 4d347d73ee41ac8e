//! Normal equations: residuals and derivatives of a few points at a time,
//! summed at once. N×13 is never held.

use multiversion::multiversion;
use nalgebra::{SMatrix, SVector, Vector3};

use super::{
    Coefficients, Distance, EUCLIDEAN, FIRST_ORDER, LANES, PointBlock, RADIAL, derivatives, local, weight,
};
use crate::geometry::theta::{PARAMETERS, Superquadric};

/// Registers' worth of points whose derivatives are held at a time.
const CHUNKS: usize = 4;
/// After so many times that, the sums are carried over to double precision.
const CARRY: usize = 16;

/// JᵀJ, Jᵀr and Σr² of a block of points, and their box in the primitive's
/// frame. Where r is divided by a slope or a size, that is held constant in J,
/// as in iteratively reweighted least squares.
#[derive(Debug, Clone)]
pub struct NormalEquations {
    pub jtj: SMatrix<f64, PARAMETERS, PARAMETERS>,
    pub jtr: SVector<f64, PARAMETERS>,
    pub cost: f64,
    pub low: Vector3<f64>,
    pub high: Vector3<f64>,
}

/// The normal equations of Σ d².
pub fn normal_equations(shape: &Superquadric, points: &PointBlock, distance: Distance) -> NormalEquations {
    equations(shape, points, None, distance.mode(), 0.0)
}

/// The normal equations of Σ w·d², one weight a point: JᵀWJ, JᵀWr and the
/// weighted cost. The box is that of all points.
pub fn weighted_normal_equations(
    shape: &Superquadric,
    points: &PointBlock,
    weights: &[f64],
    distance: Distance,
) -> NormalEquations {
    equations(shape, points, Some(weights), distance.mode(), 0.0)
}

/// The normal equations of Σ (√(d² + δ²) − δ), d as in
/// [`super::euclidean_distances`] and δ = `rounding`, each point weighted by
/// 1/√(d² + δ²).
pub fn pseudo_huber_normal_equations(
    shape: &Superquadric,
    points: &PointBlock,
    rounding: f64,
) -> NormalEquations {
    equations(shape, points, None, EUCLIDEAN, rounding)
}

fn equations(
    shape: &Superquadric,
    points: &PointBlock,
    weights: Option<&[f64]>,
    mode: u8,
    rounding: f64,
) -> NormalEquations {
    let c = Coefficients::new(shape);
    let mut total = Total::default();
    let mut sums = Sums::default();
    let chunks = points.x.len();
    for (turn, from) in (0..chunks).step_by(CHUNKS).enumerate() {
        let to = (from + CHUNKS).min(chunks);
        let few = Few {
            at: [&points.x[from..to], &points.y[from..to], &points.z[from..to]],
            weights: weights.map(|w| &w[from * LANES..(to * LANES).min(points.len())]),
            valid: points.len() - from * LANES,
        };
        match mode {
            RADIAL => accumulate_radial(&c, few, &mut sums),
            FIRST_ORDER => accumulate_first_order(&c, few, &mut sums),
            _ => accumulate_euclidean(&c, few, rounding as f32, &mut sums),
        }
        if (turn + 1).is_multiple_of(CARRY) {
            total.carry(&mut sums);
        }
    }
    total.carry(&mut sums);
    let fold = |lanes: &[[f32; LANES]; 3], f: fn(f32, f32) -> f32| {
        Vector3::from(lanes.map(|l| f64::from(l.into_iter().reduce(f).unwrap_or(0.0))))
    };
    NormalEquations {
        jtj: SMatrix::from_fn(|i, j| total.jtj[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)]),
        jtr: SVector::from(total.jtr),
        cost: total.cost,
        low: fold(&sums.low, f32::min),
        high: fold(&sums.high, f32::max),
    }
}

const ENTRIES: usize = PARAMETERS * (PARAMETERS + 1) / 2;

/// Lane-wise partial sums; the lower triangle of JᵀJ row by row.
struct Sums {
    jtj: [[f32; LANES]; ENTRIES],
    jtr: [[f32; LANES]; PARAMETERS],
    cost: [f32; LANES],
    low: [[f32; LANES]; 3],
    high: [[f32; LANES]; 3],
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            jtj: [[0.0; LANES]; ENTRIES],
            jtr: [[0.0; LANES]; PARAMETERS],
            cost: [0.0; LANES],
            low: [[f32::INFINITY; LANES]; 3],
            high: [[f32::NEG_INFINITY; LANES]; 3],
        }
    }
}

struct Total {
    jtj: [f64; ENTRIES],
    jtr: [f64; PARAMETERS],
    cost: f64,
}

impl Default for Total {
    fn default() -> Self {
        Self { jtj: [0.0; ENTRIES], jtr: [0.0; PARAMETERS], cost: 0.0 }
    }
}

impl Total {
    /// Takes over the partial sums, which start anew.
    fn carry(&mut self, sums: &mut Sums) {
        let take = |total: &mut f64, lanes: &mut [f32; LANES]| {
            *total += f64::from(super::sum(lanes));
            *lanes = [0.0; LANES];
        };
        self.jtj.iter_mut().zip(&mut sums.jtj).for_each(|(t, lanes)| take(t, lanes));
        self.jtr.iter_mut().zip(&mut sums.jtr).for_each(|(t, lanes)| take(t, lanes));
        take(&mut self.cost, &mut sums.cost);
    }
}

/// At most [`CHUNKS`] registers of points, of which the first `valid` count.
#[derive(Clone, Copy)]
struct Few<'a> {
    at: [&'a [[f32; LANES]]; 3],
    weights: Option<&'a [f64]>,
    valid: usize,
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn accumulate_radial(c: &Coefficients, few: Few<'_>, sums: &mut Sums) {
    accumulate::<RADIAL>(c, few, 0.0, sums);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn accumulate_first_order(c: &Coefficients, few: Few<'_>, sums: &mut Sums) {
    accumulate::<FIRST_ORDER>(c, few, 0.0, sums);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512bw+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn accumulate_euclidean(c: &Coefficients, few: Few<'_>, delta: f32, sums: &mut Sums) {
    accumulate::<EUCLIDEAN>(c, few, delta, sums);
}

#[inline(always)]
fn accumulate<const MODE: u8>(c: &Coefficients, few: Few<'_>, delta: f32, sums: &mut Sums) {
    const POINTS: usize = CHUNKS * LANES;
    let mut j = [[0.0f32; POINTS]; PARAMETERS];
    let mut r = [0.0f32; POINTS];
    let mut cost = [0.0f32; POINTS];
    let [x, y, z] = few.at;
    let chunks = x.len().min(CHUNKS);
    for k in 0..chunks {
        let (x, y, z) = (&x[k], &y[k], &z[k]);
        for l in 0..LANES {
            let i = k * LANES + l;
            let p = local(c, x[l], y[l], z[l]);
            for ((low, high), v) in sums.low.iter_mut().zip(&mut sums.high).zip(p) {
                low[l] = low[l].min(v);
                high[l] = high[l].max(v);
            }
            let (radial, g, mut row) = derivatives(c, p);
            let w = weight::<MODE>(g);
            let mut d = radial * w;
            for v in &mut row {
                *v *= w;
            }
            if MODE == EUCLIDEAN {
                let over: [f32; 3] = std::array::from_fn(|a| (p[a].abs() - c.reach[a]).max(0.0));
                let beyond = (over[0] * over[0] + over[1] * over[1] + over[2] * over[2]).sqrt();
                let is_beyond = beyond > d.abs();
                let from_box = box_row(c, p, over, beyond);
                for (v, b) in row.iter_mut().zip(from_box) {
                    *v = if is_beyond { b } else { *v };
                }
                d = if is_beyond { beyond } else { d };
                let size = (d * d + delta * delta).sqrt();
                cost[i] = size - delta;
                let root = (1.0 / size).sqrt();
                for v in &mut row {
                    *v *= root;
                }
                r[i] = d * root;
            } else {
                cost[i] = d * d;
                r[i] = d;
            }
            for (column, v) in j.iter_mut().zip(row) {
                column[i] = v;
            }
        }
    }
    // What repeats the last point doesn't count.
    for i in few.valid.min(POINTS)..chunks * LANES {
        (r[i], cost[i]) = (0.0, 0.0);
        for column in &mut j {
            column[i] = 0.0;
        }
    }
    if let Some(weights) = few.weights {
        for (i, w) in weights.iter().enumerate() {
            let w = *w as f32;
            let root = w.sqrt();
            r[i] *= root;
            cost[i] *= w;
            for column in &mut j {
                column[i] *= root;
            }
        }
    }
    for k in 0..chunks {
        for l in 0..LANES {
            sums.cost[l] += cost[k * LANES + l];
        }
    }
    let mut entry = 0;
    for a in 0..PARAMETERS {
        let mut g = sums.jtr[a];
        for k in 0..chunks {
            for l in 0..LANES {
                g[l] += j[a][k * LANES + l] * r[k * LANES + l];
            }
        }
        sums.jtr[a] = g;
        for b in 0..=a {
            let mut s = sums.jtj[entry];
            for k in 0..chunks {
                for l in 0..LANES {
                    s[l] += j[a][k * LANES + l] * j[b][k * LANES + l];
                }
            }
            sums.jtj[entry] = s;
            entry += 1;
        }
    }
}

/// ∂/∂θ of the way from a local point outside to the box that holds the body,
/// |(|p| − a·(1 + |k|))₊|, of which `over` are the components and `beyond` is
/// the length: in θ's order, the pose by its right perturbation.
#[inline(always)]
fn box_row(c: &Coefficients, p: [f32; 3], over: [f32; 3], beyond: f32) -> [f32; PARAMETERS] {
    let inverse = 1.0 / beyond.max(f32::MIN_POSITIVE);
    let u = over.map(|v| v * inverse);
    let g: [f32; 3] = std::array::from_fn(|a| u[a].copysign(p[a]));
    [
        0.0,
        0.0,
        -u[0] * (1.0 + c.kx.abs()),
        -u[1] * (1.0 + c.ky.abs()),
        -u[2],
        g[1] * p[2] - g[2] * p[1],
        g[2] * p[0] - g[0] * p[2],
        g[0] * p[1] - g[1] * p[0],
        -g[0],
        -g[1],
        -g[2],
        -u[0] * c.a[0] * c.sign[0],
        -u[1] * c.a[1] * c.sign[1],
    ]
}
