//! Methods by name: the program's own, and those that the paper is measured
//! against.

use serde::{Deserialize, Serialize};

use crate::geometry::kernel::Distance;
use crate::inference::params::{Algorithm, MergeRule, Params};

impl Params {
    /// Iterations or steps of a whole run; `None` where nobody can know.
    pub fn steps(&self) -> Option<u32> {
        match self.algorithm {
            Algorithm::Sampler => Some(self.iterations),
            Algorithm::KMeans => Some(self.clusters),
            Algorithm::Ems | Algorithm::HierarchicalEms => None,
        }
    }
}

/// A named way to run: the program's best, the paper's, and the baselines of
/// the paper's table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    Default,
    Paper,
    WithoutMerge,
    #[serde(rename = "kmeans")]
    KMeans,
    Ems,
    HierarchicalEms,
}

impl Method {
    pub const ALL: [Self; 6] =
        [Self::Default, Self::Paper, Self::WithoutMerge, Self::KMeans, Self::Ems, Self::HierarchicalEms];

    /// For the command line and for files; never changes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Paper => "paper",
            Self::WithoutMerge => "without-merge",
            Self::KMeans => "kmeans",
            Self::Ems => "ems",
            Self::HierarchicalEms => "hierarchical-ems",
        }
    }

    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Default => "Default",
            Self::Paper => "Paper",
            Self::WithoutMerge => "Paper without merging",
            Self::KMeans => "K-means",
            Self::Ems => "One primitive (EMS)",
            Self::HierarchicalEms => "Hierarchical EMS",
        }
    }

    /// What it does, in one sentence.
    pub fn tooltip(self) -> &'static str {
        match self {
            Self::Default => {
                "The paper's sampler, with merging and refinement by two-way error and cost of primitives. Gives \
                 the best results"
            }
            Self::Paper => "The steps, thresholds and defaults of the paper and its authors' program",
            Self::WithoutMerge => "The paper's sampler without merging",
            Self::KMeans => "K clusters by k-means, each fitted with one primitive",
            Self::Ems => {
                "One primitive for the whole shape. Points that it does not explain are outliers and stay \
                 unassigned"
            }
            Self::HierarchicalEms => {
                "One primitive with outliers, then one for each connected part of the outliers, and so on"
            }
        }
    }

    /// Where it was published.
    pub fn reference(self) -> &'static str {
        match self {
            Self::Default | Self::Paper | Self::WithoutMerge => {
                "Wu et al., Primitive-based Shape Abstraction via Nonparametric Bayesian Inference, ECCV 2022"
            }
            Self::KMeans => "A baseline in the table of Wu et al., ECCV 2022",
            Self::Ems | Self::HierarchicalEms => {
                "Liu et al., Robust and Accurate Superquadric Recovery: a Probabilistic Approach, CVPR 2022"
            }
        }
    }

    /// The parameters that make a run this method.
    pub fn params(self) -> Params {
        let baseline = |algorithm| Params { algorithm, fit_distance: Distance::Radial, ..Params::default() };
        match self {
            Self::Default => Params::default(),
            Self::Paper => Params::paper(),
            Self::WithoutMerge => Params { merge: MergeRule::None, ..Params::paper() },
            Self::KMeans => baseline(Algorithm::KMeans),
            Self::Ems => baseline(Algorithm::Ems),
            // All but the part at hand is an outlier.
            Self::HierarchicalEms => Params { outlier_prior: 0.9, ..baseline(Algorithm::HierarchicalEms) },
        }
    }

    /// The method that a run with these parameters is, whatever the numbers it
    /// is tuned with; `None` where its parts are combined in another way.
    pub fn of(params: &Params) -> Option<Self> {
        Self::ALL.into_iter().find(|method| {
            let named = method.params();
            let tuned = named.tuned_as(params);
            // What a baseline doesn't read can't make it another method.
            let is_baseline = params.algorithm != Algorithm::Sampler;
            if is_baseline { params.algorithm == named.algorithm } else { tuned == *params }
        })
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for Method {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|m| m.name() == name).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|m| m.name()).collect();
            format!("there is no method {name}; there are {}", names.join(", "))
        })
    }
}
