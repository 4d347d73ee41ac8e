//! The sampler, Algorithm 1 of Wu et al. (ECCV 2022), and the baselines that it
//! is measured against. Pure and seeded: the same cloud, parameters and seed
//! give the same bits, whatever the number of threads. Works in a normalised
//! frame; results leave in input units.
//!
//! Each layer uses only those below it:
//!
//! | layer | what lives there |
//! |---|---|
//! | `runs` | whole runs: the sampler's or a baseline's, edits, imports, checkpoints, merge proposals |
//! | `gibbs` | the Gibbs sampler: sweep, separate and split, the log joint density |
//! | `moves` | changes of the set of primitives: the configuration that they are judged in, the search, merges |
//! | `objective` | the energy, and a cache of its terms |
//! | `fit` | fits of one primitive: Levenberg–Marquardt, to points, symmetric, k-means, moments |
//! | `data` | the cloud's model, the state, the result, random streams |
//! | `parameters`, `method`, `params`, `control` | the table of parameters, named methods; cancelling and errors |

pub(crate) mod control;
pub(crate) mod data;
pub(crate) mod fit;
pub(crate) mod gibbs;
pub mod method;
pub(crate) mod moves;
pub(crate) mod objective;
pub mod parameters;
pub mod params;
pub(crate) mod runs;

pub use control::{Cancel, InferenceError};
pub use data::abstraction::{
    Abstraction, Figures, MergeReason, MergeReport, Occurrence, PaperFinding, Phase, Primitive, UNASSIGNED,
};
pub use data::known_space::Sighting;
pub use data::label_uncertainty::{align_labels, aligned, disagreement, label_entropy};
pub use data::restaurant::expected_tables;
pub use data::state::Cluster;
pub use gibbs::sampler::Sampler;
pub use method::Method;
pub use parameters::{PARAMETERS, Parameter, Setting};
pub use params::{Algorithm, MergeRule, Params, SeenFrom};
pub use runs::checkpoint::Checkpoint;
pub use runs::edit::Edit;
pub use runs::explain::{Explanation, Held, NewTable, Odds, explain, new_table_distance, normalised_scale};
pub use runs::merge_proposal::{MergeProposal, TestNumber, TestQuantity};
pub use runs::run::Run;

#[cfg(test)]
mod tests;
