//! Temporary.
use super::Superquadric;
use nalgebra::{Point3, Vector3};

fn grid(shape: &Superquadric) -> Vec<Vec<Point3<f64>>> {
    let curve = |e: f64, from: f64, to: f64, n: usize| -> Vec<(f64, f64)> {
        (0..=n)
            .map(|i| {
                let a = from + (to - from) * i as f64 / n as f64;
                let (s, c) = a.sin_cos();
                let m = c.abs().max(s.abs());
                let rho =
                    1.0 / (m * ((c.abs() / m).powf(2.0 / e) + (s.abs() / m).powf(2.0 / e)).powf(e / 2.0));
                (c * rho, s * rho)
            })
            .collect()
    };
    use std::f64::consts::PI;
    let profile = curve(shape.exponents[0], -PI / 2.0, PI / 2.0, 16);
    let section = curve(shape.exponents[1], 0.0, 2.0 * PI, 32);
    profile
        .iter()
        .map(|(c, z)| {
            section
                .iter()
                .map(|(x, y)| shape.world_from_normalized(&Vector3::new(c * x, c * y, *z)))
                .collect()
        })
        .collect()
}

pub fn surface_area(shape: &Superquadric) -> f64 {
    let g = grid(shape);
    let mut a = 0.0;
    for i in 0..g.len() - 1 {
        for j in 0..g[0].len() - 1 {
            let (p, q, r, s) = (g[i][j], g[i][j + 1], g[i + 1][j], g[i + 1][j + 1]);
            a += 0.5 * (s - p).cross(&(r - q)).norm();
        }
    }
    a
}

pub fn surface_samples(shape: &Superquadric, spacing: f64, max: usize) -> Vec<(Point3<f64>, Vector3<f64>)> {
    let g = grid(shape);
    let mut out = Vec::new();
    let total = surface_area(shape);
    let n = (total / (spacing * spacing)).min(max as f64).max(1.0);
    let step = total / n;
    let mut acc = step * 0.5;
    for i in 0..g.len() - 1 {
        for j in 0..g[0].len() - 1 {
            let (p, q, r, s) = (g[i][j], g[i][j + 1], g[i + 1][j], g[i + 1][j + 1]);
            let c = (s - p).cross(&(r - q));
            let a = 0.5 * c.norm();
            acc += a;
            let k = (acc / step).floor();
            acc -= k * step;
            let k = k as usize;
            // k points spread in the quad
            let side = (k as f64).sqrt().ceil() as usize;
            for m in 0..k {
                let u = ((m % side) as f64 + 0.5) / side as f64;
                let v = ((m / side) as f64 + 0.5) / (k as f64 / side as f64).ceil();
                let x = p.coords * (1.0 - u) * (1.0 - v)
                    + q.coords * u * (1.0 - v)
                    + r.coords * (1.0 - u) * v
                    + s.coords * u * v;
                out.push((Point3::from(x), c));
            }
        }
    }
    out
}
