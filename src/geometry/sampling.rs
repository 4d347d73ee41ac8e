//! Even sampling: a shape of any size becomes a set number of points that are
//! as evenly spaced as the shape allows.
//!
//! Candidates (area-uniform ones on a mesh, the points of a thinned grid in a
//! cloud) are eliminated one by one, the most crowded first, until the wanted
//! number is left: *weighted sample elimination*, C. Yuksel, "Sample
//! Elimination for Generating Poisson Disk Sample Sets", Eurographics 2015.
//! The result depends on the input and the seed alone.

use std::collections::HashMap;
use std::ops::ControlFlow;

use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::cloud::{NO_SAMPLE, SampleCloud, SampledPart};
use super::elimination::eliminate;
use super::frame::Frame;
use super::isolated::{IsolatedPoints, find_isolated};
use super::mesh::{TriMesh, bounds, has_area};
use super::morton::{Level, MortonOrder};
use super::neighbors::KdTree;
use super::outside::Room;

/// Candidates drawn for each sample of a mesh.
const CANDIDATES_PER_SAMPLE: usize = 5;
/// Where a smaller share of a mesh's area can be seen from outside, it is no
/// shape to look at, and all of it is sampled.
const LEAST_SEEN: f64 = 0.05;
/// Where a larger share can be seen, there are candidates enough.
const ENOUGH_SEEN: f64 = 0.9;
/// Most candidates that are drawn in addition, relative to the first ones.
const MOST_DRAWN: f64 = 9.0;
/// Least number of candidates for each sample of a cloud that is larger than
/// this. The grids double from one to the next, so that there may be four
/// times as many on a surface.
const THINNED_PER_SAMPLE: usize = 4;
/// Cells finer than this many halvings below the samples' spacing say nothing
/// about it; without the limit a dense clump would cost quadratic time.
const LEVELS_BELOW_SPACING: usize = 3;

/// Points of a cell that are worth looking up together.
const LEAST_SHARED: usize = 4;
/// Most samples that are looked through for each point of a cell.
const MOST_SHARED: usize = 48;

/// How a shape is turned into samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct SamplingOptions {
    /// Number of samples N.
    pub points: usize,
    pub seed: u64,
    /// Which part of a mesh is sampled. Of no matter for a cloud.
    pub surface: Surface,
    /// What becomes of isolated points of a cloud. Of no matter for a mesh.
    pub isolated: Isolated,
}

/// Which part of a mesh's surface is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Surface {
    /// What can be seen from outside, as [`outside`](super::outside) tells it:
    /// no inner walls, no parts buried in others.
    #[default]
    Outside,
    /// Every face.
    All,
}

/// What becomes of a cloud's isolated points: those whose connected component
/// at radius 2·s̄ has no more than 20 places, s̄ being the mean distance to the 5
/// nearest neighbours. Components that lie on a sheet of such are no outliers,
/// but a sparse part of the surface, and do not count as isolated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Isolated {
    /// They are no samples. Those within 3·s̄ of the others are mapped to the
    /// nearest sample all the same. Where more than half of the cloud is
    /// isolated, or it has no more than 200 places, nothing is left out.
    #[default]
    LeaveOut,
    /// They are points like the others.
    Keep,
}

impl Default for SamplingOptions {
    fn default() -> Self {
        Self { points: 5500, seed: 1, surface: Surface::default(), isolated: Isolated::default() }
    }
}

impl SamplingOptions {
    /// Limits of the number of samples, as the window and the command line
    /// offer them.
    pub const POINTS: (usize, usize) = (100, 200_000);

    /// Says what is wrong with the options, if anything is.
    pub fn check(&self) -> Result<(), SamplingError> {
        let (least, most) = Self::POINTS;
        if (least..=most).contains(&self.points) {
            Ok(())
        } else {
            Err(SamplingError::PointsOutOfRange { points: self.points, least, most })
        }
    }
}

/// Why a shape can't be sampled.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SamplingError {
    #[error("the mesh has no faces with non-zero area, so there is no surface to sample")]
    NoArea,
    #[error("the cloud has no points with finite coordinates")]
    NoPoints,
    #[error("the number of samples is {points}, but must be between {least} and {most}")]
    PointsOutOfRange { points: usize, least: usize, most: usize },
}

/// Samples a mesh evenly to exactly `options.points` points on its surface, or
/// on the part of it that can be seen from outside. Where hardly anything can,
/// all of it is taken; [`SampleCloud::part`] tells. Faces that are degenerate,
/// out of range or not finite are skipped.
///
/// # Errors
/// [`SamplingError::NoArea`] where no face is left.
pub fn sample_mesh(mesh: &TriMesh, options: &SamplingOptions) -> Result<SampleCloud, SamplingError> {
    let faces = Faces::new(mesh)?;
    let wanted = options.points;
    let Candidates { points: candidates, part } = match options.surface {
        Surface::All => faces.all_candidates(options),
        Surface::Outside => faces.seen_candidates(options),
    };
    let order = MortonOrder::new(&candidates);
    // Yuksel's largest possible spacing for N points on this area. A surface
    // that is folded over itself has less room than its area says.
    let area = faces.area() * (1.0 - part.left_out());
    let by_area = (area / (2.0 * 3f64.sqrt() * wanted.max(1) as f64)).sqrt();
    let by_cells = order.level_with(wanted).map_or(by_area, |level| 0.5 * level.cell);
    let kept = eliminate(&candidates, wanted, by_area.min(by_cells));
    let points = kept.into_iter().map(|i| faces.frame.input(&candidates[i as usize])).collect();
    Ok(SampleCloud { points, sample_of_input: None, part, viewpoints: Vec::new() })
}

/// Random points of a mesh's surface, seen or not, as many on each part as is
/// due to its area: what a dense scan would give, before any thinning. Much
/// quicker than [`sample_mesh`], but not even.
///
/// # Errors
/// [`SamplingError::NoArea`] where no face is left.
pub fn scatter_mesh(mesh: &TriMesh, count: usize, seed: u64) -> Result<Vec<Point3<f64>>, SamplingError> {
    let faces = Faces::new(mesh)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    Ok(faces.draw(count, &mut rng).into_iter().map(|(_, p)| faces.frame.input(&p)).collect())
}

/// Takes a cloud of up to `options.points` distinct points as it is, and thins
/// a larger one evenly to exactly that number, isolated points left out if
/// `options.isolated` says so; [`SampleCloud::part`] tells how many. Every
/// sample is a point of the input; each input point is mapped to its nearest
/// sample, one that is not finite, or isolated and far, to [`NO_SAMPLE`].
///
/// # Errors
/// [`SamplingError::NoPoints`] where no point is finite.
pub fn sample_cloud(points: &[Point3<f64>], options: &SamplingOptions) -> Result<SampleCloud, SamplingError> {
    let mut members: Vec<u32> =
        (0u32..).zip(points).filter(|(_, p)| p.iter().all(|c| c.is_finite())).map(|(i, _)| i).collect();
    if members.is_empty() {
        return Err(SamplingError::NoPoints);
    }
    let isolated = match options.isolated {
        Isolated::LeaveOut => find_isolated(points, &members),
        Isolated::Keep => IsolatedPoints::default(),
    };
    if isolated.len() == 0 {
        return Ok(sample_members(points, &members, options.points.max(1)));
    }
    let finite = members.len();
    let mut is_out = vec![false; points.len()];
    for &i in isolated.near.iter().chain(&isolated.far) {
        is_out[i as usize] = true;
    }
    members.retain(|&i| !is_out[i as usize]);
    let mut cloud = sample_members(points, &members, options.points.max(1));
    map_to_nearest(&mut cloud, points, &isolated.near);
    cloud.part =
        SampledPart::Connected { points: finite, isolated: isolated.len(), unlabelled: isolated.far.len() };
    Ok(cloud)
}

/// Samples those of the points that `members` names; the others get none.
fn sample_members(points: &[Point3<f64>], members: &[u32], wanted: usize) -> SampleCloud {
    if members.len() <= wanted {
        return distinct(points, members);
    }
    let frame = Frame::around(members.iter().map(|&i| points[i as usize]));
    let local: Vec<Point3<f64>> = members.par_iter().map(|&i| frame.local(&points[i as usize])).collect();
    let order = MortonOrder::new(&local);
    let (mut kept, depth) = match order.level_with(wanted) {
        Some(spacing) => {
            let fine = order.level_with(wanted.saturating_mul(THINNED_PER_SAMPLE)).unwrap_or(Level::FINEST);
            let depth = fine.depth.min(spacing.depth + LEVELS_BELOW_SPACING);
            let candidates = order.thinned(&local, depth);
            let positions: Vec<Point3<f64>> = candidates.iter().map(|&i| local[i as usize]).collect();
            let eliminated = eliminate(&positions, wanted, 0.5 * spacing.cell);
            (eliminated.into_iter().map(|i| candidates[i as usize]).collect(), depth)
        }
        // Fewer cells are occupied at the finest level than samples are wanted:
        // all that can be told apart becomes a sample.
        None => (order.thinned(&local, Level::FINEST.depth), Level::FINEST.depth),
    };
    kept.sort_unstable();
    let positions: Vec<Point3<f64>> = kept.iter().map(|&i| local[i as usize]).collect();
    let nearest = nearest_samples(&positions, &local, &order, depth);
    let mut sample_of_input = vec![NO_SAMPLE; points.len()];
    for (&i, sample) in members.iter().zip(nearest) {
        sample_of_input[i as usize] = sample;
    }
    let points = kept.iter().map(|&k| points[members[k as usize] as usize]).collect();
    SampleCloud {
        points,
        sample_of_input: Some(sample_of_input),
        part: SampledPart::Whole,
        viewpoints: Vec::new(),
    }
}

/// The nearest sample of each point, the smallest index among equals, as
/// [`KdTree::nearest_one`] tells it. `order` is that of the points.
///
/// Points of a cell choose among the same few samples: the nearest one of any
/// of them is at most one diameter of the cell farther from its middle than the
/// middle's own. So a tree is asked once a cell.
fn nearest_samples(
    samples: &[Point3<f64>],
    points: &[Point3<f64>],
    order: &MortonOrder,
    depth: usize,
) -> Vec<u32> {
    let tree = KdTree::new(samples);
    let alone = |p: &Point3<f64>| tree.nearest_one(p).map_or(NO_SAMPLE, |(_, i)| i);
    let found: Vec<(u32, u32)> = order
        .cells(depth)
        .map_init(Vec::new, |near: &mut Vec<u32>, cell| {
            let at = |k: &(u128, u32)| points[k.1 as usize];
            near.clear();
            if cell.len() >= LEAST_SHARED
                && let Some((lo, hi)) = bounds(cell.iter().map(at))
                && let middle = nalgebra::center(&lo, &hi)
                && let Some((d2, _)) = tree.nearest_one(&middle)
            {
                let reach = (d2.sqrt() + (hi - lo).norm()) * (1.0 + 1e-9);
                let end = tree.within_until(&middle, reach, |_, i| {
                    near.push(i);
                    if near.len() <= MOST_SHARED { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
                });
                if end.is_break() {
                    near.clear();
                }
            }
            let of = |p: &Point3<f64>| {
                let distances = near.iter().map(|&i| ((samples[i as usize] - p).norm_squared(), i));
                let nearest = distances.reduce(|best, next| if next < best { next } else { best });
                nearest.map_or_else(|| alone(p), |(_, i)| i)
            };
            cell.iter().map(|k| (k.1, of(&at(k)))).collect::<Vec<_>>()
        })
        .flatten_iter()
        .collect();
    let mut nearest = vec![NO_SAMPLE; points.len()];
    for (point, sample) in found {
        nearest[point as usize] = sample;
    }
    nearest
}

/// Maps some points that are no samples to the nearest sample.
fn map_to_nearest(cloud: &mut SampleCloud, points: &[Point3<f64>], chosen: &[u32]) {
    let Some(sample_of_input) = &mut cloud.sample_of_input else { return };
    let frame = Frame::around(cloud.points.iter().copied());
    let tree = KdTree::new(&cloud.points.par_iter().map(|p| frame.local(p)).collect::<Vec<_>>());
    for &i in chosen {
        let nearest = tree.nearest_one(&frame.local(&points[i as usize]));
        sample_of_input[i as usize] = nearest.map_or(NO_SAMPLE, |(_, sample)| sample);
    }
}

/// Every distinct member becomes a sample, in order of first appearance.
fn distinct(points: &[Point3<f64>], members: &[u32]) -> SampleCloud {
    let mut first: HashMap<[u64; 3], u32> = HashMap::with_capacity(members.len());
    let mut kept: Vec<Point3<f64>> = Vec::new();
    let mut sample_of_input = vec![NO_SAMPLE; points.len()];
    for &i in members {
        let p = points[i as usize];
        // + 0.0 makes one zero of the two.
        let place = [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
        sample_of_input[i as usize] = *first.entry(place).or_insert_with(|| {
            kept.push(p);
            (kept.len() - 1) as u32
        });
    }
    SampleCloud {
        points: kept,
        sample_of_input: Some(sample_of_input),
        part: SampledPart::Whole,
        viewpoints: Vec::new(),
    }
}

/// Candidates for samples, in the frame.
struct Candidates {
    points: Vec<Point3<f64>>,
    part: SampledPart,
}

/// The faces of a mesh that have an area, with the running sum of it.
#[derive(Debug)]
struct Faces {
    frame: Frame,
    /// Corners in the frame.
    triangles: Vec<[Point3<f64>; 3]>,
    /// Sum of the areas up to and including each triangle.
    area_up_to: Vec<f64>,
}

impl Faces {
    fn new(mesh: &TriMesh) -> Result<Self, SamplingError> {
        let mut triangles: Vec<[Point3<f64>; 3]> =
            mesh.faces.par_iter().filter_map(|f| mesh.corners(f)).filter(has_area).collect();
        let frame = Frame::around(triangles.iter().flatten().copied());
        let mut area_up_to: Vec<f64> = triangles
            .par_iter_mut()
            .map(|corners| {
                *corners = corners.map(|p| frame.local(&p));
                let [a, b, c] = corners;
                0.5 * (*b - *a).cross(&(*c - *a)).norm()
            })
            .collect();
        let mut total = 0.0;
        for area in &mut area_up_to {
            total += *area;
            *area = total;
        }
        if total > 0.0 { Ok(Self { frame, triangles, area_up_to }) } else { Err(SamplingError::NoArea) }
    }

    fn area(&self) -> f64 {
        self.area_up_to.last().copied().unwrap_or(0.0)
    }

    fn all_candidates(&self, options: &SamplingOptions) -> Candidates {
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
        let count = options.points.saturating_mul(CANDIDATES_PER_SAMPLE);
        let points = self.draw(count, &mut rng).into_iter().map(|(_, p)| p).collect();
        Candidates { points, part: SampledPart::Whole }
    }

    /// Draws until about as many candidates are seen from outside as
    /// [`Faces::all_candidates`] would draw; the same ones where all are.
    fn seen_candidates(&self, options: &SamplingOptions) -> Candidates {
        let room = Room::new(&self.triangles);
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
        let count = options.points.saturating_mul(CANDIDATES_PER_SAMPLE);
        let first = self.draw(count, &mut rng);
        let mut seen = self.seen(&room, &first);
        let share = seen.len() as f64 / count as f64;
        let nothing = SampledPart::WholeAsHidden;
        if share < LEAST_SEEN {
            return Candidates { points: first.into_iter().map(|(_, p)| p).collect(), part: nothing };
        }
        let mut drawn = count;
        if share < ENOUGH_SEEN {
            let more = (count as f64 * (1.0 / share - 1.0).min(MOST_DRAWN)) as usize;
            let second = self.draw(more, &mut rng);
            seen.extend(self.seen(&room, &second));
            drawn += more;
        }
        let left_out = 1.0 - seen.len() as f64 / drawn as f64;
        Candidates { points: seen, part: SampledPart::Outside { left_out } }
    }

    /// Which of the drawn points are seen from outside, in their order.
    fn seen(&self, room: &Room, drawn: &[(u32, Point3<f64>)]) -> Vec<Point3<f64>> {
        drawn
            .par_iter()
            .filter(|(face, p)| {
                let [a, b, c] = self.triangles[*face as usize];
                room.sees(p, &(b - a).cross(&(c - a)).normalize())
            })
            .map(|(_, p)| *p)
            .collect()
    }

    /// Area-uniform points, in the frame, each with its face. Stratified: the
    /// i-th point is drawn from the i-th of `count` equal shares of the area,
    /// so that each face gets its due number to within one.
    fn draw(&self, count: usize, rng: &mut ChaCha8Rng) -> Vec<(u32, Point3<f64>)> {
        let share = self.area() / count as f64;
        (0..count)
            .map(|i| {
                let at = (i as f64 + rng.random::<f64>()) * share;
                let face = self.area_up_to.partition_point(|&a| a <= at).min(self.triangles.len() - 1);
                let [a, b, c] = self.triangles[face];
                // The square root makes the density uniform over the triangle.
                let (r, v) = (rng.random::<f64>().sqrt(), rng.random::<f64>());
                let p = a.coords * (1.0 - r) + b.coords * (r * (1.0 - v)) + c.coords * (r * v);
                (face as u32, Point3::from(p))
            })
            .collect()
    }
}
