//! The right panel: the list of primitives, what is selected of them.

use egui::{Frame, Margin, Panel, ScrollArea, Ui};

use crate::session::Session;
use crate::session::action::Action;

mod inspector;
mod list;
mod theta;

pub(super) use inspector::swatch;

/// What the panel remembers besides the session.
#[derive(Debug, Default)]
pub(super) struct Primitives {
    list: list::List,
}

/// The selected ones take at most this share of the panel.
const INSPECTOR_SHARE: f32 = 0.62;

impl Primitives {
    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
        if inspector::has_something(session) {
            let most = INSPECTOR_SHARE * ui.available_height();
            let frame = Frame::new().inner_margin(Margin { top: 6, ..Margin::ZERO });
            Panel::bottom("inspector").frame(frame).resizable(false).max_size(most).show(ui, |ui| {
                ScrollArea::vertical().auto_shrink([false, true]).show(ui, |ui| {
                    inspector::show(ui, session, actions);
                });
            });
        }
        self.list.show(ui, session, actions);
    }
}
