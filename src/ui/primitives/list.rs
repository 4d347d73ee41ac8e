//! The list of primitives: one row each, to select, hide, lock and sort.

use std::cmp::Ordering;

use egui::{
    Align2, Button, FontId, Key, Label, Modifiers, Rect, Response, RichText, Role, ScrollArea, Sense, Ui,
    WidgetInfo, pos2, vec2,
};

use crate::inference::{Edit, Primitive};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::selection::Select;
use crate::session::verb::Verb;
use crate::ui::theme::{self, Palette};
use crate::ui::widgets::{count, eye, focus_ring, follow_focus, length, menu_item};

/// Right edges of the columns, from the list's right edge.
const ERROR_COLUMN: f32 = 50.0;
const POINTS_COLUMN: f32 = 114.0;
/// Left edge of the ids.
const ID_COLUMN: f32 = 26.0;
/// Minimum number of visible rows.
const FEWEST_ROWS: f32 = 3.0;

/// Sort key of the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Column {
    Id,
    #[default]
    Points,
    Error,
}

impl Column {
    const ALL: [Self; 3] = [Self::Id, Self::Points, Self::Error];

    fn text(self) -> &'static str {
        match self {
            Self::Id => "Id",
            Self::Points => "Points",
            Self::Error => "Mean error",
        }
    }

    fn tooltip(self) -> &'static str {
        match self {
            Self::Id => "Sort by id. A primitive keeps its id throughout the run",
            Self::Points => "Sort by number of assigned samples",
            Self::Error => {
                "Sort by mean distance of the assigned samples to the surface, in the file's units"
            }
        }
    }

    /// Default order: ids ascending, others descending.
    fn compare(self, a: &Primitive, b: &Primitive) -> Ordering {
        let order = match self {
            Self::Id => Ordering::Equal,
            Self::Points => b.points.cmp(&a.points),
            Self::Error => b.mean_distance.total_cmp(&a.mean_distance),
        };
        order.then(a.id.cmp(&b.id))
    }
}

/// State of the list.
#[derive(Debug, Default)]
pub(super) struct List {
    column: Column,
    is_reversed: bool,
    /// Start of a range: the primitive, by id, that was last selected alone.
    anchor: Option<u32>,
    /// The other end of that range.
    tip: Option<u32>,
    /// The primitive, by id, that was selected alone, and the height of the rows
    /// then: where one of them changes, its row is scrolled to.
    seen: Option<(u32, f32)>,
}

impl List {
    /// The rows end at `bottom`, except for the minimum number of rows.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &Session, bottom: f32, actions: &mut Vec<Action>) {
        let primitives = session.primitives();
        title(ui, session, actions);
        if primitives.is_empty() {
            let text = if session.loaded.is_some() {
                "No primitives in this state"
            } else {
                "Open a shape to see its primitives"
            };
            ui.add(Label::new(RichText::new(text).color(Palette::of(ui).weak)).wrap());
            return;
        }
        self.header(ui);
        let mut order: Vec<&Primitive> = primitives.iter().collect();
        order.sort_by(|a, b| self.column.compare(a, b));
        if self.is_reversed {
            order.reverse();
        }
        let target = self.step(ui, &order, actions);
        let height = (bottom - ui.cursor().top()).max(FEWEST_ROWS * theme::ROW);
        let selected = session.selected_primitive().map(|p| (p.id, height));
        let is_new = selected.is_some() && selected != self.seen;
        self.seen = selected;
        let row_of = |(id, _)| order.iter().position(|p| p.id == id);
        let target = target.or_else(|| selected.filter(|_| is_new).and_then(row_of));
        let pitch = theme::ROW + ui.spacing().item_spacing.y;
        ScrollArea::vertical().auto_shrink([false, true]).animated(false).max_height(height).show_rows(
            ui,
            theme::ROW,
            order.len(),
            |ui, rows| {
                if let Some(target) = target {
                    let top = ui.max_rect().top() + (target as f32 - rows.start as f32) * pitch;
                    let row = Rect::from_x_y_ranges(ui.max_rect().x_range(), top..=top + theme::ROW);
                    ui.scroll_to_rect(row, None);
                }
                for index in rows {
                    self.row(ui, session, &order, index, actions);
                }
                follow_focus(ui);
            },
        );
    }

    fn header(&mut self, ui: &mut Ui) {
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 18.0), Sense::hover());
        let edge = |column| match column {
            Column::Id => rect.left() + ID_COLUMN,
            Column::Points => rect.right() - POINTS_COLUMN,
            Column::Error => rect.right() - ERROR_COLUMN,
        };
        let between = 4.0;
        for column in Column::ALL {
            let is_sorted = self.column == column;
            let (left, right, align) = match column {
                Column::Id => (edge(column), edge(column) + 34.0, Align2::LEFT_CENTER),
                Column::Points => (edge(column) - 58.0, edge(column) + between, Align2::RIGHT_CENTER),
                Column::Error => {
                    (edge(Column::Points) + between, edge(column) + between, Align2::RIGHT_CENTER)
                }
            };
            let cell = Rect::from_x_y_ranges(left..=right, rect.y_range());
            let response = ui.interact(cell, ui.scope_id().with(column.text()), Sense::click());
            let name = format!("Sort by {}", column.text().to_lowercase());
            response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_sorted, &name));
            let color = if response.hovered() || response.has_focus() {
                ui.visuals().strong_text_color()
            } else if is_sorted {
                ui.visuals().text_color()
            } else {
                Palette::of(ui).weak
            };
            let at = pos2(if align == Align2::LEFT_CENTER { left } else { right - between }, cell.center().y);
            let text = ui.painter().text(at, align, column.text(), FontId::proportional(11.0), color);
            if is_sorted {
                let is_upwards = self.is_reversed != (column == Column::Id);
                let tip = if align == Align2::LEFT_CENTER { text.right() + 6.0 } else { text.left() - 6.0 };
                paint_arrow(ui, pos2(tip, cell.center().y), is_upwards, color);
            }
            if response.on_hover_text(column.tooltip()).clicked() {
                self.is_reversed = is_sorted && !self.is_reversed;
                self.column = column;
            }
        }
    }

    /// Up and down move the selection; Shift extends it. Returns the row to scroll to.
    fn step(&mut self, ui: &Ui, order: &[&Primitive], actions: &mut Vec<Action>) -> Option<usize> {
        // Anything else that was reached by the keyboard has a use of its own for them.
        let focused = ui.memory(|memory| memory.focused());
        if focused.is_some_and(|id| !order.iter().any(|p| row_id(p.id) == id)) {
            return None;
        }
        let (step, widens) = ui.input_mut(|input| {
            let mut pressed = |modifiers, key| input.consume_key(modifiers, key);
            // With Shift first: without it any would do.
            let wide = i32::from(pressed(Modifiers::SHIFT, Key::ArrowDown))
                - i32::from(pressed(Modifiers::SHIFT, Key::ArrowUp));
            let narrow = i32::from(pressed(Modifiers::NONE, Key::ArrowDown))
                - i32::from(pressed(Modifiers::NONE, Key::ArrowUp));
            if wide != 0 { (wide, true) } else { (narrow, false) }
        });
        if step == 0 {
            return None;
        }
        let place = |id: Option<u32>| order.iter().position(|p| Some(p.id) == id);
        let last = order.len() - 1;
        let target = match place(self.tip) {
            Some(at) if step < 0 => at.saturating_sub(1),
            Some(at) => (at + 1).min(last),
            None if step < 0 => last,
            None => 0,
        };
        let id = order[target].id;
        self.tip = Some(id);
        match (widens, place(self.anchor)) {
            (true, Some(anchor)) => actions.push(select_range(order, anchor, target, Select::Replace)),
            _ => {
                self.anchor = Some(id);
                actions.push(Action::Select(Some(id)));
            }
        }
        Some(target)
    }

    fn row(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        order: &[&Primitive],
        index: usize,
        actions: &mut Vec<Action>,
    ) {
        let primitive = order[index];
        let id = primitive.id;
        let is_selected = session.selection.contains(&id);
        let is_visible = !session.hidden.contains(&id);
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::hover());
        let response = ui.interact(rect, row_id(id), Sense::click());
        let name = format!("Primitive {id}");
        response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_selected, &name));
        paint_row(ui, session, primitive, rect, &response);

        let square = |right: f32| Rect::from_min_size(pos2(right, rect.top()), vec2(theme::ROW, theme::ROW));
        let eye_rect = square(rect.right() - theme::ROW - 1.0);
        let toggles_eye = ui
            .scope_builder(egui::UiBuilder::new().max_rect(eye_rect), |ui| {
                eye(ui, is_visible, &format!("Primitive {id} in the viewport")).clicked()
            })
            .inner;
        let lock_rect = square(rect.right() - 2.0 * theme::ROW - 1.0);
        let toggles_lock = lock(ui, session, primitive, lock_rect, response.contains_pointer());
        if toggles_eye {
            actions.push(Action::SetPrimitiveVisible(id, !is_visible));
        } else if toggles_lock {
            actions.push(Action::Edit(Edit::Lock { id, locked: !primitive.locked }));
        } else if response.double_clicked() {
            self.choose(id, actions);
            actions.push(Action::Verb(Verb::FrameSelection));
        } else if response.clicked() {
            self.click(ui, session, order, index, actions);
        } else if response.secondary_clicked() && !is_selected {
            self.choose(id, actions);
        }
        response.context_menu(|ui| menu(ui, session, actions));
    }

    fn click(
        &mut self,
        ui: &Ui,
        session: &Session,
        order: &[&Primitive],
        index: usize,
        actions: &mut Vec<Action>,
    ) {
        let id = order[index].id;
        let Modifiers { shift, command, .. } = ui.input(|i| i.modifiers);
        let anchor = order.iter().position(|p| Some(p.id) == self.anchor);
        match (shift, anchor) {
            (true, Some(anchor)) => {
                let how = if command { Select::Add } else { Select::Replace };
                self.tip = Some(id);
                actions.push(select_range(order, anchor, index, how));
            }
            _ if shift || command => {
                (self.anchor, self.tip) = (Some(id), Some(id));
                actions.push(Action::ToggleSelected(id));
            }
            _ if session.selection.len() == 1 && session.selection.contains(&id) => {
                actions.push(Action::Select(None));
            }
            _ => self.choose(id, actions),
        }
    }

    fn choose(&mut self, id: u32, actions: &mut Vec<Action>) {
        (self.anchor, self.tip) = (Some(id), Some(id));
        actions.push(Action::Select(Some(id)));
    }
}

fn title(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Primitives").strong());
        ui.label(RichText::new(count(session.primitives().len())).color(Palette::of(ui).weak));
        if !session.hidden.is_empty() {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let entry = Verb::ShowAll.entry();
                if ui.add(Button::new("Show all").small()).on_hover_text(entry.tooltip).clicked() {
                    actions.push(Action::Verb(Verb::ShowAll));
                }
            });
        }
    });
}

/// Actions on the selection.
fn menu(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    let groups: [&[Verb]; 3] = [
        &[Verb::FrameSelection, Verb::HideSelected],
        &[
            Verb::RefitSelected,
            Verb::LockSelected,
            Verb::SplitSelected,
            Verb::JudgeMerge,
            Verb::MergeSelected,
        ],
        &[Verb::DeleteSelected],
    ];
    for (i, verbs) in groups.iter().enumerate() {
        if i > 0 {
            ui.separator();
        }
        for &verb in *verbs {
            menu_item(ui, session, verb, actions);
        }
    }
}

fn row_id(id: u32) -> egui::Id {
    egui::Id::unique(("row of primitive", id))
}

fn select_range(order: &[&Primitive], a: usize, b: usize, how: Select) -> Action {
    let ids = order[a.min(b)..=a.max(b)].iter().map(|p| p.id).collect();
    Action::SelectPrimitives { ids, how }
}

fn paint_row(ui: &Ui, session: &Session, primitive: &Primitive, rect: Rect, response: &Response) {
    let id = primitive.id;
    let visuals = ui.visuals();
    if session.selection.contains(&id) {
        ui.painter().rect_filled(rect, 3.0, visuals.selection.bg_fill);
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 3.0, visuals.faint_bg_color);
    }
    focus_ring(ui, response);
    let strength = if session.hidden.contains(&id) { 0.4 } else { 1.0 };
    let color = theme::data_color(session.color_of(id)).gamma_multiply(strength);
    let swatch = Rect::from_center_size(pos2(rect.left() + 12.0, rect.center().y), vec2(12.0, 12.0));
    ui.painter().rect_filled(swatch, 3.0, color);
    let text_color = visuals.text_color().gamma_multiply(strength);
    let text = |x: f32, align: Align2, text: String| {
        ui.painter().text(pos2(x, rect.center().y), align, text, FontId::proportional(13.0), text_color);
    };
    text(rect.left() + ID_COLUMN, Align2::LEFT_CENTER, id.to_string());
    text(rect.right() - POINTS_COLUMN, Align2::RIGHT_CENTER, count(primitive.points));
    text(rect.right() - ERROR_COLUMN, Align2::RIGHT_CENTER, length(primitive.mean_distance));
}

/// A padlock, closed if the primitive is locked. An open one is visible only in
/// the row under the pointer. Returns whether it was clicked.
fn lock(ui: &mut Ui, session: &Session, primitive: &Primitive, rect: Rect, is_near: bool) -> bool {
    let Primitive { id, locked, .. } = *primitive;
    let can = session.can_edit();
    let response = ui.interact(rect, ui.scope_id().with(("lock", id)), Sense::click());
    response
        .widget_info(|| WidgetInfo::selected(Role::CheckBox, can, locked, format!("Lock primitive {id}")));
    let color = if response.hovered() || response.has_focus() {
        ui.visuals().strong_text_color()
    } else if locked {
        ui.visuals().text_color()
    } else {
        Palette::of(ui).weak.gamma_multiply(0.7)
    };
    if locked || is_near || response.has_focus() {
        paint_padlock(ui, rect.center(), locked, color);
    }
    let text = if let Some(why) = session.reason(Verb::LockSelected).filter(|_| !can) {
        why.to_owned()
    } else if locked {
        format!("Unlock primitive {id}: the sampler can change it and its points again")
    } else {
        format!(
            "Lock primitive {id}: the sampler does not change it or its points, even when the run restarts"
        )
    };
    response.on_hover_text(text).clicked() && can
}

fn paint_padlock(ui: &Ui, center: egui::Pos2, is_shut: bool, color: egui::Color32) {
    let painter = ui.painter();
    let stroke = egui::Stroke::new(1.4, color);
    let body = Rect::from_center_size(center + vec2(0.0, 2.5), vec2(9.0, 7.0));
    let arc = |x: f32| -> Vec<egui::Pos2> {
        let top = pos2(center.x + x, body.top() - 2.0);
        let mut path = vec![pos2(top.x - 3.0, body.top())];
        path.extend((0..=8).map(|i| {
            let turn = std::f32::consts::PI * (1.0 - i as f32 / 8.0);
            top + vec2(3.0 * turn.cos(), -3.0 * turn.sin())
        }));
        if x == 0.0 {
            path.push(pos2(top.x + 3.0, body.top()));
        }
        path
    };
    if is_shut {
        painter.rect_filled(body, 1.5, color);
        painter.line(arc(0.0), stroke);
    } else {
        painter.rect_stroke(body, 1.5, stroke, egui::StrokeKind::Inside);
        painter.line(arc(4.5), stroke);
    }
}

fn paint_arrow(ui: &Ui, center: egui::Pos2, is_upwards: bool, color: egui::Color32) {
    let up = if is_upwards { -1.0 } else { 1.0 };
    let corners = [vec2(-3.0, -1.5 * up), vec2(3.0, -1.5 * up), vec2(0.0, 2.0 * up)];
    let triangle = corners.map(|c| center + c).to_vec();
    ui.painter().add(egui::Shape::convex_polygon(triangle, color, egui::Stroke::NONE));
}
