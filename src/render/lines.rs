//! Straight lines of constant width on the screen.

use super::frame::LineSegment;
use super::gpu::{self, Depth, Drawing, ElementBuffer, Recipe};

/// A line as the shader takes it.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Segment {
    pub(super) from: [f32; 3],
    pub(super) to: [f32; 3],
    /// Outward normal of the surface that the line lies on, or 0.
    pub(super) normal: [f32; 3],
    pub(super) color: [u8; 4],
    /// Logical pixels.
    pub(super) width: f32,
}

impl Segment {
    pub(super) fn buffer() -> ElementBuffer {
        ElementBuffer::new("line segments", wgpu::BufferUsages::VERTEX, size_of::<Self>() as u64)
    }
}

impl From<&LineSegment> for Segment {
    fn from(line: &LineSegment) -> Self {
        Self { from: line.from, to: line.to, normal: [0.0; 3], color: line.color, width: line.width }
    }
}

/// The pipeline, and the free lines.
#[derive(Debug)]
pub(super) struct Lines {
    pipeline: wgpu::RenderPipeline,
    free: ElementBuffer,
}

impl Lines {
    pub(super) fn new(recipe: &Recipe<'_>) -> Self {
        let attributes = wgpu::vertex_attr_array![
            0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Unorm8x4, 4 => Float32
        ];
        let pipeline = recipe.pipeline(&Drawing {
            label: "lines",
            source: include_str!("../../shaders/lines.wgsl"),
            vertex: "vs_main",
            fragment: "fs_main",
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Segment>() as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &attributes,
            })],
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            cull: None,
            blend: Some(gpu::OVER),
            depth: Depth::Test,
            alpha_to_coverage: false,
        });
        Self { pipeline, free: Segment::buffer() }
    }

    pub(super) fn set_free(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, lines: &[LineSegment]) {
        let finite = |l: &&LineSegment| l.from.iter().chain(&l.to).all(|c| c.is_finite());
        let segments: Vec<Segment> = lines.iter().filter(finite).map(Segment::from).collect();
        self.free.write(device, queue, &segments);
    }

    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, segments: &ElementBuffer) {
        if let Some(slice) = segments.slice() {
            pass.set_pipeline(&self.pipeline);
            pass.set_vertex_buffer(0, slice);
            pass.draw(0..4, 0..segments.len());
        }
    }

    pub(super) fn draw_free(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.draw(pass, &self.free);
    }
}
