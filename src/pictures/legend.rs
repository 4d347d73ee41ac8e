//! The colour bar of a picture whose colours tell numbers.

use image::RgbaImage;

use super::blending::blend;
use super::lettering::{Lettering, Line};
use super::theme::Theme;
use crate::render::colormap::viridis;

/// Logical pixels.
const MARGIN: f32 = 22.0;
const BAR: [f32; 2] = [190.0, 10.0];
const FONT: f32 = 14.0;
const GAP: f32 = 6.0;
/// Text smaller than this can't be read, however small the picture.
const LEAST_SCALE: f32 = 0.75;

/// What a colour bar says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Legend {
    pub(super) title: String,
    /// The first and the last number with a colour of its own, in input units.
    pub(super) range: (f32, f32),
    /// Whether larger numbers share the last colour.
    pub(super) is_cut: bool,
}

/// Draws it in the lower left corner, where there is room.
pub(super) fn draw(
    picture: &mut RgbaImage,
    lettering: &mut Lettering,
    legend: &Legend,
    theme: Theme,
    scale: f32,
) {
    let scale = scale.max(LEAST_SCALE);
    let [width, height] = BAR.map(|side| (side * scale).round());
    let (margin, font, gap) = ((MARGIN * scale).round(), FONT * scale, (GAP * scale).round());
    let all = height + 2.0 * (gap + 1.3 * font);
    let (picture_width, picture_height) = (picture.width() as f32, picture.height() as f32);
    if width + 2.0 * margin > picture_width || all + 2.0 * margin > picture_height {
        return;
    }
    let top = (picture_height - margin - all).round();
    let room = picture_width - 2.0 * margin;
    let line = Line { at: [margin, top], size: font, width: room, rows: 1, color: theme.ink() };
    let [_, title] = lettering.write(picture, &legend.title, &line);
    let bar = (top + title + gap).round();
    for x in 0..width as i64 {
        let color = viridis(x as f32 / (width - 1.0));
        for y in 0..height as i64 {
            blend(picture, [margin as i64 + x, bar as i64 + y], color, 1.0);
        }
    }
    let below = Line { at: [margin, bar + height + gap], color: theme.weak(), ..line };
    lettering.write(picture, &number(legend.range.0), &below);
    let last = format!("{}{}", if legend.is_cut { "≥ " } else { "" }, number(legend.range.1));
    let left = margin + width - lettering.width(&last, font);
    lettering.write(picture, &last, &Line { at: [left, below.at[1]], ..below });
}

/// Short, whatever the unit.
fn number(value: f32) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-4..1e5).contains(&size) {
        let digits = (2 - size.max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in
            [(0.0, "0"), (0.015, "0.015"), (8.0, "8"), (1500.0, "1500"), (2e-7, "2.0e-7"), (3e9, "3.0e9")]
        {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn a_legend_needs_room_and_stays_in_its_corner() {
        let legend = Legend { title: "Distance".to_owned(), range: (0.0, 0.02), is_cut: true };
        let draw_on = |width, height| {
            let mut picture = RgbaImage::new(width, height);
            draw(&mut picture, &mut Lettering::default(), &legend, Theme::Dark, 1.0);
            picture
        };
        assert!(draw_on(100, 300).pixels().all(|p| p[3] == 0), "too narrow");
        let drawn = draw_on(600, 400);
        let inked = |of: &dyn Fn(u32, u32) -> bool| {
            drawn.enumerate_pixels().filter(|(x, y, p)| p[3] > 0 && of(*x, *y)).count()
        };
        assert!(inked(&|_, _| true) > 2000);
        assert_eq!(inked(&|x, y| x > 300 || y < 250), 0);
    }
}
