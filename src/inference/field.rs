//! The cloud as a surface: how far any place is from it, and which way.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use crate::geometry::neighbors::KdTree;

/// Neighbours that give the tangent plane at a point.
const NORMAL_NEIGHBORS: usize = 10;
/// Within so many mean spacings along the tangent plane of its nearest point
/// a place counts as covered: the cloud knows no finer.
const COVERED: f64 = 1.0;

/// Tangent planes at all points of the cloud.
#[derive(Debug)]
pub(crate) struct Field {
    tree: KdTree,
    points: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    reach: f64,
}

/// The way from the cloud to a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Offset {
    pub(crate) distance: f64,
    /// Unit vector along which the distance grows; 0 on the surface itself.
    pub(crate) direction: Vector3<f64>,
}

impl Field {
    pub(crate) fn new(points: &[Point3<f64>], spacing: f64) -> Self {
        let tree = KdTree::new(points);
        let normals = points
            .par_iter()
            .map(|p| {
                let near = tree.nearest(p, NORMAL_NEIGHBORS);
                let n = near.len().max(1) as f64;
                let center = near.iter().map(|k| points[k.1 as usize].coords).sum::<Vector3<f64>>() / n;
                let mut covariance = Matrix3::zeros();
                for (_, k) in &near {
                    let v = points[*k as usize].coords - center;
                    covariance += v * v.transpose();
                }
                let eigen = SymmetricEigen::new(covariance);
                let thinnest = eigen.eigenvalues.imin();
                eigen.eigenvectors.column(thinnest).into_owned()
            })
            .collect();
        Self { tree, points: points.to_vec(), normals, reach: COVERED * spacing }
    }

    /// The offset of a place from the tangent plane at its nearest point, and
    /// beyond the reach of that point from its edge, too.
    pub(crate) fn offset(&self, place: &Point3<f64>) -> Offset {
        let Some((_, k)) = self.tree.nearest_one(place) else {
            return Offset { distance: 0.0, direction: Vector3::zeros() };
        };
        let v = place - self.points[k as usize];
        let normal = self.normals[k as usize];
        let height = normal.dot(&v);
        let along = v - normal * height;
        let length = along.norm();
        let excess = (length - self.reach).max(0.0);
        let distance = height.hypot(excess);
        if distance <= f64::MIN_POSITIVE {
            return Offset { distance: 0.0, direction: Vector3::zeros() };
        }
        let sideways = if excess > 0.0 { along * (excess / length) } else { Vector3::zeros() };
        Offset { distance, direction: (normal * height + sideways) / distance }
    }
}
