//! How far places are from a shape, without what measuring volumes takes.

use nalgebra::Point3;
use rayon::prelude::*;

use super::clean::CleanMesh;
use super::error::ReferenceError;
use super::figures::CHUNK;
use super::triangles::Triangles;
use crate::geometry::TriMesh;
use crate::geometry::frame::Frame;
use crate::geometry::neighbors::KdTree;

/// A mesh's surface or a cloud's points, in the frame of their box.
#[derive(Debug, Clone)]
pub(super) enum Target {
    Mesh(Triangles),
    Cloud(KdTree),
}

impl Target {
    /// Distances of places in the frame: exact to a mesh, to the nearest point
    /// of a cloud. Neighbours in the list had better be so in space.
    pub(super) fn distances<'a>(&'a self, places: &'a [Point3<f64>]) -> impl Iterator<Item = f64> + 'a {
        let mut hint = 0;
        places.iter().map(move |p| {
            let squared = match self {
                Self::Mesh(triangles) => Some(triangles.squared_distance(p, &mut hint)),
                Self::Cloud(tree) => tree.nearest_one(p).map(|(d2, _)| d2),
            };
            squared.map_or(f64::NAN, f64::sqrt)
        })
    }
}

/// A shape that distances are measured to.
#[derive(Debug, Clone)]
pub struct Nearest {
    frame: Frame,
    target: Target,
}

impl Nearest {
    /// The surface of a mesh.
    ///
    /// # Errors
    /// [`ReferenceError::NoSurface`] where it has no face with an area.
    pub fn of_mesh(mesh: &TriMesh) -> Result<Self, ReferenceError> {
        let clean = CleanMesh::new(mesh).ok_or(ReferenceError::NoSurface)?;
        let target = Target::Mesh(Triangles::new(&clean.triangles()));
        Ok(Self { frame: clean.frame, target })
    }

    /// The points of a cloud; those that are not finite are left out.
    ///
    /// # Errors
    /// [`ReferenceError::NoPoints`] where no two distinct points are left.
    pub fn of_cloud(points: &[Point3<f64>]) -> Result<Self, ReferenceError> {
        let finite = || points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
        let frame = Frame::of_edge(finite().copied()).ok_or(ReferenceError::NoPoints)?;
        let places: Vec<Point3<f64>> = finite().map(|p| frame.local(p)).collect();
        Ok(Self { frame, target: Target::Cloud(KdTree::new(&places)) })
    }

    /// The distance of each place to the nearest point of the mesh's surface or
    /// of the cloud, all in input units.
    pub fn distances(&self, places: &[Point3<f64>]) -> Vec<f64> {
        let of_chunk = |chunk: &[Point3<f64>]| {
            let local: Vec<Point3<f64>> = chunk.iter().map(|p| self.frame.local(p)).collect();
            self.target.distances(&local).map(|d| d * self.frame.unit).collect::<Vec<f64>>()
        };
        places.par_chunks(CHUNK).flat_map_iter(of_chunk).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles, 1000 long, far from the origin.
    fn square() -> TriMesh {
        let at = |x: f64, y: f64| Point3::new(1e5 + 1e3 * x, 1e3 * y, 7.0);
        let vertices = vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        TriMesh { vertices, faces: vec![[0, 1, 2], [0, 2, 3]] }
    }

    #[test]
    fn distances_are_exact_and_in_input_units() {
        let places = [
            Point3::new(1e5 + 500.0, 500.0, 12.0),
            Point3::new(1e5 - 3.0, -4.0, 7.0),
            Point3::new(1e5, 0.0, 7.0),
        ];
        let mesh = square();
        let expected = [5.0, 5.0, 0.0];
        for (found, expected) in
            Nearest::of_mesh(&mesh).expect("a surface").distances(&places).iter().zip(expected)
        {
            assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
        }
        let to_corners = Nearest::of_cloud(&mesh.vertices).expect("points").distances(&places);
        for (found, expected) in to_corners.iter().zip([(500_025.0_f64).sqrt(), 5.0, 0.0]) {
            assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
        }
    }

    #[test]
    fn what_has_no_extent_is_refused() {
        assert!(Nearest::of_mesh(&TriMesh::default()).is_err());
        assert!(Nearest::of_cloud(&[Point3::origin(); 3]).is_err());
    }
}
