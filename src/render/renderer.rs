//! Owns what is on the GPU and draws frames.

use super::frame::{Frame, LineSegment, PrimitiveInstance};

/// Fixed for the life of a [`Renderer`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RenderOptions {
    /// Samples a pixel: 4 where the hardware draws, 1 for slow software
    /// drivers. Other values are taken to the nearest of the two.
    pub msaa: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { msaa: 4 }
    }
}

/// Draws the scene.
///
/// The `set_…` functions upload and are called when the data changes;
/// [`Renderer::prepare`] and [`Renderer::paint`] are called for each frame of
/// the window and cost next to nothing when nothing changed.
#[derive(Debug)]
pub struct Renderer {
    options: RenderOptions,
}

impl Renderer {
    /// Builds all pipelines. `color_format` is the format of the pass that
    /// [`Renderer::paint`] is given.
    pub fn new(device: &wgpu::Device, color_format: wgpu::TextureFormat, options: RenderOptions) -> Self {
        let _ = (device, color_format);
        Self { options }
    }

    pub fn options(&self) -> RenderOptions {
        self.options
    }

    /// Replaces the points (scene units). All are white until
    /// [`Renderer::set_point_colors`].
    pub fn set_points(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, points: &[[f32; 3]]) {
        let _ = (device, queue, points);
    }

    /// Colours the points, one colour a point in their order; surplus colours
    /// are ignored, missing ones leave the old. Alpha 0 hides a point.
    pub fn set_point_colors(&mut self, queue: &wgpu::Queue, colors: &[[u8; 4]]) {
        let _ = (queue, colors);
    }

    /// Replaces the input mesh; with no faces there is none. Faces with an
    /// index out of range are left out.
    pub fn set_mesh(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        vertices: &[[f32; 3]],
        faces: &[[u32; 3]],
    ) {
        let _ = (device, queue, vertices, faces);
    }

    /// Replaces the primitives. One whose id and shape are the same as before
    /// keeps its tessellation: a change of colour, highlight or visibility
    /// uploads next to nothing.
    pub fn set_primitives(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        primitives: &[PrimitiveInstance],
    ) {
        let _ = (device, queue, primitives);
    }

    /// Replaces the free lines (gizmos, boxes).
    pub fn set_lines(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, lines: &[LineSegment]) {
        let _ = (device, queue, lines);
    }

    /// Draws the frame into the renderer's own picture by way of `encoder`,
    /// if anything changed since the last call. Returns whether it drew.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
    ) -> bool {
        let _ = (device, queue, encoder, frame);
        false
    }

    /// Copies the picture over the pass's viewport.
    pub fn paint(&self, pass: &mut wgpu::RenderPass<'_>) {
        let _ = pass;
    }
}
