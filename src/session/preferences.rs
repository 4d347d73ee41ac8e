//! Preferences that persist between starts.

use serde::{Deserialize, Serialize};

use super::Session;
use super::view::ThemeChoice;
use super::window::{ExportChoice, Panel, Window};
use crate::io::StoredPath;
use crate::worker::Pace;

/// Stored form. Missing fields have defaults and unknown ones are ignored, so
/// that older and newer programs can read each other's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    theme: Theme,
    live: bool,
    /// `None` for the maximum speed.
    steps_per_second: Option<u32>,
    zoom: f32,
    left: bool,
    right: bool,
    bottom: bool,
    log: bool,
    recent: Vec<StoredPath>,
    open_folder: Option<StoredPath>,
    save_folder: Option<StoredPath>,
    commands: Vec<String>,
    export: ExportChoice,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Theme {
    System,
    Light,
    Dark,
}

impl Default for Preferences {
    fn default() -> Self {
        Session::new(crate::inference::Params::default(), crate::worker::SamplingOptions::default())
            .preferences()
    }
}

impl Session {
    /// The preferences to store.
    pub fn preferences(&self) -> Preferences {
        let window = &self.window;
        Preferences {
            theme: match self.view.theme {
                ThemeChoice::System => Theme::System,
                ThemeChoice::Light => Theme::Light,
                ThemeChoice::Dark => Theme::Dark,
            },
            live: self.live.is_on,
            steps_per_second: match self.pace {
                Pace::PerSecond(steps) => Some(steps),
                Pace::Unlimited => None,
            },
            zoom: window.zoom,
            left: window.is_kept_open(Panel::Left),
            right: window.is_kept_open(Panel::Right),
            bottom: window.is_kept_open(Panel::Bottom),
            log: self.view.shows_log,
            recent: window.recent.iter().map(|path| StoredPath(path.into())).collect(),
            open_folder: window.open_folder.clone().map(StoredPath),
            save_folder: window.save_folder.clone().map(StoredPath),
            commands: window.commands.clone(),
            export: window.export,
        }
    }

    /// Applies stored preferences, clamping values to their range.
    pub fn recall(&mut self, preferences: Preferences) {
        let Preferences {
            theme,
            live,
            steps_per_second,
            zoom,
            left,
            right,
            bottom,
            log,
            recent,
            open_folder,
            save_folder,
            commands,
            export,
        } = preferences;
        self.view.theme = match theme {
            Theme::System => ThemeChoice::System,
            Theme::Light => ThemeChoice::Light,
            Theme::Dark => ThemeChoice::Dark,
        };
        self.view.shows_log = log;
        self.live.is_on = live;
        self.pace = steps_per_second.map_or(Pace::Unlimited, |steps| Pace::PerSecond(steps.clamp(1, 1000)));
        let mut window = Window {
            recent: recent.into_iter().map(|path| path.0).collect(),
            open_folder: open_folder.map(|path| path.0),
            save_folder: save_folder.map(|path| path.0),
            commands,
            // Options out of their limits are not worth a word.
            export: if export.options.check().is_ok() { export } else { ExportChoice::default() },
            ..Window::default()
        };
        for (panel, shown) in [(Panel::Right, right), (Panel::Left, left), (Panel::Bottom, bottom)] {
            window.set_shown(panel, shown);
        }
        window.set_zoom(zoom);
        self.window = window;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::Params;
    use crate::session::{Action, Verb};
    use crate::worker::SamplingOptions;

    fn fresh() -> Session {
        Session::new(Params::default(), SamplingOptions::default())
    }

    #[test]
    fn what_was_set_is_there_again() {
        let mut session = fresh();
        for verb in [Verb::ThemeDark, Verb::ToggleLive, Verb::ToggleRightPanel, Verb::ZoomIn, Verb::ToggleLog]
        {
            session.apply(Action::Verb(verb));
        }
        session.apply(Action::SetPace(Pace::PerSecond(3)));
        let file = std::env::temp_dir().join("chair.obj");
        session.window.recent.add(&file);
        session.window.open_folder = Some(std::env::temp_dir());
        session.window.remember_command("Run");
        let stored = serde_json::to_string(&session.preferences()).unwrap();
        let mut again = fresh();
        again.recall(serde_json::from_str(&stored).unwrap());
        assert_eq!(again.window, session.window);
        assert_eq!((again.view, again.pace, again.live), (session.view, session.pace, session.live));
    }

    #[test]
    fn another_programs_preferences_are_read_as_far_as_they_go() {
        let mut session = fresh();
        session.recall(serde_json::from_str("{}").unwrap());
        assert_eq!(session.preferences(), fresh().preferences());
        let newer = r#"{"theme": "light", "zoom": 99.0, "steps_per_second": 0, "colour": "mauve"}"#;
        session.recall(serde_json::from_str(newer).unwrap());
        assert_eq!(session.view.theme, ThemeChoice::Light);
        assert_eq!(session.window.zoom, Window::ZOOM.1);
        assert_eq!(session.pace, Pace::PerSecond(1));
    }
}
