//! The inspector: the parameters of the selected primitive, and operations on primitives and
//! points.

use egui::{Button, Response, RichText, Sense, Ui, vec2};

use super::theta;
use crate::inference::Primitive;
use crate::session::Session;
use crate::session::action::Action;
use crate::session::verb::Verb;
use crate::ui::theme::{self, Palette};
use crate::ui::widgets::{choice, count, divide, length, verb_button, with_reason};

/// Number of primitives offered for merging.
const NEIGHBORS: usize = 8;
/// Number of ids listed.
const LISTED: usize = 8;

pub(super) fn has_something(session: &Session) -> bool {
    !session.selection.is_empty() || !session.selected_points.is_empty()
}

pub(super) fn show(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let has_primitives = !session.selection.is_empty();
    if let Some(primitive) = session.selected_primitive() {
        one(ui, session, primitive, actions);
    } else if has_primitives {
        several(ui, session, actions);
    }
    if !session.selected_points.is_empty() {
        if has_primitives {
            divide(ui);
        }
        points(ui, session, actions);
    }
}

fn one(ui: &mut Ui, session: &Session, primitive: &Primitive, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        swatch(ui, session, primitive.id);
        ui.label(RichText::new(format!("Primitive {}", primitive.id)).strong());
        let state = if session.is_shaping() {
            "editing"
        } else if primitive.locked {
            "locked"
        } else {
            ""
        };
        ui.label(RichText::new(state).color(Palette::of(ui).weak));
    });
    let text = format!("{} points, mean error {}", count(primitive.points), length(primitive.mean_distance));
    ui.label(RichText::new(text).color(Palette::of(ui).weak))
        .on_hover_text("Samples assigned to it, and their mean distance to its surface, in the file's units");
    ui.add_space(3.0);
    theta::show(ui, session, primitive, actions);
    ui.add_space(3.0);
    handles(ui, session, primitive, actions);
    ui.add_space(5.0);
    buttons(
        ui,
        session,
        &[
            (Verb::RefitSelected, "Refit"),
            (Verb::LockSelected, if primitive.locked { "Unlock" } else { "Lock" }),
            (Verb::SplitSelected, "Split"),
            (Verb::DeleteSelected, "Delete"),
        ],
        actions,
    );
    merge_with(ui, session, primitive, actions);
}

fn several(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let chosen = || session.primitives().iter().filter(|p| session.selection.contains(&p.id));
    ui.label(RichText::new(format!("{} primitives selected", chosen().count())).strong());
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for primitive in chosen().take(LISTED) {
            swatch(ui, session, primitive.id);
            ui.label(primitive.id.to_string());
            ui.add_space(3.0);
        }
        if chosen().count() > LISTED {
            ui.label("…");
        }
    });
    let total: usize = chosen().map(|p| p.points).sum();
    ui.label(RichText::new(format!("{} points", count(total))).color(Palette::of(ui).weak));
    ui.add_space(3.0);
    if session.selection.len() == 2 {
        wide_button(ui, session, Verb::JudgeMerge, actions);
    }
    let all_locked = chosen().all(|p| p.locked);
    buttons(
        ui,
        session,
        &[
            (Verb::MergeSelected, "Merge"),
            (Verb::LockSelected, if all_locked { "Unlock" } else { "Lock" }),
            (Verb::DeleteSelected, "Delete"),
        ],
        actions,
    );
}

fn points(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let n = session.selected_points.len();
    let text = if n == 1 { "1 point selected".to_owned() } else { format!("{} points selected", count(n)) };
    ui.label(RichText::new(text).strong());
    if let Some(snapshot) = &session.snapshot {
        let pinned = &snapshot.abstraction.pinned;
        let held = session.selected_points.iter().filter(|i| pinned.binary_search(i).is_ok()).count();
        if held > 0 {
            let text = format!("{} of them pinned to their primitive", count(held));
            ui.label(RichText::new(text).color(Palette::of(ui).weak));
        }
    }
    ui.add_space(3.0);
    buttons(ui, session, &[(Verb::NewCluster, "New cluster"), (Verb::ReleasePoints, "Unpin")], actions);
    wide_button(ui, session, Verb::BelongTogether, actions);
}

/// Buttons for the handles in the view.
fn handles(ui: &mut Ui, session: &Session, primitive: &Primitive, actions: &mut Vec<Action>) {
    ui.add_enabled_ui(session.why_fixed(primitive).is_none(), |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            let width = (ui.available_width() - 4.0 * 3.0) / 5.0;
            for (verb, text) in [
                (Verb::HandlesMove, "Move"),
                (Verb::HandlesRotate, "Rotate"),
                (Verb::HandlesScale, "Scale"),
                (Verb::HandlesTaper, "Taper"),
                (Verb::HandlesRoundness, "Round"),
            ] {
                let is_on = session.is_on(verb) == Some(true);
                let tooltip = with_reason(session, verb);
                let response = choice(ui, is_on, text, width).on_hover_text(&tooltip);
                if response.on_disabled_hover_text(tooltip).clicked() {
                    actions.push(Action::Verb(verb));
                }
            }
        });
    });
}

fn wide_button(ui: &mut Ui, session: &Session, verb: Verb, actions: &mut Vec<Action>) {
    // In a row the text is in the middle.
    ui.horizontal(|ui| {
        let width = ui.available_width();
        verb_button(ui, session, verb, width, actions);
    });
}

/// Buttons of equal width in a row, with short texts for verbs.
fn buttons(ui: &mut Ui, session: &Session, verbs: &[(Verb, &str)], actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.spacing_mut().button_padding.x = 3.0;
        let gap = ui.spacing().item_spacing.x;
        let count = verbs.len() as f32;
        let width = (ui.available_width() - gap * (count - 1.0)) / count;
        for &(verb, text) in verbs {
            if short_button(ui, session, verb, text, width).clicked() {
                actions.push(Action::Verb(verb));
            }
        }
    });
}

fn short_button(ui: &mut Ui, session: &Session, verb: Verb, text: &str, width: f32) -> Response {
    let tooltip = with_reason(session, verb);
    let button = Button::new(text).min_size(vec2(width, theme::ROW));
    ui.add_enabled(session.is_enabled(verb), button).on_hover_text(&tooltip).on_disabled_hover_text(&tooltip)
}

/// A menu of the nearest other primitives. The chosen merge is tested first.
fn merge_with(ui: &mut Ui, session: &Session, primitive: &Primitive, actions: &mut Vec<Action>) {
    let others = nearest(session, primitive);
    let why =
        session.why_fixed(primitive).or_else(|| others.is_empty().then_some("No other unlocked primitive"));
    ui.add_enabled_ui(why.is_none(), |ui| {
        ui.horizontal(|ui| {
            let width = ui.available_width();
            let button = Button::new("Merge with…").min_size(vec2(width, theme::ROW));
            let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
                for other in others {
                    let row = ui.horizontal(|ui| {
                        swatch(ui, session, other.id);
                        let text = format!("Primitive {}, {} points", other.id, count(other.points));
                        ui.add(Button::new(text).frame(false)).clicked()
                    });
                    if row.inner {
                        actions.push(Action::ProposeMergeOf(primitive.id, other.id));
                        ui.close();
                    }
                }
            });
            response
                .on_hover_text("Choose another primitive and test whether one primitive fits both")
                .on_disabled_hover_text(why.unwrap_or_default());
        });
    });
}

/// Other primitives that can be merged, sorted by distance of their centres.
fn nearest<'a>(session: &'a Session, primitive: &Primitive) -> Vec<&'a Primitive> {
    let distance = |p: &Primitive| (p.shape.translation - primitive.shape.translation).norm();
    let mut others: Vec<&Primitive> =
        session.primitives().iter().filter(|p| p.id != primitive.id && !p.locked).collect();
    others.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.id.cmp(&b.id)));
    others.truncate(NEIGHBORS);
    others
}

/// The colour of a primitive.
pub(in crate::ui) fn swatch(ui: &mut Ui, session: &Session, id: u32) {
    let (rect, _) = ui.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
    ui.painter().rect_filled(rect, 3.0, theme::data_color(session.color_of(id)));
}
