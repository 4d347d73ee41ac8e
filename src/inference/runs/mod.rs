//! Whole runs: of the sampler or a baseline, with edits, imports, checkpoints and
//! merge proposals.

pub(crate) mod baselines;
pub(crate) mod checkpoint;
pub(crate) mod edit;
pub(crate) mod explain;
pub(crate) mod import;
pub(crate) mod merge_proposal;
pub(crate) mod run;
