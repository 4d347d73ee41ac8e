//! What a parser hands over, and the checks that all formats share.

use nalgebra::Point3;
use rayon::prelude::*;

use super::text::counted;
use crate::geometry::TriMesh;
use crate::geometry::mesh::has_area;
use crate::io::error::Fault;
use crate::io::{Attributes, PointCloud, Shape, ShapeGeometry};

/// A shape as a parser found it, unchecked.
#[derive(Debug, Default)]
pub(super) struct Raw {
    pub(super) points: Vec<Point3<f64>>,
    /// One entry a point.
    pub(super) attributes: Attributes,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Faces whose indices point nowhere, which the parser left out.
    pub(super) faces_out_of_range: usize,
    pub(super) notes: Vec<String>,
}

impl Raw {
    /// Tells mesh from cloud, and leaves out what no surface can be made of,
    /// with a note.
    pub(super) fn checked(mut self, name: String) -> Result<Shape, Fault> {
        if self.points.is_empty() {
            return Err(Fault::whole("it has no points; export the shape again"));
        }
        if self.triangles.is_empty() && self.faces_out_of_range == 0 {
            return self.into_cloud(name);
        }
        let mesh = TriMesh {
            vertices: std::mem::take(&mut self.points),
            faces: std::mem::take(&mut self.triangles),
        };
        #[derive(Clone, Copy, PartialEq)]
        enum Face {
            Sound,
            NotFinite,
            Flat,
        }
        let kinds: Vec<Face> = mesh
            .faces
            .par_iter()
            .map(|face| match mesh.corners(face) {
                None => Face::NotFinite,
                Some(corners) if !has_area(&corners) => Face::Flat,
                Some(_) => Face::Sound,
            })
            .collect();
        let number_of = |kind| kinds.iter().filter(|k| **k == kind).count();
        let (not_finite, flat) = (number_of(Face::NotFinite), number_of(Face::Flat));
        let sound = mesh.faces.iter().zip(&kinds).filter(|(_, kind)| **kind == Face::Sound);
        let faces: Vec<[u32; 3]> = sound.map(|(face, _)| *face).collect();
        for (n, why) in [
            (self.faces_out_of_range, "pointing to vertices that are not in the file"),
            (not_finite, "with a coordinate that is not a finite number"),
            (flat, "without an area"),
        ] {
            if n > 0 {
                self.notes.push(format!("left out {} {why}", counted(n, "face", "faces")));
            }
        }
        if faces.is_empty() {
            self.notes.push("no face has an area: taken as a point cloud of its vertices".to_owned());
            self.points = mesh.vertices;
            return self.into_cloud(name);
        }
        let (mesh, kept) = compact(&mesh.vertices, faces);
        let attributes = self.attributes.of(&kept);
        Ok(Shape {
            name,
            path: None,
            content: None,
            geometry: ShapeGeometry::Mesh(mesh),
            attributes,
            notes: self.notes,
        })
    }

    fn into_cloud(mut self, name: String) -> Result<Shape, Fault> {
        let lost = self.points.iter().filter(|p| !p.iter().all(|c| c.is_finite())).count();
        if lost == self.points.len() {
            return Err(Fault::whole("none of its points has finite coordinates; export the shape again"));
        }
        if lost > 0 {
            let points = counted(lost, "point has", "points have");
            self.notes
                .push(format!("{points} a coordinate that is not a finite number and will get no label"));
        }
        let geometry = ShapeGeometry::Cloud(PointCloud { points: self.points });
        Ok(Shape {
            name,
            path: None,
            content: None,
            geometry,
            attributes: self.attributes,
            notes: self.notes,
        })
    }
}

/// The mesh without vertices that no face uses, which would stretch its box.
/// The others keep their order; also which those are.
fn compact(vertices: &[Point3<f64>], mut faces: Vec<[u32; 3]>) -> (TriMesh, Vec<u32>) {
    const UNUSED: u32 = u32::MAX;
    let mut renamed = vec![UNUSED; vertices.len()];
    for &i in faces.iter().flatten() {
        renamed[i as usize] = 0;
    }
    let mut kept = Vec::with_capacity(vertices.len());
    for (i, name) in (0..).zip(renamed.iter_mut()) {
        if *name != UNUSED {
            *name = kept.len() as u32;
            kept.push(i);
        }
    }
    for i in faces.iter_mut().flatten() {
        *i = renamed[*i as usize];
    }
    let vertices = kept.iter().map(|&i| vertices[i as usize]).collect();
    (TriMesh { vertices, faces }, kept)
}
