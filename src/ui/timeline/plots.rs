//! The curves over the states.

use egui::{FontId, Label, Rangef, Rect, RichText, Sense, TextStyle, Ui, pos2, vec2};
use egui_plot::{AxisHints, GridMark, Line, Plot, PlotPoints, Points};

use super::axis::Axis;
use super::pointing::{scrub, value_text};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::curves::Curve;
use crate::ui::theme::Palette;
use crate::ui::widgets::within;

/// Width of the numbers at the y axis.
pub(super) const NUMBERS: f32 = 46.0;
/// Height that a number at the y axis has for itself.
const MARK: f32 = 13.0;
/// The least height in which a curve says something.
pub(super) const LEAST: f32 = 25.0;
/// A plot lower than this has its title in one line.
const LOW: f32 = 34.0;
/// Space over and under the curve, so that its dots and the numbers at the axis
/// are whole.
const PAD: f64 = 5.0;

/// One curve, from `names` (the left end of the row) on; the hovered state.
pub(super) fn show(
    ui: &mut Ui,
    session: &Session,
    curve: Curve,
    rect: Rect,
    axis: &Axis,
    actions: &mut Vec<Action>,
) -> Option<usize> {
    title(ui, session, curve, rect, axis.range().min - NUMBERS);
    let states = session.timeline.states();
    let points: Vec<[f64; 2]> = states
        .iter()
        .enumerate()
        .filter_map(|(i, state)| Some([i as f64, session.value_of(curve, state)?]))
        .collect();
    let height = f64::from(rect.height());
    let [low, high] = span(curve, &points, height);
    let measured: Vec<[f64; 2]> = match curve {
        Curve::Chamfer => {
            let is_exact = |i: usize| session.chamfer_of(states[i].key).is_some_and(|c| !c.is_rough);
            points.iter().copied().filter(|p| is_exact(p[0] as usize)).collect()
        }
        // A line through one point can't be seen.
        _ if points.len() == 1 => points.clone(),
        _ => Vec::new(),
    };
    let palette = Palette::of(ui);
    let plot_rect =
        Rect::from_min_max(pos2(axis.range().min - NUMBERS, rect.min.y), pos2(axis.range().max, rect.max.y));
    let bounds = axis.bounds();
    let most = f64::from(plot_rect.height() / MARK).min(4.0);
    let numbers = AxisHints::new_y()
        .min_thickness(NUMBERS)
        .label_spacing(Rangef::new(0.5 * MARK, 0.7 * MARK))
        .tick_label_font(FontId::proportional(TextStyle::Small.resolve(ui.style()).size))
        .tick_label_color(palette.weak)
        .formatter(move |mark, _| axis_number(curve, mark.value));
    let shown = within(ui, plot_rect, |ui| {
        Plot::new(("plot", curve.text()))
            .width(plot_rect.width())
            .height(plot_rect.height())
            .sense(Sense::click_and_drag())
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .allow_axis_zoom_drag(false)
            .allow_double_click_reset(false)
            .show_x(false)
            .show_y(false)
            .show_axes([false, true])
            .show_grid([false, true])
            .show_background(false)
            .label_formatter(|_| None)
            .custom_y_axes(vec![numbers])
            .y_grid_spacer(move |_| grid(low, high, most, 0.8 * PAD / height))
            .grid_color(ui.visuals().widgets.noninteractive.bg_stroke.color)
            .show(ui, |plot| {
                plot.set_plot_bounds_x(bounds[0]..=bounds[1]);
                plot.set_plot_bounds_y(low..=high);
                plot.line(
                    Line::new(curve.text(), PlotPoints::from(points))
                        .color(palette.accent)
                        .width(1.6)
                        .allow_hover(false),
                );
                plot.points(
                    Points::new("measured", PlotPoints::from(measured))
                        .color(palette.accent)
                        .radius(2.6)
                        .allow_hover(false),
                );
            })
    });
    let response = shown.response;
    let text = format!("{} over the states", curve.text());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
    scrub(ui, session, axis, &response, actions)
}

/// The curve's name with its value at the shown state.
fn title(ui: &mut Ui, session: &Session, curve: Curve, rect: Rect, right: f32) {
    let palette = Palette::of(ui);
    let cell = Rect::from_min_max(rect.min, pos2(right - 6.0, rect.max.y)).shrink2(vec2(0.0, 1.0));
    within(ui, cell, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        let value =
            session.snapshot.as_ref().map_or_else(|| "–".to_owned(), |s| value_text(session, curve, s));
        let name = RichText::new(curve.text()).small().color(palette.weak);
        let layout = if rect.height() < LOW {
            egui::Layout::left_to_right(egui::Align::Center)
        } else {
            egui::Layout::top_down(egui::Align::Min)
        };
        ui.with_layout(layout, |ui| {
            ui.label(name).on_hover_text(curve.tooltip());
            ui.add(Label::new(value).truncate()).on_hover_text(curve.tooltip());
        });
    });
}

/// What the y axis of a plot of some height shows: all points, zero where that
/// is the best a curve can come to, and some space at both ends.
fn span(curve: Curve, points: &[[f64; 2]], height: f64) -> [f64; 2] {
    let low = points.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = match curve {
        _ if low > high => (0.0, 1.0),
        Curve::LogJoint => {
            let least = (2e-3 * high.abs()).max(2e-9);
            let lacks = 0.5 * (least - (high - low)).max(0.0);
            (low - lacks, high + lacks)
        }
        Curve::Clusters => (0.0, high.max(4.0)),
        Curve::MeanError | Curve::Chamfer => (0.0, if high > 0.0 { high } else { 1.0 }),
    };
    let margin = (high - low) * PAD / (height - 2.0 * PAD).max(PAD);
    [low - margin, high + margin]
}

/// A few marks at round values, at `most` so many, none in the outermost part
/// `edge` of the span, where its number would be cut.
fn grid(low: f64, high: f64, most: f64, edge: f64) -> Vec<GridMark> {
    let span = high - low;
    if !(span.is_finite() && span > 0.0) {
        return Vec::new();
    }
    // The smallest of 1, 2, 5 times a power of ten that leaves room for the numbers.
    let power = 10_f64.powf(span.log10().floor() - 1.0);
    let steps = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0].map(|n| n * power);
    let Some(step) = steps.into_iter().find(|s| span / s < most.max(1.2)) else { return Vec::new() };
    let first = (low / step).ceil() as i64;
    let inner = low + edge * span..=high - edge * span;
    (first..first + 5)
        .map(|i| i as f64 * step)
        .filter(|value| inner.contains(value))
        .map(|value| GridMark { value, step_size: step })
        .collect()
}

/// As short as an axis needs.
fn axis_number(curve: Curve, value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if curve == Curve::LogJoint && value.abs() >= 1e3 && value.abs() < 1e7 {
        format!("{} k", (value * 1e-2).round() / 10.0)
    } else if value.abs() >= 1e4 || value.abs() < 1e-3 {
        format!("{value:.0e}")
    } else {
        format!("{}", (value * 1e4).round() / 1e4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_y_axis_has_a_few_round_marks_within() {
        for (low, high) in [(0.0, 33.0), (0.0, 0.0123), (-15_432.0, 20_211.0), (3.0e-9, 7.0e-9)] {
            let marks = grid(low, high, 3.0, 0.0);
            assert!((1..=4).contains(&marks.len()), "{low} {high}");
            assert!((1..=2).contains(&grid(low, high, 1.5, 0.0).len()), "{low} {high}");
            assert!(grid(low, high, 3.0, 0.1).iter().all(|m| (m.value - low) / (high - low) > 0.099));
            assert!(marks.iter().all(|m| m.value >= low && m.value <= high));
        }
        assert!(grid(0.0, f64::NAN, 3.0, 0.0).is_empty() && grid(1.0, 1.0, 3.0, 0.0).is_empty());
    }

    /// Also in the lowest plot the curve has most of the height, and its dots and
    /// the number at zero are whole.
    #[test]
    fn a_curve_keeps_away_from_the_edges_and_has_the_rest() {
        for height in [f64::from(LEAST) - 3.0, 60.0, 200.0] {
            for curve in Curve::ALL {
                for values in [[5.0, 30.0], [-900.0, -20.0], [0.02, 0.02]] {
                    let points = values.map(|v| [0.0, v]);
                    let [low, high] = span(curve, &points, height);
                    let at = |v: f64| height * (v - low) / (high - low);
                    let lowest = if curve == Curve::LogJoint { values[0] } else { 0.0 };
                    for value in [lowest, values[1].max(lowest)] {
                        assert!(at(value) > 4.9 && at(value) < height - 4.9, "{curve:?} {height}");
                    }
                    let marks = grid(low, high, 2.0, 0.8 * PAD / height);
                    assert!(marks.iter().all(|m| at(m.value) > 3.9 && at(m.value) < height - 3.9));
                }
            }
        }
    }

    #[test]
    fn numbers_at_the_axis_are_short() {
        for curve in Curve::ALL {
            for value in [0.0, 0.0025, 12.0, -1234.0, 98_765.0, -5.4e5, 1e-7, 1e12] {
                assert!(axis_number(curve, value).len() <= 8, "{}", axis_number(curve, value));
            }
        }
        assert_eq!(axis_number(Curve::LogJoint, -15_400.0), "-15.4 k");
    }
}
