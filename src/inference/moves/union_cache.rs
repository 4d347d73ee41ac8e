//! Unions that the paper's merge test has judged, by the revisions of the
//! clusters that they stand for.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::geometry::Superquadric;
use crate::inference::data::abstraction::MergeReason;

/// One primitive for two clusters, in the normalised frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Union {
    pub shape: Superquadric,
    /// Σ d² of the union.
    pub sum_d2: f64,
    /// What speaks for it, or against it.
    pub reason: MergeReason,
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

    /// Forgets proposals of clusters that are not `alive`, by revision.
    pub(crate) fn retain(&mut self, alive: &BTreeSet<u64>) {
        self.0.retain(|(a, b), _| alive.contains(a) && alive.contains(b));
    }
}
