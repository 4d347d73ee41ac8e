//! The renderer's textures, and the pass that makes a picture of them.

use super::gpu::{COLOR_FORMAT, DEPTH_FORMAT, Recipe, Sampling};

/// Textures of one size.
#[derive(Debug)]
pub(super) struct Targets {
    /// Of the picture; the scene's textures may be larger.
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
    sampling: Sampling,
}

impl Composite {
    pub(super) fn new(recipe: &Recipe<'_>) -> Self {
        let multisampled = recipe.sampling == Sampling::Multi;
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
        let access = match recipe.sampling {
            Sampling::Single => include_str!("../../shaders/samples_1.wgsl"),
            Sampling::Multi => include_str!("../../shaders/samples_4.wgsl"),
            Sampling::Super => include_str!("../../shaders/samples_2x2.wgsl"),
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
        Self { pipeline, layout, sampler, sampling: recipe.sampling }
    }

    /// Textures for a picture of `size`, whose sides must be at least 1.
    pub(super) fn targets(&self, device: &wgpu::Device, size: [u32; 2]) -> Targets {
        use wgpu::TextureUsages as Usage;
        let texture = |label, format, scale, samples, usage| {
            let [width, height] = size.map(|s| s * scale);
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | Usage::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let view = |texture: wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let (scale, samples) = (self.sampling.scale(), self.sampling.samples());
        let scene = |label, format| view(texture(label, format, scale, samples, Usage::TEXTURE_BINDING));
        let color = scene("scene colour", COLOR_FORMAT);
        let depth = scene("scene depth", DEPTH_FORMAT);
        let mask = view(texture("silhouettes", COLOR_FORMAT, scale, 1, Usage::TEXTURE_BINDING));
        let mask_samples = (samples > 1)
            .then(|| view(texture("silhouette samples", COLOR_FORMAT, scale, samples, Usage::empty())));
        let usage = Usage::TEXTURE_BINDING | Usage::COPY_SRC;
        let picture_texture = texture("picture", COLOR_FORMAT, 1, 1, usage);
        let picture = picture_texture.create_view(&wgpu::TextureViewDescriptor::default());
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

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;
    use crate::render::gpu::frame_layout;

    /// Also the way that only GL takes is valid, checked without a driver.
    #[test]
    fn each_way_of_sampling_has_a_valid_pipeline_and_textures() {
        let (device, _queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor {
            required_limits: wgpu::Limits::downlevel_webgl2_defaults(),
            ..wgpu::DeviceDescriptor::default()
        });
        let errors = Arc::new(Mutex::new(Vec::new()));
        let sink = errors.clone();
        device.on_uncaptured_error(Arc::new(move |error| sink.lock().unwrap().push(error.to_string())));
        let frame_layout = frame_layout(&device);
        for sampling in [Sampling::Single, Sampling::Multi, Sampling::Super] {
            let composite =
                Composite::new(&Recipe { device: &device, frame_layout: &frame_layout, sampling });
            composite.targets(&device, [3, 5]);
            assert_eq!(*errors.lock().unwrap(), Vec::<String>::new(), "{sampling:?}");
        }
        assert_eq!(Sampling::new(4, wgpu::Backend::Gl), Sampling::Super);
    }
}
