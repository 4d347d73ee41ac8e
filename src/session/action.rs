//! Everything a person can ask for. What takes no argument is a [`Verb`], with
//! its text, tooltip and shortcut in one table from which menus, buttons,
//! keys and the help page are made.

use std::path::PathBuf;

use nalgebra::{Point3, Vector2};

use super::scene::UpAxis;
use super::selection::Select;
use super::shaping::ShapeDraft;
use super::view::{ColorBy, Layer, SurfaceStyle, ThemeChoice};
use crate::inference::{Edit, Method, Params};
use crate::worker::{Pace, SamplingOptions};

/// One user action.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    Verb(Verb),
    OpenFile(PathBuf),
    Export(Export, PathBuf),
    SaveScreenshot(PathBuf),
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
    /// Selects one primitive, or none.
    Select(Option<u32>),
    /// Adds a primitive to the selection, or takes it out.
    ToggleSelected(u32),
    /// Changes the selection of primitives, by their ids.
    SelectPrimitives {
        ids: Vec<u32>,
        how: Select,
    },
    /// Changes the selection of samples, by their indices.
    SelectPoints {
        samples: Vec<u32>,
        how: Select,
    },
    SetPrimitiveVisible(u32, bool),
    SetLayer(Layer, bool),
    SetSurfaceStyle(SurfaceStyle),
    /// Diameter in logical pixels.
    SetPointSize(f32),
    SetColorBy(ColorBy),
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
    /// Closes the error box.
    DismissErrors,
    /// Something outside the session went wrong.
    Tell {
        what: String,
        error: String,
    },
    /// Something outside the session went well.
    Note(String),
}

/// What can be written to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Export {
    Cloud,
    Primitives,
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
            Key::Left => f.write_str("←"),
            Key::Right => f.write_str("→"),
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
    Help,
}

impl Group {
    pub const ALL: [Self; 6] = [Self::File, Self::Edit, Self::Run, Self::Timeline, Self::View, Self::Help];

    pub fn text(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Run => "Run",
            Self::Timeline => "Timeline",
            Self::View => "View",
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
    Open: File, ctrl('O'), "Open…", "Open a mesh or a point cloud (OBJ, PLY, STL, OFF, glTF, XYZ)";
    OpenBuiltIn: File, None, "Open built-in shape", "Open the shape that comes with the program";
    ExportCloud: File, ctrl('E'), "Export segmented cloud…",
        "Write every input point with its label and colour, in input order (PLY)";
    ExportPrimitives: File, ctrl_shift('E'), "Export primitives…",
        "Write the parameters of all primitives in input units (JSON)";
    SaveScreenshot: File, plain(Key::Function(12)), "Save screenshot…", "Save what the window shows (PNG)";
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
    Resample: Run, None, "Sample again", "Sample the shape with these settings and start over";

    FirstState: Timeline, shift(Key::Left), "First state", "Show the start of this branch";
    PreviousState: Timeline, plain(Key::Left), "Previous state", "Show the state one step earlier";
    NextState: Timeline, plain(Key::Right), "Next state", "Show the state one step later";
    LastState: Timeline, shift(Key::Right), "Last state", "Show the newest state of this branch";
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
    ToggleLog: View, plain(Key::Char('L')), "Log", "Everything that happened, newest first";
    ThemeSystem: View, None, "System", "Light or dark as the system says";
    ThemeLight: View, None, "Light", "Always light";
    ThemeDark: View, None, "Dark", "Always dark";

    ShowShortcuts: Help, plain(Key::Function(1)), "Keyboard and mouse", "What keys and mouse do";
    ShowAbout: Help, None, "About Superform", "Version, licence and the paper";
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
    ("Click", "Select a primitive or the primitive of a point"),
    ("Shift+click", "Add to the selection"),
    ("Ctrl+click", "Take out of the selection"),
    ("Alt+left drag", "Orbit, with any tool"),
    ("Double-click", "Orbit around that place"),
    ("Drop a file", "Open it"),
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
            let capitals = text.split(' ').skip(1).filter(|w| w.starts_with(char::is_uppercase));
            assert!(capitals.clone().all(|w| w == "Superform"), "{text} is in title case");
        }
    }
}
