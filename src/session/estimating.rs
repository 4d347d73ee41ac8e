//! The values of the curves. Chamfer distances that were not measured are estimated while the worker
//! is idle.

use std::collections::BTreeSet;

use super::curves::Curve;
use super::estimates::Chamfer;
use super::{Effect, Session};
use crate::worker::{Activity, Command, Snapshot, State};

/// States of a branch that are estimated at most; of more, some between are
/// left out.
const MOST: usize = 200;
/// Estimates that are kept, whether or not their states still are.
const KEPT: usize = 4096;

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

    /// Value of a curve at a state; `None` if there is none, or not yet.
    pub fn value_of(&self, curve: Curve, state: &Snapshot) -> Option<f64> {
        let figures = &state.abstraction.figures;
        match curve {
            Curve::Clusters => Some(figures.clusters as f64),
            Curve::MeanError => Some(figures.mean_distance).filter(|_| figures.clusters > 0),
            Curve::LogJoint => figures.log_joint,
            Curve::Chamfer => self.chamfer_of(state.key).map(|chamfer| chamfer.value),
        }
        .filter(|value| value.is_finite())
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
