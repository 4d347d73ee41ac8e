//! The help page for keys and mouse, built from the table of actions, and the about page.

use egui::{Align2, Context, Frame, Grid, Label, RichText, TextEdit, Window, vec2};

use super::theme::Palette;
use super::widgets::{dialog_width, scrolling};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::verb::{EVERYWHERE, Group, MOUSE, Verb};

/// Width of a table in logical pixels.
const COLUMN: f32 = 250.0;
/// Height of a window's title and frame, with some air around it.
const AROUND: f32 = 100.0;
const PAPER: &str = "https://arxiv.org/abs/2203.14714";

/// The page of keys.
#[derive(Debug, Default)]
pub(super) struct Help {
    search: String,
}

/// One line: a key and what it does.
type Line = (String, String);

impl Help {
    pub(super) fn show(&mut self, ctx: &Context, session: &Session, actions: &mut Vec<Action>) {
        let mut open = session.view.shows_shortcuts;
        let window = ctx.content_rect();
        // Three tables beside one another where there is room, else two or one.
        let columns = (((window.width() - 60.0) / (COLUMN + 20.0)) as usize).clamp(1, 3);
        let width = (columns as f32 * (COLUMN + 20.0)).min(window.width() - 48.0);
        let frame = Frame::window(&ctx.global_style()).inner_margin(16.0);
        Window::new(Verb::ShowShortcuts.entry().text)
            .open(&mut open)
            .frame(frame)
            .collapsible(false)
            .resizable(false)
            .pivot(Align2::CENTER_CENTER)
            .default_pos(window.center())
            .show(ctx, |ui| {
                ui.set_width(width);
                let field = TextEdit::singleline(&mut self.search).hint_text("Search keys and commands");
                ui.add(field.desired_width(width.min(260.0)));
                ui.add_space(8.0);
                scrolling(ui, window.height() - AROUND - 40.0, |ui| self.tables(ui, columns));
            });
        if open != session.view.shows_shortcuts {
            actions.push(Action::Verb(Verb::ShowShortcuts));
        }
    }

    fn tables(&self, ui: &mut egui::Ui, columns: usize) {
        let wanted = self.search.trim().to_lowercase();
        let fits = |(key, text): &Line| {
            wanted.is_empty() || key.to_lowercase().contains(&wanted) || text.to_lowercase().contains(&wanted)
        };
        let fixed = |rows: &[(&str, &str)]| -> Vec<Line> {
            rows.iter().map(|(key, text)| ((*key).to_owned(), (*text).to_owned())).collect()
        };
        let groups = Group::ALL.map(|group| (group.text(), of_group(group)));
        let all = groups.into_iter().chain([("Mouse", fixed(MOUSE)), ("Everywhere", fixed(EVERYWHERE))]);
        let tables: Vec<(&str, Vec<Line>)> = all
            .map(|(title, lines)| (title, lines.into_iter().filter(fits).collect::<Vec<_>>()))
            .filter(|(_, lines)| !lines.is_empty())
            .collect();
        if tables.is_empty() {
            ui.label(RichText::new("No matching keys").color(Palette::of(ui).weak));
            return;
        }
        // Each table goes below the shortest column so far.
        let mut shared: Vec<Vec<&(&str, Vec<Line>)>> = vec![Vec::new(); columns];
        let height = |column: &[&(&str, Vec<Line>)]| column.iter().map(|t| t.1.len() + 2).sum::<usize>();
        for table in &tables {
            if let Some(shortest) = shared.iter_mut().min_by_key(|column| height(column)) {
                shortest.push(table);
            }
        }
        ui.horizontal_top(|ui| {
            for column in shared {
                ui.vertical(|ui| {
                    ui.set_width(COLUMN.min(ui.available_width()));
                    for (title, lines) in column {
                        table(ui, title, lines);
                    }
                });
                ui.add_space(12.0);
            }
        });
    }
}

/// The verbs of a group that have a key.
fn of_group(group: Group) -> Vec<Line> {
    let verbs = Verb::ALL.iter().filter(|verb| verb.entry().group == group);
    verbs
        .filter_map(|verb| {
            let keys: Vec<String> = verb.shortcuts().map(|shortcut| shortcut.to_string()).collect();
            let text = verb.entry().text.trim_end_matches('…').to_owned();
            (!keys.is_empty()).then(|| (keys.join(", "), text))
        })
        .collect()
}

fn table(ui: &mut egui::Ui, title: &str, lines: &[Line]) {
    ui.label(RichText::new(title).strong());
    let weak = Palette::of(ui).weak;
    let width = ui.available_width();
    Grid::new(title).num_columns(2).min_col_width(92.0).spacing(vec2(10.0, 3.0)).show(ui, |ui| {
        for (key, text) in lines {
            ui.scope(|ui| {
                ui.set_max_width(0.5 * width);
                ui.add(Label::new(RichText::new(key).color(weak)).wrap());
            });
            ui.scope(|ui| {
                ui.set_max_width((width - 102.0).max(60.0));
                ui.add(Label::new(text).wrap());
            });
            ui.end_row();
        }
    });
    ui.add_space(10.0);
}

pub(super) fn about(ctx: &Context, session: &Session, actions: &mut Vec<Action>) {
    let mut open = session.view.shows_about;
    let frame = Frame::window(&ctx.global_style()).inner_margin(16.0);
    Window::new(Verb::ShowAbout.entry().text)
        .open(&mut open)
        .frame(frame)
        .collapsible(false)
        .resizable(false)
        .pivot(Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            ui.set_width(dialog_width(ctx, 380.0));
            scrolling(ui, ctx.content_rect().height() - AROUND, |ui| about_text(ui, actions));
        });
    if open != session.view.shows_about {
        actions.push(Action::Verb(Verb::ShowAbout));
    }
}

fn about_text(ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    ui.heading(concat!("Superform ", env!("CARGO_PKG_VERSION")));
    ui.add(Label::new("Turns a 3D shape into a small number of tapered superquadrics.").wrap());
    ui.add_space(6.0);
    ui.add(
        Label::new(
            "Implements Wu, Liu, Ruan and Chirikjian, Primitive-based Shape Abstraction via Nonparametric \
             Bayesian Inference, ECCV 2022.",
        )
        .wrap(),
    );
    if ui.link("arXiv 2203.14714").on_hover_text(PAPER).clicked() {
        actions.push(Action::OpenLink(PAPER));
    }
    ui.add_space(6.0);
    ui.label(RichText::new("Licence: MIT or Apache-2.0").color(Palette::of(ui).weak));
}
