//! Positions of a branch's states along the panel, shared by plots, ruler and lanes.

use egui::Rangef;

/// Free space at both ends, so that marks at the first and the last state are
/// whole.
const PAD: f32 = 9.0;

/// The common x axis, in indices of states.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    range: Rangef,
    /// The index at the right end; at least 1.
    last: f64,
    /// States of the shown branch.
    states: usize,
}

impl Axis {
    /// For `states` states where `expected` are to come in the end.
    pub(super) fn new(range: Rangef, states: usize, expected: usize) -> Self {
        Self { range, last: expected.max(states).saturating_sub(1).max(1) as f64, states }
    }

    pub(super) fn range(&self) -> Rangef {
        self.range
    }

    /// Logical pixels from state to state.
    pub(super) fn spacing(&self) -> f32 {
        ((self.range.span() - 2.0 * PAD) / self.last as f32).max(1e-3)
    }

    pub(super) fn x(&self, index: usize) -> f32 {
        self.range.min + PAD + index as f32 * self.spacing()
    }

    /// The state of the shown branch that is nearest.
    pub(super) fn nearest(&self, x: f32) -> usize {
        self.nearest_of(x, self.states)
    }

    /// The nearest of so many states.
    pub(super) fn nearest_of(&self, x: f32, states: usize) -> usize {
        let index = ((x - self.range.min - PAD) / self.spacing()).round().max(0.0) as usize;
        index.min(states.saturating_sub(1))
    }

    /// What a plot over the whole range shows.
    pub(super) fn bounds(&self) -> [f64; 2] {
        let pad = f64::from(PAD / self.spacing());
        [-pad, self.last + pad]
    }
}

/// The least of 1, 2, 5, 10, 20, … such that so many `units` of `spacing` are at
/// least `room`.
pub(super) fn round_step(spacing: f32, room: f32) -> u32 {
    let mut decade = 1;
    loop {
        for step in [decade, 2 * decade, 5 * decade] {
            if step as f32 * spacing >= room || decade >= 100_000_000 {
                return step;
            }
        }
        decade *= 10;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_found_where_they_are_drawn() {
        for (states, expected) in [(1, 1), (1, 30), (31, 31), (800, 500)] {
            let axis = Axis::new(Rangef::new(200.0, 900.0), states, expected);
            for index in 0..states {
                assert_eq!(axis.nearest(axis.x(index)), index);
                assert!(axis.range().contains(axis.x(index)));
            }
            assert_eq!(axis.nearest(-1e6), 0);
            assert_eq!(axis.nearest(1e6), states - 1);
            // As a plot over the range has it.
            let [low, high] = axis.bounds();
            let at = |index: f64| 200.0 + 700.0 * (index - low) / (high - low);
            assert!((at((states - 1) as f64) - f64::from(axis.x(states - 1))).abs() < 0.05);
        }
    }

    #[test]
    fn steps_are_round_and_far_enough_apart() {
        assert_eq!(round_step(40.0, 36.0), 1);
        assert_eq!(round_step(20.0, 36.0), 2);
        assert_eq!(round_step(1.2, 36.0), 50);
        assert_eq!(round_step(0.5, 36.0), 100);
    }
}
