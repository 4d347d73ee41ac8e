//! Small widgets shared by the panels.

use egui::{
    Button, Color32, DragValue, Rangef, Rect, Response, RichText, Role, ScrollArea, Sense, Ui, UiBuilder,
    WidgetInfo, pos2, vec2,
};

use super::theme::{self, Palette};
pub(super) use crate::geometry::cloud::grouped as count;
use crate::session::Session;
use crate::session::action::{Action, Offer};
use crate::session::verb::Verb;

/// Between a dialog's contents and the window's edge: its frame and some air.
const DIALOG_MARGIN: f32 = 26.0;
/// What of a dialog that scrolls is seen in the lowest window.
const LEAST_BODY: f32 = 28.0;

/// The heading of a section in a panel.
pub(super) fn section(ui: &mut Ui, title: &str) {
    ui.add_space(2.0);
    ui.label(RichText::new(title).strong());
    ui.add_space(2.0);
}

/// A file size as text: `1.2 MB`.
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

/// The tooltip of a verb, with the reason if it is not available.
pub(super) fn with_reason(session: &Session, verb: Verb) -> String {
    let text = tooltip(verb);
    session.reason(verb).map_or_else(|| text.clone(), |why| format!("{text}\n{why}"))
}

/// A button for a verb; disabled if the verb is not available.
pub(super) fn verb_button(ui: &mut Ui, session: &Session, verb: Verb, width: f32, actions: &mut Vec<Action>) {
    let button = Button::new(verb.entry().text).min_size(vec2(width, theme::ROW));
    add_verb(ui, session, verb, button, actions);
}

/// The same in the accent colour, for the primary action.
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
    let text = with_reason(session, verb);
    if response.on_hover_text(&text).on_disabled_hover_text(&text).clicked() {
        actions.push(Action::Verb(verb));
    }
}

/// A menu that scrolls if the window is too low.
pub(super) fn menu<R>(
    ui: &mut Ui,
    title: &str,
    entries: impl FnOnce(&mut Ui) -> R,
) -> egui::InnerResponse<Option<R>> {
    ui.menu_button(title, |ui| {
        let room = ui.ctx().content_rect().height() - 2.0 * theme::TALL_ROW - 16.0;
        let area = ScrollArea::vertical().max_height(room).min_scrolled_height(room);
        area.show(ui, entries).inner
    })
}

/// A menu entry with its shortcut and, for toggles, a check mark.
pub(super) fn menu_item(ui: &mut Ui, session: &Session, verb: Verb, actions: &mut Vec<Action>) {
    let entry = verb.entry();
    let mut button = match session.is_on(verb) {
        Some(on) => Button::selectable(on, entry.text),
        None => Button::new(entry.text),
    };
    if let Some(shortcut) = entry.shortcut {
        button = button.shortcut_text(shortcut.to_string());
    }
    let text = session
        .reason(verb)
        .map_or_else(|| entry.tooltip.to_owned(), |why| format!("{}\n{why}", entry.tooltip));
    let response = ui.add_enabled(session.is_enabled(verb), button);
    if response.on_hover_text(&text).on_disabled_hover_text(&text).clicked() {
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

/// A button for the action of a message; returns whether it was pressed.
pub(super) fn offer_button(ui: &mut Ui, session: &Session, offer: &Offer, actions: &mut Vec<Action>) -> bool {
    let (enabled, about) = match &*offer.action {
        Action::Verb(verb) => (session.is_enabled(*verb), with_reason(session, *verb)),
        Action::ShowInFolder(path) => (true, path.display().to_string()),
        _ => (true, offer.text.to_owned()),
    };
    let button = ui.add_enabled(enabled, Button::new(offer.text));
    let pressed = button.on_hover_text(&about).on_disabled_hover_text(about).clicked();
    if pressed {
        actions.push((*offer.action).clone());
    }
    pressed
}

/// A close button with an accessible `label`.
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

/// The focus ring of custom-painted widgets.
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

/// An open or closed eye with an accessible `label`.
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

/// Drawn as two arcs and a pupil, because not all fonts have an eye.
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

/// A number as text with this many significant digits: in scientific notation if
/// very large or small, `–` if not a number.
fn significant(value: f64, digits: usize) -> String {
    let size = value.abs();
    if !value.is_finite() {
        return "–".to_owned();
    }
    if size == 0.0 {
        return "0".to_owned();
    }
    if size < 1e-30 {
        return "≈ 0".to_owned();
    }
    // What is rounded up to a limit is beyond it.
    let exponential = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = exponential.split_once('e').unwrap_or((&exponential, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if !(-3..5).contains(&exponent) {
        return format!("{}e{exponent}", trimmed(mantissa));
    }
    let decimals = digits as i32 - 1 - exponent;
    format!("{value:.*}", usize::try_from(decimals).unwrap_or(0))
}

/// Without trailing zeros.
fn trimmed(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// A length in a table: four significant digits, four decimals at most.
pub(super) fn length(value: f64) -> String {
    let text = significant(value, 4);
    if value.abs() < 1.0 && value != 0.0 && !text.contains(['e', '–', '≈']) {
        return format!("{value:.4}");
    }
    text
}

/// A density, a weight, a number of a test: three significant digits.
pub(super) fn figure(value: f64) -> String {
    significant(value, 3)
}

/// A setting: as short as four significant digits allow.
pub(super) fn setting(value: f64) -> String {
    let text = significant(value, 4);
    if text.contains('e') { text } else { trimmed(&text).to_owned() }
}

/// A number that is dragged or typed, shown as `text` has it; one that is left
/// as it was shown keeps its digits.
pub(super) fn editable<'a, Num: egui::emath::Numeric>(
    value: &'a mut Num,
    text: impl Fn(f64) -> String + 'a,
) -> DragValue<'a> {
    let unchanged = value.to_f64();
    let shown = text(unchanged);
    DragValue::new(value)
        .update_while_editing(false)
        .custom_formatter(move |value, _| text(value))
        .custom_parser(move |typed| if typed == shown { Some(unchanged) } else { parse(typed) })
}

/// A number as people type it: with a degree sign, spaces, a true minus.
fn parse(text: &str) -> Option<f64> {
    let text: String = text
        .chars()
        .filter(|c| !c.is_whitespace() && *c != '°')
        .map(|c| match c {
            '−' => '-',
            ',' => '.',
            c => c,
        })
        .collect();
    text.parse().ok().filter(|v: &f64| v.is_finite())
}

/// Draws what must not make its surroundings wider or, where it is `low`,
/// higher: a panel takes the size of what is in it, and would grow from frame
/// to frame with contents that fill it and a bit more.
pub(super) fn bounded<R>(ui: &mut Ui, low: bool, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let room = ui.available_rect_before_wrap();
    let mut part = ui.new_child(UiBuilder::new().max_rect(room));
    let sides = Rect::from_x_y_ranges(room.x_range(), if low { room.y_range() } else { Rangef::EVERYTHING });
    // Rings around what has the focus are a bit larger.
    part.shrink_clip_rect(sides.expand(2.0));
    let result = contents(&mut part);
    let bottom = if low { room.bottom() } else { part.min_rect().bottom() };
    ui.advance_cursor_after_rect(Rect::from_min_max(room.min, pos2(room.right(), bottom)));
    result
}

/// A part of a panel that never makes it larger.
pub(super) fn within<R>(ui: &mut Ui, rect: Rect, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let mut part = ui.new_child(UiBuilder::new().max_rect(rect));
    part.shrink_clip_rect(rect.expand(2.0));
    contents(&mut part)
}

/// Where cards are that float over the view, each of which says so in every
/// frame: what is said in passing keeps away from them.
#[derive(Debug, Clone, Default)]
struct Cards(Vec<Rect>);

/// Keeps toasts away from this area.
pub(super) fn keep_clear(ctx: &egui::Context, card: Rect) {
    ctx.data_mut(|data| data.get_temp_mut_or_default::<Cards>(egui::Id::NULL).0.push(card));
}

/// The cards that were drawn since this was asked last.
pub(super) fn cards(ctx: &egui::Context) -> Vec<Rect> {
    ctx.data_mut(|data| std::mem::take(&mut data.get_temp_mut_or_default::<Cards>(egui::Id::NULL).0))
}

/// The width of a dialog, less in a window that is narrower.
pub(super) fn dialog_width(ctx: &egui::Context, width: f32) -> f32 {
    width.min(ctx.content_rect().width() - 2.0 * DIALOG_MARGIN).max(120.0)
}

/// The part of a dialog that scrolls where the window is too low for it: what
/// is drawn below, so many logical pixels high, stays in sight.
pub(super) fn dialog_body<R>(ui: &mut Ui, below: f32, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let room = dialog_room(ui, below);
    scrolling(ui, room, contents)
}

/// The height that is left in a dialog in the present window, without what is
/// drawn below.
pub(super) fn dialog_room(ui: &Ui, below: f32) -> f32 {
    let used = ui.cursor().top() - ui.min_rect().top();
    (ui.ctx().content_rect().height() - 2.0 * DIALOG_MARGIN - used - below).max(LEAST_BODY)
}

/// Contents that scroll where they are higher than so many logical pixels.
pub(super) fn scrolling<R>(ui: &mut Ui, room: f32, contents: impl FnOnce(&mut Ui) -> R) -> R {
    let room = room.max(LEAST_BODY);
    let area = ScrollArea::vertical().max_height(room).min_scrolled_height(room).auto_shrink([false, true]);
    area.show(ui, |ui| {
        let result = contents(ui);
        follow_focus(ui);
        result
    })
    .inner
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
        for (value, expected) in [
            (0.0, "0"),
            (1.23456, "1.235"),
            (123.456, "123.5"),
            (12345.6, "12346"),
            (0.01234, "0.0123"),
            (0.002, "0.0020"),
            (1e-6, "1e-6"),
            (-1.234e-7, "-1.234e-7"),
            (1e5, "1e5"),
            (99_999.9, "1e5"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(length(value), expected);
        }
        for (value, expected) in
            [(1e-6, "1e-6"), (0.5, "0.5"), (30.0, "30"), (0.000_347_82, "3.478e-4"), (0.012_345_6, "0.01235")]
        {
            assert_eq!(setting(value), expected);
        }
        for (value, expected) in
            [(0.7, "0.700"), (12.345, "12.3"), (-0.003_58, "-0.00358"), (1.5e-5, "1.5e-5"), (1e-200, "≈ 0")]
        {
            assert_eq!(figure(value), expected);
        }
        for exponent in -40..40 {
            let value = -1.23456789 * 10_f64.powi(exponent);
            for text in [length(value), figure(value), setting(value)] {
                assert!(text.chars().count() <= 10, "{text}");
                assert!(exponent < -30 || text.parse::<f64>().is_ok(), "{text}");
            }
        }
    }

    #[test]
    fn numbers_are_read_as_people_type_them() {
        assert_eq!(parse(" −12,5 °"), Some(-12.5));
        assert_eq!(parse("1e-3"), Some(1e-3));
        assert_eq!(parse("x"), None);
        assert_eq!(parse("inf"), None);
    }
}
