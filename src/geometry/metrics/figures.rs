//! What is measured, and how finely.

use nalgebra::Point3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Samples that are measured one after the other.
pub(super) const CHUNK: usize = 2048;

/// How finely is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MetricOptions {
    /// Samples of each of the two surfaces.
    pub samples: usize,
    /// Points in the reference's box that volumes are counted by.
    pub volume_points: usize,
    pub seed: u64,
}

impl Default for MetricOptions {
    fn default() -> Self {
        Self { samples: 100_000, volume_points: 100_000, seed: 1 }
    }
}

impl MetricOptions {
    /// Limits of the number of samples and of volume points.
    pub const SAMPLES: (usize, usize) = (100, 10_000_000);

    /// Says which option is out of its limits, if one is.
    ///
    /// # Errors
    /// One sentence that names it and the limits.
    pub fn check(&self) -> Result<(), String> {
        let (least, most) = Self::SAMPLES;
        for (name, value) in [("samples", self.samples), ("volume points", self.volume_points)] {
            if !(least..=most).contains(&value) {
                return Err(format!(
                    "the number of {name} is {value}, but must be between {least} and {most}"
                ));
            }
        }
        Ok(())
    }
}

/// The figures of one state; lengths in units of the reference's longest edge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    pub primitives: usize,
    /// Share of the samples that belong to no primitive, where it is known.
    pub unassigned_share: Option<f64>,
    /// `None`, like its two parts, where the primitives have no surface.
    pub chamfer_l1: Option<f64>,
    /// Primitives → reference.
    pub accuracy: Option<f64>,
    /// Reference → primitives.
    pub completeness: Option<f64>,
    /// `None` where the reference encloses no volume; `iou_missing` says why.
    pub iou: Option<f64>,
    /// Standard error of the IoU, from the number of points that decide it.
    pub iou_error: Option<f64>,
    pub iou_missing: Option<String>,
    /// IoU against the reference with its hollows filled, where
    /// [`Reference::with_filled`](super::Reference::with_filled) was told what they are.
    pub iou_outside: Option<f64>,
    /// Volumes, in cubes of the longest edge: of the union and, where it has
    /// one, of the reference.
    pub volume: Option<f64>,
    pub reference_volume: Option<f64>,
    /// Share of the primitives' surface that lies inside other primitives.
    pub buried_share: Option<f64>,
}

/// Mean over points, the chunks in parallel but summed in their order.
pub(super) fn mean(points: &[Point3<f64>], sum: impl Fn(&[Point3<f64>]) -> f64 + Sync + Send) -> f64 {
    let sums: Vec<f64> = points.par_chunks(CHUNK).map(sum).collect();
    sums.iter().sum::<f64>() / points.len() as f64
}
