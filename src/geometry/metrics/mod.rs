//! How well an abstraction stands for its shape.
//!
//! Lengths are measured in units of the longest edge of the reference's box.
//!
//! | figure | definition |
//! |---|---|
//! | accuracy | mean distance to the reference of points drawn evenly from the surface of the primitives' union |
//! | completeness | mean distance of points drawn evenly from the reference to the nearest of those points |
//! | Chamfer-L1 | (accuracy + completeness)/2 |
//! | IoU | volume of primitives ∩ reference over that of primitives ∪ reference |
//!
//! A point belongs to the surface of the union if it, pushed outward by 1e-4,
//! is in no other primitive: so the faces by which two primitives abut don't
//! count, and of two that coincide both do. The distance to a mesh is exact,
//! that to a cloud is the distance to its nearest point. The inside of a mesh
//! is where its generalised winding number is above ½, once vertices of the
//! same place are merged, double faces left out and patches turned outward.
//!
//! What a [`Reference`] needs is prepared once; [`evaluate`] measures any
//! number of states against it. The same seed gives the same bits on any
//! number of threads.

mod body;
mod clean;
mod error;
mod evaluation;
mod figures;
mod nearest;
mod orient;
mod reference;
mod triangles;
mod union;
mod winding;

pub use error::ReferenceError;
pub use evaluation::{estimate_chamfer, evaluate};
pub use figures::{MetricOptions, Metrics};
pub use nearest::Nearest;
pub use reference::Reference;

#[cfg(test)]
mod tests;
