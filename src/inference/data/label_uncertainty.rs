//! How sure labels are: over the last states of a run, over seeds, and between
//! branches.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::inference::data::abstraction::UNASSIGNED;

/// The entropy of each sample's labels over W states, H = −Σ f ln f with f the
/// share of the states that give it a label, as a share of its largest value:
/// H/ln W, from 0 (always the same) to 1 (never the same twice). Having no label
/// counts as a label. 0 for fewer than two states.
///
/// Each of `states` has the samples' labels by id. Those of other runs or seeds
/// are first to be [`aligned`].
pub fn label_entropy(states: &[&[u32]]) -> Vec<f32> {
    let samples = states.iter().map(|labels| labels.len()).min().unwrap_or(0);
    let w = states.len();
    if w < 2 {
        return vec![0.0; samples];
    }
    // c ln c of all counts; H = ln W − Σ c ln c / W.
    let terms: Vec<f64> = (0..=w).map(|c| if c == 0 { 0.0 } else { c as f64 * (c as f64).ln() }).collect();
    let most = (w as f64).ln();
    let entropy = |seen: &mut Vec<u32>, i: usize| {
        let first = states[0][i];
        if states[1..].iter().all(|labels| labels[i] == first) {
            return 0.0;
        }
        seen.clear();
        seen.extend(states.iter().map(|labels| labels[i]));
        seen.sort_unstable();
        let sum: f64 = seen.chunk_by(|a, b| a == b).map(|same| terms[same.len()]).sum();
        (1.0 - sum / (w as f64 * most)) as f32
    };
    (0..samples).into_par_iter().map_init(Vec::new, entropy).collect()
}

/// Which label of `other` stands for which of `reference`: the one-to-one
/// matching under which most samples agree. Keys are labels of `other`; those
/// that share no sample with their partner have none, and [`UNASSIGNED`] is no
/// label.
pub fn align_labels(reference: &[u32], other: &[u32]) -> BTreeMap<u32, u32> {
    let mut pairs: Vec<(u32, u32)> = reference
        .par_iter()
        .zip(other)
        .filter(|(a, b)| **a != UNASSIGNED && **b != UNASSIGNED)
        .map(|(a, b)| (*b, *a))
        .collect();
    pairs.par_sort_unstable();
    let shared: Vec<((u32, u32), i64)> =
        pairs.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as i64)).collect();
    let distinct = |label: fn(&(u32, u32)) -> u32| {
        let mut labels: Vec<u32> = shared.iter().map(|(pair, _)| label(pair)).collect();
        labels.sort_unstable();
        labels.dedup();
        labels
    };
    let (mut from, mut to) = (distinct(|pair| pair.0), distinct(|pair| pair.1));
    // The matching takes no more rows than columns.
    let is_turned = from.len() > to.len();
    if is_turned {
        std::mem::swap(&mut from, &mut to);
    }
    let mut weights = vec![vec![0; to.len()]; from.len()];
    for ((b, a), count) in shared {
        let (row, column) = if is_turned { (a, b) } else { (b, a) };
        if let (Ok(r), Ok(c)) = (from.binary_search(&row), to.binary_search(&column)) {
            weights[r][c] = count;
        }
    }
    let matched = best_matching(&weights);
    (0..from.len())
        .filter(|&r| weights[r][matched[r]] > 0)
        .map(|r| (from[r], to[matched[r]]))
        .map(|(row, column)| if is_turned { (column, row) } else { (row, column) })
        .collect()
}

/// The labels of `other` in terms of `reference`: those that stand for one of
/// its labels become that, the others get numbers that it doesn't use.
pub fn aligned(reference: &[u32], other: &[u32]) -> Vec<u32> {
    let mut names = align_labels(reference, other);
    let largest = reference.iter().filter(|l| **l != UNASSIGNED).max();
    let mut next = largest.map_or(0, |l| l + 1);
    let mut labels: Vec<u32> = other.to_vec();
    labels.par_sort_unstable();
    labels.dedup();
    for label in labels.into_iter().filter(|l| *l != UNASSIGNED) {
        names.entry(label).or_insert_with(|| {
            next += 1;
            next - 1
        });
    }
    other.par_iter().map(|label| names.get(label).copied().unwrap_or(UNASSIGNED)).collect()
}

/// For each sample whether two labellings disagree, once the labels of `other`
/// are named by the best matching ([`align_labels`]). A sample without a label
/// in one of them only is one of disagreement.
pub fn disagreement(reference: &[u32], other: &[u32]) -> Vec<bool> {
    let names = align_labels(reference, other);
    reference
        .par_iter()
        .zip(other)
        .map(|(&a, &b)| if b == UNASSIGNED { a != UNASSIGNED } else { names.get(&b) != Some(&a) })
        .collect()
}

/// For each row the column that it is matched with, such that no column is used
/// twice and the sum of the weights is the largest there is. Not more rows than
/// columns. Shortest augmenting paths with potentials (Kuhn 1955, Munkres 1957,
/// in the form of Jonker and Volgenant 1987): O(rows²·columns).
fn best_matching(weights: &[Vec<i64>]) -> Vec<usize> {
    let (rows, columns) = (weights.len(), weights.first().map_or(0, Vec::len));
    // Row and column 0 are none; `row_of[0]` is the row that looks for a place.
    let (mut u, mut v) = (vec![0i64; rows + 1], vec![0i64; columns + 1]);
    let mut row_of = vec![0usize; columns + 1];
    for row in 1..=rows {
        row_of[0] = row;
        let mut column = 0;
        let mut slack = vec![i64::MAX; columns + 1];
        let mut came_from = vec![0usize; columns + 1];
        let mut is_done = vec![false; columns + 1];
        while row_of[column] != 0 {
            is_done[column] = true;
            let at = row_of[column];
            let (mut least, mut next) = (i64::MAX, 0);
            for c in 1..=columns {
                if is_done[c] {
                    continue;
                }
                let reduced = -weights[at - 1][c - 1] - u[at] - v[c];
                if reduced < slack[c] {
                    slack[c] = reduced;
                    came_from[c] = column;
                }
                if slack[c] < least {
                    (least, next) = (slack[c], c);
                }
            }
            for c in 0..=columns {
                if is_done[c] {
                    u[row_of[c]] += least;
                    v[c] -= least;
                } else if slack[c] != i64::MAX {
                    slack[c] -= least;
                }
            }
            column = next;
        }
        while column != 0 {
            let before = came_from[column];
            row_of[column] = row_of[before];
            column = before;
        }
    }
    let mut matched = vec![0; rows];
    for c in 1..=columns {
        if row_of[c] > 0 {
            matched[row_of[c] - 1] = c - 1;
        }
    }
    matched
}
