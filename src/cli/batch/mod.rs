//! Many shapes, or many settings: a job each, some side by side.
//!
//! A job's files appear in a folder of its name, all together, with a record of
//! what they were made from. So a batch that was stopped, however roughly, goes
//! on where it was: what is finished is skipped, and nothing half-written is
//! taken for finished. The tables are made from the records.

mod desk;
pub(super) mod fingerprint;
mod inputs;
mod job;
mod manifest;
mod merge;
mod names;
mod plan;
mod progress;
mod rows;
mod sweep;
mod tally;
mod work;

pub(super) use inputs::is_one_file;
pub use merge::MergeJob;
pub(super) use plan::BatchArgs;
pub(super) use tally::failures;
pub use work::BatchJob;
