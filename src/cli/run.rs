//! `superform run`: abstracts one shape or many.

use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::Point3;

use super::batch::{BatchArgs, is_one_file};
use super::headless::HeadlessJob;
use super::names::folder_for_results;
use super::request::Request;
use super::settings::SettingsArgs;
use crate::inference::{SeenFrom, Setting};
use crate::io::Format;
use crate::worker::Source;

/// A place from its three coordinates.
fn place(text: &str) -> Result<Point3<f64>, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|c| c.trim().parse::<f64>()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if [x, y, z].iter().all(|c| c.is_finite()) => Ok(Point3::new(x, y, z)),
        _ => Err("expected three numbers separated by commas, such as 0,-2,1.5".to_owned()),
    }
}

#[derive(Debug, Args)]
pub(super) struct RunArgs {
    /// Meshes and point clouds to read (OBJ, PLY, STL, OFF, glTF, GLB, PCD, LAS, LAZ, NPY, NPZ or
    /// XYZ text), folders of them, or patterns like 'shapes/*.obj'
    #[arg(value_name = "INPUT", required_unless_present = "manifest")]
    inputs: Vec<PathBuf>,
    /// Folder for the results; created if missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Print only errors and warnings
    #[arg(short, long)]
    quiet: bool,
    /// More files to write to the folder. Their names determine their formats as for `superform
    /// export`, for example segmented.csv,primitives.npz,robot.urdf
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    export: Vec<String>,
    /// A place that the shape was seen from, in its units: what is behind the seen surface is
    /// unknown, not empty. May be given several times
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true)]
    viewpoint: Vec<Point3<f64>>,
    #[command(flatten)]
    batch: BatchArgs,
    #[command(flatten)]
    settings: SettingsArgs,
}

impl RunArgs {
    /// The job, with all settings within their limits. One file is a job whose
    /// results go straight to the output; anything else is a batch.
    pub(super) fn resolve(self) -> Result<Request, String> {
        let Self { mut inputs, output, quiet, export: exports, viewpoint: viewpoints, batch, settings } =
            self;
        if let Some(name) = exports.iter().find(|name| Format::from_path(Path::new(name), None).is_none()) {
            return Err(format!(
                "cannot tell the format of {name} from its name; see superform export --list"
            ));
        }
        folder_for_results(&output)?;
        if inputs.len() == 1 && is_one_file(&inputs[0]) && !batch.is_wanted() {
            let (sampling, params) = settings.resolve()?;
            let source = Source::File(inputs.remove(0));
            if !viewpoints.is_empty() && params.seen_from == SeenFrom::All {
                return Err("--seen-from all does not use --viewpoint; remove one of them".to_owned());
            }
            if !viewpoints.is_empty() && !params.reads(Setting::SeenFrom) {
                return Err(format!("--method {} does not use --viewpoint; remove it", settings.method));
            }
            let job = HeadlessJob { source, viewpoints, sampling, params, output, exports, quiet };
            return Ok(Request::Headless(job));
        }
        if !viewpoints.is_empty() {
            return Err("--viewpoint belongs to one shape; run the shapes one by one".to_owned());
        }
        batch.resolve(&inputs, output, exports, &settings, quiet).map(Request::Batch)
    }
}
