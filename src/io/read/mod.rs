//! Reading: shapes from the files that people have, and results back.

pub(super) mod columns;
mod detect;
mod gltf;
mod las;
mod npy;
mod obj;
mod off;
mod pcd;
mod ply;
mod polygon;
mod raw;
mod results;
pub(super) mod scalar;
mod shapes;
mod stl;
pub(super) mod text;
mod xyz;

pub use gltf::buffers_beside;
pub(super) use results::places_of_shape;
pub use results::{FoundAs, LabelledPoints, OpenedResult, holds_primitives, open_result};
pub use shapes::{SHAPE_ENDINGS, built_in, has_shape_ending, read, read_bytes, read_bytes_as};
