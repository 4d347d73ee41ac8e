//! Saving pictures of the 3D view: the dialogs, and the job that renders a little per frame so that
//! the window stays responsive.

use std::path::{Path, PathBuf};

use egui::{Align2, Area, Button, Context, DragValue, Id, Label, Modal, ProgressBar, RichText, Ui, vec2};

use super::scene::SceneView;
use super::theme::{self, Palette};
use super::viewport::Studio;
use super::widgets;
use crate::io::{AnimationFormat, LARGEST_GIF};
use crate::session::Session;
use crate::session::action::{Action, PictureKind};

mod job;
mod still;

use job::Job;
use still::Still;

/// Logical pixels.
const WIDTH: f32 = 330.0;
const LABELS: f32 = 110.0;
/// Height of the buttons below.
const BUTTONS: f32 = theme::ROW + 16.0;
const LEAST_SIDE: u32 = 16;

/// Size of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Size {
    /// The size of the view on screen.
    View,
    Fixed(u32, u32),
    Custom,
}

/// Named sizes of single pictures and of turntables.
const PICTURE_SIZES: [(Size, &str); 4] = [
    (Size::View, "Same as view"),
    (Size::Fixed(1920, 1080), "1080p, 1920 × 1080"),
    (Size::Fixed(3840, 2160), "4K, 3840 × 2160"),
    (Size::Custom, "Custom"),
];
const TURNTABLE_SIZES: [(Size, &str); 4] = [
    (Size::Fixed(480, 480), "480 × 480"),
    (Size::Fixed(800, 600), "800 × 600"),
    (Size::Fixed(1920, 1080), "1080p, 1920 × 1080"),
    (Size::Custom, "Custom"),
];

/// The last options are kept for the next time.
#[derive(Debug)]
struct Choice {
    size: Size,
    custom: [u32; 2],
    transparent: bool,
}

/// Dialogs and job.
#[derive(Debug)]
pub(super) struct Pictures {
    /// `None` without a graphics driver.
    studio: Option<Studio>,
    open: Option<PictureKind>,
    picture: Choice,
    turntable: Choice,
    frames: u32,
    /// Of a whole turn.
    seconds: f64,
    format: AnimationFormat,
    job: Option<Job>,
    /// Physical pixels of the view on screen.
    view_px: [u32; 2],
}

impl Pictures {
    pub(super) fn new(studio: Option<Studio>) -> Self {
        Self {
            studio,
            open: None,
            picture: Choice { size: Size::View, custom: [1200, 1200], transparent: false },
            turntable: Choice { size: Size::Fixed(480, 480), custom: [640, 640], transparent: false },
            frames: 72,
            seconds: 6.0,
            format: AnimationFormat::Gif,
            job: None,
            view_px: [1, 1],
        }
    }

    /// Opens a dialog, unless a picture is being drawn.
    pub(super) fn ask(&mut self, kind: PictureKind) {
        if self.job.is_none() {
            self.open = Some(kind);
        }
    }

    /// Format of turntables: a file or a folder.
    pub(super) fn format(&self) -> AnimationFormat {
        self.format
    }

    /// Starts rendering.
    pub(super) fn begin(
        &mut self,
        ctx: &Context,
        session: &Session,
        kind: PictureKind,
        path: &Path,
    ) -> Result<(), String> {
        let Some(studio) = &mut self.studio else {
            return Err("no graphics driver is available".to_owned());
        };
        let choice = match kind {
            PictureKind::Still => &self.picture,
            PictureKind::Turntable => &self.turntable,
        };
        let size = pixels(choice, self.view_px);
        let theme = theme::scene_of(ctx.theme() == egui::Theme::Dark);
        let still = Still::of(&SceneView::of(session));
        let shot = still.shot(size, theme, choice.transparent);
        self.job = Some(match kind {
            PictureKind::Still => Job::still(studio, still, shot, path),
            PictureKind::Turntable => {
                Job::turntable(still, shot, path, self.format, self.frames, self.seconds)
            }
        });
        ctx.request_repaint();
        Ok(())
    }

    /// Draws the dialog or the progress, and continues the job. Returns the kind
    /// of picture that needs a path.
    pub(super) fn show(
        &mut self,
        ctx: &Context,
        viewport: egui::Rect,
        actions: &mut Vec<Action>,
    ) -> Option<PictureKind> {
        let size = viewport.size() * ctx.pixels_per_point();
        self.view_px = [size.x, size.y].map(|s| (s.round() as u32).max(LEAST_SIDE));
        self.advance(ctx, viewport, actions);
        let kind = self.open?;
        let mut is_wanted = false;
        let mut done = false;
        let frame = egui::Frame::popup(&ctx.global_style()).inner_margin(14.0);
        let response = Modal::new(Id::unique("picture")).frame(frame).show(ctx, |ui| {
            ui.set_width(widgets::dialog_width(ctx, WIDTH));
            ui.heading(match kind {
                PictureKind::Still => "Save picture of the 3D view",
                PictureKind::Turntable => "Save turntable",
            });
            ui.add_space(6.0);
            widgets::dialog_body(ui, BUTTONS, |ui| {
                if self.studio.is_none() {
                    ui.label("No graphics driver is available.");
                } else {
                    self.settings(ui, kind);
                }
            });
            ui.add_space(10.0);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let save = ui.add_enabled(self.studio.is_some(), Button::new("Choose file and save…"));
                let what = match (kind, self.format) {
                    (PictureKind::Turntable, AnimationFormat::Pngs) => {
                        "Choose a folder, then render the pictures"
                    }
                    _ => "Choose a file, then render the picture",
                };
                is_wanted = save.on_hover_text(what).clicked();
                done = is_wanted || ui.button("Cancel").clicked();
            });
        });
        if done || response.should_close() {
            self.open = None;
        }
        is_wanted.then_some(kind)
    }

    fn settings(&mut self, ui: &mut Ui, kind: PictureKind) {
        let limit = self.studio.as_ref().map_or(LEAST_SIDE, Studio::largest_side);
        let view_px = self.view_px;
        let (choice, sizes) = match kind {
            PictureKind::Still => (&mut self.picture, &PICTURE_SIZES),
            PictureKind::Turntable => (&mut self.turntable, &TURNTABLE_SIZES),
        };
        row(ui, "Size", |ui, label| {
            let text = sizes.iter().find(|(size, _)| *size == choice.size).map_or("", |(_, text)| text);
            let combo = egui::ComboBox::from_id_salt("picture size")
                .width(190.0)
                .selected_text(text)
                .show_ui(ui, |ui| {
                    for (size, text) in sizes {
                        ui.selectable_value(&mut choice.size, *size, *text);
                    }
                });
            combo.response.labelled_by(label).on_hover_text("Width and height in pixels");
        });
        let most = if kind == PictureKind::Turntable { limit.min(LARGEST_GIF) } else { limit };
        row(ui, "Pixels", |ui, _| {
            let is_custom = choice.size == Size::Custom;
            let mut shown = pixels(choice, view_px);
            for (side, name) in shown.iter_mut().zip(["Width", "Height"]) {
                let number = DragValue::new(side).range(LEAST_SIDE..=most).speed(4.0);
                let response = ui.add_enabled(is_custom, number).accessible_name(name);
                let text = format!("{name} in pixels, at most {most}");
                response
                    .on_hover_text(&text)
                    .on_disabled_hover_text(format!("{text}. Choose Custom to set it"));
                if name == "Width" {
                    ui.label("×");
                }
            }
            if is_custom {
                choice.custom = shown;
            }
        });
        if kind == PictureKind::Turntable {
            row(ui, "Frames", |ui, label| {
                let number = DragValue::new(&mut self.frames).range(2..=720).speed(0.5);
                ui.add(number).labelled_by(label).on_hover_text("Number of pictures in a full turn");
            });
            row(ui, "Seconds per turn", |ui, label| {
                let number = DragValue::new(&mut self.seconds).range(0.5..=120.0).speed(0.05).max_decimals(1);
                ui.add(number).labelled_by(label).on_hover_text("Duration of a full turn");
            });
            row(ui, "Format", |ui, _| {
                for (format, text, tooltip) in [
                    (AnimationFormat::Gif, "GIF", "One looping file with 256 colours per frame"),
                    (
                        AnimationFormat::Pngs,
                        "PNG pictures",
                        "A folder of numbered full-colour pictures, for example for a video",
                    ),
                ] {
                    ui.radio_value(&mut self.format, format, text).on_hover_text(tooltip);
                }
            });
        }
        row(ui, "", |ui, _| {
            ui.checkbox(&mut choice.transparent, "Transparent background")
                .on_hover_text("Without background and ground grid");
        });
    }

    /// Continues the job, one picture per frame.
    fn advance(&mut self, ctx: &Context, viewport: egui::Rect, actions: &mut Vec<Action>) {
        let (Some(job), Some(studio)) = (&mut self.job, &mut self.studio) else { return };
        if let Some(outcome) = job.advance(studio) {
            self.job = None;
            actions.push(match outcome {
                Ok(path) => Action::Note(format!("Wrote {}", path.display())),
                Err(error) => Action::Tell { what: "The picture could not be saved".to_owned(), error },
            });
            return;
        }
        ctx.request_repaint_after(job::PATIENCE);
        let (done, all) = job.progress();
        let mut is_cancelled = false;
        let card = Area::new(Id::unique("picture progress"))
            .order(egui::Order::Foreground)
            .pivot(Align2::CENTER_TOP)
            .fixed_pos(viewport.center_top() + vec2(0.0, 10.0))
            .show(ctx, |ui| {
                egui::Frame::popup(ui.style()).inner_margin(10.0).show(ui, |ui| {
                    ui.horizontal(|ui| {
                        let text = if all > 1 {
                            format!("Turntable, {done} of {all}")
                        } else {
                            "Rendering the picture".to_owned()
                        };
                        ui.add(Label::new(text));
                        if all > 1 {
                            ui.add(ProgressBar::new(done as f32 / all as f32).desired_width(130.0));
                        }
                        is_cancelled =
                            ui.button("Cancel").on_hover_text("Stop without writing anything").clicked();
                    });
                });
            });
        widgets::keep_clear(ctx, card.response.rect);
        if is_cancelled {
            self.job = None;
        }
    }
}

fn row(ui: &mut Ui, label: &str, show: impl FnOnce(&mut Ui, Id)) {
    ui.horizontal(|ui| {
        ui.set_min_height(theme::ROW);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let id = ui
            .allocate_ui_with_layout(vec2(LABELS, theme::ROW), layout, |ui| {
                ui.set_min_size(vec2(LABELS, theme::ROW));
                ui.label(RichText::new(label).color(Palette::of(ui).weak)).id
            })
            .inner;
        show(ui, id);
    });
}

fn pixels(choice: &Choice, view: [u32; 2]) -> [u32; 2] {
    match choice.size {
        Size::View => view,
        Size::Fixed(width, height) => [width, height],
        Size::Custom => choice.custom,
    }
}

/// Suggested name for the file or folder.
pub(super) fn suggestion(kind: PictureKind, format: AnimationFormat, name: &str) -> String {
    match (kind, format) {
        (PictureKind::Still, _) => format!("{name}-view.png"),
        (PictureKind::Turntable, AnimationFormat::Gif) => format!("{name}-turntable.gif"),
        (PictureKind::Turntable, AnimationFormat::Pngs) => format!("{name}-turntable"),
    }
}

/// The path with the format's extension, unless one was given.
pub(super) fn with_ending(kind: PictureKind, format: AnimationFormat, path: PathBuf) -> PathBuf {
    let ending = match (kind, format) {
        (PictureKind::Still, _) => "png",
        (PictureKind::Turntable, AnimationFormat::Gif) => "gif",
        (PictureKind::Turntable, AnimationFormat::Pngs) => return path,
    };
    if path.extension().is_none() { path.with_extension(ending) } else { path }
}
