//! The sampler, Algorithm 1 of Wu et al. (ECCV 2022), and the baselines that it
//! is measured against. Pure and seeded: the same cloud, parameters and seed
//! give the same bits, whatever the number of threads. Works in a normalised
//! frame; results leave in input units.

pub mod abstraction;
mod adjust;
mod baselines;
pub mod checkpoint;
pub mod edit;
mod energy;
mod explain;
mod field;
mod fit;
mod frame;
mod joint;
mod kmeans;
mod merge;
pub mod method;
mod moments;
pub mod params;
pub mod proposal;
mod refine;
mod run;
pub mod sampler;
mod state;
mod streams;
mod sweep;
mod take;
mod thresholds;
mod trust_region;
mod two_way;
mod uncertainty;

pub use abstraction::{Abstraction, Figures, MergeReport, Occurrence, Phase, Primitive, UNASSIGNED};
pub use checkpoint::Checkpoint;
pub use edit::Edit;
pub use explain::{
    Explanation, NewTable, Odds, expected_tables, explain, new_table_distance, normalised_scale,
};
pub use method::{Algorithm, Method, Setting};
pub use params::{MergeRule, Params};
pub use proposal::{MergeProposal, TestNumber};
pub use run::Run;
pub use sampler::{Cancel, InferenceError, Sampler};
pub use state::Cluster;
pub use uncertainty::{align_labels, aligned, disagreement, label_entropy};

#[cfg(test)]
mod tests;
