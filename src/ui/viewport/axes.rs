//! The axis gizmo in the upper right corner: clicking a ball looks along its axis, dragging orbits.

use egui::{Align2, Color32, FontId, Pos2, Rect, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2};
use nalgebra::Point3;

use super::pointer::ORBIT_SPEED;
use crate::session::action::Action;
use crate::session::camera::{AxisView, Camera};
use crate::session::verb::Verb;
use crate::ui::scene::SceneView;
use crate::ui::theme::Palette;
use crate::ui::widgets;

/// Logical pixels.
const RADIUS: f32 = 44.0;
const ARM: f32 = 32.0;
const BALL: f32 = 9.0;
/// From the corner to the rim.
const MARGIN: f32 = 8.0;

/// One end of an axis.
struct End {
    axis: usize,
    positive: bool,
    at: Pos2,
    /// Towards the eye.
    nearness: f64,
    view: AxisView,
}

pub(super) fn show(
    ui: &Ui,
    view: &SceneView<'_>,
    camera: &Camera,
    rect: Rect,
    name: &str,
    actions: &mut Vec<Action>,
) {
    let small = rect.width().min(rect.height());
    if small < 2.5 * (RADIUS + MARGIN) {
        return;
    }
    let center = rect.right_top() + vec2(-RADIUS - MARGIN, RADIUS + MARGIN);
    let disc = Rect::from_center_size(center, Vec2::splat(2.0 * RADIUS));
    let id = ui.scope_id().with((name, "axes"));
    let whole = ui.interact(disc, id, Sense::drag());
    let delta = whole.drag_delta();
    if delta != Vec2::ZERO {
        actions.push(orbit(delta));
    }
    let mut ends = ends(view, camera, center);
    // The farthest first.
    ends.sort_by(|a, b| a.nearness.total_cmp(&b.nearness));
    let painter = ui.painter().with_clip_rect(rect);
    let palette = Palette::of(ui);
    let balls: Vec<_> = ends
        .iter()
        .map(|end| {
            let around = Rect::from_center_size(end.at, Vec2::splat(2.0 * BALL + 2.0));
            let ball = ui.interact(around, id.with((end.axis, end.positive)), Sense::click_and_drag());
            let letter = ["x", "y", "z"][end.axis];
            let sign = if end.positive { '+' } else { '−' };
            ball.widget_info(|| {
                WidgetInfo::labeled(Role::Button, true, format!("{name} from {sign}{letter}"))
            });
            if ball.drag_delta() != Vec2::ZERO {
                actions.push(orbit(ball.drag_delta()));
            }
            // Who looks from there already wants the other side.
            let there = if camera.axis_view() == Some(end.view) { end.view.opposite() } else { end.view };
            if ball.clicked() {
                actions.push(Action::Verb(verb(there)));
            }
            ball.on_hover_text(format!("{} of the shape: {sign}{letter}. {}", there_is(there), tip(there)))
        })
        .collect();
    if whole.contains_pointer() || whole.dragged() || balls.iter().any(egui::Response::hovered) {
        painter.circle_filled(center, RADIUS, palette.overlay.gamma_multiply(0.75));
    }
    for (end, ball) in ends.iter().zip(&balls) {
        let color = palette.axes[end.axis];
        // What points away is fainter.
        let faint = 0.55 + 0.45 * (0.5 + 0.5 * end.nearness as f32);
        let is_hot = ball.hovered() || ball.has_focus();
        let letter = ["X", "Y", "Z"][end.axis];
        let ink = if is_hot { palette.on_axis_hot } else { palette.on_axis };
        let font = FontId::proportional(11.5);
        if end.positive {
            painter.line_segment([center, end.at], Stroke::new(2.0, color.gamma_multiply(faint)));
            painter.circle_filled(end.at, BALL, mix(palette.overlay, color, faint));
            painter.text(end.at, Align2::CENTER_CENTER, letter, font, ink);
        } else {
            let fill = mix(palette.overlay, color, 0.28 * faint);
            painter.circle(end.at, BALL - 1.5, fill, Stroke::new(1.2, color.gamma_multiply(faint)));
            if is_hot {
                painter.text(end.at, Align2::CENTER_CENTER, format!("−{letter}"), font, palette.on_axis_hot);
            }
        }
        if is_hot {
            painter.circle_stroke(end.at, BALL + 1.0, Stroke::new(1.5, palette.on_axis_hot));
        }
    }
}

fn ends(view: &SceneView<'_>, camera: &Camera, center: Pos2) -> Vec<End> {
    let zero = view.scene.point(&Point3::origin());
    let (right, up, forward) = (camera.right(), camera.up(), camera.forward());
    let end = |(axis, positive): (usize, bool)| {
        let mut along = Point3::origin();
        along[axis] = if positive { 1.0 } else { -1.0 } / view.scene.scale();
        let v = view.scene.point(&along) - zero;
        let on_screen = vec2(v.dot(&right) as f32, -v.dot(&up) as f32);
        let nearest =
            |a: &AxisView, b: &AxisView| v.dot(&a.towards_eye()).total_cmp(&v.dot(&b.towards_eye()));
        let view = AxisView::ALL.into_iter().max_by(nearest).unwrap_or(AxisView::Front);
        End { axis, positive, at: center + ARM * on_screen, nearness: -v.dot(&forward), view }
    };
    (0..3).flat_map(|axis| [(axis, true), (axis, false)]).map(end).collect()
}

fn orbit(delta: Vec2) -> Action {
    Action::Orbit { right: f64::from(delta.x) * ORBIT_SPEED, up: f64::from(-delta.y) * ORBIT_SPEED }
}

fn verb(view: AxisView) -> Verb {
    match view {
        AxisView::Front => Verb::ViewFront,
        AxisView::Back => Verb::ViewBack,
        AxisView::Right => Verb::ViewRight,
        AxisView::Left => Verb::ViewLeft,
        AxisView::Top => Verb::ViewTop,
        AxisView::Bottom => Verb::ViewBottom,
    }
}

fn there_is(view: AxisView) -> &'static str {
    verb(view).entry().text
}

fn tip(view: AxisView) -> String {
    widgets::tooltip(verb(view))
}

fn mix(from: Color32, to: Color32, share: f32) -> Color32 {
    from.lerp_to_gamma(to, share)
}
