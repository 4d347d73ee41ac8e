//! Live updates: every change to the inputs of a run starts a new one, and the last result stays
//! visible until the new one is ready.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::verb::Verb;
use super::{Effect, Session};
use crate::geometry::palette::Colors;
use crate::inference::{Abstraction, Params, Phase, UNASSIGNED};
use crate::worker::{Activity, Command, LiveResult, SamplingOptions, Setup};

impl Session {
    /// The current parameters and sampling.
    fn setup(&self) -> Setup {
        Setup { params: self.params, sampling: self.sampling }
    }

    /// Whether the update in progress is older than the last request.
    pub fn awaits_newer_run(&self) -> bool {
        self.live.under_way.is_some_and(|setup| !makes_same_run(&setup, &self.setup()))
    }

    /// Whether the shown result does not match the current parameters and
    /// sampling, and no update is in progress.
    pub fn is_outdated(&self) -> bool {
        let (Some(snapshot), Some(loaded)) = (&self.snapshot, &self.loaded) else { return false };
        if self.activity != Activity::Idle || self.live.is_renewing() || self.live.is_due {
            return false;
        }
        // A start knows nothing yet of what iterations and merges read.
        let is_start = snapshot.abstraction.phase == Phase::Start;
        let made_with =
            Setup { params: if is_start { self.params } else { snapshot.params }, sampling: loaded.sampling };
        !makes_same_run(&made_with, &self.setup()) || self.stale_start().is_some()
    }

    /// Runs so that the result matches the current parameters and sampling;
    /// restarts a run that would otherwise keep its old start or samples.
    pub(super) fn run_as_set(&mut self) -> Vec<Effect> {
        let has_samples = self.loaded.as_ref().is_some_and(|l| l.sampling == self.sampling);
        let is_over = self.phase() == Some(Phase::Finished);
        if has_samples && (is_over || self.stale_start().is_none()) {
            self.apply_verb(Verb::Run)
        } else {
            self.renew(true)
        }
    }

    /// Applies another setup. With Live on, starts an update if the run would
    /// differ; otherwise the parameters wait for the next step or start.
    pub(super) fn take_setup(&mut self, params: Params, sampling: SamplingOptions) -> Vec<Effect> {
        let before = self.setup();
        self.params = params;
        self.sampling = sampling;
        if params != before.params {
            // Another merge rule may accept what the last one refused.
            self.merges_are_exhausted = false;
        }
        if self.live.is_on && !makes_same_run(&before, &self.setup()) {
            let renewal = self.renew(false);
            if !renewal.is_empty() {
                return renewal;
            }
        }
        if params == before.params {
            return Vec::new();
        }
        vec![Effect::Send(Command::SetParams(params))]
    }

    /// A drag has paused: runs for outdated values need not be finished.
    pub(super) fn hand_rests(&mut self) -> Vec<Effect> {
        if self.awaits_newer_run() { self.renew(true) } else { Vec::new() }
    }

    /// Switches Live, and catches up on changes made while it was off.
    pub(super) fn set_live(&mut self, on: bool) -> Vec<Effect> {
        self.live.is_on = on;
        let (true, Some(snapshot), Some(loaded)) = (on, &self.snapshot, &self.loaded) else {
            return Vec::new();
        };
        let now = self.setup();
        let same = |params| makes_same_run(&Setup { params, sampling: loaded.sampling }, &now);
        // A run whose parameters were changed on its way is of neither kind.
        if same(snapshot.start) && same(snapshot.params) { Vec::new() } else { self.renew(false) }
    }

    /// Handles a change that the worker could not accept when it was made.
    pub(super) fn renew_if_due(&mut self) -> Vec<Effect> {
        if std::mem::take(&mut self.live.is_due) { self.renew(false) } else { Vec::new() }
    }

    fn renew(&mut self, hand_rests: bool) -> Vec<Effect> {
        if self.loaded.is_none() || matches!(self.activity, Activity::Loading | Activity::Writing) {
            self.live.is_due = true;
            return Vec::new();
        }
        let mut effects = self.sync();
        let setup = self.setup();
        // A run that is watched is no result that would be worth waiting for.
        let is_watched = self.live.under_way.is_none() && self.is_running();
        if self.live.under_way.is_none() || hand_rests {
            self.live.under_way = Some(setup);
        }
        if !self.is_running() || is_watched {
            self.activity = Activity::LiveRun;
        }
        effects.push(Effect::Send(Command::Renew { setup, at_once: hand_rests || is_watched }));
        effects
    }

    /// Shows the finished run. Camera and view are kept, and so are the
    /// selection and hidden primitives where they can be matched.
    pub(super) fn absorb_renewed(&mut self, renewed: &LiveResult) {
        let Some(last) = renewed.states.last() else { return };
        let is_same_cloud = self.loaded.as_ref().is_some_and(|l| Arc::ptr_eq(l, &renewed.loaded));
        if !is_same_cloud {
            self.explained = None;
            // Indices of samples mean nothing among others.
            self.selected_points = Arc::default();
        }
        // Other samples of the same shape leave the scene where it is.
        self.loaded = Some(Arc::clone(&renewed.loaded));
        if let (true, Some(before)) = (is_same_cloud, &self.snapshot) {
            let heirs = heirs(&before.abstraction, &last.abstraction);
            let origins = self::heirs(&last.abstraction, &before.abstraction);
            self.selection = self.selection.iter().filter_map(|id| heirs.get(id).copied()).collect();
            // What was swallowed by a larger one doesn't hide that.
            let same = |id: &u32| heirs.get(id).copied().filter(|heir| origins.get(heir) == Some(id));
            self.hidden = self.hidden.iter().filter_map(same).collect();
        }
        let colors = match (&self.snapshot, self.timeline.current()) {
            (Some(before), Some(branch)) if is_same_cloud => {
                Arc::new(inherited(&before.abstraction, &branch.colors, renewed))
            }
            _ => Arc::default(),
        };
        self.drop_proposal();
        self.merge_text = None;
        self.messages.dismiss_errors();
        for (index, state) in renewed.states.iter().enumerate() {
            if index == 0 {
                self.timeline.start(&renewed.loaded, Arc::clone(state), Arc::clone(&colors));
            } else {
                self.timeline.push(Arc::clone(state));
            }
        }
        self.worker_at = Some(last.key);
        self.show_state(Arc::clone(last));
    }
}

/// Whether both lead to the same run, ignoring parameters that the method does not use.
fn makes_same_run(a: &Setup, b: &Setup) -> bool {
    a.sampling == b.sampling && a.params == b.params.with_unread_of(&a.params)
}

/// For each primitive of `before`, the one of `after` that contains most of its
/// points, because ids are not comparable between runs. Primitives whose points
/// are scattered have none.
fn heirs(before: &Abstraction, after: &Abstraction) -> BTreeMap<u32, u32> {
    let mut shared: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (&old, &new) in before.labels.iter().zip(after.labels.iter()) {
        if old != UNASSIGNED && new != UNASSIGNED {
            *shared.entry((old, new)).or_default() += 1;
        }
    }
    let mut best: BTreeMap<u32, (usize, u32)> = BTreeMap::new();
    for ((old, new), points) in shared {
        let found = best.entry(old).or_insert((0, new));
        if points > found.0 {
            *found = (points, new);
        }
    }
    best.into_iter().map(|(old, (_, new))| (old, new)).collect()
}

/// Colours for a run that replaces another. A primitive keeps the colour of the
/// earlier one with which it mutually shares most points.
fn inherited(before: &Abstraction, colors: &Colors, renewed: &LiveResult) -> Colors {
    let Some(last) = renewed.states.last() else { return Colors::default() };
    let (heirs, origins) = (heirs(before, &last.abstraction), self::heirs(&last.abstraction, before));
    let kept = heirs
        .into_iter()
        .filter(|(old, new)| origins.get(new) == Some(old))
        .map(|(old, new)| (new, colors.place(old)))
        .collect();
    // The last state first: its primitives are looked at longest.
    let all = renewed.states.iter().rev().flat_map(|s| s.abstraction.primitives.iter().map(|p| p.id));
    Colors::new(kept, all)
}
