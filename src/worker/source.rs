//! From a source to samples: the worker's only calls into `io`.

use std::path::Path;
use std::sync::Arc;

use super::protocol::{LoadedShape, SamplingOptions, Source};
use crate::geometry::SampleCloud;
use crate::inference::Abstraction;
use crate::io::{self, Shape};

/// Reads the shape. The error is a sentence for a person.
pub(super) fn read(source: &Source) -> Result<Arc<Shape>, String> {
    let shape = match source {
        Source::File(path) => io::read(path),
        Source::BuiltIn => io::built_in(),
    };
    shape.map(Arc::new).map_err(|error| chain(&error))
}

/// Samples the shape.
pub(super) fn sample(shape: &Shape, sampling: SamplingOptions) -> Result<Arc<SampleCloud>, String> {
    io::sample(shape, sampling.points, sampling.seed).map(Arc::new).map_err(|error| chain(&error))
}

/// Writes the segmented cloud.
pub(super) fn write_cloud(path: &Path, loaded: &LoadedShape, state: &Abstraction) -> Result<(), String> {
    io::write_segmented(path, &loaded.shape, &loaded.cloud, state).map_err(|error| chain(&error))
}

/// Writes the primitives.
pub(super) fn write_primitives(path: &Path, state: &Abstraction) -> Result<(), String> {
    io::write_primitives(path, state).map_err(|error| chain(&error))
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
