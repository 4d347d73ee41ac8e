//! CPU time of a frame of the viewport with a million points, without a GPU:
//! wgpu's `noop` backend takes the same commands and copies the same bytes, but
//! draws nothing.
#![allow(clippy::unwrap_used)] // What can't be had here ends the benchmark.

use std::collections::BTreeSet;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{Vec2, Vec3};
use nalgebra::Point3;
use superform::geometry::palette::Colors;
use superform::geometry::{SamplingOptions, Superquadric, scatter_mesh};
use superform::io::{self, Attributes, PointCloud, Shape, ShapeGeometry};
use superform::render::picking::pick;
use superform::render::{
    CameraMatrices, Frame, Highlight, PickScene, PointIndex, PrimitiveInstance, RenderOptions, Renderer,
};
use superform::session::paint::{Paint, shown_colors, shown_points};
use superform::session::scene::{SceneFromInput, UpAxis};
use superform::worker::LoadedShape;

const POINTS: usize = 1_000_000;
/// Primitives of a large abstraction.
const PRIMITIVES: u32 = 30;

fn loaded() -> LoadedShape {
    let ShapeGeometry::Mesh(mesh) = io::built_in().unwrap().geometry else {
        unreachable!("the built-in chair is a mesh")
    };
    let points = scatter_mesh(&mesh, POINTS, 1).unwrap();
    let shape = Shape {
        name: "chair".to_owned(),
        path: None,
        content: None,
        geometry: ShapeGeometry::Cloud(PointCloud { points }),
        attributes: Attributes::default(),
        viewpoints: Vec::new(),
        notes: Vec::new(),
    };
    let sampling = SamplingOptions::default();
    let cloud = Arc::new(io::sample(&shape, &sampling).unwrap());
    LoadedShape { generation: 1, shape: Arc::new(shape), cloud, sampling }
}

fn camera(turn: f32) -> CameraMatrices {
    let eye = Vec3::new(1.6 * turn.sin(), 0.7, 1.6 * turn.cos());
    CameraMatrices::perspective(eye, Vec3::ZERO, Vec3::Y, 0.7, 16.0 / 9.0, 0.01)
}

fn frames(c: &mut Criterion) {
    let (device, queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits::downlevel_webgl2_defaults(),
        ..wgpu::DeviceDescriptor::default()
    });
    let loaded = loaded();
    let scene = SceneFromInput::fit(&loaded.cloud.points, UpAxis::Y);
    let to_scene = |p: &Point3<f64>| scene.point(p).coords.map(|c| c as f32).into();
    let points: Vec<[f32; 3]> = shown_points(&loaded).iter().map(to_scene).collect();
    let labels: Vec<u32> = (0..loaded.cloud.points.len() as u32).map(|i| i % PRIMITIVES).collect();
    let hidden = BTreeSet::from([3, 5]);
    let primitives: Vec<PrimitiveInstance> = (0..PRIMITIVES)
        .map(|id| PrimitiveInstance {
            id,
            shape: Superquadric::sphere(Point3::new(0.1 * f64::from(id % 6) - 0.3, 0.0, 0.0), 0.05),
            color: [200, 100, 50, 255],
            visible: true,
            highlight: Highlight::None,
            ghost: false,
        })
        .collect();
    let mut renderer = Renderer::new(&device, wgpu::TextureFormat::Rgba8Unorm, RenderOptions::default());
    renderer.set_points(&device, &queue, &points);
    renderer.set_point_colors(
        &queue,
        &shown_colors(&loaded, &labels, &hidden, &[], &[], Paint::Clusters(&Colors::default())),
    );
    renderer.set_primitives(&device, &queue, &primitives);

    let mut group = c.benchmark_group("frame of 1 M points");
    group.sample_size(30).measurement_time(Duration::from_secs(3));
    let size = [1920, 1080];
    let mut turn = 0.0;
    let mut frame = |renderer: &mut Renderer, moves: bool| {
        turn += if moves { 1e-3 } else { 0.0 };
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let drew = renderer.prepare(&device, &queue, &mut encoder, &Frame::new(size, camera(turn)));
        queue.submit([encoder.finish()]);
        drew
    };
    group.bench_function("nothing changed", |b| b.iter(|| frame(&mut renderer, false)));
    group.bench_function("the camera moves", |b| b.iter(|| frame(&mut renderer, true)));
    group.bench_function("new labels", |b| {
        b.iter(|| {
            renderer.set_point_colors(
                &queue,
                &shown_colors(
                    &loaded,
                    &labels,
                    &BTreeSet::new(),
                    &[],
                    &[],
                    Paint::Clusters(&Colors::default()),
                ),
            );
            frame(&mut renderer, true)
        });
    });
    group.bench_function("new labels, some hidden", |b| {
        b.iter(|| {
            renderer.set_point_colors(
                &queue,
                &shown_colors(&loaded, &labels, &hidden, &[], &[], Paint::Clusters(&Colors::default())),
            );
            frame(&mut renderer, true)
        });
    });
    group.bench_function("a primitive is hovered", |b| {
        let mut primitives = primitives.clone();
        b.iter(|| {
            let next =
                if primitives[0].highlight == Highlight::None { Highlight::Hovered } else { Highlight::None };
            primitives[0].highlight = next;
            renderer.set_primitives(&device, &queue, &primitives);
            frame(&mut renderer, true)
        });
    });
    group.bench_function("new points (once a shape)", |b| {
        b.iter(|| {
            renderer.set_points(&device, &queue, &points);
            frame(&mut renderer, true)
        });
    });

    let index = PointIndex::new(&points);
    let shown = Frame::new(size, camera(0.4));
    let bare = PickScene { points: &points, primitives: &primitives, ..PickScene::default() };
    for (name, scene) in
        [("pick", PickScene { point_index: Some(&index), ..bare }), ("pick without an index", bare)]
    {
        group.bench_function(name, |b| {
            let mut x = 700.0;
            b.iter(|| {
                x = if x > 1200.0 { 700.0 } else { x + 1.0 };
                pick(black_box(&scene), &shown, Vec2::new(x, 540.0))
            });
        });
    }
    group.bench_function("index for picking (once a shape, in the background)", |b| {
        b.iter(|| PointIndex::new(&points));
    });
    group.finish();
}

criterion_group!(benches, frames);
criterion_main!(benches);
