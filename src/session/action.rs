//! Everything a person can ask for. What takes no argument is a [`Verb`], with
//! its text, tooltip and shortcut in one table from which menus, buttons,
//! keys and the help page are made.

use std::path::PathBuf;

use nalgebra::{Point3, Vector2};

use super::comparison::Comparison;
use super::curves::Curve;
use super::export::ExportChoice;
use super::keeping::{Opening, PartingAnswer};
use super::messages::Message;
use super::scalar::Top;
use super::scene::UpAxis;
use super::seeds::SeedOrder;
use super::selection::Select;
use super::shaping::ShapeDraft;
use super::view::{ColorBy, Layer, SurfaceStyle, ThemeChoice};
use crate::geometry::Bulk;
use crate::inference::{Edit, Method, Params};
use crate::worker::{Pace, SamplingOptions};

/// One user action.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    Verb(Verb),
    /// Chosen from the list of all commands, under this name.
    FromList(String, Box<Action>),
    OpenFile(PathBuf),
    /// Files that were dropped onto the window.
    OpenDropped(Bulk<Vec<PathBuf>>),
    /// A file that was open before, if it is still there.
    OpenRecent(PathBuf),
    /// A file that was open before is no longer there.
    ForgetRecent(PathBuf),
    /// Shows a file in the system's file manager.
    ShowInFolder(PathBuf),
    /// Opens an address in the browser.
    OpenLink(&'static str),
    /// Writes the shown state as it was chosen last.
    Export(PathBuf),
    SetExport(ExportChoice),
    /// Takes the primitives of a file in place of the shown ones.
    TakeFrom(PathBuf),
    /// The same from a text.
    Paste(Bulk<String>),
    SaveScreenshot(PathBuf),
    /// Writes the session to a file.
    SaveSession(PathBuf),
    OpenSession(Opening),
    /// Deletes what was left behind, by its id.
    DiscardFound(u64),
    /// Leaves what was left behind for the next start.
    PutOffFound,
    AnswerParting(PartingAnswer),
    /// As the dialog that asked for the path was set.
    SavePicture(PictureKind, PathBuf),
    SetParams(Params),
    /// Takes the parameters of a method; the seed stays.
    SetMethod(Method),
    SetSampling(SamplingOptions),
    SetPace(Pace),
    /// A slider was let go, or has been held still for a while.
    HandRests,
    /// Shows what the hand makes of a primitive; the end of the gesture makes it
    /// an edit.
    DraftShape(ShapeDraft),
    /// Runs with the parameters and samples as they are set now.
    RunAsSet,
    /// The hand has let go of whatever it dragged: what comes next is another
    /// step for undo.
    EndGesture,
    /// Changes the shown state by hand.
    Edit(Edit),
    /// Judges the merge of two primitives.
    ProposeMergeOf(u32, u32),
    /// Shows a state of the present branch, the last where there are fewer.
    ShowState(usize),
    /// Shows another branch, by id.
    SwitchBranch(u32),
    RenameBranch(u32, String),
    RemoveBranch(u32),
    /// Shows a state of another branch, by id.
    ShowStateOf(u32, usize),
    /// So many seconds have passed while the timeline is played.
    PlayOn(f64),
    /// States a second.
    SetPlaySpeed(u32),
    SetCurve(Curve, bool),
    /// Shows another state beside the present one, or no more.
    Compare(Option<Comparison>),
    /// What moves the camera, for the view of the state beside.
    InOther(Box<Action>),
    /// Undoes so many steps.
    GoBack(usize),
    /// Makes so many steps again that were undone.
    GoOn(usize),
    /// Makes the run with that seed a branch and shows it.
    TakeSeed(u64),
    SetSeedOrder(SeedOrder),
    /// Shows the odds of a sample.
    Explain(Option<u32>),
    /// Selects one primitive, or none.
    Select(Option<u32>),
    /// Adds a primitive to the selection, or takes it out.
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
    /// Where the colour bar ends.
    SetLegendTop(Top),
    /// States over which the uncertainty of labels is taken.
    SetUncertaintyWindow(u32),
    /// Whether boxes and lassos leave out what is hidden behind something else.
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
    /// Closes the error box for all errors up to the one with this number.
    DismissError(u64),
    /// Whether the window has room for one side panel only.
    SetNarrow(bool),
    /// Something that is to be said.
    Say(Message),
    /// Something outside the session went wrong.
    Tell {
        what: String,
        error: String,
    },
    /// Something outside the session went well.
    Note(String),
}

/// Pictures of the 3D view alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureKind {
    Still,
    /// Many, once around the shape.
    Turntable,
}

/// A key, by what is printed on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Key {
    Char(char),
    Function(u8),
    Home,
    Space,
    Escape,
    Backspace,
    Delete,
    Enter,
    Left,
    Right,
}

/// A key with its modifiers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shortcut {
    pub ctrl: bool,
    pub shift: bool,
    pub alt: bool,
    pub key: Key,
}

const fn plain(key: Key) -> Option<Shortcut> {
    Some(Shortcut { ctrl: false, shift: false, alt: false, key })
}
const fn shift(key: Key) -> Option<Shortcut> {
    Some(Shortcut { ctrl: false, shift: true, alt: false, key })
}
const fn ctrl(key: char) -> Option<Shortcut> {
    Some(Shortcut { ctrl: true, shift: false, alt: false, key: Key::Char(key) })
}
const fn ctrl_shift(key: char) -> Option<Shortcut> {
    Some(Shortcut { ctrl: true, shift: true, alt: false, key: Key::Char(key) })
}

impl std::fmt::Display for Shortcut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (held, name) in [(self.ctrl, "Ctrl+"), (self.alt, "Alt+"), (self.shift, "Shift+")] {
            if held {
                f.write_str(name)?;
            }
        }
        match self.key {
            Key::Char(c) => write!(f, "{c}"),
            Key::Function(n) => write!(f, "F{n}"),
            Key::Home => f.write_str("Home"),
            Key::Space => f.write_str("Space"),
            Key::Escape => f.write_str("Esc"),
            Key::Backspace => f.write_str("Backspace"),
            Key::Delete => f.write_str("Delete"),
            Key::Enter => f.write_str("Enter"),
            Key::Left => f.write_str("Left arrow"),
            Key::Right => f.write_str("Right arrow"),
        }
    }
}

/// Under which heading the help page lists a verb.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    File,
    Edit,
    Run,
    Timeline,
    View,
    Window,
    Help,
}

impl Group {
    pub const ALL: [Self; 7] =
        [Self::File, Self::Edit, Self::Run, Self::Timeline, Self::View, Self::Window, Self::Help];

    pub fn text(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Run => "Run",
            Self::Timeline => "Timeline",
            Self::View => "View",
            Self::Window => "Window",
            Self::Help => "Help",
        }
    }
}

/// What is known of a verb.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    pub text: &'static str,
    pub tooltip: &'static str,
    pub shortcut: Option<Shortcut>,
    pub group: Group,
}

macro_rules! verbs {
    ($($verb:ident: $group:ident, $shortcut:expr, $text:literal, $tooltip:literal;)*) => {
        /// An action without an argument.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Verb { $($verb,)* }

        impl Verb {
            pub const ALL: &[Self] = &[$(Self::$verb,)*];

            /// The row of the table.
            pub const fn entry(self) -> Entry {
                match self {
                    $(Self::$verb => Entry {
                        text: $text, tooltip: $tooltip, shortcut: $shortcut, group: Group::$group,
                    },)*
                }
            }
        }
    };
}

verbs! {
    Open: File, ctrl('O'), "Open…", "Open a mesh or a point cloud (OBJ, PLY, STL, OFF, glTF, PCD, LAS, NPY, XYZ …), a result or a session";
    OpenBuiltIn: File, None, "Open built-in shape", "Open the shape that comes with the program";
    SaveSession: File, ctrl('S'), "Save session",
        "Write all of this to one file: shape, parameters, every state and branch, undo history and view";
    SaveSessionAs: File, ctrl_shift('S'), "Save session as…", "Write the session to another file, and go on in that";
    ReopenLast: File, None, "Reopen last session", "Open what was unsaved when the window was closed last";
    Export: File, ctrl('E'), "Export…",
        "Write the segmented cloud or mesh, the primitives' parameters or bodies: choose a format";
    ExportAgain: File, ctrl_shift('E'), "Export again", "Write the file of this shape's last export anew, as it was chosen then";
    CopyPrimitives: File, ctrl('C'), "Copy primitives", "Put the parameters of all primitives into the clipboard, as JSON";
    CopyCsv: File, None, "Copy primitives as CSV",
        "Put the parameters of all primitives into the clipboard, a line of 13 numbers each";
    PastePrimitives: File, ctrl('V'), "Paste primitives",
        "Take the primitives in the clipboard (JSON or CSV) in place of the shown ones";
    TakeFrom: File, ctrl('I'), "Bring in primitives…",
        "Take the primitives of a file (JSON, NPZ or CSV) in place of the shown ones: the points stay";
    SaveScreenshot: File, plain(Key::Function(12)), "Save screenshot…", "Save what the window shows (PNG)";
    ClearRecent: File, None, "Forget recent files", "Empty the list of files that were open before";
    SavePicture: File, shift(Key::Function(12)), "Save picture…",
        "Save the 3D view alone, at any size and also without a background (PNG)";
    SaveTurntable: File, None, "Save turntable…",
        "Save the 3D view once around the shape, as a GIF or as numbered PNG pictures";
    Quit: File, ctrl('Q'), "Quit", "Close the window";

    Undo: Edit, ctrl('Z'), "Undo", "Take back the last change, whatever it was";
    Redo: Edit, ctrl_shift('Z'), "Redo", "Make the change again that was taken back last";
    MergeSelected: Edit, plain(Key::Char('J')), "Merge selected",
        "Join the selected primitives in one, fitted to all their points, whatever the test says";
    JudgeMerge: Edit, shift(Key::Char('J')), "Judge this merge…",
        "Fit one primitive to the two selected, and show what the test says of it";
    SplitSelected: Edit, plain(Key::Char('D')), "Split", "Divide the selected primitive in two and fit both";
    DeleteSelected: Edit, plain(Key::Delete), "Delete", "Remove the selected primitives; their points stay without one";
    RefitSelected: Edit, plain(Key::Char('U')), "Refit", "Fit the selected primitive to its points anew";
    LockSelected: Edit, plain(Key::Char('K')), "Lock or unlock",
        "The sampler leaves locked primitives and their points alone, also when the run starts over";
    DropShape: Edit, plain(Key::Escape), "Cancel the change",
        "Give the primitive that is being dragged its shape back";
    HandlesMove: Edit, plain(Key::Char('V')), "Move by handles",
        "Show arrows on the selected primitive that move it; Ctrl snaps, Esc gives it back";
    HandlesRotate: Edit, plain(Key::Char('Q')), "Rotate by handles",
        "Show rings on the selected primitive that turn it; Ctrl snaps to 15°, Esc gives it back";
    HandlesScale: Edit, plain(Key::Char('X')), "Scale by handles",
        "Show knobs on the selected primitive that change its semi-axes; Ctrl snaps, Esc gives them back";
    HandlesTaper: Edit, shift(Key::Char('T')), "Taper by handles",
        "Show knobs at the selected primitive's top that taper it; Ctrl snaps, Esc gives it back";
    HandlesRoundness: Edit, plain(Key::Char('O')), "Round by handles",
        "Show knobs on the selected primitive that change its exponents ε1 and ε2; Ctrl snaps, Esc gives them back";
    NewCluster: Edit, plain(Key::Char('C')), "New cluster from points",
        "Make the selected points a cluster of their own, with a primitive fitted to them";
    BelongTogether: Edit, plain(Key::Char('G')), "These belong together",
        "Put the selected points in one cluster and pin them there";
    ReleasePoints: Edit, shift(Key::Char('G')), "Release pinned points",
        "Let the sampler choose again for the selected points, or for all pinned ones if none is selected";

    Run: Run, plain(Key::Space), "Run", "Iterate until the run is finished; a finished run, or another method, starts anew";
    Pause: Run, plain(Key::Space), "Pause", "Stop at once, also in the middle of an iteration; nothing is lost";
    StepIteration: Run, plain(Key::Char('N')), "Step iteration",
        "Make one Gibbs iteration, or the next step of a method without iterations";
    StepMerge: Run, plain(Key::Char('M')), "Step merge",
        "Propose the best pair of primitives to merge, with the numbers of the test; then accept or skip it";
    AcceptMerge: Run, plain(Key::Enter), "Accept", "Make the proposed merge and look for the next";
    SkipMerge: Run, plain(Key::Char('S')), "Skip", "Leave this pair apart and look for the next";
    DropMerge: Run, plain(Key::Escape), "Stop merging",
        "Leave the merge that is proposed and propose no other";
    MergeAll: Run, shift(Key::Char('M')), "Merge all",
        "Merge pair after pair until no pair may be merged";
    Reset: Run, plain(Key::Backspace), "Reset", "Back to the start, with the present parameters and seed";
    ToggleLive: Run, plain(Key::Char('R')), "Live",
        "Make the whole run anew at every change of a parameter, as fast as it goes; the last result stays until \
         the next is there";
    Continue: Run, shift(Key::Space), "Continue sampling",
        "Go on from this finished state, with whatever was changed by hand, for T further iterations";
    RunSeeds: Run, shift(Key::Char('R')), "Run 8 seeds",
        "Make the whole run with this seed and the seven after it, in the background, with the present parameters \
         and samples; then take the best";
    StopSeeds: Run, None, "Stop the seeds", "Make no further runs with other seeds; what is finished stays";
    Resample: Run, None, "Sample again", "Sample the shape with these settings and start over";

    FirstState: Timeline, shift(Key::Left), "First state", "Show the start of this branch";
    PreviousState: Timeline, plain(Key::Left), "Previous state", "Show the state one step earlier";
    NextState: Timeline, plain(Key::Right), "Next state", "Show the state one step later";
    LastState: Timeline, shift(Key::Right), "Last state", "Show the newest state of this branch";
    Play: Timeline, plain(Key::Char('T')), "Play", "Show the states of this branch one after the other";
    StopPlaying: Timeline, plain(Key::Char('T')), "Stop playing", "Stay at the shown state";
    ToggleLoop: Timeline, None, "Loop", "Begin again at the start when the last state has been shown";
    ContinueHere: Timeline, ctrl('B'), "Continue from here",
        "Run on from the shown state, as a branch of its own; the later states stay in theirs";

    FrameSelection: View, plain(Key::Char('F')), "Frame selection",
        "Move the camera so that the selected primitives fill the view";
    FrameAll: View, plain(Key::Home), "Frame all", "Move the camera so that the whole shape fills the view";
    ViewFront: View, plain(Key::Char('1')), "Front", "Look from the front";
    ViewBack: View, ctrl('1'), "Back", "Look from behind";
    ViewRight: View, plain(Key::Char('3')), "Right", "Look from the right";
    ViewLeft: View, ctrl('3'), "Left", "Look from the left";
    ViewTop: View, plain(Key::Char('7')), "Top", "Look from above";
    ViewBottom: View, ctrl('7'), "Bottom", "Look from below";
    ToggleOrthographic: View, plain(Key::Char('5')), "Orthographic",
        "Parallel projection instead of perspective";
    ToolClick: View, plain(Key::Char('W')), "Click select", "Left drag orbits, a click selects";
    ToolBox: View, plain(Key::Char('B')), "Box select",
        "Left drag draws a box and selects what is in it; Shift adds, Ctrl takes away, Alt orbits, Esc ends";
    ToolLasso: View, Some(Shortcut { ctrl: false, shift: true, alt: false, key: Key::Char('B') }), "Lasso select",
        "Left drag goes around what is to be selected; Shift adds, Ctrl takes away, Alt orbits, Esc ends";
    TogglePicks: View, plain(Key::Char('P')), "Select points",
        "Clicks, boxes and lassos select single points instead of primitives";
    Deselect: View, plain(Key::Escape), "Deselect", "Select nothing";
    HideSelected: View, plain(Key::Char('H')), "Hide selected", "Hide the selected primitives";
    ShowAll: View, Some(Shortcut { ctrl: false, shift: false, alt: true, key: Key::Char('H') }),
        "Show all primitives", "Show the hidden primitives again";
    ShowSeeds: View, None, "Seeds", "Runs that differ in their seed alone, side by side";
    ShowOdds: View, plain(Key::Char('E')), "Explain the point",
        "Show the odds of each table for the point under the pointer: what the sampler draws its label from";

    ToggleLeftPanel: Window, plain(Key::Function(2)), "Left panel", "Show or hide the shape, the run and its parameters";
    ToggleRightPanel: Window, plain(Key::Function(3)), "Right panel", "Show or hide the list of primitives and the numbers of the selected one";
    ToggleBottomPanel: Window, plain(Key::Function(4)), "Bottom panel", "Show or hide the timeline, the branches, the curves and the figures";
    ToggleLog: Window, plain(Key::Char('L')), "Log", "Everything that happened, newest first";
    ClearLog: Window, None, "Clear log", "Empty the log";
    ZoomIn: Window, ctrl('+'), "Larger", "Draw the whole interface larger";
    ZoomOut: Window, ctrl('-'), "Smaller", "Draw the whole interface smaller";
    ZoomReset: Window, ctrl('0'), "Usual size", "Draw the interface at 100 %";
    ThemeSystem: Window, None, "System theme", "Light or dark as the system says";
    ThemeLight: Window, None, "Light theme", "Always light";
    ThemeDark: Window, None, "Dark theme", "Always dark";
    ResetLayout: Window, None, "Reset layout",
        "Panels, sizes and theme as on the first start; recent files stay";

    ShowCommands: Help, ctrl_shift('P'), "All commands…", "Find any command by its name and run it";
    ShowShortcuts: Help, plain(Key::Function(1)), "Keyboard and mouse", "What keys and mouse do";
    ShowAbout: Help, None, "About Superform", "Version, licence and the paper";
}

/// Further shortcuts of some verbs.
pub const ALTERNATIVES: &[(Option<Shortcut>, Verb)] =
    &[(ctrl('P'), Verb::ShowCommands), (ctrl('='), Verb::ZoomIn)];

impl Verb {
    /// Whether it changes the shown state by hand.
    pub const fn is_edit(self) -> bool {
        matches!(
            self,
            Self::MergeSelected
                | Self::SplitSelected
                | Self::DeleteSelected
                | Self::RefitSelected
                | Self::LockSelected
                | Self::NewCluster
                | Self::BelongTogether
                | Self::ReleasePoints
        )
    }

    /// Every shortcut of the verb, the one that menus show first.
    pub fn shortcuts(self) -> impl Iterator<Item = Shortcut> {
        let others = ALTERNATIVES.iter().filter(move |(_, verb)| *verb == self);
        self.entry().shortcut.into_iter().chain(others.filter_map(|(shortcut, _)| *shortcut))
    }
}

impl From<ThemeChoice> for Verb {
    fn from(choice: ThemeChoice) -> Self {
        match choice {
            ThemeChoice::System => Self::ThemeSystem,
            ThemeChoice::Light => Self::ThemeLight,
            ThemeChoice::Dark => Self::ThemeDark,
        }
    }
}

/// What the mouse does in the viewport, for the help page.
pub const MOUSE: &[(&str, &str)] = &[
    ("Left drag", "Orbit"),
    ("Right or middle drag", "Pan"),
    ("Wheel", "Zoom to the cursor"),
    ("Click", "Select a primitive or the primitive of a point, and explain that point"),
    ("Shift+click", "Add to the selection"),
    ("Ctrl+click", "Take out of the selection"),
    ("Alt+left drag", "Orbit, with any tool"),
    ("Double-click", "Orbit around that place"),
    ("Drop a file", "Open it"),
];

/// What keys do everywhere, for the help page.
pub const EVERYWHERE: &[(&str, &str)] = &[
    ("Tab, Shift+Tab", "To the next or the last control"),
    ("Enter or Space", "Press the control that has the focus"),
    ("Arrow keys", "Turn the slider that has the focus"),
    ("Esc", "Close what is open, then deselect"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_plain_sentences() {
        for verb in Verb::ALL {
            let Entry { text, tooltip, .. } = verb.entry();
            assert!(!text.ends_with(':') && !text.ends_with('.'), "{text}");
            assert!(tooltip.len() > 5 && !tooltip.ends_with('.'), "{text} has no sound tooltip");
            let mut capitals = text.split(' ').skip(1).filter(|w| w.starts_with(char::is_uppercase));
            assert!(capitals.all(|w| ["Superform", "CSV"].contains(&w)), "{text} is in title case");
        }
    }
}
