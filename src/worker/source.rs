//! The worker's only calls into `io`, with errors as sentences for a person.

use std::path::Path;
use std::sync::Arc;

use super::protocol::{SamplingOptions, Source, State};
use crate::geometry::SampleCloud;
use crate::geometry::metrics::{MetricOptions, Reference};
use crate::geometry::palette::Colors;
use crate::io::{self, Outcome, Shape};

/// Reads the shape.
pub(super) fn read(source: &Source) -> Result<Arc<Shape>, String> {
    let shape = match source {
        Source::File(path) => io::read(path),
        Source::BuiltIn => io::built_in(),
    };
    shape.map(Arc::new).map_err(|error| chain(&error))
}

/// Samples the shape.
pub(super) fn sample(shape: &Shape, sampling: SamplingOptions) -> Result<Arc<SampleCloud>, String> {
    io::sample(shape, &sampling).map(Arc::new).map_err(|error| chain(&error))
}

/// Prepares the shape for being measured against, as `evaluate` does.
pub(super) fn reference(shape: &Shape) -> Result<Reference, String> {
    io::reference(shape, &MetricOptions::default()).map_err(|error| chain(&error))
}

/// What can be written of a state.
#[derive(Debug, Clone, Copy)]
pub(super) enum Part<'a> {
    /// In these colours.
    Cloud(&'a Colors),
    Primitives,
}

impl Part<'_> {
    /// For people.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Cloud(_) => "segmented cloud",
            Self::Primitives => "primitives",
        }
    }
}

/// Writes a part of the state, whole or not at all.
pub(super) fn write(part: Part<'_>, path: &Path, state: &State) -> Result<(), String> {
    let State { loaded, snapshot } = state;
    let plain = Colors::default();
    let colors = if let Part::Cloud(colors) = part { colors } else { &plain };
    let outcome = Outcome {
        colors,
        shape: &loaded.shape,
        cloud: &loaded.cloud,
        sampling: loaded.sampling,
        params: &snapshot.params,
        abstraction: &snapshot.abstraction,
    };
    match part {
        Part::Cloud(_) => io::write_segmented_ply(path, &outcome),
        Part::Primitives => io::write_primitives_json(path, &outcome),
    }
    .map_err(|error| chain(&error))
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
