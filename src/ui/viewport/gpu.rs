//! The renderers that live with egui's, one per view.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use egui_wgpu::wgpu;

use crate::render::{Frame, RenderOptions, Renderer};
use crate::ui::scene::Scene;

/// A renderer with the versions of what it holds.
#[derive(Debug)]
pub(super) struct Gpu {
    pub(super) renderer: Renderer,
    points: u64,
    colors: u64,
    mesh: u64,
    primitives: u64,
    paint: u64,
}

impl Gpu {
    pub(super) fn new(device: &wgpu::Device, format: wgpu::TextureFormat, options: RenderOptions) -> Self {
        let renderer = Renderer::new(device, format, options);
        Self { renderer, points: 0, colors: 0, mesh: 0, primitives: 0, paint: 0 }
    }

    /// Uploads what has another version.
    pub(super) fn upload(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) {
        let Self { renderer, points, colors, mesh, primitives, paint } = self;
        scene.points.upload(points, |p| {
            renderer.set_points(device, queue, p);
            // New points are white until they are coloured.
            *colors = 0;
        });
        scene.colors.upload(colors, |c| renderer.set_point_colors(queue, c));
        scene.mesh.upload(mesh, |m| renderer.set_mesh(device, queue, &m.vertices, &m.faces));
        scene.primitives.upload(primitives, |p| {
            renderer.set_primitives(device, queue, p);
            // A shape that has changed has lost its paint.
            *paint = 0;
        });
        scene.paint.upload(paint, |p| renderer.set_paint(device, queue, p));
    }
}

/// All views' renderers, by the numbers of their slots.
#[derive(Default)]
struct Gpus(HashMap<u64, Gpu>);

/// A view's place among egui's resources, given back when it is dropped.
pub(super) struct Slot {
    number: u64,
    state: egui_wgpu::RenderState,
}

impl std::fmt::Debug for Slot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Slot").field("number", &self.number).finish_non_exhaustive()
    }
}

impl Slot {
    /// Builds the pipelines.
    pub(super) fn new(state: &egui_wgpu::RenderState) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        // A software driver pays for every sample.
        let is_software = state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let options = RenderOptions { msaa: if is_software { 1 } else { 4 } };
        let gpu = Gpu::new(&state.device, state.target_format, options);
        let mut egui = state.renderer.write();
        match egui.callback_resources.get_mut::<Gpus>() {
            Some(gpus) => {
                gpus.0.insert(number, gpu);
            }
            None => {
                egui.callback_resources.insert(Gpus(HashMap::from([(number, gpu)])));
            }
        }
        drop(egui);
        Self { number, state: state.clone() }
    }

    /// One more, with pipelines of its own.
    pub(super) fn another(&self) -> Self {
        Self::new(&self.state)
    }

    pub(super) fn callback(&self, frame: Frame, scene: Scene) -> impl egui_wgpu::CallbackTrait + use<> {
        Paint { number: self.number, frame, scene }
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        if let Some(gpus) = self.state.renderer.write().callback_resources.get_mut::<Gpus>() {
            gpus.0.remove(&self.number);
        }
    }
}

/// One frame's drawing.
struct Paint {
    number: u64,
    frame: Frame,
    scene: Scene,
}

impl egui_wgpu::CallbackTrait for Paint {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &egui_wgpu::ScreenDescriptor,
        encoder: &mut wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(gpu) = resources.get_mut::<Gpus>().and_then(|gpus| gpus.0.get_mut(&self.number)) {
            gpu.upload(device, queue, &self.scene);
            gpu.renderer.prepare(device, queue, encoder, &self.frame);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &egui_wgpu::CallbackResources,
    ) {
        if let Some(gpu) = resources.get::<Gpus>().and_then(|gpus| gpus.0.get(&self.number)) {
            gpu.renderer.paint(pass);
        }
    }
}
