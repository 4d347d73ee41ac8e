//! The batch kernel, in time a point: distances and normal equations, beside
//! the scalar distance in double precision that they are tested against.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Point3, Rotation3, Vector3};
use superform::geometry::Superquadric;
use superform::geometry::kernel::{self, Distance, PointBlock};

/// A cluster of a usual run, and points enough to stream.
const SIZES: [usize; 2] = [128, 4096];

fn body() -> Superquadric {
    Superquadric {
        exponents: [0.4, 1.2],
        semi_axes: Vector3::new(1.0, 0.5, 2.0),
        rotation: Rotation3::new(Vector3::new(0.3, -0.8, 0.1)),
        translation: Vector3::new(0.2, -0.1, 0.4),
        taper: [0.2, -0.3],
    }
}

/// Points about the body, on a spiral whose radius changes.
fn cloud(count: usize) -> Vec<Point3<f64>> {
    let golden = std::f64::consts::PI * (1.0 + 5f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / count as f64;
            let (r, angle) = ((1.0 - z * z).sqrt(), golden * i as f64);
            let length = 1.0 + 0.8 * (7.0 * angle).sin();
            Point3::from(Vector3::new(r * angle.cos(), r * angle.sin(), z) * length)
        })
        .collect()
}

fn distances(c: &mut Criterion) {
    let mut group = c.benchmark_group("distance");
    let shape = body();
    for size in SIZES {
        let points = cloud(size);
        let block: PointBlock = points.iter().copied().collect();
        let mut out = Vec::new();
        group.throughput(Throughput::Elements(size as u64));
        group.bench_function(BenchmarkId::new("radial, scalar", size), |b| {
            b.iter(|| points.iter().map(|p| shape.radial_distance(black_box(p))).sum::<f64>());
        });
        for (name, distance) in [("radial", Distance::Radial), ("first-order", Distance::FirstOrder)] {
            group.bench_function(BenchmarkId::new(name, size), |b| {
                b.iter(|| kernel::distances(black_box(&shape), &block, distance, &mut out));
            });
        }
        group.bench_function(BenchmarkId::new("euclidean", size), |b| {
            b.iter(|| kernel::euclidean_distances(black_box(&shape), &block, &mut out));
        });
    }
    group.finish();
}

fn equations(c: &mut Criterion) {
    let mut group = c.benchmark_group("normal equations");
    let shape = body();
    for size in SIZES {
        let block: PointBlock = cloud(size).into_iter().collect();
        group.throughput(Throughput::Elements(size as u64));
        for (name, distance) in [("radial", Distance::Radial), ("first-order", Distance::FirstOrder)] {
            group.bench_function(BenchmarkId::new(name, size), |b| {
                b.iter(|| kernel::normal_equations(black_box(&shape), &block, distance));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, distances, equations);
criterion_main!(benches);
