//! The handles of a selected primitive, drawn over the picture.

use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, Ui, Vec2};
use nalgebra::Vector2;

use crate::session::gizmo::{Figure, Gizmo, Handle, Part};
use crate::ui::theme::Palette;

/// What is drawn over a view: the handles, and the one that the pointer is over
/// or drags.
#[derive(Debug, Clone, Copy)]
pub(in crate::ui) struct Handles {
    pub(in crate::ui) gizmo: Gizmo,
    pub(in crate::ui) lit: Option<Handle>,
}

/// Logical pixels.
const LINE: f32 = 2.2;
const LIT_LINE: f32 = 3.6;
const HEAD: (f32, f32) = (12.0, 5.0);
const KNOB: f32 = 5.5;

pub(super) fn paint(ui: &Ui, rect: Rect, handles: &Handles) {
    let painter = ui.painter().with_clip_rect(rect);
    let palette = Palette::of(ui);
    for part in handles.gizmo.parts() {
        let is_lit = handles.lit == Some(part.handle);
        let color = match part.handle {
            _ if is_lit => palette.on_axis_hot,
            // Others step back while one is held.
            handle => {
                let color = handle.axis().map_or(palette.weak, |axis| palette.axes[axis]);
                if handles.lit.is_some() { color.gamma_multiply(0.55) } else { color }
            }
        };
        draw(&painter, rect.min, &part, color, is_lit, palette.overlay);
    }
}

fn draw(painter: &Painter, corner: Pos2, part: &Part, color: Color32, is_lit: bool, ground: Color32) {
    let at = |p: &Vector2<f64>| corner + Vec2::new(p.x as f32, p.y as f32);
    let width = if is_lit { LIT_LINE } else { LINE };
    let stroke = Stroke::new(width, color);
    // A breath of the ground around lines keeps them apart from the shape.
    let halo = Stroke::new(width + 2.0, ground.gamma_multiply(0.45));
    match &part.figure {
        Figure::Arrow(from, to) => {
            let (from, to) = (at(from), at(to));
            let along = (to - from).normalized();
            let base = to - along * HEAD.0;
            painter.line_segment([from, base], halo);
            painter.line_segment([from, base], stroke);
            let head = vec![to, base + along.rot90() * HEAD.1, base - along.rot90() * HEAD.1];
            painter.add(Shape::convex_polygon(head, color, Stroke::NONE));
        }
        Figure::Square(corners) => {
            let corners = corners.iter().map(at).collect();
            let fill = color.gamma_multiply(if is_lit { 0.6 } else { 0.28 });
            painter.add(Shape::convex_polygon(corners, fill, Stroke::new(0.5 * width, color)));
        }
        Figure::Ring(points) => {
            for ((a, faces), (b, _)) in points.iter().zip(points.iter().cycle().skip(1)) {
                let line = [at(a), at(b)];
                if *faces {
                    painter.line_segment(line, halo);
                    painter.line_segment(line, stroke);
                } else {
                    painter.line_segment(line, Stroke::new(1.0, color.gamma_multiply(0.25)));
                }
            }
        }
        Figure::Knob { from, at: knob } => {
            let (from, knob) = (at(from), at(knob));
            painter.line_segment([from, knob], Stroke::new(0.6 * width, color.gamma_multiply(0.8)));
            let radius = if is_lit { KNOB + 1.5 } else { KNOB };
            match part.handle {
                // Scaling has cubes, as in other programs.
                Handle::ScaleAxis(_) => {
                    let cube = Rect::from_center_size(knob, Vec2::splat(1.8 * radius));
                    painter.rect_filled(cube.expand(1.0), 1.0, ground.gamma_multiply(0.45));
                    painter.rect_filled(cube, 1.0, color);
                }
                _ => {
                    painter.circle(knob, radius, color, Stroke::new(1.0, ground.gamma_multiply(0.6)));
                }
            }
        }
        Figure::Circle(center, radius) => {
            let (center, radius) = (at(center), *radius as f32);
            if radius < 10.0 {
                painter.circle(center, radius, color.gamma_multiply(0.35), stroke);
            } else {
                painter.circle_stroke(center, radius, halo);
                painter.circle_stroke(center, radius, Stroke::new(0.7 * width, color));
            }
        }
    }
}
