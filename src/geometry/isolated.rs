//! Isolated points of a cloud: what a scanner saw where there is nothing.
//!
//! A surface is a sheet of points, each with neighbours about the mean spacing
//! away. Outliers lie farther apart than that, so they fall into components of
//! a few points each. So do sparse parts of a surface that is sampled unevenly;
//! but those lie on a sheet of their own, whereas outliers fill space.

use std::ops::ControlFlow;

use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

use super::forest::Forest;
use super::frame::Frame;
use super::morton::short_code;
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
/// Points are tried for being connected with so many that follow them along the
/// curve before a tree is asked.
const FOLLOWERS: usize = 6;
/// Points whose neighbours are looked up at once.
const BLOCK: usize = 1 << 16;
/// Half the box that places are ordered in, in median distances: beyond it
/// their order is a poor one, no more.
const ORDERED: f64 = 16.0;
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
    // One tree for all rounds: those that are out are stepped over.
    let positions = &places.positions;
    let tree = KdTree::new(positions);
    let mut last = f64::INFINITY;
    let spacing = loop {
        let rest = marked(&isolated, false);
        let spacing = mean_spacing(&tree, positions, &rest, &isolated);
        if spacing * FALL > last {
            break spacing;
        }
        last = spacing;
        let mut suspects =
            in_small_components(&tree, positions, &rest, &isolated, CONNECTION_RADIUS * spacing);
        suspects.par_iter_mut().zip(&isolated).for_each(|(suspect, out)| *suspect |= out);
        let suspects = marked(&suspects, true);
        // What was found before stays found, so that it isn't asked for again.
        let mut found = false;
        for (&i, sheet) in suspects.iter().zip(on_sheets(positions, &suspects, &isolated)) {
            if !sheet && !isolated[i as usize] {
                isolated[i as usize] = true;
                found = true;
            }
        }
        if !found {
            break spacing;
        }
        if 2 * isolated.iter().filter(|&&i| i).count() > count {
            return IsolatedPoints::default();
        }
    };
    let is_near = |p: &Point3<f64>| {
        let visit =
            |_, j: u32| if isolated[j as usize] { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
        tree.within_until(p, NEAR * spacing, visit).is_break()
    };
    let near: Vec<bool> =
        positions.par_iter().zip(&isolated).map(|(p, &isolated)| isolated && is_near(p)).collect();
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
    /// In a frame that far points do not shrink, along a space-filling curve,
    /// so that queries of one after another find the same nodes in the cache.
    positions: Vec<Point3<f64>>,
    /// The place of each member.
    of_member: Vec<u32>,
}

impl Places {
    fn new(points: &[Point3<f64>], members: &[u32]) -> Self {
        let place = |at: u32| points[members[at as usize] as usize];
        // + 0.0 makes one zero of the two.
        let bits = |at: u32| -> [u64; 3] { place(at).coords.map(|c| (c + 0.0).to_bits()).into() };
        let all: Vec<Point3<f64>> = members.par_iter().map(|&i| points[i as usize]).collect();
        let frame = Frame::amid(&all);
        let mut sorted: Vec<(u64, u32)> = all
            .par_iter()
            .zip(0u32..members.len() as u32)
            .map(|(p, at)| (short_code(&(frame.local(p) / ORDERED)), at))
            .collect();
        // Ties by place and not by index: the order of the points is of no matter.
        sorted.par_sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| bits(a.1).cmp(&bits(b.1))));
        let mut of_member = vec![0; members.len()];
        let mut distinct: Vec<Point3<f64>> = Vec::with_capacity(members.len());
        let mut last = None;
        for &(_, at) in &sorted {
            let bits = bits(at);
            if last != Some(bits) {
                last = Some(bits);
                distinct.push(place(at));
            }
            of_member[at as usize] = distinct.len() as u32 - 1;
        }
        let frame = if distinct.len() < members.len() { Frame::amid(&distinct) } else { frame };
        distinct.par_iter_mut().for_each(|p| *p = frame.local(p));
        Self { positions: distinct, of_member }
    }
}

/// The indices that `marks` has as `mark`.
fn marked(marks: &[bool], mark: bool) -> Vec<u32> {
    (0u32..).zip(marks).filter(|(_, m)| **m == mark).map(|(i, _)| i).collect()
}

/// s̄ of the distinct points that are not `out`, measured at every k-th of a
/// large cloud. `rest` are their indices.
fn mean_spacing(tree: &KdTree, points: &[Point3<f64>], rest: &[u32], out: &[bool]) -> f64 {
    let step = rest.len().div_ceil(SPACING_QUERIES).max(1);
    let means: Vec<f64> = rest
        .par_iter()
        .step_by(step)
        .map_init(Vec::new, |found, &i| {
            let is_in = |j: u32| !out[j as usize];
            // The nearest hit is the point itself.
            tree.nearest_of_into(&points[i as usize], SPACING_NEIGHBORS + 1, is_in, found);
            let others = found.len().saturating_sub(1).max(1) as f64;
            found.iter().skip(1).map(|(d2, _)| d2.sqrt()).sum::<f64>() / others
        })
        .collect();
    means.iter().sum::<f64>() / means.len().max(1) as f64
}

/// Whether each point is in a connected component of at most
/// [`LARGEST_COMPONENT`] points that are not `out`; `rest` are their indices.
///
/// Points that follow each other along the curve are joined first, which shows
/// most of a surface to be large. Of the others the neighbours are looked up,
/// until one is known to be in a large component or there are too many for a
/// small one: so each point is looked at a few times, however dense.
fn in_small_components(
    tree: &KdTree,
    points: &[Point3<f64>],
    rest: &[u32],
    out: &[bool],
    radius: f64,
) -> Vec<bool> {
    let r2 = radius * radius;
    let mut parts = Parts::of(points.len() as u32);
    for (k, &i) in rest.iter().enumerate() {
        let p = &points[i as usize];
        for &j in rest[k + 1..].iter().take(FOLLOWERS) {
            if (p - points[j as usize]).norm_squared() <= r2 {
                parts.join(i, j);
            }
        }
    }
    let mut is_large = vec![false; points.len()];
    rest.iter().for_each(|&i| is_large[i as usize] = parts.is_large(i));
    let unknown: Vec<u32> = rest.iter().copied().filter(|&i| !is_large[i as usize]).collect();
    for block in unknown.chunks(BLOCK) {
        let found: Vec<Neighborhood> = block
            .par_iter()
            .with_min_len(256)
            .map(|&i| Neighborhood::of(i, tree, &points[i as usize], radius, &is_large, out))
            .collect();
        for (&i, neighborhood) in block.iter().zip(found) {
            match neighborhood {
                Neighborhood::Large => {
                    parts.enlarge(i);
                    is_large[i as usize] = true;
                }
                Neighborhood::Few(neighbors) => neighbors.into_iter().for_each(|j| parts.join(i, j)),
            }
        }
    }
    let mut is_small = vec![false; points.len()];
    rest.iter().for_each(|&i| is_small[i as usize] = !parts.is_large(i));
    is_small
}

/// What is around a point.
enum Neighborhood {
    /// Enough for a large component.
    Large,
    /// All within the radius.
    Few(Vec<u32>),
}

impl Neighborhood {
    fn of(i: u32, tree: &KdTree, p: &Point3<f64>, radius: f64, is_large: &[bool], out: &[bool]) -> Self {
        let mut neighbors = Vec::new();
        let end = tree.within_until(p, radius, |_, j| {
            if out[j as usize] {
                return ControlFlow::Continue(());
            }
            if is_large[j as usize] || neighbors.len() == LARGEST_COMPONENT {
                return ControlFlow::Break(());
            }
            if j != i {
                neighbors.push(j);
            }
            ControlFlow::Continue(())
        });
        if end.is_break() { Self::Large } else { Self::Few(neighbors) }
    }
}

/// Disjoint sets of points, which count up to where they are large.
struct Parts {
    sets: Forest,
    /// Of a root: points of its set, as far as it matters.
    size: Vec<u8>,
}

impl Parts {
    fn of(count: u32) -> Self {
        Self { sets: Forest::of(count), size: vec![1; count as usize] }
    }

    fn join(&mut self, i: u32, j: u32) {
        let (i, j) = (self.sets.root(i), self.sets.root(j));
        if i != j {
            let (small, large) = if self.size[i as usize] < self.size[j as usize] { (i, j) } else { (j, i) };
            self.sets.hang(small, large);
            let sum = self.size[small as usize] + self.size[large as usize];
            self.size[large as usize] = sum.min(Self::LARGE);
        }
    }

    const LARGE: u8 = LARGEST_COMPONENT as u8 + 1;

    /// Marks a point's set as large.
    fn enlarge(&mut self, i: u32) {
        let root = self.sets.root(i);
        self.size[root as usize] = Self::LARGE;
    }

    fn is_large(&mut self, i: u32) -> bool {
        let root = self.sets.root(i);
        self.size[root as usize] == Self::LARGE
    }
}

/// Whether each of some points lies on a sheet (or line) of them: amid others,
/// most of which see theirs in a plane. Here and there a point of a volume does,
/// too, but not most in one place. `chosen` are their indices; those that are
/// `known` not to are not looked at, but for what the others need.
fn on_sheets(points: &[Point3<f64>], chosen: &[u32], known: &[bool]) -> Vec<bool> {
    if chosen.len() <= SHEET_NEIGHBORS {
        return vec![false; chosen.len()];
    }
    let points: Vec<Point3<f64>> = chosen.iter().map(|&i| points[i as usize]).collect();
    let tree = KdTree::new(&points);
    let neighbors_of = |found: &mut Vec<(f64, u32)>, i: u32| -> [u32; SHEET_NEIGHBORS] {
        tree.nearest_into(&points[i as usize], SHEET_NEIGHBORS + 1, found);
        let mut others = found.iter().map(|f| f.1).filter(|&j| j != i);
        std::array::from_fn(|_| others.next().unwrap_or(i))
    };
    let asked: Vec<u32> =
        (0u32..).zip(chosen).filter(|(_, i)| !known[**i as usize]).map(|(k, _)| k).collect();
    let neighbors: Vec<[u32; SHEET_NEIGHBORS]> =
        asked.par_iter().map_init(Vec::new, |found, &k| neighbors_of(found, k)).collect();
    let surroundings = |k: u32, near: &[u32; SHEET_NEIGHBORS]| {
        Surroundings::new(&points[k as usize], near.map(|j| points[j as usize]))
    };
    let mut seen = vec![None; points.len()];
    let own: Vec<Surroundings> =
        asked.par_iter().zip(&neighbors).map(|(&k, near)| surroundings(k, near)).collect();
    asked.iter().zip(own).for_each(|(&k, own)| seen[k as usize] = Some(own));
    // What the neighbours see that nobody has asked for.
    let mut is_needed = vec![false; points.len()];
    neighbors.iter().flatten().for_each(|&j| is_needed[j as usize] = seen[j as usize].is_none());
    seen.par_iter_mut()
        .zip(0u32..points.len() as u32)
        .filter(|(_, k)| is_needed[*k as usize])
        .for_each_init(Vec::new, |found, (seen, k)| *seen = Some(surroundings(k, &neighbors_of(found, k))));
    let mut on_sheet = vec![false; points.len()];
    for (&k, near) in asked.iter().zip(&neighbors) {
        let is_flat = |j: &&u32| seen[**j as usize].is_some_and(|s| s.is_flat);
        on_sheet[k as usize] = seen[k as usize].is_some_and(|s| s.is_amid)
            && 2 * near.iter().filter(is_flat).count() >= SHEET_NEIGHBORS;
    }
    on_sheet
}

/// What a point sees of its neighbours.
#[derive(Clone, Copy)]
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
        let is_flat = is_amid && !is_above(&covariance, ACROSS * variance);
        Self { is_amid, is_flat }
    }
}

/// Whether all eigenvalues of a symmetric matrix are larger than `bound`: by
/// Sylvester, the leading minors of the matrix less `bound` are positive.
fn is_above(matrix: &Matrix3<f64>, bound: f64) -> bool {
    let m = matrix - Matrix3::from_diagonal_element(bound);
    let minor = m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(0, 1)];
    m[(0, 0)] > 0.0 && minor > 0.0 && m.determinant() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn small_components_are_those_that_following_all_neighbours_finds() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let points: Vec<Point3<f64>> =
            (0..4000).map(|_| Point3::from(Vector3::from_fn(|_, _| rng.random::<f64>()))).collect();
        let tree = KdTree::new(&points);
        // From loose pairs to one component, with those of about 20 in between.
        for radius in [0.01, 0.03, 0.045, 0.055, 0.07, 0.2] {
            let mut size = vec![0; points.len()];
            let mut seen = vec![false; points.len()];
            for first in 0..points.len() {
                let mut part = if seen[first] { vec![] } else { vec![first] };
                seen[first] = true;
                let mut next = 0;
                while next < part.len() {
                    tree.within(&points[part[next]], radius, |_, j| {
                        if !std::mem::replace(&mut seen[j as usize], true) {
                            part.push(j as usize);
                        }
                    });
                    next += 1;
                }
                part.iter().for_each(|&i| size[i] = part.len());
            }
            let expected: Vec<bool> = size.iter().map(|&n| n <= LARGEST_COMPONENT).collect();
            let rest: Vec<u32> = (0..points.len() as u32).collect();
            let out = vec![false; points.len()];
            assert_eq!(in_small_components(&tree, &points, &rest, &out, radius), expected, "radius {radius}");
        }
    }

    #[test]
    fn the_minors_tell_what_the_eigenvalues_tell() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(8);
        for _ in 0..500 {
            let half = Matrix3::from_fn(|_, _| rng.random_range(-1.0..1.0f64));
            let matrix = half * half.transpose();
            let least = matrix.symmetric_eigenvalues().min();
            assert!(is_above(&matrix, least - 1e-6));
            assert!(!is_above(&matrix, least + 1e-6));
        }
    }
}
