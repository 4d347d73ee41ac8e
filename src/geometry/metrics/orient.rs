//! Which way is out: patches of a mesh turned so that they face outward.
//!
//! The winding number needs faces that agree on their outside. Within a patch
//! (faces joined by edges that have exactly two) they are made to agree;
//! between patches rays decide, as Takayama, Jacobson, Kavan and
//! Sorkine-Hornung (2014) propose: the outer side is the one from which more
//! rays get away or, where neither side's do more often, get farther.

use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::triangles::{Triangles, area, random_point, running_sum};

/// Rays for all patches together, and the least number for each.
const RAYS: usize = 20_000;
const RAYS_PER_PATCH: usize = 32;
/// Rays that share a random stream.
const CHUNK: usize = 256;

/// What is known of a mesh's edges.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct EdgeCount {
    pub(super) edges: usize,
    /// Edges of one face only.
    pub(super) boundary: usize,
    /// Edges of more than two faces.
    pub(super) branching: usize,
}

/// Patches of a mesh and how their faces lie.
#[derive(Debug)]
pub(super) struct Patches {
    pub(super) edges: EdgeCount,
    /// For each face its patch, and whether it disagrees with the patch's
    /// first face.
    patch: Vec<u32>,
    turned: Vec<bool>,
    count: usize,
    /// Every edge runs once in each direction.
    closed: bool,
}

impl Patches {
    /// Finds the patches of a mesh without degenerate faces.
    pub(super) fn new(faces: &[[u32; 3]]) -> Self {
        // (ends in order, face, whether the face runs from the larger end)
        let mut sides: Vec<([u32; 2], u32, bool)> = Vec::with_capacity(3 * faces.len());
        for (face, i) in faces.iter().zip(0u32..) {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], i, a > b));
            }
        }
        sides.par_sort_unstable();
        let mut edges = EdgeCount::default();
        let mut closed = true;
        // Pairs of faces across an edge, and whether they agree.
        let mut joints: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * faces.len());
        for edge in sides.chunk_by(|a, b| a.0 == b.0) {
            edges.edges += 1;
            match edge {
                [_] => edges.boundary += 1,
                [one, other] => {
                    let agree = one.2 != other.2;
                    closed &= agree;
                    joints.extend([(one.1, other.1, agree), (other.1, one.1, agree)]);
                }
                _ => edges.branching += 1,
            }
        }
        closed &= edges.boundary + edges.branching == 0;
        joints.sort_unstable();

        const NONE: u32 = u32::MAX;
        let mut patch = vec![NONE; faces.len()];
        let mut turned = vec![false; faces.len()];
        let mut count = 0;
        let mut stack = Vec::new();
        for start in 0..faces.len() {
            if patch[start] != NONE {
                continue;
            }
            patch[start] = count as u32;
            stack.push(start as u32);
            while let Some(face) = stack.pop() {
                let from = joints.partition_point(|j| j.0 < face);
                for &(_, next, agree) in joints[from..].iter().take_while(|j| j.0 == face) {
                    if patch[next as usize] == NONE {
                        patch[next as usize] = count as u32;
                        turned[next as usize] = turned[face as usize] == agree;
                        stack.push(next);
                    }
                }
            }
            count += 1;
        }
        Self { edges, patch, turned, count, closed }
    }

    /// Whether the mesh is closed, its faces agree and every patch holds a
    /// positive volume: then it is right as it is.
    fn is_outward(&self, triangles: &[[Point3<f64>; 3]]) -> bool {
        if !self.closed {
            return false;
        }
        let mut volume = vec![0.0; self.count];
        for ([a, b, c], &patch) in triangles.iter().zip(&self.patch) {
            volume[patch as usize] += a.coords.dot(&b.coords.cross(&c.coords));
        }
        volume.iter().all(|v| *v > 0.0)
    }

    /// Which faces are to be turned over. `tree` holds `triangles`, the mesh's
    /// faces in order.
    pub(super) fn flips(&self, triangles: &[[Point3<f64>; 3]], tree: &Triangles, seed: u64) -> Vec<bool> {
        if self.is_outward(triangles) {
            return vec![false; triangles.len()];
        }
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        order.sort_by_key(|&face| self.patch[face as usize]);
        let total: f64 = triangles.iter().map(area).sum();
        let members: Vec<&[u32]> =
            order.chunk_by(|a, b| self.patch[*a as usize] == self.patch[*b as usize]).collect();
        let inward: Vec<bool> = members
            .par_iter()
            .enumerate()
            .map(|(k, faces)| {
                let area_up_to = running_sum(faces.iter().map(|&f| area(&triangles[f as usize])));
                let sum = area_up_to[faces.len() - 1];
                let rays = ((RAYS as f64 * sum / total) as usize).max(RAYS_PER_PATCH);
                let chunks: Vec<Vote> = (0..rays.div_ceil(CHUNK))
                    .into_par_iter()
                    .map(|chunk| {
                        let mut rng = ChaCha8Rng::seed_from_u64(seed);
                        rng.set_stream((k as u64) << 32 | chunk as u64);
                        let mut vote = Vote::default();
                        for _ in 0..CHUNK.min(rays - chunk * CHUNK) {
                            let at = rng.random::<f64>() * sum;
                            let face = faces[area_up_to.partition_point(|&a| a <= at).min(faces.len() - 1)];
                            let turned = self.turned[face as usize];
                            vote.cast(&triangles[face as usize], turned, face, tree, &mut rng);
                        }
                        vote
                    })
                    .collect();
                chunks.iter().fold(Vote::default(), |a, b| a.with(b)).is_inward()
            })
            .collect();
        self.turned
            .iter()
            .zip(&self.patch)
            .map(|(turned, &patch)| *turned != inward[patch as usize])
            .collect()
    }
}

/// How rays from the two sides of a patch fared: (front, back).
#[derive(Debug, Clone, Copy, Default)]
struct Vote {
    away: (u32, u32),
    /// Sum of the lengths of those that met something.
    way: (f64, f64),
}

impl Vote {
    fn cast(
        &mut self,
        corners: &[Point3<f64>; 3],
        turned: bool,
        face: u32,
        tree: &Triangles,
        rng: &mut ChaCha8Rng,
    ) {
        let origin = random_point(corners, rng);
        // Even over the sphere.
        let (z, turn) = (2.0 * rng.random::<f64>() - 1.0, std::f64::consts::TAU * rng.random::<f64>());
        let flat = (1.0 - z * z).max(0.0).sqrt();
        let direction = Vector3::new(flat * turn.cos(), flat * turn.sin(), z);
        let [a, b, c] = corners;
        let ahead = (b - a).cross(&(c - a)).dot(&direction) >= 0.0;
        let front = if ahead != turned { direction } else { -direction };
        match tree.first_hit(&origin, &front, face) {
            None => self.away.0 += 1,
            Some(way) => self.way.0 += way,
        }
        match tree.first_hit(&origin, &-front, face) {
            None => self.away.1 += 1,
            Some(way) => self.way.1 += way,
        }
    }

    fn with(self, other: &Self) -> Self {
        Self {
            away: (self.away.0 + other.away.0, self.away.1 + other.away.1),
            way: (self.way.0 + other.way.0, self.way.1 + other.way.1),
        }
    }

    fn is_inward(&self) -> bool {
        self.away.0 < self.away.1 || (self.away.0 == self.away.1 && self.way.0 < self.way.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Superquadric;
    use crate::geometry::tessellate::{Resolution, tessellate};

    /// Two spheres apart, as one mesh.
    fn two_spheres() -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let resolution = Resolution { profile: 6, section: 6 };
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for x in [0.0, 3.0] {
            let surface = tessellate(&Superquadric::sphere(Point3::new(x, 0.0, 0.0), 1.0), resolution);
            let offset = vertices.len() as u32;
            vertices.extend(surface.vertices);
            faces.extend(surface.faces.iter().map(|f| f.map(|i| i + offset)));
        }
        (vertices, faces)
    }

    fn flips(vertices: &[Point3<f64>], faces: &[[u32; 3]]) -> Vec<bool> {
        let triangles: Vec<_> = faces.iter().map(|f| f.map(|i| vertices[i as usize])).collect();
        Patches::new(faces).flips(&triangles, &Triangles::new(&triangles), 1)
    }

    #[test]
    fn faces_that_were_turned_over_are_turned_back() {
        let (vertices, faces) = two_spheres();
        assert!(flips(&vertices, &faces).iter().all(|f| !f));
        // One sphere inside out, the other ragged.
        let half = faces.len() / 2;
        let wrong: Vec<bool> = (0..faces.len()).map(|i| i < half || i % 3 == 0).collect();
        let mixed: Vec<[u32; 3]> =
            faces.iter().zip(&wrong).map(|(&[a, b, c], w)| if *w { [a, c, b] } else { [a, b, c] }).collect();
        assert_eq!(flips(&vertices, &mixed), wrong);
    }

    #[test]
    fn an_open_bowl_faces_out_of_its_mouth_or_not_but_agrees() {
        let (vertices, faces) = two_spheres();
        let bowl: Vec<[u32; 3]> =
            faces.iter().filter(|f| f.iter().all(|&i| vertices[i as usize].z < 0.5)).copied().collect();
        let patches = Patches::new(&bowl);
        assert!(patches.edges.boundary > 0 && patches.edges.branching == 0 && patches.count == 2);
        // More rays get away from the outside.
        assert!(flips(&vertices, &bowl).iter().all(|f| !f));
    }
}
