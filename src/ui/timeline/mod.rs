//! The timeline panel: the states of all branches, their events and values. Its rows share one x
//! axis: plots at the top, the ruler with the playhead, then one lane per branch.

use std::time::Duration;

use egui::{Rect, RichText, ScrollArea, Stroke, Ui, pos2, vec2};

use super::figures;
use super::progress::steps;
use super::theme::{self, Palette};
use super::widgets::within;
use crate::session::Session;
use crate::session::action::Action;

mod axis;
mod header;
mod icons;
mod lanes;
mod marks;
mod plots;
mod pointing;
mod ruler;

use axis::Axis;
use lanes::{Lanes, Shares};
pub(super) use pointing::value_text;

/// The least height: the first row and the ruler.
pub(super) const LEAST_HEIGHT: f32 = theme::ROW + ruler::HEIGHT + 12.0;

/// Width of the names and titles on the left.
const NAMES: f32 = 132.0;
/// Width of the metrics on the right, and of a panel that has room for them.
const FIGURES: f32 = 178.0;
const WIDE: f32 = 780.0;
/// Height of a panel that has room for the metrics in a separate row.
const LOW: f32 = 168.0;

/// Panel state outside the session.
#[derive(Debug, Default)]
pub(super) struct Timeline {
    lanes: Lanes,
    /// When the session was last told that time passes, in seconds.
    played_at: Option<f64>,
}

impl Timeline {
    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
        self.play(ui, session, actions);
        header::show(ui, session, actions);
        let mut body = ui.available_rect_before_wrap();
        // The panel is as high as what it holds: all that it was dragged to.
        ui.expand_to_include_rect(body);
        if session.timeline.states().is_empty() {
            let text = "All states of the run will appear here";
            ui.label(RichText::new(text).color(Palette::of(ui).weak));
            return;
        }
        body.min.y += 4.0;
        if body.width() >= WIDE && body.height() >= 60.0 {
            let side = Rect::from_min_max(pos2(body.max.x - FIGURES, body.min.y), body.max);
            body.max.x = side.min.x - 16.0;
            within(ui, side, |ui| {
                let area = ScrollArea::vertical().id_salt("figures").min_scrolled_height(0.0);
                area.show(ui, |ui| figures::show(ui, session));
            });
        } else if body.height() >= LOW {
            let mut row = body;
            row.max.y = row.min.y + figures::row_height(session);
            body.min.y = row.max.y + 2.0;
            within(ui, row, |ui| figures::show(ui, session));
        }
        self.rows(ui, session, body, actions);
    }

    /// Plots, ruler and lanes.
    fn rows(&mut self, ui: &mut Ui, session: &Session, body: Rect, actions: &mut Vec<Action>) {
        let states = session.timeline.states().len();
        let left = (body.min.x + NAMES + plots::NUMBERS).min(body.center().x);
        let longest = session.timeline.branches().iter().map(|b| b.states.len()).max().unwrap_or(1);
        let axis = Axis::new(egui::Rangef::new(left, body.max.x), states, longest.max(expected(session)));

        let wanted: Vec<_> = session.curves.shown().collect();
        let room = (body.height() - ruler::HEIGHT).max(0.0);
        let branches = session.timeline.branches().len();
        let shares = Shares::of(room, wanted.len(), branches, lanes::kinds(session).len());
        let plot_height = shares.plots_height / shares.plots.max(1) as f32;

        let mut hovered = None;
        let mut top = body.min.y;
        for &curve in &wanted[..shares.plots] {
            let rect = Rect::from_min_max(pos2(body.min.x, top), pos2(body.max.x, top + plot_height - 3.0));
            hovered = plots::show(ui, session, curve, rect, &axis, actions).or(hovered);
            top += plot_height;
        }
        let ruler = Rect::from_min_max(pos2(left, top), pos2(body.max.x, top + ruler::HEIGHT));
        hovered = ruler::show(ui, session, ruler, &axis, actions).or(hovered);
        let below = pos2(body.max.x, (ruler.max.y + shares.lanes_seen).min(body.max.y));
        let area = Rect::from_min_max(pos2(body.min.x, ruler.max.y), below);
        if area.height() > 4.0 {
            within(ui, area, |ui| {
                let scroll = ScrollArea::vertical().id_salt("lanes").min_scrolled_height(0.0);
                scroll.auto_shrink([false, false]).show(ui, |ui| {
                    let size = vec2(area.width(), shares.lanes_height);
                    let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
                    hovered = self.lanes.show(ui, session, rect, &axis, shares.rows, actions).or(hovered);
                });
            });
        }
        self.lines(ui, session, &axis, [body.min.y, ruler.min.y], hovered);
    }

    /// The playhead through the plots, and where the pointer is.
    fn lines(
        &self,
        ui: &Ui,
        session: &Session,
        axis: &Axis,
        [top, bottom]: [f32; 2],
        hovered: Option<usize>,
    ) {
        let palette = Palette::of(ui);
        if let Some(index) = hovered {
            let stroke = Stroke::new(1.0, palette.weak.gamma_multiply(0.6));
            ui.painter().vline(axis.x(index), top..=bottom, stroke);
        }
        let x = axis.x(session.timeline.shown_index());
        ui.painter().vline(x, top..=bottom, Stroke::new(1.5, palette.accent));
    }

    /// Advances playback.
    fn play(&mut self, ui: &Ui, session: &Session, actions: &mut Vec<Action>) {
        if !session.playback.is_playing {
            self.played_at = None;
            return;
        }
        let now = ui.input(|i| i.time);
        let since = now - *self.played_at.get_or_insert(now);
        let interval = 1.0 / f64::from(session.playback.speed());
        if since >= interval {
            self.played_at = Some(now);
            actions.push(Action::PlayOn(since));
        }
        let left = (interval - since).clamp(0.0, interval);
        ui.ctx().request_repaint_after(Duration::from_secs_f64(left));
    }
}

/// Expected number of states of the shown branch, from the remaining iterations.
fn expected(session: &Session) -> usize {
    let states = session.timeline.states();
    let (Some(last), Some(steps)) = (states.last(), steps(session)) else { return states.len() };
    if last.abstraction.phase == crate::inference::Phase::Finished {
        return states.len();
    }
    states.len() + steps.saturating_sub(last.abstraction.iteration) as usize
}
