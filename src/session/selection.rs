//! Changes to a selection: replacing, adding, removing.

use std::collections::BTreeSet;
use std::sync::Arc;

/// How a new selection combines with the old one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Select {
    /// Replaces it.
    #[default]
    Replace,
    /// Adds to it.
    Add,
    /// Removes from it.
    Remove,
}

impl Select {
    /// The mode selected by the modifier keys.
    pub fn of_modifiers(adds: bool, removes: bool) -> Self {
        match (adds, removes) {
            (_, true) => Self::Remove,
            (true, false) => Self::Add,
            (false, false) => Self::Replace,
        }
    }

    pub(super) fn apply_to_set(self, selection: &mut BTreeSet<u32>, meant: BTreeSet<u32>) {
        match self {
            Self::Replace => *selection = meant,
            Self::Add => selection.extend(meant),
            Self::Remove => selection.retain(|id| !meant.contains(id)),
        }
    }

    /// The same for ascending indices below `count`; `meant` in any order.
    pub(super) fn apply_to_list(
        self,
        selection: &Arc<[u32]>,
        mut meant: Vec<u32>,
        count: usize,
    ) -> Arc<[u32]> {
        meant.retain(|&i| (i as usize) < count);
        meant.sort_unstable();
        meant.dedup();
        match self {
            Self::Replace => meant.into(),
            Self::Add => {
                meant.extend_from_slice(selection);
                meant.sort_unstable();
                meant.dedup();
                meant.into()
            }
            Self::Remove => selection.iter().copied().filter(|i| meant.binary_search(i).is_err()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn lists_change_as_sets_do(
            before in prop::collection::btree_set(0_u32..40, 0..30),
            meant in prop::collection::vec(0_u32..60, 0..30),
            how in prop::sample::select(vec![Select::Replace, Select::Add, Select::Remove]),
        ) {
            let list: Arc<[u32]> = before.iter().copied().collect();
            let list = how.apply_to_list(&list, meant.clone(), 40);
            let mut set = before;
            how.apply_to_set(&mut set, meant.into_iter().filter(|&i| i < 40).collect());
            prop_assert_eq!(list.to_vec(), set.into_iter().collect::<Vec<_>>());
        }
    }
}
