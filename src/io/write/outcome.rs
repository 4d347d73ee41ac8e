//! What files are made of.

use crate::geometry::palette::Colors;
use crate::geometry::{SampleCloud, SamplingOptions};
use crate::inference::{Abstraction, Params};
use crate::io::primitives::PrimitiveSet;
use crate::io::shape::Shape;

/// A state of a run with its inputs, from which the files are written.
#[derive(Debug, Clone, Copy)]
pub struct Outcome<'a> {
    /// Of the primitives and their points.
    pub colors: &'a Colors,
    pub shape: &'a Shape,
    pub cloud: &'a SampleCloud,
    pub sampling: SamplingOptions,
    pub params: &'a Params,
    pub abstraction: &'a Abstraction,
}

impl<'a> From<&Outcome<'a>> for PrimitiveSet<'a> {
    fn from(outcome: &Outcome<'a>) -> Self {
        let Outcome { shape, cloud, abstraction, colors, params, .. } = *outcome;
        Self {
            primitives: &abstraction.primitives,
            colors,
            input: Some(&shape.name),
            points: Some(cloud.points.len()),
            samples: Some((&cloud.points, &abstraction.labels)),
            sampling_seed: Some(outcome.sampling.seed),
            seed: Some(params.seed),
            params: Some(params),
        }
    }
}
