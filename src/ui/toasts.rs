//! What is said in passing: notes and warnings in the viewport's lower right
//! corner, which go by themselves.

use std::time::Duration;

use egui::{Align, Align2, Area, Context, Frame, Id, Label, Layout, RichText, vec2};

use super::theme::Palette;
use super::widgets::{close_button, offer_button};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::messages::{Level, Message};

/// As many are shown at a time; older ones make room.
const MOST: usize = 4;
/// Seconds in which one fades away, at the end of its time.
const FADE: f64 = 0.5;
/// Width of one in logical pixels.
const WIDTH: f32 = 340.0;

/// One that is shown.
#[derive(Debug)]
struct Toast {
    /// That of the message.
    number: u64,
    seconds_left: f64,
}

/// Those that are shown, oldest first.
#[derive(Debug, Default)]
pub(super) struct Toasts {
    shown: Vec<Toast>,
    /// The newest message that was looked at.
    seen: u64,
    time: f64,
    /// The pointer rests on them: they wait.
    are_held: bool,
}

impl Toasts {
    pub(super) fn show(
        &mut self,
        ctx: &Context,
        session: &Session,
        viewport: egui::Rect,
        actions: &mut Vec<Action>,
    ) {
        self.advance(ctx.input(|i| i.time));
        for message in session.messages.since(self.seen) {
            if matches!(message.level, Level::Note | Level::Warning) {
                self.shown.push(Toast { number: message.number, seconds_left: seconds(message) });
            }
        }
        self.seen = session.messages.count();
        let excess = self.shown.len().saturating_sub(MOST);
        self.shown.drain(..excess);
        self.shown.retain(|toast| session.messages.get(toast.number).is_some());
        let Some(next) = self.shown.iter().map(|toast| toast.seconds_left).reduce(f64::min) else {
            self.are_held = false;
            return;
        };
        if next < FADE {
            ctx.request_repaint();
        } else {
            ctx.request_repaint_after(Duration::from_secs_f64(next - FADE));
        }
        let width = WIDTH.min(viewport.width() - 24.0).max(120.0);
        let mut gone = None;
        let area = Area::new(Id::unique("notes"))
            .pivot(Align2::RIGHT_BOTTOM)
            .fixed_pos(viewport.right_bottom() - vec2(12.0, 12.0))
            .show(ctx, |ui| {
                ui.set_width(width);
                ui.spacing_mut().item_spacing.y = 6.0;
                for toast in &self.shown {
                    let Some(message) = session.messages.get(toast.number) else { continue };
                    ui.scope(|ui| {
                        if !self.are_held {
                            ui.set_opacity((toast.seconds_left / FADE).clamp(0.0, 1.0) as f32);
                        }
                        if draw(ui, session, message, actions) {
                            gone = Some(toast.number);
                        }
                    });
                }
            });
        self.are_held = area.response.contains_pointer();
        self.shown.retain(|toast| Some(toast.number) != gone);
    }

    /// Time goes by, but not while the pointer rests on them.
    fn advance(&mut self, now: f64) {
        let passed = (now - self.time).max(0.0);
        self.time = now;
        for toast in &mut self.shown {
            if !self.are_held {
                toast.seconds_left -= passed;
            } else {
                // What was about to go can be read again.
                toast.seconds_left = toast.seconds_left.max(2.0 * FADE);
            }
        }
        self.shown.retain(|toast| toast.seconds_left > 0.0);
    }
}

/// For how long a message is shown: long enough to be read.
fn seconds(message: &Message) -> f64 {
    let letters = message.line().chars().count() as f64;
    let least = if message.level == Level::Warning { 7.0 } else { 4.0 };
    (least + 0.03 * letters + if message.offer.is_some() { 2.0 } else { 0.0 }).min(14.0)
}

/// Draws one; whether it was closed.
fn draw(ui: &mut egui::Ui, session: &Session, message: &Message, actions: &mut Vec<Action>) -> bool {
    let palette = Palette::of(ui);
    let color = if message.level == Level::Warning { palette.warn } else { palette.accent };
    let mut closed = false;
    let frame = Frame::popup(ui.style()).inner_margin(egui::Margin { left: 14, right: 8, top: 8, bottom: 8 });
    let shown = frame.show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            closed = close_button(ui, "Close the note").clicked();
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                ui.add(Label::new(&message.what).wrap().selectable(true));
                for more in [&message.why, &message.advice] {
                    if !more.is_empty() {
                        let text = RichText::new(more).color(palette.weak);
                        ui.add(Label::new(text).wrap().selectable(true));
                    }
                }
                if let Some(offer) = &message.offer {
                    ui.add_space(2.0);
                    closed |= offer_button(ui, session, offer, actions);
                }
            });
        });
    });
    let rect = shown.response.rect;
    let bar = egui::Rect::from_min_max(rect.min, egui::pos2(rect.min.x + 4.0, rect.max.y));
    let radius = egui::CornerRadius { nw: 6, sw: 6, ne: 0, se: 0 };
    ui.painter().rect_filled(bar, radius, color);
    closed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_go_with_time_but_not_under_the_pointer() {
        let toast = |number, seconds_left| Toast { number, seconds_left };
        let mut toasts = Toasts { shown: vec![toast(1, 1.0), toast(2, 4.0)], ..Toasts::default() };
        toasts.advance(0.5);
        assert_eq!(toasts.shown.len(), 2);
        toasts.are_held = true;
        toasts.advance(100.0);
        assert_eq!(toasts.shown.len(), 2);
        toasts.are_held = false;
        toasts.advance(100.0 + 1.5 * FADE);
        assert_eq!(toasts.shown.len(), 2, "what was held can be read on");
        toasts.advance(102.0);
        assert_eq!(toasts.shown.iter().map(|t| t.number).collect::<Vec<_>>(), [2]);
        toasts.advance(200.0);
        assert!(toasts.shown.is_empty());
    }
}
