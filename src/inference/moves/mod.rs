//! Changes of the set of primitives: proposed, judged by the energy or by the
//! paper's test, and applied.

pub(crate) mod configuration;
pub(crate) mod merge;
pub(crate) mod merge_search;
pub(crate) mod paper_merge_test;
pub(crate) mod refit;
pub(crate) mod search;
pub(crate) mod union_cache;
