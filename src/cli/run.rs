//! `superform run`: abstracts one shape or many.

use std::path::{Path, PathBuf};

use clap::Args;

use super::batch::{BatchArgs, is_one_file};
use super::headless::HeadlessJob;
use super::names::folder_for_results;
use super::request::Request;
use super::settings::SettingsArgs;
use crate::io::Format;
use crate::worker::Source;

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
    #[command(flatten)]
    batch: BatchArgs,
    #[command(flatten)]
    settings: SettingsArgs,
}

impl RunArgs {
    /// The job, with all settings within their limits. One file is a job whose
    /// results go straight to the output; anything else is a batch.
    pub(super) fn resolve(self) -> Result<Request, String> {
        let Self { mut inputs, output, quiet, export: exports, batch, settings } = self;
        if let Some(name) = exports.iter().find(|name| Format::from_path(Path::new(name), None).is_none()) {
            return Err(format!(
                "cannot tell the format of {name} from its name; see superform export --list"
            ));
        }
        folder_for_results(&output)?;
        if inputs.len() == 1 && is_one_file(&inputs[0]) && !batch.is_wanted() {
            let (sampling, params) = settings.resolve()?;
            let source = Source::File(inputs.remove(0));
            return Ok(Request::Headless(HeadlessJob { source, sampling, params, output, exports, quiet }));
        }
        batch.resolve(&inputs, output, exports, &settings, quiet).map(Request::Batch)
    }
}
