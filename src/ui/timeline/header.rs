//! The first row of the panel: playback controls, progress, the legend of the marks, and actions on
//! the shown state.

use egui::{Button, ComboBox, Layout, Popup, PopupCloseBehavior, ProgressBar, RichText, Ui};

use super::icons::{Icon, verb_icon};
use super::{lanes, marks};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::comparison::Comparison;
use crate::session::curves::Curve;
use crate::session::playback::Playback;
use crate::session::verb::Verb;
use crate::ui::progress::advance;
use crate::ui::theme::Palette;
use crate::ui::widgets::verb_button;

/// A header narrower than this leaves out what can be had elsewhere.
const NARROW: f32 = 720.0;

pub(super) fn show(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let width = ui.available_width();
    ui.horizontal(|ui| {
        transport(ui, session, actions);
        ui.add_space(4.0);
        progress(ui, session, width);
        ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
            compare_button(ui, session, actions);
            curves_button(ui, session, actions);
            if width >= NARROW {
                verb_button(ui, session, Verb::ContinueHere, 0.0, actions);
            }
            let kinds = lanes::kinds(session);
            if ui.available_width() > marks::legend_width(&kinds) + 20.0 {
                ui.with_layout(Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.add_space(10.0);
                    marks::legend(ui, &kinds);
                });
            }
        });
    });
}

fn transport(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.x = 1.0;
        verb_icon(ui, session, Verb::FirstState, Icon::First, actions);
        verb_icon(ui, session, Verb::PreviousState, Icon::Previous, actions);
        if session.playback.is_playing {
            verb_icon(ui, session, Verb::StopPlaying, Icon::Stop, actions);
        } else {
            verb_icon(ui, session, Verb::Play, Icon::Play, actions);
        }
        verb_icon(ui, session, Verb::NextState, Icon::Next, actions);
        verb_icon(ui, session, Verb::LastState, Icon::Last, actions);
        verb_icon(ui, session, Verb::ToggleLoop, Icon::Loop, actions);
    });
    let speed = |speed: u32| format!("{speed} per second");
    let combo = ComboBox::from_id_salt("play speed")
        .selected_text(format!("{}/s", session.playback.speed()))
        .width(50.0)
        .show_ui(ui, |ui| {
            for choice in Playback::SPEEDS {
                if ui.selectable_label(session.playback.speed() == choice, speed(choice)).clicked() {
                    actions.push(Action::SetPlaySpeed(choice));
                }
            }
        });
    let response = combo.response.on_hover_text("States played per second");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "Play speed"));
}

fn progress(ui: &mut Ui, session: &Session, width: f32) {
    let iteration = session.snapshot.as_ref().map_or(0, |s| s.abstraction.iteration);
    let (done, mut text) = advance(session, iteration);
    text += &session.timeline.shown_name().suffix();
    if width >= NARROW {
        let bar = ProgressBar::new(done.clamp(0.0, 1.0) as f32)
            .desired_width(64.0)
            .desired_height(6.0)
            .fill(Palette::of(ui).accent);
        ui.add(bar).on_hover_text(&text);
    }
    ui.label(text).on_hover_text("The shown state and the number of iterations T of the run");
}

fn curves_button(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let button = ui.button("Curves").on_hover_text("Which values are plotted over the states");
    Popup::menu(&button).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        for curve in Curve::ALL {
            let mut shown = session.curves.shows(curve);
            if ui.checkbox(&mut shown, curve.text()).on_hover_text(curve.tooltip()).clicked() {
                actions.push(Action::SetCurve(curve, shown));
            }
        }
    });
}

fn compare_button(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    if session.comparison.is_some() {
        let button = Button::selectable(true, "Compare");
        if ui.add(button).on_hover_text("Show only one state").clicked() {
            actions.push(Action::Compare(None));
        }
        return;
    }
    let enabled = session.snapshot.is_some();
    let button = ui.add_enabled(enabled, Button::new("Compare"));
    let button = button.on_hover_text("Show another branch or another state next to this one");
    Popup::menu(&button).show(|ui| {
        let weak = Palette::of(ui).weak;
        ui.label(RichText::new("Compare the shown state with").small().color(weak));
        let Some(current) = session.timeline.current() else { return };
        for branch in session.timeline.branches().iter().filter(|b| b.id != current.id) {
            let hint = format!("Its latest state, {}", branch.name_of(usize::MAX));
            if ui.button(&branch.name).on_hover_text(hint).clicked() {
                actions.push(Action::Compare(Some(Comparison::with(branch.id, None))));
            }
        }
        for (text, index) in [("Start of this branch", Some(0)), ("End of this branch", None)] {
            let hint = format!(
                "{}. You can choose another state afterwards",
                current.name_of(index.unwrap_or(usize::MAX))
            );
            if ui.button(text).on_hover_text(hint).clicked() {
                actions.push(Action::Compare(Some(Comparison::with(current.id, index))));
            }
        }
    });
}
