//! Transient notes and warnings in the viewport's lower right corner, or where no card is in the
//! way.

use std::time::Duration;

use egui::{Align, Align2, Area, Context, Frame, Id, Label, Layout, Rect, RichText, Vec2, pos2, vec2};

use super::theme::Palette;
use super::widgets::{cards, close_button, offer_button};
use crate::session::Session;
use crate::session::action::{Action, Level, Message};

/// Maximum number shown at a time; older ones are removed.
const MOST: usize = 4;
/// Seconds of fading at the end.
const FADE: f64 = 0.5;
/// Width of one in logical pixels.
const WIDTH: f32 = 340.0;
/// From the viewport's edges and from cards.
const MARGIN: f32 = 12.0;
/// As high as one is before it was drawn.
const USUAL_HEIGHT: f32 = 80.0;

/// A visible toast.
#[derive(Debug)]
struct Toast {
    /// That of the message.
    number: u64,
    seconds_left: f64,
    /// Number of repetitions.
    times: u32,
}

/// Visible toasts, oldest first.
#[derive(Debug, Default)]
pub(super) struct Toasts {
    shown: Vec<Toast>,
    /// The newest message that was looked at.
    seen: u64,
    time: f64,
    /// The pointer is over them, so they stay.
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
                self.take(session, message);
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
        let width = WIDTH.min(viewport.width() - 2.0 * MARGIN).max(120.0);
        let id = Id::unique("notes");
        let before = ctx.memory(|memory| memory.area_rect(id));
        let size = vec2(width, before.map_or(USUAL_HEIGHT, |rect| rect.height()));
        let mut gone = None;
        let area = Area::new(id)
            .pivot(Align2::RIGHT_BOTTOM)
            .fixed_pos(place(size, viewport, &cards(ctx)).right_bottom())
            .show(ctx, |ui| {
                ui.set_width(width);
                ui.spacing_mut().item_spacing.y = 6.0;
                for toast in &self.shown {
                    let Some(message) = session.messages.get(toast.number) else { continue };
                    ui.scope(|ui| {
                        if !self.are_held {
                            ui.set_opacity((toast.seconds_left / FADE).clamp(0.0, 1.0) as f32);
                        }
                        if draw(ui, session, message, toast.times, actions) {
                            gone = Some(toast.number);
                        }
                    });
                }
            });
        self.are_held = area.response.contains_pointer();
        if (area.response.rect.height() - size.y).abs() > 0.5 {
            // It may be in the way now, or have room elsewhere.
            ctx.request_repaint();
        }
        self.shown.retain(|toast| Some(toast.number) != gone);
    }

    /// Shows a message in place of the last of its kind.
    fn take(&mut self, session: &Session, message: &Message) {
        let mut times = 1;
        self.shown.retain(|toast| {
            let Some(old) = session.messages.get(toast.number) else { return false };
            if old.line() == message.line() {
                times += toast.times;
            }
            kind(old) != kind(message)
        });
        self.shown.push(Toast { number: message.number, seconds_left: seconds(message), times });
    }

    /// Advances time, except while the pointer is over them.
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

/// How long a message is shown, depending on its length.
fn seconds(message: &Message) -> f64 {
    let letters = message.line().chars().count() as f64;
    let least = if message.level == Level::Warning { 7.0 } else { 4.0 };
    (least + 0.03 * letters + if message.offer.is_some() { 2.0 } else { 0.0 }).min(14.0)
}

/// What two messages share of which the second takes the place of the first: of
/// notes the words they begin with, of warnings all but the numbers.
fn kind(message: &Message) -> (Level, String) {
    let text = match message.level {
        Level::Warning => message.line().chars().filter(|c| !c.is_ascii_digit()).collect(),
        _ => {
            let topic = message.what.split(':').next().unwrap_or_default();
            topic.split_whitespace().take(2).collect::<Vec<_>>().join(" ")
        }
    };
    (message.level, text)
}

/// Where so much fits into the viewport without lying over a card: as far down
/// and to the right as it can be, or else where it hides least.
fn place(size: Vec2, viewport: Rect, cards: &[Rect]) -> Rect {
    let room = viewport.shrink(MARGIN);
    let above = cards.iter().map(|card| card.top() - MARGIN);
    let mut bottoms: Vec<f32> =
        std::iter::once(room.bottom()).chain(above).filter(|b| b - size.y >= room.top()).collect();
    bottoms.sort_by(|a, b| b.total_cmp(a));
    bottoms.push(room.top() + size.y);
    let hidden = |rect: &Rect| -> f32 {
        cards.iter().map(|card| card.intersect(*rect)).filter(Rect::is_positive).map(|r| r.area()).sum()
    };
    bottoms
        .into_iter()
        .flat_map(|bottom| [room.right() - size.x, room.left()].map(|left| pos2(left, bottom - size.y)))
        .map(|at| Rect::from_min_size(at, size))
        // The first of the best.
        .min_by(|a, b| hidden(a).total_cmp(&hidden(b)))
        .unwrap_or(room)
}

/// Draws one; returns whether it was closed.
fn draw(
    ui: &mut egui::Ui,
    session: &Session,
    message: &Message,
    times: u32,
    actions: &mut Vec<Action>,
) -> bool {
    let palette = Palette::of(ui);
    let color = if message.level == Level::Warning { palette.warn } else { palette.accent };
    let mut closed = false;
    let frame = Frame::popup(ui.style()).inner_margin(egui::Margin { left: 14, right: 8, top: 8, bottom: 8 });
    let shown = frame.show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            closed = close_button(ui, "Close notification").clicked();
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                let what = match times {
                    1 => message.what.clone(),
                    _ => format!("{} (×{times})", message.what),
                };
                ui.add(Label::new(what).wrap().selectable(true));
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
        let toast = |number, seconds_left| Toast { number, seconds_left, times: 1 };
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

    #[test]
    fn a_repeated_kind_is_shown_once_and_counted() {
        let mut session = Session::new(Default::default(), Default::default());
        let mut toasts = Toasts::default();
        let mut say = |level, what: &str, why: &str| {
            session.messages.push(level, what, why);
            let number = session.messages.count();
            toasts.take(&session, session.messages.get(number).expect("it was just said"));
            toasts.shown.iter().map(|toast| (toast.number, toast.times)).collect::<Vec<_>>()
        };
        assert_eq!(say(Level::Note, "Delete", "it is locked"), [(1, 1)]);
        assert_eq!(say(Level::Note, "Delete", "it is locked"), [(2, 2)]);
        assert_eq!(say(Level::Note, "Delete", "it is locked"), [(3, 3)]);
        assert_eq!(say(Level::Note, "Undid: Select", ""), [(3, 3), (4, 1)]);
        assert_eq!(say(Level::Note, "Undid: Refit 3", ""), [(3, 3), (5, 1)]);
        assert_eq!(say(Level::Warning, "the pool has 3 threads", ""), [(3, 3), (5, 1), (6, 1)]);
        assert_eq!(say(Level::Warning, "the pool has 4 threads", ""), [(3, 3), (5, 1), (7, 1)]);
        assert_eq!(say(Level::Warning, "the pool is gone", "").len(), 4);
    }

    #[test]
    fn they_lie_over_no_card() {
        let rect = |x, y, w, h| Rect::from_min_size(pos2(x, y), vec2(w, h));
        let view = rect(290.0, 60.0, 460.0, 420.0);
        let size = vec2(340.0, 80.0);
        assert_eq!(place(size, view, &[]).right_bottom(), view.right_bottom() - vec2(MARGIN, MARGIN));
        // The merge card over the whole lower edge, a legend, odds in a corner.
        let merge = rect(304.0, 300.0, 432.0, 166.0);
        let legend = rect(544.0, 240.0, 196.0, 196.0);
        let odds = rect(300.0, 70.0, 250.0, 110.0);
        for cards in [vec![merge], vec![legend], vec![legend, merge], vec![odds], vec![odds, merge]] {
            let found = place(size, view, &cards);
            assert!(view.contains_rect(found), "{found:?}");
            assert!(cards.iter().all(|card| !card.intersects(found)), "{cards:?} and {found:?}");
        }
        // Where there is no room at all, it is still in the view.
        assert!(view.contains_rect(place(size, view, &[view])));
    }
}
