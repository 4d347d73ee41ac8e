//! What a person can turn: one struct for the sliders, the command line and
//! the report.

use crate::geometry::kernel::Distance;
use serde::{Deserialize, Serialize};

/// Parameters of the inference. The defaults are the paper's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Concentration α of the Chinese Restaurant Process: the larger, the more
    /// primitives are expected a priori.
    pub alpha: f64,
    /// Density p₀ that a new primitive gives to any point, per unit of the
    /// normalised cloud.
    pub p0: f64,
    /// Number of Gibbs iterations T.
    pub iterations: u32,
    /// Number of clusters K at the start.
    pub clusters: u32,
    /// Seed of every random draw.
    pub seed: u64,
    /// Which clusters are merged, and by which test.
    pub merge: MergeRule,
    /// What one primitive costs in the description length, as a multiple of
    /// what its thirteen parameters are worth: the larger, the fewer primitives
    /// and the larger their error.
    pub primitive_cost: f64,
    /// What a fit minimises: the paper's radial distance, or its first-order
    /// correction to the Euclidean one, which does not blow up on thin plates
    /// and long rods.
    pub fit_distance: Distance,
    /// Freeze the points of well fitted clusters (a speed-up of the authors'
    /// program that also locks mistakes in).
    pub freeze: bool,
    /// After the last iteration, refine by descent on the description length:
    /// assign every point that is no outlier, refit, split and merge until
    /// nothing changes.
    pub refine: bool,
}

/// The test by which two clusters become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
pub enum MergeRule {
    /// No merging.
    None,
    /// The thresholds of the authors' program, largest cluster first.
    Paper,
    /// The pair that shortens the description of the cloud most, first.
    #[default]
    DescriptionLength,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            alpha: 0.5,
            p0: 0.1,
            iterations: 30,
            clusters: 30,
            seed: 1,
            merge: MergeRule::DescriptionLength,
            primitive_cost: 1.0,
            fit_distance: Distance::FirstOrder,
            freeze: false,
            refine: true,
        }
    }
}

impl Params {
    /// Limits of each parameter, as sliders and the command line offer them.
    pub const ALPHA: (f64, f64) = (1e-3, 100.0);
    pub const P0: (f64, f64) = (1e-6, 10.0);
    pub const ITERATIONS: (u32, u32) = (1, 500);
    pub const CLUSTERS: (u32, u32) = (1, 500);
    pub const PRIMITIVE_COST: (f64, f64) = (0.1, 10.0);

    /// The steps and defaults of the paper and its authors' program.
    pub fn paper() -> Self {
        Self {
            merge: MergeRule::Paper,
            fit_distance: Distance::Radial,
            freeze: true,
            refine: false,
            ..Self::default()
        }
    }

    /// Says which parameter is out of its limits, if one is.
    pub fn check(&self) -> Result<(), String> {
        fn within<T: PartialOrd + std::fmt::Display>(
            name: &str,
            value: T,
            (low, high): (T, T),
        ) -> Result<(), String> {
            if value >= low && value <= high {
                Ok(())
            } else {
                Err(format!("{name} is {value}, but must lie between {low} and {high}"))
            }
        }
        within("alpha", self.alpha, Self::ALPHA)?;
        within("p0", self.p0, Self::P0)?;
        within("iterations", self.iterations, Self::ITERATIONS)?;
        within("clusters", self.clusters, Self::CLUSTERS)?;
        within("primitive cost", self.primitive_cost, Self::PRIMITIVE_COST)
    }
}
