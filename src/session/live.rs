//! Live updates: whether they are on, and the one in progress.

use crate::worker::Setup;

/// State of live updates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Live {
    pub is_on: bool,
    /// The setup of the update in progress.
    pub(super) under_way: Option<Setup>,
    /// A change came while the worker could not take it.
    pub(super) is_due: bool,
}

impl Default for Live {
    fn default() -> Self {
        Self { is_on: true, under_way: None, is_due: false }
    }
}

impl Live {
    /// Whether an update is in progress.
    pub fn is_renewing(&self) -> bool {
        self.under_way.is_some()
    }

    /// An update has started.
    pub(super) fn begin(&mut self, setup: Setup) {
        self.under_way = Some(setup);
    }

    /// No update is in progress any more.
    pub(super) fn finish(&mut self) {
        self.under_way = None;
    }

    /// Other work was requested, which replaces any update.
    pub(super) fn forget(&mut self) {
        self.under_way = None;
        self.is_due = false;
    }
}
