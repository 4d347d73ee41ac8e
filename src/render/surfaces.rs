//! Primitives as lit surfaces, as parameter lines, and as silhouettes for the
//! outlines.

use std::collections::HashMap;

use super::frame::{Frame, Highlight, PrimitiveInstance, SurfacePaint};
use super::gpu::{self, Depth, Drawing, ElementBuffer, Recipe};
use super::lines::{Lines, Segment};
use crate::geometry::Superquadric;
use crate::geometry::tessellate::{Resolution, parameter_lines, surface_vertices};

const RESOLUTION: Resolution = Resolution::SCREEN;
const WIRES: Resolution = Resolution { profile: 4, section: 4 };

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
}

/// What differs between primitives without their shape being touched.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct Look {
    color: [u8; 4],
    look: [u8; 4],
    /// Who covers whom where faces coincide, [`ON_ALL`] for ghosts.
    level: f32,
}

/// Level of what lies on all primitives.
const ON_ALL: f32 = -1.0;
/// All of them are closer than what lies on all primitives.
const LEVELS: usize = 5;

/// A primitive on the GPU.
#[derive(Debug)]
struct Uploaded {
    shape: Superquadric,
    vertices: ElementBuffer,
    /// Parameter lines, made when they are first asked for, and their colour.
    wires: Option<([u8; 4], Highlight, ElementBuffer)>,
    /// A colour a vertex, where it was given.
    paint: Option<ElementBuffer>,
}

/// A level for each: different ones for primitives that touch, as far as there
/// are enough.
fn levels(instances: &[PrimitiveInstance]) -> Vec<f32> {
    // Boxes along the axes, a little larger: what lies close counts as touching.
    let boxes: Vec<_> = instances
        .iter()
        .map(|i| (i.shape.translation, 1.02 * i.shape.rotation.matrix().abs() * i.shape.half_extents()))
        .collect();
    let touch = |a: usize, b: usize| {
        let (apart, reach) = ((boxes[a].0 - boxes[b].0).abs(), boxes[a].1 + boxes[b].1);
        apart.iter().zip(&reach).all(|(apart, reach)| apart <= reach)
    };
    let mut levels: Vec<f32> = Vec::with_capacity(instances.len());
    for (i, instance) in instances.iter().enumerate() {
        if instance.ghost {
            levels.push(ON_ALL);
            continue;
        }
        let taken: Vec<f32> = (0..i).filter(|&j| touch(i, j)).map(|j| levels[j]).collect();
        let free = (0..LEVELS).map(|level| level as f32).find(|level| !taken.contains(level));
        levels.push(free.unwrap_or((i % LEVELS) as f32));
    }
    levels
}

/// A ghost may have the id of a primitive.
type Key = (u32, bool);

fn key(instance: &PrimitiveInstance) -> Key {
    (instance.id, instance.ghost)
}

fn paint_buffer() -> ElementBuffer {
    ElementBuffer::new("primitive paint", wgpu::BufferUsages::VERTEX, 4)
}

#[derive(Debug)]
pub(super) struct Surfaces {
    solid: wgpu::RenderPipeline,
    back: wgpu::RenderPipeline,
    front: wgpu::RenderPipeline,
    ghost: wgpu::RenderPipeline,
    mask: wgpu::RenderPipeline,
    /// All primitives have the same faces.
    faces: ElementBuffer,
    looks: ElementBuffer,
    /// The paint of those that have none.
    no_paint: ElementBuffer,
    uploaded: HashMap<Key, Uploaded>,
    instances: Vec<PrimitiveInstance>,
    /// Scratch memory of a tessellation.
    vertices: Vec<Vertex>,
    tessellations: u64,
}

impl Surfaces {
    pub(super) fn new(recipe: &Recipe<'_>) -> Self {
        let vertex = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
        let look = wgpu::vertex_attr_array![2 => Unorm8x4, 3 => Unorm8x4, 5 => Float32];
        let paint = wgpu::vertex_attr_array![4 => Unorm8x4];
        let buffers = [
            Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &vertex,
            }),
            Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Look>() as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &look,
            }),
            Some(wgpu::VertexBufferLayout {
                array_stride: 4,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &paint,
            }),
        ];
        let solid = Drawing {
            label: "surfaces",
            source: include_str!("../../shaders/surfaces.wgsl"),
            vertex: "vs_main",
            fragment: "fs_solid",
            buffers: &buffers,
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull: Some(wgpu::Face::Back),
            blend: None,
            depth: Depth::Write,
            alpha_to_coverage: false,
        };
        let front = Drawing {
            label: "translucent fronts",
            fragment: "fs_translucent_front",
            blend: Some(gpu::OVER),
            depth: Depth::Test,
            ..solid
        };
        let ghost = Drawing { label: "ghosts", fragment: "fs_ghost", ..front.clone() };
        let back = Drawing {
            label: "translucent backs",
            fragment: "fs_translucent_back",
            cull: Some(wgpu::Face::Front),
            ..front.clone()
        };
        let max =
            wgpu::BlendComponent { operation: wgpu::BlendOperation::Max, ..wgpu::BlendComponent::REPLACE };
        let max = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            ..max
        };
        let mask = Drawing {
            label: "silhouettes",
            source: include_str!("../../shaders/mask.wgsl"),
            vertex: "vs_main",
            fragment: "fs_main",
            blend: Some(wgpu::BlendState { color: max, alpha: max }),
            depth: Depth::None,
            ..solid
        };
        Self {
            solid: recipe.pipeline(&solid),
            back: recipe.pipeline(&back),
            front: recipe.pipeline(&front),
            ghost: recipe.pipeline(&ghost),
            mask: recipe.pipeline(&mask),
            faces: ElementBuffer::new("primitive faces", wgpu::BufferUsages::INDEX, 4),
            looks: ElementBuffer::new(
                "primitive looks",
                wgpu::BufferUsages::VERTEX,
                size_of::<Look>() as u64,
            ),
            no_paint: paint_buffer(),
            uploaded: HashMap::new(),
            instances: Vec::new(),
            vertices: Vec::new(),
            tessellations: 0,
        }
    }

    /// Shapes tessellated since the start.
    pub(super) fn tessellations(&self) -> u64 {
        self.tessellations
    }

    pub(super) fn set(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        instances: &[PrimitiveInstance],
    ) {
        self.instances.clear();
        self.instances.extend(instances.iter().filter(|i| i.shape.is_valid()));
        if self.faces.len() == 0 {
            self.faces.write(device, queue, &RESOLUTION.faces());
            self.no_paint.write(device, queue, &vec![[0_u8; 4]; RESOLUTION.vertices()]);
        }
        let looks: Vec<_> = self
            .instances
            .iter()
            .zip(levels(&self.instances))
            .map(|(i, level)| Look { color: i.color, look: gpu::look(i.highlight), level })
            .collect();
        self.looks.write(device, queue, &looks);

        let kept: std::collections::HashSet<Key> = self.instances.iter().map(key).collect();
        self.uploaded.retain(|key, _| kept.contains(key));
        for instance in &self.instances {
            let known = self.uploaded.get(&key(instance));
            if known.is_some_and(|u| u.shape == instance.shape) {
                continue;
            }
            self.vertices.clear();
            self.vertices.extend(surface_vertices(&instance.shape, RESOLUTION).map(|(p, n)| Vertex {
                position: [p.x as f32, p.y as f32, p.z as f32],
                normal: [n.x as f32, n.y as f32, n.z as f32],
            }));
            self.tessellations += 1;
            let entry = self.uploaded.entry(key(instance)).or_insert_with(|| Uploaded {
                shape: instance.shape,
                vertices: ElementBuffer::new(
                    "primitive vertices",
                    wgpu::BufferUsages::VERTEX,
                    size_of::<Vertex>() as u64,
                ),
                wires: None,
                paint: None,
            });
            entry.shape = instance.shape;
            entry.wires = None;
            // It was for another surface.
            entry.paint = None;
            entry.vertices.write(device, queue, &self.vertices);
        }
    }

    /// Paints the surfaces that are named, and takes the paint off the others.
    pub(super) fn set_paint(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, paint: &[SurfacePaint]) {
        for ((id, ghost), uploaded) in &mut self.uploaded {
            let given =
                paint.iter().find(|p| p.id == *id && !ghost && p.colors.len() == RESOLUTION.vertices());
            let Some(given) = given else {
                uploaded.paint = None;
                continue;
            };
            uploaded.paint.get_or_insert_with(paint_buffer).write(device, queue, &given.colors);
        }
    }

    /// Whether a visible primitive wants an outline.
    pub(super) fn has_outlines(&self) -> bool {
        self.visible().any(|i| self.instances[i].highlight != Highlight::None)
    }

    fn draw_one(&self, pass: &mut wgpu::RenderPass<'_>, index: usize) {
        let Some(uploaded) = self.uploaded.get(&key(&self.instances[index])) else { return };
        let paint = uploaded.paint.as_ref().unwrap_or(&self.no_paint);
        let buffers = (uploaded.vertices.slice(), self.looks.element(index as u32), paint.slice());
        if let (Some(vertices), Some(look), Some(paint)) = buffers {
            pass.set_vertex_buffer(0, vertices);
            pass.set_vertex_buffer(1, look);
            pass.set_vertex_buffer(2, paint);
            pass.draw_indexed(0..3 * (RESOLUTION.faces_len() as u32), 0, 0..1);
        }
    }

    fn visible(&self) -> impl Iterator<Item = usize> {
        (0..self.instances.len()).filter(|&i| self.instances[i].visible && !self.instances[i].ghost)
    }

    /// What is not there yet, over all that is.
    pub(super) fn draw_ghosts(&self, pass: &mut wgpu::RenderPass<'_>) {
        if self.set_faces(pass) {
            pass.set_pipeline(&self.ghost);
            let ghosts =
                (0..self.instances.len()).filter(|&i| self.instances[i].visible && self.instances[i].ghost);
            ghosts.for_each(|i| self.draw_one(pass, i));
        }
    }

    fn set_faces(&self, pass: &mut wgpu::RenderPass<'_>) -> bool {
        let Some(faces) = self.faces.slice() else { return false };
        pass.set_index_buffer(faces, wgpu::IndexFormat::Uint32);
        true
    }

    pub(super) fn draw_solid(&self, pass: &mut wgpu::RenderPass<'_>) {
        if self.set_faces(pass) {
            pass.set_pipeline(&self.solid);
            self.visible().for_each(|i| self.draw_one(pass, i));
        }
    }

    /// Far ones first, and of each its far side first.
    pub(super) fn draw_translucent(&self, pass: &mut wgpu::RenderPass<'_>, frame: &Frame) {
        if !self.set_faces(pass) {
            return;
        }
        let depth = |i: usize| {
            let t = &self.instances[i].shape.translation;
            let center = glam::Vec3::new(t.x as f32, t.y as f32, t.z as f32);
            frame.camera.view_from_world.transform_point3(center).z
        };
        let mut order: Vec<_> = self.visible().map(|i| (depth(i), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        for &(_, i) in &order {
            pass.set_pipeline(&self.back);
            self.draw_one(pass, i);
            pass.set_pipeline(&self.front);
            self.draw_one(pass, i);
        }
    }

    pub(super) fn draw_mask(&self, pass: &mut wgpu::RenderPass<'_>) {
        if self.set_faces(pass) {
            pass.set_pipeline(&self.mask);
            let lit = |i: &usize| self.instances[*i].highlight != Highlight::None;
            self.visible().filter(lit).for_each(|i| self.draw_one(pass, i));
        }
    }

    /// Makes the parameter lines that are still missing.
    pub(super) fn prepare_wires(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) {
        for instance in self.instances.iter().filter(|i| i.visible && !i.ghost) {
            let Some(uploaded) = self.uploaded.get_mut(&key(instance)) else { continue };
            let same =
                |w: &([u8; 4], Highlight, ElementBuffer)| (w.0, w.1) == (instance.color, instance.highlight);
            if uploaded.wires.as_ref().is_some_and(same) {
                continue;
            }
            let width = if instance.highlight == Highlight::None { 1.15 } else { 2.0 };
            let mut segments = Vec::new();
            for line in parameter_lines(&instance.shape, WIRES) {
                segments.extend(line.windows(2).map(|w| {
                    let normal = (w[0].1 + w[1].1) * 0.5;
                    Segment {
                        from: w[0].0.coords.map(|c| c as f32).into(),
                        to: w[1].0.coords.map(|c| c as f32).into(),
                        normal: normal.map(|c| c as f32).into(),
                        color: instance.color,
                        width,
                    }
                }));
            }
            let mut buffer = uploaded.wires.take().map_or_else(Segment::buffer, |w| w.2);
            buffer.write(device, queue, &segments);
            uploaded.wires = Some((instance.color, instance.highlight, buffer));
        }
    }

    pub(super) fn draw_wires(&self, pass: &mut wgpu::RenderPass<'_>, lines: &Lines) {
        for i in self.visible() {
            if let Some((_, _, wires)) =
                self.uploaded.get(&key(&self.instances[i])).and_then(|u| u.wires.as_ref())
            {
                lines.draw(pass, wires);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn primitives_that_touch_have_different_levels() {
        let at = |id: u32, x: f64, ghost: bool| PrimitiveInstance {
            id,
            shape: Superquadric::sphere(Point3::new(x, 0.0, 0.0), 0.6),
            color: [255; 4],
            visible: true,
            highlight: Highlight::None,
            ghost,
        };
        let row: Vec<_> = (0..40).map(|i| at(i, f64::from(i), i == 7)).collect();
        let levels = levels(&row);
        assert_eq!(levels[7], ON_ALL);
        assert!(levels.windows(2).all(|pair| pair[0] != pair[1]), "{levels:?}");
        assert!(levels.iter().all(|level| *level <= 1.0), "no more than it takes: {levels:?}");
    }
}
