//! The renderer's textures, and the pass that makes a picture of them.

use super::gpu::{COLOR_FORMAT, DEPTH_FORMAT, Recipe};

/// Textures of one size.
#[derive(Debug)]
pub(super) struct Targets {
    pub(super) size: [u32; 2],
    pub(super) color: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
    /// The mask's samples, where there is more than one a pixel.
    pub(super) mask_samples: Option<wgpu::TextureView>,
    pub(super) mask: wgpu::TextureView,
    pub(super) picture: wgpu::TextureView,
    pub(super) picture_texture: wgpu::Texture,
    inputs: wgpu::BindGroup,
}

#[derive(Debug)]
pub(super) struct Composite {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    samples: u32,
}

impl Composite {
    pub(super) fn new(recipe: &Recipe<'_>) -> Self {
        let multisampled = recipe.samples > 1;
        let texture = |binding, multisampled, filterable| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled,
            },
            count: None,
        };
        let layout = recipe.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("composite"),
            entries: &[
                texture(0, multisampled, false),
                // Depth read as plain numbers: GL can't load from a depth texture otherwise.
                texture(1, multisampled, false),
                texture(2, false, true),
                wgpu::BindGroupLayoutEntry {
                    binding: 3,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                    count: None,
                },
            ],
        });
        let access = if multisampled {
            include_str!("../../shaders/samples_4.wgsl")
        } else {
            include_str!("../../shaders/samples_1.wgsl")
        };
        let module = recipe.shader("composite", &[access, include_str!("../../shaders/composite.wgsl")]);
        let pipeline_layout = recipe.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("composite"),
            bind_group_layouts: &[Some(recipe.frame_layout), Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = recipe.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("composite"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vs_main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fs_main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(COLOR_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = linear_sampler(recipe.device);
        Self { pipeline, layout, sampler, samples: recipe.samples }
    }

    /// Textures of `size`, whose sides must be at least 1.
    pub(super) fn targets(&self, device: &wgpu::Device, size: [u32; 2]) -> Targets {
        use wgpu::TextureUsages as Usage;
        let texture = |label, format, samples, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | Usage::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let color = view(&texture("scene colour", COLOR_FORMAT, self.samples, Usage::TEXTURE_BINDING));
        let depth = view(&texture("scene depth", DEPTH_FORMAT, self.samples, Usage::TEXTURE_BINDING));
        let mask = view(&texture("silhouettes", COLOR_FORMAT, 1, Usage::TEXTURE_BINDING));
        let mask_samples = (self.samples > 1)
            .then(|| view(&texture("silhouette samples", COLOR_FORMAT, self.samples, Usage::empty())));
        let usage = Usage::TEXTURE_BINDING | Usage::COPY_SRC;
        let picture_texture = texture("picture", COLOR_FORMAT, 1, usage);
        let inputs = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("composite"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&color) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&depth) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(&mask) },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::Sampler(&self.sampler) },
            ],
        });
        let picture = view(&picture_texture);
        Targets { size, color, depth, mask_samples, mask, picture, picture_texture, inputs }
    }

    pub(super) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        frame_group: &wgpu::BindGroup,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("composite"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &targets.picture,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, frame_group, &[]);
        pass.set_bind_group(1, &targets.inputs, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Bilinear, clamped to the edge.
pub(super) fn linear_sampler(device: &wgpu::Device) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("linear"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    })
}
