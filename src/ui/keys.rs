//! Maps egui's key events to verbs.

use crate::session::Session;
use crate::session::action::Action;
use crate::session::verb::{Key, Shortcut, Verb};
use crate::session::view::Tool;

/// Verbs whose shortcuts were pressed in this frame, available ones first.
/// Almost none while a text field has the focus.
pub(super) fn pressed(ctx: &egui::Context, session: &Session, actions: &mut Vec<Action>) {
    // While a list or a question is open, keys belong to it.
    if session.window.shows_commands || ctx.memory(|memory| memory.top_modal_layer().is_some()) {
        return;
    }
    let types = ctx.text_edit_focused();
    // These belong to a widget that was reached by the keyboard.
    let focused = ctx.memory(|memory| memory.focused().is_some());
    let marks_text = ctx
        .with_plugin::<egui::text_selection::LabelSelectionState, _>(|labels| labels.has_selection())
        .unwrap_or_default();
    // Escape closes an open menu, and nothing else.
    let has_menu = egui::Popup::is_any_open(ctx);
    ctx.input(|input| {
        for event in &input.events {
            // The system makes these of its own keys for the clipboard.
            match event {
                egui::Event::Copy if !types && !marks_text => {
                    actions.push(Action::Verb(Verb::CopyPrimitives));
                }
                egui::Event::Paste(text) if !types => {
                    let can = session.is_enabled(Verb::PastePrimitives);
                    let refused = Action::Verb(Verb::PastePrimitives);
                    actions.push(if can { Action::Paste(text.clone().into()) } else { refused });
                }
                _ => {}
            }
            let egui::Event::Key { key, pressed: true, repeat, modifiers, .. } = event else {
                continue;
            };
            // A held arrow key plays the timeline.
            if *repeat && !matches!(key, egui::Key::ArrowLeft | egui::Key::ArrowRight) {
                continue;
            }
            let Some(key) = translate(*key) else { continue };
            if has_menu && key == Key::Escape {
                continue;
            }
            // Typing into a field presses only what no text is made of.
            if types && !matches!(key, Key::Function(_)) && !is_for_the_window(key, *modifiers) {
                continue;
            }
            if let (Key::Escape, true, Some(action)) = (key, modifiers.is_none(), topmost(session)) {
                actions.push(action);
                continue;
            }
            if focused && matches!(key, Key::Space | Key::Escape | Key::Enter | Key::Left | Key::Right) {
                continue;
            }
            // Where the plus is on the keyboard decides whether Shift is held.
            let shift = modifiers.shift && key != Key::Char('+');
            let shortcut = Shortcut { ctrl: modifiers.command, shift, alt: modifiers.alt, key };
            let meant = || Verb::ALL.iter().filter(|verb| verb.shortcuts().any(|own| own == shortcut));
            let verb = meant().find(|verb| session.is_enabled(**verb));
            // What can't be done is told why by the session; Escape may always be pressed.
            let verb = verb.or_else(|| meant().next().filter(|_| key != Key::Escape && !repeat));
            actions.extend(verb.map(|verb| Action::Verb(*verb)));
        }
    });
}

/// Whether a text field passes this on: a letter with Ctrl that does not edit the text.
fn is_for_the_window(key: Key, modifiers: egui::Modifiers) -> bool {
    let edits = ['A', 'C', 'V', 'X', 'Z', 'Y', 'U', 'W', 'K', 'H', 'B', 'F', 'N', 'P', 'E', 'D'];
    let all_commands = modifiers.shift && key == Key::Char('P');
    modifiers.command && (all_commands || matches!(key, Key::Char(c) if !edits.contains(&c)))
}

/// What Escape closes first: a window, an error, or else a tool.
fn topmost(session: &Session) -> Option<Action> {
    let view = &session.view;
    let windows = [(view.shows_about, Verb::ShowAbout), (view.shows_shortcuts, Verb::ShowShortcuts)];
    let window = windows.into_iter().find_map(|(is_open, verb)| is_open.then_some(Action::Verb(verb)));
    let error = || session.messages.open_error().map(|error| Action::DismissError(error.number));
    let tool = || (view.tool != Tool::Click).then_some(Action::Verb(Verb::ToolClick));
    let hand = || session.is_shaping().then_some(Action::Verb(Verb::DropShape));
    window.or_else(hand).or_else(error).or_else(tool)
}

fn translate(key: egui::Key) -> Option<Key> {
    Some(match key {
        egui::Key::Home => Key::Home,
        egui::Key::Space => Key::Space,
        egui::Key::Escape => Key::Escape,
        egui::Key::Backspace => Key::Backspace,
        egui::Key::Plus => Key::Char('+'),
        egui::Key::Minus => Key::Char('-'),
        egui::Key::Equals => Key::Char('='),
        egui::Key::Delete => Key::Delete,
        egui::Key::Enter => Key::Enter,
        egui::Key::ArrowLeft => Key::Left,
        egui::Key::ArrowRight => Key::Right,
        other => {
            let name = other.name();
            let mut letters = name.chars();
            match (letters.next(), letters.as_str()) {
                (Some(letter), "") => Key::Char(letter.to_ascii_uppercase()),
                (Some('F'), number) => Key::Function(number.parse().ok()?),
                _ => return None,
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shortcut_can_be_typed() {
        let keys: Vec<Key> = egui::Key::ALL.iter().filter_map(|key| translate(*key)).collect();
        for verb in Verb::ALL {
            for shortcut in verb.shortcuts() {
                assert!(keys.contains(&shortcut.key), "{verb:?}: no key gives {shortcut}");
            }
        }
    }
}
