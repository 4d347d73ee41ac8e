//! From egui's key events to verbs.

use crate::session::Session;
use crate::session::action::{Action, Key, Shortcut, Verb};
use crate::session::view::Tool;

/// The verbs whose shortcuts were pressed in this frame and that would do
/// something. Typing into a field presses none.
pub(super) fn pressed(ctx: &egui::Context, session: &Session, actions: &mut Vec<Action>) {
    if ctx.text_edit_focused() {
        return;
    }
    // These belong to a widget that was reached by the keyboard.
    let focused = ctx.memory(|memory| memory.focused().is_some());
    ctx.input(|input| {
        for event in &input.events {
            let egui::Event::Key { key, pressed: true, repeat, modifiers, .. } = event else {
                continue;
            };
            // A held arrow key plays the timeline.
            if *repeat && !matches!(key, egui::Key::ArrowLeft | egui::Key::ArrowRight) {
                continue;
            }
            let Some(key) = translate(*key) else { continue };
            if let (Key::Escape, true, Some(verb)) = (key, modifiers.is_none(), topmost(session)) {
                actions.push(Action::Verb(verb));
                continue;
            }
            if focused && matches!(key, Key::Space | Key::Escape | Key::Enter | Key::Left | Key::Right) {
                continue;
            }
            let shortcut =
                Shortcut { ctrl: modifiers.command, shift: modifiers.shift, alt: modifiers.alt, key };
            let verb = Verb::ALL
                .iter()
                .find(|verb| verb.entry().shortcut == Some(shortcut) && session.is_enabled(**verb));
            actions.extend(verb.map(|verb| Action::Verb(*verb)));
        }
    });
}

/// What ends the window, or else the tool, that Escape ends first.
fn topmost(session: &Session) -> Option<Verb> {
    let view = &session.view;
    [
        (view.shows_about, Verb::ShowAbout),
        (view.shows_shortcuts, Verb::ShowShortcuts),
        (view.shows_log, Verb::ToggleLog),
        (view.tool != Tool::Click, Verb::ToolClick),
    ]
    .into_iter()
    .find_map(|(is_open, verb)| is_open.then_some(verb))
}

fn translate(key: egui::Key) -> Option<Key> {
    Some(match key {
        egui::Key::Home => Key::Home,
        egui::Key::Space => Key::Space,
        egui::Key::Escape => Key::Escape,
        egui::Key::Backspace => Key::Backspace,
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
            if let Some(shortcut) = verb.entry().shortcut {
                assert!(keys.contains(&shortcut.key), "{verb:?}: no key gives {shortcut}");
            }
        }
    }
}
