//! The inference's properties: fits, the laws of the draws, runs, scenes.

mod baselines;
mod checkpoints;
mod degenerate;
mod edits;
mod energies;
mod explanations;
mod fits;
mod laws;
mod locks;
mod merges;
mod one_side;
mod proposals;
mod runs;
mod scenes;
mod take;
mod uncertain;

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use nalgebra::{Point3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::geometry::{SampleCloud, Superquadric, tessellate};
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::{Abstraction, UNASSIGNED};
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::params::Params;

fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A box with its axes along the world's.
fn block(center: [f64; 3], half: [f64; 3]) -> Superquadric {
    Superquadric {
        exponents: [0.1, 0.1],
        semi_axes: half.into(),
        rotation: Rotation3::identity(),
        translation: center.into(),
        taper: [0.0, 0.0],
    }
}

/// About `n` points spread evenly over the surface.
fn samples(shape: &Superquadric, n: usize) -> Vec<Point3<f64>> {
    let spacing = (tessellate::surface_area(shape) / n as f64).sqrt();
    tessellate::surface_samples(shape, spacing, 4 * n).into_iter().map(|s| s.0).collect()
}

/// Points spread evenly, at one density, over the union of some shapes; with
/// the index of the shape that each lies on.
fn scene(shapes: &[Superquadric], n: usize) -> (Vec<Point3<f64>>, Vec<u32>) {
    let area: f64 = shapes.iter().map(tessellate::surface_area).sum();
    let spacing = (area / n as f64).sqrt();
    let mut points = Vec::new();
    let mut parts = Vec::new();
    for (j, shape) in (0u32..).zip(shapes) {
        for (x, _) in tessellate::surface_samples(shape, spacing, 4 * n) {
            if !shapes.iter().zip(0u32..).any(|(s, k)| k != j && s.contains(&x)) {
                points.push(x);
                parts.push(j);
            }
        }
    }
    (points, parts)
}

fn jitter(points: &mut [Point3<f64>], sigma: f64, seed: u64) {
    let mut rng = rng(seed);
    for p in points {
        let noise = Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng));
        *p += noise * sigma;
    }
}

/// Points drawn evenly from a cube.
fn noise(n: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut rng = rng(seed);
    (0..n).map(|_| Point3::from(Vector3::from_fn(|_, _| rng.random::<f64>()))).collect()
}

fn sampler(points: &[Point3<f64>], params: Params) -> Sampler {
    Sampler::new(Arc::new(SampleCloud::from_points(points)), params, &Cancel::default()).unwrap()
}

/// Runs to the end.
fn run(points: &[Point3<f64>], params: Params) -> Abstraction {
    let mut sampler = sampler(points, params);
    while !sampler.is_finished() {
        sampler.step(&Cancel::default()).unwrap();
    }
    sampler.abstraction()
}

/// What must hold of every state: labels refer to primitives, counts add up,
/// nothing is NaN.
fn check(a: &Abstraction, points: usize) {
    assert_eq!(a.labels.len(), points);
    let mut ids: Vec<u32> = a.primitives.iter().map(|p| p.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), a.primitives.len(), "two primitives share an id");
    for p in a.primitives.iter() {
        assert!(p.shape.is_valid(), "{:?}", p.shape);
        assert!(p.sigma.is_finite() && p.sigma > 0.0, "σ = {}", p.sigma);
        assert!(p.mean_distance.is_finite() && p.mean_distance >= 0.0, "d = {}", p.mean_distance);
        assert_eq!(p.points, a.labels.iter().filter(|l| **l == p.id).count());
    }
    let unassigned = a.labels.iter().filter(|l| **l == UNASSIGNED).count();
    assert_eq!(a.figures.unassigned, unassigned);
    assert_eq!(a.figures.clusters, a.primitives.len());
    assert_eq!(points - unassigned, a.primitives.iter().map(|p| p.points).sum::<usize>(), "a dangling label");
    assert!(a.figures.mean_distance.is_finite());
}

/// A slab with two posts on it: something to be born, merged and split.
fn gate(n: usize) -> Vec<Point3<f64>> {
    let shapes = [
        block([0.0, 0.0, 0.0], [1.0, 0.5, 0.1]),
        block([-0.7, 0.0, 0.6], [0.15, 0.15, 0.5]),
        block([0.7, 0.0, 0.6], [0.15, 0.15, 0.5]),
    ];
    let mut points = scene(&shapes, n).0;
    jitter(&mut points, 0.003, 1);
    points
}

fn short() -> Params {
    Params { iterations: 8, clusters: 12, ..Params::default() }
}

/// Two states bit by bit: `==` alone would take −0 for 0.
fn same_bits(a: &Abstraction, b: &Abstraction) -> bool {
    let bits = |a: &Abstraction| {
        let mut bits: Vec<u64> = Vec::new();
        for p in a.primitives.iter() {
            let s = &p.shape;
            bits.extend([u64::from(p.id), p.points as u64, p.sigma.to_bits(), p.mean_distance.to_bits()]);
            let numbers = s.exponents.iter().chain(&s.semi_axes).chain(&s.translation);
            bits.extend(numbers.chain(s.rotation.matrix()).chain(&s.taper).map(|v| v.to_bits()));
        }
        bits.push(a.figures.mean_distance.to_bits());
        bits
    };
    a == b && bits(a) == bits(b)
}

/// Asks to cancel after some turns of a loop on another thread, so that it
/// meets the work at many places; says what came of it.
fn cancelled_after<T>(turns: u32, work: impl FnOnce(&Cancel) -> T) -> T {
    let cancel = Cancel::default();
    let started = AtomicU32::new(0);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while started.load(Ordering::Acquire) == 0 {
                std::hint::spin_loop();
            }
            for turn in 0..turns {
                // Something that the compiler does not leave out.
                started.fetch_max(turn, Ordering::Relaxed);
            }
            cancel.request();
        });
        if turns == 0 {
            cancel.request();
        }
        started.fetch_max(1, Ordering::Release);
        work(&cancel)
    })
}

/// Turns from none to some milliseconds.
fn delays() -> impl Iterator<Item = u32> {
    (0..12).map(|i| if i == 0 { 0 } else { 200u32 << i })
}
