//! The log: all messages, newest first.

use egui::{Align, Label, Layout, RichText, ScrollArea, Sense, TextEdit, Ui, vec2};

use super::theme::Palette;
use super::widgets::{choice, close_button};
use crate::session::Session;
use crate::session::action::{Action, Level, Message};
use crate::session::verb::Verb;

/// Height of a line.
const LINE: f32 = 19.0;
/// Width of the column of times.
const CLOCK: f32 = 42.0;

/// Filter of the log.
#[derive(Debug)]
pub(super) struct Log {
    /// Less severe messages are hidden.
    least: Level,
    search: String,
}

impl Default for Log {
    fn default() -> Self {
        Self { least: Level::Detail, search: String::new() }
    }
}

impl Log {
    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
        let wanted = self.search.trim().to_lowercase();
        let shown: Vec<&Message> = session
            .messages
            .iter()
            .rev()
            .filter(|message| message.level >= self.least)
            .filter(|message| wanted.is_empty() || message.line().to_lowercase().contains(&wanted))
            .collect();
        self.header(ui, session, &shown, actions);
        ui.add_space(4.0);
        if shown.is_empty() {
            let text =
                if session.messages.iter().len() == 0 { "No messages yet" } else { "No matching messages" };
            ui.label(RichText::new(text).color(Palette::of(ui).weak));
        }
        ui.spacing_mut().item_spacing.y = 0.0;
        ScrollArea::vertical().auto_shrink([false, false]).show_rows(ui, LINE, shown.len(), |ui, rows| {
            for message in &shown[rows] {
                line(ui, message);
            }
        });
    }

    fn header(&mut self, ui: &mut Ui, session: &Session, shown: &[&Message], actions: &mut Vec<Action>) {
        ui.horizontal(|ui| {
            ui.label(RichText::new("Log").strong());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if close_button(ui, "Close the log").clicked() {
                    actions.push(Action::Verb(Verb::ToggleLog));
                }
                let clear = egui::Button::new("Clear");
                let any = session.messages.iter().len() > 0;
                let clear = ui.add_enabled(any, clear).on_disabled_hover_text("The log is empty");
                if clear.on_hover_text(Verb::ClearLog.entry().tooltip).clicked() {
                    actions.push(Action::Verb(Verb::ClearLog));
                }
                let copy = ui.add_enabled(!shown.is_empty(), egui::Button::new("Copy all"));
                let copy = copy.on_disabled_hover_text("No messages listed");
                if copy.on_hover_text("Copy the listed messages, oldest first").clicked() {
                    ui.ctx().copy_text(as_text(shown));
                }
                // What is left belongs to the filter and the search.
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    ui.add_space(6.0);
                    ui.scope(|ui| {
                        ui.spacing_mut().item_spacing.x = 3.0;
                        for (level, text, tooltip) in [
                            (Level::Detail, "All", "Everything, including single steps"),
                            (Level::Note, "Notes", "Notes, warnings and errors"),
                            (Level::Warning, "Warnings", "Warnings and errors"),
                            (Level::Error, "Errors", "Errors only"),
                        ] {
                            let chosen = choice(ui, self.least == level, text, 54.0);
                            if chosen.on_hover_text(tooltip).clicked() {
                                self.least = level;
                            }
                        }
                    });
                    let width = (ui.available_width() - 4.0).clamp(40.0, 260.0);
                    let field = TextEdit::singleline(&mut self.search).hint_text("Search the log");
                    ui.add(field.desired_width(width - 8.0))
                        .on_hover_text("Show only messages that contain this text");
                });
            });
        });
    }
}

fn line(ui: &mut Ui, message: &Message) {
    let palette = Palette::of(ui);
    let color = match message.level {
        Level::Error => palette.error,
        Level::Warning => palette.warn,
        Level::Note => ui.visuals().text_color(),
        Level::Detail => palette.weak,
    };
    ui.allocate_ui_with_layout(
        vec2(ui.available_width(), LINE),
        Layout::left_to_right(Align::Center),
        |ui| {
            ui.set_min_height(LINE);
            let clock = RichText::new(message.clock()).monospace().color(palette.weak);
            ui.allocate_ui_with_layout(vec2(CLOCK, LINE), Layout::right_to_left(Align::Center), |ui| {
                ui.set_min_width(CLOCK);
                ui.label(clock).on_hover_text("Minutes and seconds since the program started");
            });
            let (mark, _) = ui.allocate_exact_size(vec2(8.0, LINE), Sense::hover());
            ui.painter().circle_filled(mark.center(), 3.0, color);
            let text = RichText::new(message.line().replace('\n', " ")).color(color);
            ui.add(Label::new(text).truncate()).on_hover_text(format!(
                "{}\n{}",
                message.level.text(),
                message.line()
            ));
        },
    );
}

/// For the clipboard.
fn as_text(shown: &[&Message]) -> String {
    let lines = shown
        .iter()
        .rev()
        .map(|message| format!("{:>6}  {:<7}  {}", message.clock(), message.level.text(), message.line()));
    lines.collect::<Vec<_>>().join("\n")
}
