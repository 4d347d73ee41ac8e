//! Owns what is on the GPU and draws frames.

use super::blit::Blit;
use super::composite::{Composite, Targets};
use super::frame::{Frame, InputStyle, LineSegment, PrimitiveInstance, SurfacePaint, SurfaceStyle};
use super::gpu::{self, FrameUniforms, Recipe, Sampling};
use super::grid::GridPlane;
use super::lines::Lines;
use super::mesh::InputMesh;
use super::points::Points;
use super::surfaces::Surfaces;

/// Fixed for the life of a [`Renderer`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RenderOptions {
    /// Samples a pixel: 4 where the hardware draws, 1 for slow software
    /// drivers. 2 and more count as 4.
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
    sampling: Sampling,
    uniforms: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    points: Points,
    surfaces: Surfaces,
    mesh: InputMesh,
    lines: Lines,
    grid: GridPlane,
    composite: Composite,
    blit: Blit,
    targets: Option<(Targets, wgpu::BindGroup)>,
    /// The frame that the picture shows; `None` if data changed since.
    shown: Option<Frame>,
}

impl Renderer {
    /// Builds all pipelines. `color_format` is the format of the pass that
    /// [`Renderer::paint`] is given.
    pub fn new(device: &wgpu::Device, color_format: wgpu::TextureFormat, options: RenderOptions) -> Self {
        let options = RenderOptions { msaa: if options.msaa >= 2 { 4 } else { 1 } };
        let sampling = Sampling::new(options.msaa, device.adapter_info().backend);
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<FrameUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let frame_layout = gpu::frame_layout(device);
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &frame_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniforms.as_entire_binding() }],
        });
        let recipe = Recipe { device, frame_layout: &frame_layout, sampling };
        Self {
            options,
            sampling,
            points: Points::new(&recipe),
            surfaces: Surfaces::new(&recipe),
            mesh: InputMesh::new(&recipe),
            lines: Lines::new(&recipe),
            grid: GridPlane::new(&recipe),
            composite: Composite::new(&recipe),
            blit: Blit::new(device, color_format),
            uniforms,
            frame_group,
            targets: None,
            shown: None,
        }
    }

    /// The largest side of a picture, in pixels.
    pub fn largest_side(&self, device: &wgpu::Device) -> u32 {
        device.limits().max_texture_dimension_2d / self.sampling.scale()
    }

    /// Gives back the textures, which the next frame makes anew.
    pub fn release(&mut self) {
        self.targets = None;
        self.shown = None;
    }

    /// The options in force.
    pub fn options(&self) -> RenderOptions {
        self.options
    }

    /// Replaces the points (scene units); points that are not finite are not
    /// drawn. All are white until [`Renderer::set_point_colors`].
    pub fn set_points(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, points: &[[f32; 3]]) {
        self.points.set_points(device, queue, points);
        self.shown = None;
    }

    /// Colours the points, one colour a point in their order; surplus colours
    /// are ignored, missing ones leave the old. Alpha 0 hides a point,
    /// one of 128 marks it as selected.
    pub fn set_point_colors(&mut self, queue: &wgpu::Queue, colors: &[[u8; 4]]) {
        self.points.set_colors(queue, colors);
        self.shown = None;
    }

    /// Replaces the input mesh; with no faces there is none. Faces with an
    /// index out of range or a corner that is not finite are left out.
    pub fn set_mesh(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        vertices: &[[f32; 3]],
        faces: &[[u32; 3]],
    ) {
        self.mesh.set(device, queue, vertices, faces);
        self.shown = None;
    }

    /// Replaces the primitives; those whose shape is not valid are left out.
    /// One whose id and shape are the same as before keeps its tessellation: a
    /// change of colour, highlight or visibility uploads next to nothing.
    pub fn set_primitives(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        primitives: &[PrimitiveInstance],
    ) {
        self.surfaces.set(device, queue, primitives);
        self.shown = None;
    }

    /// Paints the surfaces of primitives that were set before, and takes the
    /// paint off those that are not named; one whose shape changes loses it. A
    /// paint of another length than the surface has vertices is left out.
    pub fn set_paint(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, paint: &[SurfacePaint]) {
        self.surfaces.set_paint(device, queue, paint);
        self.shown = None;
    }

    /// How many shapes were tessellated so far.
    pub fn tessellations(&self) -> u64 {
        self.surfaces.tessellations()
    }

    /// Replaces the free lines (gizmos, boxes).
    pub fn set_lines(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, lines: &[LineSegment]) {
        self.lines.set_free(device, queue, lines);
        self.shown = None;
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
        if self.shown.as_ref() == Some(frame) {
            return false;
        }
        let size = frame.size_px.map(|s| s.min(self.largest_side(device)));
        if size.contains(&0) {
            self.targets = None;
            self.shown = None;
            return false;
        }
        if self.targets.as_ref().is_none_or(|(t, _)| t.size != size) {
            let targets = self.composite.targets(device, size);
            let picture = self.blit.bind(device, &targets.picture);
            self.targets = Some((targets, picture));
        }
        let wires = frame.layers.primitives && frame.surface_style == SurfaceStyle::Wire;
        if wires {
            self.surfaces.prepare_wires(device, queue);
        }
        let outlines = frame.layers.primitives && self.surfaces.has_outlines();
        let uniforms = FrameUniforms::new(frame, size, self.sampling, outlines);
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));

        if let Some((targets, _)) = &self.targets {
            self.draw_scene(encoder, targets, frame);
            if outlines {
                self.draw_mask(encoder, targets);
            }
            self.composite.draw(encoder, targets, &self.frame_group);
        }
        self.shown = Some(*frame);
        true
    }

    fn draw_scene(&self, encoder: &mut wgpu::CommandEncoder, targets: &Targets, frame: &Frame) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &targets.color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(wgpu::Operations {
                    // Reversed depth: 0 is far away.
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.frame_group, &[]);
        let layers = &frame.layers;
        // What is opaque, then what lets through, from the ground up.
        if layers.input && frame.input_style == InputStyle::Solid {
            self.mesh.draw(&mut pass, false);
        }
        if layers.primitives && frame.surface_style == SurfaceStyle::Solid {
            self.surfaces.draw_solid(&mut pass);
        }
        if layers.points {
            self.points.draw(&mut pass);
        }
        if layers.grid {
            self.grid.draw(&mut pass);
        }
        if layers.primitives {
            match frame.surface_style {
                SurfaceStyle::Solid => {}
                SurfaceStyle::Translucent => self.surfaces.draw_translucent(&mut pass, frame),
                SurfaceStyle::Wire => self.surfaces.draw_wires(&mut pass, &self.lines),
            }
        }
        if layers.primitives {
            self.surfaces.draw_ghosts(&mut pass);
        }
        if layers.input && frame.input_style == InputStyle::Ghost {
            self.mesh.draw(&mut pass, true);
        }
        if layers.lines {
            self.lines.draw_free(&mut pass);
        }
    }

    fn draw_mask(&self, encoder: &mut wgpu::CommandEncoder, targets: &Targets) {
        let (view, resolve_target) = match &targets.mask_samples {
            Some(samples) => (samples, Some(&targets.mask)),
            None => (&targets.mask, None),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("silhouettes"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.frame_group, &[]);
        self.surfaces.draw_mask(&mut pass);
    }

    /// Copies the picture over the pass's viewport. The pass must have one
    /// colour target of the format given to [`Renderer::new`], no depth and
    /// one sample a pixel.
    pub fn paint(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some((_, picture)) = &self.targets {
            self.blit.draw(pass, picture);
        }
    }

    /// The finished picture: Rgba8Unorm, sRGB-encoded, premultiplied.
    pub(super) fn picture(&self) -> Option<&wgpu::Texture> {
        self.targets.as_ref().map(|(targets, _)| &targets.picture_texture)
    }
}
