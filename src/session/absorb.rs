//! Events from the worker.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::action::{Action, Level, Message};
use super::messages;
use super::timeline::Timeline;
use super::verb::Verb;
use super::{Effect, Session, merge_wording};
use crate::geometry::SampledPart;
use crate::inference::Phase;
use crate::worker::{Activity, Cause, Command, Event, Helper, LoadedShape, Measurement, Snapshot};

/// Measurements that are kept.
const MEASURED: usize = 512;

impl Session {
    /// Handles an event from the worker.
    pub fn absorb(&mut self, event: Event) -> Vec<Effect> {
        match event {
            Event::Loaded(shape) => self.absorb_shape(shape),
            Event::Snapshot(snapshot) => self.absorb_snapshot(snapshot),
            Event::Activity(activity) => {
                self.activity = activity;
                if activity == Activity::Idle {
                    // Whatever was on its way has arrived, failed or was cancelled.
                    let has_arrived = std::mem::take(&mut self.has_arrived);
                    // What was opened may be a result.
                    let is_result = has_arrived && self.phase() == Some(Phase::Finished);
                    let runs = has_arrived && self.run_when_loaded && !is_result;
                    self.run_when_loaded = false;
                    self.live.finish();
                    let renewal = self.renew_if_due();
                    if runs && renewal.is_empty() {
                        return self.work(Command::Run, Activity::Running);
                    }
                    if is_result && renewal.is_empty() {
                        return self.measure_shown();
                    }
                    return renewal;
                }
            }
            Event::LiveStarted(setup) => self.live.begin(setup),
            Event::LiveFinished(renewed) => self.absorb_renewed(&renewed),
            Event::MergeStep(Some(report)) => {
                let (a, b) = report.merged;
                let gone = if a == report.into { b } else { a };
                let text = format!(
                    "Merged {gone} into {}. {}",
                    report.into,
                    merge_wording::sentence(&report.reason)
                );
                self.messages.push(Level::Detail, text.clone(), "");
                self.merge_text = Some(text);
            }
            Event::MergeStep(None) => {
                self.merges_are_exhausted = true;
                self.dismiss_answered();
                self.merge_text = Some("No more pairs to merge.".to_owned());
            }
            Event::Measuring(snapshot) => self.measuring = Some(snapshot),
            Event::Measured(measurement) => {
                self.measuring.take_if(|s| Arc::ptr_eq(s, &measurement.snapshot));
                self.keep_measurement(measurement);
            }
            Event::Estimated { key, chamfer_l1 } => self.estimates.take(key, chamfer_l1),
            Event::Seeds { request, news } => self.absorb_seeds(request, news),
            Event::Proposed(proposal) => self.absorb_proposal(proposal),
            Event::Written { path, format, notes } => {
                // What could not be written before can be now.
                self.messages.dismiss_errors();
                self.tell_written(format, path, &notes);
            }
            Event::Failed { what, error } => {
                self.is_judging = false;
                self.settle_draft();
                self.fail(what, &error);
            }
            Event::Ended { who, error } => return self.absorb_end(who, &error),
        }
        Vec::new()
    }

    /// Handles a worker thread that has died and been replaced. A new sampler
    /// thread gets the settings; it gets the shown state with the next request
    /// that continues from it.
    fn absorb_end(&mut self, who: Helper, error: &str) -> Vec<Effect> {
        let (what, advice) = match who {
            Helper::Sampler => (
                "The computation thread stopped after an internal error",
                "It has been restarted. All states and settings are kept; only the step in progress was \
                 lost. Press Run to continue from the shown state. If this happens again, save the session \
                 and report the problem with the details, the shape and the parameters",
            ),
            Helper::Measurer => (
                "The measuring thread stopped after an internal error",
                "It has been restarted. Only the measurement in progress was lost. Please report the \
                 problem with the details and the shape",
            ),
            Helper::Seeds => (
                "The thread for seed runs stopped after an internal error",
                "It has been restarted. Finished runs are kept; start the others again. Please report the \
                 problem with the details and the shape",
            ),
        };
        if matches!(who, Helper::Sampler | Helper::Measurer) {
            self.measuring = None;
            self.estimates.ask_again();
        }
        if matches!(who, Helper::Sampler | Helper::Seeds) {
            self.seeds.end();
        }
        let message = Message::error(what, error).advise(advice);
        if who != Helper::Sampler {
            self.messages.add(message);
            return Vec::new();
        }
        self.messages.add(message.offer("Run again", Action::Verb(Verb::Run)));
        self.activity = Activity::Idle;
        self.worker_at = None;
        self.run_when_loaded = false;
        self.has_arrived = false;
        self.is_judging = false;
        self.live.forget();
        self.settle_draft();
        vec![Effect::Send(Command::SetParams(self.params)), Effect::Send(Command::SetPace(self.pace))]
    }

    /// Stores a measurement, if its state is still relevant.
    pub(super) fn keep_measurement(&mut self, measurement: Arc<Measurement>) {
        let key = measurement.snapshot.key;
        if self.timeline.branches().iter().flat_map(|b| &b.states).any(|s| s.key == key) {
            self.measured.retain(|m| m.snapshot.key != key);
            if self.measured.len() == MEASURED {
                self.measured.remove(0);
            }
            self.measured.push(measurement);
        }
    }

    fn absorb_shape(&mut self, shape: Arc<LoadedShape>) {
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
        if let (Some(path), false) = (&shape.shape.path, is_same) {
            self.window.recent.add(path);
        }
        // What went wrong before doesn't concern the new shape.
        self.messages.dismiss_errors();
        self.loaded = Some(shape);
        self.snapshot = None;
        self.measuring = None;
        self.merge_text = None;
        self.drop_proposal();
        self.selection.clear();
        self.selected_points = Arc::default();
        self.explained = None;
        self.hidden.clear();
        if !is_same {
            self.timeline = Timeline::default();
            self.measured.clear();
            self.estimates.forget();
            self.seeds.clear();
        }
        self.worker_at = None;
        self.refit_scene();
        if !is_same {
            self.camera.frame(&self.scene.bounds);
        }
        // What comes of it begins when the worker is done with loading.
        self.has_arrived = true;
    }

    fn absorb_snapshot(&mut self, snapshot: Arc<Snapshot>) {
        let Some(loaded) = self.loaded.clone() else { return };
        let follows = self.timeline.follows();
        self.worker_at = Some(snapshot.key);
        if snapshot.cause == Cause::Start {
            self.drop_proposal();
            self.merge_text = None;
            // A run that starts leaves behind what stopped the last one.
            self.messages.dismiss_errors();
            self.timeline.start(&loaded, Arc::clone(&snapshot), Arc::default());
        } else {
            self.timeline.push(Arc::clone(&snapshot));
        }
        self.tell_deleted(&snapshot.occurrences);
        self.follow_selection(&snapshot.occurrences);
        if let Some(what) = messages::of_step(&snapshot) {
            let name = self.timeline.newest_name().place();
            self.messages.push(Level::Detail, format!("{name}: {what}"), "");
            self.tell_edits(&snapshot.occurrences);
            self.dismiss_answered();
        }
        if follows || snapshot.cause == Cause::Start {
            self.show_state(snapshot);
        }
    }

    /// Makes a state the current one.
    pub(super) fn show_state(&mut self, snapshot: Arc<Snapshot>) {
        self.merges_are_exhausted = false;
        self.snapshot = Some(snapshot);
        let present: BTreeSet<u32> = self.primitives().iter().map(|p| p.id).collect();
        self.selection.retain(|id| present.contains(id));
        self.hidden.retain(|id| present.contains(id));
        self.settle_draft();
    }

    /// The requested work has succeeded: earlier errors are no longer relevant.
    fn dismiss_answered(&mut self) {
        if let Some(number) = self.answered.take() {
            self.messages.dismiss_errors_until(number);
        }
    }
}
