//! The ruler under the plots: a tick for every state, and the playhead.

use egui::{Align2, FontId, Rect, Sense, Stroke, TextStyle, Ui, pos2, vec2};

use super::axis::{Axis, round_step};
use super::pointing;
use crate::session::Session;
use crate::session::action::Action;
use crate::ui::theme::Palette;
use crate::worker::Cause;

pub(super) const HEIGHT: f32 = 26.0;
/// Room for a number.
const NUMBER: f32 = 34.0;

/// The ruler over the axis's range; the hovered state.
pub(super) fn show(
    ui: &mut Ui,
    session: &Session,
    rect: Rect,
    axis: &Axis,
    actions: &mut Vec<Action>,
) -> Option<usize> {
    let states = session.timeline.states();
    let shown = session.timeline.shown_index();
    let response = ui.interact(rect, ui.scope_id().with("ruler"), Sense::click_and_drag());
    pointing::declare(ui, &response, shown, states.len());
    if let Some(index) = pointing::keys(ui, &response, shown, states.len()) {
        actions.push(Action::ShowState(index));
    }
    if response.has_focus() {
        let stroke = ui.visuals().widgets.hovered.bg_stroke;
        ui.painter().rect_stroke(rect.expand2(vec2(2.0, 0.0)), 3.0, stroke, egui::StrokeKind::Inside);
    }
    ticks(ui, session, rect, axis);
    playhead(ui, session, rect, axis);
    pointing::scrub(ui, session, axis, &response, actions)
}

fn ticks(ui: &Ui, session: &Session, rect: Rect, axis: &Axis) {
    let palette = Palette::of(ui);
    let painter = ui.painter().with_clip_rect(ui.clip_rect().intersect(rect.expand2(vec2(8.0, 0.0))));
    let states = session.timeline.states();
    let line = ui.visuals().widgets.noninteractive.bg_stroke.color;
    let base = rect.min.y + 0.5;
    painter.hline(axis.range(), base, Stroke::new(1.0, line));
    if let Some(last) = states.len().checked_sub(1) {
        painter.hline(axis.x(0)..=axis.x(last), base, Stroke::new(1.5, palette.weak));
    }
    // Where states lie closer than ticks can, some stand for their neighbours.
    let stride = (3.0 / axis.spacing()).ceil().max(1.0) as usize;
    for (index, state) in states.iter().enumerate().step_by(stride) {
        let long = matches!(state.cause, Cause::Start | Cause::Merge | Cause::Edit);
        let length = if long { 6.0 } else { 4.0 };
        painter.vline(axis.x(index), base..=base + length, Stroke::new(1.0, palette.weak));
    }
    let step = round_step(axis.spacing(), NUMBER);
    let font = FontId::proportional(TextStyle::Small.resolve(ui.style()).size);
    let mut free_from = f32::NEG_INFINITY;
    let mut before = None;
    for (index, state) in states.iter().enumerate() {
        let iteration = state.abstraction.iteration;
        let is_first = before != Some(iteration);
        before = Some(iteration);
        let x = axis.x(index);
        if !is_first || !iteration.is_multiple_of(step) || x < free_from {
            continue;
        }
        let at = pos2(x, rect.max.y);
        painter.vline(x, base..=base + 7.0, Stroke::new(1.0, palette.weak));
        painter.text(at, Align2::CENTER_BOTTOM, iteration.to_string(), font.clone(), palette.weak);
        free_from = x + NUMBER;
    }
}

/// The handle, with the shown state's iteration on it.
fn playhead(ui: &Ui, session: &Session, rect: Rect, axis: &Axis) {
    let Some(state) = session.timeline.shown() else { return };
    let palette = Palette::of(ui);
    let x = axis.x(session.timeline.shown_index());
    let font = FontId::proportional(TextStyle::Small.resolve(ui.style()).size);
    let text = state.abstraction.iteration.to_string();
    let galley = ui.painter().layout_no_wrap(text, font, palette.on_accent);
    let size = vec2(galley.size().x.max(12.0) + 8.0, 15.0);
    let handle = Rect::from_center_size(pos2(x, rect.max.y - 0.5 * size.y + 1.0), size);
    ui.painter().vline(x, rect.min.y..=handle.min.y, Stroke::new(1.5, palette.accent));
    ui.painter().rect_filled(handle, 3.0, palette.accent);
    ui.painter().galley(handle.center() - 0.5 * galley.size(), galley, palette.on_accent);
}
