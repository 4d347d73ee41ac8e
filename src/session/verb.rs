//! Actions without an argument, with text, tooltip and shortcut in one table that menus, buttons,
//! keys and the help page share.

use super::view::ThemeChoice;

/// A key, by its label.
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

/// The section of the help page that lists a verb.
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

/// The entry of a verb.
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
    OpenBuiltIn: File, None, "Open built-in shape", "Open the shape included with the program";
    SaveSession: File, ctrl('S'), "Save session",
        "Save everything to one file: shape, parameters, all states and branches, undo history and view";
    SaveSessionAs: File, ctrl_shift('S'), "Save session as…", "Save the session to another file \
         and continue with that file";
    ReopenLast: File, None, "Reopen last session", "Open the unsaved session from the last time \
         the window was closed";
    Export: File, ctrl('E'), "Export…",
        "Export the segmented cloud or mesh, or the primitives as parameters or meshes";
    ExportAgain: File, ctrl_shift('E'), "Export again", "Repeat this shape's last export with the \
         same file and options";
    CopyPrimitives: File, ctrl('C'), "Copy primitives", "Copy the parameters of all primitives to \
         the clipboard as JSON";
    CopyCsv: File, None, "Copy primitives as CSV",
        "Copy the parameters of all primitives to the clipboard, one line of 13 numbers each";
    PastePrimitives: File, ctrl('V'), "Paste primitives",
        "Replace the shown primitives with those in the clipboard (JSON or CSV)";
    TakeFrom: File, ctrl('I'), "Import primitives…",
        "Replace the shown primitives with those in a file (JSON, NPZ or CSV); the points are kept";
    SaveScreenshot: File, plain(Key::Function(12)), "Save screenshot…", "Save an image of the window (PNG)";
    ClearRecent: File, None, "Clear recent files", "Clear the list of recently opened files";
    SavePicture: File, shift(Key::Function(12)), "Save picture…",
        "Save an image of the 3D view at any size, optionally with a transparent background (PNG)";
    SaveTurntable: File, None, "Save turntable…",
        "Save a full turn around the shape as a GIF or as numbered PNG files";
    Quit: File, ctrl('Q'), "Quit", "Close the window";

    Undo: Edit, ctrl('Z'), "Undo", "Undo the last change";
    Redo: Edit, ctrl_shift('Z'), "Redo", "Redo the last undone change";
    MergeSelected: Edit, plain(Key::Char('J')), "Merge selected",
        "Merge the selected primitives into one, fitted to all their points, regardless of the merge test";
    JudgeMerge: Edit, shift(Key::Char('J')), "Test this merge…",
        "Fit one primitive to the two selected ones and show the result of the merge test";
    SplitSelected: Edit, plain(Key::Char('D')), "Split", "Split the selected primitive into two and fit both";
    DeleteSelected: Edit, plain(Key::Delete), "Delete", "Delete the selected primitives; their \
         points become unassigned";
    RefitSelected: Edit, plain(Key::Char('U')), "Refit", "Fit the selected primitive to its points again";
    LockSelected: Edit, plain(Key::Char('K')), "Lock or unlock",
        "The sampler does not change locked primitives or their points, even when the run restarts";
    DropShape: Edit, plain(Key::Escape), "Cancel change",
        "Restore the primitive that is being dragged";
    HandlesMove: Edit, plain(Key::Char('V')), "Move with handles",
        "Show arrows that move the selected primitive; Ctrl snaps, Esc cancels";
    HandlesRotate: Edit, plain(Key::Char('Q')), "Rotate with handles",
        "Show rings that rotate the selected primitive; Ctrl snaps to 15°, Esc cancels";
    HandlesScale: Edit, plain(Key::Char('X')), "Scale with handles",
        "Show handles that change the semi-axes of the selected primitive; Ctrl snaps, Esc cancels";
    HandlesTaper: Edit, shift(Key::Char('T')), "Taper with handles",
        "Show handles that taper the selected primitive; Ctrl snaps, Esc cancels";
    HandlesRoundness: Edit, plain(Key::Char('O')), "Round with handles",
        "Show handles that change the exponents ε1 and ε2 of the selected primitive; Ctrl snaps, Esc cancels";
    NewCluster: Edit, plain(Key::Char('C')), "New cluster from points",
        "Move the selected points to a new cluster and fit a primitive to them";
    BelongTogether: Edit, plain(Key::Char('G')), "Pin to one cluster",
        "Assign the selected points to one cluster and pin them to it";
    ReleasePoints: Edit, shift(Key::Char('G')), "Unpin points",
        "Let the sampler reassign the selected points, or all pinned points if none are selected";

    Run: Run, plain(Key::Space), "Run", "Iterate until the run finishes. A finished run, or a \
         changed method, restarts";
    Pause: Run, plain(Key::Space), "Pause", "Stop immediately, even in the middle of an \
         iteration; nothing is lost";
    StepIteration: Run, plain(Key::Char('N')), "Step iteration",
        "Run one Gibbs iteration, or the next step of a method without iterations";
    StepMerge: Run, plain(Key::Char('M')), "Step merge",
        "Propose the best pair of primitives to merge and show the merge test; then accept or skip";
    AcceptMerge: Run, plain(Key::Enter), "Accept", "Accept the proposed merge and look for the next";
    SkipMerge: Run, plain(Key::Char('S')), "Skip", "Keep this pair separate and look for the next";
    DropMerge: Run, plain(Key::Escape), "Stop merging",
        "Discard the proposed merge and stop proposing merges";
    MergeAll: Run, shift(Key::Char('M')), "Merge all",
        "Merge pairs until no more pairs can be merged";
    Reset: Run, plain(Key::Backspace), "Reset", "Restart with the current parameters and seed";
    ToggleLive: Run, plain(Key::Char('R')), "Live",
        "Start a new run whenever a parameter changes, at full speed; the last result stays visible until \
         the new one is ready";
    Continue: Run, shift(Key::Space), "Continue sampling",
        "Continue from this finished state, including manual edits, for another T iterations";
    RunSeeds: Run, shift(Key::Char('R')), "Run 8 seeds",
        "Run this seed and the next seven in the background with the current parameters and samples, to \
         choose the best";
    StopSeeds: Run, None, "Stop seed runs", "Stop running other seeds; finished runs are kept";
    Resample: Run, None, "Resample", "Sample the shape with these settings and restart the run";

    FirstState: Timeline, shift(Key::Left), "First state", "Show the first state of this branch";
    PreviousState: Timeline, plain(Key::Left), "Previous state", "Show the previous state";
    NextState: Timeline, plain(Key::Right), "Next state", "Show the next state";
    LastState: Timeline, shift(Key::Right), "Last state", "Show the latest state of this branch";
    Play: Timeline, plain(Key::Char('T')), "Play", "Play the states of this branch in order";
    StopPlaying: Timeline, plain(Key::Char('T')), "Stop playback", "Stop at the shown state";
    ToggleLoop: Timeline, None, "Loop", "Start again from the first state after the last";
    ContinueHere: Timeline, ctrl('B'), "Continue from here",
        "Continue the run from the shown state in a new branch; later states stay in the old branch";

    FrameSelection: View, plain(Key::Char('F')), "Frame selection",
        "Fit the selected primitives in the view";
    FrameAll: View, plain(Key::Home), "Frame all", "Fit the whole shape in the view";
    ViewFront: View, plain(Key::Char('1')), "Front", "Look from the front";
    ViewBack: View, ctrl('1'), "Back", "Look from behind";
    ViewRight: View, plain(Key::Char('3')), "Right", "Look from the right";
    ViewLeft: View, ctrl('3'), "Left", "Look from the left";
    ViewTop: View, plain(Key::Char('7')), "Top", "Look from above";
    ViewBottom: View, ctrl('7'), "Bottom", "Look from below";
    ToggleOrthographic: View, plain(Key::Char('5')), "Orthographic",
        "Use parallel instead of perspective projection";
    ToolClick: View, plain(Key::Char('W')), "Click select", "Drag to orbit, click to select";
    ToolBox: View, plain(Key::Char('B')), "Box select",
        "Drag a box around what to select; Shift adds, Ctrl removes, Alt orbits, Esc leaves the tool";
    ToolLasso: View, Some(Shortcut { ctrl: false, shift: true, alt: false, key: Key::Char('B') }), "Lasso select",
        "Draw around what to select; Shift adds, Ctrl removes, Alt orbits, Esc leaves the tool";
    TogglePicks: View, plain(Key::Char('P')), "Select points",
        "Clicks, boxes and lassos select points instead of primitives";
    Deselect: View, plain(Key::Escape), "Deselect", "Clear the selection";
    HideSelected: View, plain(Key::Char('H')), "Hide selected", "Hide the selected primitives";
    ShowAll: View, Some(Shortcut { ctrl: false, shift: false, alt: true, key: Key::Char('H') }),
        "Show all primitives", "Show the hidden primitives again";
    ShowSeeds: View, None, "Seeds", "Compare runs that differ only in their seed";
    ShowOdds: View, plain(Key::Char('E')), "Explain point",
        "Show the odds of each table for the point under the pointer, from which the sampler draws its label";

    ToggleLeftPanel: Window, plain(Key::Function(2)), "Left panel", "Show or hide the shape, run \
         and parameters";
    ToggleRightPanel: Window, plain(Key::Function(3)), "Right panel", "Show or hide the list of \
         primitives and the inspector";
    ToggleBottomPanel: Window, plain(Key::Function(4)), "Bottom panel", "Show or hide the \
         timeline, branches, curves and metrics";
    ToggleLog: Window, plain(Key::Char('L')), "Log", "Show all messages, newest first";
    ClearLog: Window, None, "Clear log", "Clear the log";
    ZoomIn: Window, ctrl('+'), "Larger", "Make the interface larger";
    ZoomOut: Window, ctrl('-'), "Smaller", "Make the interface smaller";
    ZoomReset: Window, ctrl('0'), "Default size", "Set the interface to 100 %";
    ThemeSystem: Window, None, "System theme", "Follow the system's light or dark theme";
    ThemeLight: Window, None, "Light theme", "Use the light theme";
    ThemeDark: Window, None, "Dark theme", "Use the dark theme";
    ResetLayout: Window, None, "Reset layout",
        "Restore the default panels, sizes and theme; recent files are kept";

    ShowCommands: Help, ctrl_shift('P'), "All commands…", "Find and run any command by name";
    ShowShortcuts: Help, plain(Key::Function(1)), "Keyboard and mouse", "Show keyboard shortcuts \
         and mouse controls";
    ShowAbout: Help, None, "About Superform", "Version, licence and paper";
}

/// Further shortcuts of some verbs.
pub const ALTERNATIVES: &[(Option<Shortcut>, Verb)] =
    &[(ctrl('P'), Verb::ShowCommands), (ctrl('='), Verb::ZoomIn)];

impl Verb {
    /// Whether it edits the shown state.
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

    /// All shortcuts of the verb, starting with the one shown in menus.
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

/// Mouse controls of the viewport, for the help page.
pub const MOUSE: &[(&str, &str)] = &[
    ("Left drag", "Orbit"),
    ("Right or middle drag", "Pan"),
    ("Wheel", "Zoom at the pointer"),
    ("Click", "Select a primitive. On a point: select its primitive and explain the point"),
    ("Shift+click", "Add to the selection"),
    ("Ctrl+click", "Remove from the selection"),
    ("Alt+left drag", "Orbit with any tool"),
    ("Double-click", "Set the orbit centre"),
    ("Drop a file", "Open it"),
];

/// Keys that work everywhere, for the help page.
pub const EVERYWHERE: &[(&str, &str)] = &[
    ("Tab, Shift+Tab", "Move to the next or previous control"),
    ("Enter or Space", "Press the focused control"),
    ("Arrow keys", "Change the focused slider"),
    ("Esc", "Close open panels and dialogs, then clear the selection"),
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
