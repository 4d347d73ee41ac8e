//! The scale in input units: numbers along the ground grid, and a scale bar.

use egui::{Align2, FontId, Rect, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, pos2, vec2};
use nalgebra::Point3;

use super::frame::cell;
use crate::render::Frame;
use crate::session::scalar::round_up;
use crate::session::view::Layer;
use crate::ui::scene::SceneView;
use crate::ui::theme::Palette;
use crate::ui::widgets::figure;

/// Logical pixels from number to number, at least.
const GAP: f32 = 46.0;
/// Least and most numbers along an edge.
const MOST: usize = 40;
/// Logical pixels that the bar is about as long as.
const BAR: f64 = 70.0;

pub(super) fn show(ui: &Ui, view: &SceneView<'_>, frame: &Frame, rect: Rect) {
    if view.view.shows(Layer::Grid) {
        numbers(ui, view, frame, rect);
    }
    bar(ui, view, frame, rect);
}

/// The input's coordinates along the two edges of the shape's footprint that
/// face the camera.
fn numbers(ui: &Ui, view: &SceneView<'_>, frame: &Frame, rect: Rect) {
    let scene = view.scene;
    let bounds = &scene.bounds;
    let forward = frame.camera.forward();
    // From the side, or from below, the ground is a line or hides the shape.
    if forward.y > -0.05 {
        return;
    }
    let painter = ui.painter().with_clip_rect(rect);
    let axes = Palette::of(ui).axes;
    let inverse = 1.0 / scene.scale();
    let zero = scene.point(&Point3::origin());
    let on_screen = |p: Point3<f64>| {
        let pixel = frame.camera.project(glam::DVec3::new(p.x, p.y, p.z).as_vec3(), frame.size_px)?;
        Some(rect.min + vec2(pixel.x, pixel.y) / frame.pixels_per_point)
    };
    for (along, across, towards) in [(0, 2, forward.z), (2, 0, forward.x)] {
        let margin = 0.04 + 0.02 * bounds.size().max();
        let edge = if towards <= 0.0 { bounds.max[across] + margin } else { bounds.min[across] - margin };
        let place = |at: f64| {
            let mut p = bounds.min;
            p[along] = at;
            p[across] = edge;
            p
        };
        let (from, to) = (bounds.min[along], bounds.max[along]);
        let (Some(a), Some(b)) = (on_screen(place(from)), on_screen(place(to))) else { continue };
        // As many cells from number to number as there is room for.
        let per_cell = (b - a).length() * (cell(view) / ((to - from).max(1e-9) * inverse)) as f32;
        let cells = [1.0, 2.0, 5.0, 10.0, 20.0].into_iter().find(|c| c * per_cell >= GAP);
        let Some(step) = cells.map(|c| cell(view) * f64::from(c)) else { continue };
        // The input's coordinate: the scene's axis is an input axis, maybe turned round.
        let (axis, sign) = input_axis(view, along);
        let color = axes[axis].gamma_multiply(0.85);
        let value = |at: f64| (at - zero[along]) * inverse * sign;
        let (low, high) = (value(from).min(value(to)), value(from).max(value(to)));
        let first = (low / step).ceil();
        for k in (0..MOST).map(|k| first + k as f64).take_while(|k| k * step <= high + 1e-9 * step) {
            let at = zero[along] + k * step * scene.scale() / sign;
            let Some(p) = on_screen(place(at)) else { continue };
            let text = tick(k * step, step);
            painter.text(p, Align2::CENTER_CENTER, text, FontId::proportional(10.5), color);
        }
    }
}

/// The input's axis that an axis of the scene is, and 1 where it runs the same
/// way or −1 where against it.
fn input_axis(view: &SceneView<'_>, along: usize) -> (usize, f64) {
    let zero = view.scene.point(&Point3::origin());
    let step = 1.0 / view.scene.scale();
    (0..3)
        .map(|axis| {
            let mut p = Point3::origin();
            p[axis] = step;
            (axis, (view.scene.point(&p) - zero)[along])
        })
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .map_or((0, 1.0), |(axis, run)| (axis, run.signum()))
}

/// A round length, as long as it is at the pivot.
fn bar(ui: &Ui, view: &SceneView<'_>, frame: &Frame, rect: Rect) {
    let target = view.camera.target;
    let target = glam::DVec3::new(target.x, target.y, target.z).as_vec3();
    // Logical pixels an input unit.
    let scale = view.scene.scale()
        / f64::from(frame.camera.units_per_pixel(target, frame.size_px[1]))
        / f64::from(frame.pixels_per_point);
    if !(scale.is_normal() && scale > 0.0) {
        return;
    }
    let shown = round_up(BAR / scale);
    let width = (shown * scale) as f32;
    let end = rect.right_bottom() + vec2(-14.0, -14.0);
    let start = end - vec2(width, 0.0);
    let color = Palette::of(ui).weak;
    let painter = ui.painter().with_clip_rect(rect);
    let stroke = Stroke::new(1.3, color);
    painter.line_segment([start, end], stroke);
    for x in [start.x, end.x] {
        painter.line_segment([pos2(x, end.y - 4.0), pos2(x, end.y + 1.0)], stroke);
    }
    let text = tick(shown, shown);
    let middle = pos2(0.5 * (start.x + end.x), end.y - 4.0);
    painter.text(middle, Align2::CENTER_BOTTOM, &text, FontId::proportional(11.0), color);
    let around = Rect::from_two_pos(start, end).expand2(Vec2::new(2.0, 16.0));
    let response = ui.interact(around, ui.scope_id().with("scale bar"), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("Scale bar: {text}")));
    response.on_hover_text(format!(
        "This length is {text} in the file's units, at the pivot. One grid cell is {}",
        tick(cell(view), cell(view))
    ));
}

/// A number with as many decimals as its step asks for.
fn tick(value: f64, step: f64) -> String {
    if step < 1e-4 || value.abs() >= 1e6 {
        return figure(value);
    }
    let decimals = (-(step * (1.0 + 1e-9)).log10().floor()).clamp(0.0, 5.0) as usize;
    // The steps 1.5 and 0.15 want one more.
    let decimals = if (value * 10_f64.powi(decimals as i32)).fract().abs() > 1e-6
        && ((value * 10_f64.powi(decimals as i32)).fract().abs() - 1.0).abs() > 1e-6
    {
        decimals + 1
    } else {
        decimals
    };
    // No −0.
    format!("{:.*}", decimals, value + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_decimals_that_they_need() {
        for (value, step, expected) in [
            (0.1, 0.1, "0.1"),
            (0.30000000000000004, 0.1, "0.3"),
            (1.5, 1.5, "1.5"),
            (0.15, 0.15, "0.15"),
            (-0.0, 0.5, "0.0"),
            (200.0, 200.0, "200"),
            (3e-6, 1e-6, "3e-6"),
        ] {
            assert_eq!(tick(value, step), expected);
        }
    }
}
