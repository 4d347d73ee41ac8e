//! The toolbar along the viewport's upper edge: tools, selection mode, colours, surface style and
//! visible layers.

use egui::{
    Button, Color32, ComboBox, Painter, Pos2, Rect, Role, Sense, Shape, Slider, Stroke, Ui, WidgetInfo, pos2,
    vec2,
};

use crate::io::ShapeGeometry;
use crate::session::Session;
use crate::session::action::Action;
use crate::session::verb::Verb;
use crate::session::view::{ColorBy, Layer, Picks, SurfaceStyle, View};
use crate::ui::theme::{self, Palette};
use crate::ui::widgets::{menu, menu_item, tooltip};

/// Logical pixels.
const ICON: f32 = 26.0;

type Draw = fn(&Painter, Pos2, Color32);

pub(in crate::ui) fn show(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let fill = ui.visuals().panel_fill;
    let margin = egui::Margin::symmetric(8, 3);
    egui::Frame::new().fill(fill).inner_margin(margin).show(ui, |ui| {
        ui.set_min_width(ui.available_width());
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = vec2(2.0, 3.0);
            for (verb, draw) in
                [(Verb::ToolClick, arrow as Draw), (Verb::ToolBox, dashed_box), (Verb::ToolLasso, loop_line)]
            {
                let on = session.is_on(verb) == Some(true);
                if icon(ui, on, verb.entry().text, &tooltip(verb), draw) {
                    actions.push(Action::Verb(verb));
                }
            }
            ui.add_space(8.0);
            let keys = Verb::TogglePicks.entry().shortcut.map_or_else(String::new, |s| format!(" ({s})"));
            for (picks, draw, label, text) in [
                (Picks::Primitives, ball as Draw, "Select primitives", "Select whole primitives"),
                (Picks::Points, dots, "Select points", "Select single points"),
            ] {
                let on = session.view.picks == picks;
                if icon(ui, on, label, &format!("{text}{keys}"), draw) && !on {
                    actions.push(Action::Verb(Verb::TogglePicks));
                }
            }
            ui.add_space(8.0);
            color_by(ui, session, actions);
            ui.add_space(4.0);
            surface_style(ui, session, actions);
            ui.add_space(4.0);
            shown(ui, session, actions);
        });
    });
}

fn color_by(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let present = session.view.color_by;
    let has_colors = session.loaded.as_ref().is_some_and(|loaded| {
        let shape = &loaded.shape;
        matches!(shape.geometry, ShapeGeometry::Cloud(_)) && shape.attributes.colors.is_some()
    });
    let combo =
        ComboBox::from_id_salt("colour by").selected_text(present.text()).width(100.0).show_ui(ui, |ui| {
            for by in ColorBy::ALL {
                let is_there = by != ColorBy::Input || has_colors;
                let item = ui.add_enabled(is_there, Button::selectable(by == present, by.text()));
                let item =
                    item.on_hover_text(by.tooltip()).on_disabled_hover_text("The file contains no colours");
                if item.clicked() {
                    actions.push(Action::SetColorBy(by));
                }
            }
        });
    combo
        .response
        .accessible_name("Colour by")
        .on_hover_text(format!("Points: {}", lower(present.tooltip())));
}

fn surface_style(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let present = session.view.surface_style;
    let combo =
        ComboBox::from_id_salt("surface style").selected_text(present.text()).width(84.0).show_ui(ui, |ui| {
            for style in SurfaceStyle::ALL {
                if ui.selectable_label(style == present, style.text()).clicked() {
                    actions.push(Action::SetSurfaceStyle(style));
                }
            }
        });
    combo.response.accessible_name("Surface style").on_hover_text("How primitive surfaces are drawn");
}

/// What is shown at all.
fn shown(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    // Room for the mark that a menu opens.
    let shown = menu(ui, "Show    ", |ui| {
        for layer in Layer::ALL {
            let mut on = session.view.shows(layer);
            if ui.checkbox(&mut on, layer.text()).clicked() {
                actions.push(Action::SetLayer(layer, on));
            }
        }
        ui.separator();
        ui.horizontal(|ui| {
            let label = ui.label("Point size").id;
            let mut size = session.view.point_size;
            let (low, high) = View::POINT_SIZE;
            ui.spacing_mut().slider_width = 90.0;
            let slider = Slider::new(&mut size, low..=high).show_value(false);
            let slider = ui.add(slider).labelled_by(label);
            if slider.on_hover_text("Point diameter in pixels").changed() {
                actions.push(Action::SetPointSize(size));
            }
        });
        let mut visible_only = session.view.visible_only;
        let only = ui.checkbox(&mut visible_only, "Select only visible items");
        if only.on_hover_text("Box and lasso selection ignore what is hidden behind something else").clicked()
        {
            actions.push(Action::SetVisibleOnly(visible_only));
        }
        ui.separator();
        menu_item(ui, session, Verb::ToggleOrthographic, actions);
        menu_item(ui, session, Verb::ShowAll, actions);
    });
    let mark = shown.response.rect.right_center() - vec2(13.0, 0.0);
    let color = ui.style().interact(&shown.response).text_color();
    let triangle = vec![mark + vec2(-4.5, -2.5), mark + vec2(4.5, -2.5), mark + vec2(0.0, 4.0)];
    ui.painter().add(Shape::convex_polygon(triangle, color, Stroke::NONE));
    shown.response.accessible_name("Show").on_hover_text("Visible layers and point size");
}

fn lower(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// A button with a picture; whether it was clicked.
fn icon(ui: &mut Ui, on: bool, label: &str, tooltip: &str, draw: Draw) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ICON, theme::ROW), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, on, label));
    if ui.is_rect_visible(rect) {
        let visuals = ui.style().interact_selectable(&response, on);
        if on || response.hovered() || response.has_focus() {
            ui.painter().rect_filled(rect, visuals.corner_radius, visuals.weak_bg_fill);
        }
        let color = if on { Palette::of(ui).accent } else { visuals.text_color() };
        draw(ui.painter(), rect.center(), color);
    }
    response.on_hover_text(tooltip).clicked()
}

fn arrow(painter: &Painter, c: Pos2, color: Color32) {
    let at = |x: f32, y: f32| c + vec2(x, y);
    let head = vec![at(-4.0, -6.5), at(5.0, 1.6), at(1.0, 2.0), at(-4.0, 5.8)];
    painter.add(Shape::convex_polygon(head, color, Stroke::NONE));
    painter.line_segment([at(0.6, 1.4), at(3.2, 6.4)], Stroke::new(2.0, color));
}

fn dashed_box(painter: &Painter, c: Pos2, color: Color32) {
    let r = Rect::from_center_size(c, vec2(14.0, 11.0));
    let line = [r.left_top(), r.right_top(), r.right_bottom(), r.left_bottom(), r.left_top()];
    painter.extend(Shape::dashed_line(&line, Stroke::new(1.5, color), 3.0, 2.4));
}

fn loop_line(painter: &Painter, c: Pos2, color: Color32) {
    let line: Vec<Pos2> = (0..=28)
        .map(|i| {
            let a = i as f32 / 28.0 * std::f32::consts::TAU;
            c + vec2(7.2 * a.cos(), 4.4 * a.sin() - 1.2)
        })
        .collect();
    painter.extend(Shape::dashed_line(&line, Stroke::new(1.5, color), 3.4, 2.2));
    painter.line_segment([c + vec2(-4.4, 2.3), c + vec2(-6.2, 6.6)], Stroke::new(1.5, color));
}

fn ball(painter: &Painter, c: Pos2, color: Color32) {
    painter.circle_stroke(c, 6.0, Stroke::new(1.4, color));
    let arc = |sx: f32, sy: f32| -> Vec<Pos2> {
        (0..=12)
            .map(|i| {
                let a = i as f32 / 12.0 * std::f32::consts::PI;
                c + vec2(6.0 * a.cos() * sx, 6.0 * a.sin() * sy)
            })
            .collect()
    };
    painter.line(arc(1.0, 0.36), Stroke::new(1.1, color));
    let upright = arc(1.0, 0.36).into_iter().map(|p| c + (p - c).rot90()).collect::<Vec<_>>();
    painter.line(upright, Stroke::new(1.1, color));
}

fn dots(painter: &Painter, c: Pos2, color: Color32) {
    for (x, y) in [(-5.0, -3.5), (0.5, -5.0), (5.0, -1.0), (-2.2, 1.0), (2.2, 4.6), (-5.6, 4.8)] {
        painter.circle_filled(pos2(c.x + x, c.y + y), 1.6, color);
    }
}
