//! Every shader and pipeline, and the commands of every kind of frame, pass
//! wgpu's validation on its `noop` backend: no driver is needed. The limits
//! are WebGL2's, the least that a window may get.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use glam::Vec3;
use nalgebra::Point3;
use superform::geometry::Superquadric;
use superform::render::{
    Background, CameraMatrices, Frame, Highlight, InputStyle, LineSegment, PrimitiveInstance, RenderOptions,
    Renderer, SurfaceStyle,
};

/// A device that notes what validation finds.
fn device() -> (wgpu::Device, wgpu::Queue, Arc<Mutex<Vec<String>>>) {
    let (device, queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits::downlevel_webgl2_defaults(),
        ..wgpu::DeviceDescriptor::default()
    });
    let errors = Arc::new(Mutex::new(Vec::new()));
    let sink = errors.clone();
    device.on_uncaptured_error(Arc::new(move |error| {
        // A poisoned lock means that a test has failed already.
        if let Ok(mut errors) = sink.lock() {
            errors.push(error.to_string());
        }
    }));
    (device, queue, errors)
}

fn frame(size: [u32; 2]) -> Frame {
    let eye = Vec3::new(1.0, 1.0, 2.0);
    Frame::new(size, CameraMatrices::perspective(eye, Vec3::ZERO, Vec3::Y, 0.7, 1.5, 0.01))
}

fn fill(renderer: &mut Renderer, device: &wgpu::Device, queue: &wgpu::Queue) {
    let points = [[0.0; 3], [0.1, f32::NAN, 0.0], [0.2; 3]];
    renderer.set_points(device, queue, &points);
    renderer.set_point_colors(queue, &[[1, 2, 3, 255]; 9]);
    renderer.set_point_colors(queue, &[]);
    renderer.set_mesh(device, queue, &points, &[[0, 2, 0], [0, 1, 2]]);
    let line = LineSegment { from: [0.0; 3], to: [1.0; 3], color: [255; 4], width: 2.0 };
    renderer.set_lines(device, queue, &[line; 3]);
    let primitive = |id, highlight| PrimitiveInstance {
        id,
        shape: Superquadric::sphere(Point3::new(f64::from(id), 0.0, 0.0), 0.3),
        color: [200, 100, 50, 255],
        visible: true,
        highlight,
        ghost: false,
    };
    let broken = PrimitiveInstance {
        shape: Superquadric::sphere(Point3::new(f64::NAN, 0.0, 0.0), 0.3),
        ..primitive(7, Highlight::None)
    };
    let primitives = [
        primitive(1, Highlight::None),
        primitive(2, Highlight::Hovered),
        primitive(3, Highlight::Selected),
        broken,
    ];
    renderer.set_primitives(device, queue, &primitives);
}

fn draw(
    renderer: &mut Renderer,
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    frame: &Frame,
    format: wgpu::TextureFormat,
) {
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    renderer.prepare(device, queue, &mut encoder, frame);
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 64, height: 32, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        renderer.paint(&mut pass);
    }
    queue.submit([encoder.finish()]);
}

#[test]
fn all_pipelines_and_all_kinds_of_frames_are_valid() {
    for format in [
        wgpu::TextureFormat::Rgba8Unorm,
        wgpu::TextureFormat::Bgra8Unorm,
        wgpu::TextureFormat::Bgra8UnormSrgb,
    ] {
        for msaa in [1, 4] {
            let (device, queue, errors) = device();
            let mut renderer = Renderer::new(&device, format, RenderOptions { msaa });
            assert_eq!(*errors.lock().unwrap(), Vec::<String>::new());
            // Empty, then full, then empty again.
            for round in 0..3 {
                for surface_style in [SurfaceStyle::Solid, SurfaceStyle::Translucent, SurfaceStyle::Wire] {
                    for input_style in [InputStyle::Ghost, InputStyle::Solid] {
                        let mut frame = Frame { surface_style, input_style, ..frame([300, 200]) };
                        draw(&mut renderer, &device, &queue, &frame, format);
                        frame.theme.background = Background::Transparent;
                        draw(&mut renderer, &device, &queue, &frame, format);
                    }
                }
                if round == 0 {
                    fill(&mut renderer, &device, &queue);
                } else {
                    renderer.set_points(&device, &queue, &[]);
                    renderer.set_primitives(&device, &queue, &[]);
                    renderer.set_mesh(&device, &queue, &[], &[]);
                    renderer.set_lines(&device, &queue, &[]);
                }
            }
            assert_eq!(*errors.lock().unwrap(), Vec::<String>::new(), "{format:?}, {msaa} samples");
        }
    }
}

#[test]
fn sizes_of_nothing_and_beyond_the_limit_are_survived() {
    let (device, queue, errors) = device();
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let mut renderer = Renderer::new(&device, format, RenderOptions::default());
    fill(&mut renderer, &device, &queue);
    for size in [[0, 0], [0, 30], [30, 0], [1, 1], [5000, 3], [40, 30]] {
        draw(&mut renderer, &device, &queue, &frame(size), format);
    }
    assert_eq!(*errors.lock().unwrap(), Vec::<String>::new());
}

/// A frame over a million points uploads none of them again: what it costs on
/// the CPU doesn't depend on their number.
#[test]
fn the_cost_of_a_frame_does_not_grow_with_the_cloud() {
    let (device, queue, errors) = device();
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let fastest_frame = |points: usize| {
        let mut renderer = Renderer::new(&device, format, RenderOptions::default());
        fill(&mut renderer, &device, &queue);
        renderer.set_points(&device, &queue, &vec![[0.1; 3]; points]);
        let once = |k: u32| {
            let start = std::time::Instant::now();
            draw(
                &mut renderer,
                &device,
                &queue,
                &Frame { point_size: k as f32, ..frame([300, 200]) },
                format,
            );
            start.elapsed()
        };
        (1..40).map(once).min().unwrap_or_default()
    };
    // On a busy machine either may be held up, now and then.
    let is_flat = (0..5).any(|_| {
        let (few, many) = (fastest_frame(1_000), fastest_frame(1_000_000));
        many < few * 5 + std::time::Duration::from_millis(2)
    });
    assert!(is_flat, "a million points take more than five times as long as a thousand");
    assert!(errors.lock().unwrap().is_empty());
}

/// The error sink works: a shader that is wrong is found on this backend.
#[test]
fn the_noop_backend_finds_mistakes() {
    let (device, _queue, _) = device();
    let found = Arc::new(AtomicBool::new(false));
    let sink = found.clone();
    device.on_uncaptured_error(Arc::new(move |_| sink.store(true, Ordering::Relaxed)));
    let _ = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl("fn f() -> f32 { return 1u; }".into()),
    });
    assert!(found.load(Ordering::Relaxed));
}
