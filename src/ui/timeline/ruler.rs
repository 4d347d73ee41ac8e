//! The ruler under the plots: a tick for every state, and the playhead.

use std::sync::Arc;

use egui::{FontId, Galley, Rect, Sense, Stroke, TextStyle, Ui, Vec2, pos2, vec2};

use super::axis::{Axis, round_step};
use super::pointing;
use crate::session::Session;
use crate::session::action::Action;
use crate::ui::theme::Palette;
use crate::worker::Cause;

pub(super) const HEIGHT: f32 = 26.0;
/// Space from number to number.
const APART: f32 = 12.0;

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
    if !states.is_empty() {
        let handle = Handle::new(ui, session, rect, axis);
        ticks(ui, session, rect, axis, handle.rect);
        handle.show(ui, axis.x(shown), rect.min.y);
    }
    pointing::scrub(ui, session, axis, &response, actions)
}

/// Ticks, with numbers where there is room beside the `handle`.
fn ticks(ui: &Ui, session: &Session, rect: Rect, axis: &Axis, handle: Rect) {
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
    let font = FontId::proportional(TextStyle::Small.resolve(ui.style()).size);
    let number = |iteration: u32| painter.layout_no_wrap(iteration.to_string(), font.clone(), palette.weak);
    let iterations: Vec<u32> = states.iter().map(|s| s.abstraction.iteration).collect();
    for (index, place) in numbered(rect, axis, &iterations, |n| number(n).size(), handle) {
        painter.vline(axis.x(index), base..=base + 7.0, Stroke::new(1.0, palette.weak));
        painter.galley(place.min, number(iterations[index]), palette.weak);
    }
}

/// Which states have their iteration under them, and where: round ones, the
/// first of each iteration, as far as they meet neither each other nor the
/// `handle`.
fn numbered(
    rect: Rect,
    axis: &Axis,
    iterations: &[u32],
    size: impl Fn(u32) -> Vec2,
    handle: Rect,
) -> Vec<(usize, Rect)> {
    let widest = iterations.iter().max().map_or(0.0, |&n| size(n).x);
    let step = round_step(axis.spacing(), widest + APART);
    let mut free_from = f32::NEG_INFINITY;
    let mut placed = Vec::new();
    for (index, &iteration) in iterations.iter().enumerate() {
        let is_first = index == 0 || iterations[index - 1] != iteration;
        if !is_first || !iteration.is_multiple_of(step) {
            continue;
        }
        let place = along(rect, axis.x(index), size(iteration));
        if place.min.x >= free_from && !place.expand(3.0).intersects(handle) {
            free_from = place.max.x + 0.6 * APART;
            placed.push((index, place));
        }
    }
    placed
}

/// The place of a text at the bottom of the ruler, centred at `x` as far as it
/// stays within.
fn along(rect: Rect, x: f32, size: Vec2) -> Rect {
    let left = (x - 0.5 * size.x).min(rect.max.x - size.x).max(rect.min.x);
    Rect::from_min_size(pos2(left, rect.max.y - size.y), size)
}

/// The playhead with the shown state's name on it.
struct Handle {
    rect: Rect,
    text: Arc<Galley>,
}

impl Handle {
    fn new(ui: &Ui, session: &Session, rect: Rect, axis: &Axis) -> Self {
        let font = FontId::proportional(TextStyle::Small.resolve(ui.style()).size);
        let name = session.timeline.shown_name().short();
        let text = ui.painter().layout_no_wrap(name, font, Palette::of(ui).on_accent);
        let size = vec2(text.size().x.max(12.0) + 8.0, 15.0);
        let x = axis.x(session.timeline.shown_index());
        Self { rect: along(rect, x, size).translate(vec2(0.0, 1.0)), text }
    }

    fn show(self, ui: &Ui, x: f32, top: f32) {
        let palette = Palette::of(ui);
        ui.painter().vline(x, top..=self.rect.min.y, Stroke::new(1.5, palette.accent));
        ui.painter().rect_filled(self.rect, 3.0, palette.accent);
        let at = self.rect.center() - 0.5 * self.text.size();
        ui.painter().galley(at, self.text, palette.on_accent);
    }
}

#[cfg(test)]
mod tests {
    use egui::Rangef;

    use super::*;

    #[test]
    fn numbers_never_meet_and_stay_within() {
        for width in [90.0, 330.0, 700.0, 1600.0] {
            for states in [1, 2, 7, 31, 32, 400, 2000] {
                let rect = Rect::from_min_size(pos2(200.0, 50.0), vec2(width, HEIGHT));
                let axis = Axis::new(Rangef::new(200.0, 200.0 + width), states, states);
                // Digits of the size that they have, and at the end merges of one iteration.
                let size = |n: u32| vec2(6.5 * n.to_string().len() as f32, 12.0);
                let iterations: Vec<u32> = (0..states as u32).map(|i| i.min(1990)).collect();
                for shown in [0, states / 2, states - 1] {
                    let handle = along(rect, axis.x(shown), vec2(64.0, 15.0));
                    let placed = numbered(rect, &axis, &iterations, size, handle);
                    for pair in placed.windows(2) {
                        assert!(pair[1].1.min.x - pair[0].1.max.x > 5.0, "{width} {states}: {pair:?}");
                    }
                    for (index, place) in &placed {
                        assert!(rect.contains_rect(*place) && !place.intersects(handle));
                        assert!((place.center().x - axis.x(*index)).abs() < 5.0, "at its tick");
                    }
                    assert!(rect.contains_rect(handle));
                    assert!(!placed.is_empty() || width < 100.0 || states < 3, "{width} {states}");
                }
            }
        }
    }
}
