//! Batches: many shapes or many settings, one job each, some in parallel.
//!
//! The files of a job appear in its folder together, with a record of what they were made from. An
//! interrupted batch therefore resumes where it stopped: finished jobs are skipped, and incomplete
//! output never counts as finished. The tables are built from the records.

pub(super) mod fingerprint;
mod inputs;
mod job;
mod manifest;
mod merge;
mod names;
mod plan;
mod progress;
mod rows;
mod staging;
mod sweep;
mod tally;
mod work;

pub(super) use inputs::is_one_file;
pub use merge::MergeJob;
pub(super) use plan::BatchArgs;
#[cfg(feature = "window")]
pub(super) use tally::failures;
pub use work::BatchJob;
