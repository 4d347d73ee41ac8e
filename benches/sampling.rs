//! From a shape to samples, and back to labels of all its points.
#![allow(clippy::unwrap_used)] // What can't be had here ends the benchmark.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use superform::geometry::{SamplingOptions, TriMesh, sample_cloud, sample_mesh, scatter_mesh};
use superform::io::{self, ShapeGeometry};

fn chair() -> TriMesh {
    match io::built_in().unwrap().geometry {
        ShapeGeometry::Mesh(mesh) => mesh,
        ShapeGeometry::Cloud(_) => unreachable!("the built-in chair is a mesh"),
    }
}

/// Random points of the chair, the last fifth of them strewn about it.
fn with_outliers(mesh: &TriMesh, count: usize) -> Vec<Point3<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (low, high) = mesh.bounds().unwrap();
    let mut points = scatter_mesh(mesh, count - count / 5, 1).unwrap();
    let extent = high - low;
    points.extend((0..count / 5).map(|_| low + extent.map(|e| e * (1.4 * rng.random::<f64>() - 0.2))));
    points
}

fn sampling(c: &mut Criterion) {
    let mut group = c.benchmark_group("sampling");
    group.sample_size(10).measurement_time(Duration::from_secs(10));
    let (mesh, options) = (chair(), SamplingOptions::default());
    group.bench_function("built-in chair", |b| b.iter(|| sample_mesh(&mesh, &options).unwrap()));
    for count in [100_000, 1_000_000] {
        group.throughput(Throughput::Elements(count as u64));
        let clean = scatter_mesh(&mesh, count, 1).unwrap();
        group.bench_function(BenchmarkId::new("cloud", count), |b| {
            b.iter(|| sample_cloud(&clean, &options).unwrap());
        });
        let noisy = with_outliers(&mesh, count);
        group.bench_function(BenchmarkId::new("cloud with a fifth of outliers", count), |b| {
            b.iter(|| sample_cloud(&noisy, &options).unwrap());
        });
        let cloud = sample_cloud(&clean, &options).unwrap();
        let labels = vec![7; cloud.points.len()];
        group.bench_function(BenchmarkId::new("labels of all points", count), |b| {
            b.iter(|| cloud.labels_of_input(&labels, u32::MAX));
        });
    }
    group.finish();
}

criterion_group!(benches, sampling);
criterion_main!(benches);
