//! The 3D view: turns the session into a [`Frame`] and uploads, and the
//! pointer into actions. The only file that names both egui and wgpu.

use egui::{PointerButton, Response, Role, Sense, Ui, WidgetInfo, vec2};
use egui_wgpu::wgpu;
use nalgebra::{Point3, Vector2};

use super::scene::Scene;
use super::theme::{self, Palette};
use super::widgets::{count, length};
use crate::render::{
    CameraMatrices, Frame, Grid, Layers, Pick, PickId, RenderOptions, Renderer, SurfaceStyle, picking,
};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::camera::Camera;
use crate::session::scene::sample_of_shown;
use crate::session::view::{self, Layer};

/// Radians a logical pixel of dragging.
const ORBIT_SPEED: f64 = 0.008;
/// Zoom a logical pixel of scrolling.
const ZOOM_SPEED: f64 = 0.0022;

/// The viewport's own state: what was uploaded, what is hovered.
#[derive(Debug, Default)]
pub(super) struct Viewport {
    scene: Scene,
    hovered: Option<u32>,
    has_gpu: bool,
}

/// What lives with egui's renderer.
struct Gpu {
    renderer: Renderer,
    points: u64,
    colors: u64,
    mesh: u64,
    primitives: u64,
}

impl Viewport {
    /// Builds the pipelines; without a render state there is no picture.
    pub(super) fn new(state: Option<&egui_wgpu::RenderState>) -> Self {
        if let Some(state) = state {
            // A software driver pays for every sample.
            let is_software = state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
            let options = RenderOptions { msaa: if is_software { 1 } else { 4 } };
            let renderer = Renderer::new(&state.device, state.target_format, options);
            let gpu = Gpu { renderer, points: 0, colors: 0, mesh: 0, primitives: 0 };
            state.renderer.write().callback_resources.insert(gpu);
        }
        Self { has_gpu: state.is_some(), ..Self::default() }
    }

    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "3D view"));
        if rect.width() < 2.0 || rect.height() < 2.0 {
            return;
        }
        let aspect = f64::from(rect.width() / rect.height());
        if (aspect - session.camera.aspect).abs() > 1e-9 {
            actions.push(Action::SetAspect(aspect));
        }
        self.scene.update(session, self.hovered);
        let frame = frame(ui, session, rect);
        self.point(ui, session, &response, &frame, actions);
        if self.has_gpu {
            let callback = Paint { frame, scene: self.scene.clone() };
            ui.painter().add(egui_wgpu::Callback::new_paint_callback(rect, callback));
        } else {
            ui.painter().rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
        }
        axes(ui, session, rect);
        if session.loaded.is_none() {
            empty(ui, session, rect);
        }
    }

    /// The pointer: orbit, pan, zoom, select, hover.
    fn point(
        &mut self,
        ui: &Ui,
        session: &Session,
        response: &Response,
        frame: &Frame,
        actions: &mut Vec<Action>,
    ) {
        let rect = response.rect;
        let delta = response.drag_delta();
        if response.dragged_by(PointerButton::Primary) && delta != egui::Vec2::ZERO {
            let (right, up) = (f64::from(delta.x) * ORBIT_SPEED, f64::from(-delta.y) * ORBIT_SPEED);
            actions.push(Action::Orbit { right, up });
        } else if (response.dragged_by(PointerButton::Secondary)
            || response.dragged_by(PointerButton::Middle))
            && delta != egui::Vec2::ZERO
        {
            let offset = 2.0 * delta / rect.size();
            actions.push(Action::Pan(Vector2::new(f64::from(offset.x), f64::from(-offset.y))));
        }
        let previously = self.hovered;
        let Some(pointer) = response.hover_pos() else {
            self.set_hovered(ui, previously, None);
            return;
        };
        let offset = 2.0 * (pointer - rect.center()) / rect.size();
        let cursor = Vector2::new(f64::from(offset.x), f64::from(-offset.y));
        let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        if scroll != 0.0 || pinch != 1.0 {
            let factor = (-f64::from(scroll) * ZOOM_SPEED).exp() / f64::from(pinch.max(0.1));
            actions.push(Action::Zoom { cursor, factor });
        }
        let is_dragging = response.dragged();
        let wants_pick = response.clicked() || response.double_clicked();
        if !wants_pick && (is_dragging || !self.scene.is_quick_to_pick()) {
            self.set_hovered(ui, previously, None);
            return;
        }
        let pixel = (pointer - rect.min) * frame.pixels_per_point;
        let pick = picking::pick(&self.scene.pickable(), frame, glam::vec2(pixel.x, pixel.y));
        let id = pick.and_then(|pick| self.primitive_of(session, &pick));
        if response.double_clicked() {
            if let Some(pick) = pick {
                let p = pick.position;
                actions.push(Action::SetPivot(Point3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z))));
            }
        } else if response.clicked_by(PointerButton::Primary) {
            let adds = ui.input(|i| i.modifiers.shift);
            match id {
                Some(id) if adds => actions.push(Action::ToggleSelected(id)),
                None if adds => {}
                id => actions.push(Action::Select(id)),
            }
        }
        self.set_hovered(ui, previously, id);
        if let Some(primitive) = id.and_then(|id| session.primitives().iter().find(|p| p.id == id)) {
            let text = format!(
                "Primitive {}\n{} points, mean error {}",
                primitive.id,
                count(primitive.points),
                length(primitive.mean_distance)
            );
            response.clone().on_hover_text_at_pointer(text);
        }
    }

    fn set_hovered(&mut self, ui: &Ui, previously: Option<u32>, now: Option<u32>) {
        if previously != now {
            self.hovered = now;
            // The picture of this frame has been decided.
            ui.ctx().request_repaint();
        }
    }

    fn primitive_of(&self, session: &Session, pick: &Pick) -> Option<u32> {
        match pick.id {
            PickId::Primitive(id) => Some(id),
            PickId::Point(index) => {
                let index = sample_of_shown(session.loaded.as_ref()?, index)?;
                let label = *session.snapshot.as_ref()?.abstraction.labels.get(index)?;
                (label != crate::inference::UNASSIGNED).then_some(label)
            }
        }
    }
}

/// Everything but the data that decides how the picture looks.
fn frame(ui: &Ui, session: &Session, rect: egui::Rect) -> Frame {
    let pixels_per_point = ui.ctx().pixels_per_point();
    // As egui rounds the viewport of a paint callback.
    let pixels = |from: f32, to: f32| {
        ((to * pixels_per_point).round() - (from * pixels_per_point).round()).max(0.0) as u32
    };
    let size_px = [pixels(rect.min.x, rect.max.x), pixels(rect.min.y, rect.max.y)];
    let aspect = rect.width() / rect.height();
    let view = &session.view;
    let bounds = &session.scene.bounds;
    let has_shape = session.loaded.is_some();
    Frame {
        pixels_per_point,
        layers: Layers {
            input: view.shows(Layer::Input),
            points: view.shows(Layer::Points),
            primitives: view.shows(Layer::Primitives),
            grid: view.shows(Layer::Grid) && has_shape,
            lines: false,
        },
        surface_style: match view.surface_style {
            view::SurfaceStyle::Solid => SurfaceStyle::Solid,
            view::SurfaceStyle::Translucent => SurfaceStyle::Translucent,
            view::SurfaceStyle::Wire => SurfaceStyle::Wire,
        },
        point_size: view.point_size,
        grid: Grid::horizontal(bounds.min.y as f32, 0.1),
        theme: theme::scene(ui),
        ..Frame::new(size_px, matrices(&session.camera, aspect))
    }
}

fn matrices(camera: &Camera, aspect: f32) -> CameraMatrices {
    let vec3 = |v: [f64; 3]| glam::Vec3::from(v.map(|c| c as f32));
    let (eye, target) = (vec3(camera.eye().coords.into()), vec3(camera.target.coords.into()));
    let up = vec3(camera.up().into());
    if camera.orthographic {
        let height = 2.0 * camera.half_extent().y as f32;
        CameraMatrices::orthographic(
            eye,
            target,
            up,
            height,
            aspect,
            -50.0,
            50.0 + 2.0 * camera.distance as f32,
        )
    } else {
        let near = (0.01 * camera.distance as f32).clamp(1e-5, 0.05);
        CameraMatrices::perspective(eye, target, up, camera.fov_y() as f32, aspect, near)
    }
}

/// The input's axes in the lower left corner.
fn axes(ui: &Ui, session: &Session, rect: egui::Rect) {
    let origin = rect.left_bottom() + vec2(34.0, -34.0);
    let colors = Palette::of(ui).axes;
    let camera = &session.camera;
    let zero = session.scene.point(&Point3::origin());
    let mut arms: Vec<_> = (0..3)
        .map(|axis| {
            let mut along = Point3::origin();
            along[axis] = 1.0 / session.scene.scale();
            let v = session.scene.point(&along) - zero;
            let on_screen = vec2(v.dot(&camera.right()) as f32, -v.dot(&camera.up()) as f32);
            (v.dot(&camera.forward()), on_screen, axis)
        })
        .collect();
    // The farthest first.
    arms.sort_by(|a, b| b.0.total_cmp(&a.0));
    let painter = ui.painter().with_clip_rect(rect);
    for (_, arm, axis) in arms {
        let tip = origin + arm * 20.0;
        painter.line_segment([origin, tip], egui::Stroke::new(2.0, colors[axis]));
        let name = ["x", "y", "z"][axis];
        let font = egui::FontId::proportional(11.0);
        painter.text(origin + arm * 27.0, egui::Align2::CENTER_CENTER, name, font, colors[axis]);
    }
}

/// What to do when there is nothing to see.
fn empty(ui: &Ui, session: &Session, rect: egui::Rect) {
    let text = if session.activity == crate::worker::Activity::Loading {
        "Loading…"
    } else {
        "Open a shape, or drop a file here"
    };
    let font = egui::FontId::proportional(15.0);
    ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, text, font, Palette::of(ui).weak);
}

/// One frame's drawing.
struct Paint {
    frame: Frame,
    scene: Scene,
}

impl egui_wgpu::CallbackTrait for Paint {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &egui_wgpu::ScreenDescriptor,
        encoder: &mut wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(Gpu { renderer, points, colors, mesh, primitives }) = resources.get_mut::<Gpu>() {
            self.scene.points.upload(points, |p| {
                renderer.set_points(device, queue, p);
                // New points are white until they are coloured.
                *colors = 0;
            });
            self.scene.colors.upload(colors, |c| renderer.set_point_colors(queue, c));
            self.scene.mesh.upload(mesh, |m| renderer.set_mesh(device, queue, &m.vertices, &m.faces));
            self.scene.primitives.upload(primitives, |p| renderer.set_primitives(device, queue, p));
            renderer.prepare(device, queue, encoder, &self.frame);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &egui_wgpu::CallbackResources,
    ) {
        if let Some(gpu) = resources.get::<Gpu>() {
            gpu.renderer.paint(pass);
        }
    }
}
