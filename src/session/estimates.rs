//! Estimated Chamfer distances for states at which no run stopped.

use std::collections::BTreeMap;

/// What was asked for and what has come.
#[derive(Debug, Default)]
pub(super) struct Estimates {
    pub(super) values: BTreeMap<u64, Option<f64>>,
    /// First and last key, and number, of the states that were asked for.
    pub(super) asked: Option<(u64, u64, usize)>,
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
