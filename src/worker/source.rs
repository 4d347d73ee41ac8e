//! The worker's only calls into `io`, with errors as sentences for a person.

use std::path::Path;
use std::sync::Arc;

use super::protocol::{ExportRequest, SamplingOptions, Source, State};
use crate::geometry::SampleCloud;
use crate::geometry::metrics::{MetricOptions, Reference};
use crate::inference::Edit;
use crate::io::{self, Opened, Outcome, Shape};

/// Reads the shape, or the primitives with the shape that they stand for.
pub(super) fn read(source: &Source) -> Result<Opened, String> {
    match source {
        Source::File(path) => io::open(path),
        Source::BuiltIn => io::built_in().map(|shape| Opened::Shape(Box::new(shape))),
    }
    .map_err(|error| chain(&error))
}

/// The edit that takes the primitives of a file.
pub(super) fn read_primitives(path: &Path) -> Result<Edit, String> {
    io::read_primitives(path).map(|stored| stored.brought_in()).map_err(|error| chain(&error))
}

/// Samples the shape.
pub(super) fn sample(shape: &Shape, sampling: SamplingOptions) -> Result<Arc<SampleCloud>, String> {
    io::sample(shape, &sampling).map(Arc::new).map_err(|error| chain(&error))
}

/// Prepares the shape for being measured against, as `evaluate` does.
pub(super) fn reference(shape: &Shape) -> Result<Reference, String> {
    io::reference(shape, &MetricOptions::default()).map_err(|error| chain(&error))
}

/// Writes a state, whole or not at all. Answers what the file can't say.
pub(super) fn export(request: &ExportRequest) -> Result<Vec<String>, String> {
    let State { loaded, snapshot } = &request.state;
    let outcome = Outcome {
        colors: &request.colors,
        shape: &loaded.shape,
        cloud: &loaded.cloud,
        sampling: loaded.sampling,
        params: &snapshot.params,
        abstraction: &snapshot.abstraction,
    };
    let written = io::export(&request.path, request.format, &request.options, &outcome);
    written.map(|exported| exported.notes).map_err(|error| chain(&error))
}

/// The error and its causes, as one text; a cause that the error already
/// quotes is not said twice.
pub(super) fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(next) = cause {
        let next_text = next.to_string();
        if !text.contains(&next_text) {
            text.push_str(": ");
            text.push_str(&next_text);
        }
        cause = next.source();
    }
    text
}
