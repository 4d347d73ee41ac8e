//! Primitives as they are written.

use std::io;

use nalgebra::Point3;

use crate::geometry::palette::Colors;
use crate::inference::{Params, Primitive};
use crate::io::write::unfit;

/// Primitives with what is known of where they come from.
#[derive(Debug, Clone, Copy)]
pub struct PrimitiveSet<'a> {
    pub primitives: &'a [Primitive],
    pub colors: &'a Colors,
    /// Name of the shape that they stand for.
    pub input: Option<&'a str>,
    /// Number of samples that they were made from.
    pub points: Option<usize>,
    /// The samples, and for each the id of its primitive.
    pub samples: Option<(&'a [Point3<f64>], &'a [u32])>,
    pub sampling_seed: Option<u64>,
    /// Seed of the run.
    pub seed: Option<u64>,
    pub params: Option<&'a Params>,
}

/// Rejects invalid primitives.
pub(in crate::io) fn checked(p: &Primitive) -> io::Result<&Primitive> {
    if p.shape.is_valid() && p.sigma.is_finite() && p.mean_distance.is_finite() {
        return Ok(p);
    }
    Err(unfit(format!("primitive {} has an invalid parameter", p.id)))
}
