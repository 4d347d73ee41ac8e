//! Pictures without a window.

use super::frame::Frame;
use super::renderer::{RenderOptions, Renderer};

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum OffscreenError {
    #[error("no graphics driver was found ({0}); install one (Mesa's lavapipe needs no graphics card)")]
    NoAdapter(String),
    #[error("the graphics driver {adapter} gave no device ({reason}); try another driver")]
    NoDevice { adapter: String, reason: String },
    #[error("a picture of {width} × {height} pixels can't be drawn: its sides must be 1 to {limit}")]
    Size { width: u32, height: u32, limit: u32 },
    #[error("the picture could not be read back from the graphics driver ({0}); try a smaller one")]
    Read(String),
}

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
    pub fn render(&mut self, frame: &Frame) -> Result<image::RgbaImage, OffscreenError> {
        let [width, height] = frame.size_px;
        let limit = self.device.limits().max_texture_dimension_2d;
        if width == 0 || height == 0 || width > limit || height > limit {
            return Err(OffscreenError::Size { width, height, limit });
        }
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.renderer.prepare(&self.device, &self.queue, &mut encoder, frame);
        let unread = || OffscreenError::Read("nothing was drawn".to_owned());
        let picture = self.renderer.picture().ok_or_else(unread)?;

        let row = 4 * width;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(padded) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_texture_to_buffer(
            picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.queue.submit([encoder.finish()]);

        let (sender, receiver) = std::sync::mpsc::sync_channel(1);
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver outlives the wait below.
            let _ = sender.send(result);
        });
        let read = |e: &dyn std::fmt::Display| OffscreenError::Read(e.to_string());
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| read(&e))?;
        receiver.recv().map_err(|e| read(&e))?.map_err(|e| read(&e))?;
        let bytes = buffer.get_mapped_range(..).map_err(|e| read(&e))?;
        let mut pixels = Vec::with_capacity((row * height) as usize);
        for line in bytes.chunks(padded as usize) {
            pixels.extend_from_slice(&line[..row as usize]);
        }
        for pixel in pixels.as_chunks_mut::<4>().0 {
            let alpha = u32::from(pixel[3]);
            if alpha != 0 && alpha != 255 {
                for c in &mut pixel[..3] {
                    *c = ((u32::from(*c) * 255 + alpha / 2) / alpha).min(255) as u8;
                }
            }
        }
        image::RgbaImage::from_raw(width, height, pixels).ok_or_else(unread)
    }
}
