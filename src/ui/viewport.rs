//! The 3D view: turns a state into a [`Frame`] and GPU uploads, and pointer input into actions.
//! With the files below, the only place that uses both egui and wgpu.

use egui::{Role, Sense, Ui, WidgetInfo};

use super::scene::{Scene, SceneView};
use super::theme::Palette;
use crate::render::Frame;
use crate::session::action::Action;

mod axes;
mod frame;
mod glide;
mod gpu;
mod grip;
mod handles;
mod legend;
mod pointer;
mod ruler;
mod studio;
mod toolbar;

use glide::Glide;
use gpu::Slot;
use grip::Grip;
pub(super) use handles::Handles;
use pointer::Pointer;
pub(super) use studio::{Shot, Studio};
pub(super) use toolbar::show as toolbar;

/// A view with its own uploads, hovered item and selection in progress. Several
/// views can show different states side by side; giving them the same camera
/// links them.
#[derive(Debug)]
pub(super) struct Viewport {
    /// Accessible name, also used in tests.
    name: String,
    /// Whether the session's camera has this view's aspect ratio.
    leads: bool,
    slot: Option<Slot>,
    scene: Scene,
    pointer: Pointer,
    grip: Option<Grip>,
    glide: Glide,
}

impl Viewport {
    /// Builds the pipelines; without a render state there is no picture. One of
    /// the views on screen `leads`: the session's camera takes its form.
    pub(super) fn new(state: Option<&egui_wgpu::RenderState>, name: &str, leads: bool) -> Self {
        Self {
            name: name.to_owned(),
            leads,
            slot: state.map(Slot::new),
            scene: Scene::default(),
            pointer: Pointer::default(),
            grip: None,
            glide: Glide::default(),
        }
    }

    /// One more, beside this one, which keeps the lead.
    pub(super) fn another(&self, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            leads: false,
            slot: self.slot.as_ref().map(Slot::another),
            scene: Scene::default(),
            pointer: Pointer::default(),
            grip: None,
            glide: Glide::default(),
        }
    }

    /// Fills the remaining space.
    pub(super) fn show(&mut self, ui: &mut Ui, view: &SceneView<'_>, actions: &mut Vec<Action>) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &self.name));
        if rect.width() < 2.0 || rect.height() < 2.0 {
            return;
        }
        let aspect = f64::from(rect.width() / rect.height());
        if self.leads && (aspect - view.camera.aspect).abs() > 1e-9 {
            actions.push(Action::SetAspect(aspect));
        }
        self.scene.update(view, self.pointer.hovered(), Some(ui.ctx()));
        let camera = self.glide.camera(ui, view.camera, view.camera_jumps);
        let frame: Frame = frame::of(ui, view, &camera, rect);
        let (handles, is_at_handle) = grip::handle(&mut self.grip, ui, view, &response, &camera, actions);
        self.pointer.advance(view, &response, &frame, &self.scene, is_at_handle, actions);
        match &self.slot {
            Some(slot) => {
                let callback = slot.callback(frame, self.scene.clone());
                ui.painter().add(egui_wgpu::Callback::new_paint_callback(rect, callback));
            }
            None => {
                ui.painter().rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
            }
        }
        if let Some(handles) = &handles {
            handles::paint(ui, rect, handles);
        }
        mark(ui, view, &frame, rect);
        self.pointer.paint(ui, rect);
        if view.loaded.is_some() {
            ruler::show(ui, view, &frame, rect);
        }
        legend::show(ui, &self.scene, view.view, rect, actions);
        axes::show(ui, view, &camera, rect, &self.name, actions);
        if view.loaded.is_none() {
            empty(ui, view, rect);
        }
    }
}

/// A ring around the explained sample.
fn mark(ui: &Ui, view: &SceneView<'_>, frame: &Frame, rect: egui::Rect) {
    let sample = view.marked.and_then(|i| view.loaded?.cloud.points.get(i as usize));
    let Some(p) = sample.map(|p| view.scene.point(p)) else { return };
    let at = frame.camera.project(glam::vec3(p.x as f32, p.y as f32, p.z as f32), frame.size_px);
    let Some(at) = at.map(|at| rect.min + egui::vec2(at.x, at.y) / frame.pixels_per_point) else { return };
    let palette = Palette::of(ui);
    let painter = ui.painter().with_clip_rect(rect);
    // Seen on dark and on light things.
    painter.circle_stroke(at, 8.0, egui::Stroke::new(4.0, palette.overlay));
    painter.circle_stroke(at, 8.0, egui::Stroke::new(2.0, palette.accent));
}

/// The hint in an empty view.
fn empty(ui: &Ui, view: &SceneView<'_>, rect: egui::Rect) {
    let text = if view.is_loading { "Loading…" } else { "Open a shape or drop a file here" };
    let font = egui::FontId::proportional(15.0);
    ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, text, font, Palette::of(ui).weak);
}
