//! Why something can't be had now.

use super::apply::mode_of;
use super::{Session, Verb};
use crate::inference::Phase;
use crate::worker::Activity;

impl Session {
    /// Why the verb would do nothing now, as a sentence without its full stop;
    /// `None` where it would.
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
        let is_busy = !matches!(self.activity, Activity::Idle | Activity::Renewing);
        Some(match verb {
            Verb::Pause => "Nothing is running",
            Verb::Deselect if self.proposal.is_some() => "Decide on the merge first",
            Verb::FrameSelection | Verb::Deselect => "Nothing is selected",
            Verb::HideSelected => "No primitive is selected",
            Verb::StopPlaying => "Nothing is being played",
            Verb::Play if self.playback.is_playing => "It is being played",
            Verb::Play => "There are no steps to play",
            Verb::StopSeeds => "No seeds are being run",
            Verb::Undo => "Nothing was done yet",
            Verb::Redo => "Nothing was undone",
            Verb::AcceptMerge | Verb::SkipMerge | Verb::DropMerge => "No merge is proposed",
            Verb::MergeSelected => "Select two primitives or more",
            Verb::JudgeMerge => "Select two primitives",
            Verb::DropShape => "No primitive is being changed",
            Verb::SplitSelected | Verb::RefitSelected => "Select one primitive",
            Verb::DeleteSelected | Verb::LockSelected => "Select a primitive",
            Verb::NewCluster | Verb::BelongTogether => "Select points first",
            Verb::ReleasePoints => "No point is pinned",
            Verb::ShowAll => "No primitive is hidden",
            Verb::ReopenLast => "No session was closed without being saved",
            Verb::ClearRecent => "No file is remembered",
            Verb::ZoomReset => "It is 100 % already",
            Verb::ExportAgain if self.exported().is_none() && self.loaded.is_some() => {
                "Nothing of this shape was exported yet"
            }
            _ if needs_shape && self.activity == Activity::Loading => "A shape is being loaded",
            _ if needs_shape && self.loaded.is_none() => "Open a shape first",
            Verb::RunSeeds | Verb::ShowOdds => "There is no state yet",
            Verb::Reset | Verb::FirstState | Verb::PreviousState => "It is at its start",
            Verb::NextState | Verb::LastState => "It is the newest state",
            Verb::ContinueHere => "It is the newest state: Run goes on from it",
            Verb::Resample => "The settings of the samples are those of the run",
            Verb::CopyPrimitives | Verb::CopyCsv => "There are no primitives",
            Verb::ExportAgain if !is_busy => "The shape has no mesh, which the last format needs",
            Verb::PastePrimitives | Verb::TakeFrom if self.snapshot.is_none() => "There is no state yet",
            _ if is_busy && self.is_running() => "Pause the run first",
            _ if is_busy => "Wait until the file is written",
            Verb::Continue => "The run is not finished: Run goes on with it",
            Verb::StepIteration if self.phase() == Some(Phase::Finished) => "The run is finished",
            Verb::StepMerge | Verb::MergeAll if self.primitives().len() < 2 => {
                "There are no two primitives to merge"
            }
            Verb::StepMerge | Verb::MergeAll => "No pair is left that may be merged",
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
