//! The window's contents: panels around the viewport. [`Interface::show`] draws a session and
//! returns the user's actions; it changes nothing itself.
//!
//! Each layer uses only those below it:
//!
//! | layer | what lives there |
//! |---|---|
//! | `compare`, `dialogs`, `export`, `layout`, `overlays`, `commands` | views side by side, dialogs, the panels around the view, what lies over it |
//! | `menu`, `controls`, `primitives`, `priors`, `timeline`, `figures`, `seeds`, `pictures`, `odds`, `merging`, `saving`, `history`, `log`, `toasts`, `errors`, `progress`, `help` | panels and their contents |
//! | `viewport` | the 3D view |
//! | `scene`, `widgets` | what a view draws, what many panels are made of |
//! | `background`, `fuzzy`, `keys`, `theme`, `tooltips` | work that no frame waits for, matching of names, keys, colours and spacing |

use std::path::{Path, PathBuf};
use std::time::Duration;

use egui::{CentralPanel, Context, Frame, Margin, Panel, ScrollArea, Ui};

use crate::geometry::Bulk;
use crate::session::Session;
use crate::session::action::{Action, PictureKind};

mod background;
mod commands;
mod compare;
mod controls;
mod dialogs;
mod errors;
mod export;
mod figures;
mod fuzzy;
mod help;
mod history;
mod keys;
mod layout;
mod log;
mod menu;
mod merging;
mod odds;
mod overlays;
mod pictures;
mod primitives;
mod priors;
mod progress;
mod saving;
mod scene;
mod seeds;
mod theme;
mod timeline;
mod toasts;
mod tooltips;
mod viewport;
mod widgets;

use compare::Compare;
use dialogs::Dialogs;
pub use dialogs::Purpose;
use export::ExportDialog;
use layout::Part;
pub use layout::Sizes;
use log::Log;
use odds::OddsCard;
use overlays::Overlays;
use pictures::Pictures;
use primitives::Primitives;
use seeds::SeedStrip;
use timeline::Timeline;
use viewport::{Studio, Viewport};

/// Below this window width, in logical pixels, there is room for only one side panel.
const NARROW: f32 = 860.0;

/// A slider counts as resting when nothing has moved for this many seconds and
/// frames. With slow frames, some frames of a drag see no change.
const REST: f64 = 0.2;
const STILL_FRAMES: u32 = 2;

/// Window state outside the session.
#[derive(Debug)]
pub struct Interface {
    viewport: Viewport,
    odds: OddsCard,
    seeds: SeedStrip,
    pictures: Pictures,
    export: ExportDialog,
    dialogs: Dialogs,
    overlays: Overlays,
    primitives: Primitives,
    timeline: Timeline,
    compare: Compare,
    log: Log,
    sizes: Sizes,
    /// Time of the last change to a run's inputs, in seconds, and the number of
    /// frames without movement since.
    turned_at: f64,
    still_frames: u32,
    /// A drag is in progress whose changes form one undo step.
    is_in_gesture: bool,
}

impl Interface {
    /// Sets up the themes and, if there is a render state, the 3D view. Without
    /// `system_dialogs`, paths are always typed.
    pub fn new(ctx: &Context, state: Option<&egui_wgpu::RenderState>, system_dialogs: bool) -> Self {
        theme::install(ctx);
        ctx.add_plugin(tooltips::QuietTooltips::default());
        Self {
            viewport: Viewport::new(state, "3D view", true),
            odds: OddsCard::default(),
            seeds: SeedStrip::new(state.map(Studio::new)),
            pictures: Pictures::new(state.map(Studio::new)),
            export: ExportDialog::default(),
            dialogs: Dialogs::new(system_dialogs),
            overlays: Overlays::default(),
            primitives: Primitives::default(),
            timeline: Timeline::default(),
            compare: Compare::default(),
            log: Log::default(),
            sizes: Sizes::default(),
            turned_at: 0.0,
            still_frames: 0,
            is_in_gesture: false,
        }
    }

    /// Asks the user for a path, starting in `folder`. The answer is an action
    /// of a later [`Interface::show`].
    pub fn ask(&mut self, ctx: &Context, purpose: Purpose, name: &str, folder: Option<&Path>) {
        self.dialogs.ask(ctx, purpose, name, folder);
    }

    /// Panel sizes, for the next start.
    pub fn sizes(&self) -> &Sizes {
        &self.sizes
    }

    /// Sets the panel sizes.
    pub fn set_sizes(&mut self, sizes: Sizes) {
        self.sizes.replace(sizes);
    }

    /// Opens the dialog for a picture of the 3D view.
    pub fn ask_for_picture(&mut self, kind: PictureKind) {
        self.pictures.ask(kind);
    }

    /// Opens the export dialog.
    pub fn ask_for_export(&mut self, session: &Session) {
        self.export.ask(session);
    }

    /// Renders the requested picture. The outcome is an action of a later [`Interface::show`].
    ///
    /// # Errors
    /// Where there is nothing to draw with.
    pub fn save_picture(
        &mut self,
        ctx: &Context,
        session: &Session,
        kind: PictureKind,
        path: PathBuf,
    ) -> Result<(), String> {
        self.pictures.begin(ctx, session, kind, &path)
    }

    /// Draws one frame.
    pub fn show(&mut self, ui: &mut Ui, session: &Session) -> Vec<Action> {
        let ctx = ui.ctx().clone();
        let mut actions = Vec::new();
        theme::choose(&ctx, session.view.theme);
        theme::zoom(&ctx, session.window.zoom);
        keys::pressed(&ctx, session, &mut actions);
        let dropped: Bulk<Vec<_>> =
            ctx.input(|i| i.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        if !dropped.is_empty() {
            actions.push(Action::OpenDropped(dropped));
        }
        let window = ui.max_rect().size();
        if (window.x < NARROW) != session.window.is_narrow() {
            actions.push(Action::SetNarrow(window.x < NARROW));
        }

        let fill = ui.visuals().panel_fill;
        let bar = Frame::new().fill(fill).inner_margin(Margin::symmetric(8, 3));
        let side = Frame::new().fill(fill).inner_margin(Margin::symmetric(12, 8));
        let below = Frame::new().fill(fill).inner_margin(Margin::symmetric(12, 6));
        Panel::top("menu bar").frame(bar).show(ui, |ui| menu::show(ui, session, &mut actions));
        Panel::bottom("status line").frame(bar).show(ui, |ui| {
            // Cut where it is too long, never wrapped.
            ScrollArea::horizontal().show(ui, |ui| progress::status(ui, session));
        });
        let (sizes, place) = (&mut self.sizes, (session, window));
        Part::Log.show(ui, place, below, sizes, &mut actions, |ui, actions| {
            self.log.show(ui, session, actions);
        });
        Part::Timeline.show(ui, place, below, sizes, &mut actions, |ui, actions| {
            self.timeline.show(ui, session, actions);
        });
        Part::Left.show(ui, place, side, sizes, &mut actions, |ui, actions| {
            ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                widgets::bounded(ui, false, |ui| controls::show(ui, session, actions));
                widgets::follow_focus(ui);
            });
        });
        Part::Right.show(ui, place, side, sizes, &mut actions, |ui, actions| {
            let height = ui.available_height();
            ScrollArea::vertical().id_salt("right").auto_shrink([false, false]).show(ui, |ui| {
                widgets::bounded(ui, false, |ui| self.primitives.show(ui, session, height, actions));
                widgets::follow_focus(ui);
            });
        });
        self.seeds.show(ui, session, &mut actions);
        let area = CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            viewport::toolbar(ui, session, &mut actions);
            let rect = ui.available_rect_before_wrap();
            self.compare.show(ui, session, &mut self.viewport, &mut actions);
            rect
        });
        merging::show(&ctx, session, area.inner, &mut actions);
        self.odds.show(&ctx, session, area.inner, &mut actions);
        self.overlays.show(&ctx, session, area.inner, &mut actions);
        saving::show(&ctx, session, &mut actions);
        if let Some(kind) = self.pictures.show(&ctx, area.inner, &mut actions) {
            let purpose = Purpose::Picture(kind, self.pictures.format());
            let name = session.loaded.as_ref().map_or("superform", |l| l.shape.name.as_str());
            let stem =
                Path::new(name).file_stem().map_or_else(|| "superform".into(), |s| s.to_string_lossy());
            self.dialogs.ask(&ctx, purpose, &stem, session.window.save_folder.as_deref());
        }
        if let Some(format) = self.export.show(&ctx, session, &mut actions) {
            let folder = session.window.save_folder.as_deref();
            self.dialogs.ask(&ctx, Purpose::Export(format), &session.export_name(format), folder);
        }
        self.dialogs.show(&ctx, &mut actions);
        self.watch_hand(&ctx, session, &mut actions);
        self.watch_gesture(&ctx, &mut actions);
        actions
    }

    /// Detects the end of a gesture: for the pointer when it is released, for
    /// the keyboard immediately.
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

    /// Detects when a dragged slider comes to rest.
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
