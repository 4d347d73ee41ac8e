//! Why an action is not available.

use super::Session;
use super::apply::mode_of;
use super::verb::Verb;
use crate::inference::Phase;
use crate::worker::Activity;

impl Session {
    /// Why the verb is not available, as a sentence without full stop; `None` if it is.
    pub fn reason(&self, verb: Verb) -> Option<&'static str> {
        if self.is_enabled(verb) {
            return None;
        }
        if let Some(why) = self.why_disabled(verb) {
            return Some(why);
        }
        if mode_of(verb).is_some() {
            return self.selected_primitive().and_then(|p| self.why_fixed(p));
        }
        let needs_shape = matches!(
            verb,
            Verb::Run
                | Verb::StepIteration
                | Verb::StepMerge
                | Verb::MergeAll
                | Verb::Reset
                | Verb::Resample
                | Verb::FrameAll
                | Verb::Export
                | Verb::ExportAgain
                | Verb::CopyPrimitives
                | Verb::CopyCsv
                | Verb::PastePrimitives
                | Verb::TakeFrom
                | Verb::SaveSession
                | Verb::SaveSessionAs
                | Verb::Continue
                | Verb::ContinueHere
                | Verb::FirstState
                | Verb::PreviousState
                | Verb::NextState
                | Verb::LastState
                | Verb::SavePicture
                | Verb::SaveTurntable
                | Verb::RunSeeds
                | Verb::ShowSeeds
                | Verb::ShowOdds
        );
        let is_busy = !matches!(self.activity, Activity::Idle | Activity::LiveRun);
        Some(match verb {
            Verb::Pause => "Nothing is running",
            Verb::Deselect if self.proposal.is_some() => "Accept or skip the proposed merge first",
            Verb::FrameSelection | Verb::Deselect => "Nothing selected",
            Verb::HideSelected => "No primitive selected",
            Verb::StopPlaying => "Nothing is playing",
            Verb::Play if self.playback.is_playing => "Already playing",
            Verb::Play => "No other states to play",
            Verb::StopSeeds => "No seed runs in progress",
            Verb::Undo => "Nothing to undo",
            Verb::Redo => "Nothing to redo",
            Verb::AcceptMerge | Verb::SkipMerge | Verb::DropMerge => "No merge proposed",
            Verb::MergeSelected => "Select two or more primitives",
            Verb::JudgeMerge => "Select two primitives",
            Verb::DropShape => "No primitive is being edited",
            Verb::SplitSelected | Verb::RefitSelected => "Select one primitive",
            Verb::DeleteSelected | Verb::LockSelected => "Select a primitive",
            Verb::NewCluster | Verb::BelongTogether => "Select points first",
            Verb::ReleasePoints => "No pinned points",
            Verb::ShowAll => "No hidden primitives",
            Verb::ReopenLast => "No unsaved session to reopen",
            Verb::ClearRecent => "No recent files",
            Verb::ZoomReset => "Already at 100 %",
            Verb::ExportAgain if self.exported().is_none() && self.loaded.is_some() => {
                "This shape has not been exported yet"
            }
            _ if needs_shape && self.activity == Activity::Loading => "A shape is loading",
            _ if needs_shape && self.loaded.is_none() => "Open a shape first",
            Verb::RunSeeds | Verb::ShowOdds => "No state yet",
            Verb::Reset | Verb::FirstState | Verb::PreviousState => "Already at the first state",
            Verb::NextState | Verb::LastState => "Already at the latest state",
            Verb::ContinueHere => "This is the latest state; use Run to continue",
            Verb::Resample => "The sampling settings have not changed",
            Verb::CopyPrimitives | Verb::CopyCsv => "No primitives",
            Verb::ExportAgain if !is_busy => {
                "The last export format needs a mesh, but the shape is a point cloud"
            }
            Verb::PastePrimitives | Verb::TakeFrom if self.snapshot.is_none() => "No state yet",
            _ if is_busy && self.is_running() => "Pause the run first",
            _ if is_busy => "Wait until the file has been written",
            Verb::Continue => "The run is not finished; use Run to continue",
            Verb::StepIteration if self.phase() == Some(Phase::Finished) => "The run has finished",
            Verb::StepMerge | Verb::MergeAll if self.primitives().len() < 2 => {
                "At least two primitives are needed to merge"
            }
            Verb::StepMerge | Verb::MergeAll => "No more pairs to merge",
            _ => "Not now",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::Params;
    use crate::worker::SamplingOptions;

    #[test]
    fn whatever_is_disabled_has_its_reason() {
        let mut session = Session::new(Params::default(), SamplingOptions::default());
        for activity in [Activity::Idle, Activity::Loading, Activity::Running, Activity::Writing] {
            session.activity = activity;
            for &verb in Verb::ALL {
                let reason = session.reason(verb);
                assert_eq!(reason.is_none(), session.is_enabled(verb), "{verb:?}");
                assert_ne!(reason, Some("Not now"), "{verb:?} while {activity:?}");
            }
        }
    }
}
