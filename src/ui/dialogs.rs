//! File dialogs: the system's dialog outside the window's thread or, without one, a text field for
//! the path.

use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::time::{Duration, Instant};

use egui::{Context, Label, Modal, RichText, TextEdit};

use super::pictures;
use super::theme::Palette;
use super::widgets::{dialog_body, dialog_width};
use crate::io::{self, AnimationFormat, Format};
use crate::session::action::{Action, PictureKind};

/// Dialogs cancelled by a person stay open longer than this. Without a dialog,
/// the answer comes within about 15 ms.
const TOO_FAST_FOR_A_PERSON: Duration = Duration::from_millis(150);

/// Height of the path field with its surroundings and the buttons.
const FIELD: f32 = 130.0;

/// A running system dialog.
type Answer = Pin<Box<dyn Future<Output = Option<rfd::FileHandle>> + Send>>;

/// Purpose of the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    Open,
    Export(Format),
    Primitives,
    Screenshot,
    Session,
    Picture(PictureKind, AnimationFormat),
}

impl Purpose {
    /// Whether the file must exist.
    pub fn is_reading(self) -> bool {
        matches!(self, Self::Open | Self::Primitives)
    }

    fn title(self) -> &'static str {
        match self {
            Self::Open => "Open a shape",
            Self::Export(_) => "Export",
            Self::Primitives => "Import primitives",
            Self::Screenshot => "Save screenshot",
            Self::Session => "Save session",
            Self::Picture(PictureKind::Still, _) => "Save picture",
            Self::Picture(PictureKind::Turntable, AnimationFormat::Gif) => "Save turntable",
            Self::Picture(PictureKind::Turntable, AnimationFormat::Pngs) => {
                "Choose a folder for the turntable"
            }
        }
    }

    fn button(self) -> &'static str {
        if self.is_reading() { "Open" } else { "Save" }
    }

    /// Name of the file kind and its extensions.
    fn filter(self) -> (&'static str, Vec<&'static str>) {
        match self {
            Self::Open => ("Shapes, results and sessions", openable()),
            Self::Export(format) => (format.kind().title(), vec![format.ending()]),
            Self::Primitives => ("Primitives", vec!["json", "npz", "csv"]),
            Self::Screenshot | Self::Picture(PictureKind::Still, _) => ("Picture", vec!["png"]),
            Self::Session => ("Session", vec![io::SESSION_ENDING]),
            Self::Picture(PictureKind::Turntable, AnimationFormat::Gif) => ("Animation", vec!["gif"]),
            Self::Picture(PictureKind::Turntable, AnimationFormat::Pngs) => ("Folder", vec![]),
        }
    }

    fn action(self, path: PathBuf) -> Action {
        match self {
            Self::Open => Action::OpenFile(path),
            Self::Export(_) => Action::Export(path),
            Self::Primitives => Action::TakeFrom(path),
            Self::Screenshot => Action::SaveScreenshot(path),
            Self::Session => Action::SaveSession(self.completed(path)),
            Self::Picture(kind, format) => {
                Action::SavePicture(kind, pictures::with_ending(kind, format, path))
            }
        }
    }
}

impl Purpose {
    /// The path with the extension of session files.
    fn completed(self, path: PathBuf) -> PathBuf {
        if self != Self::Session || io::has_session_ending(&path) {
            return path;
        }
        let mut name = path.into_os_string();
        name.push(format!(".{}", io::SESSION_ENDING));
        name.into()
    }
}

/// Extensions of all files that can be opened.
fn openable() -> Vec<&'static str> {
    [io::SHAPE_ENDINGS, &[io::SESSION_ENDING, "json"]].concat()
}

/// An open system dialog.
#[derive(Debug)]
struct Pending {
    purpose: Purpose,
    /// Initial text of the path field, if it is needed.
    typed: String,
    /// The path, and how long the dialog was open.
    answer: Receiver<(Option<PathBuf>, Duration)>,
}

/// The dialog for typing a path.
#[derive(Debug)]
struct Prompt {
    purpose: Purpose,
    text: String,
    reason: Option<&'static str>,
    is_new: bool,
    /// The existing file to be replaced, after it was entered once.
    replaces: Option<PathBuf>,
}

impl Prompt {
    fn new(purpose: Purpose, text: String, reason: Option<&'static str>) -> Self {
        Self { purpose, text, reason, is_new: true, replaces: None }
    }

    /// A note about the current path.
    fn note(&self) -> Option<&'static str> {
        let typed = self.text.trim();
        if typed.is_empty() || self.replaces.is_some() {
            return None;
        }
        let path = expand(typed);
        if self.purpose.is_reading() {
            return if path.is_dir() {
                Some("This is a folder")
            } else {
                (!path.exists()).then_some("File not found")
            };
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder.is_some_and(|folder| !folder.is_dir()).then_some("Folder not found")
    }

    /// Handles an entered path; `None` if it must be confirmed first.
    fn enter(&mut self) -> Option<Action> {
        let path = self.purpose.completed(expand(self.text.trim()));
        if !self.purpose.is_reading() && path.exists() && self.replaces.as_ref() != Some(&path) {
            self.replaces = Some(path);
            return None;
        }
        Some(self.purpose.action(path))
    }
}

#[derive(Debug)]
pub(super) struct Dialogs {
    /// Whether system dialogs are used.
    system: bool,
    pending: Option<Pending>,
    prompt: Option<Prompt>,
}

impl Dialogs {
    pub(super) fn new(system: bool) -> Self {
        Self { system, pending: None, prompt: None }
    }

    /// Asks for a path, starting in `folder`. `name` is suggested for a file to be written.
    pub(super) fn ask(&mut self, ctx: &Context, purpose: Purpose, name: &str, folder: Option<&Path>) {
        if self.pending.is_some() || self.prompt.is_some() {
            return;
        }
        let suggestion = match purpose {
            Purpose::Open | Purpose::Primitives => String::new(),
            Purpose::Export(_) => name.to_owned(),
            Purpose::Screenshot => format!("{name}.png"),
            Purpose::Session => format!("{name}.{}", io::SESSION_ENDING),
            Purpose::Picture(kind, format) => pictures::suggestion(kind, format, name),
        };
        // What is typed starts in that folder.
        let typed = match (folder, purpose) {
            (Some(folder), Purpose::Open | Purpose::Primitives) => {
                format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR)
            }
            (Some(folder), _) => folder.join(&suggestion).display().to_string(),
            (None, _) => suggestion.clone(),
        };
        if !self.system {
            self.prompt = Some(Prompt::new(purpose, typed, None));
            return;
        }
        let (kind, extensions) = purpose.filter();
        let mut dialog = rfd::AsyncFileDialog::new().set_title(purpose.title());
        if !extensions.is_empty() {
            dialog = dialog.add_filter(kind, &extensions);
        }
        if let Some(folder) = folder {
            dialog = dialog.set_directory(folder);
        }
        let (sender, answer) = sync_channel(1);
        let ctx = ctx.clone();
        let wait = move |future: Answer| {
            // Measured here: a slow frame of the window's must not count.
            let asked = Instant::now();
            let path = pollster::block_on(future).map(|handle| handle.path().to_owned());
            // The window may have been closed meanwhile: then nobody wants to know.
            let _ = sender.send((path, asked.elapsed()));
            ctx.request_repaint();
        };
        // The dialog is made here, because some systems insist on the window's
        // thread, and awaited there.
        let future: Answer = if purpose.is_reading() {
            Box::pin(dialog.pick_file())
        } else {
            Box::pin(dialog.set_file_name(&suggestion).save_file())
        };
        match std::thread::Builder::new().name("file dialog".to_owned()).spawn(move || wait(future)) {
            Ok(_) => {
                self.pending = Some(Pending { purpose, typed, answer });
            }
            Err(error) => {
                tracing::warn!("cannot start a thread for the file dialog: {error}");
                let reason = Some("The system's file dialog could not be opened.");
                self.prompt = Some(Prompt::new(purpose, typed, reason));
            }
        }
    }

    pub(super) fn show(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        self.receive(actions);
        self.show_prompt(ctx, actions);
    }

    fn receive(&mut self, actions: &mut Vec<Action>) {
        let Some(pending) = &self.pending else { return };
        let (answer, took) = match pending.answer.try_recv() {
            Ok(answer) => answer,
            Err(TryRecvError::Empty) => return,
            // The dialog's thread has died: as if there were no dialog.
            Err(TryRecvError::Disconnected) => (None, Duration::ZERO),
        };
        let Some(pending) = self.pending.take() else { return };
        match answer {
            Some(path) => actions.push(pending.purpose.action(path)),
            None if took < TOO_FAST_FOR_A_PERSON => {
                let reason =
                    Some("No file dialog is available on this system (no desktop portal responded).");
                let (purpose, text) = (pending.purpose, pending.typed);
                self.prompt = Some(Prompt::new(purpose, text, reason));
            }
            None => {}
        }
    }

    fn show_prompt(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        let Some(prompt) = &mut self.prompt else { return };
        let mut done = false;
        let frame = egui::Frame::popup(&ctx.global_style()).inner_margin(14.0);
        let response = Modal::new(egui::Id::unique("path prompt")).frame(frame).show(ctx, |ui| {
            ui.set_width(dialog_width(ctx, 460.0));
            ui.heading(prompt.purpose.title());
            ui.add_space(4.0);
            if let Some(reason) = prompt.reason {
                let text = if prompt.purpose.is_reading() {
                    format!("{reason} Type the file's path or drop the file onto the window.")
                } else {
                    format!("{reason} Type the file's path.")
                };
                dialog_body(ui, FIELD, |ui| {
                    ui.add(Label::new(RichText::new(text).color(Palette::of(ui).weak)).wrap());
                });
                ui.add_space(4.0);
            }
            let label = ui.label("File path").id;
            let field = TextEdit::singleline(&mut prompt.text).desired_width(f32::INFINITY);
            let field = ui.add(field).labelled_by(label);
            if std::mem::take(&mut prompt.is_new) {
                field.request_focus();
            }
            if field.changed() {
                prompt.replaces = None;
            }
            if let Some(note) = prompt.note() {
                ui.add_space(4.0);
                ui.add(Label::new(RichText::new(note).small().color(Palette::of(ui).weak)).wrap());
            }
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            if let Some(path) = &prompt.replaces {
                ui.add_space(4.0);
                let name = path.file_name().unwrap_or(path.as_os_str()).display();
                let text = format!("{name} already exists. Replace it?");
                ui.add(Label::new(RichText::new(text).color(ui.visuals().warn_fg_color)).wrap());
            }
            ui.add_space(8.0);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let is_empty = prompt.text.trim().is_empty();
                let text = if prompt.replaces.is_some() { "Replace" } else { prompt.purpose.button() };
                let palette = Palette::of(ui);
                let text = RichText::new(text).color(palette.on_accent).strong();
                let button = egui::Button::new(text).fill(palette.accent).min_size(egui::vec2(72.0, 0.0));
                let pressed =
                    ui.add_enabled(!is_empty, button).on_disabled_hover_text("Type a path first").clicked();
                if (pressed || entered) && !is_empty {
                    match prompt.enter() {
                        Some(action) => {
                            actions.push(action);
                            done = true;
                        }
                        // Seen in the next frame.
                        None => ui.ctx().request_repaint(),
                    }
                }
                done |= ui.button("Cancel").on_hover_text("Close this dialog (Esc)").clicked();
            });
        });
        if done || response.should_close() {
            self.prompt = None;
        }
    }
}

/// A path as typed: `~/` is the home folder.
pub(super) fn expand(path: &str) -> PathBuf {
    match (path.strip_prefix("~/"), std::env::home_dir()) {
        (Some(rest), Some(home)) => home.join(rest),
        _ => PathBuf::from(path),
    }
}
