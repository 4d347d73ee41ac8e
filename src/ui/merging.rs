//! The proposed merge: a card over the viewport's lower edge with the pair, the result of the test
//! and the buttons.

use egui::{
    Align2, Area, Context, Frame, Id, Label, Rect, Response, RichText, Role, Sense, Ui, WidgetInfo, pos2,
    vec2,
};

use super::primitives::swatch;
use super::theme::{self, Palette};
use super::widgets::{figure, keep_clear, primary_button, verb_button};
use crate::inference::{MergeProposal, TestNumber};
use crate::session::action::Action;
use crate::session::verb::Verb;
use crate::session::{Session, merge_wording};

/// Widths in logical pixels.
const CARD: f32 = 470.0;
const NAMES: f32 = 104.0;
const VALUES: f32 = 136.0;
/// From the viewport's edges.
const MARGIN: f32 = 14.0;

pub(super) fn show(ctx: &Context, session: &Session, viewport: Rect, actions: &mut Vec<Action>) {
    if !session.is_judging() {
        return;
    }
    let card = Area::new(Id::unique("merge card"))
        .order(egui::Order::Middle)
        .pivot(Align2::CENTER_BOTTOM)
        .fixed_pos(viewport.center_bottom() - vec2(0.0, MARGIN))
        .show(ctx, |ui| {
            Frame::popup(ui.style()).inner_margin(12.0).show(ui, |ui| {
                ui.set_width(CARD.min(viewport.width() - 2.0 * MARGIN - 24.0));
                match &session.proposal {
                    Some(proposal) => card(ui, session, proposal, actions),
                    None => {
                        ui.horizontal(|ui| {
                            ui.spinner();
                            ui.label("Testing the merge…");
                        });
                    }
                }
            });
        });
    keep_clear(ctx, card.response.rect);
}

fn card(ui: &mut Ui, session: &Session, proposal: &MergeProposal, actions: &mut Vec<Action>) {
    let palette = Palette::of(ui);
    ui.horizontal(|ui| {
        ui.label(RichText::new("Merge").heading());
        ui.add_space(2.0);
        for (i, id) in [proposal.pair.0, proposal.pair.1].into_iter().enumerate() {
            if i > 0 {
                ui.label(RichText::new("and").heading().color(palette.weak));
            }
            swatch(ui, session, id);
            ui.label(RichText::new(id.to_string()).heading());
        }
        ui.label(RichText::new(format!("into {}", proposal.into)).heading().color(palette.weak));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let (text, color) = if proposal.is_acceptable {
                ("Recommended", palette.good)
            } else {
                ("Not recommended", palette.error)
            };
            ui.label(RichText::new(text).strong().color(color)).on_hover_text(
                "What Merge all would decide for this pair under the selected merging rule. You can decide \
                 otherwise",
            );
        });
    });
    ui.add_space(2.0);
    ui.add(Label::new(merge_wording::sentence(&proposal.reason)).wrap());
    ui.add_space(6.0);
    for number in &proposal.numbers {
        row(ui, number, domain(number, &proposal.numbers));
    }
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        let gap = ui.spacing().item_spacing.x;
        let width = (ui.available_width() - 3.0 * gap) / 4.0;
        primary_button(ui, session, Verb::AcceptMerge, width, actions);
        for verb in [Verb::SkipMerge, Verb::Undo, Verb::DropMerge] {
            verb_button(ui, session, verb, width, actions);
        }
    });
}

/// A value of the test as a bar, with its limit.
fn row(ui: &mut Ui, number: &TestNumber, (low, high): (f64, f64)) {
    let palette = Palette::of(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::hover());
    describe(&response, number);
    let middle = rect.center().y;
    let font = egui::FontId::proportional(13.0);
    let painter = ui.painter().with_clip_rect(rect);
    let name = pos2(rect.left(), middle);
    painter.text(
        name,
        Align2::LEFT_CENTER,
        merge_wording::quantity(number.quantity).0,
        font.clone(),
        palette.weak,
    );
    let color = match number.is_good {
        Some(true) => palette.good,
        Some(false) => palette.error,
        None => ui.visuals().text_color(),
    };
    let value = pos2(rect.right() - VALUES + 8.0, middle);
    let text = match number.threshold {
        Some(threshold) => format!("{}, limit {}", figure(number.value), figure(threshold)),
        None => figure(number.value),
    };
    painter.text(value, Align2::LEFT_CENTER, text, font, color);

    let track =
        Rect::from_x_y_ranges(rect.left() + NAMES..=rect.right() - VALUES, middle - 3.0..=middle + 3.0);
    let at = |v: f64| track.left() + track.width() * ((v - low) / (high - low)).clamp(0.0, 1.0) as f32;
    painter.rect_filled(track, 3.0, ui.visuals().widgets.inactive.bg_fill);
    let (from, to) = (at(0.0), at(number.value));
    let bar = Rect::from_x_y_ranges(from.min(to)..=from.max(to).max(from.min(to) + 2.0), track.y_range());
    let fill = if number.is_good.is_none() { palette.weak } else { color };
    painter.rect_filled(bar, 3.0, fill);
    if let Some(threshold) = number.threshold {
        let x = at(threshold);
        let mark = [pos2(x, middle - 7.0), pos2(x, middle + 7.0)];
        painter.line_segment(mark, egui::Stroke::new(2.0, ui.visuals().strong_text_color()));
    }
}

fn describe(response: &Response, number: &TestNumber) {
    let held = number.threshold.map_or_else(String::new, |t| format!(", limit {}", figure(t)));
    let verdict = match number.is_good {
        Some(true) => ", passes",
        Some(false) => ", fails",
        None => "",
    };
    let (name, unit, meaning) = merge_wording::quantity(number.quantity);
    let space = if unit.is_empty() { "" } else { " " };
    let label = format!("{name} {}{space}{unit}{held}{verdict}", figure(number.value));
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, label.clone()));
    let mut tooltip = format!("{meaning}.");
    if !unit.is_empty() {
        tooltip.push_str(&format!("\nIn {unit}"));
    }
    response.clone().on_hover_text(tooltip);
}

/// Range of a bar: 0, the value and the threshold, with some room. Values
/// without a threshold share a range, so that they can be compared.
fn domain(number: &TestNumber, all: &[TestNumber]) -> (f64, f64) {
    let unit = |n: &TestNumber| merge_wording::quantity(n.quantity).1;
    let is_like =
        |n: &&TestNumber| number.threshold.is_none() && n.threshold.is_none() && unit(n) == unit(number);
    let others = all.iter().filter(is_like).map(|n| n.value);
    let marks: Vec<f64> = [0.0, number.value, number.threshold.unwrap_or(0.0)]
        .into_iter()
        .chain(others)
        .map(|v| if v.is_finite() { v } else { 0.0 })
        .collect();
    let low = marks.iter().copied().fold(0.0, f64::min);
    let high = marks.iter().copied().fold(0.0, f64::max);
    let room = 0.15 * (high - low);
    match (low < 0.0, high > 0.0) {
        (false, false) => (0.0, 1.0),
        (below, above) => (if below { low - room } else { 0.0 }, if above { high + room } else { room }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::TestQuantity;

    #[test]
    fn bars_hold_what_they_show() {
        for (value, threshold) in
            [(0.3, Some(0.7)), (-2.0, Some(0.0)), (0.0, None), (0.0, Some(0.0)), (f64::NAN, Some(1.0))]
        {
            let number = TestNumber { quantity: TestQuantity::Gain, value, threshold, is_good: None };
            let (low, high) = domain(&number, std::slice::from_ref(&number));
            assert!(low <= 0.0 && high > low && high >= 0.0);
            for mark in [value, threshold.unwrap_or(0.0)] {
                assert!(mark.is_nan() || (low..=high).contains(&mark), "{value} {threshold:?}");
            }
        }
    }
}
