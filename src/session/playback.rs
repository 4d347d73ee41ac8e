//! Playback of the timeline, driven by the owner's clock.

/// State of playback.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playback {
    pub is_playing: bool,
    /// Loop after the last state.
    pub loops: bool,
    /// States per second.
    speed: u32,
    /// Fractional number of states due.
    pub(super) due: f64,
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
    pub(super) fn advance(&mut self, seconds: f64) -> usize {
        // Whoever was away for long need not see all that was missed.
        self.due += seconds.clamp(0.0, 1.0) * f64::from(self.speed);
        let whole = self.due.floor();
        self.due -= whole;
        whole as usize
    }
}
