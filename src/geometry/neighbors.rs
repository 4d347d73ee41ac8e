//! Nearest neighbours, the radius graph of a cloud, and its connected
//! components.

use std::ops::ControlFlow;

use nalgebra::Point3;
use rayon::prelude::*;

/// Largest number of points in a leaf of the tree.
const LEAF: usize = 8;
/// Parts of the tree with more points than this are built side by side.
const SPLIT_WORK: usize = 1 << 13;
/// Halves of the tree that wait to be searched: one a level at most, and a
/// tree of 2³² points has fewer levels.
const DEEPEST: usize = 40;

/// A balanced k-d tree over a fixed set of points. Any input is fine:
/// duplicates, flat and linear clouds.
#[derive(Debug, Clone)]
pub struct KdTree {
    /// Points in tree order, and for each its index in the input.
    points: Vec<Point3<f64>>,
    index: Vec<u32>,
    /// Split axis of each inner node, by the position of its median.
    axis: Vec<u8>,
}

impl KdTree {
    /// Builds the tree in O(n log n). All coordinates must be finite.
    pub fn new(points: &[Point3<f64>]) -> Self {
        let mut items: Vec<(Point3<f64>, u32)> = points.iter().copied().zip(0..).collect();
        let mut axis = vec![0; items.len()];
        split(&mut items, &mut axis);
        let (points, index) = items.into_iter().unzip();
        Self { points, index, axis }
    }

    pub fn len(&self) -> usize {
        self.points.len()
    }

    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The `k` nearest points to `query` as (squared distance, index), nearest
    /// first; fewer where the cloud is smaller.
    pub fn nearest(&self, query: &Point3<f64>, k: usize) -> Vec<(f64, u32)> {
        let mut found = Vec::with_capacity(k);
        self.nearest_into(query, k, &mut found);
        found
    }

    /// As [`KdTree::nearest`], into a vector that is cleared first: many
    /// queries need no memory of their own.
    pub fn nearest_into(&self, query: &Point3<f64>, k: usize, found: &mut Vec<(f64, u32)>) {
        self.nearest_of_into(query, k, |_| true, found);
    }

    /// As [`KdTree::nearest_into`], of the points that `is_asked` names.
    pub fn nearest_of_into(
        &self,
        query: &Point3<f64>,
        k: usize,
        is_asked: impl Fn(u32) -> bool,
        found: &mut Vec<(f64, u32)>,
    ) {
        found.clear();
        if k > 0 {
            self.nearest_in((0, self.points.len()), query, [0.0; 3], k, &is_asked, found);
        }
    }

    /// `beyond` is how far the query lies outside the part's box along each
    /// axis, as far as the splits so far tell.
    fn nearest_in(
        &self,
        (lo, hi): (usize, usize),
        query: &Point3<f64>,
        beyond: [f64; 3],
        k: usize,
        is_asked: &impl Fn(u32) -> bool,
        found: &mut Vec<(f64, u32)>,
    ) {
        let mut offer = |i: usize| {
            let candidate = ((self.points[i] - query).norm_squared(), self.index[i]);
            if !is_asked(candidate.1) {
                return;
            }
            if found.len() < k {
                found.push(candidate);
            } else if candidate < found[k - 1] {
                found[k - 1] = candidate;
            } else {
                return;
            }
            let mut at = found.len() - 1;
            while at > 0 && candidate < found[at - 1] {
                found[at] = found[at - 1];
                at -= 1;
            }
            found[at] = candidate;
        };
        if hi - lo <= LEAF {
            (lo..hi).for_each(offer);
            return;
        }
        let mid = lo + (hi - lo) / 2;
        offer(mid);
        let axis = self.axis[mid] as usize;
        let offset = self.points[mid][axis] - query[axis];
        let (near, far) = if offset > 0.0 { ((lo, mid), (mid + 1, hi)) } else { ((mid + 1, hi), (lo, mid)) };
        self.nearest_in(near, query, beyond, k, is_asked, found);
        let mut farther = beyond;
        farther[axis] = offset;
        // Summed as the distances of points are: rounding can't make the box
        // farther than a point in it.
        let [x, y, z] = farther;
        if found.len() < k || x * x + y * y + z * z <= found[k - 1].0 {
            self.nearest_in(far, query, farther, k, is_asked, found);
        }
    }

    /// The nearest point to `query` as (squared distance, index), the smallest
    /// index among equals; `None` in an empty tree. Faster than
    /// [`KdTree::nearest`] with k = 1: it needs no memory.
    pub fn nearest_one(&self, query: &Point3<f64>) -> Option<(f64, u32)> {
        self.nearest_about(query, 1.0)
    }

    /// A point at most `slack` (≥ 1) times as far from `query` as the nearest:
    /// far from the cloud, where many points are about as near, that takes a
    /// fraction of the time.
    pub fn nearest_about(&self, query: &Point3<f64>, slack: f64) -> Option<(f64, u32)> {
        let mut best = (f64::INFINITY, u32::MAX);
        self.nearest_about_in((0, self.points.len()), query, [0.0; 3], slack * slack, &mut best);
        (!self.is_empty()).then_some(best)
    }

    /// `beyond` holds, by axis, the squared way to the side of the split planes
    /// that the range lies on.
    fn nearest_about_in(
        &self,
        (lo, hi): (usize, usize),
        query: &Point3<f64>,
        beyond: [f64; 3],
        slack2: f64,
        best: &mut (f64, u32),
    ) {
        let mut offer = |i: usize| {
            let d2 = (self.points[i] - query).norm_squared();
            if d2 < best.0 || (d2 == best.0 && self.index[i] < best.1) {
                *best = (d2, self.index[i]);
            }
        };
        if hi - lo <= LEAF {
            (lo..hi).for_each(offer);
            return;
        }
        let mid = lo + (hi - lo) / 2;
        offer(mid);
        let axis = self.axis[mid] as usize;
        let offset = query[axis] - self.points[mid][axis];
        let (near, far) = if offset < 0.0 { ((lo, mid), (mid + 1, hi)) } else { ((mid + 1, hi), (lo, mid)) };
        self.nearest_about_in(near, query, beyond, slack2, best);
        let mut beyond = beyond;
        beyond[axis] = offset * offset;
        if (beyond[0] + beyond[1] + beyond[2]) * slack2 <= best.0 {
            self.nearest_about_in(far, query, beyond, slack2, best);
        }
    }

    /// Calls `visit` with (squared distance, index) for every point within
    /// `radius` of `query`, in tree order.
    pub fn within(&self, query: &Point3<f64>, radius: f64, mut visit: impl FnMut(f64, u32)) {
        let _ = self.within_until(query, radius, |d2, i| {
            visit(d2, i);
            ControlFlow::<()>::Continue(())
        });
    }

    /// As [`KdTree::within`], until `visit` breaks off; what it broke off with.
    pub fn within_until<B>(
        &self,
        query: &Point3<f64>,
        radius: f64,
        mut visit: impl FnMut(f64, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let r2 = radius * radius;
        let mut visit_near = |i: usize| {
            let d2 = (self.points[i] - query).norm_squared();
            if d2 <= r2 { visit(d2, self.index[i]) } else { ControlFlow::Continue(()) }
        };
        let mut stack = [(0, 0); DEEPEST];
        stack[0] = (0, self.points.len());
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (lo, hi) = stack[waiting];
            if hi - lo <= LEAF {
                (lo..hi).try_for_each(&mut visit_near)?;
                continue;
            }
            let mid = lo + (hi - lo) / 2;
            visit_near(mid)?;
            let axis = self.axis[mid] as usize;
            let offset = query[axis] - self.points[mid][axis];
            if offset <= radius {
                stack[waiting] = (lo, mid);
                waiting += 1;
            }
            if offset >= -radius {
                stack[waiting] = (mid + 1, hi);
                waiting += 1;
            }
        }
        ControlFlow::Continue(())
    }

    /// Whether any point lies within `radius` of `query`.
    pub fn any_within(&self, query: &Point3<f64>, radius: f64) -> bool {
        let r2 = radius * radius;
        let mut stack = [(0, 0); DEEPEST];
        stack[0] = (0, self.points.len());
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (lo, hi) = stack[waiting];
            if hi - lo <= LEAF {
                if self.points[lo..hi].iter().any(|p| (p - query).norm_squared() <= r2) {
                    return true;
                }
                continue;
            }
            let mid = lo + (hi - lo) / 2;
            if (self.points[mid] - query).norm_squared() <= r2 {
                return true;
            }
            let axis = self.axis[mid] as usize;
            let offset = query[axis] - self.points[mid][axis];
            // The nearer half is pushed last, so that it is searched first.
            let (first, second) =
                if offset < 0.0 { ((lo, mid), (mid + 1, hi)) } else { ((mid + 1, hi), (lo, mid)) };
            if offset.abs() <= radius {
                stack[waiting] = second;
                waiting += 1;
            }
            stack[waiting] = first;
            waiting += 1;
        }
        false
    }

    /// Mean distance of the points to their `k` nearest other points (the
    /// paper's mean spacing s̄ for k = 5); 0 for fewer than two points.
    pub fn mean_spacing(&self, k: usize) -> f64 {
        let distances: Vec<Vec<f64>> = self
            .points
            .par_iter()
            .with_min_len(256)
            .map_init(Vec::new, |found, p| {
                self.nearest_into(p, k + 1, found);
                // The nearest hit is the point itself (or a twin of it).
                found.iter().skip(1).map(|(d2, _)| d2.sqrt()).collect()
            })
            .collect();
        let count: usize = distances.iter().map(Vec::len).sum();
        // One after another: one order of terms, whatever the number of threads.
        let sum: f64 = distances.iter().flatten().fold(0.0, |sum, d| sum + d);
        if count == 0 { 0.0 } else { sum / count as f64 }
    }
}

fn split(items: &mut [(Point3<f64>, u32)], axis: &mut [u8]) {
    if items.len() <= LEAF {
        return;
    }
    let (mut lo, mut hi) = (items[0].0, items[0].0);
    for (p, _) in items.iter() {
        lo = lo.inf(p);
        hi = hi.sup(p);
    }
    let widest = (hi - lo).imax();
    let mid = items.len() / 2;
    // Ties are broken by index, so that the tree depends on nothing else.
    items.select_nth_unstable_by(mid, |a, b| a.0[widest].total_cmp(&b.0[widest]).then(a.1.cmp(&b.1)));
    axis[mid] = widest as u8;
    let (left, right) = items.split_at_mut(mid);
    let (axis_left, axis_right) = axis.split_at_mut(mid);
    let (right, axis_right) = (&mut right[1..], &mut axis_right[1..]);
    if mid > SPLIT_WORK {
        rayon::join(|| split(left, axis_left), || split(right, axis_right));
    } else {
        split(left, axis_left);
        split(right, axis_right);
    }
}

/// For each point the points within a radius: the graph whose connected
/// components tell the parts of a cloud apart.
#[derive(Debug, Clone)]
pub struct RadiusGraph {
    start: Vec<u32>,
    neighbor: Vec<u32>,
}

impl RadiusGraph {
    /// Joins each point to its nearest neighbours within `radius`, at most
    /// `limit` of them (so that dense spots stay linear in size), in order of
    /// index. The graph is symmetric: an edge that either end keeps, stays.
    pub fn new(tree: &KdTree, points: &[Point3<f64>], radius: f64, limit: usize) -> Self {
        let mut edges: Vec<(u32, u32)> = points
            .par_iter()
            .zip(0u32..points.len() as u32)
            .with_min_len(256)
            .map_init(Vec::new, |hits: &mut Vec<(f64, u32)>, (p, i)| {
                hits.clear();
                tree.within(p, radius, |d2, j| {
                    if j != i {
                        hits.push((d2, j));
                    }
                });
                if hits.len() > limit {
                    hits.select_nth_unstable_by(limit, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                    hits.truncate(limit);
                }
                hits.iter().flat_map(|h| [(i, h.1), (h.1, i)]).collect::<Vec<_>>()
            })
            .flatten_iter()
            .collect();
        edges.par_sort_unstable();
        edges.dedup();
        let mut start = vec![0u32; points.len() + 1];
        for (i, _) in &edges {
            start[*i as usize + 1] += 1;
        }
        for i in 0..points.len() {
            start[i + 1] += start[i];
        }
        Self { start, neighbor: edges.into_iter().map(|e| e.1).collect() }
    }

    /// The neighbours of point `i`.
    #[inline]
    pub fn of(&self, i: u32) -> &[u32] {
        &self.neighbor[self.start[i as usize] as usize..self.start[i as usize + 1] as usize]
    }

    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Splits `members` into its connected components, the largest first
    /// (ties: the one with the smallest index first). `inside` tells whether
    /// a point is a member; within a component the indices ascend.
    pub fn components(&self, members: &[u32], inside: impl Fn(u32) -> bool) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.len()];
        let mut parts: Vec<Vec<u32>> = Vec::new();
        for &seed in members {
            if seen[seed as usize] {
                continue;
            }
            seen[seed as usize] = true;
            let mut part = vec![seed];
            let mut next = 0;
            while next < part.len() {
                for &j in self.of(part[next]) {
                    if !seen[j as usize] && inside(j) {
                        seen[j as usize] = true;
                        part.push(j);
                    }
                }
                next += 1;
            }
            part.sort_unstable();
            parts.push(part);
        }
        parts.sort_by(|a, b| b.len().cmp(&a.len()).then(a[0].cmp(&b[0])));
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn cloud(n: usize, seed: u64, flat: bool) -> Vec<Point3<f64>> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        (0..n)
            .map(|_| {
                let p = Point3::new(rng.random::<f64>(), rng.random(), rng.random());
                if flat { Point3::new(p.x, 0.0, (p.z * 4.0).floor()) } else { p }
            })
            .collect()
    }

    #[test]
    fn queries_agree_with_brute_force() {
        for (n, flat) in [(1, false), (9, true), (500, false), (500, true)] {
            let points = cloud(n, 3, flat);
            let tree = KdTree::new(&points);
            for q in cloud(40, 4, false) {
                let mut all: Vec<(f64, u32)> =
                    points.iter().zip(0..).map(|(p, i)| ((p - q).norm_squared(), i)).collect();
                all.sort_by(|a, b| a.partial_cmp(b).unwrap());
                assert_eq!(tree.nearest(&q, 6), all[..6.min(n)]);
                assert_eq!(tree.nearest_one(&q), Some(all[0]));
                let about = tree.nearest_about(&q, 1.2).unwrap();
                assert!(all.contains(&about) && about.0 <= 1.2f64.powi(2) * all[0].0);
                let radius: f64 = 0.3;
                let mut within = Vec::new();
                tree.within(&q, radius, |d2, i| within.push((d2, i)));
                within.sort_by(|a, b| a.partial_cmp(b).unwrap());
                let expected: Vec<_> = all.iter().copied().filter(|h| h.0 <= radius * radius).collect();
                assert_eq!(within, expected);
                assert_eq!(tree.any_within(&q, radius), !expected.is_empty());
            }
        }
    }

    #[test]
    fn duplicates_do_not_break_the_tree() {
        let points = vec![Point3::new(1.0, 2.0, 3.0); 1000];
        let tree = KdTree::new(&points);
        assert_eq!(tree.nearest(&points[0], 3), [(0.0, 0), (0.0, 1), (0.0, 2)]);
        assert_eq!(tree.mean_spacing(5), 0.0);
    }

    #[test]
    fn components_split_a_cloud_where_it_has_a_gap() {
        let mut points: Vec<_> = (0..30).map(|i| Point3::new(f64::from(i) * 0.1, 0.0, 0.0)).collect();
        points.extend((0..20).map(|i| Point3::new(f64::from(i) * 0.1, 5.0, 0.0)));
        let graph = RadiusGraph::new(&KdTree::new(&points), &points, 0.15, 50);
        let members: Vec<u32> = (0..50).collect();
        let parts = graph.components(&members, |_| true);
        assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [30, 20]);
        // Without its middle the first row falls apart.
        let members: Vec<u32> = (0..50).filter(|&i| i != 12).collect();
        let parts = graph.components(&members, |i| i != 12);
        assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [20, 17, 12]);
    }
}
