//! What α and p0 mean for the current shape, next to their sliders.

use egui::{RichText, Ui};

use super::theme::Palette;
use super::widgets::{count, length};
use crate::inference::{Params, Setting, expected_tables, new_table_distance};
use crate::session::Session;

/// The number of tables expected a priori for α.
pub(super) fn tables(ui: &mut Ui, session: &Session, params: &Params) {
    let Some(loaded) = &session.loaded else { return };
    if !params.reads(Setting::Alpha) {
        return;
    }
    let samples = loaded.cloud.points.len();
    let tables = expected_tables(params.alpha, samples);
    let number = if tables < 99.5 { format!("{tables:.1}") } else { count(tables.round() as usize) };
    note(
        ui,
        &format!("≈ {number} primitives expected for {} samples", count(samples)),
        "Number of primitives that the Chinese Restaurant Process expects a priori for this many samples: Σ \
         α/(α + i), i = 0 … N − 1",
    );
}

/// The distance beyond which a new table is preferred.
pub(super) fn distance(ui: &mut Ui, session: &Session, params: &Params) {
    let Some(usual) = Usual::of(session) else { return };
    if !params.reads(Setting::P0) {
        return;
    }
    let distance = new_table_distance(params.alpha, params.p0, usual.points, usual.sigma * usual.scale);
    let text = match distance {
        Some(distance) => format!("new primitive preferred beyond {}", length(distance / usual.scale)),
        None => "new primitive always preferred".to_owned(),
    };
    note(
        ui,
        &text,
        &format!(
            "Distance from a primitive's surface, in the file's units, beyond which a new primitive has \
             more weight than an existing one with the mean number of points n and the median noise σ of \
             this state (n = {}, σ = {}): n · N(d; σ) · ½ = α · p0",
            count(usual.points.round() as usize),
            length(usual.sigma)
        ),
    );
}

fn note(ui: &mut Ui, text: &str, tooltip: &str) {
    ui.label(RichText::new(text).small().color(Palette::of(ui).weak)).on_hover_text(tooltip);
}

/// A typical table of the current state.
struct Usual {
    /// Mean number of points.
    points: f64,
    /// Median noise, in input units.
    sigma: f64,
    /// From input units to the sampler's.
    scale: f64,
}

impl Usual {
    /// `None` without primitives.
    fn of(session: &Session) -> Option<Self> {
        let primitives = session.primitives();
        let mut sigmas: Vec<f64> = primitives.iter().map(|p| p.sigma).filter(|s| s.is_finite()).collect();
        if sigmas.is_empty() {
            return None;
        }
        sigmas.sort_unstable_by(f64::total_cmp);
        let points: usize = primitives.iter().map(|p| p.points).sum();
        Some(Self {
            points: points as f64 / primitives.len() as f64,
            sigma: sigmas[sigmas.len() / 2],
            scale: session.normalised_scale()?,
        })
    }
}
