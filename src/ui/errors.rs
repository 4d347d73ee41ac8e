//! The error message: what went wrong, why, and what to do.

use egui::{Align2, Area, Context, Frame, Id, Label, RichText, vec2};

use super::theme::Palette;
use super::widgets::{keep_clear, offer_button, scrolling};
use crate::session::Session;
use crate::session::action::{Action, Message};
use crate::session::verb::Verb;

/// Height around the scrolling part: frame, two rows of buttons, margins.
const ROOM: f32 = 120.0;

/// The error whose details are shown.
#[derive(Debug, Default)]
pub(super) struct ErrorBox {
    detailed: Option<u64>,
}

impl ErrorBox {
    pub(super) fn show(
        &mut self,
        ctx: &Context,
        session: &Session,
        viewport: egui::Rect,
        actions: &mut Vec<Action>,
    ) {
        let Some(message) = session.messages.open_error() else { return };
        // Over the panels where the view is too narrow for it.
        let window = ctx.content_rect();
        let width = 460.0_f32.min(window.width() - 48.0);
        let half = 0.5 * width + 16.0;
        let left = window.left() + half;
        let x = viewport.center().x.clamp(left, (window.right() - half).max(left));
        let card = Area::new(Id::unique("error box"))
            .order(egui::Order::Foreground)
            .pivot(Align2::CENTER_TOP)
            .fixed_pos(egui::pos2(x, viewport.top() + 14.0))
            .show(ctx, |ui| {
                Frame::popup(ui.style()).inner_margin(14.0).show(ui, |ui| {
                    ui.set_width(width - 28.0);
                    self.contents(ui, session, message, window.height(), actions);
                });
            });
        keep_clear(ctx, card.response.rect);
    }

    fn contents(
        &mut self,
        ui: &mut egui::Ui,
        session: &Session,
        message: &Message,
        height: f32,
        actions: &mut Vec<Action>,
    ) {
        let palette = Palette::of(ui);
        scrolling(ui, (0.45 * height).min(height - ROOM), |ui| {
            let what = RichText::new(&message.what).heading().color(palette.error);
            ui.add(Label::new(what).wrap().selectable(true));
            if !message.why.is_empty() {
                ui.add_space(4.0);
                ui.add(Label::new(&message.why).wrap().selectable(true));
            }
            if !message.advice.is_empty() {
                ui.add_space(6.0);
                ui.add(Label::new(RichText::new(&message.advice).color(palette.weak)).wrap());
            }
            if self.detailed == Some(message.number) {
                ui.add_space(8.0);
                let fill = ui.visuals().extreme_bg_color;
                Frame::new().fill(fill).corner_radius(4.0).inner_margin(8.0).show(ui, |ui| {
                    ui.set_width(ui.available_width());
                    let report = RichText::new(message.report()).monospace();
                    ui.add(Label::new(report).wrap().selectable(true));
                });
            }
        });
        ui.add_space(10.0);
        ui.horizontal_wrapped(|ui| {
            if let Some(offer) = &message.offer
                && offer_button(ui, session, offer, actions)
            {
                actions.push(Action::DismissError(message.number));
            }
            if ui.button("Dismiss").on_hover_text("Close this message (Esc). It stays in the log").clicked() {
                actions.push(Action::DismissError(message.number));
            }
            let is_open = self.detailed == Some(message.number);
            let details = if is_open { "Hide details" } else { "Details" };
            if ui.button(details).on_hover_text("The chain of causes, for a bug report").clicked() {
                self.detailed = (!is_open).then_some(message.number);
            }
            if is_open && ui.button("Copy").on_hover_text("Copy the details").clicked() {
                ui.ctx().copy_text(message.report());
            }
            if !session.view.shows_log {
                let log = ui.button("Show log").on_hover_text(Verb::ToggleLog.entry().tooltip);
                if log.clicked() {
                    actions.push(Action::Verb(Verb::ToggleLog));
                }
            }
        });
    }
}

/// A hint over the viewport while files are dragged over the window.
pub(super) fn drop_hint(ctx: &Context, viewport: egui::Rect) {
    let files = ctx.input(|i| i.raw.hovered_files.clone());
    if files.is_empty() {
        return;
    }
    let paths: Vec<_> = files.iter().filter_map(|file| file.path.as_deref()).collect();
    let shape = paths.iter().find(|path| crate::io::has_shape_ending(path)).or(paths.first());
    let name = shape.and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
    let is_readable = paths.is_empty() || paths.iter().any(|path| crate::io::has_shape_ending(path));
    let (title, more) = match (name, is_readable) {
        (Some(name), true) if files.len() > 1 => (
            format!("Drop to open {name}"),
            format!("Only one shape can be open; {} files are being dragged", files.len()),
        ),
        (Some(name), true) => (format!("Drop to open {name}"), "The run starts immediately".to_owned()),
        (Some(name), false) => (
            format!("{name} may not be a shape"),
            format!("Supported file extensions: {}", crate::io::SHAPE_ENDINGS.join(", ")),
        ),
        (None, _) => ("Drop the file to open it".to_owned(), "The run starts immediately".to_owned()),
    };
    Area::new(Id::unique("drop hint"))
        .order(egui::Order::Foreground)
        .fixed_pos(viewport.min)
        .interactable(false)
        .show(ctx, |ui| {
            let palette = Palette::of(ui);
            let (rect, _) = ui.allocate_exact_size(viewport.size(), egui::Sense::hover());
            ui.painter().rect_filled(rect, 0.0, palette.overlay.gamma_multiply(0.75));
            let color = if is_readable { palette.accent } else { palette.warn };
            let stroke = egui::Stroke::new(2.0, color);
            let inside = rect.shrink(14.0);
            let corners = [
                inside.left_top(),
                inside.right_top(),
                inside.right_bottom(),
                inside.left_bottom(),
                inside.left_top(),
            ];
            ui.painter().extend(egui::Shape::dashed_line(&corners, stroke, 9.0, 6.0));
            let inner = egui::Rect::from_center_size(rect.center(), vec2(inside.width() - 24.0, 60.0));
            ui.scope_builder(egui::UiBuilder::new().max_rect(inner), |ui| {
                ui.vertical_centered(|ui| {
                    ui.add(Label::new(RichText::new(title).heading().color(color)).wrap());
                    ui.add(Label::new(RichText::new(more).color(palette.weak)).wrap());
                });
            });
        });
}
