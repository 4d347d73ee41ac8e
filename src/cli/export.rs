//! `superform export`: exports a result to other formats.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::bail;
use clap::{Args, ValueEnum};
use nalgebra::Point3;

use super::interrupt::until_done_or_interrupted;
use super::output::say;
use crate::geometry::palette::Colors;
use crate::geometry::{SampleCloud, SamplingOptions};
use crate::inference::{Abstraction, Figures, Params, Phase, Sighting, UNASSIGNED};
use crate::io::{
    self, ExportOptions, Format, FoundAs, Inputs, Kind, Outcome, PrimitiveSet, SEGMENTED_FILE, Shape,
    ShapeGeometry, StoredPrimitives,
};

#[derive(Debug, Args)]
pub(super) struct ExportArgs {
    /// Folder of a run or file of primitives (JSON, NPZ or CSV)
    #[arg(required_unless_present = "list")]
    result: Option<PathBuf>,
    /// Files to write; - is standard output (with --format). The ending determines the format, and
    /// the name what is written: segmented or cloud, mesh or parts, otherwise primitives
    #[arg(short, long, value_name = "FILE", num_args = 1.., required_unless_present = "list")]
    output: Vec<PathBuf>,
    /// Format of the files, one of --list, regardless of their names
    #[arg(long, value_name = "NAME")]
    format: Option<String>,
    /// The abstracted shape, if the run's report does not lead to it
    #[arg(long, value_name = "FILE")]
    shape: Option<PathBuf>,
    /// Index of the shape in an NPZ with several, from 0
    #[arg(long, value_name = "N")]
    index: Option<usize>,
    /// List the formats and exit
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    options: OptionArgs,
}

/// What [`ExportOptions`] holds, as options.
#[derive(Debug, Args)]
#[command(next_help_heading = "Format options")]
struct OptionArgs {
    /// Write text instead of binary, for formats that have both
    #[arg(long)]
    text: bool,
    /// Omit colours
    #[arg(long)]
    no_colors: bool,
    /// Omit normals, colours and labels of the input
    #[arg(long)]
    no_input_attributes: bool,
    /// PCD: double-precision coordinates, which PCL and Open3D cannot read
    #[arg(long)]
    doubles: bool,
    /// Segmented meshes: cut faces along part boundaries
    #[arg(long)]
    split_boundaries: bool,
    /// Resolution: segments per quarter turn of a primitive's surface, from 2 to 128
    #[arg(long, value_name = "N", default_value_t = ExportOptions::default().resolution)]
    resolution: usize,
    /// Robot models: use meshes even for spheres, boxes and cylinders
    #[arg(long)]
    no_exact_shapes: bool,
    /// Robot models: density in kilograms per cubic metre
    #[arg(long, value_name = "D", default_value_t = ExportOptions::default().density)]
    density: f64,
    /// Robot models (in metres): unit of the input's lengths [default: m]
    #[arg(long, value_enum, value_name = "UNIT", conflicts_with = "scale")]
    unit: Option<Unit>,
    /// Robot models: metres per unit of the input, as an alternative to --unit
    #[arg(long, value_name = "METRES", default_value_t = ExportOptions::default().scale)]
    scale: f64,
}

/// Units of length that files come in.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Unit {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    M,
    /// Inches
    In,
    /// Feet
    Ft,
}

impl Unit {
    fn metres(self) -> f64 {
        match self {
            Self::Mm => 0.001,
            Self::Cm => 0.01,
            Self::M => 1.0,
            Self::In => 0.0254,
            Self::Ft => 0.3048,
        }
    }
}

impl OptionArgs {
    fn resolve(&self) -> Result<ExportOptions, String> {
        let options = ExportOptions {
            binary: !self.text,
            colors: !self.no_colors,
            input_attributes: !self.no_input_attributes,
            doubles: self.doubles,
            split_boundaries: self.split_boundaries,
            resolution: self.resolution,
            exact_shapes: !self.no_exact_shapes,
            density: self.density,
            scale: self.unit.map_or(self.scale, Unit::metres),
        };
        options.check().map(|()| options)
    }
}

impl ExportArgs {
    pub(super) fn resolve(self) -> Result<ExportJob, String> {
        let options = self.options.resolve()?;
        let named = self
            .format
            .map(|name| Format::by_name(&name).ok_or_else(|| format!("{name} is not a format; see --list")))
            .transpose()?;
        let target = |path: PathBuf| match named.or_else(|| Format::from_path(&path, None)) {
            Some(format) => Ok((path, format)),
            None => Err(format!(
                "cannot tell the format of {} from its name; choose one of --list with --format",
                path.display()
            )),
        };
        let Some(result) = self.result.filter(|_| !self.list) else {
            return Ok(ExportJob::List);
        };
        let targets = self.output.into_iter().map(target).collect::<Result<Vec<_>, _>>()?;
        let (shape, index) = (self.shape, self.index);
        Ok(ExportJob::Write(WriteJob { result, targets, shape, index, options }))
    }
}

/// What `superform export` is to do.
#[derive(Debug, Clone, PartialEq)]
pub enum ExportJob {
    /// Print the formats.
    List,
    Write(WriteJob),
}

/// Files to be written of a result.
#[derive(Debug, Clone, PartialEq)]
pub struct WriteJob {
    pub result: PathBuf,
    pub targets: Vec<(PathBuf, Format)>,
    /// The shape that was abstracted.
    pub shape: Option<PathBuf>,
    /// Place of the shape in a file with several.
    pub index: Option<usize>,
    pub options: ExportOptions,
}

impl ExportJob {
    /// Does the job: names of the files, or the list, go to standard output,
    /// notes to standard error.
    pub fn run(&self) -> ExitCode {
        until_done_or_interrupted(|_| match self {
            Self::List => Ok(list()),
            Self::Write(job) => job.work(),
        })
    }
}

/// The formats by kind, a line each.
fn list() -> String {
    let mut text = String::new();
    for kind in Kind::ALL {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{}{}", if text.is_empty() { "" } else { "\n" }, kind.title());
        for format in Format::of_kind(kind) {
            let _ = writeln!(text, "  {:<14}.{:<6}{}", format.name(), format.ending(), format.description());
        }
    }
    text
}

/// A stored result with its points and their labels.
struct Segmented {
    shape: Shape,
    cloud: SampleCloud,
    abstraction: Abstraction,
}

impl WriteJob {
    fn work(&self) -> anyhow::Result<String> {
        let stdout: Vec<&Path> = self
            .targets
            .iter()
            .map(|(path, _)| path.as_path())
            .filter(|path| io::is_standard_output(path))
            .collect();
        if stdout.len() > 1 {
            bail!("only one file can go to standard output; give names for the others");
        }
        let mut inputs = Inputs::default();
        inputs.add_result(&self.result);
        self.shape.iter().for_each(|path| inputs.add(path));
        for (path, format) in &self.targets {
            inputs.check(io::outputs(path, *format, &self.options))?;
        }
        let stored = io::read_primitives_of(&self.result, self.index)?;
        for note in &stored.notes {
            say(&format!("{}: {note}", stored.path.display()));
        }
        let colors = Colors::default();
        let params = stored.params.unwrap_or_default();
        let segmented = self.segmented(&stored)?;
        let mut written = String::new();
        for (path, format) in &self.targets {
            let done = match (&segmented, format.kind()) {
                (Some(result), Kind::Cloud | Kind::Mesh) => {
                    if format.needs_mesh() && matches!(result.shape.geometry, ShapeGeometry::Cloud(_)) {
                        bail!("{format} needs the abstracted mesh; give it with --shape");
                    }
                    io::export(path, *format, &self.options, &result.outcome(&colors, &params, &stored))
                }
                _ => {
                    let samples = segmented.as_ref().map(Segmented::samples);
                    let set = PrimitiveSet { samples, ..stored.set(&colors) };
                    io::export_primitives(path, *format, &self.options, &set)
                }
            }?;
            for note in &done.notes {
                say(&format!("{}: {note}", path.display()));
            }
            for file in done.files.iter().filter(|file| !stdout.contains(&file.as_path())) {
                let _ = writeln!(written, "wrote {}", file.display());
            }
        }
        if stdout.is_empty() {
            return Ok(written);
        }
        // There it would be taken for a part of the file.
        written.lines().for_each(say);
        Ok(String::new())
    }

    /// The result with its points, where something is to be written of them
    /// and they are there.
    fn segmented(&self, stored: &StoredPrimitives) -> anyhow::Result<Option<Segmented>> {
        let is_asked = |(_, format): &(PathBuf, Format)| {
            matches!(format.kind(), Kind::Cloud | Kind::Mesh) || *format == Format::PrimitivesNpz
        };
        if !self.targets.iter().any(is_asked) {
            return Ok(None);
        }
        let result = io::open_result(stored.clone(), self.shape.as_deref())?;
        if result.found_as != FoundAs::Input {
            for note in &result.shape.notes {
                say(&format!("{}: {note}", stored.path.display()));
            }
        }
        let Some(points) = &result.segmented else {
            if let Some(shape) =
                self.shape.as_deref().filter(|_| stored.path.with_file_name(SEGMENTED_FILE).exists())
            {
                bail!(
                    "{} is not the abstracted shape: it does not match the segmented cloud next to the \
                     result",
                    shape.display()
                );
            }
            return Ok(None);
        };
        let (cloud, labels) = points.samples_of(&result.shape);
        let unassigned = labels.iter().filter(|&&l| l == UNASSIGNED).count();
        let figures =
            Figures { clusters: stored.primitives.len(), unassigned, mean_distance: 0.0, log_joint: None };
        let abstraction = Abstraction {
            phase: Phase::Finished,
            iteration: 0,
            labels: labels.into(),
            pinned: [].into(),
            primitives: stored.primitives.clone().into(),
            figures,
            sighting: Sighting::default(),
        };
        Ok(Some(Segmented { shape: result.shape, cloud, abstraction }))
    }
}

impl Segmented {
    fn samples(&self) -> (&[Point3<f64>], &[u32]) {
        (&self.cloud.points, &self.abstraction.labels)
    }

    fn outcome<'a>(
        &'a self,
        colors: &'a Colors,
        params: &'a Params,
        stored: &StoredPrimitives,
    ) -> Outcome<'a> {
        let sampling =
            SamplingOptions { seed: stored.sampling_seed.unwrap_or_default(), ..SamplingOptions::default() };
        Outcome {
            colors,
            shape: &self.shape,
            cloud: &self.cloud,
            sampling,
            params,
            abstraction: &self.abstraction,
        }
    }
}
