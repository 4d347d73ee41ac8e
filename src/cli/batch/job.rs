//! One of many jobs.

use std::path::PathBuf;

use crate::geometry::SamplingOptions;
use crate::inference::Params;

/// One job: input, settings and name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Job {
    /// Its number in the whole list, from 1, whichever part is done here.
    pub(super) number: usize,
    /// Path of its folder in the output, with `/`.
    pub(super) name: String,
    pub(super) input: PathBuf,
    pub(super) sampling: SamplingOptions,
    pub(super) params: Params,
}
