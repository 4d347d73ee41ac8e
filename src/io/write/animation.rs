//! Pictures: alone as PNG; one after the other as one GIF, or as a folder of PNGs.

use std::fs;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::atomic::Staged;
use super::place::{Place, folder_of};
use crate::io::error::WriteError;

/// Writes a picture as PNG.
///
/// # Errors
/// Where the file can't be written. It is written whole or not at all.
pub fn write_picture(path: &Path, picture: &image::RgbaImage) -> Result<(), WriteError> {
    Staged::with(path, |w| picture.write_to(w, image::ImageFormat::Png).map_err(std::io::Error::other))?
        .persist()
}

/// How an animation is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AnimationFormat {
    /// One file that plays for ever, with 256 colours a picture.
    #[default]
    Gif,
    /// A folder with `frame-001.png` and so on, in full colour.
    Pngs,
}

/// The largest side of a picture in a GIF.
pub const LARGEST_GIF: u32 = u16::MAX as u32;
/// How thoroughly a GIF's colours are chosen, 1 to 30, 1 the slowest.
const GIF_SPEED: i32 = 8;

/// An animation that is being written. It gets its name when it is whole: one
/// that is dropped before [`AnimationWriter::finish`] leaves nothing behind.
pub struct AnimationWriter {
    path: PathBuf,
    size: [u32; 2],
    target: Target,
}

enum Target {
    Gif { encoder: Box<gif::Encoder<BufWriter<Staged>>>, delay: u16 },
    Pngs { folder: TempDir, place: PathBuf, digits: usize, written: usize },
}

impl std::fmt::Debug for AnimationWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("AnimationWriter").field("path", &self.path).finish_non_exhaustive()
    }
}

impl AnimationWriter {
    /// Begins an animation of `frames` pictures of `size` pixels, each shown
    /// Starts an animation of `frames` pictures of `size` pixels, each shown for
    /// `seconds` (rounded to hundredths in a GIF).
    /// unfinished jobs.
    /// # Errors
    /// Where nothing can be written there: also where the folder of PNGs is
    /// there already with something in it.
    pub fn new(
        path: &Path,
        format: AnimationFormat,
        size: [u32; 2],
        frames: usize,
        seconds: f64,
    ) -> Result<Self, WriteError> {
        let failed = |reason| WriteError::Io { path: path.to_owned(), reason };
        let target = match format {
            AnimationFormat::Gif => {
                let file = Staged::begin(path)?;
                let [width, height] = size.map(|s| u16::try_from(s).unwrap_or(u16::MAX));
                let mut encoder = gif::Encoder::new(BufWriter::new(file), width, height, &[])
                    .map_err(|e| failed(io_error(e)))?;
                encoder.set_repeat(gif::Repeat::Infinite).map_err(|e| failed(io_error(e)))?;
                let delay = (100.0 * seconds).round().clamp(2.0, 6e4) as u16;
                Target::Gif { encoder: Box::new(encoder), delay }
            }
            AnimationFormat::Pngs => {
                let place = Place::of(path).map_err(failed)?;
                let path = place.file().unwrap_or(path);
                let is_taken = match fs::read_dir(path) {
                    Ok(mut entries) => entries.next().is_some(),
                    Err(_) => path.exists() || place.file().is_none(),
                };
                if is_taken {
                    let reason = std::io::Error::new(std::io::ErrorKind::AlreadyExists, "it already exists");
                    return Err(failed(reason));
                }
                let mut builder = tempfile::Builder::new();
                builder.prefix(".superform-").suffix(".part");
                #[cfg(unix)]
                builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
                let folder = builder.tempdir_in(folder_of(path)).map_err(|e| failed(e.kind().into()))?;
                let digits = frames.to_string().len().max(3);
                Target::Pngs { folder, place: path.to_owned(), digits, written: 0 }
            }
        };
        Ok(Self { path: path.to_owned(), size, target })
    }

    /// Appends a picture.
    /// unfinished jobs.
    /// # Errors
    /// Where it can't be written or has another size.
    pub fn push(&mut self, picture: &image::RgbaImage) -> Result<(), WriteError> {
        let failed = |reason| WriteError::Io { path: self.path.clone(), reason };
        if <[u32; 2]>::from(picture.dimensions()) != self.size {
            return Err(failed(std::io::Error::other("a frame differs in size from the first")));
        }
        match &mut self.target {
            Target::Gif { encoder, delay } => {
                let mut pixels = picture.as_raw().clone();
                let [width, height] = self.size.map(|s| u16::try_from(s).unwrap_or(u16::MAX));
                let mut frame = gif::Frame::from_rgba_speed(width, height, &mut pixels, GIF_SPEED);
                frame.delay = *delay;
                // What is transparent must not show the picture before.
                frame.dispose = gif::DisposalMethod::Background;
                encoder.write_frame(&frame).map_err(|e| failed(io_error(e)))
            }
            Target::Pngs { folder, digits, written, .. } => {
                *written += 1;
                let name = format!("frame-{:0digits$}.png", *written, digits = *digits);
                picture
                    .save_with_format(folder.path().join(name), image::ImageFormat::Png)
                    .map_err(|e| failed(std::io::Error::other(e)))
            }
        }
    }

    /// Gives the animation its name, in place of a file that stood there.
    /// unfinished jobs.
    /// # Errors
    /// Where it can't have it.
    pub fn finish(self) -> Result<(), WriteError> {
        let Self { path, target, .. } = self;
        let failed = |reason| WriteError::Io { path: path.clone(), reason };
        match target {
            Target::Gif { encoder, .. } => {
                let file = encoder.into_inner().map_err(|e| failed(io_error(e)))?;
                file.into_inner().map_err(|e| failed(e.into_error()))?.persist()
            }
            Target::Pngs { folder, place, .. } => {
                // Only what is empty: this fails where there is something by now.
                if place.is_dir() {
                    fs::remove_dir(&place).map_err(failed)?;
                }
                fs::rename(folder.path(), &place).map_err(failed)?;
                // It has moved away: nothing is left to be removed.
                drop(folder.keep());
                Ok(())
            }
        }
    }
}

fn io_error(error: gif::EncodingError) -> std::io::Error {
    match error {
        gif::EncodingError::Io(error) => error,
        other => std::io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(shade: u8) -> image::RgbaImage {
        image::RgbaImage::from_fn(20, 12, |x, _| {
            if x < 5 { image::Rgba([0; 4]) } else { image::Rgba([shade, 200, 30, 255]) }
        })
    }

    fn write(path: &Path, format: AnimationFormat) -> Result<(), WriteError> {
        let mut writer = AnimationWriter::new(path, format, [20, 12], 3, 0.25)?;
        for shade in [10, 90, 250] {
            writer.push(&picture(shade))?;
        }
        writer.finish()
    }

    #[test]
    fn a_gif_holds_all_frames_and_their_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("turn.gif");
        write(&path, AnimationFormat::Gif).expect("written");
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut reader = options.read_info(fs::File::open(&path).expect("there")).expect("a GIF");
        assert_eq!((reader.width(), reader.height()), (20, 12));
        let mut shades = Vec::new();
        while let Some(frame) = reader.read_next_frame().expect("sound") {
            assert_eq!(frame.delay, 25);
            assert_eq!(frame.buffer[3], 0, "the left is transparent");
            shades.push(frame.buffer[4 * 10]);
        }
        assert_eq!(shades.len(), 3);
        assert!(shades.is_sorted() && shades[2] - shades[0] > 200, "{shades:?}");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }

    #[test]
    fn pngs_are_numbered_in_a_folder_that_must_be_free() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("turn");
        write(&path, AnimationFormat::Pngs).expect("written");
        let first = image::open(path.join("frame-001.png")).expect("a picture").to_rgba8();
        assert_eq!(first, picture(10));
        assert!(path.join("frame-003.png").exists());
        assert!(write(&path, AnimationFormat::Pngs).is_err(), "nothing is written over");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "and nothing left behind");
    }

    #[test]
    fn what_is_given_up_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("a folder");
        for format in [AnimationFormat::Gif, AnimationFormat::Pngs] {
            let path = folder.path().join("turn");
            let mut writer = AnimationWriter::new(&path, format, [20, 12], 3, 0.1).expect("begun");
            writer.push(&picture(1)).expect("written");
            assert!(writer.push(&image::RgbaImage::new(3, 3)).is_err());
            drop(writer);
            assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0, "{format:?}");
        }
    }
}
