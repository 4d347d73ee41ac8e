//! Playing the timeline.

use super::{Effect, Session};

impl Session {
    /// Plays from the shown state, or from the start if it is the last.
    pub(super) fn play(&mut self) {
        if self.timeline.is_at_end() {
            self.show_state_at(0);
        }
        self.playback.is_playing = true;
        self.playback.due = 0.0;
    }

    /// Stops at the shown state and requests its measurement.
    pub(super) fn stop_playing(&mut self) -> Vec<Effect> {
        self.playback.is_playing = false;
        self.measure_shown()
    }

    /// Advances by this many seconds; stops or loops at the end.
    pub(super) fn play_on(&mut self, seconds: f64) -> Vec<Effect> {
        let states = self.timeline.states().len();
        if !self.playback.is_playing || states < 2 {
            return Vec::new();
        }
        let due = self.playback.advance(seconds);
        if due == 0 {
            return Vec::new();
        }
        let wanted = self.timeline.shown_index() + due;
        let index = match (wanted < states, self.playback.loops) {
            (true, _) => wanted,
            (false, false) => states - 1,
            // The last is shown before it goes round.
            (false, true) if !self.timeline.is_at_end() => states - 1,
            (false, true) => (due - 1) % states,
        };
        let effects = self.show_state_at(index);
        self.playback.is_playing = self.playback.loops || !self.timeline.is_at_end();
        // What is passed by need not be measured.
        if self.playback.is_playing { Vec::new() } else { effects }
    }
}
