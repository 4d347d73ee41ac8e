//! Runs that differ only in their seed, side by side, best first. A click opens one.

use egui::{
    Align, Align2, Button, ComboBox, FontId, Frame, Label, Layout, Margin, Panel, ProgressBar, Rect,
    RichText, Role, ScrollArea, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

use super::theme::{self, Palette};
use super::viewport::Studio;
use super::widgets::{length, verb_button};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::seeds::{SeedOrder, SeedResult};
use crate::session::verb::Verb;
use crate::session::view::ColorBy;

mod thumbnails;

use thumbnails::Thumbnails;

/// Logical pixels.
const CARD: f32 = 132.0;
const TEXT: f32 = 50.0;
/// Least and largest height of a picture.
const PICTURE: (f32, f32) = (60.0, 96.0);

/// The strip along the viewport's lower edge.
#[derive(Debug)]
pub(super) struct SeedStrip {
    thumbnails: Thumbnails,
    /// Renders the thumbnails, if there is a graphics driver.
    studio: Option<Studio>,
}

impl SeedStrip {
    pub(super) fn new(studio: Option<Studio>) -> Self {
        Self { thumbnails: Thumbnails::default(), studio }
    }

    /// Takes its place in a window's layout, where it is open.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
        if !session.view.shows_seeds {
            return;
        }
        if let Some(studio) = &mut self.studio {
            self.thumbnails.advance(ui, session, studio);
        }
        let fill = ui.visuals().panel_fill;
        let frame = Frame::new().fill(fill).inner_margin(Margin::symmetric(12, 6));
        Panel::bottom("seeds").frame(frame).resizable(false).show(ui, |ui| {
            header(ui, session, actions);
            ui.add_space(4.0);
            if session.seeds.wanted() == 0 {
                let text = "Runs with other seeds show how much of a result is due to chance. \
                     They run in the background with the current parameters and samples.";
                ui.add(Label::new(RichText::new(text).color(Palette::of(ui).weak)).wrap());
            } else {
                self.cards(ui, session, actions);
            }
        });
    }

    fn cards(&self, ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
        let (least, most) = PICTURE;
        let picture = (0.11 * ui.ctx().content_rect().height()).clamp(least, most);
        let height = picture + TEXT;
        ScrollArea::horizontal().auto_shrink([false, true]).show(ui, |ui| {
            ui.set_min_height(height + 2.0);
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 8.0;
                let results = session.seeds.sorted();
                for (place, result) in results.iter().enumerate() {
                    let is_best = place == 0 && session.seeds.order == SeedOrder::Error && results.len() > 1;
                    self.card(ui, session, result, vec2(CARD, height), is_best, actions);
                }
                let missing = session.seeds.wanted().saturating_sub(results.len());
                if session.seeds.is_running() {
                    for i in 0..missing {
                        let share = session.seeds.progress().filter(|_| i == 0);
                        pending(ui, share, vec2(CARD, height));
                    }
                }
            });
        });
    }

    fn card(
        &self,
        ui: &mut Ui,
        session: &Session,
        result: &SeedResult,
        size: egui::Vec2,
        is_best: bool,
        actions: &mut Vec<Action>,
    ) {
        let Some(last) = result.last() else { return };
        let seed = result.run.seed;
        let is_shown = session.snapshot.as_ref().is_some_and(|s| s.key == last.key);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let (k, time) = (result.primitives(), format!("{:.2} s", last.elapsed.as_secs_f64()));
        let error = match result.chamfer() {
            Some(chamfer) => format!("Chamfer {chamfer:.5}"),
            None => format!("error {}", length(result.mean_distance())),
        };
        let label = format!("Seed {seed}: K {k}, {error}, {time}");
        response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_shown, &label));
        if response.clicked() {
            actions.push(Action::TakeSeed(seed));
        }
        if response.has_focus() {
            response.scroll_to_me(None);
        }
        if ui.is_rect_visible(rect) {
            let palette = Palette::of(ui);
            let visuals = ui.style().interact_selectable(&response, is_shown);
            let painter = ui.painter();
            painter.rect_filled(rect, 5.0, ui.visuals().extreme_bg_color);
            let picture = Rect::from_min_size(rect.min, vec2(size.x, size.y - TEXT));
            self.thumbnails.paint(painter, last.key, picture);
            let stroke = if is_shown {
                Stroke::new(2.0, palette.accent)
            } else if response.hovered() || response.has_focus() {
                Stroke::new(1.0, visuals.text_color())
            } else {
                ui.visuals().widgets.noninteractive.bg_stroke
            };
            painter.rect_stroke(rect, 5.0, stroke, StrokeKind::Inside);
            let line = |row: f32| pos2(rect.left() + 8.0, picture.bottom() + 11.0 + 15.0 * row);
            let right = |row: f32| pos2(rect.right() - 8.0, picture.bottom() + 11.0 + 15.0 * row);
            let (text, font) = (ui.visuals().text_color(), FontId::proportional(12.0));
            let small = FontId::proportional(11.0);
            painter.text(line(0.0), Align2::LEFT_CENTER, format!("Seed {seed}"), font.clone(), text);
            painter.text(right(0.0), Align2::RIGHT_CENTER, format!("K {k}"), font, text);
            painter.text(line(1.0), Align2::LEFT_CENTER, &error, small.clone(), palette.weak);
            painter.text(line(2.0), Align2::LEFT_CENTER, &time, small.clone(), palette.weak);
            if is_best {
                painter.text(right(2.0), Align2::RIGHT_CENTER, "best", small, palette.good);
            }
        }
        let how = match result.measurement.as_ref().map(|m| &m.result) {
            Some(Ok(_)) => {
                "Chamfer-L1 is in units of the longest edge of the input's bounding box".to_owned()
            }
            Some(Err(why)) => {
                format!("Not measured: {why}. The error is the mean distance, in the file's units")
            }
            None => {
                "The error is the mean distance, in the file's units. Chamfer-L1 is being measured".to_owned()
            }
        };
        response.on_hover_text(format!("Click to open this run as a branch.\n{how}"));
    }
}

/// The card of a run still to come, with its progress.
fn pending(ui: &mut Ui, progress: Option<(u64, f32)>, size: egui::Vec2) {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let palette = Palette::of(ui);
    let stroke = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter().rect_stroke(rect, 5.0, stroke, StrokeKind::Inside);
    let Some((seed, share)) = progress else { return };
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("Running seed {seed}")));
    let font = FontId::proportional(12.0);
    ui.painter().text(
        rect.center() - vec2(0.0, 10.0),
        Align2::CENTER_CENTER,
        format!("Seed {seed}"),
        font,
        palette.weak,
    );
    let track = Rect::from_center_size(rect.center() + vec2(0.0, 8.0), vec2(size.x - 40.0, 4.0));
    ui.painter().rect_filled(track, 2.0, ui.visuals().extreme_bg_color);
    let mut done = track;
    done.set_width(track.width() * share);
    ui.painter().rect_filled(done, 2.0, palette.accent);
}

fn header(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let seeds = &session.seeds;
    let palette = Palette::of(ui);
    ui.horizontal(|ui| {
        ui.label(RichText::new("Seeds").strong());
        if seeds.is_running() {
            let bar =
                ProgressBar::new(seeds.share()).desired_width(80.0).desired_height(6.0).fill(palette.accent);
            ui.add(bar);
        }
        if let Some(text) = status(session) {
            ui.label(RichText::new(text).small().color(palette.weak));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let close = ui.add(Button::new("×").frame(false)).accessible_name("Close seeds");
            if close.on_hover_text("Close this panel; the runs are kept").clicked() {
                actions.push(Action::Verb(Verb::ShowSeeds));
            }
            let verb = if seeds.is_running() { Verb::StopSeeds } else { Verb::RunSeeds };
            verb_button(ui, session, verb, 0.0, actions);
            if seeds.wanted() > 0 {
                order(ui, session, actions);
                paint(ui, session, actions);
            }
        });
    });
}

fn status(session: &Session) -> Option<String> {
    let seeds = &session.seeds;
    let (done, wanted) = (seeds.results().len(), seeds.wanted());
    let measured = seeds.results().iter().filter(|r| r.measurement.is_some()).count();
    match (seeds.is_running(), wanted) {
        (_, 0) => None,
        (true, _) if done < wanted => Some(format!("{done} of {wanted}")),
        (true, _) => Some(format!("{measured} of {wanted} measured")),
        (false, _) if done < wanted => Some(format!("stopped after {done} of {wanted}")),
        (false, _) => {
            let k: Vec<usize> = seeds.results().iter().map(SeedResult::primitives).collect();
            let (least, most) = (k.iter().min()?, k.iter().max()?);
            Some(if least == most {
                format!("K {least} in all runs")
            } else {
                format!("K {least} to {most}")
            })
        }
    }
}

fn order(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let present = session.seeds.order;
    let combo = ComboBox::from_id_salt("order of the seeds")
        .selected_text(present.text())
        .width(104.0)
        .show_ui(ui, |ui| {
            for order in SeedOrder::ALL {
                let item = ui.selectable_label(order == present, order.text()).on_hover_text(order.tooltip());
                if item.clicked() {
                    actions.push(Action::SetSeedOrder(order));
                }
            }
        });
    combo.response.accessible_name("Sort seeds by").on_hover_text(present.tooltip());
}

/// Switches point colours to the disagreement of the runs, and back.
fn paint(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let on = session.view.color_by == ColorBy::SeedUncertainty;
    let button = Button::selectable(on, "Paint disagreement")
        .min_size(vec2(0.0, theme::ROW))
        .frame_when_inactive(true);
    if ui.add(button).on_hover_text(ColorBy::SeedUncertainty.tooltip()).clicked() {
        actions.push(Action::SetColorBy(if on { ColorBy::Cluster } else { ColorBy::SeedUncertainty }));
    }
}
