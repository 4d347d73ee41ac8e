//! From the renderer's picture back to the CPU.

use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use super::error::OffscreenError;
use super::frame::Frame;
use super::renderer::Renderer;

/// A picture on its way from the device.
#[derive(Debug)]
pub struct Capture {
    size: [u32; 2],
    /// Bytes from row to row.
    padded: u32,
    buffer: wgpu::Buffer,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Capture {
    /// Has `renderer` draw a frame of any size and submits it; nothing is
    /// waited for.
    ///
    /// # Errors
    /// [`OffscreenError::Size`] where a side is 0 or more than the device can
    /// draw.
    pub fn begin(
        renderer: &mut Renderer,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &Frame,
    ) -> Result<Self, OffscreenError> {
        let [width, height] = frame.size_px;
        let limit = renderer.largest_side(device);
        if width == 0 || height == 0 || width > limit || height > limit {
            return Err(OffscreenError::Size { width, height, limit });
        }
        let padded = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let (bytes, most) = (u64::from(padded) * u64::from(height), device.limits().max_buffer_size);
        if bytes > most {
            let limit = (most / u64::from(padded)) as u32;
            return Err(OffscreenError::Size { width, height, limit });
        }
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.prepare(device, queue, &mut encoder, frame);
        let picture = renderer.picture().ok_or_else(nothing)?;
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: bytes,
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
        queue.submit([encoder.finish()]);
        let (sender, mapped) = sync_channel(1);
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody waits for a picture that was given up.
            let _ = sender.send(result);
        });
        Ok(Self { size: [width, height], padded, buffer, mapped })
    }

    /// The picture, once it is there: RGBA with straight (not premultiplied)
    /// alpha. `None` while the device still draws.
    ///
    /// # Errors
    /// [`OffscreenError::Read`] where the driver gives it up.
    pub fn poll(&self, device: &wgpu::Device) -> Option<Result<image::RgbaImage, OffscreenError>> {
        if let Err(error) = device.poll(wgpu::PollType::Poll) {
            return Some(Err(OffscreenError::Read(error.to_string())));
        }
        match self.mapped.try_recv() {
            Ok(Ok(())) => Some(self.read()),
            Ok(Err(error)) => Some(Err(OffscreenError::Read(error.to_string()))),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(nothing())),
        }
    }

    /// Waits for the picture.
    ///
    /// # Errors
    /// As [`Capture::poll`].
    pub fn wait(self, device: &wgpu::Device) -> Result<image::RgbaImage, OffscreenError> {
        let read = |e: &dyn std::fmt::Display| OffscreenError::Read(e.to_string());
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| read(&e))?;
        self.mapped.recv().map_err(|e| read(&e))?.map_err(|e| read(&e))?;
        self.read()
    }

    fn read(&self) -> Result<image::RgbaImage, OffscreenError> {
        let [width, height] = self.size;
        let row = 4 * width as usize;
        let bytes = self.buffer.get_mapped_range(..).map_err(|e| OffscreenError::Read(e.to_string()))?;
        let mut pixels = Vec::with_capacity(row * height as usize);
        for line in bytes.chunks(self.padded as usize) {
            pixels.extend_from_slice(&line[..row]);
        }
        for pixel in pixels.as_chunks_mut::<4>().0 {
            let alpha = u32::from(pixel[3]);
            if alpha != 0 && alpha != 255 {
                for c in &mut pixel[..3] {
                    *c = ((u32::from(*c) * 255 + alpha / 2) / alpha).min(255) as u8;
                }
            }
        }
        image::RgbaImage::from_raw(width, height, pixels).ok_or_else(nothing)
    }
}

fn nothing() -> OffscreenError {
    OffscreenError::Read("nothing was drawn".to_owned())
}
