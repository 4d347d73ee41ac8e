//! Results as files: the segmented cloud and mesh, the primitives, the report.

mod animation;
mod atomic;
mod cloud;
mod export;
mod formats;
mod glb;
mod meshes;
mod options;
mod outcome;
mod parts;
mod place;
mod report;
mod robot;
mod run;
mod standard;
mod text;
mod writing;

pub use animation::{AnimationFormat, AnimationWriter, LARGEST_GIF, write_picture};
pub(super) use atomic::unfit;
pub use atomic::{move_whole, write_streamed, write_whole};
pub use export::{Exported, estimated_size, export, export_primitives, outputs, primitives_text};
pub use formats::Format;
pub use options::{Choice, ExportOptions, Kind};
pub use outcome::Outcome;
pub use place::{is_standard_output, is_written_through};
pub use report::{PhaseTimes, RunRecord};
pub use run::{run_outputs, write_run};
pub use standard::print;
pub(super) use text::{Text, file_label, json};
