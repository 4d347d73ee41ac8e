//! From where a cloud of unknown origin was seen: the direction or place that
//! shows all its points, where there is one.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::range_image::frame;
use super::viewpoint::Viewpoint;
use crate::inference::data::surface_distance::SurfaceDistance;

/// Directions that are tried first, spread evenly.
const DIRECTIONS: usize = 120;
/// The same where the shape may have been seen from one side.
const MORE_DIRECTIONS: usize = 400;
/// Points whose visibility is tested, at first and then.
const TESTED: usize = 300;
const THOROUGHLY: usize = 1000;
/// A point is hidden by one within so many mean spacings of its line of sight,
const ASIDE: f64 = 0.6;
/// at least so many mean spacings in front of it,
const IN_FRONT: f64 = 1.0;
/// where the way between them makes at least this sine with both tangent
/// planes: a surface doesn't hide itself at its rim.
const STEEP: f64 = 0.3;
/// The share of points that must be visible from one side. Of a closed surface
/// a direction shows about half.
const ONE_SIDE: f64 = 0.95;
/// Seen this much askew, in tangents, this share must still be visible.
const ASKEW: f64 = 0.35;
const STEADY: f64 = 0.95;
/// Viewpoints that may be the true one, at most; their cosine with the middle one
/// is above the first, and with each other below the second of these.
const PLAUSIBLE: usize = 6;
const ABOUT: f64 = 0.9;
const DISTINCT: f64 = 0.99;
/// Directions that show about as much as the best.
const NEARLY: f64 = 0.01;
/// A first look may be wrong by so much.
const ROUGHLY: f64 = 0.1;
/// Distances of a viewpoint that are tried, in radii of the cloud.
const DISTANCES: [f64; 5] = [10.0, 5.0, 3.0, 2.0, 1.3];

/// The cloud with what visibility is judged by.
struct Cloud<'a> {
    surface: &'a SurfaceDistance,
    spacing: f64,
}

/// The viewpoint that shows most of the points, with others that show about as
/// much, and whether that is all of them, as good as.
pub(crate) fn find_viewpoints(surface: &SurfaceDistance, spacing: f64) -> (Vec<Viewpoint>, bool) {
    let cloud = Cloud { surface, spacing };
    let directions = spread_directions(DIRECTIONS);
    // A view and its opposite often show the same points: convex bodies are
    // more common than bowls.
    let score = |viewpoint: &Viewpoint, share: f64| {
        let towards = viewpoint.direction_from(&cloud.center());
        let all = surface.normals().iter().zip(surface.bulges());
        let bulge: f64 = all.map(|(n, b)| n.dot(&towards).signum() * b).sum();
        share - if bulge > 0.0 { 2.0 * NEARLY } else { 0.0 }
    };
    let shares: Vec<f64> = directions
        .par_iter()
        .map(|d| {
            let viewpoint = Viewpoint::Direction(*d);
            score(&viewpoint, cloud.visible_share(&viewpoint, TESTED))
        })
        .collect();
    let best = (0..directions.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b])).unwrap_or(0);
    if shares[best] < ONE_SIDE - ROUGHLY {
        return (vec![Viewpoint::Direction(directions[best])], false);
    }
    // The middle of all directions that show about as much: where exactly the
    // viewer was, points can hardly tell.
    let around: Vec<Vector3<f64>> =
        spread_directions(MORE_DIRECTIONS).into_iter().filter(|d| d.dot(&directions[best]) > 0.3).collect();
    let shares: Vec<f64> =
        around.par_iter().map(|d| cloud.visible_share(&Viewpoint::Direction(*d), THOROUGHLY)).collect();
    let most = shares.iter().copied().fold(0.0, f64::max);
    let near: Vec<Vector3<f64>> =
        around.iter().zip(&shares).filter(|(_, s)| **s >= most - NEARLY).map(|(d, _)| *d).collect();
    let middle = near.iter().sum::<Vector3<f64>>().normalize();
    let (center, radius) = (cloud.center(), cloud.radius());
    let far = Viewpoint::Direction(middle);
    let candidates: Vec<Viewpoint> = std::iter::once(far)
        .chain(DISTANCES.map(|d| Viewpoint::Place(center + middle * (d * radius))))
        .collect();
    let rated: Vec<f64> = candidates.par_iter().map(|v| cloud.visible_share(v, THOROUGHLY)).collect();
    // The farthest of those that are about as good.
    let most = rated.iter().copied().fold(0.0, f64::max);
    let best = rated.iter().position(|r| *r >= most - 0.5 * NEARLY).unwrap_or(0);
    let mut found = vec![candidates[best]];
    // Each as far as can be from those before it.
    let mut chosen = vec![middle];
    for _ in 1..PLAUSIBLE {
        let nearness = |d: &Vector3<f64>| chosen.iter().map(|c| c.dot(d)).fold(-1.0, f64::max);
        let may_be = near.iter().filter(|d| d.dot(&middle) > ABOUT);
        let Some(next) = may_be.min_by(|a, b| nearness(a).total_cmp(&nearness(b))).copied() else { break };
        if nearness(&next) > DISTINCT {
            break;
        }
        chosen.push(next);
        found.push(Viewpoint::Direction(next));
    }
    // The sides of a post are seen edge-on by who looks along it, and half of them by
    // who looks a little askew.
    let axes = frame(&middle);
    let askew = [0, 1].map(|row| axes.row(row).transpose() * ASKEW).into_iter().flat_map(|a| [a, -a]);
    let shares = askew.map(|a| {
        let direction = (middle + a).normalize();
        let viewpoint = match candidates[best] {
            Viewpoint::Direction(_) => Viewpoint::Direction(direction),
            Viewpoint::Place(eye) => Viewpoint::Place(center + direction * (eye - center).norm()),
        };
        cloud.visible_share(&viewpoint, TESTED)
    });
    let is_steady = shares.sum::<f64>() / 4.0 >= STEADY;
    (found, is_steady && rated[best] >= ONE_SIDE)
}

/// Unit vectors spread evenly by the golden angle.
fn spread_directions(count: usize) -> Vec<Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let place = |k: usize| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (radius, angle) = ((1.0 - z * z).sqrt(), golden * k as f64);
        Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    (0..count).map(place).collect()
}

impl Cloud<'_> {
    fn center(&self) -> Point3<f64> {
        let sum: Vector3<f64> = self.surface.points().iter().map(|p| p.coords).sum();
        Point3::from(sum / self.surface.points().len().max(1) as f64)
    }

    fn radius(&self) -> f64 {
        let center = self.center();
        self.surface.points().iter().map(|p| (p - center).norm()).fold(0.0, f64::max)
    }

    /// The share of the points that nothing hides from the viewpoint.
    fn visible_share(&self, viewpoint: &Viewpoint, most_tested: usize) -> f64 {
        let across = ASIDE * self.spacing;
        let forward = -viewpoint.direction_from(&self.center());
        let axes = frame(&forward);
        let scale = match viewpoint {
            Viewpoint::Direction(_) => None,
            Viewpoint::Place(eye) => Some((*eye, (self.center() - eye).norm())),
        };
        // Image coordinates in which spacings keep about their length.
        let project = |p: &Point3<f64>| match scale {
            None => axes * p.coords,
            Some((eye, distance)) => {
                let q = axes * (p - eye);
                let z = q.z.max(1e-3 * distance);
                Vector3::new(q.x * distance / z, q.y * distance / z, q.z)
            }
        };
        let places: Vec<Vector3<f64>> = self.surface.points().iter().map(project).collect();
        let low = places.iter().fold(Vector3::repeat(f64::INFINITY), |l, p| l.inf(p));
        let high = places.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |h, p| h.sup(p));
        let size = [0, 1].map(|a| ((high[a] - low[a]) / across).min(2000.0) as usize + 1);
        let cell_of =
            |p: &Vector3<f64>| [0, 1].map(|a| (((p[a] - low[a]) / across) as usize).min(size[a] - 1));
        // A list of points for each cell.
        let mut heads = vec![u32::MAX; size[0] * size[1]];
        let mut next = vec![u32::MAX; places.len()];
        for (i, p) in (0u32..).zip(&places) {
            let [x, y] = cell_of(p);
            next[i as usize] = std::mem::replace(&mut heads[y * size[0] + x], i);
        }
        let is_hidden = |i: usize| {
            let (p, n) = (self.surface.points()[i], self.surface.normals()[i]);
            let towards = viewpoint.direction_from(&p);
            let [x, y] = cell_of(&places[i]);
            for cy in y.saturating_sub(1)..(y + 2).min(size[1]) {
                for cx in x.saturating_sub(1)..(x + 2).min(size[0]) {
                    let mut k = heads[cy * size[0] + cx];
                    while k != u32::MAX {
                        let way = self.surface.points()[k as usize] - p;
                        let along = way.dot(&towards);
                        if along > IN_FRONT * self.spacing {
                            let length = way.norm();
                            let aside = (length * length - along * along).max(0.0).sqrt();
                            let steep = STEEP * length;
                            if aside < across
                                && n.dot(&way).abs() > steep
                                && self.surface.normals()[k as usize].dot(&way).abs() > steep
                            {
                                return true;
                            }
                        }
                        k = next[k as usize];
                    }
                }
            }
            false
        };
        let stride = self.surface.points().len().div_ceil(most_tested).max(1);
        let tested: Vec<usize> = (0..self.surface.points().len()).step_by(stride).collect();
        let hidden = tested.iter().filter(|&&i| is_hidden(i)).count();
        1.0 - hidden as f64 / tested.len().max(1) as f64
    }
}
