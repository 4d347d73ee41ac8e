//! The metrics of the current state against the shape, as in `evaluate`.

use egui::{Label, RichText, Ui};

use super::theme::Palette;
use super::widgets::count;
use crate::geometry::metrics::Metrics;
use crate::inference::Phase;
use crate::session::Session;

/// Minimum width of a metric.
const CELL: f32 = 72.0;
/// Heights of a row of metrics and of a line of text below.
const ROW: f32 = 30.0;
const REMARK: f32 = 16.0;

/// Name, value and meaning of a metric.
struct Figure {
    name: &'static str,
    value: String,
    meaning: String,
    /// The value belongs to an earlier result.
    is_old: bool,
}

pub(super) fn show(ui: &mut Ui, session: &Session) {
    let figures = figures(session);
    // As few rows as the width allows, all of the same length.
    let fitting = ((ui.available_width() / CELL) as usize).clamp(1, figures.len());
    let columns = figures.len().div_ceil(figures.len().div_ceil(fitting));
    let weak = Palette::of(ui).weak;
    for row in figures.chunks(columns) {
        ui.columns(columns, |cells| {
            for (cell, figure) in cells.iter_mut().zip(row) {
                cell.spacing_mut().item_spacing.y = 0.0;
                cell.add(Label::new(RichText::new(figure.name).small().color(weak)).truncate())
                    .on_hover_text(&figure.meaning);
                let value = RichText::new(&figure.value);
                let value = if figure.is_old { value.color(weak) } else { value };
                cell.add(Label::new(value).truncate()).on_hover_text(&figure.meaning);
            }
        });
    }
    if let Some(remark) = remark(session) {
        ui.add(Label::new(RichText::new(&remark).small().color(weak)).wrap()).on_hover_text(&remark);
    }
}

/// Height of the metrics in a wide row, including notes.
pub(super) fn row_height(session: &Session) -> f32 {
    if remark(session).is_some() { ROW + REMARK } else { ROW }
}

fn figures(session: &Session) -> Vec<Figure> {
    let present = metrics(session);
    // While sliders are turned, results come faster than they are measured: the
    // last figures stay, in grey, so that nothing flickers.
    let metrics = present.or_else(|| last_of_live(session));
    let is_old = present.is_none();
    let unknown = if session.is_measuring() { "…" } else { "–" };
    let waits = if session.is_measuring() {
        "Measuring…"
    } else {
        "Measured when the run finishes, pauses or is stepped"
    };
    let measured = |name, value: Option<f64>, digits: usize, meaning: String| Figure {
        name,
        value: match (metrics, value) {
            (None, _) => unknown.to_owned(),
            (_, Some(value)) => format!("{value:.digits$}"),
            (_, None) => "–".to_owned(),
        },
        meaning: match (metrics.is_some(), is_old) {
            (false, _) => format!("{meaning}\n{waits}"),
            (true, true) => {
                format!("{meaning}\nThis value is from the last measured result; an update is pending")
            }
            (true, false) => meaning,
        },
        is_old,
    };
    let unit = "Lengths are in units of the longest edge of the input's bounding box";
    let mut overlap = "Intersection over union: volume shared by primitives and input divided by \
         the volume of their union; 1 is perfect. The inside of a mesh is where its winding \
         number exceeds ½"
        .to_owned();
    if let Some(metrics) = metrics {
        overlap +=
            &metrics.iou_error.map_or_else(String::new, |error| format!("\nStandard error {error:.3}"));
        overlap += &metrics
            .iou_outside
            .map_or_else(String::new, |iou| format!("\nAgainst the input with cavities filled: {iou:.3}"));
        overlap +=
            &metrics.iou_missing.as_ref().map_or_else(String::new, |why| format!("\nNot available: {why}"));
    }
    let state = session.snapshot.as_ref().map(|s| &s.abstraction);
    let share = state.map(|a| 100.0 * a.figures.unassigned as f64 / a.labels.len().max(1) as f64);
    vec![
        measured(
            "Chamfer-L1",
            metrics.and_then(|m| m.chamfer_l1),
            5,
            format!("Mean of accuracy and completeness: how far apart primitives and input are. {unit}"),
        ),
        measured(
            "Accuracy",
            metrics.and_then(|m| m.accuracy),
            5,
            format!("Mean distance from the surface of the primitives' union to the input. {unit}"),
        ),
        measured(
            "Completeness",
            metrics.and_then(|m| m.completeness),
            5,
            format!("Mean distance from the input to the surface of the primitives' union. {unit}"),
        ),
        measured("IoU", metrics.and_then(|m| m.iou), 3, overlap),
        Figure {
            name: "Primitives",
            value: state.map_or_else(|| "–".to_owned(), |a| count(a.primitives.len())),
            meaning: "Number of primitives in the current state".to_owned(),
            is_old: false,
        },
        Figure {
            name: "Unassigned",
            value: share.map_or_else(|| "–".to_owned(), |share| format!("{share:.1} %")),
            meaning: "Share of the samples that belong to no primitive".to_owned(),
            is_old: false,
        },
    ]
}

fn metrics(session: &Session) -> Option<&Metrics> {
    session.measurement().and_then(|m| m.result.as_ref().ok())
}

/// The metrics of the current state, or the last ones while they are measured.
fn last_of_live(session: &Session) -> Option<&Metrics> {
    let is_coming = session.live.is_on
        && session.phase() == Some(Phase::Finished)
        && (session.live.is_renewing() || session.is_measuring());
    session.last_measurement().filter(|_| is_coming).and_then(|m| m.result.as_ref().ok())
}

/// Why a metric is missing, shown without a tooltip. Reasons that depend only on
/// the shape are shown for all its states, so that the layout does not jump.
fn remark(session: &Session) -> Option<String> {
    match &session.last_measurement()?.result {
        Err(why) => Some(format!("Not measured: {why}")),
        Ok(last) => {
            let why = last.iou_missing.as_ref()?;
            let filled = metrics(session).and_then(|m| m.iou_outside);
            let filled = filled.map(|iou| format!("; with cavities filled {iou:.3}"));
            Some(format!("No IoU: {why}{}", filled.unwrap_or_default()))
        }
    }
}
