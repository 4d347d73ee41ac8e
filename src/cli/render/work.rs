//! Renders the pictures.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use indicatif::{ProgressBar, ProgressStyle};

use super::ending_of;
use super::inputs::{Entry, expand};
use super::job::{RenderJob, Turn, Viewpoint};
use crate::cli::batch::failures;
use crate::cli::headless;
use crate::cli::interrupt::{INTERRUPTED, cancel_on_interrupt};
use crate::cli::names::is_folder;
use crate::cli::output::{self, fail_by, say};
use crate::inference::Cancel;
use crate::io::{self, AnimationFormat, AnimationWriter, Inputs};
use crate::pictures::{Figures, Painter, Sheet, Stage, Subject, Theme};
use crate::session::camera::Camera;
use crate::session::view::ColorBy;

impl RenderJob {
    /// Does the job: what was written is told on standard output. The exit
    /// status tells how many results gave no picture.
    pub fn run(&self) -> ExitCode {
        let cancel = cancel_on_interrupt();
        match RenderTask::new(self).and_then(|work| work.done(&cancel)) {
            Ok(exit) => exit,
            Err(e) => fail_by(&e),
        }
    }
}

/// A job on its way.
struct RenderTask<'a> {
    job: &'a RenderJob,
    entries: Vec<Entry>,
    painter: Painter,
    sheet: Option<Sheet>,
    bar: ProgressBar,
    /// Standard output is for a picture.
    is_quiet: bool,
    /// Why what was said did not arrive.
    lost: Option<anyhow::Error>,
}

impl<'a> RenderTask<'a> {
    fn new(job: &'a RenderJob) -> anyhow::Result<Self> {
        let entries = expand(&job.inputs).map_err(anyhow::Error::msg)?;
        if let Some(output) = job.output.as_deref().filter(|output| is_one_picture(output)) {
            let shown = output.display();
            if entries.len() > 1 {
                bail!(
                    "{shown} is one file, but there are {} results; give a folder for their pictures or use \
                     --sheet",
                    entries.len()
                );
            }
            if job.views.len() > 1 && io::is_written_through(output) {
                bail!("{shown} is one file, but there are {} views; give a folder", job.views.len());
            }
        }
        let outputs = outputs(job, &entries)?;
        let cells = entries.len() * job.views.len();
        let sheet = match &job.sheet {
            Some(wish) => {
                let columns = wish.columns;
                let look = &job.look;
                Some(Sheet::new(theme(job), look.is_transparent, job.cell, cells, columns)?)
            }
            None => None,
        };
        let painter = Painter::new()?;
        if let Some(folder) = job.output.as_deref().filter(|output| !is_one_picture(output)) {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        }
        let is_shown = !job.quiet && entries.len() > 1;
        let bar = if is_shown { ProgressBar::new(entries.len() as u64) } else { ProgressBar::hidden() };
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {msg}") {
            bar.set_style(style);
        }
        let is_quiet = outputs.iter().any(|path| io::is_standard_output(path));
        Ok(Self { job, entries, painter, sheet, bar, is_quiet, lost: None })
    }

    fn done(mut self, cancel: &Cancel) -> anyhow::Result<ExitCode> {
        let mut failed = Vec::new();
        let entries = std::mem::take(&mut self.entries);
        for entry in &entries {
            if cancel.is_requested() {
                break;
            }
            self.bar.set_message(entry.title.clone());
            if let Err(e) = self.one(entry, cancel) {
                if output::is_closed_pipe(&e) {
                    return Err(e);
                }
                let problem = format!("{e:#}");
                if let Some(sheet) = &mut self.sheet {
                    for _ in &self.job.views {
                        sheet.add_missing(&mut self.painter, &entry.title, &problem);
                    }
                }
                failed.push(format!("{}: {problem}", entry.title));
            }
            self.bar.inc(1);
        }
        self.bar.finish_and_clear();
        if cancel.is_requested() {
            say("stopped; the listed pictures are complete, the others were not written");
            return Ok(ExitCode::from(INTERRUPTED));
        }
        // A sheet of nothing but problems is no picture.
        if let (Some(sheet), Some(wish)) = (self.sheet.take(), &self.job.sheet)
            && failed.len() < entries.len()
        {
            io::write_picture(&wish.path, &sheet.into_picture())?;
            self.tell(&wish.path);
        }
        failed.iter().for_each(|line| say(line));
        match (self.lost, failed.len()) {
            (Some(lost), 0) => Err(lost),
            (_, 1) if entries.len() == 1 => Ok(ExitCode::FAILURE),
            (_, failed) => Ok(failures(failed)),
        }
    }

    /// All pictures of one result.
    fn one(&mut self, entry: &Entry, cancel: &Cancel) -> anyhow::Result<()> {
        let subject = Subject::read(&entry.path)?;
        if !self.job.quiet {
            let told = subject.notes().iter().map(String::as_str).chain(self.missing(&subject));
            told.for_each(|note| self.bar.suspend(|| say(&format!("{}: {note}", entry.title))));
        }
        let view = self.job.look.over(subject.view());
        let stage = self.painter.take(&subject, &view, theme(self.job), self.job.look.is_transparent);
        let cells = self.cells(entry, &subject, &stage)?;
        for viewpoint in &self.job.views {
            let Some(path) = path(self.job, entry, *viewpoint) else { continue };
            match self.job.turn {
                Some(turn) => self.turntable(&stage, camera(*viewpoint, &subject), turn, &path, cancel)?,
                None => {
                    let size = self.job.size;
                    let picture = self.picture(&stage, &subject, *viewpoint, size)?;
                    io::write_picture(&path, &picture)?;
                }
            }
            if cancel.is_requested() {
                return Ok(());
            }
            self.tell(&path);
        }
        // Only now: a result has either all of its cells or none.
        for (picture, title, detail) in cells {
            if let Some(sheet) = &mut self.sheet {
                sheet.add(&mut self.painter, &picture, &title, &detail);
            }
        }
        Ok(())
    }

    /// The cells of a sheet, with their captions.
    fn cells(
        &mut self,
        entry: &Entry,
        subject: &Subject,
        stage: &Stage,
    ) -> anyhow::Result<Vec<(image::RgbaImage, String, String)>> {
        let mut cells = Vec::new();
        if self.sheet.is_none() {
            return Ok(cells);
        }
        for viewpoint in &self.job.views {
            let picture = self.picture(stage, subject, *viewpoint, self.job.cell)?;
            let title = match self.job.views.len() {
                1 => entry.title.clone(),
                _ => format!("{} · {}", entry.title, viewpoint.name()),
            };
            cells.push((picture, title, caption(subject)));
        }
        Ok(cells)
    }

    fn picture(
        &mut self,
        stage: &Stage,
        subject: &Subject,
        viewpoint: Viewpoint,
        size: [u32; 2],
    ) -> anyhow::Result<image::RgbaImage> {
        let mut camera = camera(viewpoint, subject);
        // A session keeps where it was looked at from.
        if viewpoint == Viewpoint::AsLeft && subject.camera().is_some() {
            camera.aspect = f64::from(size[0]) / f64::from(size[1]);
        } else {
            camera = stage.framed(camera, size);
        }
        Ok(self.painter.picture(stage, &camera, size)?)
    }

    fn turntable(
        &mut self,
        stage: &Stage,
        camera: Camera,
        turn: Turn,
        path: &Path,
        cancel: &Cancel,
    ) -> anyhow::Result<()> {
        let size = self.job.size;
        let each = turn.seconds / f64::from(turn.frames);
        let mut writer = AnimationWriter::new(path, AnimationFormat::Gif, size, turn.frames as usize, each)?;
        for camera in stage.turntable(camera, size, turn.frames) {
            if cancel.is_requested() {
                // What was begun is gone with the writer.
                return Ok(());
            }
            writer.push(&self.painter.picture(stage, &camera, size)?)?;
        }
        Ok(writer.finish()?)
    }

    /// What was asked for and can't be told of this result.
    fn missing(&self, subject: &Subject) -> Option<&'static str> {
        match self.job.look.color_by? {
            ColorBy::Input if !subject.has_input_colors() => {
                Some("its points have no colours in the file and are shown in grey")
            }
            ColorBy::OwnDistance if !subject.has_labels() => {
                Some("no points are assigned to a primitive, so there is no error to show")
            }
            ColorBy::SurfaceDistance if !subject.has_surfaces() => {
                Some("comparing needs primitives and an input, so there is no distance to show")
            }
            _ => None,
        }
    }

    /// Says what was written.
    fn tell(&mut self, path: &Path) {
        if !self.job.quiet && !self.is_quiet {
            let told = self.bar.suspend(|| output::tell(&format!("wrote {}\n", path.display())));
            self.lost = self.lost.take().or(told.err());
        }
    }
}

/// All files that are to be written.
///
/// # Errors
/// Where one of them is read, too, or would be written twice.
fn outputs(job: &RenderJob, entries: &[Entry]) -> anyhow::Result<Vec<PathBuf>> {
    let mut inputs = Inputs::default();
    entries.iter().for_each(|entry| inputs.add_result(&entry.path));
    let pictures = entries
        .iter()
        .flat_map(|entry| job.views.iter().filter_map(|viewpoint| path(job, entry, *viewpoint)));
    let mut outputs: Vec<PathBuf> = pictures.collect();
    if let Some(sheet) = &job.sheet {
        if outputs.contains(&sheet.path) {
            bail!(
                "{} is used for both a picture and the sheet; give two different names",
                sheet.path.display()
            );
        }
        outputs.push(sheet.path.clone());
    }
    inputs.check(&outputs)?;
    Ok(outputs)
}

/// Whether pictures go to one file, and not to a folder.
fn is_one_picture(output: &Path) -> bool {
    !is_folder(output) && (io::is_written_through(output) || ending_of(output).is_some())
}

/// Where a picture goes; `None` where only a sheet is wanted.
fn path(job: &RenderJob, entry: &Entry, viewpoint: Viewpoint) -> Option<PathBuf> {
    let output = job.output.as_deref()?;
    let several = if job.views.len() > 1 { format!("-{}", viewpoint.name()) } else { String::new() };
    let ending = if job.turn.is_some() { "gif" } else { "png" };
    Some(match is_one_picture(output) {
        true if several.is_empty() => output.to_owned(),
        true => {
            let mut name: OsString = output.file_stem().unwrap_or_default().to_owned();
            name.push(format!("{several}.{ending}"));
            output.with_file_name(name)
        }
        false => output.join(format!("{}{several}.{ending}", entry.name)),
    })
}

fn theme(job: &RenderJob) -> Theme {
    if job.look.is_light { Theme::Light } else { Theme::Dark }
}

/// In the direction and of the kind that is asked for, before it is framed.
fn camera(viewpoint: Viewpoint, subject: &Subject) -> Camera {
    let mut camera = Camera::default();
    match viewpoint {
        Viewpoint::AsLeft => return subject.camera().unwrap_or_default(),
        Viewpoint::Perspective { azimuth, elevation } => {
            camera.yaw = azimuth.rem_euclid(360.0).to_radians();
            camera.pitch = elevation.to_radians();
        }
        Viewpoint::Along(axis) => {
            camera.look(axis);
            camera.orthographic = true;
        }
    }
    camera
}

/// "9 primitives · mean distance 0.34 %", of the longest edge.
fn caption(subject: &Subject) -> String {
    match subject.figures() {
        Figures::Result { primitives, mean_distance } => {
            let mut text = headless::primitives(primitives);
            if let Some(share) = mean_distance {
                text += &format!(" · mean distance {:.2} %", 100.0 * share);
            }
            text
        }
        Figures::Mesh { faces } => format!("{faces} faces"),
        Figures::Cloud { points } => format!("{points} points"),
    }
}
