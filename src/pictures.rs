//! Pictures without a window, as the window would draw them: of results, of
//! sessions and of plain shapes, one by one, turning, or many on one sheet.
//!
//! ```text
//! file → Subject ─ View, Theme ─▶ Painter::take → Stage ─ Camera ─▶ Painter::picture → RgbaImage → Sheet
//! ```
//!
//! A [`Subject`] is plain data and needs no graphics driver; a [`Painter`] does.

pub mod frame;

mod blending;
mod framing;
mod legend;
mod lettering;
mod painter;
mod sheet;
mod subject;
mod theme;

pub use painter::{Painter, Stage};
pub use sheet::{Sheet, SheetError};
pub use subject::{Figures, Subject, SubjectError};
pub use theme::Theme;
