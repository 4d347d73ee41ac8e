//! The branches: their names, and next to each its states with their events. Each lane starts at
//! its parent.

use std::collections::BTreeSet;

use egui::{
    Atom, Button, Color32, Grid, Key, Label, Popup, PopupCloseBehavior, Rect, RichText, Sense, Shape, Stroke,
    TextEdit, Tooltip, Ui, pos2, vec2,
};

use super::axis::Axis;
use super::icons::{self, Icon};
use super::pointing::{self, value_text};
use super::{marks, plots};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::comparison::Comparison;
use crate::session::curves::Curve;
use crate::session::timeline::{Branch, Mark};
use crate::ui::theme::{self, Palette};
use crate::ui::widgets::{count, lower_first, within};

/// Height of a branch that is not shown, and of the line of the one that is.
const LANE: f32 = theme::ROW;
/// Height of a row of marks.
const MARKS: f32 = 9.0;
/// Height of a plot that can do without more.
const PLOT: f32 = 90.0;
/// Least distance of two marks of a kind that are both drawn.
const CLOSEST: f32 = 5.0;

/// Events in the shown branch, each kind once.
pub(super) fn kinds(session: &Session) -> BTreeSet<Mark> {
    session.timeline.states().iter().flat_map(|s| Mark::of(s)).collect()
}

/// How plots and lanes share a height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shares {
    /// Plots that are shown, and the height that they have together.
    pub(super) plots: usize,
    pub(super) plots_height: f32,
    /// What the lanes are high, and how much of that is seen at once.
    pub(super) lanes_height: f32,
    pub(super) lanes_seen: f32,
    /// Rows of marks, below the line of the shown lane; where there are fewer than kinds, some
    /// share one.
    pub(super) rows: usize,
}

impl Shares {
    /// Of so many wanted plots, branches and kinds of marks. A branch or a mark
    /// more never takes a plot away: they are first set closer, then scroll.
    pub(super) fn of(room: f32, wanted: usize, branches: usize, kinds: usize) -> Self {
        let high = |branches: usize, rows: usize| LANE * branches as f32 + MARKS * rows as f32;
        let least = high(1, 1);
        let plots = (((room - least) / plots::LEAST).max(0.0) as usize).min(wanted);
        let most = if plots == 0 {
            room
        } else {
            let generous = (0.5 * room).max(room - plots as f32 * PLOT);
            generous.min(room - plots as f32 * plots::LEAST).max(least)
        };
        let rows = (1..=kinds).rev().find(|rows| high(branches, *rows) <= most).unwrap_or(kinds.min(1));
        let lanes_height = high(branches, rows);
        // Whole lanes are seen.
        let whole = (1..=branches).rev().find(|n| high(*n, rows) <= most).unwrap_or(1);
        let lanes_seen = high(whole, rows).min(room.max(0.0));
        let plots_height = if plots == 0 { 0.0 } else { room - lanes_seen };
        Self { plots, plots_height, lanes_height, lanes_seen, rows }
    }
}

/// A branch being renamed.
#[derive(Debug)]
struct Renaming {
    id: u32,
    text: String,
    is_new: bool,
}

impl Renaming {
    fn of(branch: &Branch) -> Self {
        Self { id: branch.id, text: branch.name.clone(), is_new: true }
    }
}

/// State of the lanes outside the session.
#[derive(Debug, Default)]
pub(super) struct Lanes {
    renaming: Option<Renaming>,
    /// The branch whose lane was brought into view last, and of how many.
    brought: Option<(u32, usize)>,
}

impl Lanes {
    /// All lanes, from the top of `rect` on; the hovered state of the shown
    /// branch.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        rect: Rect,
        axis: &Axis,
        mark_rows: usize,
        actions: &mut Vec<Action>,
    ) -> Option<usize> {
        let kinds: Vec<Mark> = kinds(session).into_iter().collect();
        let current = session.timeline.current_index();
        let mut top = rect.min.y;
        let rows: Vec<Rect> = (0..session.timeline.branches().len())
            .map(|index| {
                let marks = if index == current { MARKS * mark_rows as f32 } else { 0.0 };
                let row = Rect::from_min_size(pos2(rect.min.x, top), vec2(rect.width(), LANE + marks));
                top = row.max.y;
                row
            })
            .collect();
        let shown = session.timeline.current().map(|b| (b.id, rows.len()));
        if let (true, Some(row)) = (self.brought != shown, rows.get(current)) {
            self.brought = shown;
            ui.scroll_to_rect(*row, None);
        }
        connectors(ui, session, &rows, axis);
        let mut hovered = None;
        for (index, (branch, row)) in session.timeline.branches().iter().zip(&rows).enumerate() {
            let is_shown = index == session.timeline.current_index();
            let split = axis.range().min;
            self.name(
                ui,
                session,
                branch,
                Rect::from_min_max(row.min, pos2(split - 6.0, row.min.y + LANE)),
                actions,
            );
            let track = Rect::from_min_max(pos2(split, row.min.y), pos2(axis.range().max, row.max.y));
            let response =
                ui.interact(track, ui.scope_id().with(("lane", branch.id)), Sense::click_and_drag());
            let label = format!("States of {}", branch.name);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &label));
            if is_shown {
                shown_lane(ui, session, branch, track, axis, (&kinds, mark_rows));
                hovered = hovered.or(pointing::scrub(ui, session, axis, &response, actions));
            } else {
                other_lane(ui, branch, track, axis);
                if let (true, Some(pointer)) = (response.clicked(), response.interact_pointer_pos()) {
                    let state = axis.nearest_of(pointer.x, branch.states.len());
                    actions.push(Action::ShowStateOf(branch.id, state));
                } else if response.hovered() {
                    Tooltip::for_widget(&response)
                        .at_pointer()
                        .gap(14.0)
                        .show(|ui| about(ui, session, branch));
                }
            }
        }
        hovered
    }

    fn name(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        branch: &Branch,
        rect: Rect,
        actions: &mut Vec<Action>,
    ) {
        let layout = egui::Layout::right_to_left(egui::Align::Center);
        within(ui, rect, |ui| {
            ui.with_layout(layout, |ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                if let Some(renaming) = self.renaming.as_mut().filter(|r| r.id == branch.id) {
                    if edit_name(ui, renaming, actions) {
                        self.renaming = None;
                    }
                    return;
                }
                let more = icons::button(ui, Icon::More, &format!("More about {}", branch.name), None);
                let menu = Popup::menu(&more).close_behavior(PopupCloseBehavior::CloseOnClick);
                menu.show(|ui| self.menu(ui, session, branch, actions));
                let more = more.on_hover_text("Rename, compare or remove this branch");
                ui.with_layout(
                    egui::Layout::left_to_right(egui::Align::Center).with_cross_justify(true),
                    |ui| {
                        let is_shown = session.timeline.current().is_some_and(|b| b.id == branch.id);
                        let text = RichText::new(&branch.name);
                        let text = if is_shown { text.strong() } else { text };
                        // What grows pushes the name to the left.
                        let button = Button::selectable(is_shown, (text, Atom::grow()));
                        let button = button.truncate().min_size(vec2(ui.available_width(), theme::ROW - 2.0));
                        let response = ui.add(button);
                        if response.double_clicked() {
                            self.renaming = Some(Renaming::of(branch));
                        } else if response.clicked() && !is_shown {
                            actions.push(Action::SwitchBranch(branch.id));
                        }
                        Popup::context_menu(&response).show(|ui| self.menu(ui, session, branch, actions));
                        if !Popup::is_id_open(ui.ctx(), Popup::default_response_id(&more)) {
                            response.on_hover_ui(|ui| {
                                about(ui, session, branch);
                                let hint = if is_shown {
                                    "Double-click to rename"
                                } else {
                                    "Click to show this branch"
                                };
                                ui.label(RichText::new(hint).small().color(Palette::of(ui).weak));
                            });
                        }
                    },
                );
            });
        });
    }

    fn menu(&mut self, ui: &mut Ui, session: &Session, branch: &Branch, actions: &mut Vec<Action>) {
        if ui.button("Rename").on_hover_text("Rename this branch").clicked() {
            self.renaming = Some(Renaming::of(branch));
        }
        let is_shown = session.timeline.current().is_some_and(|b| b.id == branch.id);
        let (text, index) = if is_shown { ("Compare with its start", Some(0)) } else { ("Compare", None) };
        if ui.button(text).on_hover_text("Show that state next to this one").clicked() {
            actions.push(Action::Compare(Some(Comparison::with(branch.id, index))));
        }
        ui.separator();
        let is_last = session.timeline.branches().len() < 2;
        let remove = ui.add_enabled(!is_last, Button::new("Remove"));
        let remove = remove.on_hover_text("Remove this branch and its states. Undo restores it");
        if remove.on_disabled_hover_text("The last branch can't be removed").clicked() {
            actions.push(Action::RemoveBranch(branch.id));
        }
    }
}

/// The field for the new name; returns whether editing is finished.
fn edit_name(ui: &mut Ui, renaming: &mut Renaming, actions: &mut Vec<Action>) -> bool {
    let field = TextEdit::singleline(&mut renaming.text).desired_width(ui.available_width() - 8.0);
    let field = ui.add(field);
    field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Branch name"));
    if std::mem::take(&mut renaming.is_new) {
        field.request_focus();
        return false;
    }
    if !field.lost_focus() {
        return false;
    }
    if !ui.input(|i| i.key_pressed(Key::Escape)) {
        actions.push(Action::RenameBranch(renaming.id, renaming.text.clone()));
    }
    true
}

/// Summary of a branch.
fn about(ui: &mut Ui, session: &Session, branch: &Branch) {
    let weak = Palette::of(ui).weak;
    ui.label(RichText::new(&branch.name).strong());
    let origin = match branch.origin {
        Some(origin) => {
            let parent = session.timeline.branch(origin.branch);
            let name = parent.map_or("a removed branch", |b| &b.name);
            let at = branch.name_of(origin.index).to_string();
            format!("Branched from {name} at {}", lower_first(&at))
        }
        None => "Began with a new run".to_owned(),
    };
    let by_hand = if branch.is_manual() { ", with manual edits" } else { "" };
    let states = if branch.states.len() == 1 { "state" } else { "states" };
    ui.add(Label::new(format!("{origin}; {} {states}{by_hand}", count(branch.states.len()))).wrap());
    let Some(last) = branch.states.last() else { return };
    Grid::new(("about", branch.id)).num_columns(2).spacing([14.0, 1.0]).show(ui, |ui| {
        ui.label(RichText::new("Latest state").color(weak));
        ui.label(branch.name_of(usize::MAX).to_string());
        ui.end_row();
        for curve in Curve::ALL {
            ui.label(RichText::new(curve.text()).color(weak));
            ui.label(value_text(session, curve, last));
            ui.end_row();
        }
    });
}

/// From each branch's origin to its own lane.
fn connectors(ui: &Ui, session: &Session, rows: &[Rect], axis: &Axis) {
    let branches = session.timeline.branches();
    let lane_y = |row: &Rect| row.min.y + 0.5 * LANE;
    for (index, branch) in branches.iter().enumerate() {
        let Some(mut origin) = branch.origin else { continue };
        let index_left = origin.index;
        // Where the states at the origin are themselves shared, the line comes
        // from whoever drew them.
        while let Some(parent) = session.timeline.branch(origin.branch)
            && let Some(earlier) = parent.origin.filter(|o| index_left <= o.index)
        {
            origin = earlier;
        }
        let Some(parent) = branches.iter().position(|b| b.id == origin.branch) else { continue };
        let (from, to) = (pos2(axis.x(index_left), lane_y(&rows[parent])), lane_y(&rows[index]));
        let width = axis.spacing().clamp(6.0, 16.0);
        let end = pos2(from.x + width, to);
        let curve = egui::epaint::CubicBezierShape::from_points_stroke(
            [from, pos2(from.x, to), pos2(from.x, to), end],
            false,
            Color32::TRANSPARENT,
            Stroke::new(1.5, lane_color(ui, index == session.timeline.current_index())),
        );
        ui.painter().add(Shape::CubicBezier(curve));
    }
}

fn lane_color(ui: &Ui, is_shown: bool) -> Color32 {
    let palette = Palette::of(ui);
    if is_shown { palette.accent } else { palette.weak.gamma_multiply(0.8) }
}

/// Where the branch's own states begin on its lane.
fn own_start(branch: &Branch, axis: &Axis) -> f32 {
    match branch.origin {
        Some(origin) => axis.x(origin.index) + axis.spacing().clamp(6.0, 16.0),
        None => axis.x(0),
    }
}

fn line_and_dots(ui: &Ui, branch: &Branch, track: Rect, axis: &Axis, is_shown: bool) {
    let painter = ui.painter();
    let y = track.min.y + 0.5 * LANE;
    let color = lane_color(ui, is_shown);
    let last = branch.states.len().saturating_sub(1);
    let from = own_start(branch, axis);
    painter.hline(
        from.min(axis.x(last))..=axis.x(last),
        y,
        Stroke::new(if is_shown { 2.0 } else { 1.5 }, color),
    );
    let own = branch.origin.map_or(0, |o| o.index + 1);
    if axis.spacing() >= 6.0 {
        for index in own..=last {
            painter.circle_filled(pos2(axis.x(index), y), 2.0, color);
        }
    }
    painter.circle_filled(pos2(axis.x(last), y), 3.4, color);
}

fn other_lane(ui: &Ui, branch: &Branch, track: Rect, axis: &Axis) {
    line_and_dots(ui, branch, track, axis, false);
    let own = branch.origin.map_or(0, |o| o.index + 1);
    for (index, state) in branch.states.iter().enumerate().skip(own) {
        if state.cause.is_manual() {
            let at = pos2(axis.x(index), track.min.y + 0.5 * LANE - 6.0);
            marks::paint(ui.painter(), at, 2.6, Mark::Edit, marks::color(ui, Mark::Edit));
        }
    }
}

/// The line with rows of marks under it, as far as there are any one for each kind.
fn shown_lane(
    ui: &Ui,
    session: &Session,
    branch: &Branch,
    track: Rect,
    axis: &Axis,
    (kinds, rows): (&[Mark], usize),
) {
    if let Some(origin) = branch.origin {
        // The states that it shares with where it came from.
        let y = track.min.y + 0.5 * LANE;
        let faint = Stroke::new(1.0, lane_color(ui, true).gamma_multiply(0.45));
        ui.painter().hline(axis.x(0)..=axis.x(origin.index), y, faint);
    }
    line_and_dots(ui, branch, track, axis, true);
    let x = axis.x(session.timeline.shown_index());
    ui.painter().circle_filled(pos2(x, track.min.y + 0.5 * LANE), 4.6, lane_color(ui, true));
    // Where kinds share a row, the rarer ones come last and are on top.
    for (k, &mark) in kinds.iter().enumerate() {
        let row = k * rows / kinds.len();
        let y = track.min.y + LANE + MARKS * (row as f32 + 0.4);
        let color = marks::color(ui, mark);
        let mut last = f32::NEG_INFINITY;
        for (index, state) in branch.states.iter().enumerate() {
            let at = pos2(axis.x(index), y);
            if at.x - last >= CLOSEST && Mark::of(state).contains(&mark) {
                marks::paint(ui.painter(), at, 3.2, mark, color);
                last = at.x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_branch_more_takes_no_curve_away_and_nothing_is_cut() {
        for room in (0..60).map(|i| 10.0 * i as f32) {
            for wanted in 0..=4 {
                for kinds in 0..=6 {
                    let one = Shares::of(room, wanted, 1, 0);
                    for branches in 1..=9 {
                        let shares = Shares::of(room, wanted, branches, kinds);
                        assert_eq!(shares.plots, one.plots, "{room} {wanted} {branches} {kinds}");
                        let sum = shares.plots_height + shares.lanes_seen;
                        assert!(sum <= room + 0.01, "{room}: {shares:?}");
                        assert!(shares.plots_height >= plots::LEAST * shares.plots as f32 - 0.01);
                        assert!(shares.rows <= kinds && (shares.rows > 0) == (kinds > 0));
                        let hidden = (shares.lanes_height - shares.lanes_seen) / LANE;
                        let is_whole = (hidden - hidden.round()).abs() < 1e-3;
                        assert!(is_whole || shares.plots == 0, "{room}: {shares:?}");
                    }
                }
            }
        }
    }
}
