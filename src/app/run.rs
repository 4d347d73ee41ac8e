//! Opening the window.

use std::sync::mpsc::channel;
use std::time::Instant;

use super::{App, Options, Start, place};
use crate::cli::Journal;

/// Smallest size of the window, in logical pixels.
const MIN_SIZE: [f32; 2] = [480.0, 320.0];

/// Why [`run`] gave up.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// There is no display, no driver, or the window system refuses.
    #[error("cannot open the window: {0}")]
    NoWindow(String),
    /// The window was there, but the screenshot that was asked for could not
    /// be made: the shape can't be loaded, or the picture not written.
    #[error("{0}")]
    NoPicture(String),
}

/// The icon of the window, where the system doesn't take that of the menu entry.
fn icon() -> egui::IconData {
    const ICON: &[u8] = include_bytes!("../../assets/icon.png");
    eframe::icon_data::from_png_bytes(ICON).unwrap_or_else(|error| {
        tracing::warn!("cannot set the window icon: {error}");
        egui::IconData::default()
    })
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// See [`RunError`].
pub fn run(options: Options, journal: Option<Journal>) -> Result<(), RunError> {
    let begun = Instant::now();
    let (sender, outcome) = channel();
    let wants_picture = options.screenshot.is_some();
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Superform")
            .with_app_id("superform")
            .with_icon(icon())
            .with_inner_size(place::SIZE)
            .with_min_inner_size(MIN_SIZE)
            .with_drag_and_drop(true),
        // See there.
        persist_window: false,
        ..Default::default()
    };
    eframe::run_native(
        "Superform",
        native,
        Box::new(move |cc| {
            tracing::debug!(after = ?begun.elapsed(), "the window has a device");
            let mut app = App::new(cc, &options)?;
            tracing::debug!(after = ?begun.elapsed(), "the window has its pipelines");
            app.outcome = Some(sender);
            app.start = Start::Since(begun);
            if let Some(journal) = journal {
                app.listen(journal);
            }
            Ok(Box::new(app))
        }),
    )
    .map_err(|error| RunError::NoWindow(error.to_string()))?;
    match outcome.try_recv() {
        Ok(result) => result.map_err(|error| RunError::NoPicture(format!("{error:#}"))),
        Err(_) if wants_picture => {
            Err(RunError::NoPicture("the window was closed before the screenshot was taken".to_owned()))
        }
        Err(_) => Ok(()),
    }
}
