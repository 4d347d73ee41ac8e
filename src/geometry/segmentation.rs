//! From labels of a cloud to labels of the faces of a mesh.

use std::collections::{HashMap, HashSet};

use nalgebra::Point3;
use rayon::prelude::*;

use super::neighbors::KdTree;
use super::{SampleCloud, TriMesh};

/// The label of a face that is nothing's: the same as that of a sample.
const NO_LABEL: u32 = u32::MAX;
/// Most pieces that an edge of a face is cut in to look at its labels.
const MOST_PIECES: usize = 24;
/// Neighbours that the spacing of the samples is measured by.
const SPACING_NEIGHBORS: usize = 5;
/// Faces are halved at most so often on the way to a boundary.
const MOST_ROUNDS: usize = 32;
/// Halvings of the way along an edge to where its label changes.
const BISECTIONS: usize = 24;
/// How near to its ends an edge is cut, as a part of its length: nearer, the
/// pieces would be too thin.
const NEAREST_CUT: f64 = 0.02;

/// The label of each face: that which most of its area has, each place taking
/// the label of the nearest sample. Of a tie the smallest. `labels` has one
/// entry a sample; `u32::MAX`, a sample without a label, counts as a label like
/// the others, and is that of faces that are not valid.
///
/// # Panics
/// Where there are fewer labels than samples.
pub fn face_labels(mesh: &TriMesh, cloud: &SampleCloud, labels: &[u32]) -> Vec<u32> {
    let field = Field::new(cloud, labels);
    mesh.faces
        .par_iter()
        .map_init(Vec::new, |found, face| {
            let Some(corners) = mesh.corners(face) else { return NO_LABEL };
            found.clear();
            field.look(&corners, found);
            found.sort_unstable();
            let most = found.chunk_by(|a, b| a == b).rev().max_by_key(|run| run.len());
            most.and_then(|run| run.first().copied()).unwrap_or(NO_LABEL)
        })
        .collect()
}

/// A mesh whose faces are cut where the label changes, and the label of each
/// face. All vertices of `mesh` are kept, in their order, and the surface is the
/// same; faces near a boundary are halved until their edges are about as long as
/// the samples are apart, then cut in two or three parts. Neighbours are cut at
/// the same points, so that what was closed stays closed, also where vertices
/// are given several times.
///
/// # Panics
/// Where there are fewer labels than samples.
pub fn split_at_boundaries(mesh: &TriMesh, cloud: &SampleCloud, labels: &[u32]) -> (TriMesh, Vec<u32>) {
    let field = Field::new(cloud, labels);
    let mut cut = Cutting::new(mesh);
    cut.refine(&field, 4 * mesh.faces.len() + 64 * cloud.points.len());
    cut.cut(&field)
}

/// The label of every place in space: that of the nearest sample.
struct Field<'a> {
    tree: KdTree,
    labels: &'a [u32],
    /// Distance of neighbouring samples.
    spacing: f64,
}

impl<'a> Field<'a> {
    fn new(cloud: &SampleCloud, labels: &'a [u32]) -> Self {
        let tree = KdTree::new(&cloud.points);
        let spacing = if tree.len() > 1 { tree.mean_spacing(SPACING_NEIGHBORS) } else { 0.0 };
        Self { tree, labels, spacing }
    }

    fn at(&self, p: &Point3<f64>) -> u32 {
        self.tree.nearest_one(p).map_or(NO_LABEL, |(_, i)| self.labels[i as usize])
    }

    /// Labels of places that are spread evenly over a triangle, two a spacing:
    /// the centres of the pieces that it falls in when each edge is cut evenly.
    fn look(&self, [a, b, c]: &[Point3<f64>; 3], found: &mut Vec<u32>) {
        let longest = [b - a, c - b, a - c].iter().map(|e| e.norm()).fold(0.0, f64::max);
        let pieces = (2.0 * longest / self.spacing).ceil();
        let n = if pieces >= 1.0 { pieces.min(MOST_PIECES as f64) as usize } else { 1 };
        let mut at = |u: f64, v: f64| {
            let place = a + ((b - a) * u + (c - a) * v) / (3 * n) as f64;
            found.push(self.at(&place));
        };
        for i in 0..n {
            for j in 0..n - i {
                let (u, v) = ((3 * i) as f64, (3 * j) as f64);
                at(u + 1.0, v + 1.0);
                if i + j + 1 < n {
                    at(u + 2.0, v + 2.0);
                }
            }
        }
    }

    fn is_mixed(&self, corners: &[Point3<f64>; 3]) -> bool {
        let mut found: Vec<u32> = corners.iter().map(|p| self.at(p)).collect();
        self.look(corners, &mut found);
        found.iter().any(|&label| label != found[0])
    }
}

/// A face on its way through the cuts.
#[derive(Debug, Clone, Copy)]
struct Face {
    corners: [u32; 3],
    /// Whether it has several labels; `None` where nobody has looked.
    is_mixed: Option<bool>,
}

/// A mesh that is being cut.
struct Cutting {
    vertices: Vec<Point3<f64>>,
    /// For each vertex the first at the same place.
    first_at: Vec<u32>,
    faces: Vec<Face>,
}

/// An edge by its two places, the smaller first.
type Edge = (u32, u32);

impl Cutting {
    fn new(mesh: &TriMesh) -> Self {
        let mut places = HashMap::new();
        // 0 and −0 are one place.
        let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
        let first_at =
            mesh.vertices.iter().zip(0u32..).map(|(p, i)| *places.entry(key(p)).or_insert(i)).collect();
        // Faces that are not valid go through as they are.
        let face = |corners: &[u32; 3]| Face {
            corners: *corners,
            is_mixed: mesh.corners(corners).is_none().then_some(false),
        };
        let faces = mesh.faces.iter().map(face).collect();
        Self { vertices: mesh.vertices.clone(), first_at, faces }
    }

    fn is_valid(&self, face: &Face) -> bool {
        face.corners
            .iter()
            .all(|&i| self.vertices.get(i as usize).is_some_and(|p| p.iter().all(|c| c.is_finite())))
    }

    fn places(&self, face: &Face) -> [Point3<f64>; 3] {
        face.corners.map(|i| self.vertices[i as usize])
    }

    /// The three edges, from corner k to corner k + 1.
    fn edges(&self, face: &Face) -> [Edge; 3] {
        let at = face.corners.map(|i| self.first_at[i as usize]);
        [0, 1, 2].map(|k| {
            let (a, b) = (at[k], at[(k + 1) % 3]);
            (a.min(b), a.max(b))
        })
    }

    fn push(&mut self, p: Point3<f64>) -> u32 {
        let index = self.vertices.len() as u32;
        self.vertices.push(p);
        self.first_at.push(index);
        index
    }

    /// Halves the long edges of faces with several labels, and with them their
    /// neighbours, until there are none or the faces are too many.
    fn refine(&mut self, field: &Field<'_>, most_faces: usize) {
        for _ in 0..MOST_ROUNDS {
            let mixed: Vec<Option<bool>> = self
                .faces
                .par_iter()
                .map(|face| Some(face.is_mixed.unwrap_or_else(|| field.is_mixed(&self.places(face)))))
                .collect();
            for (face, mixed) in self.faces.iter_mut().zip(mixed) {
                face.is_mixed = mixed;
            }
            let long = |&(a, b): &Edge| {
                (self.vertices[a as usize] - self.vertices[b as usize]).norm() > field.spacing
            };
            let halved: HashSet<Edge> = self
                .faces
                .iter()
                .filter(|face| face.is_mixed == Some(true))
                .flat_map(|face| self.edges(face))
                .filter(long)
                .collect();
            if halved.is_empty() || self.faces.len() + 3 * halved.len() > most_faces {
                return;
            }
            self.halve(&halved);
        }
    }

    fn halve(&mut self, halved: &HashSet<Edge>) {
        let mut middles: HashMap<Edge, u32> = HashMap::new();
        let mut faces = Vec::with_capacity(self.faces.len() + 3 * halved.len());
        for face in std::mem::take(&mut self.faces) {
            let edges = if self.is_valid(&face) { self.edges(&face).map(Some) } else { [None; 3] };
            let mut middle = [None; 3];
            for (k, edge) in edges.into_iter().enumerate() {
                let Some(edge) = edge.filter(|edge| halved.contains(edge)) else { continue };
                let known = middles.get(&edge).copied();
                middle[k] = Some(known.unwrap_or_else(|| {
                    let [a, b] = [edge.0, edge.1].map(|i| self.vertices[i as usize]);
                    let index = self.push(nalgebra::center(&a, &b));
                    middles.insert(edge, index);
                    index
                }));
            }
            // What has one label all over has it in each part.
            let is_mixed = face.is_mixed.filter(|mixed| !mixed);
            let parts = halves(face.corners, middle);
            faces.extend(parts.into_iter().map(|corners| Face { corners, is_mixed }));
        }
        self.faces = faces;
    }

    /// Cuts each face whose corners have several labels.
    fn cut(mut self, field: &Field<'_>) -> (TriMesh, Vec<u32>) {
        let labels: Vec<u32> = self.vertices.par_iter().map(|p| field.at(p)).collect();
        let mut cuts: HashMap<Edge, u32> = HashMap::new();
        let (mut faces, mut face_labels) = (Vec::new(), Vec::new());
        for face in std::mem::take(&mut self.faces) {
            if !self.is_valid(&face) {
                faces.push(face.corners);
                face_labels.push(NO_LABEL);
                continue;
            }
            let label = face.corners.map(|i| labels[i as usize]);
            let edges = self.edges(&face);
            let mut cut = [None; 3];
            for k in 0..3 {
                if label[k] == label[(k + 1) % 3] {
                    continue;
                }
                let known = cuts.get(&edges[k]).copied();
                cut[k] = Some(known.unwrap_or_else(|| {
                    let index = self.push(self.crossing(field, edges[k], &labels));
                    cuts.insert(edges[k], index);
                    index
                }));
            }
            let [a, b, c] = face.corners;
            if let [Some(ab), Some(bc), Some(ca)] = cut {
                let [p, q, r] = self.places(&face);
                let m = self.push(Point3::from((p.coords + q.coords + r.coords) / 3.0));
                for (k, part) in
                    [[[a, ab, m], [a, m, ca]], [[b, bc, m], [b, m, ab]], [[c, ca, m], [c, m, bc]]]
                        .iter()
                        .enumerate()
                {
                    faces.extend(part);
                    face_labels.extend([label[k]; 2]);
                }
                continue;
            }
            // The corner between the two edges that are cut, if any are.
            let Some(k) = (0..3).find(|&k| cut[k].is_some() && cut[(k + 2) % 3].is_some()) else {
                faces.push(face.corners);
                face_labels.push(label[0]);
                continue;
            };
            let turned = [0, 1, 2].map(|i| face.corners[(k + i) % 3]);
            let (next, last) = (cut[k].unwrap_or(turned[1]), cut[(k + 2) % 3].unwrap_or(turned[2]));
            let rest = label[(k + 1) % 3];
            faces.extend([[turned[0], next, last], [next, turned[1], turned[2]], [next, turned[2], last]]);
            face_labels.extend([label[k], rest, rest]);
        }
        (TriMesh { vertices: self.vertices, faces }, face_labels)
    }

    /// Where along an edge the label of its first end stops.
    fn crossing(&self, field: &Field<'_>, (from, to): Edge, labels: &[u32]) -> Point3<f64> {
        let [a, b] = [from, to].map(|i| self.vertices[i as usize]);
        let own = labels[from as usize];
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if field.at(&(a + (b - a) * middle)) == own {
                low = middle;
            } else {
                high = middle;
            }
        }
        a + (b - a) * low.clamp(NEAREST_CUT, 1.0 - NEAREST_CUT)
    }
}

/// The parts of a triangle some of whose edges have a middle; edge k leads from
/// corner k to corner k + 1.
fn halves([a, b, c]: [u32; 3], middle: [Option<u32>; 3]) -> Vec<[u32; 3]> {
    match middle {
        [None, None, None] => vec![[a, b, c]],
        [Some(ab), None, None] => vec![[a, ab, c], [ab, b, c]],
        [Some(ab), Some(bc), None] => vec![[b, bc, ab], [a, ab, bc], [a, bc, c]],
        [Some(ab), Some(bc), Some(ca)] => vec![[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]],
        // The others are these, turned.
        [None, _, _] => halves([b, c, a], [middle[1], middle[2], middle[0]]),
        [Some(_), None, Some(_)] => halves([c, a, b], [middle[2], middle[0], middle[1]]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surface of the box from −1 to 1, each edge cut in `n`; as many
    /// vertices a face as it has corners where `is_shared` is off.
    fn cube(n: i32, is_shared: bool) -> TriMesh {
        let mut mesh = TriMesh::default();
        let mut index = HashMap::new();
        for axis in 0..3 {
            for side in [-1, 1] {
                let mut at = |u: i32, v: i32| {
                    let mut key = [0; 3];
                    key[axis] = side * n;
                    key[(axis + 1) % 3] = side * (2 * u - n);
                    key[(axis + 2) % 3] = 2 * v - n;
                    let p = Point3::from(key.map(|k| f64::from(k) / f64::from(n)));
                    let next = mesh.vertices.len() as u32;
                    let found = if is_shared { *index.entry(key).or_insert(next) } else { next };
                    if found == next {
                        mesh.vertices.push(p);
                    }
                    found
                };
                for u in 0..n {
                    for v in 0..n {
                        let [a, b, c, d] = [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)];
                        mesh.faces.extend([[a, b, c], [a, c, d]]);
                    }
                }
            }
        }
        mesh
    }

    /// Samples on the box, labelled by a ball around a corner and a half space.
    fn samples() -> (SampleCloud, Vec<u32>) {
        let mut points = Vec::new();
        let fine = cube(24, true);
        for face in &fine.faces {
            let [a, b, c] = fine.corners(face).unwrap();
            points.push(Point3::from((a.coords + b.coords + c.coords) / 3.0));
        }
        let label = |p: &Point3<f64>| match () {
            () if (p - Point3::new(1.0, 1.0, 1.0)).norm() < 0.7 => 7,
            () if p.x + 0.3 * p.y < 0.1 => 3,
            () => u32::MAX,
        };
        let labels = points.iter().map(label).collect();
        let cloud =
            SampleCloud { points, sample_of_input: None, part: Default::default(), viewpoints: Vec::new() };
        (cloud, labels)
    }

    fn area(mesh: &TriMesh, of: impl Fn(usize) -> bool) -> f64 {
        let one = |face| {
            let [a, b, c] = mesh.corners(face).unwrap();
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        mesh.faces.iter().enumerate().filter(|(i, _)| of(*i)).map(|(_, face)| one(face)).sum()
    }

    #[test]
    fn faces_take_the_label_of_most_of_their_area() {
        let (cloud, labels) = samples();
        let mesh = cube(12, true);
        let found = face_labels(&mesh, &cloud, &labels);
        let field = Field::new(&cloud, &labels);
        for (face, &label) in mesh.faces.iter().zip(&found) {
            let corners = mesh.corners(face).unwrap();
            let mut all = Vec::new();
            field.look(&corners, &mut all);
            let of = |l: u32| all.iter().filter(|&&x| x == l).count();
            assert!(all.iter().all(|&l| of(l) <= of(label)));
        }
        assert!([3, 7, u32::MAX].iter().all(|l| found.contains(l)));
        // Two large faces a side: each is mostly of one label.
        let coarse = face_labels(&cube(1, true), &cloud, &labels);
        assert_eq!(coarse.iter().filter(|&&l| l == 7).count(), 0);
        let broken = TriMesh { faces: vec![[0, 1, 99_999]], ..mesh };
        assert_eq!(face_labels(&broken, &cloud, &labels), [u32::MAX]);
    }

    #[test]
    fn cutting_keeps_the_surface_and_closes_every_edge() {
        let (cloud, labels) = samples();
        for (n, is_shared) in [(1, true), (1, false), (3, true), (7, false)] {
            let mesh = cube(n, is_shared);
            let (split, found) = split_at_boundaries(&mesh, &cloud, &labels);
            assert_eq!(split.faces.len(), found.len());
            assert_eq!(split.vertices[..mesh.vertices.len()], mesh.vertices[..]);
            assert!((area(&split, |_| true) - 24.0).abs() < 24.0 * 1e-9);
            // Every directed edge meets its opposite: by place, since vertices
            // may be there several times.
            let place = |i: u32| split.vertices[i as usize].coords.map(|c| (c + 0.0).to_bits());
            let mut open: HashMap<_, i32> = HashMap::new();
            for &[a, b, c] in &split.faces {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *open.entry((place(from), place(to))).or_default() += 1;
                    *open.entry((place(to), place(from))).or_default() -= 1;
                }
            }
            assert!(open.values().all(|&n| n == 0), "an edge is open");
            // The half space and the ball's three quarter discs, to within a
            // fraction of the spacing times the boundary's length.
            let of = |label: u32| area(&split, |i| found[i] == label);
            let quarter = 3.0 * std::f64::consts::PI * 0.49 / 4.0;
            assert!((of(7) - quarter).abs() < 0.12, "{} {quarter}", of(7));
            assert!((of(3) - 12.8).abs() < 0.25, "{}", of(3));
            // And no face lies far on the wrong side.
            for (face, &label) in split.faces.iter().zip(&found) {
                let [a, b, c] = split.corners(face).unwrap();
                let p = Point3::from((a.coords + b.coords + c.coords) / 3.0);
                if label == 3 {
                    assert!(p.x + 0.3 * p.y < 0.3, "{p}");
                }
            }
        }
    }

    #[test]
    fn a_mesh_of_one_label_is_left_alone() {
        let (cloud, _) = samples();
        let mesh = cube(2, true);
        let labels = vec![5; cloud.points.len()];
        let (split, found) = split_at_boundaries(&mesh, &cloud, &labels);
        assert_eq!(split, mesh);
        assert!(found.iter().all(|&l| l == 5));
        let none = SampleCloud {
            points: Vec::new(),
            sample_of_input: None,
            part: Default::default(),
            viewpoints: Vec::new(),
        };
        assert_eq!(face_labels(&mesh, &none, &[]), vec![u32::MAX; mesh.faces.len()]);
        assert_eq!(split_at_boundaries(&mesh, &none, &[]).0, mesh);
    }

    #[test]
    fn every_way_of_halving_covers_the_triangle() {
        let at = |i: u32| match i {
            0 => (0.0, 0.0),
            1 => (1.0, 0.0),
            2 => (0.0, 1.0),
            3 => (0.5, 0.0),
            4 => (0.5, 0.5),
            _ => (0.0, 0.5),
        };
        for mask in 0..8 {
            let middle = [0, 1, 2].map(|k| (mask >> k & 1 == 1).then_some(3 + k));
            let parts = halves([0, 1, 2], middle);
            assert_eq!(parts.len() as u32, 1 + u32::count_ones(mask));
            let mut sum = 0.0;
            for part in parts {
                let [(ax, ay), (bx, by), (cx, cy)] = part.map(at);
                let doubled: f64 = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
                assert!(doubled > 0.0);
                sum += doubled;
            }
            assert_eq!(sum, 1.0);
        }
    }
}
