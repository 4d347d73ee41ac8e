//! Messages about successes and failures with the actions they offer, and the handling of opened
//! and recent files.

use std::path::{Path, PathBuf};

use super::action::{Action, Level, Message};
use super::saving::{Opening, Parting};
use super::verb::Verb;
use super::window::Window;
use super::{Effect, Session};
use crate::inference::Occurrence;
use crate::io::{self, Format};
use crate::worker::{Activity, FAULT, Source};

impl Session {
    /// Adds an error with advice that depends on the current activity.
    pub(super) fn fail(&mut self, what: String, causes: &str) {
        let message = Message::error(what, causes);
        let message = if message.what == FAULT {
            message
                .advise(
                    "The last good state is kept; nothing else is lost. Run again or try another seed. If \
                     it happens again, please report the problem with the details, the shape and the \
                     parameters",
                )
                .offer("Run again", Action::Verb(Verb::Run))
        } else {
            match self.activity {
                Activity::Loading => {
                    let advice = if self.loaded.is_some() {
                        "The current shape stays open. Choose another file, or repair this file and open it \
                         again"
                    } else {
                        "Choose another file, or repair this file and open it again"
                    };
                    message.advise(advice).offer(Verb::Open.entry().text, Action::Verb(Verb::Open))
                }
                Activity::Writing => {
                    message.advise("Nothing was written. Choose an existing folder with write permission")
                }
                _ => message,
            }
        };
        self.messages.add(message);
    }

    /// Adds a note about a written file.
    pub(super) fn tell_written(&mut self, format: Format, path: PathBuf, notes: &[String]) {
        let kind = format.kind().title().to_lowercase();
        let what = kind.split(',').next().unwrap_or(&kind);
        let text = format!("Wrote the {what} as {} to {}", format.title(), path.display());
        let message = Message::new(Level::Note, text).because(notes.join("; "));
        self.messages.add(message.offer("Show in folder", Action::ShowInFolder(path)));
    }

    /// Adds a note about deleted primitives that offers Undo.
    pub(super) fn tell_deleted(&mut self, occurrences: &[Occurrence]) {
        let deleted: Vec<String> = occurrences
            .iter()
            .filter_map(|o| if let Occurrence::Deleted { id, .. } = o { Some(id.to_string()) } else { None })
            .collect();
        let text = match &deleted[..] {
            [] => return,
            [one] => format!("Primitive {one} deleted"),
            several => format!("Primitives {} deleted", several.join(", ")),
        };
        let undo = Verb::Undo;
        self.messages.add(Message::new(Level::Note, text).offer(undo.entry().text, Action::Verb(undo)));
    }

    /// Opens a shape or a session and remembers its folder.
    pub(super) fn open_file(&mut self, path: PathBuf) -> Vec<Effect> {
        self.window.open_folder = path.parent().map(PathBuf::from);
        if io::has_session_ending(&path) {
            return self.leave(Parting::Open(Opening::File(path)));
        }
        self.open(Source::File(path))
    }

    /// Opens the first file that can be a shape or a session, with a note if there were others.
    pub(super) fn open_dropped(&mut self, paths: Vec<PathBuf>) -> Vec<Effect> {
        let count = paths.len();
        let readable = paths
            .iter()
            .position(|path| io::has_shape_ending(path) || io::has_session_ending(path))
            .unwrap_or_default();
        let Some(path) = paths.into_iter().nth(readable) else { return Vec::new() };
        if count > 1 {
            let name = path.file_name().unwrap_or(path.as_os_str()).display();
            let text = format!("{name} was opened out of {count} dropped files");
            self.messages.push(Level::Note, text, "only one shape can be open at a time");
        }
        // As from the menu, so that it can be undone.
        self.apply(Action::OpenFile(path))
    }

    pub(super) fn forget_recent(&mut self, path: &Path) {
        self.window.recent.forget(path);
        let text = format!("{} no longer exists", path.display());
        self.messages.push(Level::Warning, text, "it was removed from the recent files");
    }

    /// Resets the window to its defaults, except for recent files and folders.
    pub(super) fn reset_layout(&mut self) -> Vec<Effect> {
        let old = std::mem::take(&mut self.window);
        self.window = Window {
            recent: old.recent,
            open_folder: old.open_folder,
            save_folder: old.save_folder,
            export: old.export,
            commands: old.commands,
            ..Window::default()
        };
        self.view.theme = super::view::ThemeChoice::default();
        self.view.shows_log = false;
        vec![Effect::ResetLayout]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Bulk;
    use crate::inference::Params;
    use crate::worker::{Command, Event, SamplingOptions};

    fn session() -> Session {
        Session::new(Params::default(), SamplingOptions::default())
    }

    #[test]
    fn a_fault_in_the_sampler_offers_to_run_again() {
        let mut session = session();
        session.activity = Activity::Running;
        session.absorb(Event::Failed { what: FAULT.to_owned(), error: "index out of bounds".to_owned() });
        let message = session.messages.open_error().unwrap();
        assert!(message.advice.contains("The last good state is kept"), "{}", message.advice);
        let offer = message.offer.as_ref().unwrap();
        assert_eq!((offer.text, &*offer.action), ("Run again", &Action::Verb(Verb::Run)));
    }

    #[test]
    fn of_several_dropped_files_the_first_shape_is_opened() {
        let mut session = session();
        let paths = ["a.txt.bak", "b.PLY", "c.obj"].map(PathBuf::from).to_vec();
        let effects = session.apply(Action::OpenDropped(paths.into()));
        let [Effect::Send(Command::Load { source, .. })] = &effects[..] else { panic!("{effects:?}") };
        assert_eq!(*source, Source::File("b.PLY".into()));
        assert!(session.messages.iter().any(|m| m.what.contains("b.PLY was opened")));
        assert!(session.apply(Action::OpenDropped(Bulk::default())).is_empty());
    }

    #[test]
    fn a_file_that_is_gone_is_forgotten_and_that_is_said() {
        let mut session = session();
        let path = std::env::temp_dir().join("gone.ply");
        session.window.recent.add(&path);
        let effects = session.apply(Action::OpenRecent(path.clone()));
        assert!(matches!(&effects[..], [Effect::OpenIfThere(p)] if *p == path));
        session.apply(Action::ForgetRecent(path));
        assert!(session.window.recent.is_empty());
        assert!(session.messages.iter().any(|m| m.level == Level::Warning && m.what.contains("gone.ply")));
    }

    #[test]
    fn resetting_the_layout_keeps_the_recent_files() {
        let mut session = session();
        session.window.recent.add(Path::new("chair.ply"));
        for verb in [Verb::ToggleLeftPanel, Verb::ZoomIn, Verb::ThemeLight] {
            session.apply(Action::Verb(verb));
        }
        let effects = session.apply(Action::Verb(Verb::ResetLayout));
        assert!(matches!(effects[..], [Effect::ResetLayout]));
        let expected = Window { recent: session.window.recent.clone(), ..Window::default() };
        assert_eq!(session.window, expected);
        assert!(!session.window.recent.is_empty());
    }
}
