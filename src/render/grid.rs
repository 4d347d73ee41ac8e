//! The ground grid.

use super::gpu::{self, Depth, Drawing, Recipe};

#[derive(Debug)]
pub(super) struct GridPlane {
    pipeline: wgpu::RenderPipeline,
}

impl GridPlane {
    pub(super) fn new(recipe: &Recipe<'_>) -> Self {
        let pipeline = recipe.pipeline(&Drawing {
            label: "grid",
            source: include_str!("../../shaders/grid.wgsl"),
            vertex: "vs_main",
            fragment: "fs_main",
            buffers: &[],
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            cull: None,
            blend: Some(gpu::OVER),
            depth: Depth::Test,
            alpha_to_coverage: false,
        });
        Self { pipeline }
    }

    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.draw(0..4, 0..1);
    }
}
