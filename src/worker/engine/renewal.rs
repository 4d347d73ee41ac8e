//! Making the whole run anew, out of sight, while its parameters are turned.
//!
//! While a slider is dragged, setups come faster than runs end. If each
//! cancelled the run of the one before, none would ever end and the picture
//! would stand still until the hand does. So the run under way is let finish
//! and shown, although the hand has moved on; the next is made with the newest
//! setup, and those between are never begun. That gives as many results as the
//! machine can make, each at most two runs old. Only when the hand rests, which
//! the owner tells by a renewal `at_once`, is a run for an older setup cancelled:
//! then nothing stands between the person and what was asked for last.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::super::machine::Steppable;
use super::super::protocol::{Event, Setup};
use super::super::trouble::{Stop, guarded};
use super::live_run::{Finished, LiveRun};
use super::{Engine, Goal};

/// How long another setup is waited for before the worker is said to be idle
/// and the result measured: longer than from one to the next of a drag.
const LINGER: Duration = Duration::from_millis(200);
/// A run that takes longer is told as running, so that it can be paused.
const SLOW: Duration = Duration::from_millis(600);

impl<M: Steppable> Engine<M> {
    /// Takes the setup for the renewal to come.
    pub(super) fn renew(&mut self, setup: Setup, at_once: bool) {
        // Where the flag is raised, the order that raised it decides how it goes on.
        if !self.set_params(setup.params) || self.cancel.is_requested() || self.present.is_none() {
            return;
        }
        match &self.renewal {
            Some(under_way) if !at_once => {
                // The hand may have come back to where it was.
                self.next_setup = (under_way.setup != setup).then_some(setup);
            }
            _ => self.begin_renewal(setup, at_once),
        }
    }

    fn begin_renewal(&mut self, setup: Setup, is_last: bool) {
        let Some(present) = &self.present else { return };
        if !matches!(self.work, Goal::Renew | Goal::Linger) {
            self.renews_slowly = false;
        }
        self.renewal = Some(LiveRun::new(setup, is_last, present));
        self.next_setup = None;
        self.emit(Event::LiveStarted(setup));
        if self.work != Goal::Renew {
            self.begin(Goal::Renew);
            self.announce();
        }
    }

    pub(super) fn drop_renewal(&mut self) {
        self.renewal = None;
        self.next_setup = None;
    }

    pub(super) fn advance_renewal(&mut self) {
        let cancel = self.cancel.clone();
        let Some(renewal) = &mut self.renewal else {
            self.work = Goal::Nothing;
            self.announce();
            return;
        };
        match guarded(|| renewal.advance(&cancel)) {
            Ok(false) => {
                if !self.renews_slowly && renewal.begun.elapsed() > SLOW {
                    self.renews_slowly = true;
                    self.announce();
                }
            }
            Ok(true) => self.take_renewed(),
            // The order that cancelled the step decides how it goes on.
            Err(Stop::Cancelled) => {}
            Err(stop) => {
                self.drop_renewal();
                self.work = Goal::Nothing;
                self.report(stop);
                self.announce();
            }
        }
    }

    /// Makes the finished renewal the present run, and goes on to the next.
    fn take_renewed(&mut self) {
        let Some(renewal) = self.renewal.take() else { return };
        let is_last = renewal.is_last;
        self.renews_slowly &= renewal.begun.elapsed() > SLOW;
        let Some(Finished { present, renewed }) = renewal.finish() else { return };
        self.generation = present.shape.generation;
        self.present = Some(present);
        self.emit(Event::LiveFinished(Arc::new(renewed)));
        if let Some(setup) = self.next_setup.take() {
            self.begin_renewal(setup, false);
        } else if is_last || !self.held.is_empty() {
            self.work = Goal::Nothing;
            self.announce();
        } else {
            self.work = Goal::Linger;
            self.pacer.make_due(Instant::now() + LINGER);
        }
    }
}
