//! Methods by name: the program's own, and those that the paper is measured
//! against.

use serde::{Deserialize, Serialize};

use super::params::{MergeRule, Params};
use crate::geometry::kernel::Distance;

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

/// A parameter that some algorithms read and others don't.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    Alpha,
    P0,
    Iterations,
    Clusters,
    Seed,
    Merge,
    PrimitiveCost,
    FitDistance,
    Freeze,
    Refine,
    OutlierPrior,
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

impl Params {
    /// Whether a run with these parameters looks at `setting`.
    pub fn reads(&self, setting: Setting) -> bool {
        match self.algorithm {
            Algorithm::Sampler => match setting {
                Setting::PrimitiveCost => self.merge == MergeRule::Energy || self.refine,
                Setting::OutlierPrior => false,
                _ => true,
            },
            Algorithm::KMeans => matches!(setting, Setting::Clusters | Setting::Seed | Setting::FitDistance),
            Algorithm::Ems => matches!(setting, Setting::FitDistance | Setting::OutlierPrior),
            Algorithm::HierarchicalEms => {
                matches!(setting, Setting::Seed | Setting::FitDistance | Setting::OutlierPrior)
            }
        }
    }

    /// Iterations or steps of a whole run; `None` where nobody can know.
    pub fn steps(&self) -> Option<u32> {
        match self.algorithm {
            Algorithm::Sampler => Some(self.iterations),
            Algorithm::KMeans => Some(self.clusters),
            Algorithm::Ems | Algorithm::HierarchicalEms => None,
        }
    }

    /// Why a run with these parameters doesn't look at `setting`; `None` where
    /// it does.
    pub fn why_unread(&self, setting: Setting) -> Option<String> {
        (!self.reads(setting)).then(|| match (self.algorithm, setting) {
            (Algorithm::Sampler, Setting::OutlierPrior) => {
                "The sampler has no class of outliers; EMS and hierarchical EMS read this".to_owned()
            }
            (Algorithm::Sampler, _) => {
                "Only merging by energy and the refinement at the end read this".to_owned()
            }
            (other, _) => format!("{} doesn't read this", other.title()),
        })
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
                "The paper's sampler, merged and refined by two-way error and cost of primitives: the best \
                 results"
            }
            Self::Paper => "The steps, thresholds and defaults of the paper and its authors' program",
            Self::WithoutMerge => "The paper's sampler, whose primitives stay unmerged",
            Self::KMeans => "K clusters by k-means, and one fit to each",
            Self::Ems => {
                "One primitive for the whole shape; points that it doesn't explain are outliers and stay \
                 unassigned"
            }
            Self::HierarchicalEms => {
                "One primitive with outliers, then one for each part of the outliers, and so on"
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
            let tuned = Params {
                alpha: params.alpha,
                p0: params.p0,
                iterations: params.iterations,
                clusters: params.clusters,
                seed: params.seed,
                primitive_cost: params.primitive_cost,
                outlier_prior: params.outlier_prior,
                ..named
            };
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
