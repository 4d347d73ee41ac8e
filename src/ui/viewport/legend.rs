//! The colour bar: the values of the colours, and the end of the range.

use egui::{
    Align2, Button, Color32, DragValue, FontId, Label, Mesh, Rect, RichText, Role, Sense, Shape, Stroke, Ui,
    UiBuilder, WidgetInfo, pos2, vec2,
};

use crate::render::colormap::viridis;
use crate::session::action::Action;
use crate::session::scalar::{Top, Unit};
use crate::session::verb::Verb;
use crate::session::view::{ColorBy, View};
use crate::ui::scene::{Legend, Scene};
use crate::ui::theme::{self, Palette, data_color};
use crate::ui::widgets::{keep_clear, length, tooltip};

/// Logical pixels.
const BAR: f32 = 12.0;
/// Least and largest height of the bar.
const HEIGHT: (f32, f32) = (52.0, 116.0);
const PADDING: f32 = 9.0;
const WIDTH: f32 = 178.0;
/// From the viewport's corner, above what is written along its lower edge.
const CORNER: egui::Vec2 = vec2(10.0, 44.0);
const TICKS: usize = 4;
const STRIPES: usize = 48;

pub(super) fn show(ui: &mut Ui, scene: &Scene, view: &View, rect: Rect, actions: &mut Vec<Action>) {
    match scene.legend() {
        None => {}
        Some(Legend::Missing(why)) => missing(ui, view, why, rect, actions),
        Some(Legend::Bar { title, unit, range, most }) => {
            bar(ui, view, &Bar { title, unit, range, most }, rect, actions);
        }
    }
}

struct Bar<'a> {
    title: &'a str,
    unit: Unit,
    range: (f32, f32),
    most: f32,
}

/// The panel in the lower right corner; `None` where there is no room.
fn panel(ui: &mut Ui, rect: Rect, height: f32) -> Option<(Rect, Ui)> {
    let size = vec2(WIDTH + 2.0 * PADDING, height + 2.0 * PADDING);
    if size.x + CORNER.x > rect.width() || size.y + CORNER.y > rect.height() {
        return None;
    }
    let panel = Rect::from_min_size(rect.right_bottom() - size - CORNER, size);
    let fill = Palette::of(ui).overlay.gamma_multiply(0.9);
    ui.painter().with_clip_rect(rect).rect_filled(panel, 5.0, fill);
    keep_clear(ui.ctx(), panel);
    // What is pressed here is not meant for the view behind.
    ui.interact(panel, ui.scope_id().with("legend"), Sense::click_and_drag());
    let inside = UiBuilder::new().max_rect(panel.shrink(PADDING));
    Some((panel, ui.new_child(inside)))
}

fn missing(ui: &mut Ui, view: &View, why: &str, rect: Rect, actions: &mut Vec<Action>) {
    let offers_seeds = view.color_by == ColorBy::SeedUncertainty;
    let height = if offers_seeds { 62.0 } else { 34.0 };
    let Some((_, mut ui)) = panel(ui, rect, height) else { return };
    ui.label(RichText::new(view.color_by.text()).small()).on_hover_text(view.color_by.tooltip());
    ui.add(Label::new(RichText::new(why).small().color(Palette::of(&ui).weak)).wrap());
    if offers_seeds {
        let verb = Verb::RunSeeds;
        if ui.add(Button::new(verb.entry().text).small()).on_hover_text(tooltip(verb)).clicked() {
            actions.push(Action::Verb(verb));
        }
    }
}

fn bar(ui: &mut Ui, view: &View, bar: &Bar<'_>, rect: Rect, actions: &mut Vec<Action>) {
    let has_window = view.color_by == ColorBy::Uncertainty;
    let row = theme::ROW + 4.0;
    let controls = if has_window { 2.0 * row } else { row };
    // In a low view it leaves the axes in the other corner free.
    let height = (rect.height() - 224.0 - controls).clamp(HEIGHT.0, HEIGHT.1);
    let Some((panel, mut ui)) = panel(ui, rect, 20.0 + height + 10.0 + controls) else { return };
    let ui = &mut ui;
    let (low, high) = bar.range;
    let unit = match bar.unit {
        Unit::Length => "in the file's units",
        Unit::Share => "as a fraction of the maximum possible value",
    };
    let heading = ui.add(Label::new(RichText::new(bar.title).small()).truncate());
    heading.on_hover_text(format!("{}. Values are {unit}. Grey means no value", view.color_by.tooltip()));

    let palette = Palette::of(ui);
    let strip =
        Rect::from_min_size(pos2(panel.left() + PADDING, panel.top() + PADDING + 22.0), vec2(BAR, height));
    let response = ui.interact(strip.expand(3.0), ui.scope_id().with("bar"), Sense::drag());
    let (from, to) = (length(f64::from(low)), length(f64::from(high)));
    let label = format!("{} from {from} to {to}", bar.title);
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &label));
    if response.dragged() && response.drag_delta().y != 0.0 {
        // What is pulled up spreads the colours over larger numbers.
        let top = high * (-0.012 * response.drag_delta().y).exp();
        actions.push(Action::SetLegendTop(Top::At(top)));
    }
    response
        .on_hover_text("Drag up or down to change the end of the range")
        .on_hover_cursor(egui::CursorIcon::ResizeVertical);
    paint(ui, strip, bar, &palette);

    ui.add_space(strip.bottom() + 6.0 - ui.cursor().top());
    ui.horizontal(|ui| ends(ui, view, bar, actions));
    if has_window {
        ui.horizontal(|ui| {
            let label = ui.label(RichText::new("Last").small()).id;
            let mut states = view.uncertainty_window;
            let (least, most) = View::UNCERTAINTY_WINDOW;
            let number = DragValue::new(&mut states).range(least..=most).speed(0.1).suffix(" states");
            let number = ui.add(number).labelled_by(label);
            if number.on_hover_text("Number of states W over which the entropy is computed").changed() {
                actions.push(Action::SetUncertaintyWindow(states));
            }
        });
    }
}

/// Controls for the end of the range.
fn ends(ui: &mut Ui, view: &View, bar: &Bar<'_>, actions: &mut Vec<Action>) {
    let (_, high) = bar.range;
    let label = ui.label(RichText::new("Up to").small()).id;
    let mut top = high;
    let number = DragValue::new(&mut top).speed(f64::from(high) * 0.01).range(f32::MIN_POSITIVE..=f32::MAX);
    let number = number.custom_formatter(|value, _| length(value)).update_while_editing(false);
    let number = ui.add_sized([56.0, theme::ROW], number).labelled_by(label);
    let text = format!("Value of the last colour. The largest value is {}", length(f64::from(bar.most)));
    if number.on_hover_text(text).changed() && top != high {
        actions.push(Action::SetLegendTop(Top::At(top)));
    }
    ui.spacing_mut().item_spacing.x = 3.0;
    for (top, text, name, tooltip) in [
        (Top::Robust, "95 %", "Scale colours to 95 %", "End at a round number above 95 % of the values"),
        (Top::Most, "Max", "Scale colours to the maximum", "End at the largest value"),
    ] {
        let button = Button::selectable(view.legend_top == top, RichText::new(text).small());
        let button = ui.add(button.frame_when_inactive(true)).accessible_name(name);
        if button.on_hover_text(tooltip).clicked() {
            actions.push(Action::SetLegendTop(top));
        }
    }
}

fn paint(ui: &Ui, strip: Rect, bar: &Bar<'_>, palette: &Palette) {
    let painter = ui.painter();
    let mut mesh = Mesh::default();
    for i in 0..=STRIPES {
        let share = i as f32 / STRIPES as f32;
        let color = data_color(viridis(share));
        let y = strip.bottom() - share * strip.height();
        mesh.colored_vertex(pos2(strip.left(), y), color);
        mesh.colored_vertex(pos2(strip.right(), y), color);
        if i > 0 {
            let k = 2 * i as u32;
            mesh.add_triangle(k - 2, k - 1, k);
            mesh.add_triangle(k - 1, k + 1, k);
        }
    }
    painter.add(Shape::mesh(mesh));
    let (low, high) = bar.range;
    let font = FontId::proportional(11.0);
    for i in 0..=TICKS {
        let share = i as f32 / TICKS as f32;
        let y = strip.bottom() - share * strip.height();
        let tick = [pos2(strip.right(), y), pos2(strip.right() + 4.0, y)];
        painter.line_segment(tick, Stroke::new(1.0, palette.weak));
        let above = if i == TICKS && bar.most > high { "≥ " } else { "" };
        let number = format!("{above}{}", length(f64::from(low + (high - low) * share)));
        let number = painter.layout_no_wrap(number, font.clone(), palette.weak);
        let at = Align2::LEFT_CENTER.anchor_size(pos2(strip.right() + 8.0, y), number.size());
        painter.galley(at.min, number, Color32::PLACEHOLDER);
    }
}
