//! Estimated Chamfer distances for states at which no run stopped, computed while the worker is
//! idle.

use std::collections::{BTreeMap, BTreeSet};

use super::curves::Curve;
use super::{Effect, Session};
use crate::worker::{Activity, Command, State};

/// States of a branch that are estimated at most; of more, some between are
/// left out.
const MOST: usize = 200;
/// Estimates that are kept, whether or not their states still are.
const KEPT: usize = 4096;

/// What was asked for and what has come.
#[derive(Debug, Default)]
pub(super) struct Estimates {
    values: BTreeMap<u64, Option<f64>>,
    /// First and last key, and number, of the states that were asked for.
    asked: Option<(u64, u64, usize)>,
}

impl Estimates {
    pub(super) fn take(&mut self, key: u64, chamfer_l1: Option<f64>) {
        self.values.insert(key, chamfer_l1);
    }

    /// Those that were on their way will not come.
    pub(super) fn ask_again(&mut self) {
        self.asked = None;
    }

    /// Those of another shape are of no use.
    pub(super) fn forget(&mut self) {
        self.values.clear();
    }
}

/// The Chamfer distance of a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chamfer {
    /// In units of the longest edge of the input's box.
    pub value: f64,
    /// It was estimated from a few points.
    pub is_rough: bool,
}

impl Session {
    /// The Chamfer distance of a state, where it was measured or estimated.
    pub fn chamfer_of(&self, key: u64) -> Option<Chamfer> {
        if let Some(measurement) = self.measurement_of(key) {
            let value = measurement.result.as_ref().ok()?.chamfer_l1?;
            return Some(Chamfer { value, is_rough: false });
        }
        let value = self.estimates.values.get(&key).copied().flatten()?;
        Some(Chamfer { value, is_rough: true })
    }

    /// What the worker can do while nothing else is to be done; the owner asks
    /// again and again.
    pub fn background(&mut self) -> Vec<Effect> {
        let wanted = self.wants_estimates();
        if wanted == self.estimates.asked {
            return Vec::new();
        }
        self.estimates.asked = wanted;
        if self.estimates.values.len() > KEPT {
            let keys = self.timeline.keys();
            self.estimates.values.retain(|key, _| keys.contains(key));
        }
        let states = if wanted.is_some() { self.to_estimate() } else { Vec::new() };
        vec![Effect::Send(Command::Estimate(states.into()))]
    }

    /// Names the states whose estimates are wanted now.
    fn wants_estimates(&self) -> Option<(u64, u64, usize)> {
        let is_shown = self.curves.shows(Curve::Chamfer) && self.activity == Activity::Idle;
        let states = self.timeline.states();
        let (first, last) = (states.first()?, states.last()?);
        is_shown.then_some((first.key, last.key, states.len()))
    }

    /// The states of the shown branch that have none, coarse to fine.
    fn to_estimate(&self) -> Vec<State> {
        let Some(branch) = self.timeline.current() else { return Vec::new() };
        let step = branch.states.len().div_ceil(MOST).max(1);
        let chosen: Vec<_> = branch.states.iter().rev().step_by(step).collect();
        coarse_to_fine(chosen.len())
            .into_iter()
            .map(|index| chosen[index])
            .filter(|s| self.measurement_of(s.key).is_none() && !self.estimates.values.contains_key(&s.key))
            .map(|s| State { loaded: branch.loaded.clone(), snapshot: s.clone() })
            .collect()
    }
}

/// 0 … n − 1 with the two ends first, then what lies between, each time half as
/// far apart.
fn coarse_to_fine(n: usize) -> Vec<usize> {
    let mut seen = BTreeSet::new();
    let mut order = Vec::with_capacity(n);
    let mut add = |index: usize| {
        if index < n && seen.insert(index) {
            order.push(index);
        }
    };
    add(0);
    add(n.saturating_sub(1));
    let mut stride = n.next_power_of_two();
    while stride > 0 {
        (0..n).step_by(stride).for_each(&mut add);
        stride /= 2;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_comes_once_and_the_ends_first() {
        for n in [0, 1, 2, 3, 7, 64, 200] {
            let order = coarse_to_fine(n);
            let sorted: BTreeSet<usize> = order.iter().copied().collect();
            assert_eq!((order.len(), sorted.len()), (n, n));
            if n > 2 {
                assert_eq!(order[..2], [0, n - 1]);
            }
        }
    }
}
