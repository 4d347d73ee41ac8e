//! Small parts that the panels share.

use egui::{Button, Color32, Response, RichText, Role, Sense, Ui, WidgetInfo, vec2};

use super::theme::{self, Palette};
pub(super) use crate::geometry::cloud::grouped as count;
use crate::session::Session;
use crate::session::action::{Action, Verb};
use crate::session::messages::Offer;

/// The heading of a section in a panel.
pub(super) fn section(ui: &mut Ui, title: &str) {
    ui.add_space(2.0);
    ui.label(RichText::new(title).strong());
    ui.add_space(2.0);
}

/// A size for people: `1.2 MB`.
pub(super) fn bytes(count: u64) -> String {
    let mut size = count as f64;
    for unit in ["bytes", "kB", "MB"] {
        if size < 999.5 {
            let digits = if unit == "bytes" || size >= 9.95 { 0 } else { 1 };
            return format!("{size:.digits$} {unit}");
        }
        size /= 1000.0;
    }
    format!("{size:.1} GB")
}

/// A line between two sections.
pub(super) fn divide(ui: &mut Ui) {
    ui.add_space(theme::SECTION_GAP * 0.5);
    ui.separator();
    ui.add_space(theme::SECTION_GAP * 0.2);
}

/// The tooltip of a verb with its shortcut.
pub(super) fn tooltip(verb: Verb) -> String {
    let entry = verb.entry();
    match entry.shortcut {
        Some(shortcut) => format!("{} ({shortcut})", entry.tooltip),
        None => entry.tooltip.to_owned(),
    }
}

/// A button that does the verb; grey while it would do nothing.
pub(super) fn verb_button(ui: &mut Ui, session: &Session, verb: Verb, width: f32, actions: &mut Vec<Action>) {
    let button = Button::new(verb.entry().text).min_size(vec2(width, theme::ROW));
    add_verb(ui, session, verb, button, actions);
}

/// The same in the accent colour, for what a person most likely wants.
pub(super) fn primary_button(
    ui: &mut Ui,
    session: &Session,
    verb: Verb,
    width: f32,
    actions: &mut Vec<Action>,
) {
    let palette = Palette::of(ui);
    let text = RichText::new(verb.entry().text).color(palette.on_accent).strong();
    let button = Button::new(text).fill(palette.accent).min_size(vec2(width, theme::ROW));
    add_verb(ui, session, verb, button, actions);
}

fn add_verb(ui: &mut Ui, session: &Session, verb: Verb, button: Button<'_>, actions: &mut Vec<Action>) {
    let response = ui.add_enabled(session.is_enabled(verb), button);
    let text = tooltip(verb);
    let why = session.reason(verb).map(|why| format!("{text}\n{why}"));
    let why = why.as_deref().unwrap_or(&text);
    if response.on_hover_text(&text).on_disabled_hover_text(why).clicked() {
        actions.push(Action::Verb(verb));
    }
}

/// An entry of a menu, with its shortcut and, for what can be on, a mark.
pub(super) fn menu_item(ui: &mut Ui, session: &Session, verb: Verb, actions: &mut Vec<Action>) {
    let entry = verb.entry();
    let mut button = match session.is_on(verb) {
        Some(on) => Button::selectable(on, entry.text),
        None => Button::new(entry.text),
    };
    if let Some(shortcut) = entry.shortcut {
        button = button.shortcut_text(shortcut.to_string());
    }
    let why = session.reason(verb).unwrap_or(entry.tooltip);
    let response = ui.add_enabled(session.is_enabled(verb), button);
    if response.on_hover_text(entry.tooltip).on_disabled_hover_text(why).clicked() {
        actions.push(Action::Verb(verb));
        ui.close();
    }
}

/// One of several choices in a row.
pub(super) fn choice(ui: &mut Ui, on: bool, text: &str, width: f32) -> Response {
    ui.spacing_mut().button_padding.x = 3.0;
    let button = Button::selectable(on, text).min_size(vec2(width, theme::ROW)).frame_when_inactive(true);
    ui.add(button)
}

/// A button for what a message offers; whether it was pressed.
pub(super) fn offer_button(ui: &mut Ui, session: &Session, offer: &Offer, actions: &mut Vec<Action>) -> bool {
    let (enabled, about) = match &*offer.action {
        Action::Verb(verb) => (session.is_enabled(*verb), tooltip(*verb)),
        Action::ShowInFolder(path) => (true, path.display().to_string()),
        _ => (true, offer.text.to_owned()),
    };
    let pressed = ui.add_enabled(enabled, Button::new(offer.text)).on_hover_text(about).clicked();
    if pressed {
        actions.push((*offer.action).clone());
    }
    pressed
}

/// A cross that closes something; `label` says what.
pub(super) fn close_button(ui: &mut Ui, label: &str) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(theme::ROW, theme::ROW), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, label));
    if ui.is_rect_visible(rect) {
        if response.hovered() || response.has_focus() {
            ui.painter().rect_filled(rect, 4.0, ui.visuals().widgets.hovered.weak_bg_fill);
        }
        focus_ring(ui, &response);
        let stroke = egui::Stroke::new(1.4, ui.visuals().text_color());
        let (center, arm) = (rect.center(), 4.0);
        for sign in [-1.0, 1.0] {
            let offset = vec2(arm, sign * arm);
            ui.painter().line_segment([center - offset, center + offset], stroke);
        }
    }
    response.on_hover_text(label)
}

/// Around what was reached by the keyboard, for widgets that are painted by hand.
pub(super) fn focus_ring(ui: &Ui, response: &Response) {
    if response.has_focus() {
        let stroke = ui.visuals().widgets.active.bg_stroke;
        ui.painter().rect_stroke(response.rect, 4.0, stroke, egui::StrokeKind::Inside);
    }
}

/// Scrolls to what the keyboard has just reached. To be called at the end of a
/// scroll area's contents.
pub(super) fn follow_focus(ui: &mut Ui) {
    let Some(id) = ui.memory(|memory| memory.focused()) else { return };
    let Some(response) = ui.ctx().read_response(id) else { return };
    if response.gained_focus()
        && response.layer_id == ui.layer_id()
        && ui.min_rect().intersects(response.rect)
    {
        ui.scroll_to_rect(response.rect.expand2(vec2(0.0, theme::ROW)), None);
    }
}

/// An eye that is open or shut; `label` says of what.
pub(super) fn eye(ui: &mut Ui, open: bool, label: &str) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(theme::ROW, theme::ROW), Sense::click());
    let enabled = ui.is_enabled();
    response.widget_info(|| WidgetInfo::selected(Role::CheckBox, enabled, open, label));
    if ui.is_rect_visible(rect) {
        focus_ring(ui, &response);
        let color = if response.hovered() || response.has_focus() {
            ui.visuals().strong_text_color()
        } else if open {
            ui.visuals().text_color()
        } else {
            Palette::of(ui).weak.gamma_multiply(0.7)
        };
        paint_eye(ui, rect.center(), open, color);
    }
    response.on_hover_text(format!("{} {}", if open { "Hide" } else { "Show" }, lower_first(label)))
}

/// Fonts differ in their eyes, and some have none: two arcs and a pupil.
fn paint_eye(ui: &Ui, center: egui::Pos2, open: bool, color: Color32) {
    let stroke = egui::Stroke::new(1.3, color);
    let (half, lift) = (6.5, 4.2);
    let arc = |sign: f32| -> Vec<egui::Pos2> {
        (0..=12)
            .map(|i| {
                let t = i as f32 / 6.0 - 1.0;
                center + vec2(t * half, sign * lift * (1.0 - t * t))
            })
            .collect()
    };
    let painter = ui.painter();
    if open {
        painter.line(arc(-1.0), stroke);
        painter.line(arc(1.0), stroke);
        painter.circle_filled(center, 2.1, color);
    } else {
        painter.line(arc(1.0), stroke);
        for t in [-0.62_f32, 0.0, 0.62] {
            let foot = center + vec2(t * half, lift * (1.0 - t * t));
            painter.line_segment([foot, foot + vec2(t * 2.5, 2.6)], stroke);
        }
    }
}

pub(super) fn lower_first(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// A length with four significant digits, in powers of ten where it is very
/// large or small; `–` where it is not a number.
pub(super) fn length(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let before = if size >= 1.0 { size.log10().floor() as usize + 1 } else { 1 };
    format!("{value:.*}", 4_usize.saturating_sub(before).max(if size < 1.0 { 4 } else { 0 }))
}

/// A label on the left, a value on the right, for a grid of two columns.
pub(super) fn fact(ui: &mut Ui, label: &str, value: &str) -> Response {
    ui.label(RichText::new(label).color(Palette::of(ui).weak));
    let response = ui.add(egui::Label::new(value).truncate());
    ui.end_row();
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_short_at_any_size() {
        assert_eq!(count(1), "1");
        assert_eq!(count(1_234_567), "1,234,567");
        assert_eq!(length(0.0), "0.0000");
        assert_eq!(length(1.23456), "1.235");
        assert_eq!(length(123.456), "123.5");
        assert_eq!(length(12345.6), "12346");
        assert_eq!(length(f64::NAN), "–");
        for exponent in -30..30 {
            assert!(length(-1.23456789 * 10_f64.powi(exponent)).len() <= 9);
        }
    }
}
