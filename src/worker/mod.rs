//! The background thread that owns the sampler, and the types that cross.

pub mod protocol;

pub use protocol::{Activity, Command, Event, LoadedShape, SamplingOptions, Snapshot, Source};
