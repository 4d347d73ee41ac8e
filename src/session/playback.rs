//! Playback of the timeline, driven by the owner's clock.

use super::{Effect, Session};

/// State of playback.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playback {
    pub is_playing: bool,
    /// Loop after the last state.
    pub loops: bool,
    /// States per second.
    speed: u32,
    /// Fractional number of states due.
    due: f64,
}

impl Default for Playback {
    fn default() -> Self {
        Self { is_playing: false, loops: false, speed: 10, due: 0.0 }
    }
}

impl Playback {
    /// Available speeds, in states per second.
    pub const SPEEDS: [u32; 6] = [2, 5, 10, 20, 50, 100];

    pub fn speed(&self) -> u32 {
        self.speed
    }

    pub(super) fn set_speed(&mut self, speed: u32) {
        self.speed = speed.clamp(1, 1000);
    }

    /// Number of whole states due after this many seconds.
    fn advance(&mut self, seconds: f64) -> usize {
        // Whoever was away for long need not see all that was missed.
        self.due += seconds.clamp(0.0, 1.0) * f64::from(self.speed);
        let whole = self.due.floor();
        self.due -= whole;
        whole as usize
    }
}

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
