//! Pointer input in a view: orbit, pan, zoom, hover, and the selection tools.

use egui::{Context, CursorIcon, PointerButton, Pos2, Rect, Response, Shape, Stroke, Ui, pos2};
use nalgebra::{Point3, Vector2};

use crate::geometry::Bulk;
use crate::inference::UNASSIGNED;
use crate::render::region::{points_within, primitives_within};
use crate::render::{Frame, Pick, PickId, Region, picking};
use crate::session::action::Action;
use crate::session::paint::sample_of_shown;
use crate::session::selection::Select;
use crate::session::verb::Verb;
use crate::session::view::{Picks, Tool};
use crate::ui::scene::{Scene, SceneView};
use crate::ui::theme::Palette;
use crate::ui::widgets::{count, length};

/// Radians per logical pixel of dragging.
pub(super) const ORBIT_SPEED: f64 = 0.008;
/// Zoom per logical pixel of scrolling.
const ZOOM_SPEED: f64 = 0.0022;
/// Logical pixels from corner to corner of a lasso.
const LASSO_STEP: f32 = 2.0;

/// A selection in progress, in logical pixels of the window.
#[derive(Debug)]
struct Drawn {
    tool: Tool,
    /// Of a box the corner that it began at.
    path: Vec<Pos2>,
    /// Where the pointer is.
    tip: Pos2,
}

impl Drawn {
    fn region(&self, rect: Rect, scale: f32) -> Region {
        let pixel = |p: &Pos2| {
            let p = (*p - rect.min) * scale;
            glam::vec2(p.x, p.y)
        };
        match self.tool {
            Tool::Lasso => Region::Lasso(self.path.iter().chain([&self.tip]).map(pixel).collect()),
            Tool::Box | Tool::Click => Region::Box(pixel(&self.path[0]), pixel(&self.tip)),
        }
    }
}

/// The primitive under the pointer, by id, and the selection in progress.
#[derive(Debug, Default)]
pub(super) struct Pointer {
    hovered: Option<u32>,
    drawn: Option<Drawn>,
}

impl Pointer {
    pub(super) fn hovered(&self) -> Option<u32> {
        self.hovered
    }

    /// Handles the pointer, except for handles.
    pub(super) fn advance(
        &mut self,
        view: &SceneView<'_>,
        response: &Response,
        frame: &Frame,
        scene: &Scene,
        is_at_handle: bool,
        actions: &mut Vec<Action>,
    ) {
        if !is_at_handle || self.drawn.is_some() {
            self.draw_around(view, response, frame, scene, actions);
        }
        let (ctx, rect) = (&response.ctx, response.rect);
        let delta = response.drag_delta();
        if delta != egui::Vec2::ZERO {
            let pans =
                response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle);
            let orbits = self.drawn.is_none() && !is_at_handle;
            if response.dragged_by(PointerButton::Primary) && orbits {
                let (right, up) = (f64::from(delta.x) * ORBIT_SPEED, f64::from(-delta.y) * ORBIT_SPEED);
                actions.push(Action::Orbit { right, up });
            } else if pans {
                let offset = 2.0 * delta / rect.size();
                actions.push(Action::Pan(Vector2::new(f64::from(offset.x), f64::from(-offset.y))));
            }
        }
        let Some(pointer) = response.hover_pos() else {
            self.set_hovered(ctx, None);
            return;
        };
        if view.view.tool != Tool::Click {
            ctx.set_cursor_icon(CursorIcon::Crosshair);
        }
        let offset = 2.0 * (pointer - rect.center()) / rect.size();
        let cursor = Vector2::new(f64::from(offset.x), f64::from(-offset.y));
        let (scroll, pinch) = ctx.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        if scroll != 0.0 || pinch != 1.0 {
            let factor = (-f64::from(scroll) * ZOOM_SPEED).exp() / f64::from(pinch.max(0.1));
            actions.push(Action::Zoom { cursor, factor });
        }
        if is_at_handle {
            self.set_hovered(ctx, None);
            return;
        }
        let wants_pick = response.clicked() || response.double_clicked();
        if !wants_pick && (response.dragged() || !scene.is_quick_to_pick()) {
            self.set_hovered(ctx, None);
            return;
        }
        let pixel = (pointer - rect.min) * frame.pixels_per_point;
        let pick = picking::pick(&scene.pickable(), frame, glam::vec2(pixel.x, pixel.y));
        let id = pick.and_then(|pick| primitive_of(view, &pick));
        let sample = pick.and_then(|pick| sample_of(view, &pick)).map(|i| i as u32);
        explain(view, response, sample, pick.is_some(), actions);
        if response.double_clicked() {
            if let Some(pick) = pick {
                let p = pick.position.as_dvec3();
                actions.push(Action::SetPivot(Point3::new(p.x, p.y, p.z)));
            }
        } else if response.clicked_by(PointerButton::Primary) {
            let how = how(ctx);
            match view.view.picks {
                Picks::Points => {
                    let samples: Bulk<Vec<u32>> =
                        pick.and_then(|pick| sample_of(view, &pick)).into_iter().map(|i| i as u32).collect();
                    if !samples.is_empty() || how == Select::Replace {
                        actions.push(Action::SelectPoints { samples, how });
                    }
                }
                Picks::Primitives => match (id, how) {
                    (Some(id), Select::Add) => actions.push(Action::ToggleSelected(id)),
                    (Some(id), Select::Remove) => {
                        actions.push(Action::SelectPrimitives { ids: vec![id].into(), how });
                    }
                    (id, Select::Replace) => actions.push(Action::Select(id)),
                    (None, Select::Add | Select::Remove) => {}
                },
            }
        }
        self.set_hovered(ctx, id);
        if let Some(text) = tooltip(view, pick.as_ref(), id) {
            response.clone().on_hover_text_at_pointer(text);
        }
    }

    /// A box or a lasso, from its first corner to what it selects.
    fn draw_around(
        &mut self,
        view: &SceneView<'_>,
        response: &Response,
        frame: &Frame,
        scene: &Scene,
        actions: &mut Vec<Action>,
    ) {
        let tool = view.view.tool;
        let (pointer, origin, alt) =
            response.ctx.input(|i| (i.pointer.latest_pos(), i.pointer.press_origin(), i.modifiers.alt));
        if tool == Tool::Click {
            self.drawn = None;
            return;
        }
        if response.drag_started_by(PointerButton::Primary)
            && !alt
            && let Some(start) = origin.or(response.interact_pointer_pos())
        {
            self.drawn = Some(Drawn { tool, path: vec![start], tip: start });
        }
        let Some(drawn) = &mut self.drawn else { return };
        if let Some(pointer) = pointer {
            drawn.tip = pointer;
            if tool == Tool::Lasso && drawn.path.last().is_none_or(|p| p.distance(pointer) >= LASSO_STEP) {
                drawn.path.push(pointer);
            }
        }
        if !response.drag_stopped_by(PointerButton::Primary) && response.dragged_by(PointerButton::Primary) {
            return;
        }
        let Some(drawn) = self.drawn.take() else { return };
        let region = drawn.region(response.rect, frame.pixels_per_point);
        let (pickable, visible_only, how) = (scene.pickable(), view.view.visible_only, how(&response.ctx));
        actions.push(match view.view.picks {
            Picks::Primitives => Action::SelectPrimitives {
                ids: primitives_within(&pickable, frame, &region, visible_only).into(),
                how,
            },
            Picks::Points => {
                let shown = points_within(&pickable, frame, &region, visible_only);
                let sample = |i: u32| Some(sample_of_shown(view.loaded?, i as usize)? as u32);
                Action::SelectPoints { samples: shown.into_iter().filter_map(sample).collect(), how }
            }
        });
    }

    /// The outline of a selection in progress.
    pub(super) fn paint(&self, ui: &Ui, rect: Rect) {
        let Some(drawn) = &self.drawn else { return };
        let palette = Palette::of(ui);
        let painter = ui.painter().with_clip_rect(rect);
        let mut line = match drawn.tool {
            Tool::Lasso => drawn.path.iter().chain([&drawn.tip]).copied().collect::<Vec<_>>(),
            Tool::Box | Tool::Click => {
                let around = Rect::from_two_pos(drawn.path[0], drawn.tip);
                painter.rect_filled(around, 0.0, palette.accent.gamma_multiply(0.10));
                let (a, b) = (around.min, around.max);
                vec![a, pos2(b.x, a.y), b, pos2(a.x, b.y)]
            }
        };
        line.push(line[0]);
        // Seen on dark and on light things.
        painter.add(Shape::line(line.clone(), Stroke::new(2.5, palette.overlay.gamma_multiply(0.6))));
        painter.extend(Shape::dashed_line(&line, Stroke::new(1.3, palette.accent), 5.0, 4.0));
    }

    fn set_hovered(&mut self, ctx: &Context, now: Option<u32>) {
        if self.hovered != now {
            self.hovered = now;
            // The picture of this frame has been decided.
            ctx.request_repaint();
        }
    }
}

/// A click on a point, or the key while the pointer is over it, shows its odds.
/// A click on nothing hides them.
fn explain(
    view: &SceneView<'_>,
    response: &Response,
    sample: Option<u32>,
    is_on_something: bool,
    actions: &mut Vec<Action>,
) {
    let is_key = |action: &Action| *action == Action::Verb(Verb::ShowOdds);
    if let (Some(_), Some(at)) = (sample, actions.iter().position(is_key)) {
        if view.view.shows_odds {
            actions.remove(at);
        }
        actions.push(Action::Explain(sample));
    } else if response.clicked_by(PointerButton::Primary)
        && view.view.tool == Tool::Click
        && (sample.is_some() || !is_on_something)
    {
        actions.push(Action::Explain(sample));
    }
}

fn how(ctx: &Context) -> Select {
    let modifiers = ctx.input(|i| i.modifiers);
    Select::of_modifiers(modifiers.shift, modifiers.command)
}

fn sample_of(view: &SceneView<'_>, pick: &Pick) -> Option<usize> {
    match pick.id {
        PickId::Primitive(_) => None,
        PickId::Point(index) => sample_of_shown(view.loaded?, index),
    }
}

fn primitive_of(view: &SceneView<'_>, pick: &Pick) -> Option<u32> {
    match pick.id {
        PickId::Primitive(id) => Some(id),
        PickId::Point(_) => {
            let label = *view.snapshot?.abstraction.labels.get(sample_of(view, pick)?)?;
            (label != UNASSIGNED).then_some(label)
        }
    }
}

/// Tooltip of the item under the pointer.
fn tooltip(view: &SceneView<'_>, pick: Option<&Pick>, id: Option<u32>) -> Option<String> {
    let primitive = id.and_then(|id| view.primitives().iter().find(|p| p.id == id));
    let mut lines = Vec::new();
    if let Some(sample) = pick.and_then(|pick| sample_of(view, pick)) {
        let point = view.loaded?.cloud.points.get(sample)?;
        let distance = primitive.map(|p| length(p.shape.first_order_distance(point)));
        lines.push(match distance {
            Some(distance) => format!("Point {sample}, {distance} from its surface"),
            None => format!("Point {sample}, unassigned"),
        });
    }
    if let Some(primitive) = primitive {
        lines.push(format!(
            "Primitive {}\n{} points, mean error {}",
            primitive.id,
            count(primitive.points),
            length(primitive.mean_distance)
        ));
    }
    (!lines.is_empty()).then(|| lines.join("\n"))
}
