//! Suppresses tooltips while a mouse button is held, and closes them when a dialog opens over them.

use egui::{Context, Event, MouseWheelSource, MouseWheelUnit, Plugin, RawInput, TouchPhase, Vec2};

/// egui hides all tooltips for a while after the wheel was turned: so a turn
/// by nothing is what hides them.
#[derive(Debug, Default)]
pub(super) struct QuietTooltips {
    had_dialog: bool,
}

impl Plugin for QuietTooltips {
    fn debug_name(&self) -> &'static str {
        "quiet tooltips"
    }

    fn input_hook(&mut self, ctx: &Context, input: &mut RawInput) {
        let is_pressed = |event: &Event| matches!(event, Event::PointerButton { pressed: true, .. });
        let holds = ctx.input(|i| i.pointer.any_down()) || input.events.iter().any(is_pressed);
        let has_dialog = ctx.memory(|memory| memory.top_modal_layer().is_some());
        let had_dialog = std::mem::replace(&mut self.had_dialog, has_dialog);
        if holds || (has_dialog && !had_dialog) {
            input.events.push(Event::MouseWheel {
                unit: MouseWheelUnit::Point,
                delta: Vec2::ZERO,
                phase: TouchPhase::End,
                source: MouseWheelSource::Unknown,
                modifiers: ctx.input(|i| i.modifiers),
            });
        }
    }
}
