//! Everything except the data that determines how a view is rendered.

use egui::Ui;

use crate::pictures::frame;
use crate::render::{Frame, SceneTheme};
use crate::session::camera::Camera;
use crate::ui::scene::SceneView;
use crate::ui::theme;

/// The frame of a view on screen.
pub(super) fn of(ui: &Ui, view: &SceneView<'_>, camera: &Camera, rect: egui::Rect) -> Frame {
    let pixels_per_point = ui.ctx().pixels_per_point();
    // As egui rounds the viewport of a paint callback.
    let pixels = |from: f32, to: f32| {
        ((to * pixels_per_point).round() - (from * pixels_per_point).round()).max(0.0) as u32
    };
    let size_px = [pixels(rect.min.x, rect.max.x), pixels(rect.min.y, rect.max.y)];
    sized(view, camera, size_px, pixels_per_point, theme::scene(ui))
}

/// The frame of a picture of any size.
pub(super) fn sized(
    view: &SceneView<'_>,
    camera: &Camera,
    size_px: [u32; 2],
    pixels_per_point: f32,
    theme: SceneTheme,
) -> Frame {
    let mut frame = frame::sized(view.view, view.scene, camera, size_px, pixels_per_point, theme);
    frame.layers.grid &= view.loaded.is_some();
    frame
}

/// Length of a cell of the grid, in input units.
pub(super) fn cell(view: &SceneView<'_>) -> f64 {
    frame::cell(view.scene)
}
