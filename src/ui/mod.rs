//! The window's contents: panels around the viewport. [`Interface::show`]
//! draws a session and answers with what the person asked for; it changes
//! nothing itself.

use std::time::Duration;

use egui::{CentralPanel, Context, Frame, Margin, Panel, ScrollArea, Ui};

use crate::session::Session;
use crate::session::action::Action;

mod controls;
mod dialogs;
mod figures;
mod keys;
mod menu;
mod merging;
mod overlays;
mod primitives;
mod progress;
mod scene;
mod theme;
mod viewport;
mod widgets;

use dialogs::Dialogs;
pub use dialogs::Purpose;
use overlays::Overlays;
use primitives::Primitives;
use scene::SceneView;
use viewport::{Studio, Viewport};

/// Widths of the side panels in logical pixels.
const LEFT: f32 = 290.0;
const RIGHT: f32 = 272.0;

/// A hand that holds a slider rests when nothing was moved for so many seconds
/// and in so many frames: where frames are slow, some of a drag see no change.
const REST: f64 = 0.2;
const STILL_FRAMES: u32 = 2;

/// What the window remembers besides the session.
#[derive(Debug)]
pub struct Interface {
    viewport: Viewport,
    /// Draws what is not on screen, where there is something to draw with.
    studio: Option<Studio>,
    dialogs: Dialogs,
    overlays: Overlays,
    primitives: Primitives,
    /// When what a run is made from was last changed, in seconds, and the frames
    /// without a movement since.
    turned_at: f64,
    still_frames: u32,
    /// Something is being dragged whose changes are one step for undo.
    is_in_gesture: bool,
}

impl Interface {
    /// Sets the themes up and, where there is a render state, the 3D view.
    /// Without `system_dialogs` paths are always typed.
    pub fn new(ctx: &Context, state: Option<&egui_wgpu::RenderState>, system_dialogs: bool) -> Self {
        theme::install(ctx);
        Self {
            viewport: Viewport::new(state, "3D view", true),
            studio: state.map(Studio::new),
            dialogs: Dialogs::new(system_dialogs),
            overlays: Overlays::default(),
            primitives: Primitives::default(),
            turned_at: 0.0,
            still_frames: 0,
            is_in_gesture: false,
        }
    }

    /// Asks the person for a path; the answer comes as an action of a later
    /// [`Interface::show`].
    pub fn ask(&mut self, ctx: &Context, purpose: Purpose, name: &str) {
        self.dialogs.ask(ctx, purpose, name);
    }

    /// Draws one frame.
    pub fn show(&mut self, ui: &mut Ui, session: &Session) -> Vec<Action> {
        let ctx = ui.ctx().clone();
        let mut actions = Vec::new();
        theme::choose(&ctx, session.view.theme);
        keys::pressed(&ctx, session, &mut actions);
        for file in ctx.input(|i| i.raw.dropped_files.clone()).iter().take(1) {
            actions.push(Action::OpenFile(file.path().to_owned()));
        }

        let fill = ui.visuals().panel_fill;
        let bar = Frame::new().fill(fill).inner_margin(Margin::symmetric(8, 3));
        let side = Frame::new().fill(fill).inner_margin(Margin::symmetric(12, 8));
        let below = Frame::new().fill(fill).inner_margin(Margin::symmetric(12, 6));
        Panel::top("menu bar").frame(bar).show(ui, |ui| menu::show(ui, session, &mut actions));
        Panel::bottom("status line").frame(bar).show(ui, |ui| progress::status(ui, session));
        Panel::left("controls").frame(side).exact_size(LEFT).resizable(false).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                controls::show(ui, session, &mut actions);
            });
        });
        Panel::right("primitives").frame(side).exact_size(RIGHT).resizable(false).show(ui, |ui| {
            self.primitives.show(ui, session, &mut actions);
        });
        Panel::bottom("progress").frame(below).show(ui, |ui| progress::show(ui, session));
        let area = CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            viewport::toolbar(ui, session, &mut actions);
            let rect = ui.available_rect_before_wrap();
            self.viewport.show(ui, &SceneView::of(session), &mut actions);
            rect
        });
        merging::show(&ctx, session, area.inner, &mut actions);
        self.overlays.show(&ctx, session, area.inner, &mut actions);
        self.dialogs.show(&ctx, &mut actions);
        self.watch_hand(&ctx, session, &mut actions);
        self.watch_gesture(&ctx, &mut actions);
        actions
    }

    /// Tells when a gesture ends: what the pointer drags until it lets go, what
    /// the keyboard changes at once.
    fn watch_gesture(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        let is_part = |action: &Action| {
            matches!(action, Action::SetParams(_) | Action::SetSampling(_) | Action::DraftShape(_))
        };
        self.is_in_gesture |= actions.iter().any(is_part);
        if self.is_in_gesture && !ctx.input(|i| i.pointer.any_down()) {
            self.is_in_gesture = false;
            actions.push(Action::EndGesture);
        }
    }

    /// Tells when the hand that turns a slider comes to rest.
    fn watch_hand(&mut self, ctx: &Context, session: &Session, actions: &mut Vec<Action>) {
        let turns = |action: &Action| {
            matches!(action, Action::SetParams(_) | Action::SetMethod(_) | Action::SetSampling(_))
        };
        let (now, let_go, moves) =
            ctx.input(|i| (i.time, i.pointer.any_released(), i.pointer.delta() != egui::Vec2::ZERO));
        let turned = actions.iter().any(turns);
        if turned || moves {
            self.turned_at = now;
            self.still_frames = 0;
        } else {
            self.still_frames = self.still_frames.saturating_add(1);
        }
        if !turned && !session.awaits_newer_run() {
            return;
        }
        let left = self.turned_at + REST - now;
        if let_go || (left <= 0.0 && self.still_frames >= STILL_FRAMES) {
            actions.push(Action::HandRests);
        } else {
            ctx.request_repaint_after(Duration::from_secs_f64(left.max(0.0)));
        }
    }
}
