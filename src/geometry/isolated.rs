//! Isolated points of a cloud: what a scanner saw where there is nothing.
//!
//! A surface is a sheet of points, each with neighbours about the mean spacing
//! away. Outliers lie farther apart than that, so they fall into components of
//! a few points each. So do sparse parts of a surface that is sampled unevenly;
//! but those lie on a sheet of their own, whereas outliers fill space.

use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

use super::frame::Frame;
use super::neighbors::KdTree;

/// Clouds of up to this many places are too small to tell.
const SMALLEST_CLOUD: usize = 200;
/// A component of more points than this is part of the shape: a primitive needs
/// as many.
const LARGEST_COMPONENT: usize = 20;
/// Neighbours that count for the mean spacing s̄, as in the paper.
const SPACING_NEIGHBORS: usize = 5;
/// Most points that s̄ is measured at, evenly chosen.
const SPACING_QUERIES: usize = 40_000;
/// Points within this many mean spacings are connected.
const CONNECTION_RADIUS: f64 = 2.0;
/// An isolated point within this many mean spacings of the shape is near it.
const NEAR: f64 = 3.0;
/// Outliers raise s̄, and with it the distance at which they count as
/// connected. Once they are out they are looked for again, if s̄ has fallen by
/// this factor.
const FALL: f64 = 1.25;
/// Isolated neighbours that tell whether an isolated point is on a sheet.
const SHEET_NEIGHBORS: usize = 16;
/// Largest share of the neighbours' variance that is across a sheet; in space
/// it is about 1/6 for as many neighbours.
const ACROSS: f64 = 0.1;
/// Largest distance of a point on a sheet from its neighbours' mean, in their
/// standard deviations: a point far from a few others sees them in one line.
const OFFSET: f64 = 2.0;

/// Isolated points, by their index, ascending.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct IsolatedPoints {
    /// Those within 3·s̄ of a point that is not isolated.
    pub(super) near: Vec<u32>,
    /// The others.
    pub(super) far: Vec<u32>,
}

impl IsolatedPoints {
    pub(super) fn len(&self) -> usize {
        self.near.len() + self.far.len()
    }
}

/// Finds the isolated ones among the points of `members` (indices into
/// `points`, ascending), which must be finite: those whose connected component
/// at radius 2·s̄ has at most 20 places, unless they lie on a sheet of such. s̄
/// is the mean distance to the 5 nearest neighbours. Points at the same place
/// count as one. Where more than half of the places would be isolated, or there
/// are too few to tell, none is.
///
/// Independent of the unit and of the order of the points; O(n log n).
pub(super) fn find_isolated(points: &[Point3<f64>], members: &[u32]) -> IsolatedPoints {
    let places = Places::new(points, members);
    let count = places.positions.len();
    let mut isolated = vec![false; count];
    if count <= SMALLEST_CLOUD {
        return IsolatedPoints::default();
    }
    let mut last = f64::INFINITY;
    let (tree, spacing) = loop {
        let (rest, index) = chosen(&places.positions, &isolated, false);
        let tree = KdTree::new(&rest);
        let spacing = mean_spacing(&tree, &rest);
        if spacing * FALL > last {
            break (tree, spacing);
        }
        last = spacing;
        let mut suspects = isolated.clone();
        for (i, alone) in index.iter().zip(in_small_components(&tree, &rest, CONNECTION_RADIUS * spacing)) {
            suspects[*i as usize] = alone;
        }
        let (positions, index) = chosen(&places.positions, &suspects, true);
        let mut found = false;
        for (&i, sheet) in index.iter().zip(on_sheets(&positions)) {
            let i = i as usize;
            // What was found before stays found.
            if !sheet && !isolated[i] {
                isolated[i] = true;
                found = true;
            }
        }
        if !found {
            break (tree, spacing);
        }
        if 2 * isolated.iter().filter(|&&i| i).count() > count {
            return IsolatedPoints::default();
        }
    };
    let near: Vec<bool> = (0..count)
        .into_par_iter()
        .map(|i| isolated[i] && tree.any_within(&places.positions[i], NEAR * spacing))
        .collect();
    let mut result = IsolatedPoints::default();
    for (&member, &place) in members.iter().zip(&places.of_member) {
        if near[place as usize] {
            result.near.push(member);
        } else if isolated[place as usize] {
            result.far.push(member);
        }
    }
    result
}

/// The distinct places of a cloud.
struct Places {
    /// In a frame that far points do not shrink, in an order of their own.
    positions: Vec<Point3<f64>>,
    /// The place of each member.
    of_member: Vec<u32>,
}

impl Places {
    fn new(points: &[Point3<f64>], members: &[u32]) -> Self {
        // + 0.0 makes one zero of the two.
        let key = |i: u32| points[i as usize].coords.map(|c| (c + 0.0).to_bits());
        let mut sorted: Vec<([u64; 3], u32)> =
            members.par_iter().zip(0u32..members.len() as u32).map(|(&i, at)| (key(i).into(), at)).collect();
        sorted.par_sort_unstable();
        let mut of_member = vec![0; members.len()];
        let mut distinct: Vec<Point3<f64>> = Vec::new();
        for place in sorted.chunk_by(|a, b| a.0 == b.0) {
            for &(_, at) in place {
                of_member[at as usize] = distinct.len() as u32;
            }
            distinct.push(points[members[place[0].1 as usize] as usize]);
        }
        let frame = Frame::amid(&distinct);
        Self { positions: distinct.par_iter().map(|p| frame.local(p)).collect(), of_member }
    }
}

/// The positions that `marks` has as `mark`, and their indices.
fn chosen(positions: &[Point3<f64>], marks: &[bool], mark: bool) -> (Vec<Point3<f64>>, Vec<u32>) {
    (0u32..)
        .zip(positions.iter().zip(marks))
        .filter(|(_, (_, m))| **m == mark)
        .map(|(i, (p, _))| (*p, i))
        .unzip()
}

/// s̄ of distinct points, measured at every k-th of a large cloud.
fn mean_spacing(tree: &KdTree, points: &[Point3<f64>]) -> f64 {
    let step = points.len().div_ceil(SPACING_QUERIES).max(1);
    let means: Vec<f64> = points
        .par_iter()
        .step_by(step)
        .map(|p| {
            // The nearest hit is the point itself.
            let found = tree.nearest(p, SPACING_NEIGHBORS + 1);
            let others = found.len().saturating_sub(1).max(1) as f64;
            found.iter().skip(1).map(|(d2, _)| d2.sqrt()).sum::<f64>() / others
        })
        .collect();
    means.iter().sum::<f64>() / means.len().max(1) as f64
}

/// Whether each point is in a connected component of at most
/// [`LARGEST_COMPONENT`] points. A component is followed only until it is known
/// to be larger, so that each point is looked at a few times, however dense.
fn in_small_components(tree: &KdTree, points: &[Point3<f64>], radius: f64) -> Vec<bool> {
    #[derive(Clone, Copy, PartialEq)]
    enum Component {
        Unknown,
        Followed,
        Small,
        Large,
    }
    let mut component = vec![Component::Unknown; points.len()];
    let mut part: Vec<u32> = Vec::new();
    for first in 0..points.len() as u32 {
        if component[first as usize] != Component::Unknown {
            continue;
        }
        component[first as usize] = Component::Followed;
        part.clear();
        part.push(first);
        let mut joined = false;
        let mut next = 0;
        while next < part.len() && part.len() <= LARGEST_COMPONENT && !joined {
            tree.within(&points[part[next] as usize], radius, |_, j| match component[j as usize] {
                Component::Unknown => {
                    component[j as usize] = Component::Followed;
                    part.push(j);
                }
                Component::Large => joined = true,
                Component::Followed | Component::Small => {}
            });
            next += 1;
        }
        let large = joined || part.len() > LARGEST_COMPONENT;
        for &i in &part {
            component[i as usize] = if large { Component::Large } else { Component::Small };
        }
    }
    component.into_iter().map(|c| c == Component::Small).collect()
}

/// Whether each point lies on a sheet (or line) of points: amid others, most of
/// which see theirs in a plane. Here and there a point of a volume does, too, but
/// not most in one place.
fn on_sheets(points: &[Point3<f64>]) -> Vec<bool> {
    if points.len() <= SHEET_NEIGHBORS {
        return vec![false; points.len()];
    }
    let tree = KdTree::new(points);
    let neighbors: Vec<[u32; SHEET_NEIGHBORS]> = (0..points.len() as u32)
        .into_par_iter()
        .map(|i| {
            let found = tree.nearest(&points[i as usize], SHEET_NEIGHBORS + 1);
            let mut others = found.iter().map(|f| f.1).filter(|&j| j != i);
            std::array::from_fn(|_| others.next().unwrap_or(i))
        })
        .collect();
    let seen: Vec<Surroundings> = points
        .par_iter()
        .zip(&neighbors)
        .map(|(p, near)| Surroundings::new(p, near.map(|j| points[j as usize])))
        .collect();
    seen.iter()
        .zip(&neighbors)
        .map(|(own, near)| {
            own.is_amid && 2 * near.iter().filter(|&&j| seen[j as usize].is_flat).count() >= SHEET_NEIGHBORS
        })
        .collect()
}

/// What a point sees of its neighbours.
struct Surroundings {
    /// They are about the point, not all to one side and far.
    is_amid: bool,
    /// The point is amid them, and they are nearly in a plane.
    is_flat: bool,
}

impl Surroundings {
    fn new(p: &Point3<f64>, neighbors: [Point3<f64>; SHEET_NEIGHBORS]) -> Self {
        let offsets = neighbors.map(|n| n - p);
        let mean = offsets.iter().sum::<Vector3<f64>>() / SHEET_NEIGHBORS as f64;
        let squares = offsets.iter().map(|o| (o - mean) * (o - mean).transpose()).sum::<Matrix3<f64>>();
        let covariance = squares / SHEET_NEIGHBORS as f64;
        let variance = covariance.trace();
        let is_amid = mean.norm_squared() <= OFFSET * OFFSET * variance;
        let is_flat = is_amid && covariance.symmetric_eigenvalues().min() <= ACROSS * variance;
        Self { is_amid, is_flat }
    }
}
