//! What a person may change in the state of the sampler.

use serde::{Deserialize, Serialize};

use super::abstraction::Occurrence;
use super::proposal::MergeProposal;
use super::sampler::{Cancel, InferenceError, Sampler};
use crate::geometry::Superquadric;

/// A change by hand. Primitives are told by id, samples by their index in the
/// cloud; lengths are in input units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Edit {
    /// Gives a primitive another shape, in input units; its points and σ stay.
    SetShape { id: u32, shape: Superquadric },
    /// Fits a primitive to its points; σ follows.
    Refit { id: u32 },
    /// Lets the sampler leave a primitive and its points alone, or no more.
    Lock { id: u32, locked: bool },
    /// Makes one primitive, fitted to all their points, of two or more,
    /// whatever the test says; the largest one's id stays.
    Merge { ids: Vec<u32> },
    /// Makes one primitive, exactly the shown one, of two.
    AcceptMerge { proposal: Box<MergeProposal> },
    /// Cuts a primitive in two, the best of a few cuts; the larger part keeps
    /// the id.
    Split { id: u32 },
    /// Deletes primitives; their points become unassigned.
    Delete { ids: Vec<u32> },
    /// Takes samples out of their clusters and makes them one of their own.
    NewCluster { samples: Vec<u32> },
    /// "These belong together": all join the primitive that holds most of them,
    /// or a new one if none does, which is fitted again, and they are pinned:
    /// no step takes them from it.
    Together { samples: Vec<u32> },
    /// Lets go of pinned samples.
    Release { samples: Vec<u32> },
}

impl Sampler {
    pub(super) fn edit(&mut self, edit: &Edit, cancel: &Cancel) -> Result<Vec<Occurrence>, InferenceError> {
        let _ = (edit, cancel);
        Err(InferenceError::Edit("not yet".to_owned()))
    }

    pub(super) fn resample(&mut self, more: u32) -> Result<(), InferenceError> {
        let _ = more;
        Err(InferenceError::Edit("not yet".to_owned()))
    }
}
