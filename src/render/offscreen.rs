//! Pictures without a window.

use super::capture::Capture;
use super::error::OffscreenError;
use super::frame::Frame;
use super::renderer::{RenderOptions, Renderer};

/// A device of its own with a [`Renderer`].
#[derive(Debug)]
pub struct Offscreen {
    device: wgpu::Device,
    queue: wgpu::Queue,
    adapter: wgpu::AdapterInfo,
    renderer: Renderer,
}

impl Offscreen {
    /// Opens the best driver, needing no display. The environment variable
    /// `WGPU_BACKEND` (vulkan, gl, metal, dx12) narrows the choice.
    pub fn new(options: RenderOptions) -> Result<Self, OffscreenError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        }))
        .map_err(|e| OffscreenError::NoAdapter(e.to_string()))?;
        let info = adapter.get_info();
        // Nothing beyond WebGL2 is asked for but the size of pictures and clouds.
        let limits = wgpu::Limits {
            max_buffer_size: adapter.limits().max_buffer_size,
            ..wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits())
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("offscreen"),
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|e| OffscreenError::NoDevice { adapter: info.name.clone(), reason: e.to_string() })?;
        let renderer = Renderer::new(&device, wgpu::TextureFormat::Rgba8Unorm, options);
        Ok(Self { device, queue, adapter: info, renderer })
    }

    /// Which driver draws, for people.
    pub fn adapter_name(&self) -> String {
        format!("{} ({})", self.adapter.name, self.adapter.backend)
    }

    /// The renderer with the device and the queue that its functions want.
    pub fn parts(&mut self) -> (&mut Renderer, &wgpu::Device, &wgpu::Queue) {
        (&mut self.renderer, &self.device, &self.queue)
    }

    /// Draws a frame; the pixels have straight (not premultiplied) alpha.
    /// unfinished jobs.
    /// # Errors
    /// Where the size can't be drawn or the driver gives no picture.
    pub fn render(&mut self, frame: &Frame) -> Result<image::RgbaImage, OffscreenError> {
        Capture::begin(&mut self.renderer, &self.device, &self.queue, frame)?.wait(&self.device)
    }
}
