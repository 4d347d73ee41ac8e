//! The right panel: layers, the list of primitives, the selected one's θ.

use egui::{
    Align2, Button, FontId, Grid, Label, RichText, Role, ScrollArea, Sense, Slider, Ui, WidgetInfo, pos2,
    vec2,
};

use super::theme::{self, Palette};
use super::widgets::{choice, count, divide, eye, focus_ring, follow_focus, length, section};
use crate::inference::Primitive;
use crate::io::ShapeGeometry;
use crate::session::Session;
use crate::session::action::{Action, Verb};
use crate::session::scene::UpAxis;
use crate::session::view::{Layer, SurfaceStyle, View};

/// Height that the numbers of the selected primitive take.
const INSPECTOR: f32 = 214.0;

/// `height` is that of the panel: the list takes what is left of it.
pub(super) fn show(ui: &mut Ui, session: &Session, height: f32, actions: &mut Vec<Action>) {
    let bottom = ui.cursor().top() + height;
    layers(ui, session, actions);
    divide(ui);
    let primitives = session.primitives();
    ui.horizontal(|ui| {
        ui.label(RichText::new("Primitives").strong());
        ui.label(RichText::new(count(primitives.len())).color(Palette::of(ui).weak));
        if !session.hidden.is_empty() {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let entry = Verb::ShowAll.entry();
                if ui.add(Button::new("Show all").small()).on_hover_text(entry.tooltip).clicked() {
                    actions.push(Action::Verb(Verb::ShowAll));
                }
            });
        }
    });
    if primitives.is_empty() {
        let text = if session.loaded.is_some() {
            "None in this state"
        } else {
            "Open a shape to see its primitives"
        };
        ui.add(Label::new(RichText::new(text).color(Palette::of(ui).weak)).wrap());
        return;
    }
    let selected = session.selected_primitive();
    let reserved = if selected.is_some() { INSPECTOR } else { 0.0 };
    header(ui);
    // Largest first: what a person looks for are the large parts.
    let mut order: Vec<&Primitive> = primitives.iter().collect();
    order.sort_by_key(|p| (std::cmp::Reverse(p.points), p.id));
    ScrollArea::vertical()
        .auto_shrink([false, true])
        .max_height((bottom - ui.cursor().top() - reserved).max(4.0 * theme::ROW))
        .show_rows(ui, theme::ROW, order.len(), |ui, rows| {
            for primitive in &order[rows] {
                row(ui, session, primitive, actions);
            }
            follow_focus(ui);
        });
    if let Some(primitive) = selected {
        divide(ui);
        inspector(ui, primitive);
    }
}

fn layers(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    section(ui, "Layers");
    let has_mesh =
        session.loaded.as_ref().is_some_and(|l| matches!(l.shape.geometry, ShapeGeometry::Mesh(_)));
    let width = (ui.available_width() - ui.spacing().item_spacing.x) / 2.0;
    for pair in Layer::ALL.chunks(2) {
        ui.horizontal(|ui| {
            for &layer in pair {
                let cell = vec2(width, theme::ROW);
                let layout = egui::Layout::left_to_right(egui::Align::Center);
                ui.allocate_ui_with_layout(cell, layout, |ui| {
                    ui.set_min_size(cell);
                    ui.add_enabled_ui(layer != Layer::Input || has_mesh, |ui| {
                        let shown = session.view.shows(layer);
                        let toggled = eye(ui, shown, layer.text()).clicked();
                        ui.label(layer.text());
                        if toggled {
                            actions.push(Action::SetLayer(layer, !shown));
                        }
                    });
                });
            }
        });
    }
    ui.add_space(2.0);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        let width = (ui.available_width() - 6.0) / 3.0;
        for style in SurfaceStyle::ALL {
            if choice(ui, session.view.surface_style == style, style.text(), width)
                .on_hover_text("How primitives are drawn")
                .clicked()
            {
                actions.push(Action::SetSurfaceStyle(style));
            }
        }
    });
    ui.horizontal(|ui| {
        let label = ui.label(RichText::new("Point size").color(Palette::of(ui).weak)).id;
        let mut size = session.view.point_size;
        ui.spacing_mut().slider_width = (ui.available_width() - 4.0).max(40.0);
        let (low, high) = View::POINT_SIZE;
        let slider = Slider::new(&mut size, low..=high).show_value(false);
        if ui.add(slider).labelled_by(label).on_hover_text("Diameter of a point in pixels").changed() {
            actions.push(Action::SetPointSize(size));
        }
    });
    let mut z_up = session.view.up == UpAxis::Z;
    if ui.checkbox(&mut z_up, "Z is up").on_hover_text("Otherwise y is up, as in most mesh files").clicked() {
        actions.push(Action::SetUpAxis(if z_up { UpAxis::Z } else { UpAxis::Y }));
    }
}

/// Right edges of the columns, from the panel's right edge.
const ERROR_COLUMN: f32 = 30.0;
const POINTS_COLUMN: f32 = 92.0;

fn header(ui: &mut Ui) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 16.0), Sense::hover());
    let color = Palette::of(ui).weak;
    let text = |x: f32, align: Align2, text: &str| {
        ui.painter().text(pos2(x, rect.center().y), align, text, FontId::proportional(11.0), color);
    };
    text(rect.left() + 26.0, Align2::LEFT_CENTER, "Id");
    text(rect.right() - POINTS_COLUMN, Align2::RIGHT_CENTER, "Points");
    text(rect.right() - ERROR_COLUMN, Align2::RIGHT_CENTER, "Mean error");
}

fn row(ui: &mut Ui, session: &Session, primitive: &Primitive, actions: &mut Vec<Action>) {
    let id = primitive.id;
    let selected = session.selection.contains(&id);
    let visible = !session.hidden.contains(&id);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, selected, format!("Primitive {id}")));
    let visuals = ui.visuals();
    if selected {
        ui.painter().rect_filled(rect, 3.0, visuals.selection.bg_fill);
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 3.0, visuals.faint_bg_color);
    }
    focus_ring(ui, &response);
    let strength = if visible { 1.0 } else { 0.4 };
    let color = theme::data_color(session.color_of(id)).gamma_multiply(strength);
    let swatch = egui::Rect::from_center_size(pos2(rect.left() + 12.0, rect.center().y), vec2(12.0, 12.0));
    ui.painter().rect_filled(swatch, 3.0, color);
    let text_color = visuals.text_color().gamma_multiply(strength);
    let text = |x: f32, align: Align2, text: String| {
        ui.painter().text(pos2(x, rect.center().y), align, text, FontId::proportional(13.0), text_color);
    };
    text(rect.left() + 26.0, Align2::LEFT_CENTER, id.to_string());
    text(rect.right() - POINTS_COLUMN, Align2::RIGHT_CENTER, count(primitive.points));
    text(rect.right() - ERROR_COLUMN, Align2::RIGHT_CENTER, length(primitive.mean_distance));

    let eye_rect = egui::Rect::from_min_size(
        pos2(rect.right() - theme::ROW - 2.0, rect.top()),
        vec2(theme::ROW, theme::ROW),
    );
    let toggled = ui
        .scope_builder(egui::UiBuilder::new().max_rect(eye_rect), |ui| {
            eye(ui, visible, &format!("Primitive {id} in the viewport")).clicked()
        })
        .inner;
    if toggled {
        actions.push(Action::SetPrimitiveVisible(id, !visible));
    } else if response.double_clicked() {
        actions.push(Action::Select(Some(id)));
        actions.push(Action::Verb(Verb::FrameSelection));
    } else if response.clicked() {
        actions.push(if ui.input(|i| i.modifiers.shift || i.modifiers.command) {
            Action::ToggleSelected(id)
        } else if selected && session.selection.len() == 1 {
            Action::Select(None)
        } else {
            Action::Select(Some(id))
        });
    }
}

fn inspector(ui: &mut Ui, primitive: &Primitive) {
    section(ui, &format!("Primitive {}", primitive.id));
    let shape = &primitive.shape;
    let weak = Palette::of(ui).weak;
    let (roll, pitch, yaw) = shape.rotation.euler_angles();
    let t = shape.translation;
    let number = |v: f64| if v.is_finite() { format!("{v:.3}") } else { "–".to_owned() };
    let degrees = |v: f64| if v.is_finite() { format!("{:.1}°", v.to_degrees()) } else { "–".to_owned() };
    let rows: [(&str, &str, Vec<String>); 6] = [
        (
            "Exponents ε",
            "ε1 from pole to pole, ε2 around the equator: near 0 a box, 1 an ellipsoid, 2 an octahedron",
            shape.exponents.iter().map(|v| number(*v)).collect(),
        ),
        (
            "Semi-axes a",
            "ax, ay, az in the file's units",
            shape.semi_axes.iter().map(|v| length(*v)).collect(),
        ),
        ("Centre t", "x, y, z in the file's units", t.iter().map(|v| length(*v)).collect()),
        (
            "Rotation R",
            "Turns about x, then y, then z that bring the primitive into place",
            [roll, pitch, yaw].iter().map(|v| degrees(*v)).collect(),
        ),
        (
            "Taper k",
            "kx, ky along the primitive's z axis: 0 for none, ±1 to a point",
            shape.taper.iter().map(|v| number(*v)).collect(),
        ),
        (
            "Noise σ",
            "Standard deviation of the points' radial distances, in the file's units",
            vec![length(primitive.sigma)],
        ),
    ];
    Grid::new("theta").num_columns(4).min_col_width(48.0).spacing(vec2(8.0, 5.0)).show(ui, |ui| {
        for (label, tooltip, values) in rows {
            ui.label(RichText::new(label).color(weak)).on_hover_text(tooltip);
            for value in values {
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(value).on_hover_text(tooltip);
                });
            }
            ui.end_row();
        }
    });
}
