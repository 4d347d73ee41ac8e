//! Unions that have been fitted, by the revisions of the clusters that they
//! stand for.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::geometry::Superquadric;

/// One primitive for two clusters, in the normalised frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Union {
    pub shape: Superquadric,
    /// Σ d² of the union.
    pub sum_d2: f64,
    /// Why it is acceptable, where the rule remembers that.
    pub reason: String,
}

/// What came of the fit of one primitive to the points of two clusters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RememberedUnion {
    /// Of the two clusters.
    pub revisions: (u64, u64),
    /// `None` where it was not worth finishing.
    pub union: Option<Union>,
}

/// Proposals by the revisions of the two clusters: what did not change since
/// needs no second fit. `None`: tried, and not acceptable.
#[derive(Debug, Clone, Default)]
pub(crate) struct UnionCache(pub(crate) BTreeMap<(u64, u64), Option<Union>>);

impl UnionCache {
    /// The union of two clusters by revision, if it was worth fitting.
    pub(crate) fn get(&self, revisions: (u64, u64)) -> Option<&Union> {
        self.0.get(&revisions)?.as_ref()
    }

    /// The proposals of clusters that are `alive`, by revision, as plain data.
    pub(crate) fn remembered(&self, alive: &BTreeSet<u64>) -> Vec<RememberedUnion> {
        let kept = self.0.iter().filter(|((a, b), _)| alive.contains(a) && alive.contains(b));
        kept.map(|(&revisions, union)| RememberedUnion { revisions, union: union.clone() }).collect()
    }

    pub(crate) fn of(remembered: &[RememberedUnion]) -> Self {
        Self(remembered.iter().map(|r| (r.revisions, r.union.clone())).collect())
    }

    /// Forgets proposals of clusters that are not `alive`, by revision.
    pub(crate) fn retain(&mut self, alive: &BTreeSet<u64>) {
        self.0.retain(|(a, b), _| alive.contains(a) && alive.contains(b));
    }
}
