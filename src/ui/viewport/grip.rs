//! Dragging the handles of the selected primitive, with the current value as text.

use egui::{Align2, FontId, Key, PointerButton, Pos2, Rect, Response, Ui, vec2};
use nalgebra::Vector2;

use super::Handles;
use crate::geometry::Superquadric;
use crate::session::action::Action;
use crate::session::camera::Camera;
use crate::session::gizmo::{Gizmo, Handle, angle_between};
use crate::session::shaping::{ShapeDraft, round_step, snapped};
use crate::ui::scene::SceneView;
use crate::ui::theme::Palette;
use crate::ui::widgets::length;

/// A handle being dragged.
#[derive(Debug)]
pub(super) struct Grip {
    id: u32,
    handle: Handle,
    /// Where the drag started, in logical pixels of the view.
    from: Vector2<f64>,
    /// The primitive at that time.
    gizmo: Gizmo,
    /// Escape has restored the shape; the button is still down.
    is_given_up: bool,
}

/// Lets the pointer drag handles. Returns what to draw, and whether the
/// pointer is used by a handle.
pub(super) fn handle(
    grip: &mut Option<Grip>,
    ui: &Ui,
    view: &SceneView<'_>,
    response: &Response,
    camera: &Camera,
    actions: &mut Vec<Action>,
) -> (Option<Handles>, bool) {
    let rect = response.rect;
    let pixel = |p: Pos2| Vector2::new(f64::from(p.x - rect.min.x), f64::from(p.y - rect.min.y));
    let Some((id, shape, mode)) = view.handled() else {
        // Until the button is let go nothing else begins to move.
        let is_held = grip.is_some() && response.dragged_by(PointerButton::Primary);
        grip.take_if(|_| !is_held);
        return (None, is_held);
    };
    let size = Vector2::new(f64::from(rect.width()), f64::from(rect.height()));
    let gizmo = Gizmo::new(view.scene.shape(shape), mode, camera, size);
    let (pressed_at, pointer, snaps, gives_up, alt) = ui.input(|i| {
        let pointer = &i.pointer;
        let keys = i.modifiers;
        (pointer.press_origin(), pointer.latest_pos(), keys.command, i.key_pressed(Key::Escape), keys.alt)
    });
    if grip.is_none()
        && !alt
        && response.drag_started_by(PointerButton::Primary)
        && let Some(from) = pressed_at.map(pixel)
        && let Some(handle) = gizmo.hit(from)
    {
        *grip = Some(Grip { id, handle, from, gizmo, is_given_up: false });
    }
    if let Some(held) = grip {
        held.is_given_up |= gives_up || held.id != id;
        if let (false, Some(pointer)) = (held.is_given_up, pointer) {
            let start = view.scene.shape_in_input(&held.gizmo.shape);
            let mut shape =
                view.scene.shape_in_input(&held.gizmo.drag(held.handle, held.from, pixel(pointer)));
            if snaps {
                shape = snapped(held.handle, &start, &shape, round_step(1.0 / view.scene.scale()));
            }
            if response.drag_delta() != egui::Vec2::ZERO || view.draft.is_some() {
                actions.push(Action::DraftShape(ShapeDraft { id, shape, angles: None }));
            }
            tell(ui, rect, pointer, &reading(held.handle, &start, &shape));
        }
        let handles = Handles { gizmo, lit: (!held.is_given_up).then_some(held.handle) };
        if !response.dragged_by(PointerButton::Primary) {
            *grip = None;
        }
        return (Some(handles), true);
    }
    let is_busy = response.dragged() || alt;
    let lit = response.hover_pos().filter(|_| !is_busy).and_then(|p| gizmo.hit(pixel(p)));
    if let Some(handle) = lit {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
        response.clone().on_hover_text_at_pointer(handle.text());
    }
    (Some(Handles { gizmo, lit }), lit.is_some())
}

/// Value of a drag as text.
fn reading(handle: Handle, start: &Superquadric, now: &Superquadric) -> String {
    match handle {
        Handle::MoveAxis(_) | Handle::MovePlane(_) | Handle::MoveFree => {
            let step = now.translation - start.translation;
            format!("moved by {}", length(step.norm()))
        }
        Handle::RotateAxis(_) | Handle::RotateView => {
            format!("rotated by {:.1}°", angle_between(&start.rotation, &now.rotation).to_degrees())
        }
        Handle::ScaleAxis(axis) => format!("a{} {}", ["x", "y", "z"][axis], length(now.semi_axes[axis])),
        Handle::ScaleUniform => format!("× {:.3}", now.semi_axes.x / start.semi_axes.x),
        Handle::Taper(which) => format!("k{} {:.3}", ["x", "y"][which], now.taper[which]),
        Handle::Exponent(which) => format!("ε{} {:.3}", which + 1, now.exponents[which]),
    }
}

/// Text next to the pointer.
fn tell(ui: &Ui, rect: Rect, pointer: Pos2, text: &str) {
    let palette = Palette::of(ui);
    let painter = ui.ctx().layer_painter(egui::LayerId::new(
        egui::Order::Tooltip,
        egui::Id::unique("what a handle has come to"),
    ));
    let color = ui.visuals().strong_text_color();
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(13.0), color);
    let size = galley.size() + vec2(14.0, 8.0);
    let at = Align2::LEFT_BOTTOM.anchor_size(pointer + vec2(16.0, -12.0), size);
    // Within the view.
    let shift = vec2((rect.right() - 4.0 - at.right()).min(0.0), (rect.top() + 4.0 - at.top()).max(0.0));
    let at = at.translate(shift);
    painter.rect_filled(at, 4.0, palette.overlay.gamma_multiply(0.92));
    painter.galley(at.min + vec2(7.0, 4.0), galley, color);
}
