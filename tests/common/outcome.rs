//! Runs as they may end, without having run.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use superform::geometry::palette::Colors;
use superform::geometry::{SampleCloud, SamplingOptions, Superquadric};
use superform::inference::{Abstraction, Figures, Params, Phase, Primitive, Sighting, UNASSIGNED};
use superform::io::{self, Outcome, Shape};

/// A finished run whose samples are dealt in turn.
pub(crate) struct Run {
    pub(crate) colors: Colors,
    pub(crate) shape: Shape,
    pub(crate) cloud: SampleCloud,
    pub(crate) params: Params,
    pub(crate) abstraction: Abstraction,
}

impl Run {
    /// `dealt` are the ids of the primitives, and [`UNASSIGNED`].
    pub(crate) fn on(
        shape: Shape,
        points: usize,
        dealt: &[u32],
        primitive: impl Fn(u32) -> Superquadric,
    ) -> Self {
        let cloud = io::sample(&shape, &SamplingOptions { points, ..SamplingOptions::default() }).unwrap();
        let labels: Arc<[u32]> = (0..cloud.points.len()).map(|i| dealt[i % dealt.len()]).collect();
        let primitives = dealt.iter().filter(|&&id| id != UNASSIGNED).map(|&id| Primitive {
            id,
            shape: primitive(id),
            sigma: 0.125,
            points: labels.iter().filter(|&&l| l == id).count(),
            mean_distance: 0.01,
            locked: false,
        });
        let primitives: Arc<[Primitive]> = primitives.collect();
        let unassigned = labels.iter().filter(|&&l| l == UNASSIGNED).count();
        let clusters = primitives.len();
        let abstraction = Abstraction {
            phase: Phase::Finished,
            iteration: 2,
            primitives,
            figures: Figures { clusters, unassigned, mean_distance: 0.01, log_joint: None },
            pinned: [].into(),
            sighting: Sighting::default(),
            labels,
        };
        Self { shape, cloud, params: Params::default(), abstraction, colors: Colors::default() }
    }

    pub(crate) fn outcome(&self) -> Outcome<'_> {
        Outcome {
            colors: &self.colors,
            shape: &self.shape,
            cloud: &self.cloud,
            sampling: SamplingOptions::default(),
            params: &self.params,
            abstraction: &self.abstraction,
        }
    }
}

/// What is in a folder, by name.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|f| f.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
