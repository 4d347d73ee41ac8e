//! The odds of a point: what the next sweep would draw its table from, the paper's two equations
//! with the numbers filled in, and its labels so far.

use std::sync::Arc;

use egui::{Align2, Context, Id, Label, Rect, RichText, Ui, Window, vec2};

use super::background::Background;
use super::theme::Palette;
use super::widgets::{count, keep_clear, length};
use crate::inference::{Explanation, Held, Odds, explain};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::verb::Verb;
use crate::worker::{LoadedShape, Snapshot};

mod equation;
mod rows;
mod strip;

use rows::{Row, Table};

/// Width of the card in logical pixels.
const WIDTH: f32 = 384.0;
/// Number of tables that are always shown.
const FEW: usize = 5;
/// Maximum number of samples for which the odds are computed within a frame.
const QUICK: usize = 300_000;

/// The state, the samples and the one among them.
#[derive(Debug, Clone)]
struct Key {
    shape: Arc<LoadedShape>,
    state: u64,
    sample: u32,
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.shape, &other.shape) && (self.state, self.sample) == (other.state, other.sample)
    }
}

/// State of the card.
#[derive(Debug, Default)]
pub(super) struct OddsCard {
    found: Background<Key, Option<Explanation>>,
    /// The table whose terms are shown; the likeliest if none is chosen.
    chosen: Option<Table>,
    shows_all: bool,
}

impl OddsCard {
    pub(super) fn show(
        &mut self,
        ctx: &Context,
        session: &Session,
        viewport: Rect,
        actions: &mut Vec<Action>,
    ) {
        let (Some(sample), true) = (session.explained, session.view.shows_odds) else { return };
        let (Some(loaded), Some(snapshot)) = (&session.loaded, &session.snapshot) else { return };
        let mut open = true;
        let card = Window::new(format!("Point {}", count(sample as usize)))
            .id(Id::unique("odds of a point"))
            .open(&mut open)
            .resizable(false)
            .collapsible(true)
            .constrain_to(viewport)
            .pivot(Align2::LEFT_TOP)
            .default_pos(viewport.left_top() + vec2(10.0, 10.0))
            .show(ctx, |ui| {
                ui.set_width(WIDTH.min(viewport.width() - 40.0));
                self.contents(ui, session, loaded, snapshot, sample, actions);
            });
        if let Some(card) = card {
            keep_clear(ctx, card.response.rect);
        }
        if !open {
            actions.push(Action::Verb(Verb::ShowOdds));
        }
    }

    fn contents(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        loaded: &Arc<LoadedShape>,
        snapshot: &Arc<Snapshot>,
        sample: u32,
        actions: &mut Vec<Action>,
    ) {
        let weak = Palette::of(ui).weak;
        let key = Key { shape: Arc::clone(loaded), state: snapshot.key, sample };
        let work = {
            let (loaded, checkpoint) = (Arc::clone(loaded), Arc::clone(&snapshot.checkpoint));
            move || explain(&loaded.cloud.points, &checkpoint, sample)
        };
        let window = (loaded.cloud.points.len() > QUICK).then(|| ui.ctx().clone());
        let found = self.found.get(&key, window.as_ref(), work);
        let found = found.filter(|(of, _)| of.sample == sample && Arc::ptr_eq(&of.shape, loaded));
        let Some(explanation) = found.map(|(_, found)| Arc::clone(found)) else {
            ui.label(RichText::new("Computing…").color(weak));
            return;
        };
        let Some(explanation) = &*explanation else {
            let text = "Only the sampler draws labels. The method of this run assigns points by other rules.";
            ui.add(Label::new(RichText::new(text).color(weak)).wrap());
            strip::show(ui, session, sample, actions);
            return;
        };
        place(ui, session, loaded, explanation);
        ui.add_space(4.0);
        let mut present: Vec<&Odds> = explanation.tables.iter().collect();
        present.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let few = if self.shows_all { present.len() } else { FEW.min(present.len()) };
        let (first, rest) = present.split_at(few);
        let new = Row::New(&explanation.new);
        let likeliest = first.first().map_or(new, |odds| Row::Present(odds));
        let likeliest = if likeliest.probability() < new.probability() { new } else { likeliest };
        let chosen = self.chosen.and_then(|table| row_of(explanation, table)).unwrap_or(likeliest);

        rows::header(ui);
        for odds in first {
            self.row(ui, session, Row::Present(odds), chosen);
        }
        if !rest.is_empty() || self.shows_all && present.len() > FEW {
            self.fold(ui, rest);
        }
        self.row(ui, session, new, chosen);
        ui.add_space(6.0);
        equation::show(ui, session, explanation, chosen);
        ui.add_space(6.0);
        strip::show(ui, session, sample, actions);
    }

    fn row(&mut self, ui: &mut Ui, session: &Session, row: Row<'_>, chosen: Row<'_>) {
        let is_chosen = row.table() == chosen.table();
        if rows::show(ui, session, row, is_chosen).clicked() {
            self.chosen = if is_chosen { None } else { Some(row.table()) };
        }
    }

    /// Hides or shows the least likely tables.
    fn fold(&mut self, ui: &mut Ui, rest: &[&Odds]) {
        let text = if self.shows_all {
            "Show fewer".to_owned()
        } else {
            let together: f64 = rest.iter().map(|odds| odds.probability).sum();
            format!("{} more, together {}", count(rest.len()), rows::percent(together))
        };
        let weak = Palette::of(ui).weak;
        let button = egui::Button::new(RichText::new(text).small().color(weak)).frame(false);
        if ui.add(button).on_hover_text("Show or hide the least likely tables").clicked() {
            self.shows_all = !self.shows_all;
        }
    }
}

fn row_of(explanation: &Explanation, table: Table) -> Option<Row<'_>> {
    match table {
        Table::New => Some(Row::New(&explanation.new)),
        Table::Present(id) => explanation.tables.iter().find(|odds| odds.id == id).map(Row::Present),
    }
}

/// Position and primitive of the point.
fn place(ui: &mut Ui, session: &Session, loaded: &LoadedShape, explanation: &Explanation) {
    let weak = Palette::of(ui).weak;
    if let Some(p) = loaded.cloud.points.get(explanation.sample as usize) {
        let text = format!("at {}, {}, {}", length(p.x), length(p.y), length(p.z));
        ui.label(RichText::new(text).small().color(weak)).on_hover_text("x, y and z in the file's units");
    }
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        match explanation.present {
            Some(id) => {
                rows::swatch(ui, session.color_of(id));
                ui.label(format!("Assigned to primitive {id}"));
            }
            None => {
                ui.label("Unassigned");
            }
        }
    });
    if let Some(held) = explanation.held {
        let text = match held {
            Held::Locked => "The sweep skips this point: its primitive is locked.",
            Held::Pinned => "The sweep skips this point: it is pinned to its primitive.",
            Held::Frozen => "The sweep skips this point: it is frozen, because its primitive fits well.",
        };
        ui.add(Label::new(RichText::new(text).small().color(Palette::of(ui).accent)).wrap());
    }
}
