//! The export dialog: format, options, approximate size and file name.

use std::path::PathBuf;

use egui::text::{LayoutJob, TextFormat};
use egui::{
    Button, Context, DragValue, FontId, Id, Modal, RichText, ScrollArea, TextEdit, TextStyle, Ui, vec2,
};

use super::dialogs::expand;
use super::theme::{self, Palette};
use super::widgets;
use crate::io::{Choice, ExportOptions, Format, Kind};
use crate::session::action::Action;
use crate::session::{ExportChoice, Session};

/// Logical pixels.
const FORMATS: f32 = 400.0;
const OPTIONS: f32 = 320.0;
const HEIGHT: f32 = 430.0;
const GAP: f32 = 20.0;
/// Of the field for the path and the buttons.
const BELOW: f32 = 2.0 * theme::ROW + 40.0;

/// Requests to the dialog in this frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asked {
    Export,
    /// Choose the file in the system's dialog.
    Browse,
    Close,
}

#[derive(Debug)]
struct Open {
    choice: ExportChoice,
    path: String,
    /// The existing file, once its replacement has to be confirmed.
    replaces: Option<PathBuf>,
    /// Frames in which the list still has to be scrolled to what was chosen
    /// last: the first of a dialog is drawn to find its size.
    unseen: u8,
}

/// The dialog. The session remembers the options while it is closed.
#[derive(Debug, Default)]
pub(super) struct ExportDialog {
    open: Option<Open>,
}

impl ExportDialog {
    /// Opens the dialog with the last options.
    pub(super) fn ask(&mut self, session: &Session) {
        let mut choice = session.window.export;
        if session.why_not_exported(choice.format).is_some() {
            choice.format = ExportChoice::default().format;
        }
        let name = session.export_name(choice.format);
        let folder = session.window.save_folder.as_deref().filter(|folder| folder.is_dir());
        let path = folder.map_or_else(|| PathBuf::from(&name), |folder| folder.join(&name));
        // A name alone would not tell in which folder.
        let path = std::path::absolute(&path).unwrap_or(path);
        self.open = Some(Open { choice, path: path.display().to_string(), replaces: None, unseen: 2 });
    }

    /// Draws the dialog. Returns the format for which the system's dialog should ask for a path.
    pub(super) fn show(
        &mut self,
        ctx: &Context,
        session: &Session,
        actions: &mut Vec<Action>,
    ) -> Option<Format> {
        let open = self.open.as_mut()?;
        let frame = egui::Frame::popup(&ctx.global_style()).inner_margin(16.0);
        let response = Modal::new(Id::unique("export")).frame(frame).show(ctx, |ui| {
            let width = widgets::dialog_width(ctx, FORMATS + OPTIONS + GAP);
            ui.set_width(width);
            ui.heading("Export");
            ui.add_space(6.0);
            let height = HEIGHT.min(widgets::dialog_room(ui, BELOW));
            let column = |ui: &mut Ui, name: &str, width: f32, contents: &mut dyn FnMut(&mut Ui)| {
                let below = egui::Layout::top_down(egui::Align::Min);
                ui.allocate_ui_with_layout(vec2(width, height), below, |ui| {
                    let area = ScrollArea::vertical().id_salt(name).auto_shrink([false, false]);
                    area.max_height(height).min_scrolled_height(height).show(ui, contents);
                });
            };
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = GAP;
                // A narrow window takes from both.
                let formats = (width - GAP) * FORMATS / (FORMATS + OPTIONS);
                column(ui, "formats", formats, &mut |ui| open.formats(ui, session));
                column(ui, "options", width - GAP - formats, &mut |ui| {
                    ui.spacing_mut().item_spacing = vec2(8.0, 6.0);
                    open.options(ui, session);
                });
            });
            ui.add_space(8.0);
            let browsed = open.target(ui);
            ui.add_space(10.0);
            let pressed = open.buttons(ui);
            browsed.or(pressed)
        });
        let asked = response.inner.or(response.should_close().then_some(Asked::Close))?;
        let format = open.choice.format;
        match asked {
            Asked::Close => {}
            Asked::Browse => actions.push(Action::SetExport(open.choice)),
            Asked::Export => {
                let path = open.enter()?;
                actions.push(Action::SetExport(open.choice));
                actions.push(Action::Export(path));
            }
        }
        self.open = None;
        (asked == Asked::Browse).then_some(format)
    }
}

impl Open {
    /// The list of formats, grouped by content.
    fn formats(&mut self, ui: &mut Ui, session: &Session) {
        ui.spacing_mut().item_spacing.y = 2.0;
        for kind in Kind::ALL {
            let formats: Vec<Format> = Format::of_kind(kind).collect();
            let Some(first) = formats.first() else { continue };
            if kind != Kind::ALL[0] {
                ui.add_space(10.0);
            }
            ui.label(RichText::new(kind.title()).strong().color(Palette::of(ui).weak));
            // One sentence for all is enough.
            let why = session.why_not_exported(*first);
            if let Some(why) = why {
                ui.label(RichText::new(why).small().color(Palette::of(ui).weak));
            }
            for format in formats {
                let is_chosen = format == self.choice.format;
                let text = lines(ui, format, why.is_none());
                let button = Button::selectable(is_chosen, text).min_size(vec2(ui.available_width(), 0.0));
                let response = ui.add_enabled(why.is_none(), button.wrap());
                let response = response
                    .accessible_name(format!("{}, {}", kind.title(), format.title()))
                    .on_disabled_hover_text(why.unwrap_or_default());
                if is_chosen && self.unseen > 0 {
                    self.unseen -= 1;
                    response.scroll_to_me(Some(egui::Align::Center));
                }
                if response.clicked() {
                    self.choose(format, session);
                }
            }
        }
    }

    /// Changes the format, and the suggested part of the name with it.
    fn choose(&mut self, format: Format, session: &Session) {
        let (before, after) = (session.export_name(self.choice.format), session.export_name(format));
        self.path = match self.path.strip_suffix(&before) {
            Some(folder) => format!("{folder}{after}"),
            None => PathBuf::from(&self.path).with_extension(format.ending()).display().to_string(),
        };
        self.choice.format = format;
        self.replaces = None;
    }

    fn options(&mut self, ui: &mut Ui, session: &Session) {
        let format = self.choice.format;
        let weak = Palette::of(ui).weak;
        ui.label(RichText::new(format!("{} as {}", format.kind().title(), format.title())).strong());
        ui.label(RichText::new(format.description()).color(weak));
        ui.add_space(6.0);
        let options = &mut self.choice.options;
        for choice in format.choices() {
            let check = |ui: &mut Ui, value: &mut bool| {
                ui.checkbox(value, choice.title()).on_hover_text(choice.hint());
            };
            match choice {
                Choice::Binary => check(ui, &mut options.binary),
                Choice::Colors => check(ui, &mut options.colors),
                Choice::InputAttributes => check(ui, &mut options.input_attributes),
                Choice::Doubles => check(ui, &mut options.doubles),
                Choice::SplitBoundaries => check(ui, &mut options.split_boundaries),
                Choice::ExactShapes => check(ui, &mut options.exact_shapes),
                Choice::Resolution => {
                    let (least, most) = ExportOptions::RESOLUTION;
                    let value = DragValue::new(&mut options.resolution).range(least..=most).speed(0.1);
                    number(ui, *choice, value);
                    // Pieces come in pairs.
                    options.resolution = options.resolution.next_multiple_of(2);
                }
                Choice::Density => share(ui, *choice, &mut options.density, ExportOptions::DENSITY),
                Choice::Scale => share(ui, *choice, &mut options.scale, ExportOptions::SCALE),
            }
        }
        if format.choices().is_empty() {
            ui.label(RichText::new("No options for this format").color(weak));
        }
        ui.add_space(6.0);
        if let Some(bytes) = session.export_size(&self.choice) {
            ui.label(RichText::new(format!("About {}", widgets::bytes(bytes))).color(weak));
        }
        if matches!(format.kind(), Kind::Cloud | Kind::Mesh) {
            ui.label(RichText::new("Labels are primitive ids; −1 marks unassigned points").color(weak));
        }
    }

    /// The field for the path.
    fn target(&mut self, ui: &mut Ui) -> Option<Asked> {
        let mut asked = None;
        ui.horizontal(|ui| {
            let label = ui.label("File");
            let width = ui.available_width() - 90.0;
            // The dialog itself is as light as a field is.
            let fill = ui.visuals().widgets.inactive.weak_bg_fill;
            let field = TextEdit::singleline(&mut self.path).desired_width(width).background_color(fill);
            let field = ui.add(field).labelled_by(label.id);
            if field.changed() {
                self.replaces = None;
            }
            if field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter)) && self.is_ready() {
                asked = Some(Asked::Export);
            }
            let browse = ui.add(Button::new("Browse…").min_size(vec2(80.0, theme::ROW)));
            if browse.on_hover_text("Choose a file in the system's dialog and export to it").clicked() {
                asked = Some(Asked::Browse);
            }
        });
        asked
    }

    fn buttons(&mut self, ui: &mut Ui) -> Option<Asked> {
        let mut asked = None;
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let palette = Palette::of(ui);
            let text = if self.replaces.is_some() { "Replace" } else { "Export" };
            let text = RichText::new(text).color(palette.on_accent).strong();
            let export = Button::new(text).fill(palette.accent).min_size(vec2(90.0, theme::ROW));
            let export = ui.add_enabled(self.is_ready(), export);
            let export = export.on_disabled_hover_text(self.problem().unwrap_or("Enter a file name first"));
            if export.on_hover_text("Write the file. If writing fails, no partial file is left").clicked() {
                asked = Some(Asked::Export);
            }
            let cancel = ui.add(Button::new("Cancel").min_size(vec2(80.0, theme::ROW)));
            if cancel.on_hover_text("Close without writing").clicked() {
                asked = Some(Asked::Close);
            }
            let note = self.problem().or(self.replaces.is_some().then_some("The file already exists"));
            if let Some(note) = note {
                ui.label(RichText::new(note).color(palette.warn));
            }
        });
        asked
    }

    fn is_ready(&self) -> bool {
        !self.path.trim().is_empty() && self.problem().is_none()
    }

    /// Why the file cannot be written, as far as known.
    fn problem(&self) -> Option<&'static str> {
        let path = expand(self.path.trim());
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if folder.is_some_and(|folder| !folder.is_dir()) {
            Some("Folder not found")
        } else {
            path.is_dir().then_some("This is a folder")
        }
    }

    /// Handles an entered path; `None` if it must be confirmed first.
    fn enter(&mut self) -> Option<PathBuf> {
        let mut path = expand(self.path.trim());
        if path.extension().is_none() {
            path.set_extension(self.choice.format.ending());
        }
        if path.exists() && self.replaces.as_ref() != Some(&path) {
            self.replaces = Some(path);
            return None;
        }
        Some(path)
    }
}

/// Name and description of a format, one below the other.
fn lines(ui: &Ui, format: Format, is_there: bool) -> LayoutJob {
    let (text, weak) = (ui.visuals().text_color(), Palette::of(ui).weak);
    let body = FontId::proportional(ui.text_style_height(&TextStyle::Body) * 0.8);
    let small = TextStyle::Small.resolve(ui.style());
    let name_color = if is_there { text } else { weak };
    let mut job = LayoutJob::default();
    job.append(format.title(), 0.0, TextFormat::simple(body, name_color));
    job.append(&format!("   .{}\n", format.ending()), 0.0, TextFormat::simple(small.clone(), weak));
    job.append(format.description(), 0.0, TextFormat::simple(small, weak));
    job
}

/// A number of any magnitude, dragged in proportion to its value.
fn share(ui: &mut Ui, choice: Choice, value: &mut f64, (least, most): (f64, f64)) {
    let speed = *value * 0.01;
    let value = widgets::editable(value, widgets::setting);
    number(ui, choice, value.range(least..=most).speed(speed));
}

fn number(ui: &mut Ui, choice: Choice, value: DragValue<'_>) {
    ui.horizontal(|ui| {
        let label = ui.label(choice.title());
        ui.add(value).labelled_by(label.id).on_hover_text(choice.hint());
    });
}
