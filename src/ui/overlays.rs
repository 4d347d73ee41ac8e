//! What floats above the window.

use egui::{Align2, Area, Context, Frame, Id, Label, vec2};

use super::commands::Commands;
use super::errors::{ErrorBox, drop_hint};
use super::help::{Help, about};
use super::theme::Palette;
use super::toasts::Toasts;
use crate::session::Session;
use crate::session::action::Action;

/// What each of them remembers.
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
        self.toasts.show(ctx, session, viewport, actions);
        self.errors.show(ctx, session, viewport, actions);
        self.help.show(ctx, session, actions);
        about(ctx, session, actions);
        self.commands.show(ctx, session, actions);
        drop_hint(ctx, viewport);
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
            let width = (viewport.width() - left - 16.0).max(60.0);
            let fill = Palette::of(ui).overlay.gamma_multiply(0.85);
            Frame::new().fill(fill).corner_radius(4.0).inner_margin(6.0).show(ui, |ui| {
                ui.set_max_width(width - 12.0);
                ui.add(Label::new(text).wrap());
            });
        });
}
