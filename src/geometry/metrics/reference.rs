//! What abstractions are measured against, prepared once.

use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::body::{Body, inside_any};
use super::clean::CleanMesh;
use super::error::ReferenceError;
use super::figures::{CHUNK, MetricOptions, Metrics, mean};
use super::nearest::Target;
use super::orient::Patches;
use super::triangles::{Triangles, area, random_point, running_sum};
use super::winding::Winding;
use crate::geometry::TriMesh;
use crate::geometry::frame::Frame;
use crate::geometry::mesh::bounds;
use crate::geometry::neighbors::KdTree;

/// Margin of the box in which volumes are counted.
const PADDING: f64 = 0.05;
/// Points beyond the box that are drawn for primitives that stick out far.
const MOST_POINTS_BEYOND: usize = 4_000_000;
/// The share of points, and of the volume, whose winding number may be
/// undecided before the mesh counts as open.
const UNDECIDED: f64 = 0.05;
/// A volume of no more points than this is none.
const FEWEST_INSIDE: usize = 100;
/// A share of undecided points that is worth a word.
const WORTH_A_NOTE: f64 = 0.01;
/// Mean thickness (2V/A) under which IoU is harsh.
const THIN: f64 = 0.01;

/// Random streams of the preparation.
const SURFACE_STREAM: u64 = 1 << 62;
const VOLUME_STREAM: u64 = 2 << 62;
const BEYOND_STREAM: u64 = 3 << 62;

/// A mesh or a cloud, with all that measuring against it takes.
#[derive(Debug, Clone)]
pub struct Reference {
    pub(super) frame: Frame,
    pub(super) options: MetricOptions,
    target: Target,
    /// Points of the reference, in the frame.
    pub(super) samples: Vec<Point3<f64>>,
    /// The volume, or why there is none.
    pub(super) volume: Result<Volume, String>,
    notes: Vec<String>,
}

impl Reference {
    /// Prepares a mesh: distances to it are exact, and it has a volume where
    /// it is closed well enough for its inside to be told.
    /// unfinished jobs.
    /// # Errors
    /// [`ReferenceError::NoSurface`] where it has no face with an area.
    pub fn of_mesh(mesh: &TriMesh, options: &MetricOptions) -> Result<Self, ReferenceError> {
        let clean = CleanMesh::new(mesh).ok_or(ReferenceError::NoSurface)?;
        let triangles = clean.triangles();
        let samples = sample(&triangles, options).ok_or(ReferenceError::NoSurface)?;
        let area: f64 = triangles.iter().map(area).sum();
        let mut tree = Triangles::new(&triangles);
        let patches = Patches::new(&clean.faces);
        let flips = patches.flips(&triangles, &tree, options.seed);
        tree.flip(&flips);

        let mut notes = Vec::new();
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{count} of {} faces {what}", clean.faces.len()));
            }
        };
        note(clean.duplicates, "were duplicates and count once");
        note(flips.iter().filter(|f| **f).count(), "were flipped so that all face outward");
        let (volume, doubts) = Volume::of(&tree, clean.bounds, options);
        let edges = patches.edges;
        if edges.boundary > 0 || doubts > WORTH_A_NOTE {
            notes.push(format!(
                "the mesh is not watertight: of {} edges, {} have only one face and {} have more than two; \
                 {:.1} % of the bounding box is neither clearly inside nor outside",
                edges.edges,
                edges.boundary,
                edges.branching,
                100.0 * doubts
            ));
        }
        let thickness = 2.0 * volume.share(&volume.occupied) * volume.box_volume / area;
        if volume.unclear.is_none() && thickness < THIN {
            notes.push(format!(
                "the mesh is thin ({:.2} % of its longest edge on average), so IoU is strict here",
                100.0 * thickness
            ));
        }
        let target = Target::Mesh(tree);
        Ok(Self { frame: clean.frame, options: *options, target, samples, volume: Ok(volume), notes })
    }

    /// Prepares a cloud: distances to it are those to its nearest point, so
    /// that none falls below its spacing, and it has no volume. Points that are
    /// not finite are left out.
    /// unfinished jobs.
    /// # Errors
    /// [`ReferenceError::NoPoints`] where no two distinct points are left.
    pub fn of_cloud(points: &[Point3<f64>], options: &MetricOptions) -> Result<Self, ReferenceError> {
        let finite = || points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
        let frame = Frame::of_edge(finite().copied()).ok_or(ReferenceError::NoPoints)?;
        let samples: Vec<Point3<f64>> = finite().map(|p| frame.local(p)).collect();
        let tree = KdTree::new(&samples);
        let spacings: Vec<f64> =
            samples.par_iter().map(|p| tree.nearest(p, 2).last().map_or(0.0, |(d2, _)| d2.sqrt())).collect();
        let spacing = spacings.iter().sum::<f64>() / spacings.len() as f64;
        let notes = vec![format!(
            "the reference is a cloud: because of its point spacing, accuracy cannot fall below about {:.4}",
            0.9 * spacing
        )];
        let volume = Err("the reference is a cloud, which encloses no volume".to_owned());
        Ok(Self { frame, options: *options, target: Target::Cloud(tree), samples, volume, notes })
    }

    /// Adds the mesh's inside with its hollows filled, for
    /// [`Metrics::iou_outside`]: `is_inside` is asked about points in input
    /// units. Changes nothing for a cloud, and where next to nothing is inside:
    /// a thin shell has no volume to compare with.
    #[must_use]
    pub fn with_filled(mut self, is_inside: impl Fn(&Point3<f64>) -> bool + Sync) -> Self {
        if let Ok(volume) = &mut self.volume {
            let frame = self.frame;
            let filled: Vec<bool> = volume.points.par_iter().map(|p| is_inside(&frame.input(p))).collect();
            let inside = filled.iter().filter(|f| **f).count();
            volume.filled = (inside > FEWEST_INSIDE).then_some(filled);
        }
        self
    }

    /// What was mended and what to bear in mind, one sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Longest edge of the box in input units: the unit of all lengths.
    pub fn longest_edge(&self) -> f64 {
        self.frame.unit
    }

    pub fn options(&self) -> &MetricOptions {
        &self.options
    }

    /// Mean distance of points, in the frame, to the reference; `None` for no
    /// points.
    pub(super) fn mean_distance_of(&self, points: &[Point3<f64>]) -> Option<f64> {
        (!points.is_empty())
            .then(|| mean(points, |chunk| self.target.distances(chunk).filter(|d| !d.is_nan()).sum()))
    }
}

/// Area-uniform points: the i-th comes from the i-th equal share of the area.
fn sample(triangles: &[[Point3<f64>; 3]], options: &MetricOptions) -> Option<Vec<Point3<f64>>> {
    let area_up_to = running_sum(triangles.iter().map(area));
    let total = area_up_to.last().copied().filter(|total| *total > 0.0)?;
    let mut rng = stream(options.seed, SURFACE_STREAM);
    let share = total / options.samples as f64;
    let points = (0..options.samples)
        .map(|i| {
            let at = (i as f64 + rng.random::<f64>()) * share;
            let face = area_up_to.partition_point(|&a| a <= at).min(triangles.len() - 1);
            random_point(&triangles[face], &mut rng)
        })
        .collect();
    Some(points)
}

fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

/// Points all over the reference's padded box, and which of them are inside.
#[derive(Debug, Clone)]
pub(super) struct Volume {
    lo: Point3<f64>,
    hi: Point3<f64>,
    box_volume: f64,
    points: Vec<Point3<f64>>,
    /// Inside the reference; empty where that can't be told.
    occupied: Vec<bool>,
    unclear: Option<String>,
    /// Inside the reference with its hollows filled.
    filled: Option<Vec<bool>>,
}

impl Volume {
    /// The volume of an oriented mesh, and the share of its box where the
    /// winding number is no whole number.
    fn of(tree: &Triangles, (lo, hi): (Point3<f64>, Point3<f64>), options: &MetricOptions) -> (Self, f64) {
        let pad = Vector3::repeat(PADDING);
        let (lo, hi) = (lo - pad, hi + pad);
        let points = jittered_grid(lo, hi, options);
        let winding = Winding::new(tree);
        let numbers: Vec<f64> = points
            .par_chunks(CHUNK)
            .flat_map_iter(|chunk| {
                let mut stack = Vec::new();
                chunk.iter().map(|q| winding.at(q, &mut stack)).collect::<Vec<_>>()
            })
            .collect();
        let count = |test: &dyn Fn(f64) -> bool| numbers.iter().filter(|w| test(**w)).count() as f64;
        let inside = count(&|w| w > 0.5);
        let doubts = count(&|w| (w - w.round()).abs() > 0.1) / points.len() as f64;
        let undecided = count(&|w| w > 0.25 && w < 0.75) / inside.max(1.0);
        let unclear = if inside <= FEWEST_INSIDE as f64 {
            Some(format!(
                "the mesh encloses almost no volume ({inside} of {} points): it is open, a thin shell, or \
                 needs more samples",
                points.len()
            ))
        } else if doubts >= UNDECIDED || undecided >= UNDECIDED {
            Some(format!(
                "the mesh is open or a thin shell: the winding number is inconclusive for {:.0} % of its \
                 volume and {:.0} % of its bounding box",
                100.0 * undecided,
                100.0 * doubts
            ))
        } else {
            None
        };
        let volume = Self {
            lo,
            hi,
            box_volume: (hi - lo).product(),
            occupied: numbers.iter().map(|w| *w > 0.5).collect(),
            unclear,
            filled: None,
            points,
        };
        (volume, doubts)
    }

    fn share(&self, marked: &[bool]) -> f64 {
        marked.iter().filter(|m| **m).count() as f64 / self.points.len() as f64
    }

    /// Fills in the figures that have to do with volumes.
    pub(super) fn measure(&self, bodies: &[Body], seed: u64, metrics: &mut Metrics) {
        let covered: Vec<bool> = self
            .points
            .par_chunks(CHUNK)
            .flat_map_iter(|chunk| chunk.iter().map(|p| inside_any(bodies, p, None)))
            .collect();
        // In units of the padded box.
        let (covered_share, beyond) = (self.share(&covered), self.beyond(bodies, seed) / self.box_volume);
        metrics.volume = Some((covered_share + beyond) * self.box_volume);
        let against = |marked: &[bool]| {
            let both = covered.iter().zip(marked).filter(|(a, b)| **a && **b).count() as f64;
            let either = covered.iter().zip(marked).filter(|(a, b)| **a || **b).count() as f64;
            let either = either + beyond * self.points.len() as f64;
            let iou = if either > 0.0 { both / either } else { 0.0 };
            (iou, (iou * (1.0 - iou) / either.max(1.0)).sqrt())
        };
        match &self.unclear {
            Some(why) => metrics.iou_missing = Some(why.clone()),
            None => {
                let (iou, error) = against(&self.occupied);
                (metrics.iou, metrics.iou_error) = (Some(iou), Some(error));
                metrics.reference_volume = Some(self.share(&self.occupied) * self.box_volume);
            }
        }
        metrics.iou_outside = self.filled.as_deref().map(|filled| against(filled).0);
    }

    /// Volume of the bodies' union beyond the padded box.
    fn beyond(&self, bodies: &[Body], seed: u64) -> f64 {
        let corners = bodies.iter().flat_map(|b| [b.lo, b.hi]);
        let Some((lo, hi)) = bounds(corners.chain([self.lo, self.hi])) else { return 0.0 };
        if lo == self.lo && hi == self.hi {
            return 0.0;
        }
        let (edges, common) = (hi - lo, (hi - lo).product());
        // As densely as within.
        let wanted = self.points.len() as f64 * (common / self.box_volume);
        let count = (wanted as usize).clamp(1, MOST_POINTS_BEYOND);
        let hits: Vec<usize> = (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut rng = stream(seed, BEYOND_STREAM | chunk as u64);
                (0..CHUNK.min(count - chunk * CHUNK))
                    .filter(|_| {
                        let t = Vector3::new(rng.random::<f64>(), rng.random(), rng.random());
                        let p = lo + edges.component_mul(&t);
                        let within = (0..3).all(|k| p[k] > self.lo[k] && p[k] < self.hi[k]);
                        !within && inside_any(bodies, &p, None)
                    })
                    .count()
            })
            .collect();
        hits.iter().sum::<usize>() as f64 / count as f64 * common
    }
}

/// About `options.volume_points` points, one at a random place of each cell of
/// a grid: as uniform as points drawn freely, with less noise.
fn jittered_grid(lo: Point3<f64>, hi: Point3<f64>, options: &MetricOptions) -> Vec<Point3<f64>> {
    let edges = hi - lo;
    let cell = (edges.product() / options.volume_points as f64).cbrt();
    let cells = edges.map(|e| (e / cell).round().max(1.0));
    let step = edges.component_div(&cells);
    let mut rng = stream(options.seed, VOLUME_STREAM);
    let mut points = Vec::with_capacity(cells.product() as usize);
    let [nx, ny, nz] = [cells.x, cells.y, cells.z].map(|n| n as usize);
    for i in 0..nx {
        for j in 0..ny {
            for k in 0..nz {
                let at = Vector3::new(
                    i as f64 + rng.random::<f64>(),
                    j as f64 + rng.random::<f64>(),
                    k as f64 + rng.random::<f64>(),
                );
                points.push(lo + step.component_mul(&at));
            }
        }
    }
    points
}
