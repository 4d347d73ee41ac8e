//! The paper's two equations with the numbers of one table.

use egui::{Frame, Label, Margin, RichText, Ui};

use super::rows::{Row, percent};
use crate::inference::Explanation;
use crate::session::Session;
use crate::ui::theme::Palette;
use crate::ui::widgets::{count, figure, length, setting};

pub(super) fn show(ui: &mut Ui, session: &Session, explanation: &Explanation, row: Row<'_>) {
    let fill = ui.visuals().extreme_bg_color;
    Frame::new().fill(fill).corner_radius(4.0).inner_margin(Margin::symmetric(8, 6)).show(ui, |ui| {
        ui.set_min_width(ui.available_width());
        ui.spacing_mut().item_spacing.y = 2.0;
        let total = explanation.new.weight + explanation.tables.iter().map(|t| t.weight).sum::<f64>();
        let (law, terms, weight) = match row {
            Row::Present(odds) => {
                let terms = format!(
                    "{} · {} · ½ = {}",
                    count(odds.n.max(0.0) as usize),
                    figure(odds.density),
                    figure(odds.weight)
                );
                (format!("weight of {} = n · N(d; 0, σ²) · ½", odds.id), terms, odds.weight)
            }
            Row::New(new) => {
                let terms = format!("{} · {} = {}", setting(new.alpha), setting(new.p0), figure(new.weight));
                ("weight of a new table = α · p0".to_owned(), terms, new.weight)
            }
        };
        ui.label(RichText::new(law).strong());
        line(ui, &terms);
        let share = percent(row.probability());
        let whose = match row {
            Row::Present(odds) => odds.id.to_string(),
            Row::New(_) => "new".to_owned(),
        };
        line(ui, &format!("p(z = {whose}) = {} / {} = {share}", figure(weight), figure(total)))
            .on_hover_text("The weight divided by the sum of all weights");
        let weak = Palette::of(ui).weak;
        let note = match row {
            Row::Present(odds) if odds.n == 0.0 => {
                "A locked primitive takes no points: n counts as 0.".to_owned()
            }
            Row::Present(odds) => {
                let scale = session.normalised_scale().unwrap_or(1.0);
                format!(
                    "d = {} and σ = {} in the file's units; multiply by {} for the sampler's units.",
                    length(odds.distance_input),
                    length(odds.sigma / scale),
                    figure(scale)
                )
            }
            Row::New(_) => {
                "α is the concentration; p0 is the density that a new table assigns to any point.".to_owned()
            }
        };
        ui.add(Label::new(RichText::new(note).small().color(weak)).wrap());
        let samples = session.loaded.as_ref().map_or(0, |l| l.cloud.points.len());
        let alpha = explanation.new.alpha;
        let divisor = length(samples as f64 - 1.0 + alpha);
        ui.add(
            Label::new(
                RichText::new("The common divisor N − 1 + α cancels and is omitted.").small().color(weak),
            )
            .wrap(),
        )
        .on_hover_text(format!(
            "The paper divides both weights by N − 1 + α = {divisor}, where N = {} samples",
            count(samples)
        ));
    });
}

fn line(ui: &mut Ui, text: &str) -> egui::Response {
    ui.add(Label::new(RichText::new(text).monospace()).wrap())
}
