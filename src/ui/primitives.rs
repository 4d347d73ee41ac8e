//! The right panel: the list of primitives and the inspector.

use egui::Ui;

use super::widgets::divide;
use crate::session::Session;
use crate::session::action::Action;

mod inspector;
mod list;
mod theta;

pub(super) use inspector::swatch;

/// Height of the numbers and buttons of one primitive, in logical pixels.
const USUAL_HEIGHT: f32 = 300.0;

/// Panel state outside the session.
#[derive(Debug, Default)]
pub(super) struct Primitives {
    list: list::List,
    /// Height of the inspector in the previous frame.
    selection_height: f32,
}

impl Primitives {
    /// `height` is that of the panel; the list takes the rest.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, height: f32, actions: &mut Vec<Action>) {
        let bottom = ui.cursor().top() + height;
        let has_selection = inspector::has_something(session);
        // What was never shown is about as high as the numbers of one primitive.
        let expected = if self.selection_height > 0.0 { self.selection_height } else { USUAL_HEIGHT };
        let reserved = if has_selection { expected } else { 0.0 };
        self.list.show(ui, session, bottom - reserved, actions);
        if has_selection {
            let top = ui.cursor().top();
            divide(ui);
            inspector::show(ui, session, actions);
            let height = ui.cursor().top() - top;
            if (height - self.selection_height).abs() > 0.5 {
                self.selection_height = height;
                ui.ctx().request_repaint();
            }
        }
    }
}
