//! Names of states: their iteration and, if an iteration has several states, what led to them.

use std::fmt;
use std::sync::Arc;

use super::timeline::{Branch, Timeline};
use crate::inference::{Algorithm, Occurrence, Phase};
use crate::worker::{Cause, Snapshot};

/// Number of ids named for an edit of many primitives.
const NAMED: usize = 3;

/// The name of a state, which no other of its branch has:
/// “Iteration 30 · edit 2: deleted 7”.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StateName {
    step: &'static str,
    number: u32,
    /// “edit 2”; `None` for the state that an iteration ended with.
    what: Option<String>,
    /// What an edit has changed.
    detail: Option<String>,
}

impl StateName {
    /// Name of a state of a branch, or of the last if there are fewer.
    pub fn of(states: &[Arc<Snapshot>], index: usize) -> Self {
        let index = index.min(states.len().saturating_sub(1));
        let Some(state) = states.get(index) else {
            return Self { step: "Iteration", number: 0, what: None, detail: None };
        };
        let (number, kind) = (state.abstraction.iteration, kind_of(state));
        let same = states[..=index].iter().rev().take_while(|s| s.abstraction.iteration == number);
        let what = match (kind, same.filter(|s| kind_of(s) == kind).count()) {
            ("", 1) => None,
            ("", n) => Some(format!("step {n}")),
            (kind, 1) => Some(kind.to_owned()),
            (kind, n) => Some(format!("{kind} {n}")),
        };
        let step = if state.start.algorithm == Algorithm::Sampler { "Iteration" } else { "Step" };
        let detail = (state.cause == Cause::Edit).then(|| edited(&state.occurrences)).flatten();
        Self { step, number, what, detail }
    }

    /// “ · edit 2”, or nothing: what follows the iteration.
    pub fn suffix(&self) -> String {
        self.what.as_ref().map_or_else(String::new, |what| format!(" · {what}"))
    }

    /// Short form: “30 · edit 2”.
    pub fn short(&self) -> String {
        format!("{}{}", self.number, self.suffix())
    }

    /// Without details of an edit: “Iteration 30 · edit 2”.
    pub fn place(&self) -> String {
        format!("{} {}", self.step, self.short())
    }
}

impl fmt::Display for StateName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.place())?;
        self.detail.as_ref().map_or(Ok(()), |detail| write!(f, ": {detail}"))
    }
}

impl Branch {
    /// Name of the state with this index.
    pub fn name_of(&self, index: usize) -> StateName {
        StateName::of(&self.states, index)
    }
}

impl Timeline {
    /// Name of the shown state.
    pub fn shown_name(&self) -> StateName {
        StateName::of(self.states(), self.shown_index())
    }

    /// Name of the state that the worker added last.
    pub(super) fn newest_name(&self) -> StateName {
        StateName::of(self.growing().map_or(&[], |b| &b.states), usize::MAX)
    }
}

/// What led to a state, in one word; empty for an iteration.
fn kind_of(state: &Snapshot) -> &'static str {
    let is_sampler = state.start.algorithm == Algorithm::Sampler;
    match state.cause {
        Cause::Merge => "merge",
        Cause::Edit => "edit",
        // After the last iteration there is a step that is none.
        Cause::Step if is_sampler && state.abstraction.phase == Phase::Finished => {
            if state.params.refine {
                "refined"
            } else {
                "finished"
            }
        }
        Cause::Start | Cause::Step => "",
    }
}

/// Short description of an edit.
fn edited(occurrences: &[Occurrence]) -> Option<String> {
    let verb_and_ids: Vec<(&str, Vec<u32>)> = occurrences.iter().filter_map(verb_and_ids).collect();
    let (verb, _) = *verb_and_ids.first()?;
    let ids: Vec<u32> =
        verb_and_ids.into_iter().filter(|(v, _)| *v == verb).flat_map(|(_, ids)| ids).collect();
    let mut text = verb.to_owned();
    for (i, id) in ids.iter().take(NAMED).enumerate() {
        text += &format!("{} {id}", if i == 0 { "" } else { "," });
    }
    if ids.len() > NAMED {
        text += " …";
    }
    Some(text)
}

fn verb_and_ids(occurrence: &Occurrence) -> Option<(&'static str, Vec<u32>)> {
    Some(match occurrence {
        Occurrence::Edited { id } => ("reshaped", vec![*id]),
        Occurrence::Refitted { id } => ("refitted", vec![*id]),
        Occurrence::Locked { id } => ("locked", vec![*id]),
        Occurrence::Unlocked { id } => ("unlocked", vec![*id]),
        Occurrence::Joined { ids, .. } => ("merged", ids.clone()),
        Occurrence::Halved { id, .. } => ("split", vec![*id]),
        Occurrence::Deleted { id, .. } => ("deleted", vec![*id]),
        Occurrence::Created { id, .. } => ("created", vec![*id]),
        Occurrence::Pinned { id, .. } => ("pinned points to", vec![*id]),
        Occurrence::Released { .. } => ("unpinned points", Vec::new()),
        Occurrence::Taken { .. } => ("imported primitives", Vec::new()),
        _ => return None,
    })
}
