//! Triangle meshes.

use std::fmt;

use nalgebra::Point3;

use super::brief::Brief;

/// A triangle mesh in input units. Faces index `vertices`.
#[derive(Clone, Default, PartialEq)]
pub struct TriMesh {
    pub vertices: Vec<Point3<f64>>,
    pub faces: Vec<[u32; 3]>,
}

impl fmt::Debug for TriMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TriMesh")
            .field("vertices", &Brief::of_points(&self.vertices))
            .field("faces", &Brief::of(&self.faces))
            .finish()
    }
}

/// Its corners.
pub type Triangle = [Point3<f64>; 3];

/// A triangle whose height is below this part of its longest edge has no
/// area: what is left of it is rounding.
const FLAT: f64 = 1e-12;

impl TriMesh {
    /// The corners of a face, or `None` where an index is out of range or a
    /// coordinate is not finite.
    pub fn corners(&self, face: &[u32; 3]) -> Option<Triangle> {
        let corner = |i: u32| self.vertices.get(i as usize).filter(|p| p.iter().all(|c| c.is_finite()));
        Some([*corner(face[0])?, *corner(face[1])?, *corner(face[2])?])
    }

    /// Smallest and largest corner of the box around all faces. Vertices that
    /// belong to no face do not count. `None` for a mesh without a valid face.
    pub fn bounds(&self) -> Option<(Point3<f64>, Point3<f64>)> {
        bounds(self.faces.iter().filter_map(|f| self.corners(f)).flatten())
    }
}

/// What a closed surface encloses, its faces counter-clockwise from outside.
pub fn volume(vertices: &[Point3<f64>], faces: &[[u32; 3]]) -> f64 {
    let at = |i: u32| vertices[i as usize].coords;
    faces.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c))) / 6.0).sum()
}

/// Whether a triangle has an area worth the name. Scale free: edges of 1e-9
/// and of 1e12 are judged alike.
pub fn has_area([a, b, c]: &Triangle) -> bool {
    // Scaled first, so that squares neither vanish nor overflow.
    let longest = [b - a, c - b, a - c].iter().map(|e| e.amax()).fold(0.0, f64::max);
    if longest <= 0.0 || !longest.is_finite() {
        return false;
    }
    ((b - a) / longest).cross(&((c - a) / longest)).norm() > FLAT
}

/// Smallest and largest coordinates of some points; `None` for no points.
pub fn bounds(points: impl IntoIterator<Item = Point3<f64>>) -> Option<(Point3<f64>, Point3<f64>)> {
    points.into_iter().fold(None, |found, p| match found {
        None => Some((p, p)),
        Some((lo, hi)) => Some((lo.inf(&p), hi.sup(&p))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_leave_out_vertices_without_a_face() {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let mesh = TriMesh {
            vertices: vec![p(1e6, 1e6), p(0.0, 0.0), p(1.0, 0.0), p(0.0, 2.0), p(f64::NAN, 0.0)],
            faces: vec![[1, 2, 3], [1, 2, 4], [1, 2, 99]],
        };
        assert_eq!(mesh.bounds(), Some((p(0.0, 0.0), p(1.0, 2.0))));
        assert_eq!(TriMesh::default().bounds(), None);
    }

    #[test]
    fn area_is_judged_at_any_scale() {
        for scale in [1e-200, 1e-9, 1.0, 1e12, 1e200] {
            let p = |x: f64, y: f64| Point3::new(x * scale, y * scale, 0.0);
            assert!(has_area(&[p(0.0, 0.0), p(1.0, 0.0), p(0.5, 1e-6)]));
            assert!(!has_area(&[p(0.0, 0.0), p(1.0, 1.0), p(3.0, 3.0)]));
            assert!(!has_area(&[p(1.0, 1.0); 3]));
        }
    }
}
