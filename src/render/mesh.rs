//! The input mesh, as a ghost or a solid.

use std::collections::HashMap;

use glam::Vec3;

use super::gpu::{self, Depth, Drawing, ElementBuffer, Recipe};

/// Faces that meet at less than this angle (as a cosine, 40°) share normals.
const CREASE: f32 = 0.766;

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
}

#[derive(Debug)]
pub(super) struct InputMesh {
    ghost: wgpu::RenderPipeline,
    solid: wgpu::RenderPipeline,
    vertices: ElementBuffer,
}

impl InputMesh {
    pub(super) fn new(recipe: &Recipe<'_>) -> Self {
        let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
        let buffers = [Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        })];
        let solid = Drawing {
            label: "input mesh",
            source: include_str!("../../shaders/mesh.wgsl"),
            vertex: "vs_solid",
            fragment: "fs_solid",
            buffers: &buffers,
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull: None,
            blend: None,
            depth: Depth::Write,
            alpha_to_coverage: false,
        };
        let ghost = Drawing {
            label: "ghost of the input mesh",
            vertex: "vs_ghost",
            fragment: "fs_ghost",
            blend: Some(gpu::OVER),
            depth: Depth::Test,
            ..solid
        };
        Self {
            ghost: recipe.pipeline(&ghost),
            solid: recipe.pipeline(&solid),
            vertices: ElementBuffer::new(
                "input mesh",
                wgpu::BufferUsages::VERTEX,
                size_of::<Vertex>() as u64,
            ),
        }
    }

    pub(super) fn set(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        vertices: &[[f32; 3]],
        faces: &[[u32; 3]],
    ) {
        let mut corners = shaded_corners(vertices, faces);
        // Whole triangles only, should the device hold no more.
        let limit = self.vertices.limit(device);
        corners.truncate(limit - limit % 3);
        self.vertices.write(device, queue, &corners);
    }

    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, ghost: bool) {
        if let Some(vertices) = self.vertices.slice() {
            pass.set_pipeline(if ghost { &self.ghost } else { &self.solid });
            pass.set_vertex_buffer(0, vertices);
            pass.draw(0..self.vertices.len(), 0..1);
        }
    }
}

/// Three vertices a face, with normals that are smooth over soft edges and
/// apart at sharp ones. Vertices at the same place count as one.
fn shaded_corners(vertices: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<Vertex> {
    let usable = |f: &&[u32; 3]| {
        let corner = |i: &u32| vertices.get(*i as usize).is_some_and(|v| v.iter().all(|c| c.is_finite()));
        f.iter().all(corner)
    };
    let faces: Vec<[u32; 3]> = faces.iter().filter(usable).copied().collect();

    let mut places = HashMap::with_capacity(vertices.len());
    let place: Vec<usize> = vertices
        .iter()
        .map(|v| {
            let next = places.len();
            // −0 and 0 are one place.
            *places.entry(v.map(|c| (c + 0.0).to_bits())).or_insert(next)
        })
        .collect();
    // Twice the area times the unit normal.
    let normals: Vec<Vec3> = faces
        .iter()
        .map(|f| {
            let [a, b, c] = f.map(|i| Vec3::from_array(vertices[i as usize]));
            (b - a).cross(c - a)
        })
        .collect();
    // The faces around each place, as a list of lists in one array.
    let mut start = vec![0usize; places.len() + 1];
    for &i in faces.iter().flatten() {
        start[place[i as usize] + 1] += 1;
    }
    for k in 1..start.len() {
        start[k] += start[k - 1];
    }
    let mut fill = start.clone();
    let mut around = vec![0usize; 3 * faces.len()];
    for (k, &i) in faces.iter().enumerate().flat_map(|(k, f)| f.iter().map(move |i| (k, i))) {
        let slot = &mut fill[place[i as usize]];
        around[*slot] = k;
        *slot += 1;
    }

    let mut corners = Vec::with_capacity(3 * faces.len());
    for (k, face) in faces.iter().enumerate() {
        let own = normals[k].normalize_or_zero();
        for &i in face {
            let neighbors = &around[start[place[i as usize]]..start[place[i as usize] + 1]];
            let soft = |j: &&usize| own.dot(normals[**j].normalize_or_zero()).abs() >= CREASE;
            // Neighbours may be wound the other way.
            let normal: Vec3 = neighbors
                .iter()
                .filter(soft)
                .map(|&j| normals[j] * if own.dot(normals[j]) < 0.0 { -1.0 } else { 1.0 })
                .sum();
            let normal = normal.try_normalize().unwrap_or(if own == Vec3::ZERO { Vec3::Z } else { own });
            corners.push(Vertex { position: vertices[i as usize], normal: normal.to_array() });
        }
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_are_smooth_over_soft_edges_and_apart_at_sharp_ones() {
        // Two faces at a right angle and two in nearly one plane, unwelded.
        let sharp = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 0.], [1., 0., 0.], [0., 0., 1.]];
        let corners = shaded_corners(&sharp, &[[0, 1, 2], [3, 4, 5]]);
        assert_eq!(corners[0].normal, [0., 0., 1.]);
        let soft = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 0.], [1., 0., 0.], [0., -1., 0.2]];
        let corners = shaded_corners(&soft, &[[0, 1, 2], [3, 5, 4]]);
        assert_eq!(corners[0].normal, corners[3].normal);
        assert!(corners[0].normal[2] > 0.98 && corners[0].normal[2] < 1.0);
        assert_eq!(corners[2].normal, [0., 0., 1.]);
    }

    #[test]
    fn faces_that_point_nowhere_are_left_out() {
        let vertices = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [f32::NAN, 0., 0.]];
        assert!(shaded_corners(&vertices, &[[0, 1, 7], [0, 1, 3]]).is_empty());
        // A face without area has a normal all the same.
        let flat = shaded_corners(&vertices, &[[0, 1, 1]]);
        assert!(flat.iter().all(|v| Vec3::from_array(v.normal).is_normalized()));
    }
}
