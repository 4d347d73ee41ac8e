//! The figures of every state of the present run, for the plots.

use crate::worker::Snapshot;

/// One state of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Gibbs iterations made.
    pub iteration: u32,
    /// Number of primitives K.
    pub clusters: usize,
    /// Mean distance in input units.
    pub mean_distance: f64,
}

/// All states since the start of the run, oldest first. The index of an entry
/// counts the steps: iterations and merges alike.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    run: Option<(u64, u64)>,
    entries: Vec<Entry>,
}

impl History {
    /// Appends a state; the first of another run starts the history anew.
    pub fn push(&mut self, snapshot: &Snapshot) {
        let run = (snapshot.generation, snapshot.run);
        if self.run != Some(run) {
            self.run = Some(run);
            self.entries.clear();
        }
        let state = &snapshot.abstraction;
        self.entries.push(Entry {
            iteration: state.iteration,
            clusters: state.figures.clusters,
            mean_distance: state.figures.mean_distance,
        });
    }

    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }
}
