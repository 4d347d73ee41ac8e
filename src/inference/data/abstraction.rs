//! The result at any moment of a run, in the input's units: what leaves the
//! sampler for the screen and for files.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::geometry::Superquadric;
use crate::geometry::brief::Brief;
use crate::inference::control::InferenceError;
use crate::inference::data::known_space::Sighting;

/// The label of a point that belongs to no primitive.
pub const UNASSIGNED: u32 = u32::MAX;

/// One primitive of the abstraction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Primitive {
    /// Stable through the run: a primitive keeps its id from iteration to
    /// iteration, and no other one gets it.
    pub id: u32,
    /// Pose and shape in input units.
    pub shape: Superquadric,
    /// Noise σ, in input units.
    pub sigma: f64,
    /// Number of samples that carry this primitive's label.
    pub points: usize,
    /// Mean Euclidean distance of those samples to the surface (first order:
    /// |r|/|∇r|), in input units; 0 where there are none.
    pub mean_distance: f64,
    /// Whether the sampler leaves it and its points alone.
    #[serde(default)]
    pub locked: bool,
}

/// Which part of the run the state belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// No step has been made.
    Start,
    /// Between Gibbs iterations, or the steps of a baseline.
    Sampling,
    /// All iterations are made; merging or merged by hand.
    Merging,
    /// Nothing is left to do.
    Finished,
}

/// The clustering and the primitives at one moment, in input units.
#[derive(Clone, PartialEq)]
pub struct Abstraction {
    pub phase: Phase,
    /// Gibbs iterations, or steps of a baseline, made so far.
    pub iteration: u32,
    /// For each sample the id of its primitive, or [`UNASSIGNED`].
    pub labels: Arc<[u32]>,
    /// Samples, in ascending order, that a person has said belong to their
    /// primitive: no step changes their label. Usually none.
    pub pinned: Arc<[u32]>,
    pub primitives: Arc<[Primitive]>,
    pub figures: Figures,
    /// Whence the cloud is taken to have been seen.
    pub sighting: Sighting,
}

impl fmt::Debug for Abstraction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Abstraction")
            .field("phase", &self.phase)
            .field("iteration", &self.iteration)
            .field("labels", &Brief::of(&*self.labels))
            .field("pinned", &Brief::of(&*self.pinned))
            .field("primitives", &Brief::of_told(&self.primitives))
            .field("figures", &self.figures)
            .field("sighting", &self.sighting)
            .finish()
    }
}

impl Abstraction {
    /// Refuses the end of a run that found nothing.
    ///
    /// # Errors
    /// [`InferenceError::NoPrimitives`].
    pub fn check(&self) -> Result<(), InferenceError> {
        if self.primitives.is_empty() {
            return Err(InferenceError::NoPrimitives { points: self.labels.len() });
        }
        Ok(())
    }
}

/// Figures of one state.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Number of primitives, K.
    pub clusters: usize,
    /// Samples without a label.
    pub unassigned: usize,
    /// Mean Euclidean distance (first order) of the assigned samples to their
    /// primitive, in input units.
    pub mean_distance: f64,
    /// Log of the joint density of labels z and points x given the primitives
    /// (normalised), in nats, as the sampler's model defines it:
    ///
    /// ```text
    /// ln p(z, x | θ, σ) = ln Γ(α + w) − ln Γ(α + N) + w·ln p₀
    ///                   + Σⱼ [ln α + ln Γ(nⱼ) + Σᵢ ln(N(d(θⱼ, xᵢ); σⱼ)·½)]
    /// ```
    ///
    /// over the clusters j with nⱼ > 0 points, of N in all, w without a label.
    /// Moving one point changes it by the log of the two weights' ratio in the
    /// sweep, n·N·½ or (α + w)·p₀. `None` for a baseline, which has no such model.
    #[serde(default)]
    pub log_joint: Option<f64>,
}

/// One accepted merge and the numbers that spoke for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MergeReport {
    /// Ids of the two clusters that became one.
    pub merged: (u32, u32),
    /// Id of the cluster that stands for both (the larger one's).
    pub into: u32,
    /// What spoke for it.
    pub reason: MergeReason,
}

/// What speaks for a merge or against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MergeReason {
    /// It lowers the energy by `gain` mean spacings of error, the cost of the
    /// primitive that it saves included; below 0 it raises it.
    Energy { gain: f64 },
    /// The parameters switch merging off.
    SwitchedOff,
    /// What decided in the paper's test: a number and what it was held against.
    Paper { finding: PaperFinding, value: f64, limit: f64 },
    /// In words, as files of earlier versions have it.
    #[serde(untagged)]
    Sentence(String),
}

/// What decides the paper's merge test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PaperFinding {
    /// Against: the two fill too little of the box that holds both.
    BoxTooEmpty,
    /// Against: the two fill too little of the union's volume.
    UnionTooEmpty,
    /// For: the relative error² is no worse than that of the two alone.
    RelativeErrorNoWorse,
    /// For: the relative error² is below its limit.
    RelativeErrorSmall,
    /// For: the mean d² is below its limit.
    MeanSquareSmall,
    /// For: the mean d² is less than that of the two alone.
    MeanSquareLess,
    /// Against: both are too large; the number is the relative error².
    ErrorsTooLarge,
}

impl MergeReason {
    /// Whether it speaks for the merge.
    pub fn is_good(&self) -> bool {
        match self {
            Self::Energy { gain } => *gain > 0.0,
            Self::SwitchedOff => false,
            Self::Paper { finding, .. } => !matches!(
                finding,
                PaperFinding::BoxTooEmpty | PaperFinding::UnionTooEmpty | PaperFinding::ErrorsTooLarge
            ),
            Self::Sentence(_) => true,
        }
    }
}

/// What happened between two states.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Occurrence {
    Born {
        id: u32,
        points: usize,
    },
    Died {
        id: u32,
    },
    Split {
        id: u32,
        coverage: f64,
    },
    Separated {
        id: u32,
    },
    /// Cut in parts at the end of the run, which saves `gain` mean spacings of
    /// error, the price of the parts counted.
    Cut {
        id: u32,
        gain: f64,
    },
    Froze {
        id: u32,
    },
    Merged(MergeReport),
    /// A person has changed the primitive's shape.
    Edited {
        id: u32,
    },
    /// A person has asked to fit the primitive to its points again.
    Refitted {
        id: u32,
    },
    Locked {
        id: u32,
    },
    Unlocked {
        id: u32,
    },
    /// A person has made one primitive of these; `into` is the one that stays.
    Joined {
        ids: Vec<u32>,
        into: u32,
    },
    /// A person has had the primitive cut in two; `into` is the new one.
    Halved {
        id: u32,
        into: u32,
    },
    /// A person has deleted the primitive; so many points have lost their label.
    Deleted {
        id: u32,
        points: usize,
    },
    /// A person has made a primitive for some points.
    Created {
        id: u32,
        points: usize,
    },
    /// A person has said that some points belong to the primitive.
    Pinned {
        id: u32,
        points: usize,
    },
    /// A person has let go of some points.
    Released {
        points: usize,
    },
    /// A person has brought primitives, which stand in place of all that were.
    Taken {
        primitives: usize,
    },
}
