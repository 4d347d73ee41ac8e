//! Merges before they are made: the union and the test's numbers, to be looked
//! at, accepted or skipped.

use std::collections::BTreeSet;
use std::fmt;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::Superquadric;
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::data::state::State;
use crate::inference::gibbs::sampler::Sampler;
use crate::inference::moves::configuration::Configuration;
use crate::inference::moves::merge::{first_by_thresholds, gains, in_order_of_size};
use crate::inference::moves::paper_merge_test::{FILL, Pair, RELATIVE};
use crate::inference::moves::search::merge_reason;
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
    /// Why it would or wouldn't: one sentence with numbers.
    pub reason: String,
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

impl TestNumber {
    fn new(name: &str, value: f64, threshold: Option<f64>, unit: &str, meaning: &str) -> Self {
        let [name, unit, meaning] = [name, unit, meaning].map(str::to_owned);
        Self { name, value, threshold, unit, is_good: None, meaning }
    }

    /// The same, with the side of the threshold on which it lies.
    fn judged(self, is_good: bool) -> Self {
        Self { is_good: Some(is_good), ..self }
    }
}

/// What the rule says of one pair.
struct Judged {
    union: Union,
    is_acceptable: bool,
    reason: String,
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
                self.judge_by_energy(&configuration, configuration.energy(), pair)
            }
        };
        if cancel.is_requested() {
            return Err(InferenceError::Cancelled);
        }
        let judged = judged.ok_or_else(|| {
            InferenceError::Edit(format!("no primitive can be fitted to the points of {a} and {b}"))
        })?;
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
        let configuration = Configuration::of(&self.state.model, &self.state, &self.params, cancel);
        let before = configuration.energy();
        let pairs = configuration.neighbors();
        let known = gains(&self.state, &configuration, &pairs, before, &mut self.cache)?;
        let known = known.iter().filter(|(_, pair, _)| !is_skipped(&self.state, skipped, *pair));
        let best = known.max_by(|x, y| x.0.total_cmp(&y.0)).map(|best| best.1);
        // Where no pair is worth a fit, that which looks best at first glance.
        let pair = best.or_else(|| {
            let left: Vec<(usize, usize)> =
                pairs.into_iter().filter(|&pair| !is_skipped(&self.state, skipped, pair)).collect();
            let rises = left
                .into_par_iter()
                .filter_map(|(a, b)| Some((configuration.any_rough_union(&[a, b], before)?.rise, (a, b))));
            let rises: Vec<(f64, (usize, usize))> = rises.collect();
            rises.into_iter().min_by(|x, y| x.0.total_cmp(&y.0)).map(|best| best.1)
        })?;
        Some((pair, self.judge_by_energy(&configuration, before, pair)?))
    }

    fn judge_by_energy(
        &self,
        configuration: &Configuration<'_>,
        before: f64,
        (a, b): (usize, usize),
    ) -> Option<Judged> {
        let model = configuration.model;
        let clusters = &self.state.clusters;
        let union = match self.cache.get((clusters[a].revision, clusters[b].revision)) {
            Some(known) => known.clone(),
            None => {
                let (shape, points) = configuration.any_union(&[a, b], before)?;
                let sum_d2 = model.sum_d2(&shape, &points);
                Union { shape, sum_d2, reason: String::new() }
            }
        };
        let scale = energy::scale(model);
        let count = configuration.primitives().len();
        let [price, cheaper] =
            [count, count - 1].map(|k| energy::price(model, configuration.params, k) / scale);
        let after = configuration.energy_with(&[a, b], &[PrimitiveTerms::new(model, union.shape)]);
        let gain = (before - after) / scale;
        let is_off = configuration.params.merge == MergeRule::None;
        let reason = if is_off {
            "merging is switched off in the parameters; by hand it can be done all the same".to_owned()
        } else if gain > 0.0 {
            merge_reason(gain)
        } else {
            format!("one primitive in their place costs {:.4} mean spacings, its lower price counted", -gain)
        };
        let unit = "mean spacings";
        let numbers = vec![
            TestNumber::new(
                "Error before",
                before / scale - price,
                None,
                unit,
                "Mean distance between the cloud and all primitives, both ways, as they are",
            ),
            TestNumber::new(
                "Error after",
                after / scale - cheaper,
                None,
                unit,
                "The same with one primitive in the place of the two",
            ),
            TestNumber::new(
                "Price saved",
                price - cheaper,
                None,
                unit,
                "The error that one primitive more has to save to be worth having",
            ),
            TestNumber::new(
                "Gain",
                gain,
                Some(0.0),
                unit,
                "Error before plus price saved, less the error after; the merge is made above 0",
            )
            .judged(gain > 0.0),
        ];
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
        let (is_acceptable, reason) = match (known, measured.verdict()) {
            (Some(union), _) => (true, union.reason.clone()),
            (None, Ok(reason)) => (true, reason),
            (None, Err(reason)) => (false, reason),
        };
        let numbers = vec![
            TestNumber::new(
                "Box fill",
                measured.fill,
                Some(FILL),
                "",
                "Volume of the two parts' boxes against the box that holds both; must not be below",
            )
            .judged(measured.fill >= FILL),
            TestNumber::new(
                "Volume fill",
                measured.volumes,
                Some(FILL),
                "",
                "Volume of the two primitives against that of the union; must not be below",
            )
            .judged(measured.volumes >= FILL),
            TestNumber::new(
                "Relative error²",
                measured.relative,
                Some(RELATIVE.max(measured.worse_relative)),
                "",
                "Mean of (r/|q|)², the radial error against the distance from the centre; good below 0.005, or \
                 where it is no larger than that of the worse of the two alone",
            )
            .judged(measured.relative < RELATIVE || measured.relative <= measured.worse_relative),
            TestNumber::new(
                "Mean d²",
                measured.mean_d2,
                Some(measured.limit.max(measured.worse_mean_d2)),
                "normalised²",
                "Mean squared radial distance; good below the limit (0.001 in the first merge pass, 0.01 later), \
                 or where it is less than that of the worse of the two alone",
            )
            .judged(measured.mean_d2 < measured.limit || measured.mean_d2 < measured.worse_mean_d2),
        ];
        Some(Judged { union: pair.union(shape, &measured, reason.clone()), is_acceptable, reason, numbers })
    }
}
