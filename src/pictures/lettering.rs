//! Text on pictures, in the window's own font.

use std::sync::Arc;

use egui::epaint::text::{FontId, Fonts, TextOptions};
use egui::text::{FontDefinitions, LayoutJob, TextWrapping};
use egui::{Color32, FontFamily};
use image::RgbaImage;

use super::blending::blend;

/// Writes lines of text.
pub(super) struct Lettering {
    fonts: Fonts,
}

impl std::fmt::Debug for Lettering {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Lettering").finish_non_exhaustive()
    }
}

impl Default for Lettering {
    fn default() -> Self {
        // Places between pixels blur what does not move.
        let options = TextOptions { subpixel_binning: false, ..TextOptions::default() };
        Self { fonts: Fonts::new(options, FontDefinitions::default()) }
    }
}

/// How a line is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// Upper left corner, in pixels.
    pub(super) at: [f32; 2],
    /// Of the font, in pixels.
    pub(super) size: f32,
    /// What does not fit is cut, with an ellipsis.
    pub(super) width: f32,
    /// Text that doesn't fit goes on in further lines, at most so many in all.
    pub(super) rows: usize,
    pub(super) color: [u8; 3],
}

impl Lettering {
    /// Writes a text; returns its size in pixels.
    pub(super) fn write(&mut self, picture: &mut RgbaImage, text: &str, line: &Line) -> [f32; 2] {
        let font = FontId::new(line.size, FontFamily::Proportional);
        let single: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let mut job = LayoutJob::simple(single, font, Color32::WHITE, line.width);
        job.wrap = TextWrapping {
            max_width: line.width,
            max_rows: line.rows,
            break_anywhere: line.rows == 1,
            ..TextWrapping::default()
        };
        let galley = self.fonts.layout_uncached(1.0, Arc::new(job));
        let atlas = self.fonts.texture_atlas().image();
        let stride = atlas.size[0];
        for row in &galley.rows {
            for glyph in row.glyphs.iter().filter(|glyph| !glyph.uv_rect.is_nothing()) {
                let corner = row.pos.to_vec2() + glyph.pos.to_vec2() + glyph.uv_rect.offset;
                let (left, top) = ((line.at[0] + corner.x).round(), (line.at[1] + corner.y).round());
                let (min, max) = (glyph.uv_rect.min.map(usize::from), glyph.uv_rect.max.map(usize::from));
                for v in min[1]..max[1] {
                    for u in min[0]..max[0] {
                        let (x, y) = (left as i64 + (u - min[0]) as i64, top as i64 + (v - min[1]) as i64);
                        let coverage = f32::from(atlas.pixels[v * stride + u].a()) / 255.0;
                        blend(picture, [x, y], line.color, coverage);
                    }
                }
            }
        }
        [galley.rect.width(), galley.rect.height()]
    }

    /// Width of a text in one line, in pixels.
    pub(super) fn width(&mut self, text: &str, size: f32) -> f32 {
        let font = FontId::new(size, FontFamily::Proportional);
        let job = LayoutJob::simple(text.to_owned(), font, Color32::WHITE, f32::INFINITY);
        self.fonts.layout_uncached(1.0, Arc::new(job)).rect.width()
    }
}
