//! Disjoint sets that become one another's.

/// A forest in which each tree is a set; its root stands for it.
#[derive(Debug)]
pub(super) struct Forest(Vec<u32>);

impl Forest {
    /// So many sets of one member each.
    pub(super) fn of(count: u32) -> Self {
        Self((0..count).collect())
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Adds a set of one member, which is returned.
    pub(super) fn add(&mut self) -> u32 {
        let new = self.0.len() as u32;
        self.0.push(new);
        new
    }

    /// The root of a member's set.
    pub(super) fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let above = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = above;
            i = above;
        }
        i
    }

    /// Makes the set of one root a part of another's.
    pub(super) fn hang(&mut self, root: u32, below: u32) {
        self.0[root as usize] = below;
    }
}
