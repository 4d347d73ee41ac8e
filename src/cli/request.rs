//! What the command line asks for.

use std::path::PathBuf;

use super::batch::{BatchJob, MergeJob};
use super::bench::{BenchJob, ScalingJob};
use super::evaluate::EvaluateJob;
use super::export::ExportJob;
use super::headless::HeadlessJob;
use super::manual::ManualJob;
use super::render::RenderJob;
use crate::geometry::SamplingOptions;
use crate::inference::Params;
use crate::worker::Source;

/// What the command line asks for.
#[derive(Debug, Clone)]
pub enum Request {
    Window(WindowRequest),
    Headless(HeadlessJob),
    Batch(BatchJob),
    Merge(MergeJob),
    Evaluate(EvaluateJob),
    Export(ExportJob),
    Bench(BenchJob),
    Scaling(ScalingJob),
    Manual(ManualJob),
    Render(RenderJob),
}

/// What the window is to be opened with.
#[derive(Debug, Clone)]
pub struct WindowRequest {
    pub source: Source,
    pub sampling: SamplingOptions,
    pub params: Params,
    /// Where to save a picture of the window after the run.
    pub screenshot: Option<PathBuf>,
    /// Forget how the window was left.
    pub reset_layout: bool,
}
