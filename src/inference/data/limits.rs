//! What a state of a run can hold, in the normalised frame.

use crate::geometry::theta::Bounds;

/// Ids lie below this: the random streams have room for so many.
pub(crate) const MOST_IDS: u32 = 1 << 30;

/// Whether it is a normalised σ that a run can hold.
pub(crate) fn is_sigma(sigma: f64) -> bool {
    sigma > 0.0 && sigma <= Bounds::RUN.farthest
}
