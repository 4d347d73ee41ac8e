//! What the window knows, as plain data: [`Session::apply`] takes what a
//! person asks for, [`Session::absorb`] what the worker tells. Both answer
//! with [`Effect`]s, which the owner carries out.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use crate::geometry::SampledPart;
use crate::inference::{Algorithm, Occurrence, Params, Phase, Primitive, Setting};
use crate::worker::{
    Activity, Command, Event, LoadedShape, Measurement, Pace, SamplingOptions, Snapshot, Source,
};

pub mod action;
pub mod camera;
pub mod history;
pub mod live;
pub mod messages;
pub mod scalar;
pub mod scene;
pub mod selection;
pub mod view;

#[cfg(test)]
mod tests;

pub use action::{Action, Export, Verb};
use camera::{AxisView, Bounds, Camera};
use history::History;
use live::Live;
use messages::{Level, Messages};
use scene::{SceneFromInput, UpAxis};
use view::{Picks, ThemeChoice, Tool, View};

/// A pace at which a person can follow each iteration, and the default run
/// takes about three seconds. Who wants the result at once turns a slider with
/// Live on, or chooses no pace.
pub const DEFAULT_PACE: Pace = Pace::PerSecond(10);

/// What the owner of a session has to do.
#[derive(Debug, Clone)]
pub enum Effect {
    Send(Command),
    AskForShape,
    AskForExport(Export),
    AskForScreenshot,
    SaveScreenshot(PathBuf),
    Quit,
}

/// All that the window shows, apart from what egui remembers of its widgets.
#[derive(Debug)]
pub struct Session {
    pub loaded: Option<Arc<LoadedShape>>,
    /// The newest state.
    pub snapshot: Option<Arc<Snapshot>>,
    pub history: History,
    /// As the sliders stand.
    pub params: Params,
    pub sampling: SamplingOptions,
    pub pace: Pace,
    pub live: Live,
    pub activity: Activity,
    pub view: View,
    pub camera: Camera,
    /// Counts the camera's moves that no drag made: a view may ease them.
    pub camera_jumps: u64,
    pub scene: SceneFromInput,
    /// Ids of the selected primitives.
    pub selection: BTreeSet<u32>,
    /// Indices of the selected samples, ascending.
    pub selected_points: Arc<[u32]>,
    /// Ids of the primitives that are not shown.
    pub hidden: BTreeSet<u32>,
    pub messages: Messages,
    /// What the last merge came to.
    pub merge_text: Option<String>,
    /// The last state that was measured.
    measurement: Option<Arc<Measurement>>,
    /// The state that is being measured.
    measuring: Option<Arc<Snapshot>>,
    /// No pair of the present state may be merged.
    merges_are_exhausted: bool,
    /// Run as soon as the shape that is on its way has arrived.
    run_when_loaded: bool,
    /// The messages that were there when the person last asked for work: what
    /// they say is over when that work succeeds.
    answered: Option<u64>,
}

impl Session {
    pub fn new(params: Params, sampling: SamplingOptions) -> Self {
        Self {
            loaded: None,
            snapshot: None,
            history: History::default(),
            params,
            sampling,
            pace: DEFAULT_PACE,
            live: Live::default(),
            activity: Activity::Idle,
            view: View::default(),
            camera: Camera::default(),
            camera_jumps: 0,
            scene: SceneFromInput::fit(&[], UpAxis::Y),
            selection: BTreeSet::new(),
            selected_points: Arc::default(),
            hidden: BTreeSet::new(),
            messages: Messages::default(),
            merge_text: None,
            measurement: None,
            measuring: None,
            merges_are_exhausted: false,
            run_when_loaded: false,
            answered: None,
        }
    }

    /// The commands that bring a new worker to this session's settings and
    /// open the first shape, which is run at once.
    pub fn begin(&mut self, source: Source) -> [Command; 3] {
        [Command::SetParams(self.params), Command::SetPace(self.pace), self.load(source)]
    }

    /// The present primitives; none where nothing has been run.
    pub fn primitives(&self) -> &[Primitive] {
        self.snapshot.as_ref().map_or(&[], |s| &s.abstraction.primitives)
    }

    /// The one selected primitive; `None` if none or several are selected.
    pub fn selected_primitive(&self) -> Option<&Primitive> {
        let [id] = self.selection.iter().copied().collect::<Vec<_>>()[..] else { return None };
        self.primitives().iter().find(|p| p.id == id)
    }

    pub fn phase(&self) -> Option<Phase> {
        self.snapshot.as_ref().map(|s| s.abstraction.phase)
    }

    /// The figures of the present state, where it has been measured.
    pub fn measurement(&self) -> Option<&Measurement> {
        self.measurement.as_deref().filter(|m| self.is_present(&m.snapshot))
    }

    /// The newest figures of this shape, of whatever state.
    pub fn last_measurement(&self) -> Option<&Measurement> {
        self.measurement.as_deref()
    }

    /// Whether the present state is being measured.
    pub fn is_measuring(&self) -> bool {
        self.measuring.as_ref().is_some_and(|s| self.is_present(s))
    }

    fn is_present(&self, snapshot: &Arc<Snapshot>) -> bool {
        self.snapshot.as_ref().is_some_and(|present| Arc::ptr_eq(present, snapshot))
    }

    /// Whether the worker is busy with the run (not with files).
    pub fn is_running(&self) -> bool {
        matches!(self.activity, Activity::Running | Activity::Merging)
    }

    /// The parameters of the present run's start, where what belongs to a
    /// start has been changed since: the method's algorithm, K or the seed, as
    /// far as the run to come reads them.
    pub fn stale_start(&self) -> Option<Params> {
        let start = self.snapshot.as_ref()?.start;
        let now = &self.params;
        let differs = start.algorithm != now.algorithm
            || (start.clusters != now.clusters && now.reads(Setting::Clusters))
            || (start.seed != now.seed && now.reads(Setting::Seed));
        differs.then_some(start)
    }

    /// Whether the verb would do something now.
    pub fn is_enabled(&self, verb: Verb) -> bool {
        let loaded = self.loaded.is_some();
        // What is asked for while a run is made anew waits for its result, which
        // takes a blink: the buttons don't.
        let idle = matches!(self.activity, Activity::Idle | Activity::Renewing);
        match verb {
            Verb::ExportCloud | Verb::ExportPrimitives => self.snapshot.is_some() && idle,
            Verb::Run => loaded && idle,
            Verb::Pause => self.is_running() || self.activity == Activity::Loading,
            Verb::StepIteration => loaded && idle && self.phase() != Some(Phase::Finished),
            Verb::StepMerge | Verb::MergeAll => {
                loaded
                    && idle
                    && self.primitives().len() > 1
                    && !self.merges_are_exhausted
                    && self.why_disabled(verb).is_none()
            }
            Verb::Reset => {
                loaded
                    && self.activity != Activity::Loading
                    && (self.history.entries().len() > 1 || self.stale_start().is_some())
            }
            Verb::Resample => {
                self.activity != Activity::Loading
                    && !self.live.is_renewing()
                    && self.loaded.as_ref().is_some_and(|l| l.sampling != self.sampling)
            }
            Verb::Deselect => !self.selection.is_empty() || !self.selected_points.is_empty(),
            Verb::FrameSelection => !self.selection.is_empty() || !self.selected_points.is_empty(),
            Verb::HideSelected => !self.selection.is_empty(),
            Verb::FrameAll => loaded,
            Verb::ShowAll => !self.hidden.is_empty(),
            _ => true,
        }
    }

    /// Whether a verb that switches something is on; `None` for the others.
    pub fn is_on(&self, verb: Verb) -> Option<bool> {
        match verb {
            Verb::ToggleOrthographic => Some(self.camera.orthographic),
            Verb::ToggleLive => Some(self.live.is_on),
            Verb::ToggleLog => Some(self.view.shows_log),
            Verb::ToolClick => Some(self.view.tool == Tool::Click),
            Verb::ToolBox => Some(self.view.tool == Tool::Box),
            Verb::ToolLasso => Some(self.view.tool == Tool::Lasso),
            Verb::TogglePicks => Some(self.view.picks == Picks::Points),
            Verb::ThemeSystem => Some(self.view.theme == ThemeChoice::System),
            Verb::ThemeLight => Some(self.view.theme == ThemeChoice::Light),
            Verb::ThemeDark => Some(self.view.theme == ThemeChoice::Dark),
            _ => None,
        }
    }

    /// What the present run computes with.
    pub fn algorithm(&self) -> Algorithm {
        self.snapshot.as_ref().map_or(self.params.algorithm, |s| s.start.algorithm)
    }

    /// Why the verb can't be had, where a person would not guess.
    pub fn why_disabled(&self, verb: Verb) -> Option<&'static str> {
        let merges = matches!(verb, Verb::StepMerge | Verb::MergeAll);
        (merges && self.algorithm() != Algorithm::Sampler)
            .then_some("Only the sampler merges; the method of this run has nothing to judge a merge by")
    }

    /// Does what a person asked for.
    pub fn apply(&mut self, action: Action) -> Vec<Effect> {
        match action {
            Action::Verb(verb) if self.is_enabled(verb) => return self.apply_verb(verb),
            Action::Verb(_) => {}
            Action::OpenFile(path) => return self.open(Source::File(path)),
            Action::Export(Export::Cloud, path) => return vec![Effect::Send(Command::ExportCloud(path))],
            Action::Export(Export::Primitives, path) => {
                return vec![Effect::Send(Command::ExportPrimitives(path))];
            }
            Action::SaveScreenshot(path) => return vec![Effect::SaveScreenshot(path)],
            Action::SetParams(params) => return self.take_setup(params, self.sampling),
            Action::SetMethod(method) => {
                let params = Params { seed: self.params.seed, ..method.params() };
                return self.take_setup(params, self.sampling);
            }
            Action::SetSampling(sampling) => return self.take_setup(self.params, sampling),
            Action::HandRests => return self.hand_rests().into_iter().collect(),
            Action::SetPace(pace) => {
                self.pace = pace;
                return vec![Effect::Send(Command::SetPace(pace))];
            }
            Action::Select(id) => self.selection = id.into_iter().collect(),
            Action::ToggleSelected(id) => {
                if !self.selection.remove(&id) {
                    self.selection.insert(id);
                }
            }
            Action::SelectPrimitives { ids, how } => {
                let present = self.primitives().iter().map(|p| p.id).collect::<BTreeSet<_>>();
                let meant = ids.into_iter().filter(|id| present.contains(id)).collect();
                how.apply_to_set(&mut self.selection, meant);
            }
            Action::SelectPoints { samples, how } => {
                let count = self.loaded.as_ref().map_or(0, |l| l.cloud.points.len());
                self.selected_points = how.apply_to_list(&self.selected_points, samples, count);
            }
            Action::SetPrimitiveVisible(id, true) => {
                self.hidden.remove(&id);
            }
            Action::SetPrimitiveVisible(id, false) => {
                self.hidden.insert(id);
            }
            Action::SetLayer(layer, shown) => self.view.set_layer(layer, shown),
            Action::SetSurfaceStyle(style) => self.view.surface_style = style,
            Action::SetPointSize(size) => {
                self.view.point_size = size.clamp(View::POINT_SIZE.0, View::POINT_SIZE.1);
            }
            Action::SetColorBy(by) => self.view.color_by = by,
            Action::SetVisibleOnly(on) => self.view.visible_only = on,
            Action::SetUpAxis(up) => {
                self.view.up = up;
                self.refit_scene();
                self.camera.frame(&self.scene.bounds);
            }
            Action::Orbit { right, up } => self.camera.orbit(right, up),
            Action::Pan(offset) => self.camera.pan(offset),
            Action::Zoom { cursor, factor } => self.camera.zoom_to(cursor, factor),
            Action::SetPivot(point) => {
                self.camera_jumps += 1;
                self.camera.set_pivot(point);
            }
            Action::SetAspect(aspect) => self.set_aspect(aspect),
            Action::DismissErrors => self.messages.dismiss_errors(),
            Action::Tell { what, error } => self.messages.push(Level::Error, what, error),
            Action::Note(text) => {
                self.messages.dismiss_errors();
                self.messages.push(Level::Note, text, "");
            }
        }
        Vec::new()
    }

    fn apply_verb(&mut self, verb: Verb) -> Vec<Effect> {
        match verb {
            Verb::Open => return vec![Effect::AskForShape],
            Verb::OpenBuiltIn => return self.open(Source::BuiltIn),
            Verb::ExportCloud => return vec![Effect::AskForExport(Export::Cloud)],
            Verb::ExportPrimitives => return vec![Effect::AskForExport(Export::Primitives)],
            Verb::SaveScreenshot => return vec![Effect::AskForScreenshot],
            Verb::Quit => return vec![Effect::Quit],
            Verb::Run => return self.command(Command::Run, Activity::Running),
            Verb::Pause => {
                self.run_when_loaded = false;
                return vec![Effect::Send(Command::Pause)];
            }
            Verb::StepIteration => return self.command(Command::StepIteration, Activity::Running),
            Verb::StepMerge => return self.command(Command::StepMerge, Activity::Merging),
            Verb::MergeAll => return self.command(Command::MergeAll, Activity::Merging),
            Verb::Reset => return self.command(Command::Reset, Activity::Loading),
            Verb::Resample => return self.command(Command::Resample(self.sampling), Activity::Loading),
            Verb::ToggleLive => return self.set_live(!self.live.is_on).into_iter().collect(),
            Verb::FrameSelection => {
                if let Some(bounds) = self.selection_bounds() {
                    self.jump(|camera| camera.frame(&bounds));
                }
            }
            Verb::FrameAll => {
                let bounds = self.scene.bounds;
                self.jump(|camera| camera.frame(&bounds));
            }
            Verb::ViewFront => self.jump(|camera| camera.look(AxisView::Front)),
            Verb::ViewBack => self.jump(|camera| camera.look(AxisView::Back)),
            Verb::ViewRight => self.jump(|camera| camera.look(AxisView::Right)),
            Verb::ViewLeft => self.jump(|camera| camera.look(AxisView::Left)),
            Verb::ViewTop => self.jump(|camera| camera.look(AxisView::Top)),
            Verb::ViewBottom => self.jump(|camera| camera.look(AxisView::Bottom)),
            Verb::ToggleOrthographic => self.camera.orthographic ^= true,
            Verb::ToolClick => self.view.tool = Tool::Click,
            Verb::ToolBox => self.view.tool = Tool::Box,
            Verb::ToolLasso => self.view.tool = Tool::Lasso,
            Verb::TogglePicks => {
                self.view.picks = match self.view.picks {
                    Picks::Primitives => Picks::Points,
                    Picks::Points => Picks::Primitives,
                };
            }
            Verb::Deselect => {
                self.selection.clear();
                self.selected_points = Arc::default();
            }
            Verb::HideSelected => self.hidden.extend(&self.selection),
            Verb::ShowAll => self.hidden.clear(),
            Verb::ToggleLog => self.view.shows_log ^= true,
            Verb::ThemeSystem => self.view.theme = ThemeChoice::System,
            Verb::ThemeLight => self.view.theme = ThemeChoice::Light,
            Verb::ThemeDark => self.view.theme = ThemeChoice::Dark,
            Verb::ShowShortcuts => self.view.shows_shortcuts ^= true,
            Verb::ShowAbout => self.view.shows_about ^= true,
        }
        Vec::new()
    }

    fn command(&mut self, command: Command, activity: Activity) -> Vec<Effect> {
        self.expect(activity);
        vec![Effect::Send(command)]
    }

    /// The activity is assumed at once, so that no button can be pressed
    /// twice; the worker answers every command with its own word on it.
    fn expect(&mut self, activity: Activity) {
        self.activity = activity;
        self.live.forget();
        self.answered = Some(self.messages.count());
    }

    fn open(&mut self, source: Source) -> Vec<Effect> {
        vec![Effect::Send(self.load(source))]
    }

    fn load(&mut self, source: Source) -> Command {
        self.run_when_loaded = true;
        self.expect(Activity::Loading);
        Command::Load { source, sampling: self.sampling }
    }

    /// Moves the camera to another place at once.
    fn jump(&mut self, to: impl FnOnce(&mut Camera)) {
        self.camera_jumps += 1;
        to(&mut self.camera);
    }

    /// The box around the selected primitives and points, in scene units.
    fn selection_bounds(&self) -> Option<Bounds> {
        let selected = self.primitives().iter().filter(|p| self.selection.contains(&p.id));
        let boxes = selected.filter_map(|p| self.scene.bounds_of(&p.shape));
        let points = self.loaded.iter().flat_map(|loaded| {
            let samples = self.selected_points.iter();
            samples.filter_map(|&i| loaded.cloud.points.get(i as usize)).map(|p| self.scene.point(p))
        });
        Bounds::around(boxes.flat_map(|b| [b.min, b.max]).chain(points).collect::<Vec<_>>())
    }

    fn set_aspect(&mut self, aspect: f64) {
        if aspect.is_finite() && aspect > 0.0 {
            // Before the first picture, the framing could only guess the window's form.
            let is_first = self.camera.aspect == Camera::default().aspect;
            self.camera.aspect = aspect;
            if is_first && self.loaded.is_some() {
                self.camera.frame(&self.scene.bounds);
            }
        }
    }

    fn refit_scene(&mut self) {
        let points = self.loaded.as_ref().map_or(&[][..], |l| &l.cloud.points);
        self.scene = SceneFromInput::fit(points, self.view.up);
    }

    /// Takes in what the worker tells.
    pub fn absorb(&mut self, event: Event) -> Vec<Effect> {
        match event {
            Event::Loaded(shape) => return self.absorb_shape(shape),
            Event::Snapshot(snapshot) => self.absorb_snapshot(snapshot),
            Event::Activity(activity) => {
                self.activity = activity;
                if activity == Activity::Idle {
                    // Whatever was on its way has arrived, failed or was cancelled.
                    self.run_when_loaded = false;
                    self.live.finish();
                    return self.renew_if_due().into_iter().collect();
                }
            }
            Event::Renewing(setup) => self.live.begin(setup),
            Event::Renewed(renewed) => self.absorb_renewed(&renewed),
            Event::MergeStep(Some(report)) => {
                let (a, b) = report.merged;
                let gone = if a == report.into { b } else { a };
                let text = format!("Merged {gone} into {}: {}", report.into, report.reason);
                self.messages.push(Level::Detail, text.clone(), "");
                self.merge_text = Some(text);
            }
            Event::MergeStep(None) => {
                self.merges_are_exhausted = true;
                self.dismiss_answered();
                self.merge_text = Some("No pair is left that may be merged.".to_owned());
            }
            Event::Measuring(snapshot) => self.measuring = Some(snapshot),
            Event::Measured(measurement) => {
                self.measuring.take_if(|s| Arc::ptr_eq(s, &measurement.snapshot));
                // A state that was left behind doesn't matter any more.
                if self.is_present(&measurement.snapshot) {
                    self.measurement = Some(measurement);
                }
            }
            Event::Written { path, what } => {
                // What could not be written before can be now.
                self.messages.dismiss_errors();
                self.messages.push(Level::Note, format!("Wrote the {what} to {}", path.display()), "");
            }
            Event::Failed { what, error } => self.messages.push(Level::Error, what, error),
        }
        Vec::new()
    }

    fn absorb_shape(&mut self, shape: Arc<LoadedShape>) -> Vec<Effect> {
        let is_same = self.loaded.as_ref().is_some_and(|old| Arc::ptr_eq(&old.shape, &shape.shape));
        let name = &shape.shape.name;
        for note in &shape.shape.notes {
            if !is_same {
                self.messages.push(Level::Note, format!("{name}: {note}"), "");
            }
        }
        let points = shape.cloud.points.len();
        self.messages.push(Level::Detail, format!("Loaded {name} with {points} samples"), "");
        if let Some(note) = shape.cloud.part.note() {
            let level = match shape.cloud.part {
                SampledPart::WholeAsHidden | SampledPart::Connected { .. } => Level::Note,
                SampledPart::Whole | SampledPart::Outside { .. } => Level::Detail,
            };
            self.messages.push(level, format!("{name}: {note}"), "");
        }
        // What went wrong before doesn't concern the new shape.
        self.messages.dismiss_errors();
        self.loaded = Some(shape);
        self.snapshot = None;
        self.measurement = None;
        self.measuring = None;
        self.merge_text = None;
        self.selection.clear();
        self.selected_points = Arc::default();
        self.hidden.clear();
        self.refit_scene();
        if !is_same {
            self.camera.frame(&self.scene.bounds);
        }
        // It has arrived, whatever comes of it next.
        self.activity = Activity::Idle;
        if let Some(renewal) = self.renew_if_due() {
            return vec![renewal];
        }
        if std::mem::take(&mut self.run_when_loaded) {
            return self.command(Command::Run, Activity::Running);
        }
        Vec::new()
    }

    fn absorb_snapshot(&mut self, snapshot: Arc<Snapshot>) {
        self.history.push(&snapshot);
        for occurrence in &snapshot.occurrences {
            if let Occurrence::Merged(report) = occurrence {
                // The selection goes on with what it has become.
                for id in [report.merged.0, report.merged.1] {
                    if id != report.into && self.selection.remove(&id) {
                        self.selection.insert(report.into);
                    }
                }
            }
        }
        if !snapshot.occurrences.is_empty() {
            let text = messages::of_step(&snapshot);
            self.messages.push(Level::Detail, text, "");
            self.dismiss_answered();
        }
        self.show_state(snapshot);
    }

    /// Makes a state the present one.
    fn show_state(&mut self, snapshot: Arc<Snapshot>) {
        self.merges_are_exhausted = false;
        if self
            .snapshot
            .as_ref()
            .is_none_or(|old| (old.generation, old.run) != (snapshot.generation, snapshot.run))
        {
            self.merge_text = None;
            // A run that starts leaves behind what stopped the last one.
            self.messages.dismiss_errors();
        }
        self.snapshot = Some(snapshot);
        let present: BTreeSet<u32> = self.primitives().iter().map(|p| p.id).collect();
        self.selection.retain(|id| present.contains(id));
        self.hidden.retain(|id| present.contains(id));
    }

    /// The work that was asked for has succeeded: what went wrong before it
    /// matters no more.
    fn dismiss_answered(&mut self) {
        if let Some(number) = self.answered.take() {
            self.messages.dismiss_errors_until(number);
        }
    }
}
