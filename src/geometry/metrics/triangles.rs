//! A tree of boxes over triangles: exact distances and rays.

use nalgebra::{Point3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Largest number of triangles in a leaf.
const LEAF: usize = 4;
/// Bins an axis of the search for the best cut.
const BINS: usize = 16;
/// From this depth on nodes are halved by count, so that the tree stays
/// shallow whatever the triangles.
const DEEP: usize = 40;
/// Deep nodes have under 2³² triangles, which are halved at each level.
const STACK: usize = DEEP + 34;

/// A node with the triangles `first..first + len`. Its left child is the next
/// node, its right child has the index `right`; 0 in a leaf.
#[derive(Debug, Clone)]
pub(super) struct Node {
    lo: Point3<f64>,
    hi: Point3<f64>,
    pub(super) first: u32,
    pub(super) len: u32,
    pub(super) right: u32,
}

impl Node {
    #[inline(always)]
    fn squared_distance(&self, q: &Point3<f64>) -> f64 {
        let mut sum = 0.0;
        for axis in 0..3 {
            let out = (self.lo[axis] - q[axis]).max(q[axis] - self.hi[axis]).max(0.0);
            sum += out * out;
        }
        sum
    }

    /// Whether a ray meets the box before `limit`.
    #[inline(always)]
    fn is_met(&self, origin: &Point3<f64>, inverse: &Vector3<f64>, limit: f64) -> bool {
        let (mut near, mut far) = (0.0f64, limit);
        for axis in 0..3 {
            let (a, b) = (
                (self.lo[axis] - origin[axis]) * inverse[axis],
                (self.hi[axis] - origin[axis]) * inverse[axis],
            );
            // Not a number (0·∞, on a slab's face) counts as within the slab.
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        near <= far
    }
}

/// Triangles in a tree of boxes.
#[derive(Debug, Clone)]
pub(super) struct Triangles {
    /// Corners, in tree order.
    corners: Vec<[Point3<f64>; 3]>,
    /// For each triangle of the tree its index in the input.
    index: Vec<u32>,
    nodes: Vec<Node>,
}

impl Triangles {
    /// Builds the tree in O(n log n). All coordinates must be finite.
    pub(super) fn new(triangles: &[[Point3<f64>; 3]]) -> Self {
        let mut items: Vec<Item> = triangles.iter().zip(0..).map(|(t, i)| Item::new(t, i)).collect();
        let mut nodes = Vec::with_capacity(triangles.len());
        if !items.is_empty() {
            build(&mut items, 0, 0, &mut nodes);
        }
        let index: Vec<u32> = items.iter().map(|item| item.index).collect();
        let corners = index.iter().map(|&i| triangles[i as usize]).collect();
        Self { corners, index, nodes }
    }

    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Corners in tree order.
    pub(super) fn corners(&self) -> &[[Point3<f64>; 3]] {
        &self.corners
    }

    /// Turns over the triangles (by their index in the input) that are marked.
    pub(super) fn flip(&mut self, marked: &[bool]) {
        for (corners, &i) in self.corners.iter_mut().zip(&self.index) {
            if marked[i as usize] {
                corners.swap(1, 2);
            }
        }
    }

    /// Squared distance to the nearest triangle; ∞ without triangles. `hint`
    /// is a place in the tree to look at first, and becomes the place that was
    /// found: for queries that lie next to each other.
    pub(super) fn squared_distance(&self, q: &Point3<f64>, hint: &mut usize) -> f64 {
        let Some(first) = self.corners.get(*hint) else { return f64::INFINITY };
        let mut best = squared_distance(q, first);
        let mut stack = [(0u32, 0.0f64); STACK];
        stack[0] = (0, self.nodes[0].squared_distance(q));
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (mut at, mut distance) = stack[height];
            while distance < best {
                let node = &self.nodes[at as usize];
                if node.right == 0 {
                    for i in node.first as usize..(node.first + node.len) as usize {
                        let d2 = squared_distance(q, &self.corners[i]);
                        if d2 < best {
                            (best, *hint) = (d2, i);
                        }
                    }
                    break;
                }
                let (left, right) = (at + 1, node.right);
                let (l, r) = (
                    self.nodes[left as usize].squared_distance(q),
                    self.nodes[right as usize].squared_distance(q),
                );
                let (near, far) = if l <= r { ((left, l), (right, r)) } else { ((right, r), (left, l)) };
                if far.1 < best {
                    stack[height] = far;
                    height += 1;
                }
                (at, distance) = near;
            }
        }
        best
    }

    /// How far a ray gets before it meets a triangle other than `except`
    /// (index in the input), from either side; `None` if it meets none.
    pub(super) fn first_hit(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        except: u32,
    ) -> Option<f64> {
        let inverse = direction.map(|d| 1.0 / d);
        let mut nearest = f64::INFINITY;
        let mut stack = [0u32; STACK];
        let mut height = usize::from(!self.nodes.is_empty());
        while height > 0 {
            height -= 1;
            let at = stack[height];
            let node = &self.nodes[at as usize];
            if !node.is_met(origin, &inverse, nearest) {
                continue;
            }
            if node.right == 0 {
                for i in node.first as usize..(node.first + node.len) as usize {
                    if self.index[i] != except
                        && let Some(t) = hit(origin, direction, &self.corners[i])
                    {
                        nearest = nearest.min(t);
                    }
                }
            } else {
                (stack[height], stack[height + 1]) = (node.right, at + 1);
                height += 2;
            }
        }
        nearest.is_finite().then_some(nearest)
    }
}

/// A triangle on its way into the tree.
#[derive(Debug, Clone)]
struct Item {
    lo: Point3<f64>,
    hi: Point3<f64>,
    index: u32,
}

impl Item {
    fn new([a, b, c]: &[Point3<f64>; 3], index: u32) -> Self {
        Self { lo: a.inf(b).inf(c), hi: a.sup(b).sup(c), index }
    }

    /// Twice the box's middle.
    fn middle(&self, axis: usize) -> f64 {
        self.lo[axis] + self.hi[axis]
    }
}

fn half_area(lo: &Point3<f64>, hi: &Point3<f64>) -> f64 {
    let e = hi - lo;
    e.x * e.y + e.y * e.z + e.z * e.x
}

fn hull(items: &[Item]) -> (Point3<f64>, Point3<f64>) {
    items.iter().skip(1).fold((items[0].lo, items[0].hi), |(lo, hi), t| (lo.inf(&t.lo), hi.sup(&t.hi)))
}

fn build(items: &mut [Item], first: u32, depth: usize, nodes: &mut Vec<Node>) {
    let (lo, hi) = hull(items);
    let at = nodes.len();
    nodes.push(Node { lo, hi, first, len: items.len() as u32, right: 0 });
    if items.len() <= LEAF {
        return;
    }
    let half = cut(items, depth);
    let (left, right) = items.split_at_mut(half);
    build(left, first, depth + 1, nodes);
    nodes[at].right = nodes.len() as u32;
    build(right, first + half as u32, depth + 1, nodes);
}

/// Parts the triangles in two where the surface areas of the two boxes, times
/// the triangles in them, are least; returns the size of the first part.
fn cut(items: &mut [Item], depth: usize) -> usize {
    let spread = |items: &[Item], axis: usize| {
        items.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), t| {
            (lo.min(t.middle(axis)), hi.max(t.middle(axis)))
        })
    };
    let spreads = [0, 1, 2].map(|axis| spread(items, axis));
    let width = |axis: usize| spreads[axis].1 - spreads[axis].0;
    let widest = (0..3).max_by(|&a, &b| width(a).total_cmp(&width(b))).unwrap_or(0);
    let median = |items: &mut [Item]| {
        let half = items.len() / 2;
        // Ties go by index, so that the tree depends on nothing else.
        items.select_nth_unstable_by(half, |a, b| {
            a.middle(widest).total_cmp(&b.middle(widest)).then(a.index.cmp(&b.index))
        });
        half
    };
    if depth >= DEEP || width(widest) <= 0.0 {
        return median(items);
    }
    let mut best = (f64::INFINITY, widest, 0);
    for axis in (0..3).filter(|&axis| width(axis) > 0.0) {
        let mut bins = [None::<(Point3<f64>, Point3<f64>, usize)>; BINS];
        for t in items.iter() {
            let bin = &mut bins[bin_of(t, axis, spreads[axis])];
            let (lo, hi, n) = bin.unwrap_or((t.lo, t.hi, 0));
            *bin = Some((lo.inf(&t.lo), hi.sup(&t.hi), n + 1));
        }
        let join = |a: Option<(Point3<f64>, Point3<f64>, usize)>, b| match (a, b) {
            (None, other) | (other, None) => other,
            (Some((lo, hi, n)), Some((lo2, hi2, n2))) => Some((lo.inf(&lo2), hi.sup(&hi2), n + n2)),
        };
        let cost = |part: Option<(Point3<f64>, Point3<f64>, usize)>| {
            part.map(|(lo, hi, n)| half_area(&lo, &hi) * n as f64)
        };
        let mut above = [None; BINS];
        let mut sum = None;
        for k in (1..BINS).rev() {
            sum = join(sum, bins[k]);
            above[k] = sum;
        }
        let mut below = None;
        for k in 1..BINS {
            below = join(below, bins[k - 1]);
            if let (Some(a), Some(b)) = (cost(below), cost(above[k]))
                && a + b < best.0
            {
                best = (a + b, axis, k);
            }
        }
    }
    let (_, axis, bin) = best;
    // A stable partition keeps the order of the input within both parts.
    items.sort_by_key(|t| bin_of(t, axis, spreads[axis]) >= bin);
    let half = items.partition_point(|t| bin_of(t, axis, spreads[axis]) < bin);
    if half == 0 || half == items.len() { median(items) } else { half }
}

fn bin_of(t: &Item, axis: usize, (lo, hi): (f64, f64)) -> usize {
    (((t.middle(axis) - lo) / (hi - lo) * BINS as f64) as usize).min(BINS - 1)
}

pub(super) fn area([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// A point of a triangle, all of them equally likely.
pub(super) fn random_point([a, b, c]: &[Point3<f64>; 3], rng: &mut ChaCha8Rng) -> Point3<f64> {
    // The square root makes the density uniform over the triangle.
    let (r, v) = (rng.random::<f64>().sqrt(), rng.random::<f64>());
    Point3::from(a.coords * (1.0 - r) + b.coords * (r * (1.0 - v)) + c.coords * (r * v))
}

/// Sums of the values up to and including each.
pub(super) fn running_sum(values: impl Iterator<Item = f64>) -> Vec<f64> {
    values
        .scan(0.0, |sum, value| {
            *sum += value;
            Some(*sum)
        })
        .collect()
}

/// Squared distance of a point to a triangle, which may be degenerate.
pub(super) fn squared_distance(q: &Point3<f64>, [a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let (ab, ac, aq) = (b - a, c - a, q - a);
    // Barycentric coordinates of the foot, times the squared double area.
    let (d1, d2) = (ab.dot(&aq), ac.dot(&aq));
    if d1 <= 0.0 && d2 <= 0.0 {
        return aq.norm_squared();
    }
    let bq = q - b;
    let (d3, d4) = (ab.dot(&bq), ac.dot(&bq));
    if d3 >= 0.0 && d4 <= d3 {
        return bq.norm_squared();
    }
    let cq = q - c;
    let (d5, d6) = (ab.dot(&cq), ac.dot(&cq));
    if d6 >= 0.0 && d5 <= d6 {
        return cq.norm_squared();
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        return (aq - ab * (d1 / (d1 - d3))).norm_squared();
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        return (aq - ac * (d2 / (d2 - d6))).norm_squared();
    }
    let va = d3 * d6 - d5 * d4;
    let (to_c, to_b) = (d4 - d3, d5 - d6);
    if va <= 0.0 && to_c >= 0.0 && to_b >= 0.0 && to_c + to_b > 0.0 {
        return (bq - (c - b) * (to_c / (to_c + to_b))).norm_squared();
    }
    let sum = va + vb + vc;
    if sum <= 0.0 {
        // A sliver whose area drowns in rounding: its corners are close enough.
        return aq.norm_squared().min(bq.norm_squared()).min(cq.norm_squared());
    }
    (aq - ab * (vb / sum) - ac * (vc / sum)).norm_squared()
}

/// Where a ray meets a triangle (Möller and Trumbore 1997), from either side.
fn hit(origin: &Point3<f64>, direction: &Vector3<f64>, [a, b, c]: &[Point3<f64>; 3]) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(&ac);
    let determinant = ab.dot(&p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let u = s.dot(&p) / determinant;
    let q = s.cross(&ab);
    let v = direction.dot(&q) / determinant;
    let t = ac.dot(&q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    fn soup(n: usize, size: f64, seed: u64) -> Vec<[Point3<f64>; 3]> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut random = || Vector3::new(rng.random::<f64>(), rng.random(), rng.random());
        (0..n)
            .map(|_| {
                let at = Point3::from(random());
                [at, at + random() * size, at + random() * size]
            })
            .collect()
    }

    #[test]
    fn distances_agree_with_a_search_of_all_points_of_a_triangle() {
        let mut worst = 0.0f64;
        for (triangle, q) in soup(60, 1.0, 1).iter().zip(soup(60, 1.0, 2)) {
            let [a, b, c] = triangle;
            let found = squared_distance(&q[0], triangle).sqrt();
            let mut searched = f64::INFINITY;
            for i in 0..=300 {
                for j in 0..=300 - i {
                    let (u, v) = (f64::from(i) / 300.0, f64::from(j) / 300.0);
                    searched = searched.min((q[0] - (a + (b - a) * u + (c - a) * v)).norm());
                }
            }
            assert!(found <= searched + 1e-12, "{found} {searched}");
            worst = worst.max(searched - found);
        }
        assert!(worst < 5e-3, "{worst}");
    }

    #[test]
    fn the_tree_finds_what_brute_force_finds() {
        for (n, size) in [(1, 0.5), (7, 0.5), (900, 0.05), (300, 2.0)] {
            let triangles = soup(n, size, 3);
            let tree = Triangles::new(&triangles);
            let mut hint = 0;
            for [q, to, _] in soup(80, 1.5, 4) {
                let brute = triangles.iter().map(|t| squared_distance(&q, t)).fold(f64::INFINITY, f64::min);
                assert_eq!(tree.squared_distance(&q, &mut hint), brute);
                let direction = (to - q).normalize();
                let hits = triangles.iter().enumerate().filter(|(i, _)| *i != 2);
                let brute = hits.filter_map(|(_, t)| hit(&q, &direction, t)).fold(f64::INFINITY, f64::min);
                assert_eq!(tree.first_hit(&q, &direction, 2).unwrap_or(f64::INFINITY), brute);
            }
        }
    }

    #[test]
    fn points_lines_and_piles_of_triangles_are_no_trouble() {
        let p = Point3::new(1.0, 2.0, 3.0);
        let line = [p, p + Vector3::x(), p + Vector3::x() * 3.0];
        let tree = Triangles::new(&[[p; 3]; 500]);
        assert_eq!(tree.squared_distance(&Point3::new(1.0, 2.0, 5.0), &mut 0), 4.0);
        assert_eq!(squared_distance(&Point3::new(3.0, 3.0, 3.0), &line), 1.0);
        assert_eq!(Triangles::new(&[]).squared_distance(&p, &mut 0), f64::INFINITY);
    }

    #[test]
    fn triangles_that_crowd_by_powers_of_two_do_not_overflow_the_stack() {
        let triangles: Vec<[Point3<f64>; 3]> = (0..2000)
            .map(|i| {
                let x = 0.9f64.powi(i);
                [Point3::new(x, 0.0, 0.0), Point3::new(x, 1e-9, 0.0), Point3::new(x, 0.0, 1e-9)]
            })
            .collect();
        let tree = Triangles::new(&triangles);
        let d2 = tree.squared_distance(&Point3::new(-1.0, 0.0, 0.0), &mut 0);
        assert!((d2 - 1.0).abs() < 1e-9);
    }
}
