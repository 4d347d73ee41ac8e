//! Whether something lies in the way: a hierarchy of boxes over triangles.

use nalgebra::{Point3, Vector3};

use crate::geometry::mesh::Triangle;

/// Most triangles in a leaf.
const LEAF: usize = 4;
/// Below this number of triangles the tree is built by one thread.
const SPLIT_WORK: usize = 1 << 14;
/// Triangles are this much wider, relative to their edges, so that no ray
/// slips through between neighbours.
const SEAM: f64 = 1e-9;

/// Triangles in a binary tree of boxes.
#[derive(Debug)]
pub(super) struct Obstacles {
    nodes: Vec<Node>,
    /// Corner and the two edges from there, in tree order.
    triangles: Vec<[Vector3<f64>; 3]>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    lo: Vector3<f64>,
    hi: Vector3<f64>,
    /// Of a leaf: its first triangle. Of an inner node: how much farther the
    /// second child is; the first one is next to it.
    link: u32,
    /// Number of triangles of a leaf; 0 for an inner node.
    count: u32,
}

/// What the building sorts.
#[derive(Debug, Clone, Copy)]
struct Item {
    center: Vector3<f64>,
    triangle: u32,
}

impl Obstacles {
    /// Builds the tree in O(n log n).
    pub(super) fn new(triangles: &[Triangle]) -> Self {
        let mut items: Vec<Item> = (0..)
            .zip(triangles)
            .map(|(triangle, [a, b, c])| Item { center: a.coords + b.coords + c.coords, triangle })
            .collect();
        let nodes = if items.is_empty() { Vec::new() } else { build(triangles, &mut items, 0) };
        let triangles = items
            .iter()
            .map(|item| {
                let [a, b, c] = triangles[item.triangle as usize];
                [a.coords, b - a, c - a]
            })
            .collect();
        Self { nodes, triangles }
    }

    /// Whether a triangle meets the segment from `origin` along `direction` up
    /// to `length` (in units of the direction).
    pub(super) fn block(&self, origin: &Point3<f64>, direction: &Vector3<f64>, length: f64) -> bool {
        let inverse = direction.map(|d| 1.0 / d);
        let mut stack = [0u32; 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let at = stack[depth];
            let node = &self.nodes[at as usize];
            if !node.meets(&origin.coords, &inverse, length) {
                continue;
            }
            if node.count == 0 {
                stack[depth] = at + node.link;
                stack[depth + 1] = at + 1;
                depth += 2;
                continue;
            }
            let first = node.link as usize;
            let leaf = &self.triangles[first..first + node.count as usize];
            if leaf.iter().any(|t| meets(t, &origin.coords, direction, length)) {
                return true;
            }
        }
        false
    }
}

impl Node {
    fn meets(&self, origin: &Vector3<f64>, inverse: &Vector3<f64>, length: f64) -> bool {
        let (mut enter, mut leave) = (0.0f64, length);
        for k in 0..3 {
            let (a, b) = ((self.lo[k] - origin[k]) * inverse[k], (self.hi[k] - origin[k]) * inverse[k]);
            // A ray within the plane of a face has 0·∞ here, which min and max step over.
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave
    }
}

/// The nodes over the items, which come into tree order; `first` is the place
/// of the first of them.
fn build(triangles: &[Triangle], items: &mut [Item], first: usize) -> Vec<Node> {
    let (mut lo, mut hi) = (items[0].center, items[0].center);
    for item in items.iter() {
        lo = lo.inf(&item.center);
        hi = hi.sup(&item.center);
    }
    if items.len() <= LEAF {
        let mut leaf = Node {
            lo: Vector3::repeat(f64::INFINITY),
            hi: Vector3::repeat(f64::NEG_INFINITY),
            link: first as u32,
            count: items.len() as u32,
        };
        for corner in items.iter().flat_map(|item| triangles[item.triangle as usize]) {
            leaf.lo = leaf.lo.inf(&corner.coords);
            leaf.hi = leaf.hi.sup(&corner.coords);
        }
        let slack = Vector3::repeat(SEAM * (leaf.hi - leaf.lo).max());
        (leaf.lo, leaf.hi) = (leaf.lo - slack, leaf.hi + slack);
        return vec![leaf];
    }
    let axis = (hi - lo).imax();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        a.center[axis].total_cmp(&b.center[axis]).then(a.triangle.cmp(&b.triangle))
    });
    let is_large = items.len() > SPLIT_WORK;
    let (below, above) = items.split_at_mut(middle);
    let mut left = || build(triangles, below, first);
    let mut right = || build(triangles, above, first + middle);
    let (left, right) = if is_large { rayon::join(left, right) } else { (left(), right()) };
    let mut nodes = Vec::with_capacity(1 + left.len() + right.len());
    nodes.push(Node {
        lo: left[0].lo.inf(&right[0].lo),
        hi: left[0].hi.sup(&right[0].hi),
        link: 1 + left.len() as u32,
        count: 0,
    });
    nodes.extend(left);
    nodes.extend(right);
    nodes
}

/// Möller and Trumbore's test, from either side.
fn meets(
    [corner, u, v]: &[Vector3<f64>; 3],
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
    length: f64,
) -> bool {
    let across = direction.cross(v);
    let determinant = u.dot(&across);
    if determinant == 0.0 {
        return false;
    }
    let from = origin - corner;
    let a = from.dot(&across) / determinant;
    if !(-SEAM..=1.0 + SEAM).contains(&a) {
        return false;
    }
    let turned = from.cross(u);
    let b = direction.dot(&turned) / determinant;
    if b < -SEAM || a + b > 1.0 + SEAM {
        return false;
    }
    (0.0..=length).contains(&(v.dot(&turned) / determinant))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn the_tree_finds_what_testing_all_triangles_finds() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut vector = |size: f64| Vector3::from_fn(|_, _| size * rng.random_range(-1.0..1.0f64));
        let triangles: Vec<Triangle> = (0..500)
            .map(|_| {
                let at = Point3::from(vector(1.0));
                [at, at + vector(0.2), at + vector(0.2)]
            })
            .collect();
        let tree = Obstacles::new(&triangles);
        let mut blocked = 0;
        for _ in 0..500 {
            let (origin, direction) = (Point3::from(vector(1.0)), vector(1.0));
            let plain = triangles
                .iter()
                .any(|[a, b, c]| meets(&[a.coords, b - a, c - a], &origin.coords, &direction, 0.5));
            assert_eq!(tree.block(&origin, &direction, 0.5), plain);
            blocked += usize::from(plain);
        }
        assert!((50..450).contains(&blocked), "{blocked} of 500 are no test");
        assert!(!Obstacles::new(&[]).block(&Point3::origin(), &Vector3::x(), 1.0));
    }
}
