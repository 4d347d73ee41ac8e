//! Points as round splats.

use super::gpu::{Depth, Drawing, ElementBuffer, Recipe, Sampling};

/// A coordinate that the shader takes for "nowhere".
const NOWHERE: [f32; 3] = [2e6; 3];

#[derive(Debug)]
pub(super) struct Points {
    pipeline: wgpu::RenderPipeline,
    positions: ElementBuffer,
    colors: ElementBuffer,
}

impl Points {
    pub(super) fn new(recipe: &Recipe<'_>) -> Self {
        let soft = recipe.sampling == Sampling::Multi;
        let positions = wgpu::vertex_attr_array![0 => Float32x3];
        let colors = wgpu::vertex_attr_array![1 => Unorm8x4];
        let buffer = |stride, attributes| {
            Some(wgpu::VertexBufferLayout {
                array_stride: stride,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes,
            })
        };
        let pipeline = recipe.pipeline(&Drawing {
            label: "points",
            source: include_str!("../../shaders/points.wgsl"),
            vertex: "vs_main",
            fragment: if soft { "fs_coverage" } else { "fs_hard" },
            buffers: &[buffer(12, &positions), buffer(4, &colors)],
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            cull: None,
            blend: None,
            depth: Depth::Write,
            alpha_to_coverage: soft,
        });
        Self {
            pipeline,
            positions: ElementBuffer::new("point positions", wgpu::BufferUsages::VERTEX, 12),
            colors: ElementBuffer::new("point colours", wgpu::BufferUsages::VERTEX, 4),
        }
    }

    pub(super) fn set_points(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, points: &[[f32; 3]]) {
        let finite = |p: &[f32; 3]| p.iter().all(|c| c.is_finite());
        if points.iter().all(finite) {
            self.positions.write(device, queue, points);
        } else {
            let marked: Vec<_> = points.iter().map(|p| if finite(p) { *p } else { NOWHERE }).collect();
            self.positions.write(device, queue, &marked);
        }
        self.colors.write(device, queue, &vec![[255u8; 4]; points.len()]);
    }

    pub(super) fn set_colors(&mut self, queue: &wgpu::Queue, colors: &[[u8; 4]]) {
        self.colors.overwrite(queue, colors);
    }

    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let (Some(positions), Some(colors)) = (self.positions.slice(), self.colors.slice()) {
            pass.set_pipeline(&self.pipeline);
            pass.set_vertex_buffer(0, positions);
            pass.set_vertex_buffer(1, colors);
            pass.draw(0..4, 0..self.positions.len().min(self.colors.len()));
        }
    }
}
