//! What all pipelines share: the scene's formats, the frame's uniforms, the
//! pipeline recipe and buffers that grow.

use glam::Vec4;

use super::frame::{Background, Frame, Highlight};

/// Format of the scene's colour samples and of the finished picture; holds
/// sRGB-encoded values, premultiplied. (sRGB formats fail on some GL drivers.)
pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Premultiplied "over".
pub(super) const OVER: wgpu::BlendState = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;

const COMMON: &str = include_str!("../../shaders/common.wgsl");

/// How the scene's edges are smoothed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sampling {
    /// They are not.
    Single,
    /// Four samples a pixel in multisampled textures.
    Multi,
    /// Textures of twice the width and height: wgpu's GL backend can't read
    /// from multisampled textures.
    Super,
}

impl Sampling {
    pub(super) fn new(msaa: u32, backend: wgpu::Backend) -> Self {
        match (msaa, backend) {
            (0 | 1, _) => Self::Single,
            (_, wgpu::Backend::Gl) => Self::Super,
            _ => Self::Multi,
        }
    }

    /// Samples a texel of the scene's textures.
    pub(super) fn samples(self) -> u32 {
        if self == Self::Multi { 4 } else { 1 }
    }

    /// Texels of the scene's textures along the side of a pixel.
    pub(super) fn scale(self) -> u32 {
        if self == Self::Super { 2 } else { 1 }
    }
}

/// The struct `Frame` of common.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct FrameUniforms {
    view_from_world: [[f32; 4]; 4],
    clip_from_view: [[f32; 4]; 4],
    size: [f32; 4],
    eye: [f32; 4],
    params: [f32; 4],
    flags: [f32; 4],
    background: [[f32; 4]; 2],
    grid: [[f32; 4]; 3],
    grid_color: [f32; 4],
    ghost_color: [f32; 4],
    selected_color: [f32; 4],
    hovered_color: [f32; 4],
    lit_color: [f32; 4],
}

impl FrameUniforms {
    /// `size` is the size of the picture, which may be limited.
    pub(super) fn new(frame: &Frame, size: [u32; 2], sampling: Sampling, has_outlines: bool) -> Self {
        let camera = &frame.camera;
        let (transparent, background) = match frame.theme.background {
            Background::Gradient { top, bottom } => (0.0, [top, bottom]),
            Background::Transparent => (1.0, [[0.0; 4]; 2]),
        };
        let [w, h] = size.map(|s| s as f32);
        let scale = frame.pixels_per_point.max(0.25);
        // The size of a point holds at the depth of the scene's centre, but is
        // not blown up when the camera goes close to one part.
        let reference_depth = (-camera.view_from_world.w_axis.z).max(0.3);
        let ortho = if camera.is_orthographic() { 1.0 } else { 0.0 };
        let outlines = if has_outlines { 1.0 } else { 0.0 };
        let grid = &frame.grid;
        Self {
            view_from_world: camera.view_from_world.to_cols_array_2d(),
            clip_from_view: camera.clip_from_view.to_cols_array_2d(),
            size: [w, h, 1.0 / w, 1.0 / h],
            eye: Vec4::from((camera.eye(), ortho)).to_array(),
            params: [scale, frame.point_size * scale, frame.translucency.clamp(0.0, 1.0), frame.depth_cues],
            flags: [reference_depth, transparent, outlines, 0.22],
            background,
            grid: [
                Vec4::from((grid.origin, grid.spacing.max(1e-6))).to_array(),
                Vec4::from((grid.axis_u, grid.radius)).to_array(),
                Vec4::from((grid.axis_v, sampling.scale() as f32)).to_array(),
            ],
            grid_color: frame.theme.grid,
            ghost_color: frame.theme.ghost,
            selected_color: frame.theme.selected,
            hovered_color: frame.theme.hovered,
            lit_color: frame.theme.lit,
        }
    }
}

/// The look of a highlight as the surface shaders take it: brightened,
/// hovered mask, selected mask, lit mask.
pub(super) fn look(highlight: Highlight) -> [u8; 4] {
    match highlight {
        Highlight::None => [0, 0, 0, 0],
        Highlight::Hovered => [255, 255, 0, 0],
        Highlight::Selected => [110, 0, 255, 0],
        Highlight::Lit => [170, 0, 0, 255],
    }
}

/// Layout of group 0, the frame's uniforms.
pub(super) fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("frame"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

/// What pipelines are built from.
#[derive(Debug)]
pub(super) struct Recipe<'a> {
    pub(super) device: &'a wgpu::Device,
    pub(super) frame_layout: &'a wgpu::BindGroupLayout,
    pub(super) sampling: Sampling,
}

/// How a pipeline of the scene's pass differs from the others.
#[derive(Debug, Clone)]
pub(super) struct Drawing<'a> {
    pub(super) label: &'a str,
    pub(super) source: &'a str,
    pub(super) vertex: &'a str,
    pub(super) fragment: &'a str,
    pub(super) buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    pub(super) topology: wgpu::PrimitiveTopology,
    pub(super) cull: Option<wgpu::Face>,
    pub(super) blend: Option<wgpu::BlendState>,
    /// Whether the depth is tested and written, only tested, or absent.
    pub(super) depth: Depth,
    pub(super) alpha_to_coverage: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Depth {
    Write,
    Test,
    /// The pass has no depth texture.
    None,
}

impl Recipe<'_> {
    /// A shader of the scene: common.wgsl and then `source`.
    pub(super) fn shader(&self, label: &str, sources: &[&str]) -> wgpu::ShaderModule {
        let source = std::iter::once(COMMON).chain(sources.iter().copied()).collect::<Vec<_>>().join("\n");
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        })
    }

    pub(super) fn pipeline(&self, drawing: &Drawing<'_>) -> wgpu::RenderPipeline {
        let module = self.shader(drawing.label, &[drawing.source]);
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(drawing.label),
            bind_group_layouts: &[Some(self.frame_layout)],
            immediate_size: 0,
        });
        let depth = wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(drawing.depth == Depth::Write),
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        };
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(drawing.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(drawing.vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: drawing.buffers,
            },
            primitive: wgpu::PrimitiveState {
                topology: drawing.topology,
                cull_mode: drawing.cull,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: (drawing.depth != Depth::None).then_some(depth),
            multisample: wgpu::MultisampleState {
                count: self.sampling.samples(),
                mask: !0,
                alpha_to_coverage_enabled: drawing.alpha_to_coverage,
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(drawing.fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: COLOR_FORMAT,
                    blend: drawing.blend,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A vertex or index buffer with a length in elements; its memory grows and
/// is used again.
#[derive(Debug)]
pub(super) struct ElementBuffer {
    label: &'static str,
    usage: wgpu::BufferUsages,
    /// Bytes an element.
    stride: u64,
    buffer: Option<wgpu::Buffer>,
    len: u32,
}

impl ElementBuffer {
    pub(super) fn new(label: &'static str, usage: wgpu::BufferUsages, stride: u64) -> Self {
        Self { label, usage: usage | wgpu::BufferUsages::COPY_DST, stride, buffer: None, len: 0 }
    }

    /// Elements that the device can hold in one buffer.
    pub(super) fn limit(&self, device: &wgpu::Device) -> usize {
        usize::try_from(device.limits().max_buffer_size / self.stride)
            .unwrap_or(usize::MAX)
            .min(u32::MAX as usize)
    }

    /// Replaces the content; what the device can't hold is left out.
    pub(super) fn write<T: bytemuck::NoUninit>(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        elements: &[T],
    ) {
        let bytes: &[u8] = bytemuck::cast_slice(elements);
        let len = (bytes.len() / self.stride as usize).min(self.limit(device));
        let bytes = &bytes[..len * self.stride as usize];
        self.len = len as u32;
        if bytes.is_empty() {
            return;
        }
        let fits = self.buffer.as_ref().is_some_and(|b| b.size() >= bytes.len() as u64);
        if !fits {
            self.buffer = Some(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(self.label),
                size: (bytes.len() as u64).next_multiple_of(4),
                usage: self.usage,
                mapped_at_creation: false,
            }));
        }
        if let Some(buffer) = &self.buffer {
            queue.write_buffer(buffer, 0, bytes);
        }
    }

    /// Overwrites the first elements of what is there.
    pub(super) fn overwrite<T: bytemuck::NoUninit>(&self, queue: &wgpu::Queue, elements: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(elements);
        let bytes = &bytes[..bytes.len().min(self.len as usize * self.stride as usize)];
        if let (Some(buffer), false) = (&self.buffer, bytes.is_empty()) {
            queue.write_buffer(buffer, 0, bytes);
        }
    }

    pub(super) fn len(&self) -> u32 {
        self.len
    }

    /// The elements in use; `None` if there are none (an empty slice panics).
    pub(super) fn slice(&self) -> Option<wgpu::BufferSlice<'_>> {
        let buffer = self.buffer.as_ref()?;
        (self.len > 0).then(|| buffer.slice(..u64::from(self.len) * self.stride))
    }

    /// One element.
    pub(super) fn element(&self, index: u32) -> Option<wgpu::BufferSlice<'_>> {
        let buffer = self.buffer.as_ref()?;
        let start = u64::from(index) * self.stride;
        (index < self.len).then(|| buffer.slice(start..start + self.stride))
    }
}
