//! A mesh made fit for measuring: one vertex a place, no face twice.

use std::collections::HashSet;

use nalgebra::Point3;

use crate::geometry::TriMesh;
use crate::geometry::frame::Frame;
use crate::geometry::mesh::bounds;

/// Vertices closer than about this part of the longest edge are one.
const SAME_PLACE: f64 = 1e-6;

/// The faces of a mesh in the frame of its box.
#[derive(Debug)]
pub(super) struct CleanMesh {
    pub(super) frame: Frame,
    /// Lower and upper corner of the box, in the frame.
    pub(super) bounds: (Point3<f64>, Point3<f64>),
    pub(super) vertices: Vec<Point3<f64>>,
    pub(super) faces: Vec<[u32; 3]>,
    /// Faces left out because another one has the same corners.
    pub(super) duplicates: usize,
}

impl CleanMesh {
    /// Merges vertices of the same place, leaves out faces that have become
    /// degenerate and all but the first of those with the same corners. `None`
    /// where nothing with an extent is left.
    pub(super) fn new(mesh: &TriMesh) -> Option<Self> {
        let sound: Vec<[Point3<f64>; 3]> = mesh.faces.iter().filter_map(|f| mesh.corners(f)).collect();
        let frame = Frame::of_edge(sound.iter().flatten().copied())?;
        let local: Vec<Point3<f64>> = sound.iter().flatten().map(|p| frame.local(p)).collect();
        let bounds = bounds(local.iter().copied())?;
        let key = |p: &Point3<f64>| ((p - bounds.0) / SAME_PLACE).map(|c| c.round() as i64);
        let mut order: Vec<([i64; 3], u32)> = local.iter().map(|p| key(p).into()).zip(0..).collect();
        order.sort_unstable();
        let mut vertices = Vec::new();
        let mut vertex_of = vec![0u32; local.len()];
        for place in order.chunk_by(|a, b| a.0 == b.0) {
            for &(_, corner) in place {
                vertex_of[corner as usize] = vertices.len() as u32;
            }
            vertices.push(local[place[0].1 as usize]);
        }
        let mut seen = HashSet::with_capacity(sound.len());
        let mut duplicates = 0;
        let faces = vertex_of
            .chunks_exact(3)
            .map(|f| [f[0], f[1], f[2]])
            .filter(|&[a, b, c]| a != b && b != c && c != a)
            .filter(|face| {
                let mut sorted = *face;
                sorted.sort_unstable();
                let new = seen.insert(sorted);
                duplicates += usize::from(!new);
                new
            })
            .collect::<Vec<_>>();
        (!faces.is_empty()).then_some(Self { frame, bounds, vertices, faces, duplicates })
    }

    /// Corners of all faces, in the frame.
    pub(super) fn triangles(&self) -> Vec<[Point3<f64>; 3]> {
        self.faces.iter().map(|f| f.map(|i| self.vertices[i as usize])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_soup_becomes_a_mesh_and_nothing_counts_twice() {
        let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        let (a, b, c, d) = (p(0.0, 0.0, 0.0), p(2.0, 0.0, 0.0), p(0.0, 1.0, 0.0), p(2.0, 1.0, 1.0));
        let near = p(2.0, 1e-7, 0.0);
        let far = p(1e9, 0.0, 0.0);
        let mesh = TriMesh {
            vertices: vec![a, b, c, near, d, c, far, p(f64::NAN, 0.0, 0.0)],
            faces: vec![[0, 1, 2], [3, 4, 5], [2, 0, 3], [1, 3, 4], [0, 1, 7]],
        };
        let clean = CleanMesh::new(&mesh).unwrap();
        assert_eq!(clean.vertices.len(), 4, "the far vertex has no face");
        assert_eq!((clean.faces.len(), clean.duplicates), (2, 1));
        assert_eq!(clean.frame.unit, 2.0);
        assert!((clean.bounds.1 - clean.bounds.0 - nalgebra::Vector3::new(1.0, 0.5, 0.5)).norm() < 1e-6);
        assert!(CleanMesh::new(&TriMesh::default()).is_none());
        let point = TriMesh { vertices: vec![a; 3], faces: vec![[0, 1, 2]] };
        assert!(CleanMesh::new(&point).is_none());
    }
}
