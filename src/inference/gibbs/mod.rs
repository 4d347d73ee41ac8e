//! The Gibbs sampler: Algorithm 1 of the paper.

pub(crate) mod log_joint;
pub(crate) mod sampler;
pub(crate) mod separate;
pub(crate) mod sweep;
