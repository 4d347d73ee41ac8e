//! All states, as branches. Each branch is a complete history from a start and shares states with
//! its parent branch.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use crate::geometry::palette::Colors;
use crate::worker::{Cause, LoadedShape, Snapshot, State};

/// Where a branch started from another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Origin {
    /// Id of the parent branch.
    pub branch: u32,
    /// Index of the last state that both share.
    pub index: usize,
}

/// A history from a start.
#[derive(Clone)]
pub struct Branch {
    /// Stable and never reused.
    pub id: u32,
    pub name: String,
    /// `None` if it began with a new run.
    pub origin: Option<Origin>,
    /// The shape and samples of all its states.
    pub loaded: Arc<LoadedShape>,
    /// The start first; never empty.
    pub states: Vec<Arc<Snapshot>>,
    /// Of its primitives.
    pub colors: Arc<Colors>,
}

impl fmt::Debug for Branch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Branch")
            .field("id", &self.id)
            .field("name", &self.name)
            .field("origin", &self.origin)
            .field("shape", &self.loaded.shape.name)
            .field("states", &self.states.len())
            .field("colors", &self.colors)
            .finish()
    }
}

impl Branch {
    /// Whether it contains manual edits, which no run would repeat.
    pub fn is_manual(&self) -> bool {
        self.states.iter().any(|s| s.cause.is_manual())
    }

    fn is_same(&self, other: &Self) -> bool {
        self.id == other.id
            && self.name == other.name
            && self.states.len() == other.states.len()
            && self.states.last().map(|s| s.key) == other.states.last().map(|s| s.key)
            && self.states.first().map(|s| s.key) == other.states.first().map(|s| s.key)
    }
}

/// All branches and the shown state. Cheap to clone: the states are shared.
#[derive(Debug, Clone, Default)]
pub struct Timeline {
    branches: Vec<Branch>,
    /// Index of the branch that is shown.
    current: usize,
    /// Index of the branch that the worker adds to.
    growing: usize,
    /// Index of the shown state.
    shown: usize,
    /// Number of branches so far, including removed ones.
    count: u32,
}

impl PartialEq for Timeline {
    /// By the identity of the states, not their contents.
    fn eq(&self, other: &Self) -> bool {
        (self.current, self.shown) == (other.current, other.shown)
            && self.branches.len() == other.branches.len()
            && self.branches.iter().zip(&other.branches).all(|(a, b)| a.is_same(b))
    }
}

impl Timeline {
    /// Upper limit on the number of branches.
    const MOST: u32 = 1 << 30;

    /// Restores a timeline from a file; `None` if an index is out of range, a
    /// branch has no states or a duplicate id, or there are too many branches.
    pub fn from_parts(branches: Vec<Branch>, current: usize, shown: usize, count: u32) -> Option<Self> {
        let ids: BTreeSet<u32> = branches.iter().map(|b| b.id).collect();
        let is_whole = ids.len() == branches.len()
            && count <= Self::MOST
            && branches.iter().all(|b| !b.states.is_empty() && b.id < count)
            && match branches.get(current) {
                Some(branch) => shown < branch.states.len(),
                None => branches.is_empty(),
            };
        is_whole.then_some(Self { branches, current, growing: current, shown, count })
    }

    pub fn branches(&self) -> &[Branch] {
        &self.branches
    }

    /// Branches so far, removed ones too: ids are below it.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The branch that is shown.
    pub fn current(&self) -> Option<&Branch> {
        self.branches.get(self.current)
    }

    pub fn branch(&self, id: u32) -> Option<&Branch> {
        self.branches.iter().find(|b| b.id == id)
    }

    /// The branch that the worker adds to.
    pub(super) fn growing(&self) -> Option<&Branch> {
        self.branches.get(self.growing)
    }

    /// Index of the shown branch.
    pub fn current_index(&self) -> usize {
        self.current
    }

    /// The states of the branch that is shown, the start first.
    pub fn states(&self) -> &[Arc<Snapshot>] {
        self.current().map_or(&[], |b| &b.states)
    }

    /// The states of the branch that is shown, up to the one that is.
    pub fn history(&self) -> &[Arc<Snapshot>] {
        let states = self.states();
        &states[..states.len().min(self.shown + 1)]
    }

    /// Index of the shown state within its branch.
    pub fn shown_index(&self) -> usize {
        self.shown
    }

    pub fn shown(&self) -> Option<&Arc<Snapshot>> {
        self.states().get(self.shown)
    }

    /// The shown state with what it belongs to.
    pub fn shown_state(&self) -> Option<State> {
        let loaded = Arc::clone(&self.current()?.loaded);
        Some(State { loaded, snapshot: Arc::clone(self.shown()?) })
    }

    /// Whether the last state of the branch is shown.
    pub fn is_at_end(&self) -> bool {
        self.shown + 1 >= self.states().len()
    }

    /// Whether the next state from the worker continues the shown one.
    pub fn follows(&self) -> bool {
        self.current == self.growing && self.is_at_end()
    }

    /// Adds the first state of a run. It replaces the current branch, unless
    /// that contains manual edits or has child branches; then a new branch
    /// begins.
    pub(super) fn start(&mut self, loaded: &Arc<LoadedShape>, first: Arc<Snapshot>, colors: Arc<Colors>) {
        let is_free = self.current().is_some_and(|branch| {
            !branch.is_manual()
                && !self.branches.iter().any(|b| b.origin.is_some_and(|o| o.branch == branch.id))
        });
        if is_free && let Some(branch) = self.branches.get_mut(self.current) {
            branch.origin = None;
            branch.loaded = Arc::clone(loaded);
            branch.states = vec![first];
            branch.colors = colors;
        } else {
            self.add(None, Arc::clone(loaded), vec![first], colors, None);
        }
        self.growing = self.current;
        self.shown = 0;
    }

    /// Adds the worker's next state, and shows it if its predecessor was shown.
    /// Does nothing without a start.
    pub(super) fn push(&mut self, state: Arc<Snapshot>) {
        let follows = self.follows();
        let Some(branch) = self.branches.get_mut(self.growing) else { return };
        branch.states.push(state);
        if follows {
            self.shown = branch.states.len() - 1;
        }
    }

    /// Adds a branch of finished states and shows its last.
    pub(super) fn add(
        &mut self,
        name: Option<String>,
        loaded: Arc<LoadedShape>,
        states: Vec<Arc<Snapshot>>,
        colors: Arc<Colors>,
        origin: Option<Origin>,
    ) {
        if states.is_empty() {
            return;
        }
        let id = self.count;
        self.count += 1;
        let name = name.unwrap_or_else(|| if id == 0 { "Main".to_owned() } else { format!("Branch {id}") });
        let name = self.free_name(id, name);
        self.shown = states.len() - 1;
        self.branches.push(Branch { id, name, origin, loaded, states, colors });
        self.current = self.branches.len() - 1;
        self.growing = self.current;
    }

    /// As [`Timeline::add`], while the worker goes on with the branch it is at.
    pub(super) fn add_beside(
        &mut self,
        name: String,
        loaded: Arc<LoadedShape>,
        states: Vec<Arc<Snapshot>>,
        colors: Arc<Colors>,
    ) {
        let (growing, is_first) = (self.growing, self.branches.is_empty());
        self.add(Some(name), loaded, states, colors, None);
        if !is_first {
            self.growing = growing;
        }
    }

    /// Makes the shown state the last of its branch, in a new branch if there are later states.
    pub(super) fn branch_here(&mut self) {
        let shown = self.shown;
        if self.is_at_end() {
            self.growing = self.current;
            return;
        }
        let Some(branch) = self.current() else { return };
        let origin = Origin { branch: branch.id, index: shown };
        let (loaded, colors) = (Arc::clone(&branch.loaded), Arc::clone(&branch.colors));
        let states = branch.states[..=shown].to_vec();
        self.add(None, loaded, states, colors, Some(origin));
    }

    /// Shows a state of the current branch, or the last if there are fewer.
    pub(super) fn show(&mut self, index: usize) {
        self.shown = index.min(self.states().len().saturating_sub(1));
    }

    /// Shows another branch, at its last state.
    pub(super) fn switch(&mut self, id: u32) {
        if let Some(index) = self.branches.iter().position(|b| b.id == id) {
            self.current = index;
            self.shown = self.states().len().saturating_sub(1);
        }
    }

    pub(super) fn rename(&mut self, id: u32, name: &str) {
        let name = name.trim();
        if name.is_empty() {
            return;
        }
        let name = self.free_name(id, name.to_owned());
        if let Some(branch) = self.branches.iter_mut().find(|b| b.id == id) {
            branch.name = name;
        }
    }

    /// The name, with a number appended if another branch already has it.
    fn free_name(&self, id: u32, name: String) -> String {
        let is_free = |name: &String| self.branches.iter().all(|b| b.id == id || b.name != *name);
        if is_free(&name) {
            return name;
        }
        let numbered = (2..).map(|n| format!("{name} ({n})")).find(is_free);
        numbered.unwrap_or(name)
    }

    /// Removes a branch, except the last. Branches that started from it stay complete.
    pub(super) fn remove(&mut self, id: u32) {
        let Some(index) = self.branches.iter().position(|b| b.id == id) else { return };
        if self.branches.len() < 2 {
            return;
        }
        let (shown, growing) = (self.branches[self.current].id, self.branches[self.growing].id);
        self.branches.remove(index);
        for branch in &mut self.branches {
            branch.origin.take_if(|o| o.branch == id);
        }
        let place = |id| self.branches.iter().position(|b| b.id == id);
        self.growing = place(growing).unwrap_or(0);
        if let Some(current) = place(shown) {
            self.current = current;
        } else {
            self.current = index.min(self.branches.len() - 1);
            self.shown = self.states().len().saturating_sub(1);
        }
    }

    /// Keys of all states.
    pub fn keys(&self) -> BTreeSet<u64> {
        self.branches.iter().flat_map(|b| &b.states).map(|s| s.key).collect()
    }
}

/// What marks a state on the timeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mark {
    Birth,
    Death,
    Split,
    Freeze,
    Merge,
    Edit,
}

impl Mark {
    pub const ALL: [Self; 6] = [Self::Birth, Self::Death, Self::Split, Self::Freeze, Self::Merge, Self::Edit];

    pub fn text(self) -> &'static str {
        match self {
            Self::Birth => "Birth",
            Self::Death => "Death",
            Self::Split => "Split",
            Self::Freeze => "Freeze",
            Self::Merge => "Merge",
            Self::Edit => "Edit",
        }
    }

    /// The events that led to a state, each kind once.
    pub fn of(state: &Snapshot) -> BTreeSet<Self> {
        use crate::inference::Occurrence;
        let mut marks: BTreeSet<Self> = state
            .occurrences
            .iter()
            .map(|occurrence| match occurrence {
                Occurrence::Born { .. } => Self::Birth,
                Occurrence::Died { .. } => Self::Death,
                Occurrence::Split { .. } | Occurrence::Separated { .. } | Occurrence::Cut { .. } => {
                    Self::Split
                }
                Occurrence::Froze { .. } => Self::Freeze,
                Occurrence::Merged(_) => Self::Merge,
                _ => Self::Edit,
            })
            .collect();
        if state.cause == Cause::Edit {
            marks.insert(Self::Edit);
        }
        marks
    }
}
