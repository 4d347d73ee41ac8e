//! Window settings: open panels, interface scale, recent files.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::io::{ExportOptions, Format};

/// The closable panels around the viewport.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Panel {
    Left,
    Right,
    Bottom,
}

/// Number of recent files.
const RECENT: usize = 10;
/// Number of recent commands.
const COMMANDS: usize = 12;

/// Recent files, newest first.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Recent {
    paths: Vec<PathBuf>,
}

impl Recent {
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Path> {
        self.paths.iter().map(PathBuf::as_path)
    }

    pub fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    /// Puts a file first; drops the oldest if there are too many.
    pub fn add(&mut self, path: &Path) {
        // The working folder may be another one next time.
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.forget(&path);
        self.paths.insert(0, path);
        self.paths.truncate(RECENT);
    }

    pub fn forget(&mut self, path: &Path) {
        self.paths.retain(|known| known != path);
    }

    pub fn clear(&mut self) {
        self.paths.clear();
    }
}

impl FromIterator<PathBuf> for Recent {
    /// Newest first.
    fn from_iter<T: IntoIterator<Item = PathBuf>>(paths: T) -> Self {
        Self { paths: paths.into_iter().take(RECENT).collect() }
    }
}

/// The options chosen in the export dialog.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExportChoice {
    pub format: Format,
    pub options: ExportOptions,
}

impl Default for ExportChoice {
    fn default() -> Self {
        Self { format: Format::CloudPly, options: ExportOptions::default() }
    }
}

/// Settings of the window apart from the shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    pub(super) left: bool,
    pub(super) right: bool,
    pub(super) bottom: bool,
    /// There is room for only one side panel: this one.
    pub(super) is_narrow: bool,
    pub(super) front: Panel,
    /// Scale of the interface.
    pub zoom: f32,
    pub shows_commands: bool,
    pub recent: Recent,
    /// Folders of the last opened and written file.
    pub open_folder: Option<PathBuf>,
    pub save_folder: Option<PathBuf>,
    /// Options of the last export.
    pub export: ExportChoice,
    /// Names of the commands that were chosen from the list of all commands,
    /// newest first.
    pub commands: Vec<String>,
}

impl Default for Window {
    fn default() -> Self {
        Self {
            left: true,
            right: true,
            bottom: true,
            is_narrow: false,
            front: Panel::Left,
            zoom: 1.0,
            shows_commands: false,
            recent: Recent::default(),
            open_folder: None,
            save_folder: None,
            export: ExportChoice::default(),
            commands: Vec::new(),
        }
    }
}

impl Window {
    /// Limits of `zoom`.
    pub const ZOOM: (f32, f32) = (0.5, 3.0);
    /// One zoom step.
    const ZOOM_STEP: f32 = 0.1;

    /// Whether the panel is open if there is room for all.
    pub(super) fn is_kept_open(&self, panel: Panel) -> bool {
        match panel {
            Panel::Left => self.left,
            Panel::Right => self.right,
            Panel::Bottom => self.bottom,
        }
    }

    /// Whether the panel is visible.
    pub fn shows(&self, panel: Panel) -> bool {
        match panel {
            Panel::Bottom => self.bottom,
            side => self.is_kept_open(side) && (!self.is_narrow || self.front == side),
        }
    }

    /// Opens or closes a panel. In a narrow window, opening one side panel closes the other.
    pub fn set_shown(&mut self, panel: Panel, shown: bool) {
        let open = match panel {
            Panel::Left => &mut self.left,
            Panel::Right => &mut self.right,
            Panel::Bottom => &mut self.bottom,
        };
        *open = shown;
        if shown && panel != Panel::Bottom {
            self.front = panel;
        }
    }

    pub fn toggle(&mut self, panel: Panel) {
        self.set_shown(panel, !self.shows(panel));
    }

    /// Whether there is room for one side panel only.
    pub fn is_narrow(&self) -> bool {
        self.is_narrow
    }

    pub(super) fn set_narrow(&mut self, narrow: bool) {
        self.is_narrow = narrow;
    }

    /// Changes the interface scale by this many steps.
    pub(super) fn zoom_by(&mut self, steps: f32) {
        self.set_zoom((10.0 * (self.zoom + steps * Self::ZOOM_STEP)).round() / 10.0);
    }

    /// Clamps values to their range.
    pub fn set_zoom(&mut self, zoom: f32) {
        if zoom.is_finite() {
            self.zoom = zoom.clamp(Self::ZOOM.0, Self::ZOOM.1);
        }
    }

    /// Remembers a chosen command.
    pub(super) fn remember_command(&mut self, name: &str) {
        self.commands.retain(|known| known != name);
        self.commands.insert(0, name.to_owned());
        self.commands.truncate(COMMANDS);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recent_files_are_few_and_each_once() {
        let mut recent = Recent::default();
        let root = std::env::temp_dir();
        for i in 0..15 {
            recent.add(&root.join(format!("{i}.ply")));
        }
        recent.add(&root.join("9.ply"));
        assert_eq!(recent.iter().len(), RECENT);
        assert_eq!(recent.iter().next(), Some(root.join("9.ply").as_path()));
        assert_eq!(recent.iter().filter(|p| p.ends_with("9.ply")).count(), 1);
        recent.forget(&root.join("9.ply"));
        assert!(recent.iter().all(|p| !p.ends_with("9.ply")));
        recent.add(Path::new("relative.obj"));
        assert!(recent.iter().all(Path::is_absolute));
    }

    #[test]
    fn in_a_narrow_window_one_side_takes_the_place_of_the_other() {
        let mut window = Window::default();
        assert!(window.shows(Panel::Left) && window.shows(Panel::Right));
        window.set_narrow(true);
        assert!(window.shows(Panel::Left) && !window.shows(Panel::Right));
        window.toggle(Panel::Right);
        assert!(!window.shows(Panel::Left) && window.shows(Panel::Right));
        window.toggle(Panel::Right);
        assert!(!window.shows(Panel::Left) && !window.shows(Panel::Right));
        window.toggle(Panel::Left);
        assert!(window.shows(Panel::Left) && window.shows(Panel::Bottom));
        window.set_narrow(false);
        assert!(window.shows(Panel::Left) && !window.shows(Panel::Right), "it was closed by hand");
    }

    #[test]
    fn zooming_is_even_and_limited() {
        let mut window = Window::default();
        window.zoom_by(1.0);
        window.zoom_by(1.0);
        assert_eq!(window.zoom, 1.2);
        for _ in 0..50 {
            window.zoom_by(-1.0);
        }
        assert_eq!(window.zoom, Window::ZOOM.0);
        window.set_zoom(f32::NAN);
        assert_eq!(window.zoom, Window::ZOOM.0);
    }
}
