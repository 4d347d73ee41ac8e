//! Which actions are available, and why others are not.

use super::Session;
use super::apply::mode_of;
use super::verb::Verb;
use super::view::{Picks, ThemeChoice, Tool};
use super::window::Panel;
use crate::inference::{Algorithm, Phase};
use crate::worker::Activity;

impl Session {
    /// Whether the verb is available.
    pub fn is_enabled(&self, verb: Verb) -> bool {
        let loaded = self.loaded.is_some();
        // What is asked for while a run is made anew waits for its result, which
        // takes a blink: the buttons don't.
        let idle = matches!(self.activity, Activity::Idle | Activity::LiveRun);
        let is_sampler = self.algorithm() == Algorithm::Sampler;
        let can_edit = self.can_edit();
        match verb {
            Verb::Export => self.snapshot.is_some() && self.activity != Activity::Writing,
            Verb::ExportAgain => {
                self.snapshot.is_some()
                    && self.activity != Activity::Writing
                    && self.exported().is_some()
                    && self.why_not_exported(self.window.export.format).is_none()
            }
            Verb::CopyPrimitives | Verb::CopyCsv => !self.primitives().is_empty(),
            Verb::PastePrimitives | Verb::TakeFrom => can_edit,
            Verb::SaveSession | Verb::SaveSessionAs => loaded,
            Verb::ReopenLast => self.saving.has_last(),
            Verb::Run => loaded && idle,
            Verb::Pause => self.is_running() || self.activity == Activity::Loading,
            Verb::StepIteration => loaded && idle && self.phase() != Some(Phase::Finished),
            Verb::StepMerge | Verb::MergeAll => {
                loaded
                    && idle
                    && self.primitives().len() > 1
                    && !(verb == Verb::MergeAll && self.merges_are_exhausted)
                    && self.why_disabled(verb).is_none()
            }
            Verb::Reset => {
                loaded
                    && self.activity != Activity::Loading
                    && (self.timeline.states().len() > 1 || self.stale_start().is_some())
            }
            Verb::Resample => {
                self.activity != Activity::Loading
                    && !self.live.is_renewing()
                    && self.loaded.as_ref().is_some_and(|l| l.sampling != self.sampling)
            }
            Verb::HideSelected => !self.selection.is_empty(),
            Verb::FrameSelection => !self.selection.is_empty() || !self.selected_points.is_empty(),
            Verb::Deselect => {
                let is_free = self.proposal.is_none() && !self.is_shaping();
                is_free && !(self.selection.is_empty() && self.selected_points.is_empty())
            }
            Verb::DropShape => self.is_shaping(),
            Verb::HandlesMove
            | Verb::HandlesRotate
            | Verb::HandlesScale
            | Verb::HandlesTaper
            | Verb::HandlesRoundness => self.selected_primitive().is_none_or(|p| self.why_fixed(p).is_none()),
            Verb::Undo => !self.undo.done().is_empty() || self.can_take_back(),
            Verb::Redo => !self.undo.undone().is_empty(),
            Verb::Continue => loaded && idle && self.phase() == Some(Phase::Finished) && is_sampler,
            Verb::ContinueHere => loaded && !self.timeline.is_at_end() && self.activity != Activity::Loading,
            Verb::FirstState | Verb::PreviousState => self.timeline.shown_index() > 0,
            Verb::LastState | Verb::NextState => !self.timeline.is_at_end(),
            Verb::Play => !self.playback.is_playing && self.timeline.states().len() > 1,
            Verb::StopPlaying => self.playback.is_playing,
            Verb::AcceptMerge | Verb::SkipMerge | Verb::DropMerge => self.proposal.is_some(),
            Verb::MergeSelected => can_edit && self.selection.len() > 1 && !self.holds_locked(),
            Verb::JudgeMerge => can_edit && idle && self.selection.len() == 2 && !self.holds_locked(),
            Verb::SplitSelected | Verb::RefitSelected => {
                can_edit && self.selection.len() == 1 && !self.holds_locked()
            }
            Verb::DeleteSelected => can_edit && !self.selection.is_empty() && !self.holds_locked(),
            Verb::LockSelected => can_edit && !self.selection.is_empty(),
            Verb::NewCluster | Verb::BelongTogether => can_edit && !self.selected_points.is_empty(),
            Verb::ReleasePoints => {
                can_edit && self.snapshot.as_ref().is_some_and(|s| !s.abstraction.pinned.is_empty())
            }
            Verb::FrameAll | Verb::SavePicture | Verb::SaveTurntable => loaded,
            Verb::RunSeeds => self.snapshot.is_some() && self.activity != Activity::Loading,
            Verb::StopSeeds => self.seeds.is_running(),
            Verb::ShowSeeds => loaded,
            Verb::ShowOdds => self.snapshot.is_some(),
            Verb::ShowAll => !self.hidden.is_empty(),
            Verb::ClearRecent => !self.window.recent.is_empty(),
            Verb::ZoomReset => self.window.zoom != 1.0,
            _ => true,
        }
    }

    /// Whether a toggle verb is on; `None` for other verbs.
    pub fn is_on(&self, verb: Verb) -> Option<bool> {
        match verb {
            Verb::HandlesMove
            | Verb::HandlesRotate
            | Verb::HandlesScale
            | Verb::HandlesTaper
            | Verb::HandlesRoundness => Some(self.handles == mode_of(verb)),
            Verb::ToggleOrthographic => Some(self.camera.orthographic),
            Verb::ToggleLive => Some(self.live.is_on),
            Verb::ToggleLoop => Some(self.playback.loops),
            Verb::ToggleLog => Some(self.view.shows_log),
            Verb::ShowSeeds => Some(self.view.shows_seeds),
            Verb::ShowOdds => Some(self.view.shows_odds),
            Verb::ToggleLeftPanel => Some(self.window.shows(Panel::Left)),
            Verb::ToggleRightPanel => Some(self.window.shows(Panel::Right)),
            Verb::ToggleBottomPanel => Some(self.window.shows(Panel::Bottom)),
            Verb::ToolClick => Some(self.view.tool == Tool::Click),
            Verb::ToolBox => Some(self.view.tool == Tool::Box),
            Verb::ToolLasso => Some(self.view.tool == Tool::Lasso),
            Verb::TogglePicks => Some(self.view.picks == Picks::Points),
            Verb::ThemeSystem => Some(self.view.theme == ThemeChoice::System),
            Verb::ThemeLight => Some(self.view.theme == ThemeChoice::Light),
            Verb::ThemeDark => Some(self.view.theme == ThemeChoice::Dark),
            _ => None,
        }
    }

    /// Whether the shown state can be edited.
    pub fn can_edit(&self) -> bool {
        let is_sampler = self.algorithm() == Algorithm::Sampler;
        self.snapshot.is_some() && self.activity != Activity::Loading && is_sampler
    }

    /// Whether a locked primitive is selected.
    fn holds_locked(&self) -> bool {
        self.primitives().iter().any(|p| p.locked && self.selection.contains(&p.id))
    }

    /// The algorithm of the current run.
    pub fn algorithm(&self) -> Algorithm {
        self.snapshot.as_ref().map_or(self.params.algorithm, |s| s.start.algorithm)
    }

    /// Why the verb is not available, if this is not obvious.
    pub fn why_disabled(&self, verb: Verb) -> Option<&'static str> {
        if self.algorithm() == Algorithm::Sampler {
            let changes_shapes = matches!(
                verb,
                Verb::MergeSelected
                    | Verb::JudgeMerge
                    | Verb::SplitSelected
                    | Verb::RefitSelected
                    | Verb::DeleteSelected
            );
            return (changes_shapes && self.holds_locked()).then_some("Unlock the primitive first");
        }
        match verb {
            Verb::StepMerge | Verb::MergeAll => {
                Some("The method of this run has no merging; only the sampler merges")
            }
            verb if verb.is_edit()
                || matches!(
                    verb,
                    Verb::Continue | Verb::JudgeMerge | Verb::PastePrimitives | Verb::TakeFrom
                ) =>
            {
                Some("Only states of the sampler can be edited. Choose a sampler method and run")
            }
            _ => None,
        }
    }
}
