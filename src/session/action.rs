//! All user actions, and messages, which may offer one.

use std::path::PathBuf;
use std::time::Duration;

use nalgebra::{Point3, Vector2};

use super::comparison::Comparison;
use super::curves::Curve;
use super::saving::{Opening, PartingAnswer};
use super::scalar::Top;
use super::scene::UpAxis;
use super::seeds::SeedOrder;
use super::selection::Select;
use super::shaping::ShapeDraft;
use super::verb::Verb;
use super::view::{ColorBy, Layer, SurfaceStyle};
use super::window::ExportChoice;
use crate::geometry::Bulk;
use crate::inference::{Edit, Method, Params};
use crate::worker::{Pace, SamplingOptions};

/// One user action.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    Verb(Verb),
    /// A verb chosen from the command palette, under this name.
    FromList(String, Box<Action>),
    OpenFile(PathBuf),
    /// Files that were dropped onto the window.
    OpenDropped(Bulk<Vec<PathBuf>>),
    /// Opens a recent file, if it still exists.
    OpenRecent(PathBuf),
    /// A recent file that no longer exists.
    ForgetRecent(PathBuf),
    /// Shows a file in the system's file manager.
    ShowInFolder(PathBuf),
    /// Opens an address in the browser.
    OpenLink(&'static str),
    /// Exports the shown state with the last options.
    Export(PathBuf),
    SetExport(ExportChoice),
    /// Replaces the shown primitives with those in a file.
    TakeFrom(PathBuf),
    /// The same from a text.
    Paste(Bulk<String>),
    SaveScreenshot(PathBuf),
    /// Writes the session to a file.
    SaveSession(PathBuf),
    OpenSession(Opening),
    /// Deletes a session offered for recovery, by id.
    DiscardFound(u64),
    /// Postpones recovery to the next start.
    PutOffFound,
    AnswerParting(PartingAnswer),
    /// With the settings of the dialog that asked for the path.
    SavePicture(PictureKind, PathBuf),
    SetParams(Params),
    /// Sets the parameters of a method, except the seed.
    SetMethod(Method),
    SetSampling(SamplingOptions),
    SetPace(Pace),
    /// A slider was released, or has not moved for a while.
    HandRests,
    /// Previews a change to a primitive; the end of the gesture makes it an edit.
    DraftShape(ShapeDraft),
    /// Runs with the current parameters and samples.
    RunAsSet,
    /// A drag has ended: the next change is a new undo step.
    EndGesture,
    /// Edits the shown state.
    Edit(Edit),
    /// Tests the merge of two primitives.
    ProposeMergeOf(u32, u32),
    /// Shows a state of the current branch, or the last if there are fewer.
    ShowState(usize),
    /// Shows another branch, by id.
    SwitchBranch(u32),
    RenameBranch(u32, String),
    RemoveBranch(u32),
    /// Shows a state of another branch, by id.
    ShowStateOf(u32, usize),
    /// Seconds elapsed during playback.
    PlayOn(f64),
    /// States per second.
    SetPlaySpeed(u32),
    SetCurve(Curve, bool),
    /// Starts or stops comparing with another state.
    Compare(Option<Comparison>),
    /// A camera action for the view of the compared state.
    InOther(Box<Action>),
    /// Undoes this many steps.
    GoBack(usize),
    /// Redoes this many steps.
    GoOn(usize),
    /// Opens the run with this seed as a branch.
    TakeSeed(u64),
    SetSeedOrder(SeedOrder),
    /// Shows the odds of a sample.
    Explain(Option<u32>),
    /// Selects one primitive, or none.
    Select(Option<u32>),
    /// Adds a primitive to the selection or removes it.
    ToggleSelected(u32),
    /// Changes the selection of primitives, by their ids.
    SelectPrimitives {
        ids: Bulk<Vec<u32>>,
        how: Select,
    },
    /// Changes the selection of samples, by their indices.
    SelectPoints {
        samples: Bulk<Vec<u32>>,
        how: Select,
    },
    SetPrimitiveVisible(u32, bool),
    SetLayer(Layer, bool),
    SetSurfaceStyle(SurfaceStyle),
    /// Diameter in logical pixels.
    SetPointSize(f32),
    SetColorBy(ColorBy),
    /// End of the colour bar.
    SetLegendTop(Top),
    /// Number of states over which the uncertainty of labels is computed.
    SetUncertaintyWindow(u32),
    /// Whether boxes and lassos ignore what is hidden behind something else.
    SetVisibleOnly(bool),
    SetUpAxis(UpAxis),
    /// Angles in radians.
    Orbit {
        right: f64,
        up: f64,
    },
    /// In fractions of the viewport's half size, y up.
    Pan(Vector2<f64>),
    /// Towards the cursor in [−1, 1]², y up.
    Zoom {
        cursor: Vector2<f64>,
        factor: f64,
    },
    /// In scene space.
    SetPivot(Point3<f64>),
    /// Width / height of the viewport.
    SetAspect(f64),
    /// Closes all errors up to the one with this number.
    DismissError(u64),
    /// Whether the window has room for only one side panel.
    SetNarrow(bool),
    /// A message.
    Say(Message),
    /// An error outside the session.
    Tell {
        what: String,
        error: String,
    },
    /// A success outside the session.
    Note(String),
}

/// Pictures of the 3D view alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureKind {
    Still,
    /// A full turn around the shape.
    Turntable,
}

/// Severity of a message, lowest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Only shown in the log.
    Detail,
    /// Shown for a moment.
    Note,
    /// A problem that does not stop the work; shown for a while.
    Warning,
    /// Shown until it is dismissed.
    Error,
}

impl Level {
    pub const ALL: [Self; 4] = [Self::Detail, Self::Note, Self::Warning, Self::Error];

    /// Name of the level.
    pub fn text(self) -> &'static str {
        match self {
            Self::Detail => "Detail",
            Self::Note => "Note",
            Self::Warning => "Warning",
            Self::Error => "Error",
        }
    }
}

/// A message: what happened, why, and what to do.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// Number of the message, from 1; 0 before it is added.
    pub number: u64,
    /// Time since the program started.
    pub at: Duration,
    pub level: Level,
    /// What happened.
    pub what: String,
    /// Why; may be empty.
    pub why: String,
    /// What to do about it; may be empty.
    pub advice: String,
    /// Chain of causes, nearest first; empty if `why` says everything.
    pub chain: Vec<String>,
    /// A button below the message.
    pub offer: Option<Offer>,
}

/// A suggested next action.
#[derive(Debug, Clone, PartialEq)]
pub struct Offer {
    pub text: &'static str,
    pub action: Box<Action>,
}

impl Message {
    /// A message that has not been added yet.
    pub fn new(level: Level, what: impl Into<String>) -> Self {
        Self {
            number: 0,
            at: Duration::ZERO,
            level,
            what: what.into(),
            why: String::new(),
            advice: String::new(),
            chain: Vec::new(),
            offer: None,
        }
    }

    /// An error with its causes, which are joined by `": "`, the nearest first.
    pub fn error(what: impl Into<String>, causes: &str) -> Self {
        let chain = causes.split(": ").map(str::to_owned).filter(|cause| !cause.is_empty()).collect();
        Self { why: causes.to_owned(), chain, ..Self::new(Level::Error, what) }
    }

    #[must_use]
    pub fn because(mut self, why: impl Into<String>) -> Self {
        self.why = why.into();
        self
    }

    #[must_use]
    pub fn advise(mut self, advice: impl Into<String>) -> Self {
        self.advice = advice.into();
        self
    }

    #[must_use]
    pub fn offer(mut self, text: &'static str, action: Action) -> Self {
        self.offer = Some(Offer { text, action: Box::new(action) });
        self
    }

    /// The whole message on one line.
    pub fn line(&self) -> String {
        let mut line = self.what.clone();
        for (joint, part) in [(": ", &self.why), (". ", &self.advice)] {
            if !part.is_empty() {
                line.push_str(joint);
                line.push_str(part);
            }
        }
        line
    }

    /// Time in minutes and seconds.
    pub fn clock(&self) -> String {
        let seconds = self.at.as_secs();
        format!("{}:{:02}", seconds / 60, seconds % 60)
    }

    /// All details for a bug report, on several lines.
    pub fn report(&self) -> String {
        let mut lines = vec![self.what.clone()];
        if self.chain.is_empty() && !self.why.is_empty() {
            lines.push(format!("  because {}", self.why));
        }
        lines.extend(self.chain.iter().map(|cause| format!("  because {cause}")));
        lines.push(format!(
            "Superform {} on {} ({}), {} after its start",
            env!("CARGO_PKG_VERSION"),
            std::env::consts::OS,
            std::env::consts::ARCH,
            self.clock()
        ));
        lines.join("\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_keeps_its_causes_and_reports_all_it_knows() {
        let error = Message::error("a.ply could not be opened", "the header is broken: line 3: no such type");
        assert_eq!(error.chain, ["the header is broken", "line 3", "no such type"]);
        assert_eq!(error.why, "the header is broken: line 3: no such type");
        let error = error.advise("Save it again");
        assert_eq!(
            error.line(),
            "a.ply could not be opened: the header is broken: line 3: no such type. Save it again"
        );
        let report = error.report();
        for part in ["a.ply", "  because line 3\n", env!("CARGO_PKG_VERSION")] {
            assert!(report.contains(part), "{report}");
        }
    }
}
