//! What floats above the window: the error box, notes, help, about, the log.

use egui::{Align2, Area, Context, Frame, Grid, Id, Label, RichText, ScrollArea, Window, vec2};

use super::theme::Palette;
use crate::session::Session;
use crate::session::action::{Action, Group, MOUSE, Verb};
use crate::session::messages::Level;

/// Seconds for which a note is shown.
const NOTE_SECONDS: f64 = 5.0;

/// Which note is shown, and since when.
#[derive(Debug, Default)]
pub(super) struct Overlays {
    note: u64,
    note_since: f64,
}

impl Overlays {
    pub(super) fn show(
        &mut self,
        ctx: &Context,
        session: &Session,
        viewport: egui::Rect,
        actions: &mut Vec<Action>,
    ) {
        caption(ctx, session, viewport);
        error_box(ctx, session, viewport, actions);
        self.note(ctx, session, viewport);
        drop_hint(ctx, viewport);
        shortcuts(ctx, session, actions);
        about(ctx, session, actions);
        log(ctx, session, actions);
    }

    fn note(&mut self, ctx: &Context, session: &Session, viewport: egui::Rect) {
        let Some(message) = session.messages.last_note() else { return };
        let now = ctx.input(|i| i.time);
        if message.number != self.note {
            self.note = message.number;
            self.note_since = now;
        }
        let left = self.note_since + NOTE_SECONDS - now;
        if left <= 0.0 {
            return;
        }
        ctx.request_repaint_after(std::time::Duration::from_secs_f64(left));
        Area::new(Id::unique("note"))
            .pivot(Align2::CENTER_BOTTOM)
            // Above the caption.
            .fixed_pos(viewport.center_bottom() - vec2(0.0, 64.0))
            .interactable(false)
            .show(ctx, |ui| {
                Frame::popup(ui.style()).show(ui, |ui| {
                    ui.set_max_width(viewport.width() - 60.0);
                    ui.add(Label::new(&message.text).wrap());
                });
            });
    }
}

/// What the last merge came to, along the viewport's lower edge.
fn caption(ctx: &Context, session: &Session, viewport: egui::Rect) {
    let Some(text) = &session.merge_text else { return };
    // Beside the axes in the corner.
    let left = 72.0;
    Area::new(Id::unique("caption"))
        .order(egui::Order::Background)
        .pivot(Align2::LEFT_BOTTOM)
        .fixed_pos(viewport.left_bottom() + vec2(left, -10.0))
        .interactable(false)
        .show(ctx, |ui| {
            let width = viewport.width() - left - 16.0;
            let fill = Palette::of(ui).overlay.gamma_multiply(0.85);
            Frame::new().fill(fill).corner_radius(4.0).inner_margin(6.0).show(ui, |ui| {
                ui.set_max_width(width - 12.0);
                ui.add(Label::new(text).wrap());
            });
        });
}

fn error_box(ctx: &Context, session: &Session, viewport: egui::Rect, actions: &mut Vec<Action>) {
    let Some(message) = session.messages.open_error() else { return };
    let width = (viewport.width() - 60.0).clamp(240.0, 460.0);
    Area::new(Id::unique("error box"))
        .order(egui::Order::Foreground)
        .pivot(Align2::CENTER_TOP)
        .fixed_pos(viewport.center_top() + vec2(0.0, 14.0))
        .show(ctx, |ui| {
            Frame::popup(ui.style()).inner_margin(12.0).show(ui, |ui| {
                ui.set_width(width);
                let color = ui.visuals().error_fg_color;
                ui.add(Label::new(RichText::new(&message.text).strong().color(color)).wrap());
                if !message.detail.is_empty() {
                    ui.add_space(2.0);
                    ui.add(Label::new(&message.detail).wrap().selectable(true));
                }
                ui.add_space(8.0);
                ui.horizontal(|ui| {
                    if ui.button("Dismiss").clicked() {
                        actions.push(Action::DismissErrors);
                    }
                    if !session.view.shows_log && ui.button("Show log").clicked() {
                        actions.push(Action::Verb(Verb::ToggleLog));
                    }
                });
            });
        });
}

fn drop_hint(ctx: &Context, viewport: egui::Rect) {
    if ctx.input(|i| i.raw.hovered_files.is_empty()) {
        return;
    }
    Area::new(Id::unique("drop hint"))
        .pivot(Align2::CENTER_CENTER)
        .fixed_pos(viewport.center())
        .interactable(false)
        .show(ctx, |ui| {
            Frame::popup(ui.style()).inner_margin(16.0).show(ui, |ui| ui.heading("Drop the file to open it"));
        });
}

fn shortcuts(ctx: &Context, session: &Session, actions: &mut Vec<Action>) {
    let mut open = session.view.shows_shortcuts;
    Window::new(Verb::ShowShortcuts.entry().text)
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .pivot(Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            ScrollArea::vertical().max_height(ctx.content_rect().height() - 110.0).show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    ui.vertical(|ui| {
                        keys(ui, Group::File);
                        keys(ui, Group::Run);
                    });
                    ui.add_space(20.0);
                    ui.vertical(|ui| keys(ui, Group::View));
                    ui.add_space(20.0);
                    ui.vertical(|ui| {
                        table(ui, "Mouse", MOUSE.iter().map(|(k, v)| ((*k).to_owned(), *v)));
                        keys(ui, Group::Help);
                    });
                });
            });
        });
    if open != session.view.shows_shortcuts {
        actions.push(Action::Verb(Verb::ShowShortcuts));
    }
}

fn keys(ui: &mut egui::Ui, group: Group) {
    let rows = Verb::ALL.iter().map(|verb| verb.entry()).filter(|entry| entry.group == group);
    let rows = rows.filter_map(|entry| Some((entry.shortcut?.to_string(), entry.text.trim_end_matches('…'))));
    table(ui, group.text(), rows);
}

fn table<'a>(ui: &mut egui::Ui, title: &str, rows: impl Iterator<Item = (String, &'a str)>) {
    ui.label(RichText::new(title).strong());
    let weak = Palette::of(ui).weak;
    Grid::new(title).num_columns(2).spacing(vec2(12.0, 3.0)).show(ui, |ui| {
        for (key, text) in rows {
            ui.label(RichText::new(key).color(weak));
            ui.label(text);
            ui.end_row();
        }
    });
    ui.add_space(10.0);
}

fn about(ctx: &Context, session: &Session, actions: &mut Vec<Action>) {
    let mut open = session.view.shows_about;
    Window::new(Verb::ShowAbout.entry().text)
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .pivot(Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            ui.set_width(380.0);
            ui.heading(concat!("Superform ", env!("CARGO_PKG_VERSION")));
            ui.add(Label::new("Turns a 3D shape into a handful of tapered superquadrics.").wrap());
            ui.add_space(6.0);
            ui.add(
                Label::new(
                    "It implements Wu, Liu, Ruan and Chirikjian, Primitive-based Shape Abstraction via \
                     Nonparametric Bayesian Inference, ECCV 2022.",
                )
                .wrap(),
            );
            ui.hyperlink_to("arXiv 2203.14714", "https://arxiv.org/abs/2203.14714");
            ui.add_space(6.0);
            ui.label(RichText::new("Licence: MIT or Apache-2.0").color(Palette::of(ui).weak));
        });
    if open != session.view.shows_about {
        actions.push(Action::Verb(Verb::ShowAbout));
    }
}

fn log(ctx: &Context, session: &Session, actions: &mut Vec<Action>) {
    let mut open = session.view.shows_log;
    Window::new(Verb::ToggleLog.entry().text)
        .open(&mut open)
        .collapsible(false)
        .default_size([460.0, 260.0])
        .pivot(Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                for message in session.messages.iter().rev() {
                    let text = match message.detail.as_str() {
                        "" => message.text.clone(),
                        detail => format!("{}: {detail}", message.text),
                    };
                    let color = match message.level {
                        Level::Error => ui.visuals().error_fg_color,
                        Level::Note => ui.visuals().text_color(),
                        Level::Detail => Palette::of(ui).weak,
                    };
                    ui.add(Label::new(RichText::new(text).color(color)).wrap().selectable(true));
                }
            });
        });
    if open != session.view.shows_log {
        actions.push(Action::Verb(Verb::ToggleLog));
    }
}
