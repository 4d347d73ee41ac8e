//! Weighted sample elimination: the most crowded points go first.

use nalgebra::Point3;
use rayon::prelude::*;

use super::neighbors::KdTree;

/// Yuksel's α: how fast the weight of a neighbour falls with its distance.
const ALPHA: i32 = 8;
/// Yuksel's β and γ: how far close pairs are held apart beyond the spacing
/// that the density of the candidates allows.
const BETA: f64 = 0.65;
const GAMMA: f64 = 1.5;

/// Picks `wanted` of the candidates (all, where there are no more), evenly
/// spread; their indices, ascending. `spacing` is Yuksel's r_max: half the
/// distance between neighbours in the densest even arrangement, raised where the
/// candidates lie farther apart than that.
///
/// Each candidate weighs Σ_j (1 − d̂_ij/2r_max)^8 over its neighbours within
/// 2·r_max, d̂ = max(d, 2·r_min). The heaviest goes, its neighbours grow
/// lighter, and so on: O(M log M) for M candidates.
pub(super) fn eliminate(candidates: &[Point3<f64>], wanted: usize, spacing: f64) -> Vec<u32> {
    let count = candidates.len();
    if count <= wanted {
        return (0..count as u32).collect();
    }
    let tree = KdTree::new(candidates);
    // Where the reach misses the neighbours all weigh nothing, and whole sides
    // would go in order of index: a cloud of little more than the wanted number
    // is even already, and says itself how far its neighbours are.
    let thinned = tree.mean_spacing(5) * (count as f64 / wanted.max(1) as f64).sqrt();
    let reach = 2.0 * spacing.max(0.55 * thinned);
    let least = reach * (1.0 - (wanted as f64 / count as f64).powf(GAMMA)) * BETA;
    let weight = |d2: f64| (1.0 - d2.sqrt().max(least) / reach).max(0.0).powi(ALPHA);

    // Neighbours are visited in the tree's order, so each sum has one order of
    // terms, whatever the number of threads.
    let weights = candidates
        .par_iter()
        .zip(0u32..count as u32)
        .map(|(p, i)| {
            let mut sum = 0.0;
            tree.within(p, reach, |d2, j| {
                if j != i {
                    sum += weight(d2);
                }
            });
            sum
        })
        .collect();
    let mut heap = WeightHeap::new(weights);
    while heap.len() > wanted {
        let heaviest = heap.pop();
        tree.within(&candidates[heaviest as usize], reach, |d2, j| heap.lighten(j, weight(d2)));
    }
    heap.into_items()
}

/// A binary heap of items 0…n with weights that can be lowered in place; the
/// heaviest is on top, the smallest index among equals.
#[derive(Debug)]
struct WeightHeap {
    weight: Vec<f64>,
    /// Items in heap order.
    heap: Vec<u32>,
    /// Place of each item in `heap`, or `GONE`.
    place: Vec<u32>,
}

const GONE: u32 = u32::MAX;

impl WeightHeap {
    fn new(weight: Vec<f64>) -> Self {
        let items = weight.len() as u32;
        let mut this = Self { weight, heap: (0..items).collect(), place: (0..items).collect() };
        for at in (0..items as usize / 2).rev() {
            this.sink(at);
        }
        this
    }

    fn len(&self) -> usize {
        self.heap.len()
    }

    /// Takes the heaviest item off. The heap must not be empty.
    fn pop(&mut self) -> u32 {
        let top = self.heap.swap_remove(0);
        self.place[top as usize] = GONE;
        if let Some(&moved) = self.heap.first() {
            self.place[moved as usize] = 0;
            self.sink(0);
        }
        top
    }

    /// Takes some weight off an item, if it is still there.
    fn lighten(&mut self, item: u32, by: f64) {
        let at = self.place[item as usize];
        if at != GONE {
            self.weight[item as usize] -= by;
            self.sink(at as usize);
        }
    }

    fn above(&self, a: u32, b: u32) -> bool {
        let (wa, wb) = (self.weight[a as usize], self.weight[b as usize]);
        wa > wb || (wa == wb && a < b)
    }

    fn sink(&mut self, mut at: usize) {
        let item = self.heap[at];
        loop {
            let left = 2 * at + 1;
            let Some(&first) = self.heap.get(left) else { break };
            let (child, other) = match self.heap.get(left + 1) {
                Some(&second) if self.above(second, first) => (left + 1, second),
                _ => (left, first),
            };
            if !self.above(other, item) {
                break;
            }
            self.heap[at] = other;
            self.place[other as usize] = at as u32;
            at = child;
        }
        self.heap[at] = item;
        self.place[item as usize] = at as u32;
    }

    fn into_items(self) -> Vec<u32> {
        let mut items = self.heap;
        items.sort_unstable();
        items
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn the_heap_gives_the_heaviest_first_also_after_changes() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let mut weights: Vec<f64> = (0..300).map(|_| f64::from(rng.random_range(0..40u32))).collect();
        let mut heap = WeightHeap::new(weights.clone());
        let mut left: Vec<u32> = (0..300).collect();
        while heap.len() > 0 {
            let item = rng.random_range(0..300u32);
            heap.lighten(item, 3.0);
            weights[item as usize] -= 3.0;
            let top = heap.pop();
            let expected = left
                .iter()
                .copied()
                .max_by(|&a, &b| weights[a as usize].total_cmp(&weights[b as usize]).then(b.cmp(&a)))
                .unwrap();
            assert_eq!(top, expected);
            left.retain(|&i| i != top);
        }
    }

    #[test]
    fn no_more_candidates_than_wanted_are_all_kept() {
        let points = vec![Point3::origin(); 3];
        assert_eq!(eliminate(&points, 3, 1.0), [0, 1, 2]);
        assert_eq!(eliminate(&points, 2, 1.0).len(), 2);
    }

    /// A cloud that is even already loses points everywhere, not on one side.
    #[test]
    fn a_lattice_of_little_more_than_the_wanted_number_is_thinned_evenly() {
        let lattice: Vec<_> = (0..75)
            .flat_map(|i| (0..75).map(move |j| Point3::new(f64::from(i), f64::from(j), 0.0)))
            .collect();
        // However small the reach that the caller has in mind.
        let kept = eliminate(&lattice, 3500, 0.1);
        assert_eq!(kept.len(), 3500);
        let left = kept.iter().filter(|&&i| lattice[i as usize].x < 37.0).count();
        assert!((1500..2000).contains(&left), "{left} of 3500 are on the left");
    }
}
