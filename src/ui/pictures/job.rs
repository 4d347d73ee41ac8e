//! Pictures in progress: rendered by the device, encoded in a thread.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::time::Duration;

use super::still::Still;
use crate::io::{self, AnimationFormat, AnimationWriter};
use crate::render::{Capture, OffscreenError};
use crate::session::camera::Camera;
use crate::ui::viewport::{Shot, Studio};

/// Polling interval of the window.
pub(super) const PATIENCE: Duration = Duration::from_millis(8);
/// Capacity of the queue to the encoding thread.
const WAITING: usize = 2;

/// The path when everything is written, or the error.
type Outcome = Result<PathBuf, String>;

/// A job of one or many pictures. Dropping it cancels the job and leaves no files.
#[derive(Debug)]
pub(super) struct Job {
    still: Still,
    shot: Shot,
    frames: u32,
    /// Pictures submitted to the device.
    begun: u32,
    capture: Option<Result<Capture, OffscreenError>>,
    /// A picture that the encoder had no room for.
    finished: Option<image::RgbaImage>,
    /// Closed after the last picture.
    encoder: Option<SyncSender<image::RgbaImage>>,
    handed: u32,
    outcome: Receiver<Outcome>,
}

impl Job {
    pub(super) fn still(studio: &mut Studio, still: Still, shot: Shot, path: &Path) -> Self {
        let path = path.to_owned();
        let capture = studio.begin(&still.view(), &shot);
        let mut job = Self::new(still, shot, 1, move |pictures| {
            // Without a picture the job was given up.
            let Ok(picture) = pictures.recv() else { return Err(String::new()) };
            io::write_picture(&path, &picture).map_err(|e| e.to_string())?;
            Ok(path)
        });
        job.begun = 1;
        job.capture = Some(capture);
        job
    }

    /// A whole turn around the target, from where the camera stands.
    pub(super) fn turntable(
        still: Still,
        shot: Shot,
        path: &Path,
        format: AnimationFormat,
        frames: u32,
        seconds: f64,
    ) -> Self {
        let path = path.to_owned();
        let size = shot.size;
        Self::new(still, shot, frames, move |pictures| {
            let each = seconds / f64::from(frames.max(1));
            let mut writer = AnimationWriter::new(&path, format, size, frames as usize, each)
                .map_err(|e| e.to_string())?;
            for _ in 0..frames {
                let Ok(picture) = pictures.recv() else { return Err(String::new()) };
                writer.push(&picture).map_err(|e| e.to_string())?;
            }
            writer.finish().map_err(|e| e.to_string())?;
            Ok(path)
        })
    }

    fn new(
        still: Still,
        shot: Shot,
        frames: u32,
        encode: impl FnOnce(Receiver<image::RgbaImage>) -> Outcome + Send + 'static,
    ) -> Self {
        let (encoder, pictures) = sync_channel(WAITING);
        let (sender, outcome) = sync_channel(1);
        let report = sender.clone();
        let thread = std::thread::Builder::new().name("pictures".to_owned()).spawn(move || {
            // Nobody listens to a job that was given up.
            let _ = report.send(encode(pictures));
        });
        if let Err(error) = thread {
            // There is room for one.
            let _ =
                sender.try_send(Err(format!("the system could not start a thread to write it ({error})")));
        }
        Self {
            still,
            shot,
            frames,
            begun: 0,
            capture: None,
            finished: None,
            encoder: Some(encoder),
            handed: 0,
            outcome,
        }
    }

    /// Rendered pictures, and their total.
    pub(super) fn progress(&self) -> (u32, u32) {
        (self.handed, self.frames)
    }

    /// Makes progress without blocking. Returns the outcome once finished.
    pub(super) fn advance(&mut self, studio: &mut Studio) -> Option<Outcome> {
        match self.outcome.try_recv() {
            Ok(outcome) => return Some(outcome),
            Err(TryRecvError::Disconnected) => return Some(Err("its thread ended unexpectedly".to_owned())),
            Err(TryRecvError::Empty) => {}
        }
        if let Err(error) = self.draw(studio) {
            return Some(Err(error.to_string()));
        }
        self.hand_over();
        None
    }

    fn draw(&mut self, studio: &mut Studio) -> Result<(), OffscreenError> {
        if self.finished.is_some() {
            return Ok(());
        }
        if let Some(capture) = self.capture.take() {
            let capture = capture?;
            match studio.poll(&capture) {
                Some(picture) => self.finished = Some(picture?),
                None => self.capture = Some(Ok(capture)),
            }
        }
        if self.capture.is_none() && self.begun < self.frames {
            let turn = TAU * f64::from(self.begun) / f64::from(self.frames);
            let mut camera: Camera = self.shot.camera;
            camera.orbit(turn, 0.0);
            self.capture = Some(studio.begin(&self.still.view(), &Shot { camera, ..self.shot }));
            self.begun += 1;
        }
        Ok(())
    }

    fn hand_over(&mut self) {
        let (Some(picture), Some(encoder)) = (self.finished.take(), &self.encoder) else { return };
        match encoder.try_send(picture) {
            Ok(()) => self.handed += 1,
            Err(TrySendError::Full(picture)) => self.finished = Some(picture),
            // It says why in its outcome.
            Err(TrySendError::Disconnected(_)) => self.encoder = None,
        }
        if self.handed == self.frames {
            self.encoder = None;
        }
    }
}
