//! The generalised winding number: how many times a triangle mesh, closed or
//! not, goes round a point.
//!
//! It is the sum of the solid angles Ω of all triangles over 4π (Jacobson,
//! Kavan and Sorkine-Hornung 2013): 1 inside and 0 outside of a closed mesh, a
//! fraction near holes. Triangles far away count by groups, by the first
//! terms of their expansion around the group's centre p (Barill, Dickson,
//! Schmidt, Levin and Jacobson 2018). With d = p − q and n the unit normals,
//!
//! ```text
//! 4π·w(q) ≈ N·d/|d|³ + M:∇G + ½ T⋮∇∇G        G(d) = d/|d|³ = −∇(1/|d|)
//! N = ∫ n dA,   M = ∫ (x − p) nᵀ dA,   T = ∫ (x − p)(x − p)ᵀ n dA
//! ∇G = I/|d|³ − 3·ddᵀ/|d|⁵,   ∂ᵢ∂ⱼGₖ = −3(δᵢⱼdₖ + δᵢₖdⱼ + δⱼₖdᵢ)/|d|⁵ + 15·dᵢdⱼdₖ/|d|⁷
//! ```
//!
//! The derivatives are symmetric in all indices, so that of M and T only the
//! symmetric parts count.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

use super::triangles::Triangles;

/// Groups count as one from this many radii away.
const FAR: f64 = 2.0;

/// The moments of a node's triangles.
#[derive(Debug, Clone)]
struct Group {
    center: Point3<f64>,
    /// (FAR · radius)².
    far2: f64,
    area: Vector3<f64>,
    /// The symmetric part of M.
    second: Matrix3<f64>,
    /// The symmetric part of T, as the matrices of its first index x, y, z.
    third: [Matrix3<f64>; 3],
}

impl Group {
    /// The groups' part in 4π·w at a point; `d` leads from there to the centre.
    #[inline]
    fn far_angle(&self, d: &Vector3<f64>, d2: f64) -> f64 {
        let inverse2 = 1.0 / d2;
        let [tx, ty, tz] = &self.third;
        // T:I and T:dd, vectors over the free index.
        let traces = Vector3::new(tx.trace(), ty.trace(), tz.trace());
        let forms = Vector3::new(d.dot(&(tx * d)), d.dot(&(ty * d)), d.dot(&(tz * d)));
        let sum = self.area.dot(d) + self.second.trace() - 3.0 * inverse2 * d.dot(&(self.second * d))
            + inverse2 * (7.5 * inverse2 * forms.dot(d) - 4.5 * traces.dot(d));
        sum * inverse2 * inverse2.sqrt()
    }
}

/// Winding numbers of a mesh.
#[derive(Debug)]
pub(super) struct Winding<'a> {
    tree: &'a Triangles,
    groups: Vec<Group>,
}

impl<'a> Winding<'a> {
    pub(super) fn new(tree: &'a Triangles) -> Self {
        let groups = tree
            .nodes()
            .par_iter()
            .map(|node| group(&tree.corners()[node.first as usize..(node.first + node.len) as usize]))
            .collect();
        Self { tree, groups }
    }

    /// The winding number of a point.
    pub(super) fn at(&self, q: &Point3<f64>, stack: &mut Vec<u32>) -> f64 {
        stack.clear();
        if !self.groups.is_empty() {
            stack.push(0);
        }
        let mut angle = 0.0;
        while let Some(at) = stack.pop() {
            let group = &self.groups[at as usize];
            let d = group.center - q;
            let d2 = d.norm_squared();
            if d2 > group.far2 {
                angle += group.far_angle(&d, d2);
                continue;
            }
            let node = &self.tree.nodes()[at as usize];
            if node.right == 0 {
                let range = node.first as usize..(node.first + node.len) as usize;
                angle += self.tree.corners()[range].iter().map(|t| solid_angle(q, t)).sum::<f64>();
            } else {
                stack.extend([node.right, at + 1]);
            }
        }
        angle / (4.0 * PI)
    }
}

fn group(triangles: &[[Point3<f64>; 3]]) -> Group {
    let (mut weight, mut sum) = (0.0, Vector3::zeros());
    let parts = || {
        triangles.iter().map(|[a, b, c]| {
            let area = (b - a).cross(&(c - a)) * 0.5;
            (area, (a.coords + b.coords + c.coords) / 3.0)
        })
    };
    for (area, centroid) in parts() {
        weight += area.norm();
        sum += centroid * area.norm();
    }
    let center = if weight > 0.0 { sum / weight } else { triangles[0][0].coords };
    let (mut area, mut second, mut third) = (Vector3::zeros(), Matrix3::zeros(), [Matrix3::zeros(); 3]);
    for (corners, (a, centroid)) in triangles.iter().zip(parts()) {
        area += a;
        let c = centroid - center;
        second += c * a.transpose();
        // ∫ (x − p)(x − p)ᵀ over a triangle of area 1.
        let mut square = c * c.transpose() * 9.0;
        for corner in corners {
            let v = corner.coords - center;
            square += v * v.transpose();
        }
        square /= 12.0;
        for (k, part) in third.iter_mut().enumerate() {
            *part += square * a[k];
        }
    }
    let radius2 = triangles.iter().flatten().map(|p| (p.coords - center).norm_squared()).fold(0.0, f64::max);
    Group {
        center: center.into(),
        far2: FAR * FAR * radius2,
        area,
        second: (second + second.transpose()) * 0.5,
        third: [0, 1, 2]
            .map(|i| Matrix3::from_fn(|j, k| (third[i][(j, k)] + third[j][(k, i)] + third[k][(i, j)]) / 3.0)),
    }
}

/// Signed solid angle of a triangle (van Oosterom and Strackee 1983), positive
/// where it is seen from behind.
fn solid_angle(q: &Point3<f64>, [a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let (a, b, c) = (a - q, b - q, c - q);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let numerator = a.dot(&b.cross(&c));
    let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * numerator.atan2(denominator)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::geometry::Superquadric;
    use crate::geometry::tessellate::{Resolution, tessellate};

    fn sphere(keep: impl Fn(&[Point3<f64>; 3]) -> bool) -> Vec<[Point3<f64>; 3]> {
        let surface =
            tessellate(&Superquadric::sphere(Point3::origin(), 1.0), Resolution { profile: 24, section: 24 });
        let corner = |i: u32| surface.vertices[i as usize];
        surface.faces.iter().map(|f| f.map(corner)).filter(keep).collect()
    }

    #[test]
    fn a_closed_mesh_winds_once_round_its_inside_and_never_round_the_outside() {
        let triangles = sphere(|_| true);
        let tree = Triangles::new(&triangles);
        let winding = Winding::new(&tree);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (mut stack, mut worst) = (Vec::new(), 0.0f64);
        for _ in 0..4000 {
            let q = Point3::new(rng.random::<f64>(), rng.random(), rng.random()) * 2.6 - Vector3::repeat(1.3);
            let radius = q.coords.norm();
            if (radius - 1.0).abs() > 5e-3 {
                let expected = f64::from(u8::from(radius < 1.0));
                worst = worst.max((winding.at(&q, &mut stack) - expected).abs());
            }
        }
        assert!(worst < 0.02, "{worst}");
    }

    #[test]
    fn a_hemisphere_winds_by_the_solid_angle_of_its_rim() {
        // From a point on the axis at height z the bowl below the rim covers
        // what the disc of the rim does not: Ω = 2π(1 − z/√(z² + 1)) for the
        // disc, which seen from below closes the bowl.
        let triangles = sphere(|t| t.iter().all(|p| p.z < 1e-9));
        let tree = Triangles::new(&triangles);
        let winding = Winding::new(&tree);
        let mut stack = Vec::new();
        for z in [-3.0f64, -1.5, -0.8, -0.4, -0.1, 0.0, 0.3, 1.0, 4.0] {
            let disc = 0.5 * (1.0 - z.abs() / z.hypot(1.0));
            let expected = match z {
                z if z < -1.0 => -disc,
                z if z < 0.0 => 1.0 - disc,
                _ => disc,
            };
            let found = winding.at(&Point3::new(0.0, 0.0, z), &mut stack);
            assert!((found - expected).abs() < 4e-3, "{z}: {found} {expected}");
        }
    }

    #[test]
    fn groups_stand_for_their_triangles() {
        // An open, ragged half of a sphere: nothing cancels.
        let triangles = sphere(|t| (9.0 * t[0].x).sin() + t[0].z > 0.0);
        let tree = Triangles::new(&triangles);
        let winding = Winding::new(&tree);
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let (mut stack, mut worst, mut sum) = (Vec::new(), 0.0f64, 0.0);
        for _ in 0..1000 {
            let q = Point3::new(rng.random::<f64>(), rng.random(), rng.random()) * 3.0 - Vector3::repeat(1.5);
            let exact = triangles.iter().map(|t| solid_angle(&q, t)).sum::<f64>() / (4.0 * PI);
            let error = (winding.at(&q, &mut stack) - exact).abs();
            worst = worst.max(error);
            sum += error;
        }
        assert!(worst < 0.02 && sum / 1000.0 < 2e-3, "{worst} {}", sum / 1000.0);
    }

    #[test]
    fn an_empty_mesh_winds_round_nothing() {
        let tree = Triangles::new(&[]);
        assert_eq!(Winding::new(&tree).at(&Point3::origin(), &mut Vec::new()), 0.0);
    }
}
