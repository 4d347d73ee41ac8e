//! The run step by step, in sight: iterations and merges at a pace.

use std::time::{Duration, Instant};

use super::super::machine::Steppable;
use super::super::protocol::{Cause, Event};
use super::super::source;
use super::super::trouble::{Stop, guarded};
use super::{Engine, Goal};
use crate::inference::{MergeReport, Occurrence};

/// What one step came to.
enum Step {
    Iterated(Vec<Occurrence>),
    Merged(Vec<MergeReport>),
}

impl<M: Steppable> Engine<M> {
    /// Back to the start of the run; whether it worked.
    pub(super) fn restart(&mut self) -> bool {
        let Some(present) = &self.present else {
            self.fail("Nothing to reset", "no shape is loaded; open one first");
            return false;
        };
        let cancel = self.cancel.clone();
        let params = self.params;
        let outcome = guarded(|| {
            let machine = present
                .machine
                .restarted(params, &cancel)
                .map_err(|error| Stop::inference("Cannot start the run", &error))?;
            let abstraction = machine.abstraction();
            Ok((machine, abstraction))
        });
        match (outcome, &mut self.present) {
            (Ok((machine, abstraction)), Some(present)) => {
                present.machine = machine;
                present.abstraction = abstraction;
                present.run += 1;
                present.start = params;
                present.elapsed = Duration::ZERO;
                present.unmeasured = None;
                self.emit_snapshot(Cause::Start, Vec::new());
                true
            }
            (Ok(_), None) => false,
            (Err(stop), _) => {
                self.report(stop);
                false
            }
        }
    }

    /// Goes on with the work at hand by one step.
    pub(super) fn advance(&mut self) {
        match self.work {
            Goal::Nothing => {}
            Goal::Renew => self.advance_renewal(),
            Goal::Linger => {
                self.work = Goal::Nothing;
                self.announce();
            }
            Goal::Run | Goal::StepIteration | Goal::MergeAll => self.step(),
        }
    }

    /// Makes one step of the run or its merging. The step is made on a copy: what is
    /// cancelled or panics in the middle leaves the state as it was.
    fn step(&mut self) {
        let Some(present) = &self.present else {
            self.work = Goal::Nothing;
            return;
        };
        let begun = Instant::now();
        let work = self.work;
        let cancel = self.cancel.clone();
        if matches!(work, Goal::Run | Goal::StepIteration) && present.machine.is_finished() {
            self.work = Goal::Nothing;
            self.announce();
            return;
        }
        let outcome = guarded(|| {
            let mut machine = present.machine.clone();
            let step = match work {
                Goal::MergeAll => machine.step_merge(&cancel).map(Step::Merged),
                _ => machine.step(&cancel).map(Step::Iterated),
            }
            .map_err(|error| Stop::inference("Cannot complete the step", &error))?;
            let abstraction = machine.abstraction();
            Ok((machine, abstraction, step))
        });
        match outcome {
            Ok((machine, abstraction, step)) => {
                if let Some(present) = &mut self.present {
                    present.machine = machine;
                    present.abstraction = abstraction;
                    present.elapsed += begun.elapsed();
                }
                self.pacer.stepped(begun);
                self.conclude(step);
            }
            // The order that cancelled the step decides how it goes on.
            Err(Stop::Cancelled) => {}
            Err(stop) => {
                self.work = Goal::Nothing;
                self.report(stop);
                self.announce();
            }
        }
    }

    /// Tells of a step that was made, and whether it was the last.
    fn conclude(&mut self, step: Step) {
        let mut done = self.work == Goal::StepIteration;
        match step {
            Step::Iterated(occurrences) => {
                let is_finished = self.present.as_ref().is_none_or(|p| p.machine.is_finished());
                done |= is_finished;
                self.emit_step(Cause::Step, occurrences);
                let result = self.present.as_ref().filter(|_| is_finished).map(|p| p.abstraction.check());
                if let Some(Err(error)) = result {
                    self.fail("The run finished without a result", source::chain(&error));
                }
            }
            Step::Merged(reports) if !reports.is_empty() => {
                self.emit_step(Cause::Merge, reports.iter().cloned().map(Occurrence::Merged).collect());
                self.emit(Event::MergeStep(reports.into_iter().next_back()));
            }
            Step::Merged(_) => {
                done = true;
                self.emit(Event::MergeStep(None));
            }
        }
        if done {
            self.work = Goal::Nothing;
            self.announce();
        }
    }
}
