//! The parameters of primitives as JSON, NPZ and CSV, to files and back.

mod angles;
pub(super) mod csv;
pub(super) mod json;
pub(super) mod npz;
mod reading;
pub(super) mod schema;
mod set;
mod stored;

pub(super) use angles::yaw_pitch_roll;
pub use reading::{parse_primitives, read_primitives, read_primitives_of};
pub use set::PrimitiveSet;
pub(super) use set::checked;
pub use stored::StoredPrimitives;
