//! Proposed merges, which the user accepts or skips one by one.

use super::action::Level;
use super::{Decision, Effect, Session};
use crate::inference::{Edit, MergeProposal};
use crate::worker::Command;

/// Label of the undo step of an accepted merge.
pub(super) const MERGE: &str = "Merge";

impl Session {
    /// Whether a merge is being tested or waits for a decision.
    pub fn is_judging(&self) -> bool {
        self.is_judging || self.proposal.is_some()
    }

    /// Requests a merge test, of a given pair or the best one.
    pub(super) fn propose(&mut self, of: Option<(u32, u32)>) -> Vec<Effect> {
        self.drop_draft();
        self.timeline.branch_here();
        let mut effects = self.sync();
        effects.push(self.ask_for_proposal(of));
        effects
    }

    fn ask_for_proposal(&mut self, of: Option<(u32, u32)>) -> Effect {
        self.proposal = None;
        self.is_judging = true;
        self.merge_text = None;
        Effect::Send(Command::ProposeMerge { of, skipped: self.skipped.clone().into() })
    }

    pub(super) fn absorb_proposal(&mut self, proposal: Option<Box<MergeProposal>>) {
        // An answer that nobody waits for any more.
        if !std::mem::take(&mut self.is_judging) {
            return;
        }
        if let Some(proposal) = &proposal {
            // The state may have gone on since it was asked for.
            let present = |id| self.primitives().iter().any(|p| p.id == id);
            if !(present(proposal.pair.0) && present(proposal.pair.1)) {
                return;
            }
        } else {
            let text = if self.skipped.is_empty() {
                "No two primitives are close enough to merge."
            } else {
                "No other pairs to propose."
            };
            self.merge_text = Some(text.to_owned());
            self.messages.push(Level::Detail, text, "");
            self.skipped.clear();
        }
        self.proposal = proposal;
    }

    pub(super) fn accept_merge(&mut self) -> Vec<Effect> {
        let Some(proposal) = self.proposal.take() else { return Vec::new() };
        let (skipped, mut decisions) =
            (std::mem::take(&mut self.skipped), std::mem::take(&mut self.decisions));
        let mut effects = self.edit(vec![Edit::AcceptMerge { proposal }]);
        decisions.push(Decision::Accepted);
        (self.skipped, self.decisions) = (skipped, decisions);
        effects.push(self.ask_for_proposal(None));
        effects
    }

    pub(super) fn skip_merge(&mut self) -> Vec<Effect> {
        let Some(proposal) = self.proposal.take() else { return Vec::new() };
        let (a, b) = proposal.pair;
        self.skipped.push((a, b));
        self.decisions.push(Decision::Skipped(a, b));
        self.propose(None)
    }

    /// Whether undo reverts a skipped merge, which changed nothing.
    pub(super) fn can_take_back(&self) -> bool {
        matches!(self.decisions.last(), Some(Decision::Skipped(..)))
    }

    /// Reverts the last decision on a merge and proposes it again; `None` if
    /// something else was done since.
    pub(super) fn take_back_decision(&mut self) -> Option<Vec<Effect>> {
        match *self.decisions.last()? {
            Decision::Skipped(a, b) => {
                self.decisions.pop();
                self.skipped.retain(|pair| *pair != (a, b));
                Some(self.propose(Some((a, b))))
            }
            Decision::Accepted => {
                self.undo.done().last().filter(|step| step.label == MERGE)?;
                let now = self.document();
                let step = self.undo.undo(&now)?;
                self.decisions.pop();
                let kept = (std::mem::take(&mut self.skipped), std::mem::take(&mut self.decisions));
                let mut effects = self.restore(&step, "Undone");
                (self.skipped, self.decisions) = kept;
                effects.extend(self.propose(None));
                Some(effects)
            }
        }
    }

    /// Discards the proposal.
    pub(super) fn drop_proposal(&mut self) {
        self.proposal = None;
        self.is_judging = false;
        self.skipped.clear();
        self.decisions.clear();
    }
}
