//! Many pictures on one: a contact sheet.

use image::{Rgba, RgbaImage};

use super::blending::blend;
use super::lettering::Line;
use super::painter::Painter;
use super::theme::Theme;

/// Pixels around the sheet, between its cells, between picture and caption.
const PADDING: u32 = 36;
const GAP: u32 = 28;
const CAPTION_GAP: u32 = 10;
/// Height of the two lines of a caption, and their fonts.
const CAPTION: u32 = 46;
const NAME: f32 = 18.0;
const DETAIL: f32 = 14.5;
/// Radius of the corners of a picture.
const CORNER: f32 = 10.0;
/// Pixels of the largest sheet: 1 GiB.
const MOST_PIXELS: u64 = 1 << 28;
/// Form of a sheet that is neither wide nor high, width / height.
const FORM: f64 = 1.5;

/// Why there is no sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SheetError {
    #[error("nothing to show on the sheet")]
    Empty,
    #[error(
        "a sheet of {cells} cells would have {width} × {height} pixels, which is too large; reduce the cell \
         size"
    )]
    TooLarge { cells: usize, width: u64, height: u64 },
}

/// A contact sheet that is being filled, row by row.
#[derive(Debug)]
pub struct Sheet {
    picture: RgbaImage,
    theme: Theme,
    cell: [u32; 2],
    columns: u32,
    filled: u32,
}

impl Sheet {
    /// An empty sheet for so many pictures of `cell` pixels; `columns` of them
    /// side by side, or as many as give it its usual form.
    ///
    /// # Errors
    /// [`SheetError`] where it would be empty or too large.
    pub fn new(
        theme: Theme,
        is_transparent: bool,
        cell: [u32; 2],
        cells: usize,
        columns: Option<u32>,
    ) -> Result<Self, SheetError> {
        if cells == 0 {
            return Err(SheetError::Empty);
        }
        let count = u32::try_from(cells).unwrap_or(u32::MAX);
        let columns = columns.unwrap_or_else(|| usual_columns(cell, count)).clamp(1, count);
        let rows = count.div_ceil(columns);
        let side = |n: u32, step: u32| u64::from(n) * u64::from(step + GAP) + u64::from(2 * PADDING - GAP);
        let (width, height) = (side(columns, cell[0]), side(rows, cell[1] + CAPTION_GAP + CAPTION));
        let too_large = SheetError::TooLarge { cells, width, height };
        let (Ok(w), Ok(h)) = (u32::try_from(width), u32::try_from(height)) else { return Err(too_large) };
        if width * height > MOST_PIXELS {
            return Err(too_large);
        }
        let [r, g, b] = match theme {
            Theme::Dark => [16, 18, 21],
            Theme::Light => [255, 255, 255],
        };
        let background = Rgba([r, g, b, if is_transparent { 0 } else { 255 }]);
        Ok(Self { picture: RgbaImage::from_pixel(w, h, background), theme, cell, columns, filled: 0 })
    }

    /// Puts a picture of the cells' size into the next cell, with its name and
    /// what is to be said of it beneath.
    pub fn add(&mut self, painter: &mut Painter, picture: &RgbaImage, name: &str, detail: &str) {
        let [left, top] = self.next();
        for (x, y, pixel) in picture.enumerate_pixels() {
            let [r, g, b, a] = pixel.0;
            let cover = rounded([x, y], self.cell) * f32::from(a) / 255.0;
            blend(&mut self.picture, [left + i64::from(x), top + i64::from(y)], [r, g, b], cover);
        }
        self.caption(painter, [left, top], name, detail, self.theme.weak());
    }

    /// Leaves the next cell empty but for why there is no picture.
    pub fn add_missing(&mut self, painter: &mut Painter, name: &str, problem: &str) {
        let [left, top] = self.next();
        let [width, height] = self.cell;
        for y in 0..height {
            for x in 0..width {
                let cover = 0.06 * rounded([x, y], self.cell);
                let at = [left + i64::from(x), top + i64::from(y)];
                blend(&mut self.picture, at, self.theme.weak(), cover);
            }
        }
        let inset = (width as f32 * 0.08).round();
        let line = Line {
            at: [left as f32 + inset, top as f32 + (height as f32 * 0.3).round()],
            size: DETAIL,
            width: width as f32 - 2.0 * inset,
            rows: ((height as f32 * 0.6 / (1.3 * DETAIL)) as usize).max(1),
            color: self.theme.weak(),
        };
        painter.lettering().write(&mut self.picture, problem, &line);
        self.caption(painter, [left, top], name, "no picture", self.theme.error());
    }

    /// The sheet as it is by now.
    pub fn into_picture(self) -> RgbaImage {
        self.picture
    }

    /// Upper left corner of the next cell.
    fn next(&mut self) -> [i64; 2] {
        let (column, row) = (self.filled % self.columns, self.filled / self.columns);
        self.filled += 1;
        let [width, height] = self.cell;
        let at = |n: u32, step: u32| i64::from(PADDING) + i64::from(n) * i64::from(step + GAP);
        [at(column, width), at(row, height + CAPTION_GAP + CAPTION)]
    }

    fn caption(
        &mut self,
        painter: &mut Painter,
        [left, top]: [i64; 2],
        name: &str,
        detail: &str,
        color: [u8; 3],
    ) {
        let [width, height] = self.cell;
        let at = [left as f32 + 4.0, (top + i64::from(height + CAPTION_GAP)) as f32];
        let width = width as f32 - 8.0;
        let line = Line { at, size: NAME, width, rows: 1, color: self.theme.ink() };
        painter.lettering().write(&mut self.picture, name, &line);
        let below = Line { at: [at[0], at[1] + 25.0], size: DETAIL, color, ..line };
        painter.lettering().write(&mut self.picture, detail, &below);
    }
}

/// As many columns as give the sheet its form.
fn usual_columns(cell: [u32; 2], count: u32) -> u32 {
    let width = f64::from(cell[0] + GAP);
    let height = f64::from(cell[1] + CAPTION_GAP + CAPTION + GAP);
    (f64::from(count) * FORM * height / width).sqrt().round() as u32
}

/// How much of a pixel lies within a rectangle with round corners.
fn rounded([x, y]: [u32; 2], [width, height]: [u32; 2]) -> f32 {
    let inset = |at: u32, size: u32| {
        let at = at as f32 + 0.5;
        (CORNER - at).max(at - (size as f32 - CORNER)).max(0.0)
    };
    let (dx, dy) = (inset(x, width), inset(y, height));
    (CORNER + 0.5 - dx.hypot(dy)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_have_room_for_their_cells_and_a_pleasant_form() {
        for (count, columns) in [(1, 1), (2, 2), (6, 3), (100, 12)] {
            let sheet = Sheet::new(Theme::Dark, false, [480, 360], count, None).unwrap();
            assert!(sheet.columns.abs_diff(columns) <= 1, "{count} in {} columns", sheet.columns);
            let mut last = [0; 2];
            let mut sheet = sheet;
            for _ in 0..count {
                last = sheet.next();
            }
            let (width, height) = sheet.picture.dimensions();
            assert!(last[0] + 480 + i64::from(PADDING) <= i64::from(width));
            assert_eq!(last[1] + i64::from(360 + CAPTION_GAP + CAPTION + PADDING), i64::from(height));
        }
        let fixed = Sheet::new(Theme::Light, true, [100, 100], 5, Some(2)).unwrap();
        assert_eq!(fixed.picture.width(), 2 * PADDING + 2 * 100 + GAP);
        assert_eq!(Sheet::new(Theme::Dark, false, [9, 9], 0, None).unwrap_err(), SheetError::Empty);
        let huge = Sheet::new(Theme::Dark, false, [16_000, 16_000], 100, None).unwrap_err();
        assert!(huge.to_string().contains("too large"), "{huge}");
    }

    #[test]
    fn corners_are_round() {
        let cover = |at| rounded(at, [100, 60]);
        assert_eq!([cover([0, 0]), cover([99, 59]), cover([0, 30]), cover([50, 0])], [0.0, 0.0, 1.0, 1.0]);
        assert!(cover([3, 3]) > 0.0 && cover([3, 3]) < 1.0 || cover([2, 3]) < 1.0);
    }
}
