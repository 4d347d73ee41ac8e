//! Running other seeds, and opening one of the runs.

use std::sync::Arc;

use super::action::Level;
use super::seeds::{SEEDS, SeedResult};
use super::{Effect, Session};
use crate::inference::{Cancel, Params};
use crate::worker::{Command, SeedNews, SeedRequest, SeedRun};

impl Session {
    /// Asks for runs with the seeds from the present one on.
    pub(super) fn run_seeds(&mut self) -> Vec<Effect> {
        let Some(state) = self.shown_state() else { return Vec::new() };
        self.view.shows_seeds = true;
        self.seeds.clear();
        self.seeds.count += 1;
        let request = SeedRequest {
            number: self.seeds.count,
            colors: self.timeline.current().map(|b| Arc::clone(&b.colors)).unwrap_or_default(),
            state,
            params: self.params,
            count: SEEDS,
            cancel: Cancel::default(),
        };
        self.seeds.request = Some(request.clone());
        self.seeds.is_running = true;
        vec![Effect::Send(Command::RunSeeds(Box::new(request)))]
    }

    pub(super) fn stop_seeds(&mut self) {
        self.seeds.stop();
    }

    pub(super) fn absorb_seeds(&mut self, request: u64, news: SeedNews) {
        let seeds = &mut self.seeds;
        if seeds.request.as_ref().is_none_or(|r| r.number != request) {
            return;
        }
        match news {
            SeedNews::Progress { seed, share } => seeds.progress = Some((seed, share)),
            SeedNews::Finished(run) => {
                seeds.progress = None;
                seeds.results.push(SeedResult { run, measurement: None });
            }
            SeedNews::Measured { seed, measurement } => {
                if let Some(result) = seeds.results.iter_mut().find(|r| r.run.seed == seed) {
                    result.measurement = Some(Arc::clone(&measurement));
                }
                self.keep_measurement(measurement);
            }
            SeedNews::Failed { what, error } => self.messages.push(Level::Error, what, error),
            SeedNews::Over => seeds.end(),
        }
    }

    /// Opens a run with another seed as a branch, at its last state. Its seed
    /// becomes the current one, so that the next start repeats it.
    pub(super) fn take_seed(&mut self, seed: u64) -> Vec<Effect> {
        let Some(result) = self.seeds.results.iter().find(|r| r.run.seed == seed).cloned() else {
            return Vec::new();
        };
        let Some(last) = result.last() else { return Vec::new() };
        // Taken before: it is there already.
        let taken = self.timeline.branches().iter().find(|b| b.states.iter().any(|s| s.key == last.key));
        if let Some(branch) = taken.map(|b| b.id) {
            self.timeline.switch(branch);
        } else {
            let SeedRun { loaded, states, colors, .. } = &*result.run;
            let name = format!("Seed {seed}");
            self.timeline.add_beside(name, Arc::clone(loaded), states.clone(), Arc::clone(colors));
        }
        self.params = Params { seed, ..last.params };
        let effects = self.show_timeline();
        if let Some(measurement) = result.measurement {
            self.keep_measurement(measurement);
        }
        effects
    }
}
