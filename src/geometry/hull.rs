//! The convex hull of some points.
//!
//! Points are moved to a grid of whole numbers over their box first. There the
//! side of a plane that a point lies on is computed without rounding, so that
//! flat faces, rings of points that coincide and thin bodies do no harm: what
//! comes out is a closed surface, always.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use super::mesh::bounds;

/// Steps of the grid along each edge of the box. Differences take 22 bits,
/// determinants 68: within what 128 hold.
const STEPS: f64 = (1u64 << 21) as f64;

type Cell = Vector3<i128>;

/// Faces of the convex hull, counter-clockwise from outside, as indices into
/// `points`. It is closed, and convex to within 2⁻²¹ of the box; points within
/// a flat face are left out. `None` where all points lie in a plane, or one is
/// not finite.
pub fn convex_hull(points: &[Point3<f64>]) -> Option<Vec<[u32; 3]>> {
    let (lo, hi) = bounds(points.iter().copied())?;
    let size = hi - lo;
    if !size.iter().all(|s| s.is_finite() && *s > 0.0) {
        return None;
    }
    let cells: Vec<Cell> =
        points.iter().map(|p| (p - lo).component_div(&size).map(|t| (t * STEPS).round() as i128)).collect();
    let mut hull = Hull::new(&cells)?;
    for i in 0..cells.len() as u32 {
        hull.add(i);
    }
    Some(hull.faces)
}

struct Hull<'a> {
    cells: &'a [Cell],
    faces: Vec<[u32; 3]>,
}

impl<'a> Hull<'a> {
    /// A tetrahedron of four of the points, as large as can be had greedily.
    fn new(cells: &'a [Cell]) -> Option<Self> {
        let all = 0..cells.len();
        let a = cells.first()?;
        let square = |v: Cell| v.dot(&v);
        let b = all.clone().max_by_key(|&i| square(cells[i] - a))?;
        let ab = cells[b] - a;
        let c = all.clone().max_by_key(|&i| square(ab.cross(&(cells[i] - a))))?;
        let normal = ab.cross(&(cells[c] - a));
        let d = all.max_by_key(|&i| normal.dot(&(cells[i] - a)).abs())?;
        let height = normal.dot(&(cells[d] - a));
        if height == 0 {
            return None;
        }
        // The fourth point lies inside of the first face.
        let [a, b, c, d] = [0, b, c, d].map(|i| i as u32);
        let (b, c) = if height > 0 { (c, b) } else { (b, c) };
        Some(Self { cells, faces: vec![[a, b, c], [a, d, b], [b, d, c], [c, d, a]] })
    }

    fn sees(&self, p: &Cell, face: &[u32; 3]) -> bool {
        let [a, b, c] = face.map(|i| &self.cells[i as usize]);
        (b - a).cross(&(c - a)).dot(&(p - a)) > 0
    }

    /// Replaces the faces that a point lies outside of by those from their rim
    /// to the point.
    fn add(&mut self, point: u32) {
        let p = self.cells[point as usize];
        let is_seen: Vec<bool> = self.faces.iter().map(|face| self.sees(&p, face)).collect();
        if !is_seen.contains(&true) {
            return;
        }
        let mut owner = HashMap::new();
        for (k, face) in self.faces.iter().enumerate() {
            for (from, to) in edges(face) {
                owner.insert((from, to), k);
            }
        }
        let mut faces = Vec::with_capacity(self.faces.len() + 2);
        for (face, _) in self.faces.iter().zip(&is_seen).filter(|(_, seen)| !**seen) {
            faces.push(*face);
        }
        for (face, _) in self.faces.iter().zip(&is_seen).filter(|(_, seen)| **seen) {
            for (from, to) in edges(face) {
                if owner.get(&(to, from)).is_some_and(|&k| !is_seen[k]) {
                    faces.push([from, to, point]);
                }
            }
        }
        self.faces = faces;
    }
}

fn edges(&[a, b, c]: &[u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::geometry::Superquadric;
    use crate::geometry::mesh::volume;
    use crate::geometry::tessellate::{Resolution, tessellate};

    /// Closed, of one piece, and no point outside.
    fn check(points: &[Point3<f64>]) -> (f64, Vec<[u32; 3]>) {
        let faces = convex_hull(points).unwrap();
        let directed: HashSet<_> = faces.iter().flat_map(edges).collect();
        assert_eq!(directed.len(), 3 * faces.len(), "an edge is used twice");
        assert!(directed.iter().all(|&(a, b)| directed.contains(&(b, a))), "an edge is open");
        let used: HashSet<u32> = faces.iter().flatten().copied().collect();
        assert_eq!(used.len() + faces.len(), directed.len() / 2 + 2, "Euler's formula");
        let (lo, hi) = bounds(points.iter().copied()).unwrap();
        // On the grid, where it was decided: thin faces have no direction of
        // their own beyond it.
        let unit = |p: &Point3<f64>| (p - lo).component_div(&(hi - lo)).map(|t| (t * STEPS).round());
        for face in &faces {
            let [a, b, c] = face.map(|i| unit(&points[i as usize]));
            let normal = (b - a).cross(&(c - a)).normalize();
            let out = points.iter().map(|p| normal.dot(&(unit(p) - a))).fold(f64::MIN, f64::max);
            assert!(out < 1e-3, "a point lies {out} steps outside");
        }
        let units: Vec<Point3<f64>> = points.iter().map(|p| unit(p).into()).collect();
        (volume(&units, &faces) * (hi - lo).product() / STEPS.powi(3), faces)
    }

    #[test]
    fn a_box_with_points_on_and_in_it_has_twelve_faces() {
        let mut points = Vec::new();
        for x in 0..5 {
            for y in 0..5 {
                for z in 0..5 {
                    points.push(Point3::new(f64::from(x), 1e-4 * f64::from(y), 7.0 + f64::from(z)));
                }
            }
        }
        let (volume, faces) = check(&points);
        let corner = |i: u32| points[i as usize].iter().zip([4.0, 4e-4, 11.0]).all(|(c, hi)| *c == hi);
        assert!(faces.iter().flatten().any(|&i| corner(i)));
        assert!((volume - 16.0 * 4e-4).abs() < 1e-12);
        assert!(faces.len() < 100, "{}", faces.len());
    }

    #[test]
    fn hulls_of_primitives_hold_them_and_are_hardly_larger_where_they_are_convex() {
        for eps in [[0.1, 0.1], [0.1, 1.0], [1.0, 1.0], [2.0, 2.0], [1.5, 0.3], [3.5, 3.0]] {
            for taper in [[0.0, 0.0], [1.0, 1.0], [-1.0, 0.5], [0.3, 0.0]] {
                for thin in [1.0, 1e-5] {
                    let mut shape = Superquadric::sphere(Point3::origin(), 1.0);
                    shape.exponents = eps;
                    shape.semi_axes.y = thin;
                    shape.taper = taper;
                    let surface = tessellate(&shape, Resolution { profile: 8, section: 8 });
                    let (volume, _) = check(&surface.vertices);
                    let ratio = volume / shape.volume();
                    assert!(ratio > 0.9, "{eps:?} {taper:?}: {ratio}");
                    if eps[0].max(eps[1]) <= 2.0 && taper == [0.0; 2] {
                        assert!(ratio < 1.0 + 1e-5, "{eps:?}: {ratio}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_flat_has_no_hull() {
        let p = Point3::new;
        assert_eq!(convex_hull(&[]), None);
        assert_eq!(convex_hull(&[p(1.0, 2.0, 3.0); 9]), None);
        assert_eq!(
            convex_hull(&[p(0.0, 0.0, 0.0), p(1.0, 1.0, 1.0), p(1.0, 0.0, 1.0), p(2.0, 1.0, 2.0)]),
            None
        );
        assert_eq!(convex_hull(&[p(0.0, 0.0, 0.0), p(1.0, f64::NAN, 1.0)]), None);
    }
}
