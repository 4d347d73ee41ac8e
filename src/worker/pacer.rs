//! When the next step is due. Knows no clock: whoever asks says what time it
//! is.

use std::time::{Duration, Instant};

use super::protocol::Pace;

/// Holds the steps of a run apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pacer {
    pace: Pace,
    due: Instant,
}

impl Pacer {
    /// The first step is due at once.
    pub(super) fn new(now: Instant) -> Self {
        Self { pace: Pace::default(), due: now }
    }

    /// Takes another pace. What was due stays due; a step that waits never
    /// waits longer than the new pace asks for.
    pub(super) fn set(&mut self, pace: Pace, now: Instant) {
        self.pace = pace;
        self.due = self.due.min(now + pace.interval());
    }

    /// Makes the next step due at `when`.
    pub(super) fn make_due(&mut self, when: Instant) {
        self.due = when;
    }

    /// A step was made that began at `begun`; the time that it took counts.
    pub(super) fn stepped(&mut self, begun: Instant) {
        self.due = begun + self.pace.interval();
    }

    /// How long the next step has to wait.
    pub(super) fn wait(&self, now: Instant) -> Duration {
        self.due.saturating_duration_since(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    #[test]
    fn steps_keep_the_pace_whatever_they_take() {
        let start = Instant::now();
        let mut pacer = Pacer::new(start);
        pacer.set(Pace::PerSecond(4), start);
        assert!(pacer.wait(start).is_zero(), "the first step is due at once");
        let mut now = start;
        let mut begun = Vec::new();
        for took in [SECOND / 100, SECOND / 5, SECOND, SECOND / 100] {
            now += pacer.wait(now);
            begun.push(now);
            pacer.stepped(now);
            now += took;
        }
        let apart: Vec<Duration> = begun.windows(2).map(|w| w[1] - w[0]).collect();
        assert_eq!(apart, [SECOND / 4, SECOND / 4, SECOND], "a slow step is not made up for");
    }

    #[test]
    fn another_pace_is_taken_while_a_step_waits() {
        let start = Instant::now();
        let mut pacer = Pacer::new(start);
        pacer.set(Pace::PerSecond(1), start);
        pacer.stepped(start);
        let now = start + SECOND / 10;
        pacer.set(Pace::PerSecond(10), now);
        assert_eq!(pacer.wait(now), SECOND / 10);
        // A slower one never holds back what is due already.
        pacer.set(Pace::PerSecond(1), now);
        assert_eq!(pacer.wait(now), SECOND / 10);
        pacer.set(Pace::Unlimited, now);
        assert!(pacer.wait(now).is_zero());
        pacer.stepped(now);
        assert!(pacer.wait(now).is_zero(), "nothing is waited for");
    }
}
