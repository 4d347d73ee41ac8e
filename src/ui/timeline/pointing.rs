//! Pointer and key input along the axis.

use egui::{EventFilter, Grid, Key, Label, PointerButton, Response, RichText, Tooltip, Ui};

use super::axis::Axis;
use crate::session::Session;
use crate::session::action::Action;
use crate::session::curves::Curve;
use crate::session::messages;
use crate::session::naming::StateName;
use crate::ui::theme::Palette;
use crate::ui::widgets::{count, length};
use crate::worker::Snapshot;

/// Width of what tells of a state.
const TOOLTIP: f32 = 300.0;

/// A click or a drag shows the state under the pointer; hovering tells of it.
/// The state that is hovered.
pub(super) fn scrub(
    ui: &Ui,
    session: &Session,
    axis: &Axis,
    response: &Response,
    actions: &mut Vec<Action>,
) -> Option<usize> {
    let is_held =
        response.is_pointer_button_down_on() && ui.input(|i| i.pointer.button_down(PointerButton::Primary));
    if (is_held || response.clicked())
        && let Some(pointer) = response.interact_pointer_pos()
    {
        let index = axis.nearest(pointer.x);
        if index != session.timeline.shown_index() {
            actions.push(Action::ShowState(index));
        }
        return Some(index);
    }
    let index = axis.nearest(response.hover_pos()?.x);
    tell(session, response, index);
    Some(index)
}

/// Shows a state's values next to the pointer without delay.
fn tell(session: &Session, response: &Response, index: usize) {
    let states = session.timeline.states();
    let Some(state) = states.get(index) else { return };
    let name = StateName::of(states, index);
    Tooltip::for_widget(response).at_pointer().gap(14.0).width(TOOLTIP).show(|ui| {
        let weak = Palette::of(ui).weak;
        ui.horizontal(|ui| {
            ui.label(RichText::new(name.place()).strong());
            let place = format!("state {} of {}", count(index + 1), count(states.len()));
            ui.label(RichText::new(place).small().color(weak));
        });
        Grid::new("figures of the state").num_columns(2).spacing([14.0, 1.0]).show(ui, |ui| {
            for curve in Curve::ALL {
                ui.label(RichText::new(curve.text()).color(weak));
                ui.label(value_text(session, curve, state));
                ui.end_row();
            }
        });
        if let Some(what) = messages::of_step(state) {
            ui.add_space(2.0);
            ui.add(Label::new(capitalised(&what)).wrap());
        }
    });
}

/// A curve's value as text; estimates are marked.
pub(in crate::ui) fn value_text(session: &Session, curve: Curve, state: &Snapshot) -> String {
    let Some(value) = session.value_of(curve, state) else { return "–".to_owned() };
    match curve {
        Curve::Clusters => count(value as usize),
        Curve::MeanError => length(value),
        Curve::LogJoint => format!("{value:.1}"),
        Curve::Chamfer if session.chamfer_of(state.key).is_some_and(|c| c.is_rough) => {
            format!("≈ {value:.4}")
        }
        Curve::Chamfer => format!("{value:.5}"),
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The index that the keyboard, or a screen reader, moves the focused playhead
/// to.
pub(super) fn keys(ui: &Ui, response: &Response, shown: usize, states: usize) -> Option<usize> {
    let last = states.saturating_sub(1);
    let mut index = shown as i64;
    if response.has_focus() {
        let filter = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
        ui.input(|i| {
            index += i.num_presses(Key::ArrowRight) as i64 - i.num_presses(Key::ArrowLeft) as i64;
            if i.key_pressed(Key::End) {
                index = last as i64;
            }
        });
    }
    ui.input(|i| {
        use egui::accesskit::{Action, ActionData};
        let times = |action| i.num_accesskit_action_requests(response.id, action) as i64;
        index += times(Action::Increment) - times(Action::Decrement);
        for request in i.accesskit_action_requests(response.id, Action::SetValue) {
            if let Some(ActionData::NumericValue(value)) = request.data {
                index = value.round() as i64 - 1;
            }
        }
    });
    let index = index.clamp(0, last as i64) as usize;
    (index != shown).then_some(index)
}

/// Tells a screen reader how far the playhead goes, counted from 1.
pub(super) fn declare(ui: &Ui, response: &Response, shown: usize, states: usize) {
    let value = (shown + 1) as f64;
    response.widget_info(|| egui::WidgetInfo::slider(true, value, "Shown state"));
    ui.ctx().accesskit_node_builder(response.id, |node| {
        use egui::accesskit::Action;
        node.set_min_numeric_value(1.0);
        node.set_max_numeric_value(states.max(1) as f64);
        node.set_numeric_value_step(1.0);
        for action in [Action::SetValue, Action::Increment, Action::Decrement] {
            node.add_action(action);
        }
    });
}
