//! Reads shapes and writes results. Formats are detected by content; errors say what is wrong,
//! where, and what to do; files are written completely or not at all.

mod caught;
mod content;
mod error;
mod inputs;
mod names;
mod npy;
mod open;
mod paths;
mod primitives;
mod read;
mod shape;
mod wording;
mod write;

pub(crate) use caught::caught;
pub use error::{Place, ReadError, WriteError};
pub use inputs::Inputs;
pub use names::{PRIMITIVES_FILE, REPORT_FILE, SEGMENTED_FILE, SESSION_ENDING, has_session_ending};
pub use open::{Opened, open};
pub use paths::StoredPath;
pub use primitives::{PrimitiveSet, StoredPrimitives, parse_primitives, read_primitives, read_primitives_of};
#[doc(hidden)]
pub use read::read_bytes_as;
pub use read::{
    FoundAs, LabelledPoints, OpenedResult, SHAPE_ENDINGS, buffers_beside, built_in, has_shape_ending,
    holds_primitives, open_result, read, read_bytes,
};
pub use shape::{Attributes, Content, PointCloud, Shape, ShapeGeometry, reference, sample};
pub use wording::{cause, harmless, on_reading, on_writing};
pub use write::{
    AnimationFormat, AnimationWriter, Choice, ExportOptions, Exported, Format, Kind, LARGEST_GIF, Outcome,
    PhaseTimes, RunRecord, estimated_size, export, export_primitives, is_standard_output, is_written_through,
    move_whole, outputs, primitives_text, print, run_outputs, write_picture, write_run, write_streamed,
    write_whole,
};
