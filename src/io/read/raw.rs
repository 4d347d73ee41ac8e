//! The output of a parser, and the checks shared by all formats.

use std::ops::Range;

use nalgebra::Point3;
use rayon::prelude::*;

use super::polygon;
use super::text::counted;
use crate::geometry::TriMesh;
use crate::geometry::mesh::has_area;
use crate::io::error::Fault;
use crate::io::shape::{Attributes, PointCloud, Shape, ShapeGeometry};

/// The ends of fewer lines than this are no cloud of points on a surface.
const SPARSE: usize = 1000;

/// A shape as a parser found it, unchecked.
#[derive(Debug, Default)]
pub(super) struct Raw {
    pub(super) points: Vec<Point3<f64>>,
    /// One entry a point.
    pub(super) attributes: Attributes,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Which of the triangles are a polygon of more than three corners, as a
    /// fan around its first one; see [`polygon`].
    pub(super) fans: Vec<Range<usize>>,
    /// Number of lines between points, which have no surface.
    pub(super) lines: usize,
    /// Number of faces with missing vertices, ignored by the parser.
    pub(super) faces_out_of_range: usize,
    /// The places that it was seen from, where the file says so.
    pub(super) viewpoints: Vec<Point3<f64>>,
    pub(super) notes: Vec<String>,
}

impl Raw {
    /// Adds a polygon by the indices of its corners, which need not be there yet.
    pub(super) fn polygon(&mut self, corners: &[u32]) {
        let start = self.triangles.len();
        if let [first, rest @ ..] = corners {
            self.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        }
        match corners.len() {
            // A point, as which some programs write those of a cloud.
            0 | 1 | 3 => {}
            2 => self.lines += 1,
            _ => self.fans.push(start..self.triangles.len()),
        }
    }

    /// Decides between mesh and cloud, and ignores parts without a surface, with a note.
    pub(super) fn checked(mut self, name: String) -> Result<Shape, Fault> {
        if self.points.is_empty() {
            return Err(Fault::whole("it has no points; export the shape again"));
        }
        let lines = counted(self.lines, "line", "lines");
        if self.triangles.is_empty() && self.faces_out_of_range == 0 {
            if self.lines > 0 && self.points.len() < SPARSE {
                let problem = format!(
                    "it has no faces, only {lines}, and therefore no surface; export the shape with faces \
                     or as a point cloud"
                );
                return Err(Fault::whole(problem));
            } else if self.lines > 0 {
                self.notes
                    .push(format!("it has no faces, only {lines}; its vertices were read as a point cloud"));
            }
            return self.into_cloud(name);
        }
        if self.lines > 0 {
            self.notes.push(format!("ignored {lines} next to the surfaces"));
        }
        let faces = polygon::cut(std::mem::take(&mut self.triangles), &self.fans, &self.points);
        let mesh = TriMesh { vertices: std::mem::take(&mut self.points), faces };
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
            (self.faces_out_of_range, "with missing vertices"),
            (not_finite, "with a non-finite coordinate"),
            (flat, "with zero area"),
        ] {
            if n > 0 {
                self.notes.push(format!("ignored {} {why}", counted(n, "face", "faces")));
            }
        }
        if faces.is_empty() {
            self.notes.push("all faces have zero area; the vertices were read as a point cloud".to_owned());
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
            viewpoints: self.viewpoints,
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
            self.notes.push(format!("{points} a non-finite coordinate and will remain unlabelled"));
        }
        let geometry = ShapeGeometry::Cloud(PointCloud { points: self.points });
        Ok(Shape {
            name,
            path: None,
            content: None,
            geometry,
            attributes: self.attributes,
            viewpoints: self.viewpoints,
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
