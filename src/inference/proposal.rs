//! Merges before they are made: the union and the test's numbers, to be looked
//! at, accepted or skipped.

use serde::{Deserialize, Serialize};

use super::merge::Union;
use super::sampler::{Cancel, InferenceError, Sampler};
use crate::geometry::Superquadric;

/// One primitive that would stand for two, and what speaks for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MergeProposal {
    /// Ids of the two primitives.
    pub pair: (u32, u32),
    /// The id that would stay: the larger one's.
    pub into: u32,
    /// The one in their place, in input units.
    pub union: Superquadric,
    /// The same in the normalised frame: accepting it gives exactly this.
    pub normalised: Union,
    /// The states of the two that it was made of, by revision: once they have
    /// changed it can't be accepted any more.
    pub revisions: (u64, u64),
    /// Whether the rule in force would make this merge.
    pub is_acceptable: bool,
    /// Why it would or wouldn't: one sentence with numbers.
    pub reason: String,
    /// What the rule looks at.
    pub numbers: Vec<TestNumber>,
}

/// One number of a test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TestNumber {
    /// Short, for a label.
    pub name: String,
    pub value: f64,
    /// What it is held against, if it decides.
    pub threshold: Option<f64>,
    /// May be empty.
    pub unit: String,
    /// Whether it speaks for the merge, where it decides.
    pub is_good: Option<bool>,
    /// What it is and which side of the threshold is good, for a tooltip.
    pub meaning: String,
}

impl Sampler {
    pub(super) fn propose_merge(
        &mut self,
        skipped: &[(u32, u32)],
        cancel: &Cancel,
    ) -> Result<Option<MergeProposal>, InferenceError> {
        let _ = (skipped, cancel);
        Ok(None)
    }

    pub(super) fn propose_merge_of(
        &mut self,
        a: u32,
        b: u32,
        cancel: &Cancel,
    ) -> Result<MergeProposal, InferenceError> {
        let _ = (a, b, cancel);
        Err(InferenceError::Edit("not yet".to_owned()))
    }
}
