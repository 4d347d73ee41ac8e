//! The sampler, Algorithm 1 of Wu et al. (ECCV 2022), and the baselines that it
//! is measured against. Pure and seeded: the same cloud, parameters and seed
//! give the same bits, whatever the number of threads. Works in a normalised
//! frame; results leave in input units.

pub mod abstraction;
mod adjust;
mod baselines;
mod energy;
mod field;
mod fit;
mod frame;
mod kmeans;
mod merge;
pub mod method;
mod moments;
pub mod params;
mod refine;
mod run;
pub mod sampler;
mod state;
mod streams;
mod sweep;
mod trust_region;
mod two_way;

pub use abstraction::{Abstraction, Figures, MergeReport, Occurrence, Phase, Primitive, UNASSIGNED};
pub use method::{Algorithm, Method, Setting};
pub use params::{MergeRule, Params};
pub use run::Run;
pub use sampler::{Cancel, InferenceError, Sampler};

#[cfg(test)]
mod tests;
