//! Merges before they are made: the union and the test's numbers, to be looked
//! at, accepted or skipped.

use std::collections::BTreeSet;
use std::fmt;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::Superquadric;
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::data::abstraction::MergeReason;
use crate::inference::data::state::State;
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::moves::configuration::Configuration;
use crate::inference::moves::merge::{first_by_thresholds, in_order_of_size};
use crate::inference::moves::merge_search::MergeSearch;
use crate::inference::moves::paper_merge_test::{FILL, Pair, RELATIVE};
use crate::inference::moves::union_cache::Union;
use crate::inference::objective::energy;
use crate::inference::objective::energy::PrimitiveTerms;
use crate::inference::params::MergeRule;

/// One primitive that would stand for two, and what speaks for it.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub struct MergeProposal {
    /// Ids of the two primitives.
    pub pair: (u32, u32),
    /// The id that would stay: that of the one with more points.
    pub into: u32,
    /// The one in their place, in input units.
    pub union: Superquadric,
    /// The same in the normalised frame: accepting it gives exactly this.
    pub normalised: Union,
    /// The states of the two that it was made of, by revision: once they have
    /// changed it can't be accepted any more.
    pub revisions: (u64, u64),
    /// Whether it passes the test of the rule in force. (Merging by energy gives
    /// pairs up that promise nothing at first glance; one of these may turn out
    /// to be acceptable when it is looked at here.)
    pub is_acceptable: bool,
    /// What speaks for it, or against it.
    pub reason: MergeReason,
    /// What the rule looks at.
    pub numbers: Vec<TestNumber>,
}

impl fmt::Debug for MergeProposal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MergeProposal")
            .field("pair", &self.pair)
            .field("into", &self.into)
            .field("revisions", &self.revisions)
            .field("is_acceptable", &self.is_acceptable)
            .field("reason", &self.reason)
            .finish_non_exhaustive()
    }
}

/// One number of a test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TestNumber {
    pub quantity: TestQuantity,
    pub value: f64,
    /// What it is held against, if it decides.
    pub threshold: Option<f64>,
    /// Whether it speaks for the merge, where it decides.
    pub is_good: Option<bool>,
}

/// What a test measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TestQuantity {
    /// Mean distance between the cloud and all primitives, both ways, in mean
    /// spacings.
    ErrorBefore,
    /// The same with one primitive in the place of the two.
    ErrorAfter,
    /// The cost of a primitive, in mean spacings.
    CostSaved,
    /// Error before plus cost saved, less the error after.
    Gain,
    /// Volume of the two parts' boxes against the box that holds both.
    BoxFill,
    /// Volume of the two primitives against that of the union.
    VolumeFill,
    /// Mean of (r/|q|)².
    RelativeError,
    /// Mean squared radial distance, in normalised units.
    MeanSquare,
}

impl TestNumber {
    fn new(quantity: TestQuantity, value: f64) -> Self {
        Self { quantity, value, threshold: None, is_good: None }
    }

    /// The same, with what it is held against and the side on which it lies.
    fn judged(self, threshold: f64, is_good: bool) -> Self {
        Self { threshold: Some(threshold), is_good: Some(is_good), ..self }
    }
}

/// What the rule says of one pair.
struct Judged {
    union: Union,
    is_acceptable: bool,
    reason: MergeReason,
    numbers: Vec<TestNumber>,
}

fn is_skipped(state: &State, skipped: &BTreeSet<(u32, u32)>, (a, b): (usize, usize)) -> bool {
    let (a, b) = (state.clusters[a].id, state.clusters[b].id);
    skipped.contains(&(a.min(b), a.max(b)))
}

impl Sampler {
    pub(crate) fn propose_merge(
        &mut self,
        skipped: &[(u32, u32)],
        cancel: &Cancel,
    ) -> Result<Option<MergeProposal>, InferenceError> {
        let skipped: BTreeSet<(u32, u32)> = skipped.iter().map(|&(a, b)| (a.min(b), a.max(b))).collect();
        let found = match self.params.merge {
            MergeRule::Paper => self.best_by_thresholds(&skipped, cancel),
            MergeRule::Energy | MergeRule::None => self.best_by_energy(&skipped, cancel),
        };
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        Ok(found.map(|(pair, judged)| self.proposal(pair, judged)))
    }

    pub(crate) fn propose_merge_of(
        &mut self,
        a: u32,
        b: u32,
        cancel: &Cancel,
    ) -> Result<MergeProposal, InferenceError> {
        let pair = self.in_order(self.unlocked(a)?, self.unlocked(b)?);
        if a == b {
            return Err(InferenceError::Edit("a merge needs two primitives; select another one".to_owned()));
        }
        let judged = match self.params.merge {
            MergeRule::Paper => self.judge_by_thresholds(pair, cancel),
            MergeRule::Energy | MergeRule::None => {
                let configuration = Configuration::of(&self.state.model, &self.state, &self.params, cancel);
                self.judge_by_energy(&configuration, configuration.energy(), pair, None)
            }
        };
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        let judged = judged
            .ok_or_else(|| InferenceError::Edit(format!("no primitive fits the points of {a} and {b}")))?;
        Ok(self.proposal(pair, judged))
    }

    /// The pair in the order in which the rule looks at it, and remembers it.
    fn in_order(&self, a: usize, b: usize) -> (usize, usize) {
        let (first, second) = (a.min(b), a.max(b));
        let is_larger = self.size(second) > self.size(first);
        if self.params.merge == MergeRule::Paper && is_larger { (second, first) } else { (first, second) }
    }

    fn size(&self, cluster: usize) -> usize {
        self.state.labels.iter().filter(|l| **l as usize == cluster).count()
    }

    fn proposal(&self, (a, b): (usize, usize), judged: Judged) -> MergeProposal {
        let [first, second] = [a, b].map(|j| &self.state.clusters[j]);
        let Judged { union, is_acceptable, reason, numbers } = judged;
        MergeProposal {
            pair: (first.id, second.id),
            into: if self.size(b) > self.size(a) { second.id } else { first.id },
            union: self.state.model.normalization.shape(&union.shape),
            normalised: Union { reason: reason.clone(), ..union },
            revisions: (first.revision, second.revision),
            is_acceptable,
            reason,
            numbers,
        }
    }

    /// The pair of neighbours whose merge saves most, even if that is less than
    /// nothing.
    fn best_by_energy(
        &mut self,
        skipped: &BTreeSet<(u32, u32)>,
        cancel: &Cancel,
    ) -> Option<((usize, usize), Judged)> {
        let state = &self.state;
        let mut search = MergeSearch::new(&state.model, state, &self.params, cancel);
        let allowed = |a: usize, b: usize| !is_skipped(state, skipped, (a, b));
        let best = search.best(|list| matches!(*list, [a, b] if allowed(a, b)));
        let found = best.as_ref().map(|(_, proposal)| proposal.added[0].shape);
        let configuration = &search.configuration;
        let before = configuration.energy();
        // Where no pair is worth a fit, that which looks best at a rough one.
        let pair = best.map(|(list, _)| (list[0], list[1])).or_else(|| {
            let left: Vec<(usize, usize)> =
                configuration.neighbors().into_iter().filter(|&(a, b)| allowed(a, b)).collect();
            let rises = left
                .into_par_iter()
                .filter_map(|(a, b)| Some((configuration.any_rough_union(&[a, b], before)?.rise, (a, b))));
            let rises: Vec<(f64, (usize, usize))> = rises.collect();
            rises.into_iter().min_by(|x, y| x.0.total_cmp(&y.0)).map(|best| best.1)
        })?;
        Some((pair, self.judge_by_energy(configuration, before, pair, found)?))
    }

    /// `found` is the union, where the search has fitted it.
    fn judge_by_energy(
        &self,
        configuration: &Configuration<'_>,
        before: f64,
        (a, b): (usize, usize),
        found: Option<Superquadric>,
    ) -> Option<Judged> {
        let model = configuration.model;
        let shape = match found {
            Some(shape) => shape,
            None => configuration.any_union(&[a, b])?,
        };
        let sum_d2 = model.sum_d2(&shape, &configuration.union(&[a, b]));
        let scale = energy::scale(model);
        let count = configuration.primitives().len();
        let [price, cheaper] =
            [count, count - 1].map(|k| energy::price(model, configuration.params, k) / scale);
        let after = configuration.energy_with(&[a, b], &[PrimitiveTerms::new(model, shape)]);
        let gain = (before - after) / scale;
        let is_off = configuration.params.merge == MergeRule::None;
        let reason = if is_off { MergeReason::SwitchedOff } else { MergeReason::Energy { gain } };
        let numbers = vec![
            TestNumber::new(TestQuantity::ErrorBefore, before / scale - price),
            TestNumber::new(TestQuantity::ErrorAfter, after / scale - cheaper),
            TestNumber::new(TestQuantity::CostSaved, price - cheaper),
            TestNumber::new(TestQuantity::Gain, gain).judged(0.0, gain > 0.0),
        ];
        let union = Union { shape, sum_d2, reason: reason.clone() };
        Some(Judged { union, is_acceptable: gain > 0.0 && !is_off, reason, numbers })
    }

    /// The first pair in the paper's order that passes, else of the neighbours
    /// that which fills its box best.
    fn best_by_thresholds(
        &mut self,
        skipped: &BTreeSet<(u32, u32)>,
        cancel: &Cancel,
    ) -> Option<((usize, usize), Judged)> {
        let state = &self.state;
        let members = state.members();
        let mut pairs = in_order_of_size(state, &members);
        pairs.retain(|&pair| !is_skipped(&self.state, skipped, pair));
        let found = first_by_thresholds(state, &members, &pairs, &mut self.cache, &self.params, cancel);
        let pair = match found {
            Some((a, b, _)) => (a, b),
            None => {
                let near = Configuration::of(&state.model, state, &self.params, cancel).neighbors();
                pairs.retain(|&(a, b)| near.contains(&(a.min(b), a.max(b))));
                let fills = pairs.into_iter().map(|(a, b)| (Pair::new(state, &members, a, b).fill(), (a, b)));
                fills.max_by(|x, y| x.0.total_cmp(&y.0))?.1
            }
        };
        Some((pair, self.judge_by_thresholds(pair, cancel)?))
    }

    fn judge_by_thresholds(&self, (a, b): (usize, usize), cancel: &Cancel) -> Option<Judged> {
        let state = &self.state;
        let members = state.members();
        let pair = Pair::new(state, &members, a, b);
        let known = self.cache.get((state.clusters[a].revision, state.clusters[b].revision));
        let shape = match known {
            Some(union) => union.shape,
            None => pair.fit(&self.params, cancel)?,
        };
        let measured = pair.measure(&shape);
        // What was found acceptable stays so until the pair changes.
        let reason = known.map_or_else(|| measured.verdict(), |union| union.reason.clone());
        let relative_limit = RELATIVE.max(measured.worse_relative);
        let mean_limit = measured.limit.max(measured.worse_mean_d2);
        let numbers = vec![
            TestNumber::new(TestQuantity::BoxFill, measured.fill).judged(FILL, measured.fill >= FILL),
            TestNumber::new(TestQuantity::VolumeFill, measured.volumes)
                .judged(FILL, measured.volumes >= FILL),
            TestNumber::new(TestQuantity::RelativeError, measured.relative).judged(
                relative_limit,
                measured.relative < RELATIVE || measured.relative <= measured.worse_relative,
            ),
            TestNumber::new(TestQuantity::MeanSquare, measured.mean_d2).judged(
                mean_limit,
                measured.mean_d2 < measured.limit || measured.mean_d2 < measured.worse_mean_d2,
            ),
        ];
        let is_acceptable = reason.is_good();
        Some(Judged { union: pair.union(shape, &measured, reason.clone()), is_acceptable, reason, numbers })
    }
}
