//! What a person can turn: one struct for the sliders, the command line and
//! the report.

use crate::geometry::kernel::Distance;
use serde::{Deserialize, Serialize};

/// A cluster needs more points than this, all in one connected component.
pub(crate) const SMALLEST_CLUSTER: usize = 20;

/// Parameters of the inference. By default α, p₀, T and K have the paper's
/// values, whereas merging, the distance of the fits, freezing and refining are
/// the program's own: [`Params::paper`] has the paper's there, too.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// What the run computes with; the other parameters say how, as far as it
    /// reads them ([`Params::reads`]).
    pub algorithm: Algorithm,
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
    /// What is known of the space around the cloud.
    pub seen_from: SeenFrom,
    /// What one primitive costs in the energy (two-way error and cost of
    /// primitives), as a multiple of the default: the larger, the fewer
    /// primitives and the larger their error.
    pub primitive_cost: f64,
    /// What a fit minimises: the paper's radial distance, or its first-order
    /// correction to the Euclidean one, which does not blow up on thin plates
    /// and long rods.
    pub fit_distance: Distance,
    /// Freeze the points of well fitted clusters (a speed-up of the authors'
    /// program that also locks mistakes in).
    pub freeze: bool,
    /// After the last iteration, refine by descent on the energy: assign every
    /// point that is no outlier, refit in both directions, cut, merge and remove
    /// until nothing lowers it.
    pub refine: bool,
    /// Probability w₀ that EMS gives a point, before it has seen it, of being an
    /// outlier.
    pub outlier_prior: f64,
}

/// What a run computes with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
pub enum Algorithm {
    /// Gibbs sampling under a Chinese Restaurant Process.
    #[default]
    Sampler,
    /// K clusters by k-means, and one fit to each.
    #[serde(rename = "kmeans")]
    KMeans,
    /// One primitive with a class of outliers.
    Ems,
    /// One primitive after another, each with a class of outliers, until little
    /// is left.
    HierarchicalEms,
}

impl Algorithm {
    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Sampler => "Sampler",
            Self::KMeans => "K-means",
            Self::Ems => "EMS",
            Self::HierarchicalEms => "Hierarchical EMS",
        }
    }
}

/// The test by which two clusters become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
pub enum MergeRule {
    /// No merging.
    None,
    /// The thresholds of the authors' program, largest cluster first.
    Paper,
    /// The pair that lowers the energy most, first: two-way error and cost of
    /// primitives.
    #[default]
    Energy,
}

/// Whence a cloud is taken to have been seen. What nobody saw is unknown: it may
/// hold surface without points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SeenFrom {
    /// From its viewpoints where they are known; from one side where that shows
    /// all points; from all sides otherwise.
    #[default]
    Auto,
    /// From all sides: a place without points is empty.
    All,
    /// From its viewpoints where they are known, and otherwise from the
    /// side that shows most points.
    OneSide,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            algorithm: Algorithm::Sampler,
            alpha: 0.5,
            p0: 0.1,
            iterations: 30,
            clusters: 30,
            seed: 1,
            merge: MergeRule::Energy,
            seen_from: SeenFrom::Auto,
            primitive_cost: 1.0,
            fit_distance: Distance::FirstOrder,
            freeze: false,
            refine: true,
            outlier_prior: 0.5,
        }
    }
}

impl Params {
    /// The steps of the paper and the thresholds of its authors' program.
    pub fn paper() -> Self {
        Self {
            merge: MergeRule::Paper,
            fit_distance: Distance::Radial,
            freeze: true,
            refine: false,
            ..Self::default()
        }
    }
}
