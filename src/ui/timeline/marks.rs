//! The marks for events.

use std::collections::BTreeSet;

use egui::{Color32, Painter, Pos2, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};

use crate::session::timeline::Mark;
use crate::ui::theme::Palette;

/// What the mark means, for the legend's tooltip.
fn meaning(mark: Mark) -> &'static str {
    match mark {
        Mark::Birth => "A point that fitted no cluster opened a new one",
        Mark::Death => "A cluster lost its last points",
        Mark::Split => "A cluster was split, cut or reduced to its largest part",
        Mark::Freeze => "A cluster fits so well that its points keep their label",
        Mark::Merge => "Two clusters were merged",
        Mark::Edit => "A manual edit",
    }
}

pub(super) fn color(ui: &Ui, mark: Mark) -> Color32 {
    Palette::of(ui).marks[mark as usize]
}

/// Different in form too, for whoever can't tell the colours apart.
pub(super) fn paint(painter: &Painter, at: Pos2, r: f32, mark: Mark, color: Color32) {
    let polygon = |points: &[(f32, f32)]| {
        let points = points.iter().map(|(x, y)| pos2(at.x + r * x, at.y + r * y)).collect();
        Shape::convex_polygon(points, color, Stroke::NONE)
    };
    match mark {
        Mark::Birth => {
            painter.add(polygon(&[(0.0, -1.1), (1.1, 0.9), (-1.1, 0.9)]));
        }
        Mark::Death => {
            let stroke = Stroke::new(0.55 * r, color);
            let d = 0.85 * r;
            painter.line_segment([at - vec2(d, d), at + vec2(d, d)], stroke);
            painter.line_segment([at + vec2(-d, d), at + vec2(d, -d)], stroke);
        }
        Mark::Split => {
            painter.add(polygon(&[(0.0, -1.2), (1.2, 0.0), (0.0, 1.2), (-1.2, 0.0)]));
        }
        Mark::Freeze => {
            painter.add(polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]));
        }
        Mark::Merge => {
            painter.circle_filled(at, r, color);
        }
        Mark::Edit => {
            painter.circle_stroke(at, 0.8 * r, Stroke::new(0.6 * r, color));
        }
    }
}

/// Width of [`legend`].
pub(super) fn legend_width(marks: &BTreeSet<Mark>) -> f32 {
    marks.iter().map(|mark| 26.0 + 6.0 * mark.text().len() as f32).sum()
}

/// What the shapes mean.
pub(super) fn legend(ui: &mut Ui, marks: &BTreeSet<Mark>) {
    let weak = Palette::of(ui).weak;
    for &mark in marks {
        ui.scope(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            let (rect, _) = ui.allocate_exact_size(vec2(9.0, 14.0), Sense::hover());
            paint(ui.painter(), rect.center(), 3.6, mark, color(ui, mark));
            ui.label(RichText::new(mark.text()).small().color(weak)).on_hover_text(meaning(mark));
        });
    }
}
