//! Dialogs about sessions: recovery and unsaved changes.

use std::time::SystemTime;

use egui::{Context, Frame, Label, Modal, RichText, Ui};

use super::theme::{self, Palette};
use super::widgets::{dialog_body, dialog_width};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::saving::{Found, Opening, Parting, PartingAnswer, ago};

/// Width of a question, in logical pixels.
const WIDTH: f32 = 440.0;
/// Height of the buttons below.
const BUTTONS: f32 = theme::ROW + 16.0;

pub(super) fn show(ctx: &Context, session: &Session, actions: &mut Vec<Action>) {
    if let Some(parting) = session.saving.parting() {
        about_unsaved(ctx, parting, actions);
    } else if !session.saving.found().is_empty() {
        about_found(ctx, session.saving.found(), actions);
    }
}

/// Sessions of windows that did not close properly.
fn about_found(ctx: &Context, found: &[Found], actions: &mut Vec<Action>) {
    let response = modal("left behind").frame(frame(ctx)).show(ctx, |ui| {
        ui.set_width(dialog_width(ctx, WIDTH));
        ui.heading(if found.len() == 1 { "Recover the last session?" } else { "Recover a session?" });
        ui.add_space(4.0);
        let now = SystemTime::now();
        dialog_body(ui, BUTTONS, |ui| {
            weak(ui, "Superform did not close properly. At most the last step was lost.");
            ui.add_space(8.0);
            for session in found {
                row(ui, session, now, actions);
            }
        });
        ui.add_space(8.0);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let later = ui
                .button("Later")
                .on_hover_text("Continue without it; it is offered again at the next start");
            if later.clicked() {
                actions.push(Action::PutOffFound);
            }
        });
    });
    if response.should_close() {
        actions.push(Action::PutOffFound);
    }
}

/// One session with its buttons.
fn row(ui: &mut Ui, session: &Found, now: SystemTime, actions: &mut Vec<Action>) {
    Frame::group(ui.style()).inner_margin(10.0).show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.add(Label::new(RichText::new(session.summary.to_string()).strong()).wrap());
        let steps = match session.summary.steps {
            0 => String::new(),
            1 => ", 1 step to undo".to_owned(),
            steps => format!(", {steps} steps to undo"),
        };
        weak(ui, &format!("Kept {}{steps}", ago(session.kept_at, now)));
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let recover = ui.button("Recover").on_hover_text("Open it as it was, with history and branches");
            if recover.clicked() {
                actions.push(Action::OpenSession(Opening::Recovered(session.id)));
            }
            let discard = ui.button("Discard").on_hover_text("Delete it permanently");
            if discard.clicked() {
                actions.push(Action::DiscardFound(session.id));
            }
        });
    });
    ui.add_space(4.0);
}

/// Unsaved work that would be lost because there is no journal.
fn about_unsaved(ctx: &Context, parting: &Parting, actions: &mut Vec<Action>) {
    let (heading, discard) = match parting {
        Parting::Quit => ("Save the session before quitting?", "Quit without saving"),
        Parting::Open(_) => ("Save the session before opening another?", "Open without saving"),
    };
    let response = modal("unsaved work").frame(frame(ctx)).show(ctx, |ui| {
        ui.set_width(dialog_width(ctx, WIDTH));
        ui.heading(heading);
        ui.add_space(4.0);
        dialog_body(ui, BUTTONS, |ui| {
            weak(ui, "The session has unsaved changes, and the recovery journal could not be written.");
        });
        ui.add_space(10.0);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center).with_main_wrap(true), |ui| {
            let mut answer = |ui: &mut Ui, text: &str, tooltip: &str, answer| {
                if ui.button(text).on_hover_text(tooltip).clicked() {
                    actions.push(Action::AnswerParting(answer));
                }
            };
            answer(ui, "Save", "Save the session to a file and continue", PartingAnswer::Save);
            answer(ui, discard, "Discard the changes", PartingAnswer::Discard);
            answer(ui, "Cancel", "Return to the session", PartingAnswer::Cancel);
        });
    });
    if response.should_close() {
        actions.push(Action::AnswerParting(PartingAnswer::Cancel));
    }
}

fn modal(name: &str) -> Modal {
    Modal::new(egui::Id::unique(name))
}

fn frame(ctx: &Context) -> Frame {
    Frame::popup(&ctx.global_style()).inner_margin(16.0)
}

fn weak(ui: &mut Ui, text: &str) {
    ui.add(Label::new(RichText::new(text).color(Palette::of(ui).weak)).wrap());
}
