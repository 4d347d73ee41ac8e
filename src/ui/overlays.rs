//! Overlays on top of the window.

use egui::{Align2, Area, Button, Context, Frame, Id, Label, RichText, vec2};

use super::commands::Commands;
use super::errors::{ErrorBox, drop_hint};
use super::help::{Help, about};
use super::theme::Palette;
use super::toasts::Toasts;
use super::widgets::keep_clear;
use crate::session::Session;
use crate::session::action::Action;

/// State of the overlays.
#[derive(Debug, Default)]
pub(super) struct Overlays {
    toasts: Toasts,
    errors: ErrorBox,
    help: Help,
    commands: Commands,
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
        outdated(ctx, session, viewport, actions);
        self.errors.show(ctx, session, viewport, actions);
        self.toasts.show(ctx, session, viewport, actions);
        self.help.show(ctx, session, actions);
        about(ctx, session, actions);
        self.commands.show(ctx, session, actions);
        drop_hint(ctx, viewport);
    }
}

/// Shows that the result does not match the current parameters.
fn outdated(ctx: &Context, session: &Session, viewport: egui::Rect, actions: &mut Vec<Action>) {
    if !session.is_outdated() || session.is_judging() {
        return;
    }
    let card = Area::new(Id::unique("outdated"))
        .pivot(Align2::CENTER_TOP)
        .fixed_pos(viewport.center_top() + vec2(0.0, 10.0))
        .show(ctx, |ui| {
            Frame::popup(ui.style()).inner_margin(egui::Margin::symmetric(10, 5)).show(ui, |ui| {
                ui.horizontal(|ui| {
                    let palette = Palette::of(ui);
                    ui.label(RichText::new("Parameters changed").color(palette.warn))
                        .on_hover_text("The shown result was computed with different parameters or samples");
                    let text = RichText::new("Run").color(palette.on_accent).strong();
                    let run = ui.add(Button::new(text).fill(palette.accent));
                    let run = run.accessible_name("Run with changed parameters");
                    if run.on_hover_text("Run with the current parameters and samples").clicked() {
                        actions.push(Action::RunAsSet);
                    }
                });
            });
        });
    keep_clear(ctx, card.response.rect);
}

/// Result of the last merge, along the viewport's lower edge.
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
            let width = (viewport.width() - left - 16.0).max(60.0);
            let fill = Palette::of(ui).overlay.gamma_multiply(0.85);
            Frame::new().fill(fill).corner_radius(4.0).inner_margin(6.0).show(ui, |ui| {
                ui.set_max_width(width - 12.0);
                ui.add(Label::new(text).wrap());
            });
        });
}
