//! The state behind the window, as plain data: [`Session::apply`] takes user actions,
//! [`Session::absorb`] takes events from the worker. Both return [`Effect`]s, which the owner
//! carries out.
//!
//! Each layer uses only those below it:
//!
//! | layer | what lives there |
//! |---|---|
//! | `absorb`, `apply`, `comparing`, `drafting`, `edited`, `editing`, `enabled`, `estimating`, `export`, `keeping`, `merging`, `playing`, `preferences`, `reasons`, `renewing`, `seed_runs`, `telling` | the methods of the session |
//! | `Session`, `Effect`, `Decision` | the whole state |
//! | `messages`, `action`, `verb` | the log, user actions |
//! | `saving`, `workspace`, `document`, `undo`, `comparison`, `timeline`, `naming` | what is saved and undone: states in branches |
//! | `camera`, `curves`, `estimates`, `gizmo`, `live`, `merge_wording`, `paint`, `playback`, `scalar`, `scene`, `seeds`, `selection`, `shaping`, `view`, `window` | other parts of the state |

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Arc, Weak};

use nalgebra::Point3;

use crate::geometry::Bulk;
use crate::geometry::palette::color_of;
use crate::inference::{MergeProposal, Params, Phase, Primitive, Setting, normalised_scale};
use crate::io::Shape;
use crate::worker::{
    Activity, Command, LoadedShape, Measurement, Pace, SamplingOptions, Snapshot, Source, State,
};

mod absorb;
pub mod action;
mod apply;
pub mod camera;
mod comparing;
pub mod comparison;
pub mod curves;
pub mod document;
mod drafting;
mod edited;
mod editing;
mod enabled;
pub mod estimates;
mod estimating;
mod export;
pub mod gizmo;
mod keeping;
pub mod live;
pub mod merge_wording;
mod merging;
pub mod messages;
pub mod naming;
pub mod paint;
pub mod playback;
mod playing;
pub mod preferences;
mod reasons;
mod renewing;
pub mod saving;
pub mod scalar;
pub mod scene;
mod seed_runs;
pub mod seeds;
pub mod selection;
pub mod shaping;
mod telling;
pub mod timeline;
pub mod undo;
pub mod verb;
pub mod view;
pub mod window;
pub mod workspace;

#[cfg(test)]
mod tests;

pub use action::Action;
use action::PictureKind;
use camera::Camera;
use comparison::Comparison;
use curves::Curves;
use document::Document;
use estimates::Estimates;
use live::Live;
use messages::Messages;
use playback::Playback;
use saving::{Opening, Saving};
use scene::{SceneFromInput, UpAxis};
use seeds::Seeds;
use shaping::Shaping;
use timeline::Timeline;
use undo::Undo;
pub use verb::Verb;
use view::View;
pub use window::ExportChoice;
use window::Window;

/// A speed at which each iteration can be followed and the default run takes
/// about three seconds. Live updates and the maximum speed show results
/// immediately.
pub const DEFAULT_PACE: Pace = Pace::PerSecond(10);

/// Side effects that the owner of a session carries out.
#[derive(Debug, Clone)]
pub enum Effect {
    Send(Command),
    AskForShape,
    /// Open the export dialog.
    AskForExport,
    /// Ask for a file of primitives.
    AskForPrimitives,
    /// Copy a text to the clipboard.
    Copy(Bulk<String>),
    /// Request the clipboard's text as an event.
    RequestPaste,
    AskForScreenshot,
    SaveScreenshot(PathBuf),
    /// Ask for a file to save the session to.
    AskForSession,
    SaveSession(PathBuf),
    /// Open a session in place of this one.
    OpenSession(Opening),
    /// Delete a session offered for recovery, by id.
    DiscardFound(u64),
    /// Open the file if it exists, otherwise report that it does not.
    OpenIfThere(PathBuf),
    /// Show a file in the system's file manager.
    ShowInFolder(PathBuf),
    OpenLink(&'static str),
    /// Restore the default panel sizes.
    ResetLayout,
    /// Ask for the picture's options, then for its file.
    AskForPicture(PictureKind),
    SavePicture(PictureKind, PathBuf),
    Quit,
}

/// The decision on a proposed merge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Decision {
    /// Accepted.
    Accepted,
    /// The two primitives, by id, stay separate.
    Skipped(u32, u32),
}

/// Everything the window shows, except for widget state kept by egui.
#[derive(Debug)]
pub struct Session {
    pub loaded: Option<Arc<LoadedShape>>,
    /// The state that is shown: that of the timeline.
    pub snapshot: Option<Arc<Snapshot>>,
    pub timeline: Timeline,
    pub undo: Undo,
    pub playback: Playback,
    /// The curves plotted over the timeline.
    pub curves: Curves,
    /// The state compared with the current one.
    pub comparison: Option<Comparison>,
    /// Camera of the compared state, if not linked.
    pub other_camera: Camera,
    /// Current values of the sliders.
    pub params: Params,
    pub sampling: SamplingOptions,
    pub pace: Pace,
    pub live: Live,
    pub activity: Activity,
    pub saving: Saving,
    /// File and shape of the last export.
    exported: Option<(PathBuf, Weak<Shape>)>,
    pub view: View,
    pub window: Window,
    pub camera: Camera,
    /// Counts camera moves that are not drags, which views may animate.
    pub camera_jumps: u64,
    pub scene: SceneFromInput,
    /// Ids of the selected primitives.
    pub selection: BTreeSet<u32>,
    /// Ids of the hidden primitives.
    pub hidden: BTreeSet<u32>,
    pub messages: Messages,
    /// Result of the last merge.
    pub merge_text: Option<String>,
    /// Indices of the selected samples, ascending.
    pub selected_points: Arc<[u32]>,
    /// The sample whose odds are shown.
    pub explained: Option<u32>,
    /// Runs with other seeds.
    pub seeds: Seeds,
    /// The merge that waits for a decision.
    pub proposal: Option<Box<MergeProposal>>,
    /// Pairs skipped since the last accepted merge, by ids.
    skipped: Vec<(u32, u32)>,
    /// Decisions on the proposed merges.
    decisions: Vec<Decision>,
    /// Type of the handles on the selected primitive, if any.
    pub handles: Option<gizmo::Mode>,
    /// A merge is being tested.
    is_judging: bool,
    /// The primitive being edited.
    shaping: Option<Shaping>,
    /// The turns about x, y and z of the primitive, by id, that was turned last.
    last_angles: Option<(u32, [f64; 3])>,
    /// Measured states, latest last.
    measured: Vec<Arc<Measurement>>,
    /// Estimates for states that were not measured.
    estimates: Estimates,
    /// Key of the state from which the worker continues.
    worker_at: Option<u64>,
    /// The state that is being measured.
    measuring: Option<Arc<Snapshot>>,
    /// No pair of the current state can be merged.
    merges_are_exhausted: bool,
    /// Run as soon as the shape has loaded.
    run_when_loaded: bool,
    /// A shape has arrived since the worker was last idle.
    has_arrived: bool,
    /// Number of messages when work was last requested. Earlier errors are
    /// outdated once that work succeeds.
    answered: Option<u64>,
}

impl Session {
    pub fn new(params: Params, sampling: SamplingOptions) -> Self {
        Self {
            loaded: None,
            snapshot: None,
            timeline: Timeline::default(),
            undo: Undo::default(),
            playback: Playback::default(),
            curves: Curves::default(),
            comparison: None,
            other_camera: Camera::default(),
            params,
            sampling,
            pace: DEFAULT_PACE,
            live: Live::default(),
            activity: Activity::Idle,
            saving: Saving::default(),
            exported: None,
            view: View::default(),
            window: Window::default(),
            camera: Camera::default(),
            camera_jumps: 0,
            scene: SceneFromInput::fit(&[], UpAxis::Y),
            selection: BTreeSet::new(),
            hidden: BTreeSet::new(),
            messages: Messages::default(),
            merge_text: None,
            selected_points: Arc::default(),
            explained: None,
            seeds: Seeds::default(),
            proposal: None,
            skipped: Vec::new(),
            decisions: Vec::new(),
            handles: None,
            is_judging: false,
            shaping: None,
            last_angles: None,
            measured: Vec::new(),
            estimates: Estimates::default(),
            worker_at: None,
            measuring: None,
            merges_are_exhausted: false,
            run_when_loaded: false,
            has_arrived: false,
            answered: None,
        }
    }

    /// Commands that give a new worker this session's settings, open the first shape and run it.
    pub fn begin(&mut self, source: Source) -> [Command; 3] {
        [Command::SetParams(self.params), Command::SetPace(self.pace), self.load(source)]
    }

    /// The current primitives; none before the first run.
    pub fn primitives(&self) -> &[Primitive] {
        self.snapshot.as_ref().map_or(&[], |s| &s.abstraction.primitives)
    }

    /// The one selected primitive; `None` if none or several are selected.
    pub fn selected_primitive(&self) -> Option<&Primitive> {
        let [id] = self.selection.iter().copied().collect::<Vec<_>>()[..] else { return None };
        self.primitives().iter().find(|p| p.id == id)
    }

    pub fn phase(&self) -> Option<Phase> {
        self.snapshot.as_ref().map(|s| s.abstraction.phase)
    }

    /// Metrics of the current state, if measured.
    pub fn measurement(&self) -> Option<&Measurement> {
        self.measured.iter().rev().map(Arc::as_ref).find(|m| self.is_present(&m.snapshot))
    }

    /// Latest metrics of this shape, of any state.
    pub fn last_measurement(&self) -> Option<&Measurement> {
        self.measured.last().map(Arc::as_ref)
    }

    /// Whether the current state is being measured.
    pub fn is_measuring(&self) -> bool {
        self.measuring.as_ref().is_some_and(|s| self.is_present(s))
    }

    /// Metrics of a state, if measured.
    pub fn measurement_of(&self, key: u64) -> Option<&Measurement> {
        self.measured.iter().map(Arc::as_ref).find(|m| m.snapshot.key == key)
    }

    /// The sRGB colour of a primitive of the shown branch.
    pub fn color_of(&self, id: u32) -> [u8; 3] {
        self.timeline.current().map_or_else(|| color_of(id), |branch| branch.colors.of(id))
    }

    /// The shown state with what it belongs to.
    pub fn shown_state(&self) -> Option<State> {
        self.timeline.shown_state()
    }

    /// Factor from input units to normalised lengths, as used by α, p0 and σ;
    /// `None` if the shape has no extent.
    pub fn normalised_scale(&self) -> Option<f64> {
        // It depends on the box alone.
        let size = self.scene.bounds.size() / self.scene.scale();
        self.loaded.as_ref()?;
        normalised_scale(&[Point3::origin(), Point3::from(size)])
    }

    /// What undo and a session file keep.
    pub fn document(&self) -> Document {
        Document {
            loaded: self.loaded.clone(),
            params: self.params,
            sampling: self.sampling,
            timeline: self.timeline.clone(),
            selection: self.selection.clone(),
            selected_points: Arc::clone(&self.selected_points),
            hidden: self.hidden.clone(),
        }
    }

    fn is_present(&self, snapshot: &Arc<Snapshot>) -> bool {
        self.snapshot.as_ref().is_some_and(|present| Arc::ptr_eq(present, snapshot))
    }

    /// Whether the worker is busy with the run (not with files).
    pub fn is_running(&self) -> bool {
        matches!(self.activity, Activity::Running | Activity::Merging)
    }

    /// The parameters with which the current run started, if start parameters
    /// have changed since: the algorithm, K or the seed, as far as the next run
    /// uses them.
    pub fn stale_start(&self) -> Option<Params> {
        let start = self.snapshot.as_ref()?.start;
        let now = &self.params;
        let differs = start.algorithm != now.algorithm
            || (start.clusters != now.clusters && now.reads(Setting::Clusters))
            || (start.seed != now.seed && now.reads(Setting::Seed));
        differs.then_some(start)
    }
}
