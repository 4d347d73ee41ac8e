//! The tables that a point could join, one per row.

use egui::{Align2, Color32, FontId, Rect, Response, Role, Sense, Ui, WidgetInfo, pos2, vec2};

use crate::inference::{NewTable, Odds};
use crate::session::Session;
use crate::ui::theme::{Palette, data_color};
use crate::ui::widgets::{count, figure, length};

/// Height of a row in logical pixels.
const HEIGHT: f32 = 19.0;
const SWATCH: f32 = 10.0;
/// Right edges of the columns n, d, N and weight, from the left.
const COLUMNS: [f32; 4] = [92.0, 146.0, 200.0, 258.0];
const GAP: f32 = 6.0;
/// Width of a share in percent.
const NUMBER: f32 = 54.0;

/// A table that the point could join.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Table {
    /// By the id of its primitive.
    Present(u32),
    New,
}

/// A table with its odds.
#[derive(Debug, Clone, Copy)]
pub(super) enum Row<'a> {
    Present(&'a Odds),
    New(&'a NewTable),
}

impl Row<'_> {
    pub(super) fn table(&self) -> Table {
        match self {
            Self::Present(odds) => Table::Present(odds.id),
            Self::New(_) => Table::New,
        }
    }

    pub(super) fn probability(&self) -> f64 {
        match self {
            Self::Present(odds) => odds.probability,
            Self::New(new) => new.probability,
        }
    }
}

/// The names of the columns.
pub(super) fn header(ui: &mut Ui) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let color = Palette::of(ui).weak;
    let font = FontId::proportional(11.0);
    ui.painter().text(rect.left_center(), Align2::LEFT_CENTER, "Table", font.clone(), color);
    for (right, name) in COLUMNS.into_iter().zip(["n", "d", "N(d; σ)", "weight"]) {
        let at = pos2(rect.left() + right, rect.center().y);
        ui.painter().text(at, Align2::RIGHT_CENTER, name, font.clone(), color);
    }
    let at = pos2(rect.left() + COLUMNS[3] + 2.0 * GAP, rect.center().y);
    ui.painter().text(at, Align2::LEFT_CENTER, "odds", font, color);
    response.on_hover_text(
        "n: points at the table, without this one\n\
         d: radial distance to the table's primitive, in the file's units\n\
         N(d; σ): noise density, in the sampler's units (the cloud's bounding box has volume 200)\n\
         weight: n · N(d; σ) · ½; for a new table α · p0\n\
         odds: the weight divided by the sum of all weights. Click a row to see its terms",
    );
}

pub(super) fn show(ui: &mut Ui, session: &Session, row: Row<'_>, is_chosen: bool) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click());
    let [name, n, d, density, weight] = match row {
        Row::Present(odds) => [
            format!("{}", odds.id),
            count(odds.n.max(0.0) as usize),
            length(odds.distance_input),
            figure(odds.density),
            figure(odds.weight),
        ],
        Row::New(new) => {
            ["new".to_owned(), "α".to_owned(), String::new(), "p0".to_owned(), figure(new.weight)]
        }
    };
    let odds = percent(row.probability());
    let label = match row {
        Row::Present(_) => {
            format!("Table {name}, n {n}, distance {d}, density {density}, weight {weight}, odds {odds}")
        }
        Row::New(_) => format!("New table, weight {weight}, odds {odds}"),
    };
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_chosen, &label));
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let palette = Palette::of(ui);
    let visuals = ui.style().interact_selectable(&response, is_chosen);
    if is_chosen || response.hovered() || response.has_focus() {
        ui.painter().rect_filled(rect.expand2(vec2(4.0, 0.0)), 3.0, visuals.weak_bg_fill);
    }
    // Weak text would be too weak on what is chosen.
    let is_weak = row.probability() < 5e-4 && !is_chosen && !response.hovered();
    let text = if is_weak { palette.weak } else { ui.visuals().text_color() };
    let font = FontId::proportional(12.0);
    let middle = rect.center().y;
    let color = match row {
        Row::Present(odds) => data_color(session.color_of(odds.id)),
        Row::New(_) => palette.accent,
    };
    let painter = ui.painter();
    let swatch = Rect::from_center_size(pos2(rect.left() + 0.5 * SWATCH, middle), vec2(SWATCH, SWATCH));
    match row {
        Row::Present(_) => painter.rect_filled(swatch, 2.0, color),
        Row::New(_) => painter.rect_stroke(swatch, 2.0, (1.5, color), egui::StrokeKind::Inside),
    };
    let at = pos2(swatch.right() + GAP, middle);
    painter.text(at, Align2::LEFT_CENTER, name, font.clone(), text);
    for (right, value) in COLUMNS.into_iter().zip([n, d, density, weight]) {
        painter.text(pos2(rect.left() + right, middle), Align2::RIGHT_CENTER, value, font.clone(), text);
    }
    bar(ui, rect, row.probability(), odds, color, text);
    response.on_hover_text("Click to see how the weight is computed")
}

/// The share of all weights, as a bar with its value.
fn bar(ui: &Ui, row: Rect, share: f64, number: String, color: Color32, text: Color32) {
    let painter = ui.painter();
    let middle = row.center().y;
    painter.text(pos2(row.right(), middle), Align2::RIGHT_CENTER, number, FontId::proportional(11.0), text);
    let from = row.left() + COLUMNS[3] + 2.0 * GAP;
    let room = Rect::from_x_y_ranges(from..=row.right() - NUMBER, row.top() + 4.0..=row.bottom() - 4.0);
    if room.width() < 8.0 {
        return;
    }
    painter.rect_filled(room, 2.0, ui.visuals().extreme_bg_color);
    let mut full = room;
    full.set_width(room.width() * share.clamp(0.0, 1.0) as f32);
    painter.rect_filled(full, 2.0, color);
}

/// A small square in a primitive's colour.
pub(super) fn swatch(ui: &mut Ui, color: [u8; 3]) {
    let (rect, _) = ui.allocate_exact_size(vec2(SWATCH, SWATCH), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, data_color(color));
}

/// A share of 1 in percent.
pub(super) fn percent(share: f64) -> String {
    let p = 100.0 * share;
    if !p.is_finite() {
        "–".to_owned()
    } else if p > 0.0 && p < 0.01 {
        "< 0.01 %".to_owned()
    } else if p < 99.995 && p > 99.0 || p < 1.0 {
        format!("{p:.2} %")
    } else {
        format!("{p:.1} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_never_lie_about_zero() {
        assert_eq!(percent(1.0), "100.0 %");
        assert_eq!(percent(0.9993), "99.93 %");
        assert_eq!(percent(0.5), "50.0 %");
        assert_eq!(percent(0.0), "0.00 %");
        assert_eq!(percent(1e-9), "< 0.01 %");
    }
}
