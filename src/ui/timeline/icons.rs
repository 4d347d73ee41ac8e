//! Icons of the playback controls, drawn because fonts differ.

use egui::{Color32, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};

use crate::session::Session;
use crate::session::action::Action;
use crate::session::verb::Verb;
use crate::ui::theme;
use crate::ui::widgets::with_reason;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Icon {
    First,
    Previous,
    Play,
    Stop,
    Next,
    Last,
    Loop,
    More,
}

/// A button with a sign that does the verb; lit while what it switches is on.
pub(super) fn verb_icon(ui: &mut Ui, session: &Session, verb: Verb, icon: Icon, actions: &mut Vec<Action>) {
    let on = session.is_on(verb);
    let enabled = session.is_enabled(verb);
    let response = ui.add_enabled_ui(enabled, |ui| button(ui, icon, verb.entry().text, on)).inner;
    let text = with_reason(session, verb);
    if response.on_hover_text(&text).on_disabled_hover_text(&text).clicked() {
        actions.push(Action::Verb(verb));
    }
}

/// A square button that is named `label`; `on` where it is a switch.
pub(super) fn button(ui: &mut Ui, icon: Icon, label: &str, on: Option<bool>) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(theme::ROW + 2.0, theme::ROW), Sense::click());
    let enabled = ui.is_enabled();
    response.widget_info(|| match on {
        Some(on) => WidgetInfo::selected(Role::Button, enabled, on, label),
        None => WidgetInfo::labeled(Role::Button, enabled, label),
    });
    if ui.is_rect_visible(rect) {
        let style = ui.style().interact_selectable(&response, on == Some(true));
        if response.hovered() || response.has_focus() || on == Some(true) {
            ui.painter().rect(
                rect,
                style.corner_radius,
                style.weak_bg_fill,
                style.bg_stroke,
                egui::StrokeKind::Inside,
            );
        }
        paint(ui.painter(), rect, icon, style.fg_stroke.color);
    }
    response
}

fn paint(painter: &Painter, rect: Rect, icon: Icon, color: Color32) {
    let c = rect.center();
    let r = 4.5;
    let triangle = |at: Pos2, to: f32| {
        let points = vec![
            pos2(at.x - to * 3.2, at.y - r),
            pos2(at.x + to * 3.8, at.y),
            pos2(at.x - to * 3.2, at.y + r),
        ];
        painter.add(Shape::convex_polygon(points, color, Stroke::NONE));
    };
    let bar = |x: f32, width: f32| {
        painter.rect_filled(Rect::from_center_size(pos2(x, c.y), vec2(width, 2.0 * r)), 0.5, color);
    };
    match icon {
        Icon::First => {
            bar(c.x - 5.0, 1.8);
            triangle(c + vec2(1.5, 0.0), -1.0);
        }
        Icon::Last => {
            triangle(c - vec2(1.5, 0.0), 1.0);
            bar(c.x + 5.0, 1.8);
        }
        Icon::Previous => triangle(c, -1.0),
        Icon::Next => triangle(c, 1.0),
        Icon::Play => {
            let points = vec![c + vec2(-4.0, -6.0), c + vec2(6.0, 0.0), c + vec2(-4.0, 6.0)];
            painter.add(Shape::convex_polygon(points, color, Stroke::NONE));
        }
        Icon::Stop => {
            bar(c.x - 3.0, 2.8);
            bar(c.x + 3.0, 2.8);
        }
        Icon::Loop => {
            // Most of a circle with a tip.
            let arc: Vec<Pos2> = (0..=20)
                .map(|i| {
                    let t = -0.6 + 5.2 * i as f32 / 20.0;
                    c + 5.0 * vec2(t.cos(), t.sin())
                })
                .collect();
            let tip = arc[0];
            painter.line(arc, Stroke::new(1.5, color));
            let points = vec![tip + vec2(-4.4, 0.2), tip + vec2(1.6, -3.8), tip + vec2(1.4, 2.4)];
            painter.add(Shape::convex_polygon(points, color, Stroke::NONE));
        }
        Icon::More => {
            for dx in [-4.0, 0.0, 4.0] {
                painter.circle_filled(c + vec2(dx, 0.0), 1.3, color);
            }
        }
    }
}
