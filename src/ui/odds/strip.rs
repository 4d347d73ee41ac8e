//! The labels of a point over the states of the branch, as a strip of colours.

use egui::{Color32, FontId, Key, Rect, RichText, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

use crate::geometry::palette::UNASSIGNED_COLOR;
use crate::inference::UNASSIGNED;
use crate::session::Session;
use crate::session::action::Action;
use crate::session::naming::StateName;
use crate::ui::theme::{Palette, data_color};
use crate::ui::widgets::count;

/// Height in logical pixels.
const HEIGHT: f32 = 16.0;

pub(super) fn show(ui: &mut Ui, session: &Session, sample: u32, actions: &mut Vec<Action>) {
    let states = session.timeline.states();
    if states.is_empty() {
        return;
    }
    let label_in =
        |i: usize| states[i].abstraction.labels.get(sample as usize).copied().unwrap_or(UNASSIGNED);
    let changes = (1..states.len()).filter(|&i| label_in(i) != label_in(i - 1)).count();
    let weak = Palette::of(ui).weak;
    let text = format!("Label over {} states, {} changes", count(states.len()), count(changes));
    ui.label(RichText::new(&text).small().color(weak));
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &text));
    let width = rect.width() / states.len() as f32;
    let cell = |from: usize, to: usize| {
        let x = |i: usize| rect.left() + i as f32 * width;
        Rect::from_min_max(pos2(x(from), rect.top()), pos2(x(to), rect.bottom()))
    };
    let color = |label: u32| match label {
        UNASSIGNED => data_color(UNASSIGNED_COLOR).gamma_multiply(0.6),
        id => data_color(session.color_of(id)),
    };
    let painter = ui.painter();
    let mut from = 0;
    // Runs of one label in one piece.
    for i in 1..=states.len() {
        if i == states.len() || label_in(i) != label_in(from) {
            painter.rect_filled(cell(from, i), 0.0, color(label_in(from)));
            from = i;
        }
    }
    let shown = session.timeline.shown_index();
    let x = cell(shown, shown + 1).center().x;
    let line = [pos2(x, rect.top() - 2.0), pos2(x, rect.bottom() + 2.0)];
    painter.line_segment(line, Stroke::new(3.5, ui.visuals().window_fill));
    painter.line_segment(line, Stroke::new(1.5, ui.visuals().strong_text_color()));
    if response.has_focus() {
        painter.rect_stroke(rect, 2.0, (1.0, Palette::of(ui).accent), egui::StrokeKind::Outside);
    }

    let at = |x: f32| (((x - rect.left()) / width).max(0.0) as usize).min(states.len() - 1);
    if response.clicked()
        && let Some(pointer) = response.interact_pointer_pos()
    {
        actions.push(Action::ShowState(at(pointer.x)));
    }
    if response.has_focus() {
        let step = ui
            .input(|i| i32::from(i.key_pressed(Key::ArrowRight)) - i32::from(i.key_pressed(Key::ArrowLeft)));
        if step != 0 {
            actions.push(Action::ShowState(shown.saturating_add_signed(step as isize)));
        }
    }
    let hovered = response.hover_pos().map(|p| at(p.x));
    response.on_hover_ui_at_pointer(|ui| {
        let Some(i) = hovered else { return };
        ui.horizontal(|ui| {
            let label = label_in(i);
            let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, color(label));
            let whose =
                if label == UNASSIGNED { "unassigned".to_owned() } else { format!("primitive {label}") };
            ui.label(format!("{}: {whose}", StateName::of(states, i).place()));
        });
        ui.label(
            RichText::new("Click to show this state").font(FontId::proportional(11.0)).color(weak_of(ui)),
        );
    });
}

fn weak_of(ui: &Ui) -> Color32 {
    Palette::of(ui).weak
}
