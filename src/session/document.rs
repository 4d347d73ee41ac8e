//! The state that undo restores and a session file stores.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use super::timeline::Timeline;
use crate::geometry::brief::Brief;
use crate::inference::Params;
use crate::worker::{LoadedShape, SamplingOptions};

/// The part of a session that is the user's work. Cheap to clone: shapes and states are shared.
#[derive(Clone)]
pub struct Document {
    pub loaded: Option<Arc<LoadedShape>>,
    pub params: Params,
    pub sampling: SamplingOptions,
    pub timeline: Timeline,
    /// Ids of the selected primitives.
    pub selection: BTreeSet<u32>,
    /// Indices of the selected samples, in order.
    pub selected_points: Arc<[u32]>,
    /// Ids of the hidden primitives.
    pub hidden: BTreeSet<u32>,
}

impl fmt::Debug for Document {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Document")
            .field("shape", &self.loaded.as_ref().map(|l| &l.shape.name))
            .field("timeline", &self.timeline)
            .field("selection", &Brief::of(&self.selection))
            .field("selected_points", &Brief::of(&*self.selected_points))
            .field("hidden", &Brief::of(&self.hidden))
            .finish_non_exhaustive()
    }
}

impl PartialEq for Document {
    /// Shapes and states by identity.
    fn eq(&self, other: &Self) -> bool {
        let same_shape = match (&self.loaded, &other.loaded) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        same_shape
            && self.params == other.params
            && self.sampling == other.sampling
            && self.timeline == other.timeline
            && self.selection == other.selection
            && self.selected_points == other.selected_points
            && self.hidden == other.hidden
    }
}
