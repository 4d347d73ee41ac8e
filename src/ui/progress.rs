//! Under the viewport: how far the run is, the figures of the present state,
//! and K and the mean error of every step; at the very bottom the status line.

use std::sync::Arc;

use egui::{Color32, Layout, ProgressBar, RichText, Ui, vec2};
use egui_plot::{GridMark, Line, Plot, PlotPoints, VLine};

use super::figures;
use super::theme::Palette;
use super::widgets::{count, length};
use crate::inference::{Algorithm, Phase, Setting};
use crate::session::Session;
use crate::worker::{Activity, Snapshot};

/// Height of a plot.
const PLOT: f32 = 76.0;

pub(super) fn show(ui: &mut Ui, session: &Session) {
    ui.horizontal(|ui| {
        let iteration = session.snapshot.as_ref().map_or(0, |s| s.abstraction.iteration);
        let (done, text) = advance(session, iteration);
        let bar = ProgressBar::new(done.clamp(0.0, 1.0) as f32)
            .desired_width(130.0)
            .desired_height(8.0)
            .fill(Palette::of(ui).accent);
        ui.add(bar).on_hover_text(&text);
        ui.label(text);
    });
    ui.add_space(2.0);
    figures::show(ui, session);
    ui.add_space(2.0);
    let entries = session.timeline.states();
    let gap = ui.spacing().item_spacing.x + 8.0;
    let width = (ui.available_width() - gap) / 2.0;
    ui.horizontal(|ui| {
        let k = Curve {
            id: "plot of K",
            title: "Primitives K",
            now: entries.last().map(|e| count(e.abstraction.figures.clusters)),
            value: |e| e.abstraction.figures.clusters as f64,
            least_span: 4.0,
        };
        k.show(ui, session, width);
        ui.add_space(gap - ui.spacing().item_spacing.x);
        let error = Curve {
            id: "plot of the mean error",
            title: "Mean error",
            now: entries.last().map(|e| length(e.abstraction.figures.mean_distance)),
            value: |e| e.abstraction.figures.mean_distance,
            least_span: 0.0,
        };
        error.show(ui, session, width);
    });
}

/// Steps of the whole present run, with the T that the slider has now.
fn steps(session: &Session) -> Option<u32> {
    let start = session.snapshot.as_ref().map_or(session.params, |s| s.start);
    if !start.reads(Setting::Iterations) {
        return start.steps();
    }
    match &session.snapshot {
        // It will not go on to another T, but be replaced.
        Some(result) if session.live.is_on && result.abstraction.phase == Phase::Finished => {
            Some(result.abstraction.iteration)
        }
        _ => Some(session.params.iterations),
    }
}

/// How much of the run is done, from 0 to 1, and in words.
fn advance(session: &Session, step: u32) -> (f64, String) {
    let is_finished = session.phase() == Some(Phase::Finished);
    match (session.algorithm(), steps(session)) {
        (Algorithm::Sampler, Some(total)) => {
            // T may have been moved below what is done already.
            let total = total.max(step);
            (f64::from(step) / f64::from(total.max(1)), format!("Iteration {step} of {total}"))
        }
        (algorithm, Some(total)) => {
            // There may be fewer clusters than were asked for.
            let total = if is_finished { step } else { total.max(step) };
            let done = if is_finished { 1.0 } else { f64::from(step) / f64::from(total.max(1)) };
            (done, format!("{}: step {step} of {total}", algorithm.title()))
        }
        (algorithm, None) => {
            // How long it takes nobody knows; what is explained can only grow.
            let explained = session.snapshot.as_ref().map_or(0.0, |s| {
                let points = s.abstraction.labels.len().max(1);
                1.0 - s.abstraction.figures.unassigned as f64 / points as f64
            });
            let done = match (is_finished, step) {
                (true, _) => 1.0,
                (false, 0) => 0.0,
                (false, _) => 0.9 * explained,
            };
            (done, format!("{}: step {step}", algorithm.title()))
        }
    }
}

/// One small plot over the steps of the run.
struct Curve {
    id: &'static str,
    title: &'static str,
    now: Option<String>,
    value: fn(&Snapshot) -> f64,
    /// The y axis shows at least this much.
    least_span: f64,
}

impl Curve {
    fn show(self, ui: &mut Ui, session: &Session, width: f32) {
        let palette = Palette::of(ui);
        let entries = session.timeline.states();
        ui.vertical(|ui| {
            ui.set_width(width);
            ui.horizontal(|ui| {
                ui.label(RichText::new(self.title).small().color(palette.weak));
                ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(RichText::new(self.now.as_deref().unwrap_or("–")).small().strong());
                });
            });
            let value = self.value;
            let points: Vec<[f64; 2]> = entries
                .iter()
                .enumerate()
                .map(|(i, entry)| [i as f64, value(entry)])
                .filter(|[_, y]| y.is_finite())
                .collect();
            let top = points.iter().map(|p| p[1]).fold(self.least_span, f64::max);
            let last = steps(session).map_or(1, |total| total as usize).max(entries.len()) as f64;
            // Merges come after the iteration they belong to: the marks say where.
            let merges: Vec<f64> = entries
                .windows(2)
                .enumerate()
                .filter(|(_, pair)| pair[0].abstraction.iteration == pair[1].abstraction.iteration)
                .map(|(i, _)| (i + 1) as f64)
                .collect();
            let rows: Vec<Arc<Snapshot>> = entries.to_vec();
            let step_name = if session.algorithm() == Algorithm::Sampler { "Iteration" } else { "Step" };
            Plot::new(self.id)
                .height(PLOT)
                .width(width)
                .allow_drag(false)
                .allow_zoom(false)
                .allow_scroll(false)
                .allow_boxed_zoom(false)
                .allow_double_click_reset(false)
                .show_axes([false, true])
                .show_grid([false, true])
                .show_background(false)
                .y_axis_min_width(34.0)
                .y_grid_spacer(move |_| marks(top))
                .y_axis_formatter(|mark, _| axis_number(mark.value))
                .include_x(0.0)
                .include_x(last)
                .include_y(0.0)
                .include_y(if top > 0.0 { 1.08 * top } else { 1.0 })
                .label_formatter(move |position| {
                    let step = match position {
                        egui_plot::HoverPosition::NearDataPoint { position, .. }
                        | egui_plot::HoverPosition::Elsewhere { position } => position.x.round(),
                    };
                    let entry = (step >= 0.0).then(|| rows.get(step as usize)).flatten()?;
                    Some(format!(
                        "{step_name} {}\nK {}\nMean error {}",
                        entry.abstraction.iteration,
                        entry.abstraction.figures.clusters,
                        length(entry.abstraction.figures.mean_distance)
                    ))
                })
                .show(ui, |plot| {
                    for x in merges {
                        plot.vline(
                            VLine::new("merge", x).color(faint(palette.weak)).width(1.0).allow_hover(false),
                        );
                    }
                    plot.line(
                        Line::new(self.title, PlotPoints::from(points)).color(palette.accent).width(1.8),
                    );
                });
        });
    }
}

/// Marks at 0 and at one or two round values below `top`.
fn marks(top: f64) -> Vec<GridMark> {
    if !(top.is_finite() && top > 0.0) {
        return Vec::new();
    }
    // The smallest of 1, 2, 5, 10 times a power of ten that leaves room for the numbers.
    let power = 10_f64.powf(top.log10().floor() - 1.0);
    let step = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0].map(|n| n * power).into_iter().find(|s| top / s < 2.5);
    let Some(step) = step else { return Vec::new() };
    (0..=(top / step) as usize).map(|i| GridMark { value: i as f64 * step, step_size: step }).collect()
}

fn faint(color: Color32) -> Color32 {
    color.gamma_multiply(0.3)
}

/// As short as an axis needs.
fn axis_number(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if value.abs() >= 1e4 || value.abs() < 1e-3 {
        format!("{value:.0e}")
    } else {
        format!("{}", (value * 1e4).round() / 1e4)
    }
}

pub(super) fn status(ui: &mut Ui, session: &Session) {
    let palette = Palette::of(ui);
    ui.horizontal(|ui| {
        let (dot, text) = match session.activity {
            Activity::Loading => (palette.accent, "Loading"),
            Activity::Running => (palette.good, "Running"),
            Activity::Merging => (palette.good, "Merging"),
            Activity::Renewing => (palette.accent, "Renewing"),
            Activity::Writing => (palette.accent, "Writing"),
            Activity::Idle => match session.phase() {
                None => (palette.weak, "No shape"),
                Some(Phase::Start) => (palette.weak, "Ready"),
                Some(Phase::Sampling | Phase::Merging) => (palette.weak, "Paused"),
                Some(Phase::Finished) => (palette.good, "Finished"),
            },
        };
        let (rect, _) = ui.allocate_exact_size(vec2(8.0, 8.0), egui::Sense::hover());
        ui.painter().circle_filled(rect.center(), 4.0, dot);
        ui.label(text);
        if let (Some(snapshot), Some(loaded)) = (&session.snapshot, &session.loaded) {
            let figures = snapshot.abstraction.figures;
            let seconds = snapshot.elapsed.as_secs_f64();
            let primitives = if figures.clusters == 1 { "primitive" } else { "primitives" };
            for (text, tooltip) in [
                (format!("{} {primitives}", count(figures.clusters)), "Primitives in the present state"),
                (
                    format!(
                        "{} of {} unassigned",
                        count(figures.unassigned),
                        count(loaded.cloud.points.len())
                    ),
                    "Samples that belong to no primitive",
                ),
                (
                    format!("mean error {}", length(figures.mean_distance)),
                    "Mean distance of the assigned samples to their primitive, in the file's units",
                ),
                (
                    format!("{seconds:.2} s"),
                    "Computing time of this run; pauses and the pace are not counted",
                ),
            ] {
                ui.separator();
                ui.label(RichText::new(text).color(palette.weak)).on_hover_text(tooltip);
            }
        }
    });
}
