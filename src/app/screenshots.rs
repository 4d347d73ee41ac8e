//! Pictures of the window, written when the window system has taken them.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use anyhow::Context as _;
use egui::ColorImage;

use crate::inference::Phase;
use crate::io;
use crate::session::Session;
use crate::worker::Activity;

/// Frames between the end of the run and its picture: the last state has to
/// be laid out and drawn.
const SETTLING_FRAMES: u32 = 3;

/// The picture that is to be saved when the run has ended.
#[derive(Debug)]
struct PendingPicture {
    path: PathBuf,
    settled_frames: u32,
    is_requested: bool,
}

/// A picture that the window system has taken.
#[derive(Debug)]
struct Picture {
    image: Arc<ColorImage>,
    path: PathBuf,
}

/// What became of a picture.
pub(super) struct Saved {
    pub(super) path: PathBuf,
    pub(super) result: anyhow::Result<()>,
    /// It is the one that the window is there for.
    pub(super) is_last: bool,
}

#[derive(Debug)]
pub(super) struct Screenshots {
    pictures: (SyncSender<Picture>, Receiver<Picture>),
    pending: Option<PendingPicture>,
}

impl Screenshots {
    /// With the path of the picture that the window is there for, if it is.
    pub(super) fn new(path: Option<PathBuf>) -> Self {
        let pending = path.map(|path| PendingPicture { path, settled_frames: 0, is_requested: false });
        Self { pictures: sync_channel(4), pending }
    }

    /// Whether the window is there for a picture that is not saved yet.
    pub(super) fn is_pending(&self) -> bool {
        self.pending.is_some()
    }

    pub(super) fn request(&self, ctx: &egui::Context, path: PathBuf) {
        let sender = self.pictures.0.clone();
        let repaint = ctx.clone();
        ctx.request_screenshot(move |image| {
            // Fails only when the window is closing.
            let _ = sender.try_send(Picture { image, path });
            repaint.request_repaint();
        });
    }

    /// Saves the next picture that has been taken.
    pub(super) fn save_next(&mut self) -> Option<Saved> {
        let Picture { image, path } = self.pictures.1.try_recv().ok()?;
        let result = write_png(&path, &image);
        let is_last = self.pending.take_if(|pending| pending.path == path).is_some();
        Some(Saved { path, result, is_last })
    }

    /// Takes the picture that was asked for on the command line, once the run
    /// has ended and was drawn. Answers why there will be none.
    pub(super) fn advance(&mut self, ctx: &egui::Context, session: &Session) -> Option<anyhow::Error> {
        let pending = self.pending.as_mut()?;
        if let Some(message) = session.messages.open_error() {
            let error = anyhow::anyhow!("{}: {}", message.what, message.why);
            self.pending = None;
            return Some(error);
        }
        let is_done = session.activity == Activity::Idle
            && session.phase() == Some(Phase::Finished)
            && !session.is_measuring();
        if !is_done || pending.is_requested {
            return None;
        }
        pending.settled_frames += 1;
        if pending.settled_frames < SETTLING_FRAMES {
            ctx.request_repaint();
            return None;
        }
        pending.is_requested = true;
        let path = pending.path.clone();
        self.request(ctx, path);
        None
    }
}

/// Writes the picture, whole or not at all.
fn write_png(path: &Path, picture: &ColorImage) -> anyhow::Result<()> {
    let [width, height] = picture.size;
    let bytes: Vec<u8> = picture.pixels.iter().flat_map(|pixel| pixel.to_array()).collect();
    let image = image::RgbaImage::from_raw(u32::try_from(width)?, u32::try_from(height)?, bytes)
        .context("the picture is incomplete")?;
    io::write_picture(path, &image)?;
    Ok(())
}
