//! What is shown as a whole, and how.

use egui::{RichText, Slider, Ui, vec2};

use crate::io::ShapeGeometry;
use crate::session::Session;
use crate::session::action::Action;
use crate::session::scene::UpAxis;
use crate::session::view::{Layer, SurfaceStyle, View};
use crate::ui::theme::{self, Palette};
use crate::ui::widgets::{choice, eye, section};

pub(super) fn show(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
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
            if choice(ui, session.view.surface_style == style, style.text(), width) {
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
