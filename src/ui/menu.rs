//! The menu bar.

use egui::{Button, MenuBar, RichText, Ui};

use super::history;
use super::theme::Palette;
use super::widgets::{menu, menu_item};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::scene::UpAxis;
use crate::session::verb::Verb;
use crate::session::view::{Layer, ThemeChoice};

pub(super) fn show(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    MenuBar::new().ui(ui, |ui| {
        menu(ui, "File", |ui| {
            for verb in [Verb::Open, Verb::OpenBuiltIn] {
                menu_item(ui, session, verb, actions);
            }
            menu(ui, "Open recent", |ui| recent(ui, session, actions));
            ui.separator();
            for verb in [Verb::SaveSession, Verb::SaveSessionAs, Verb::ReopenLast] {
                menu_item(ui, session, verb, actions);
            }
            ui.separator();
            for verb in [Verb::Export, Verb::ExportAgain, Verb::TakeFrom] {
                menu_item(ui, session, verb, actions);
            }
            ui.separator();
            for verb in [Verb::SavePicture, Verb::SaveTurntable, Verb::SaveScreenshot] {
                menu_item(ui, session, verb, actions);
            }
            ui.separator();
            menu_item(ui, session, Verb::Quit, actions);
        });
        menu(ui, "Edit", |ui| {
            history::menu(ui, session, actions);
            ui.separator();
            for verb in [Verb::CopyPrimitives, Verb::CopyCsv, Verb::PastePrimitives] {
                menu_item(ui, session, verb, actions);
            }
            ui.separator();
            for verb in [
                Verb::MergeSelected,
                Verb::JudgeMerge,
                Verb::SplitSelected,
                Verb::RefitSelected,
                Verb::LockSelected,
                Verb::DeleteSelected,
            ] {
                menu_item(ui, session, verb, actions);
            }
            ui.separator();
            menu(ui, "Handles", |ui| {
                for verb in [
                    Verb::HandlesMove,
                    Verb::HandlesRotate,
                    Verb::HandlesScale,
                    Verb::HandlesTaper,
                    Verb::HandlesRoundness,
                ] {
                    menu_item(ui, session, verb, actions);
                }
            });
            ui.separator();
            for verb in [Verb::NewCluster, Verb::BelongTogether, Verb::ReleasePoints] {
                menu_item(ui, session, verb, actions);
            }
        });
        menu(ui, "Sampler", |ui| {
            for verb in
                [Verb::Run, Verb::Pause, Verb::StepIteration, Verb::Continue, Verb::StepMerge, Verb::MergeAll]
            {
                menu_item(ui, session, verb, actions);
            }
            ui.separator();
            for verb in
                [Verb::FirstState, Verb::PreviousState, Verb::NextState, Verb::LastState, Verb::ContinueHere]
            {
                menu_item(ui, session, verb, actions);
            }
            ui.separator();
            menu_item(ui, session, Verb::Reset, actions);
            menu_item(ui, session, Verb::ToggleLive, actions);
            ui.separator();
            menu_item(ui, session, Verb::RunSeeds, actions);
            menu_item(ui, session, Verb::StopSeeds, actions);
        });
        menu(ui, "View", |ui| {
            for verb in [Verb::FrameAll, Verb::FrameSelection] {
                menu_item(ui, session, verb, actions);
            }
            menu(ui, "Look from", |ui| {
                for verb in [
                    Verb::ViewFront,
                    Verb::ViewBack,
                    Verb::ViewRight,
                    Verb::ViewLeft,
                    Verb::ViewTop,
                    Verb::ViewBottom,
                ] {
                    menu_item(ui, session, verb, actions);
                }
            });
            menu_item(ui, session, Verb::ToggleOrthographic, actions);
            menu(ui, "Up axis", |ui| {
                for (axis, text) in [(UpAxis::Y, "Y is up"), (UpAxis::Z, "Z is up")] {
                    if ui.radio(session.view.up == axis, text).clicked() {
                        actions.push(Action::SetUpAxis(axis));
                        ui.close();
                    }
                }
            });
            ui.separator();
            menu(ui, "Layers", |ui| {
                for layer in Layer::ALL {
                    let mut shown = session.view.shows(layer);
                    if ui.checkbox(&mut shown, layer.text()).clicked() {
                        actions.push(Action::SetLayer(layer, shown));
                    }
                }
            });
            for verb in [Verb::HideSelected, Verb::ShowAll, Verb::Deselect] {
                menu_item(ui, session, verb, actions);
            }
        });
        menu(ui, "Window", |ui| {
            for verb in
                [Verb::ToggleLeftPanel, Verb::ToggleRightPanel, Verb::ToggleBottomPanel, Verb::ToggleLog]
            {
                menu_item(ui, session, verb, actions);
            }
            ui.separator();
            for verb in [Verb::ZoomIn, Verb::ZoomOut, Verb::ZoomReset] {
                menu_item(ui, session, verb, actions);
            }
            menu(ui, "Theme", |ui| {
                for choice in ThemeChoice::ALL {
                    menu_item(ui, session, choice.into(), actions);
                }
            });
            for verb in [Verb::ShowSeeds, Verb::ShowOdds] {
                menu_item(ui, session, verb, actions);
            }
            ui.separator();
            menu_item(ui, session, Verb::ResetLayout, actions);
        });
        menu(ui, "Help", |ui| {
            for verb in [Verb::ShowCommands, Verb::ShowShortcuts, Verb::ShowAbout] {
                menu_item(ui, session, verb, actions);
            }
        });
    });
}

/// The files that were open before.
fn recent(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let files = &session.window.recent;
    if files.is_empty() {
        ui.label(RichText::new("No files opened yet").color(Palette::of(ui).weak));
        return;
    }
    for path in files.iter() {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let folder = path.parent().and_then(|folder| folder.file_name());
        let folder = folder.map(|folder| folder.to_string_lossy()).unwrap_or_default();
        let button = Button::new(name).shortcut_text(folder);
        if ui.add(button).on_hover_text(path.display().to_string()).clicked() {
            actions.push(Action::OpenRecent(path.to_owned()));
            ui.close();
        }
    }
    ui.separator();
    menu_item(ui, session, Verb::ClearRecent, actions);
}
