//! The progress of the run, and the status bar.

use egui::{RichText, Ui, vec2};

use super::theme::Palette;
use super::widgets::{count, length};
use crate::inference::{Algorithm, Phase, Setting};
use crate::session::Session;
use crate::worker::Activity;

/// Steps of the whole present run, with the T that the slider has now.
pub(super) fn steps(session: &Session) -> Option<u32> {
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
pub(super) fn advance(session: &Session, step: u32) -> (f64, String) {
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

pub(super) fn status(ui: &mut Ui, session: &Session) {
    let palette = Palette::of(ui);
    ui.horizontal(|ui| {
        let (dot, text) = match session.activity {
            Activity::Loading => (palette.accent, "Loading"),
            Activity::Running => (palette.good, "Running"),
            Activity::Merging => (palette.good, "Merging"),
            Activity::LiveRun => (palette.accent, "Updating"),
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
                (format!("{} {primitives}", count(figures.clusters)), "Primitives in the current state"),
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
                (format!("{seconds:.2} s"), "Computing time of this run, without pauses and display delays"),
            ] {
                ui.separator();
                ui.label(RichText::new(text).color(palette.weak)).on_hover_text(tooltip);
            }
        }
    });
}
