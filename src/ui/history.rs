//! The undo entries of the Edit menu: the next step, and the list of all steps.

use egui::{Button, RichText, ScrollArea, Ui};

use super::theme::Palette;
use super::widgets::{lower_first, with_reason};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::timeline::Timeline;
use crate::session::verb::Verb;

/// Height of the list.
const HEIGHT: f32 = 320.0;

/// Undo and Redo with the names of their steps, and the list of all steps.
pub(super) fn menu(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let (done, undone) = (session.undo.done(), session.undo.undone());
    for (verb, step) in [(Verb::Undo, done.last()), (Verb::Redo, undone.last())] {
        let entry = verb.entry();
        let text = match step {
            Some(step) => format!("{} {}", entry.text, lower_first(&step.label)),
            None => entry.text.to_owned(),
        };
        let mut button = Button::new(text);
        if let Some(shortcut) = entry.shortcut {
            button = button.shortcut_text(shortcut.to_string());
        }
        let response = ui.add_enabled(session.is_enabled(verb), button);
        let text = with_reason(session, verb);
        if response.on_hover_text(&text).on_disabled_hover_text(&text).clicked() {
            actions.push(Action::Verb(verb));
            ui.close();
        }
    }
    let is_empty = done.is_empty() && undone.is_empty();
    ui.add_enabled_ui(!is_empty, |ui| {
        ui.menu_button("History", |ui| list(ui, session, actions));
    });
}

/// All steps, newest first. Clicking one undoes everything after it.
fn list(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let (done, undone) = (session.undo.done(), session.undo.undone());
    let weak = Palette::of(ui).weak;
    ui.set_min_width(180.0);
    ScrollArea::vertical().max_height(HEIGHT).show(ui, |ui| {
        for (index, step) in undone.iter().enumerate() {
            let text = RichText::new(&step.label).color(weak).italics();
            let steps = undone.len() - index;
            let button = Button::new(text).shortcut_text(state_of(&step.document.timeline));
            if ui.add(button).on_hover_text(format!("Redo {}", in_words(steps))).clicked() {
                actions.push(Action::GoOn(steps));
                ui.close();
            }
        }
        for (index, step) in done.iter().enumerate().rev() {
            let steps = done.len() - 1 - index;
            let after = done.get(index + 1).map_or(&session.timeline, |next| &next.document.timeline);
            let button = Button::selectable(steps == 0, &step.label).shortcut_text(state_of(after));
            let response = ui.add(button);
            let hint = if steps == 0 {
                "Last step".to_owned()
            } else {
                format!("Undo the {} steps after it", in_words(steps))
            };
            if response.on_hover_text(hint).clicked() {
                actions.push(Action::GoBack(steps));
                ui.close();
            }
        }
        let text = RichText::new("Beginning").color(weak);
        let response = ui.add(Button::selectable(done.is_empty(), text));
        if response.on_hover_text("Undo all steps").clicked() {
            actions.push(Action::GoBack(done.len()));
            ui.close();
        }
    });
}

fn in_words(steps: usize) -> String {
    if steps == 1 { "step".to_owned() } else { format!("{steps} steps") }
}

/// The state shown at that time, to distinguish steps with the same name.
fn state_of(timeline: &Timeline) -> String {
    if timeline.states().is_empty() { String::new() } else { timeline.shown_name().short() }
}
