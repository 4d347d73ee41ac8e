//! Manual changes to states: navigation, edits, proposed merges and undo.

use std::sync::Arc;

use super::action::{Action, Level};
use super::document::Document;
use super::merging::MERGE;
use super::undo::{Step, Undoable};
use super::verb::Verb;
use super::{Effect, Session};
use crate::inference::{Edit, Setting};
use crate::io::Shape;
use crate::worker::{Activity, Command, LoadedShape};

impl Session {
    /// Commands that bring the worker to the shown state; none if it is already there.
    pub(super) fn sync(&mut self) -> Vec<Effect> {
        let Some(state) = self.shown_state() else { return Vec::new() };
        let key = state.snapshot.key;
        if self.worker_at == Some(key) {
            return Vec::new();
        }
        self.worker_at = Some(key);
        self.live.forget();
        vec![Effect::Send(Command::Resume(state)), Effect::Send(Command::SetParams(self.params))]
    }

    /// Work that continues from the shown state, in a new branch if there are later states.
    pub(super) fn work(&mut self, command: Command, activity: Activity) -> Vec<Effect> {
        self.timeline.branch_here();
        let mut effects = self.sync();
        effects.extend(self.command(command, activity));
        effects
    }

    pub(super) fn edit(&mut self, edits: Vec<Edit>) -> Vec<Effect> {
        self.by_hand(edits.into_iter().map(Command::Edit).collect())
    }

    /// Commands that change the shown state.
    pub(super) fn by_hand(&mut self, commands: Vec<Command>) -> Vec<Effect> {
        if self.snapshot.is_none() || commands.is_empty() {
            return Vec::new();
        }
        self.drop_proposal();
        self.timeline.branch_here();
        let mut effects = self.sync();
        self.answered = Some(self.messages.count());
        effects.extend(commands.into_iter().map(Effect::Send));
        effects
    }

    /// The edits that the verb makes to the current selection.
    pub(super) fn edits_of(&self, verb: Verb) -> Vec<Edit> {
        if verb == Verb::LockSelected {
            let selected = || self.primitives().iter().filter(|p| self.selection.contains(&p.id));
            let locked = !selected().all(|p| p.locked);
            return selected()
                .filter(|p| p.locked != locked)
                .map(|p| Edit::Lock { id: p.id, locked })
                .collect();
        }
        self.edit_of(verb).into_iter().collect()
    }

    fn edit_of(&self, verb: Verb) -> Option<Edit> {
        let ids: Vec<u32> = self.selection.iter().copied().collect();
        let samples = self.selected_points.to_vec();
        Some(match verb {
            Verb::MergeSelected => Edit::Merge { ids },
            Verb::SplitSelected => Edit::Split { id: *ids.first()? },
            Verb::RefitSelected => Edit::Refit { id: *ids.first()? },
            Verb::DeleteSelected => Edit::Delete { ids },
            Verb::NewCluster => Edit::NewCluster { samples },
            Verb::BelongTogether => Edit::Together { samples },
            Verb::ReleasePoints if samples.is_empty() => {
                Edit::Release { samples: self.snapshot.as_ref()?.abstraction.pinned.to_vec() }
            }
            Verb::ReleasePoints => Edit::Release { samples },
            _ => return None,
        })
    }

    /// Continues the finished run for the same number of iterations.
    pub(super) fn extend(&mut self) -> Vec<Effect> {
        let more = self.params.iterations;
        let done = self.snapshot.as_ref().map_or(0, |s| s.abstraction.iteration);
        let effects = self.work(Command::Extend(more), Activity::Running);
        // As the run's own T, which the next change of a slider sends back.
        self.params.iterations = (done + more).min(Setting::Iterations.most());
        effects
    }

    /// Shows a state of the current branch. The worker follows only when there is something to do.
    pub(super) fn show_state_at(&mut self, index: usize) -> Vec<Effect> {
        if index == self.timeline.shown_index() {
            return Vec::new();
        }
        self.timeline.show(index);
        self.show_timeline()
    }

    /// Shows the timeline's current state and stops playback.
    pub(super) fn show_timeline(&mut self) -> Vec<Effect> {
        self.playback.is_playing = false;
        self.drop_proposal();
        self.drop_draft();
        self.merge_text = None;
        let Some(state) = self.shown_state() else {
            self.snapshot = None;
            return Vec::new();
        };
        let same_samples = self.loaded.as_ref().is_some_and(|l| Arc::ptr_eq(&l.cloud, &state.loaded.cloud));
        if !same_samples {
            self.explained = None;
            self.selected_points = Arc::default();
        }
        self.loaded = Some(Arc::clone(&state.loaded));
        self.show_state(Arc::clone(&state.snapshot));
        self.measure_shown()
    }

    /// Requests a measurement of the shown state, unless it is measured or a run is in progress.
    pub(super) fn measure_shown(&self) -> Vec<Effect> {
        let Some(state) = self.shown_state() else { return Vec::new() };
        let is_measured = self.measurement().is_some() || self.is_measuring();
        // Measuring takes a core, which a run has better use for.
        if is_measured || self.activity != Activity::Idle {
            return Vec::new();
        }
        vec![Effect::Send(Command::Measure(state))]
    }

    /// How an action is undone; `None` for actions that change only the view.
    pub(super) fn undoable(&self, action: &Action) -> Option<Undoable> {
        let step = |text: &str| Some(Undoable::Step(text.to_owned()));
        match action {
            Action::Verb(verb) => match verb {
                verb if verb.is_edit() => step(verb.entry().text),
                Verb::OpenBuiltIn
                | Verb::Run
                | Verb::StepIteration
                | Verb::MergeAll
                | Verb::Reset
                | Verb::Resample
                | Verb::Continue
                | Verb::ContinueHere
                | Verb::Deselect
                | Verb::HideSelected
                | Verb::ShowAll => step(verb.entry().text.trim_end_matches('…')),
                Verb::AcceptMerge => step(MERGE),
                _ => None,
            },
            Action::TakeFrom(_) | Action::Paste(_) => step("Import primitives"),
            Action::OpenFile(path) => {
                let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
                step(&format!("Open {name}"))
            }
            Action::RunAsSet => step(Verb::Run.entry().text),
            Action::SetParams(_) => Some(Undoable::Gesture("Change parameters".to_owned())),
            Action::SetSampling(_) => Some(Undoable::Gesture("Change sampling".to_owned())),
            Action::SetMethod(method) => step(&format!("Choose {}", method.name())),
            Action::Edit(edit @ Edit::SetShape { .. }) => Some(Undoable::Gesture(name_of(edit))),
            Action::Edit(edit) => Some(Undoable::Step(name_of(edit))),
            Action::EndGesture => self.drafted_edit().map(|edit| Undoable::Step(name_of(&edit))),
            Action::Select(_) | Action::ToggleSelected(_) | Action::SelectPrimitives { .. } => step("Select"),
            Action::SelectPoints { .. } => step("Select points"),
            Action::SetPrimitiveVisible(..) => step("Show or hide"),
            Action::TakeSeed(seed) => step(&format!("Open seed {seed}")),
            Action::RenameBranch(..) => step("Rename branch"),
            Action::RemoveBranch(_) => step("Remove branch"),
            _ => None,
        }
    }

    pub(super) fn undo_step(&mut self) -> Vec<Effect> {
        if let Some(effects) = self.take_back_decision() {
            return effects;
        }
        let now = self.document();
        match self.undo.undo(&now) {
            Some(step) => self.restore(&step, "Undone"),
            None => Vec::new(),
        }
    }

    pub(super) fn redo_step(&mut self) -> Vec<Effect> {
        let now = self.document();
        match self.undo.redo(&now) {
            Some(step) => self.restore(&step, "Redone"),
            None => Vec::new(),
        }
    }

    pub(super) fn restore(&mut self, step: &Step, how: &str) -> Vec<Effect> {
        self.messages.push(Level::Note, format!("{how}: {}", step.label), "");
        self.take_document(step.document.clone())
    }

    /// Makes a document the current one and stops the worker.
    pub fn take_document(&mut self, document: Document) -> Vec<Effect> {
        let Document { loaded, params, sampling, timeline, selection, selected_points, hidden } = document;
        let shape_of = |l: &Option<Arc<_>>| l.as_ref().map(|l| Arc::as_ptr(shape(l)));
        let is_same_shape = shape_of(&self.loaded) == shape_of(&loaded);
        let set_params = (self.params != params).then_some(Effect::Send(Command::SetParams(params)));
        self.loaded = loaded;
        self.params = params;
        self.sampling = sampling;
        self.timeline = timeline;
        self.run_when_loaded = false;
        if !is_same_shape {
            self.explained = None;
            self.seeds.clear();
            self.measured.clear();
            self.estimates.forget();
            self.measuring = None;
            self.refit_scene();
            self.camera.frame(&self.scene.bounds);
        }
        let was_busy = self.activity != Activity::Idle;
        let mut effects = Vec::new();
        if was_busy {
            // Whatever it still has to tell is of a state that is gone.
            self.worker_at = None;
            effects = self.sync();
            if effects.is_empty() {
                effects.push(Effect::Send(Command::Pause));
            }
            self.live.forget();
        }
        self.activity = Activity::Idle;
        effects.extend(self.show_timeline());
        effects.extend(set_params);
        self.selection = selection;
        self.selected_points = selected_points;
        self.hidden = hidden;
        effects
    }
}

fn shape(loaded: &Arc<LoadedShape>) -> &Arc<Shape> {
    &loaded.shape
}

/// Name of an edit.
fn name_of(edit: &Edit) -> String {
    match edit {
        Edit::SetShape { id, .. } => format!("Reshape primitive {id}"),
        Edit::Refit { id } => format!("Refit primitive {id}"),
        Edit::Lock { locked: true, .. } => "Lock".to_owned(),
        Edit::Lock { locked: false, .. } => "Unlock".to_owned(),
        Edit::Merge { .. } | Edit::AcceptMerge { .. } => "Merge".to_owned(),
        Edit::Split { id } => format!("Split primitive {id}"),
        Edit::Delete { .. } => "Delete".to_owned(),
        Edit::NewCluster { .. } => "New cluster".to_owned(),
        Edit::Together { .. } => "Pin to one cluster".to_owned(),
        Edit::Release { .. } => "Unpin points".to_owned(),
        Edit::Take { .. } => "Import primitives".to_owned(),
    }
}
