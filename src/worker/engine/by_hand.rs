//! What a hand does to the present state: going back to another, edits, merges
//! on probation.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use super::super::machine::Steppable;
use super::super::protocol::{Cause, Event, State};
use super::super::source;
use super::super::trouble::{Stop, guarded};
use super::Engine;
use super::present::Present;
use crate::inference::{Edit, InferenceError, Occurrence};

impl<M: Steppable> Engine<M> {
    /// Makes a state that was told before the present one.
    pub(super) fn resume(&mut self, state: &State) {
        let State { loaded, snapshot } = state;
        let cancel = self.cancel.clone();
        let like = self.present.as_ref().filter(|p| Arc::ptr_eq(&p.shape.cloud, &loaded.cloud));
        let outcome = guarded(|| {
            match like {
                Some(present) => present.machine.resumed(&snapshot.checkpoint, &cancel),
                None => M::resume(Arc::clone(&loaded.cloud), &snapshot.checkpoint, &cancel),
            }
            .map_err(|error| Stop::inference("Cannot continue the run from this state", &error))
        });
        match outcome {
            Ok(machine) => {
                // Whatever is loaded or sampled next is another cloud than any so far.
                self.generation = self.generation.max(loaded.generation);
                self.present = Some(Present {
                    shape: Arc::clone(loaded),
                    run: snapshot.run,
                    start: snapshot.start,
                    machine,
                    abstraction: snapshot.abstraction.clone(),
                    elapsed: snapshot.elapsed,
                    unmeasured: None,
                });
            }
            Err(stop) => self.report(stop),
        }
    }

    /// Changes the state; on any error it stays as it was.
    pub(super) fn edit(&mut self, edit: &Edit) {
        let cancel = self.cancel.clone();
        // A merge by hand is one more merge for whoever looks back.
        let cause = match edit {
            Edit::Merge { .. } | Edit::AcceptMerge { .. } => Cause::Merge,
            _ => Cause::Edit,
        };
        let begun = Instant::now();
        let edited = self.on_copy("Cannot apply the edit", |machine| machine.edit(edit, &cancel));
        if let Some(occurrences) = edited {
            if let Some(present) = &mut self.present {
                present.elapsed += begun.elapsed();
            }
            self.emit_step(cause, occurrences);
        }
    }

    /// Takes the primitives of a file; on any error all stays as it was.
    pub(super) fn take_from(&mut self, path: &Path) {
        let what = format!("Cannot import primitives from {}", path.display());
        let outcome = guarded(|| source::read_primitives(path).map_err(|error| Stop::trouble(what, error)));
        match outcome {
            Ok(edit) => self.edit(&edit),
            Err(stop) => self.report(stop),
        }
    }

    /// Gives a finished run more iterations; whether it worked.
    pub(super) fn extend(&mut self, iterations: u32) -> bool {
        let extended = self
            .on_copy("Cannot continue the run", |machine| machine.extend(iterations).map(|()| Vec::new()));
        if let Some(present) = &self.present {
            // T is larger now.
            self.params.iterations = present.machine.params().iterations;
        }
        extended.is_some()
    }

    pub(super) fn propose_merge(&mut self, of: Option<(u32, u32)>, skipped: &[(u32, u32)]) {
        let Some(present) = &mut self.present else {
            self.fail("Nothing to merge", "no shape is loaded; open one first");
            return;
        };
        let cancel = self.cancel.clone();
        let outcome = guarded(|| {
            present
                .machine
                .propose_merge(of, skipped, &cancel)
                .map_err(|error| Stop::inference("Cannot propose a merge", &error))
        });
        match outcome {
            Ok(proposal) => self.emit(Event::Proposed(proposal.map(Box::new))),
            Err(stop) => self.report(stop),
        }
    }

    /// Changes a copy of the run and, where that succeeds, makes it the present
    /// one; `None` where it does not, which is told.
    fn on_copy(
        &mut self,
        what: &str,
        change: impl FnOnce(&mut M) -> Result<Vec<Occurrence>, InferenceError>,
    ) -> Option<Vec<Occurrence>> {
        let Some(present) = &mut self.present else {
            self.fail(what, "no shape is loaded; open one first");
            return None;
        };
        let outcome = guarded(|| {
            let mut machine = present.machine.clone();
            let occurrences = change(&mut machine).map_err(|error| Stop::inference(what, &error))?;
            let abstraction = machine.abstraction();
            Ok((machine, abstraction, occurrences))
        });
        match outcome {
            Ok((machine, abstraction, occurrences)) => {
                present.machine = machine;
                present.abstraction = abstraction;
                Some(occurrences)
            }
            Err(stop) => {
                self.report(stop);
                None
            }
        }
    }
}
