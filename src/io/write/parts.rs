//! A mesh in parts, each belonging to one primitive or to none. Mesh files are written from this.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::atomic::unfit;
use super::options::ExportOptions;
use super::outcome::Outcome;
use super::text::{file_label, mean_place, rounding};
use super::writing::Writing;
use crate::geometry::mesh::bounds;
use crate::geometry::palette::UNASSIGNED_COLOR;
use crate::geometry::segmentation::{face_labels, split_at_boundaries};
use crate::geometry::tessellate::{Resolution, Surface, tessellate};
use crate::geometry::{Superquadric, TriMesh};
use crate::inference::UNASSIGNED;
use crate::io::error::WriteError;
use crate::io::primitives::{PrimitiveSet, checked};
use crate::io::shape::ShapeGeometry;

/// A mesh farther from the origin than this many times its size is written
/// about its own centre where a format has single precision only.
const FAR: f64 = 16.0;
/// Vertices of a primitive nearer than this, in semi-axes, are one. In single
/// precision, and to readers of STL, they would be the same.
const WELD: f64 = 1e-6;

/// A format of meshes in parts.
#[derive(Clone, Copy)]
pub(super) struct PartsFormat {
    pub(super) write: fn(&mut Writing, &Path, &Parts, &ExportOptions) -> Result<(), WriteError>,
    /// About how many bytes that is.
    pub(super) size: fn(&PartsCounts, &ExportOptions) -> u64,
    /// The file beside it that it refers to.
    pub(super) beside: fn(&Path, &ExportOptions) -> Option<PathBuf>,
}

/// What the size of a mesh's file depends on.
#[derive(Debug)]
pub(super) struct PartsCounts {
    pub(super) vertices: u64,
    pub(super) faces: u64,
    pub(super) primitives: u64,
    /// Characters of a place, and of the number of a vertex.
    pub(super) place: u64,
    pub(super) digits: u64,
    /// 1 where vertices have normals, faces colours; else 0.
    pub(super) normals: u64,
    pub(super) colors: u64,
}

impl PartsCounts {
    /// Of the input's mesh.
    pub(super) fn of_mesh(outcome: &Outcome<'_>, options: &ExportOptions) -> Self {
        let (vertices, faces) = match &outcome.shape.geometry {
            ShapeGeometry::Mesh(mesh) => (&mesh.vertices, mesh.faces.len() as u64),
            ShapeGeometry::Cloud(input) => (&input.points, 0),
        };
        // How much cutting adds depends on the boundaries.
        let samples = if options.split_boundaries { outcome.cloud.points.len() as u64 } else { 0 };
        let place = mean_place(vertices);
        Self::new(vertices.len() as u64 + 8 * samples, faces + 16 * samples, (place, 0), outcome, options)
    }

    /// Of the surfaces of the primitives.
    pub(super) fn of_surfaces(outcome: &Outcome<'_>, options: &ExportOptions) -> Self {
        let primitives = outcome.abstraction.primitives.len() as u64;
        let surface = options.surface();
        let (vertices, faces) = (surface.vertices() as u64, surface.faces_len() as u64);
        Self::new(primitives * vertices, primitives * faces, (57, 1), outcome, options)
    }

    fn new(
        vertices: u64,
        faces: u64,
        (place, normals): (u64, u64),
        outcome: &Outcome<'_>,
        options: &ExportOptions,
    ) -> Self {
        Self {
            vertices,
            faces,
            primitives: outcome.abstraction.primitives.len() as u64,
            place,
            digits: 1 + u64::from(vertices.max(1).ilog10()),
            normals,
            colors: options.colors.into(),
        }
    }
}

/// What there is to say of a part.
#[derive(Debug, Clone)]
pub(super) struct Part {
    /// The id of its primitive; −1 if unassigned.
    pub(super) label: i32,
    /// `primitive-ID` or `unassigned`.
    pub(super) name: String,
    pub(super) color: [u8; 3],
    /// World from local, for formats that place their parts.
    pub(super) frame: Isometry3<f64>,
}

/// A mesh with a part a face.
#[derive(Debug, Clone, Default)]
pub(super) struct Parts {
    pub(super) vertices: Vec<Point3<f64>>,
    /// Outward unit normals, one a vertex, where they are known.
    pub(super) normals: Option<Vec<Vector3<f64>>>,
    pub(super) faces: Vec<[u32; 3]>,
    /// For each face its place in `parts`.
    pub(super) part_of_face: Vec<u32>,
    pub(super) parts: Vec<Part>,
}

fn name_of(label: i32) -> String {
    if label < 0 { "unassigned".to_owned() } else { format!("primitive-{label}") }
}

impl Parts {
    /// The input mesh, its faces in their order (unless they are cut) and
    /// labelled by the samples next to them. Parts are in the order of their
    /// The input mesh with its faces in order (unless they are cut), labelled by
    /// the nearest samples. Parts are sorted by id; unassigned faces come last.
    pub(super) fn of_mesh(
        mesh: &TriMesh,
        outcome: &Outcome<'_>,
        options: &ExportOptions,
    ) -> io::Result<Self> {
        let (cloud, labels) = (outcome.cloud, &outcome.abstraction.labels);
        if cloud.points.len() != labels.len() {
            return Err(unfit("the labels belong to a different cloud"));
        }
        let (mesh, labels) = if options.split_boundaries {
            split_at_boundaries(mesh, cloud, labels)
        } else {
            (mesh.clone(), face_labels(mesh, cloud, labels))
        };
        // UNASSIGNED is the largest number, so it comes last.
        let found: BTreeSet<u32> = labels.iter().copied().collect();
        let place: BTreeMap<u32, u32> = found.iter().copied().zip(0..).collect();
        let frame = about_center(&mesh.vertices);
        let part = |&id: &u32| {
            let (label, color) = match id {
                UNASSIGNED => (-1, UNASSIGNED_COLOR),
                _ => (file_label(id)?, outcome.colors.of(id)),
            };
            Ok(Part { label, name: name_of(label), color, frame })
        };
        Ok(Self {
            parts: found.iter().map(part).collect::<io::Result<_>>()?,
            part_of_face: labels.iter().map(|label| place[label]).collect(),
            vertices: mesh.vertices,
            normals: None,
            faces: mesh.faces,
        })
    }

    /// The surfaces of primitives: closed, their faces counter-clockwise from
    /// outside.
    pub(super) fn of_primitives(set: &PrimitiveSet<'_>, resolution: Resolution) -> io::Result<Self> {
        let mut all = Self { normals: Some(Vec::new()), ..Self::default() };
        for primitive in set.primitives {
            let shape = checked(primitive)?.shape;
            let surface = closed(&shape, resolution);
            let (first, place) = (all.vertices.len() as u32, all.parts.len() as u32);
            all.part_of_face.extend(surface.faces.iter().map(|_| place));
            all.faces.extend(surface.faces.iter().map(|face| face.map(|i| first + i)));
            all.vertices.extend(surface.vertices);
            if let Some(normals) = &mut all.normals {
                normals.extend(surface.normals);
            }
            let label = file_label(primitive.id)?;
            let frame = Isometry3::from_parts(
                Translation3::from(shape.translation),
                UnitQuaternion::from_rotation_matrix(&shape.rotation),
            );
            all.parts.push(Part { label, name: name_of(label), color: set.colors.of(primitive.id), frame });
        }
        Ok(all)
    }

    /// The faces of each part.
    pub(super) fn by_part(&self) -> Vec<Vec<[u32; 3]>> {
        let mut faces = vec![Vec::new(); self.parts.len()];
        for (face, &part) in self.faces.iter().zip(&self.part_of_face) {
            faces[part as usize].push(*face);
        }
        faces
    }

    pub(super) fn part(&self, face: usize) -> &Part {
        &self.parts[self.part_of_face[face] as usize]
    }

    /// Rejects values out of range for single precision, and notes where it is coarse.
    pub(super) fn single_precision(&self) -> io::Result<Option<String>> {
        rounding(self.vertices.iter())
    }
}

/// A frame about the middle of the points where they are far from the origin.
fn about_center(points: &[Point3<f64>]) -> Isometry3<f64> {
    let finite = points.iter().copied().filter(|p| p.iter().all(|c| c.is_finite()));
    match bounds(finite) {
        Some((lo, hi)) if lo.coords.amax().max(hi.coords.amax()) > FAR * (hi - lo).amax() => {
            Isometry3::from_parts(
                Translation3::from(nalgebra::center(&lo, &hi).coords),
                UnitQuaternion::identity(),
            )
        }
        _ => Isometry3::identity(),
    }
}

/// The surface of a primitive, closed and without vertices that readers would
/// take for one: those nearer than [`WELD`] are one. Where a full taper makes a
/// cap a line or a point, the faces that have no area go, each with the one that
/// it lies on: every edge keeps its neighbour.
pub(super) fn closed(shape: &Superquadric, resolution: Resolution) -> Surface {
    let local = Superquadric { rotation: Rotation3::identity(), translation: Vector3::zeros(), ..*shape };
    let surface = tessellate(&local, resolution);
    let mut welder = Welder::default();
    let units = surface.vertices.iter().map(|p| p.coords.component_div(&shape.semi_axes));
    let index: Vec<u32> = units.map(|p| welder.place(p)).collect();
    // By their corners, however turned: two of opposite direction cancel out.
    let mut faces: Vec<Option<[u32; 3]>> = Vec::new();
    let mut standing: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    for face in &surface.faces {
        let [a, b, c] = face.map(|i| index[i as usize]);
        if a == b || b == c || c == a {
            continue;
        }
        let turned = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min();
        let (Some(key), Some(opposite)) = (turned([a, b, c]), turned([a, c, b])) else { continue };
        if let Some(other) = standing.get_mut(&opposite).and_then(Vec::pop) {
            faces[other] = None;
            continue;
        }
        standing.entry(key).or_default().push(faces.len());
        faces.push(Some([a, b, c]));
    }
    // The first vertex of each place stands for it.
    let mut first = vec![u32::MAX; welder.places.len()];
    for (&place, i) in index.iter().zip(0..) {
        let slot = &mut first[place as usize];
        *slot = (*slot).min(i);
    }
    let faces: Vec<_> =
        faces.into_iter().flatten().map(|face| face.map(|place| first[place as usize])).collect();
    let pose = |p: &Point3<f64>| Point3::from(shape.rotation * p.coords + shape.translation);
    let (index, used) = renumbered(&faces, surface.vertices.len());
    Surface {
        vertices: used.iter().map(|&i| pose(&surface.vertices[i as usize])).collect(),
        normals: used.iter().map(|&i| shape.rotation * surface.normals[i as usize]).collect(),
        faces: faces.iter().map(|face| face.map(|i| index[i as usize])).collect(),
    }
}

/// Places that are at least [`WELD`] apart along some axis.
#[derive(Default)]
struct Welder {
    places: Vec<Vector3<f64>>,
    /// The places in each cell of a grid of that size.
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl Welder {
    /// The index of the vertex at a point, added if new.
    fn place(&mut self, p: Vector3<f64>) -> u32 {
        let cell = <[i64; 3]>::from(p.map(|c| (c / WELD).floor() as i64));
        for step in 0..27 {
            let near = [0, 1, 2].map(|k| cell[k] + step / 3i64.pow(k as u32) % 3 - 1);
            let found = self.cells.get(&near).into_iter().flatten();
            for &place in found {
                if (self.places[place as usize] - p).amax() < WELD {
                    return place;
                }
            }
        }
        let place = self.places.len() as u32;
        self.places.push(p);
        self.cells.entry(cell).or_default().push(place);
        place
    }
}

/// New numbers for the vertices that faces have, in their order, and the old
/// numbers by the new.
pub(super) fn renumbered(faces: &[[u32; 3]], vertices: usize) -> (Vec<u32>, Vec<u32>) {
    let mut index = vec![u32::MAX; vertices];
    for &i in faces.iter().flatten() {
        index[i as usize] = 0;
    }
    let used: Vec<u32> = (0..vertices as u32).filter(|&i| index[i as usize] == 0).collect();
    for (new, &old) in used.iter().enumerate() {
        index[old as usize] = new as u32;
    }
    (index, used)
}

/// The mesh of an outcome's input.
pub(super) fn input_mesh<'a>(outcome: &Outcome<'a>) -> Option<&'a TriMesh> {
    match &outcome.shape.geometry {
        ShapeGeometry::Mesh(mesh) => Some(mesh),
        ShapeGeometry::Cloud(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::mesh::volume;

    #[test]
    fn surfaces_stay_closed_where_a_taper_collapses_their_caps() {
        for taper in [[0.0, 0.0], [-1.0, -1.0], [1.0, 0.0], [0.0, -1.0], [1.0, -1.0], [-1.0, 0.3]] {
            for eps in [[0.02, 0.02], [0.1, 1.0], [1.0, 1.0], [2.0, 0.1]] {
                let mut shape = Superquadric::sphere(Point3::origin(), 1.0);
                shape.exponents = eps;
                shape.taper = taper;
                let surface = closed(&shape, Resolution { profile: 8, section: 8 });
                let mut open: HashMap<(u32, u32), i32> = HashMap::new();
                for &[a, b, c] in &surface.faces {
                    for (from, to) in [(a, b), (b, c), (c, a)] {
                        *open.entry((from, to)).or_default() += 1;
                        *open.entry((to, from)).or_default() -= 1;
                    }
                }
                assert!(open.values().all(|&n| n == 0), "{eps:?} {taper:?}");
                let volume = volume(&surface.vertices, &surface.faces);
                assert!((volume / shape.volume() - 1.0).abs() < 0.05, "{eps:?} {taper:?}: {volume}");
            }
        }
    }

    #[test]
    fn what_is_far_off_is_written_about_its_centre() {
        let p = |x: f64| Point3::new(x, 0.0, 0.0);
        assert_eq!(about_center(&[p(1.0), p(2.0)]), Isometry3::identity());
        assert_eq!(about_center(&[p(1e6), p(1e6 + 2.0)]).translation.vector.x, 1e6 + 1.0);
    }
}
