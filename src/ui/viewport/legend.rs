//! The colour bar: which number a colour stands for.

use egui::{Align2, Color32, FontId, Mesh, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};

use crate::render::colormap::viridis;
use crate::ui::scene::Scene;
use crate::ui::theme::{Palette, data_color};
use crate::ui::widgets::length;

/// Logical pixels.
const BAR: egui::Vec2 = vec2(12.0, 132.0);
const PADDING: f32 = 9.0;
const TICKS: usize = 4;
const STRIPES: usize = 48;

pub(super) fn show(ui: &Ui, scene: &Scene, rect: Rect) {
    let Some((title, (low, high), exceeds)) = scene.legend() else { return };
    let palette = Palette::of(ui);
    let font = FontId::proportional(11.0);
    let text = |text: String, color: Color32| ui.painter().layout_no_wrap(text, font.clone(), color);
    let heading = text(title.to_owned(), ui.visuals().text_color());
    let numbers: Vec<_> = (0..=TICKS)
        .map(|i| {
            let value = low + (high - low) * i as f32 / TICKS as f32;
            let above = if i == TICKS && exceeds { "≥ " } else { "" };
            text(format!("{above}{}", length(f64::from(value))), palette.weak)
        })
        .collect();
    let widest = numbers.iter().map(|n| n.size().x).fold(0.0, f32::max);
    let width = heading.size().x.max(BAR.x + 8.0 + widest) + 2.0 * PADDING;
    let height = BAR.y + heading.size().y + 8.0 + 2.0 * PADDING;
    if width + 20.0 > rect.width() || height + 150.0 > rect.height() {
        return;
    }
    let panel =
        Rect::from_min_size(rect.right_bottom() - vec2(width + 10.0, height + 44.0), vec2(width, height));
    let response = ui.interact(panel, ui.scope_id().with("legend"), Sense::hover());
    let label = format!("{title} from {} to {}", length(f64::from(low)), length(f64::from(high)));
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &label));
    response.on_hover_text(format!("{title}, in the file's units. Grey is without a number"));

    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(panel, 5.0, palette.overlay.gamma_multiply(0.86));
    painter.galley(panel.min + vec2(PADDING, PADDING), heading.clone(), Color32::PLACEHOLDER);
    let bar = Rect::from_min_size(panel.min + vec2(PADDING, PADDING + heading.size().y + 8.0), BAR);
    let mut mesh = Mesh::default();
    for i in 0..=STRIPES {
        let share = i as f32 / STRIPES as f32;
        let color = data_color(viridis(share));
        let y = bar.bottom() - share * bar.height();
        mesh.colored_vertex(pos2(bar.left(), y), color);
        mesh.colored_vertex(pos2(bar.right(), y), color);
        if i > 0 {
            let k = 2 * i as u32;
            mesh.add_triangle(k - 2, k - 1, k);
            mesh.add_triangle(k - 1, k + 1, k);
        }
    }
    painter.add(Shape::mesh(mesh));
    for (i, number) in numbers.into_iter().enumerate() {
        let y = bar.bottom() - i as f32 / TICKS as f32 * bar.height();
        let tick = [pos2(bar.right(), y), pos2(bar.right() + 4.0, y)];
        painter.line_segment(tick, Stroke::new(1.0, palette.weak));
        let at = Align2::LEFT_CENTER.anchor_size(pos2(bar.right() + 8.0, y), number.size());
        painter.galley(at.min, number, Color32::PLACEHOLDER);
    }
}
