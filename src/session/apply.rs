//! Applies user actions.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::action::{Action, Level, PictureKind};
use super::camera::{AxisView, Bounds, Camera};
use super::gizmo::Mode;
use super::saving::{Opening, Parting};
use super::scalar::Top;
use super::scene::SceneFromInput;
use super::undo::Undoable;
use super::verb::Verb;
use super::view::{Picks, ThemeChoice, Tool, View};
use super::window::Panel;
use super::{Effect, Session};
use crate::inference::Params;
use crate::io::Format;
use crate::worker::{Activity, Command, Source};

impl Session {
    /// Applies an action and records how to undo it.
    pub fn apply(&mut self, action: Action) -> Vec<Effect> {
        if let Action::Verb(verb) = action
            && let Some(why) = self.reason(verb)
        {
            self.messages.push(Level::Note, verb.entry().text.trim_end_matches('…'), why);
            return Vec::new();
        }
        let undoable = self.undoable(&action);
        let before = undoable.as_ref().map(|_| self.document());
        let effects = self.carry_out(action);
        if let (Some(undoable), Some(before)) = (undoable, before) {
            let changed = before != self.document();
            let works = effects.iter().any(|e| matches!(e, Effect::Send(_)));
            match undoable {
                Undoable::Gesture(label) if changed || works => self.undo.record_gesture(&label, before),
                Undoable::Step(label) if changed || works => self.undo.record(label, before),
                _ => {}
            }
        }
        effects
    }

    pub(super) fn carry_out(&mut self, action: Action) -> Vec<Effect> {
        match action {
            Action::Verb(verb) => return self.apply_verb(verb),
            Action::SaveSession(path) => return self.write(path, Effect::SaveSession),
            Action::OpenSession(opening) => return self.leave(Parting::Open(opening)),
            Action::DiscardFound(id) => return vec![self.discard_found(id)],
            Action::PutOffFound => self.put_off_found(),
            Action::AnswerParting(answer) => return self.answer_parting(answer),
            Action::FromList(name, action) => {
                self.window.remember_command(&name);
                return self.apply(*action);
            }
            Action::OpenFile(path) => return self.open_file(path),
            Action::OpenDropped(paths) => return self.open_dropped(paths.into_inner()),
            Action::OpenRecent(path) => return vec![Effect::OpenIfThere(path)],
            Action::ForgetRecent(path) => self.forget_recent(&path),
            Action::ShowInFolder(path) => return vec![Effect::ShowInFolder(path)],
            Action::OpenLink(address) => return vec![Effect::OpenLink(address)],
            Action::Export(path) => return self.export(path),
            Action::SetExport(choice) => self.window.export = choice,
            Action::TakeFrom(path) => return self.take_from(path),
            Action::Paste(text) => return self.paste_primitives(&text),
            Action::Edit(edit) => return self.edit(vec![edit]),
            Action::ProposeMergeOf(a, b) => return self.propose(Some((a, b))),
            Action::ShowState(index) => return self.show_state_at(index),
            Action::ShowStateOf(id, index) => {
                self.timeline.switch(id);
                self.timeline.show(index);
                return self.show_timeline();
            }
            Action::PlayOn(seconds) => return self.play_on(seconds),
            Action::SetPlaySpeed(speed) => self.playback.set_speed(speed),
            Action::SetCurve(curve, shown) => self.curves.set(curve, shown),
            Action::Compare(comparison) => return self.compare(comparison),
            Action::InOther(action) => return self.carry_out_in_other(*action),
            Action::GoBack(steps) => return (0..steps).flat_map(|_| self.undo_step()).collect(),
            Action::GoOn(steps) => return (0..steps).flat_map(|_| self.redo_step()).collect(),
            Action::SwitchBranch(id) => {
                self.timeline.switch(id);
                return self.show_timeline();
            }
            Action::RenameBranch(id, name) => self.timeline.rename(id, &name),
            Action::RemoveBranch(id) => {
                self.timeline.remove(id);
                return self.show_timeline();
            }
            Action::DraftShape(draft) => self.take_draft(draft),
            Action::EndGesture => {
                self.undo.end_gesture();
                return self.end_shaping();
            }
            Action::TakeSeed(seed) => return self.take_seed(seed),
            Action::SetSeedOrder(order) => self.seeds.order = order,
            Action::Explain(sample) => self.explain(sample),
            Action::SaveScreenshot(path) => return self.write(path, Effect::SaveScreenshot),
            Action::SavePicture(kind, path) => {
                return self.write(path, |path| Effect::SavePicture(kind, path));
            }
            Action::SetParams(params) => return self.take_setup(params, self.sampling),
            Action::SetMethod(method) => {
                let params = Params { seed: self.params.seed, ..method.params() };
                return self.take_setup(params, self.sampling);
            }
            Action::SetSampling(sampling) => return self.take_setup(self.params, sampling),
            Action::HandRests => return self.hand_rests(),
            Action::RunAsSet => return self.run_as_set(),
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
                let meant = ids.into_inner().into_iter().filter(|id| present.contains(id)).collect();
                how.apply_to_set(&mut self.selection, meant);
            }
            Action::SelectPoints { samples, how } => {
                let count = self.loaded.as_ref().map_or(0, |l| l.cloud.points.len());
                self.selected_points = how.apply_to_list(&self.selected_points, samples.into_inner(), count);
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
            Action::SetColorBy(by) => {
                self.view.color_by = by;
                self.view.legend_top = Top::default();
            }
            Action::SetLegendTop(top) => self.view.legend_top = top,
            Action::SetUncertaintyWindow(states) => {
                let (least, most) = View::UNCERTAINTY_WINDOW;
                self.view.uncertainty_window = states.clamp(least, most);
            }
            Action::SetVisibleOnly(on) => self.view.visible_only = on,
            Action::SetUpAxis(up) => {
                self.view.up = up;
                self.refit_scene();
                self.camera.frame(&self.scene.bounds);
            }
            Action::Orbit { right, up } => self.camera.orbit(right, up),
            Action::Pan(offset) => self.camera.pan(offset),
            Action::Zoom { cursor, factor } => self.camera.zoom_to(cursor, factor),
            Action::SetPivot(point) => self.jump(|camera| camera.set_pivot(point)),
            Action::SetAspect(aspect) => self.set_aspect(aspect),
            Action::DismissError(number) => self.messages.dismiss_errors_until(number),
            Action::SetNarrow(narrow) => self.window.set_narrow(narrow),
            Action::Say(message) => self.messages.add(message),
            Action::Tell { what, error } => self.fail(what, &error),
            Action::Note(text) => {
                self.messages.dismiss_errors();
                self.messages.push(Level::Note, text, "");
            }
        }
        Vec::new()
    }

    pub(super) fn apply_verb(&mut self, verb: Verb) -> Vec<Effect> {
        match verb {
            Verb::Open => return vec![Effect::AskForShape],
            Verb::OpenBuiltIn => return self.open(Source::BuiltIn),
            Verb::Export => return vec![Effect::AskForExport],
            Verb::ExportAgain => return self.export_again(),
            Verb::CopyPrimitives => return self.copy_primitives(Format::PrimitivesJson),
            Verb::CopyCsv => return self.copy_primitives(Format::PrimitivesCsv),
            Verb::PastePrimitives => return vec![Effect::RequestPaste],
            Verb::TakeFrom => return vec![Effect::AskForPrimitives],
            Verb::SaveScreenshot => return vec![Effect::AskForScreenshot],
            Verb::SaveSession => return vec![self.save_session()],
            Verb::SaveSessionAs => return vec![self.save_session_as()],
            Verb::ReopenLast => return self.leave(Parting::Open(Opening::Last)),
            Verb::Quit => return self.leave(Parting::Quit),
            Verb::SavePicture => return vec![Effect::AskForPicture(PictureKind::Still)],
            Verb::SaveTurntable => return vec![Effect::AskForPicture(PictureKind::Turntable)],
            Verb::Run => return self.work(Command::Run, Activity::Running),
            Verb::Pause => {
                self.run_when_loaded = false;
                return vec![Effect::Send(Command::Pause)];
            }
            Verb::StepIteration => return self.work(Command::StepIteration, Activity::Running),
            Verb::StepMerge => {
                self.drop_proposal();
                return self.propose(None);
            }
            Verb::JudgeMerge => {
                if let [a, b] = self.selection.iter().copied().collect::<Vec<_>>()[..] {
                    return self.propose(Some((a, b)));
                }
            }
            Verb::DropShape => self.drop_draft(),
            Verb::HandlesMove
            | Verb::HandlesRotate
            | Verb::HandlesScale
            | Verb::HandlesTaper
            | Verb::HandlesRoundness => {
                let is_on = self.is_on(verb) == Some(true);
                self.handles = if is_on { None } else { mode_of(verb) };
            }
            Verb::AcceptMerge => return self.accept_merge(),
            Verb::SkipMerge => return self.skip_merge(),
            Verb::DropMerge => self.drop_proposal(),
            Verb::MergeAll => return self.work(Command::MergeAll, Activity::Merging),
            Verb::Reset => return self.synced(Command::Reset),
            Verb::Continue => return self.extend(),
            Verb::ContinueHere => {
                self.timeline.branch_here();
                let mut effects = self.sync();
                effects.extend(self.command(Command::Run, Activity::Running));
                return effects;
            }
            Verb::Undo => return self.undo_step(),
            Verb::Redo => return self.redo_step(),
            Verb::FirstState => return self.show_state_at(0),
            Verb::LastState => return self.show_state_at(usize::MAX),
            Verb::PreviousState => return self.show_state_at(self.timeline.shown_index().saturating_sub(1)),
            Verb::NextState => return self.show_state_at(self.timeline.shown_index() + 1),
            Verb::Play => self.play(),
            Verb::StopPlaying => return self.stop_playing(),
            Verb::ToggleLoop => self.playback.loops ^= true,
            Verb::MergeSelected
            | Verb::SplitSelected
            | Verb::DeleteSelected
            | Verb::RefitSelected
            | Verb::LockSelected
            | Verb::NewCluster
            | Verb::BelongTogether
            | Verb::ReleasePoints => return self.edit(self.edits_of(verb)),
            Verb::RunSeeds => return self.run_seeds(),
            Verb::StopSeeds => self.stop_seeds(),
            Verb::ShowSeeds => self.view.shows_seeds ^= true,
            Verb::ShowOdds => {
                self.view.shows_odds = !self.view.shows_odds || self.explained.is_none();
                if self.explained.is_none() {
                    self.messages.push(Level::Note, "Click a point to see the odds of each table", "");
                }
            }
            Verb::Resample => return self.synced(Command::Resample(self.sampling)),
            Verb::ToggleLive => return self.set_live(!self.live.is_on),
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
            Verb::ClearLog => self.messages.clear(),
            Verb::ClearRecent => self.window.recent.clear(),
            Verb::ToggleLeftPanel => self.window.toggle(Panel::Left),
            Verb::ToggleRightPanel => self.window.toggle(Panel::Right),
            Verb::ToggleBottomPanel => self.window.toggle(Panel::Bottom),
            Verb::ZoomIn => self.window.zoom_by(1.0),
            Verb::ZoomOut => self.window.zoom_by(-1.0),
            Verb::ZoomReset => self.window.set_zoom(1.0),
            Verb::ResetLayout => return self.reset_layout(),
            Verb::ShowCommands => self.window.shows_commands ^= true,
            Verb::ThemeSystem => self.view.theme = ThemeChoice::System,
            Verb::ThemeLight => self.view.theme = ThemeChoice::Light,
            Verb::ThemeDark => self.view.theme = ThemeChoice::Dark,
            Verb::ShowShortcuts => self.view.shows_shortcuts ^= true,
            Verb::ShowAbout => self.view.shows_about ^= true,
        }
        Vec::new()
    }

    /// A command for the shown shape, which the worker may not have loaded yet.
    fn synced(&mut self, command: Command) -> Vec<Effect> {
        let mut effects = self.sync();
        effects.extend(self.command(command, Activity::Loading));
        effects
    }

    pub(super) fn command(&mut self, command: Command, activity: Activity) -> Vec<Effect> {
        self.expect(activity);
        vec![Effect::Send(command)]
    }

    /// The activity is set immediately, so that no button can be pressed twice;
    /// the worker then reports its own activity for every command.
    pub(super) fn expect(&mut self, activity: Activity) {
        self.activity = activity;
        self.playback.is_playing = false;
        self.live.forget();
        self.drop_proposal();
        self.answered = Some(self.messages.count());
    }

    pub(super) fn open(&mut self, source: Source) -> Vec<Effect> {
        vec![Effect::Send(self.load(source))]
    }

    pub(super) fn load(&mut self, source: Source) -> Command {
        self.run_when_loaded = true;
        self.expect(Activity::Loading);
        Command::Load { source, sampling: self.sampling }
    }

    /// Shows the odds of a sample, or hides them.
    fn explain(&mut self, sample: Option<u32>) {
        let count = self.loaded.as_ref().map_or(0, |l| l.cloud.points.len());
        self.explained = sample.filter(|&i| (i as usize) < count);
    }

    /// Moves the camera immediately.
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

    pub(super) fn refit_scene(&mut self) {
        let points = self.loaded.as_ref().map_or(&[][..], |l| &l.cloud.points);
        self.scene = SceneFromInput::fit(points, self.view.up);
    }
}

/// The handles shown by a verb.
pub(super) fn mode_of(verb: Verb) -> Option<Mode> {
    Some(match verb {
        Verb::HandlesMove => Mode::Move,
        Verb::HandlesRotate => Mode::Rotate,
        Verb::HandlesScale => Mode::Scale,
        Verb::HandlesTaper => Mode::Taper,
        Verb::HandlesRoundness => Mode::Roundness,
        _ => return None,
    })
}
