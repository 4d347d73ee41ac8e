//! The panels around the viewport: sizes, opening and closing.

use egui::{Panel, Ui, Vec2};
use serde::{Deserialize, Serialize};

use super::timeline;
use super::widgets::bounded;
use crate::session::Session;
use crate::session::action::Action;
use crate::session::verb::Verb;

/// Sizes of the panels in logical pixels: widths of the side panels, heights of
/// log and timeline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Sizes {
    left: f32,
    right: f32,
    log: f32,
    timeline: f32,
    /// A new number creates new panels, without the sizes of the previous ones.
    #[serde(skip)]
    generation: u32,
}

impl Default for Sizes {
    fn default() -> Self {
        Self { left: 290.0, right: 272.0, log: 180.0, timeline: 256.0, generation: 0 }
    }
}

impl Sizes {
    /// Takes the place of others.
    pub(super) fn replace(&mut self, other: Self) {
        let generation = self.generation + 1;
        *self = Self { generation, ..other };
    }

    fn of(&mut self, part: Part) -> &mut f32 {
        match part {
            Part::Left => &mut self.left,
            Part::Right => &mut self.right,
            Part::Log => &mut self.log,
            Part::Timeline => &mut self.timeline,
        }
    }
}

/// A resizable panel.
#[derive(Debug, Clone, Copy)]
pub(super) enum Part {
    Left,
    Right,
    Log,
    Timeline,
}

impl Part {
    fn verb(self) -> Verb {
        match self {
            Self::Left => Verb::ToggleLeftPanel,
            Self::Right => Verb::ToggleRightPanel,
            Self::Log => Verb::ToggleLog,
            Self::Timeline => Verb::ToggleBottomPanel,
        }
    }

    /// Smallest and largest size in a window of this size.
    fn limits(self, window: Vec2) -> (f32, f32) {
        match self {
            Self::Left => (264.0, (0.45 * window.x).max(290.0)),
            Self::Right => (250.0, (0.45 * window.x).max(272.0)),
            Self::Log => (72.0, (0.5 * window.y).max(72.0)),
            Self::Timeline => {
                // A low window keeps most of its room for the view.
                let most = if window.y < 640.0 { 0.34 * window.y } else { 0.6 * window.y };
                (timeline::LEAST_HEIGHT, most.max(timeline::LEAST_HEIGHT))
            }
        }
    }

    /// Shows the panel if it is open.
    pub(super) fn show(
        self,
        ui: &mut Ui,
        (session, window): (&Session, Vec2),
        frame: egui::Frame,
        sizes: &mut Sizes,
        actions: &mut Vec<Action>,
        contents: impl FnOnce(&mut Ui, &mut Vec<Action>),
    ) {
        let generation = sizes.generation;
        let (panel, axis) = match self {
            Self::Left => (Panel::left(("controls", generation)), 0),
            Self::Right => (Panel::right(("primitives", generation)), 0),
            Self::Log => (Panel::bottom(("log", generation)), 1),
            Self::Timeline => (Panel::bottom(("timeline", generation)), 1),
        };
        let (least, most) = self.limits(window);
        let size = sizes.of(self);
        let panel = panel.default_size(*size).size_range(least..=most).resizable(true).frame(frame);
        let shown = collapsible(ui, panel, session, self.verb(), actions, |ui, actions| {
            // A panel takes the size of what is in it: little, before there is a
            // run, and more than it has where a number is long.
            bounded(ui, true, |ui| contents(ui, actions));
        });
        // What a narrow window makes of it is not what was wanted.
        if let (Some(shown), false) = (shown, session.window.is_narrow()) {
            *size = shown[axis];
        }
    }
}

/// Shows a panel toggled by the verb; returns its size if open.
fn collapsible(
    ui: &mut Ui,
    panel: Panel,
    session: &Session,
    verb: Verb,
    actions: &mut Vec<Action>,
    contents: impl FnOnce(&mut Ui, &mut Vec<Action>),
) -> Option<Vec2> {
    let was_open = session.is_on(verb) == Some(true);
    let mut open = was_open;
    let shown = panel.show_collapsible(ui, &mut open, |ui| contents(ui, actions));
    // Its edge was dragged or double-clicked.
    if open != was_open {
        actions.push(Action::Verb(verb));
    }
    shown.filter(|_| open).map(|shown| shown.response.rect.size())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_as_far_as_they_go() {
        let sizes: Sizes = serde_json::from_str(r#"{"left": 333.0, "middle": 1}"#).unwrap();
        assert_eq!(sizes, Sizes { left: 333.0, ..Sizes::default() });
        let mut present = Sizes::default();
        present.replace(sizes);
        assert_eq!((present.left, present.generation), (333.0, 1));
    }

    #[test]
    fn panels_leave_room_in_any_window() {
        for (width, height) in [(480.0, 320.0), (1024.0, 700.0), (3840.0, 2160.0)] {
            for part in [Part::Left, Part::Right, Part::Log, Part::Timeline] {
                let (least, most) = part.limits(egui::vec2(width, height));
                assert!(least <= most, "{part:?} in {width} × {height}");
            }
        }
    }
}
