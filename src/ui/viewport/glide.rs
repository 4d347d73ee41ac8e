//! Smooth camera transitions.

use egui::Ui;

use crate::session::camera::Camera;

/// How long a jump takes.
const SECONDS: f64 = 0.15;

/// What a view shows while the session's camera is elsewhere already.
#[derive(Debug, Default)]
pub(super) struct Glide {
    jumps: u64,
    shown: Option<Camera>,
    /// Where the camera came from, and when.
    from: Option<(Camera, f64)>,
}

impl Glide {
    /// The camera to draw with now. A jump is eased, but not the first, none
    /// that changes the projection, and none where animations are switched off.
    pub(super) fn camera(&mut self, ui: &Ui, camera: &Camera, jumps: u64) -> Camera {
        let now = ui.input(|i| i.time);
        if jumps != self.jumps {
            self.jumps = jumps;
            let is_animated = ui.style().animation_time > 0.0;
            let from = self.shown.filter(|shown| {
                is_animated && *shown != *camera && shown.orthographic == camera.orthographic
            });
            self.from = from.map(|from| (from, now));
        }
        let mut shown = *camera;
        if let Some((from, since)) = self.from {
            let share = (now - since) / SECONDS;
            if share < 1.0 {
                shown = from.towards(camera, ease(share.max(0.0)));
                ui.ctx().request_repaint();
            } else {
                self.from = None;
            }
        }
        self.shown = Some(shown);
        shown
    }
}

/// From 0 to 1, slowly at both ends.
fn ease(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}
