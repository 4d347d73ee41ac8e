//! Random clicks, drags, keys and sizes: whatever is done in whatever order,
//! the window never panics, never contradicts itself, and never gets stuck.
//!
//! `SUPERFORM_MONKEY_STEPS` makes it longer than a test run should be,
//! `SUPERFORM_MONKEY_SEED` another walk; both are told when it fails.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod driver;

use std::time::Duration;

use driver::{Driver, file, options};
use egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, Vec2, vec2,
};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use superform::inference::Phase;
use superform::session::verb::{Key as Printed, Verb};
use superform::worker::{Activity, Source};

const STEPS: u64 = 500;

/// Until it is checked that nothing is stuck.
const STEPS_BETWEEN_RESTS: u64 = 100;

struct Monkey {
    driver: Driver,
    rng: ChaCha8Rng,
    size: Vec2,
    done: Vec<String>,
}

impl Monkey {
    fn place(&mut self) -> Pos2 {
        Pos2::new(self.rng.random_range(0.0..self.size.x), self.rng.random_range(0.0..self.size.y))
    }

    fn note(&mut self, what: String) {
        if self.done.len() == 12 {
            self.done.remove(0);
        }
        self.done.push(what);
    }

    fn modifiers(&mut self) -> Modifiers {
        *[
            Modifiers::NONE,
            Modifiers::NONE,
            Modifiers::NONE,
            Modifiers::SHIFT,
            Modifiers::COMMAND,
            Modifiers::ALT,
        ]
        .choose(&mut self.rng)
        .unwrap()
    }

    fn press(&mut self, from: Pos2, to: Pos2, button: PointerButton, steps: usize) {
        let modifiers = self.modifiers();
        let harness = &mut self.driver.harness;
        harness.event(Event::PointerMoved(from));
        harness.step();
        harness
            .event_modifiers(Event::PointerButton { pos: from, button, pressed: true, modifiers }, modifiers);
        for i in 1..=steps {
            harness.event_modifiers(Event::PointerMoved(from.lerp(to, i as f32 / steps as f32)), modifiers);
            harness.step();
        }
        harness
            .event_modifiers(Event::PointerButton { pos: to, button, pressed: false, modifiers }, modifiers);
        harness.step();
    }

    fn step(&mut self) {
        match self.rng.random_range(0..100) {
            0..35 => {
                let at = self.place();
                self.note(format!("click at {at:?}"));
                self.press(at, at, PointerButton::Primary, 0);
            }
            35..40 => {
                let at = self.place();
                self.note(format!("right click at {at:?}"));
                self.press(at, at, PointerButton::Secondary, 0);
            }
            40..60 => {
                let (from, to) = (self.place(), self.place());
                let button = *[
                    PointerButton::Primary,
                    PointerButton::Primary,
                    PointerButton::Secondary,
                    PointerButton::Middle,
                ]
                .choose(&mut self.rng)
                .unwrap();
                self.note(format!("{button:?} drag from {from:?} to {to:?}"));
                self.press(from, to, button, 4);
            }
            60..85 => {
                let verb = *Verb::ALL.choose(&mut self.rng).unwrap();
                let Some(shortcut) = verb.entry().shortcut.filter(|_| verb != Verb::Quit) else { return };
                let Some(key) = key(shortcut.key) else { return };
                self.note(format!("{shortcut} ({verb:?})"));
                let mut modifiers = Modifiers::NONE;
                modifiers.shift = shortcut.shift;
                modifiers.alt = shortcut.alt;
                modifiers.command = shortcut.ctrl;
                modifiers.ctrl = shortcut.ctrl;
                self.driver.harness.key_press_modifiers(modifiers, key);
                self.driver.harness.step();
            }
            85..90 => {
                let key = *[Key::Tab, Key::Enter, Key::Escape, Key::ArrowDown, Key::ArrowRight, Key::Space]
                    .choose(&mut self.rng)
                    .unwrap();
                self.note(format!("{key:?}"));
                self.driver.harness.key_press(key);
                self.driver.harness.step();
            }
            90..95 => {
                let at = self.place();
                let delta = vec2(0.0, self.rng.random_range(-3.0..3.0));
                self.note(format!("wheel by {} at {at:?}", delta.y));
                self.driver.harness.event(Event::PointerMoved(at));
                self.driver.harness.event(Event::MouseWheel {
                    source: MouseWheelSource::Wheel,
                    unit: MouseWheelUnit::Line,
                    delta,
                    phase: TouchPhase::Move,
                    modifiers: Modifiers::NONE,
                });
                self.driver.harness.step();
            }
            95..97 => {
                self.size = vec2(self.rng.random_range(700.0..1700.0), self.rng.random_range(450.0..1000.0));
                let size = self.size;
                self.note(format!("size {size:?}"));
                self.driver.harness.set_size(size);
                self.driver.harness.step();
            }
            _ => self.listen(Duration::from_millis(20)),
        }
        self.listen(Duration::ZERO);
        self.check();
    }

    /// Takes in what the worker has told.
    fn listen(&mut self, patience: Duration) {
        let ctx = self.driver.harness.ctx.clone();
        while self.driver.harness.state_mut().wait(&ctx, patience) {}
        self.driver.harness.step();
    }

    /// What holds at any moment.
    fn check(&self) {
        let session = self.driver.session();
        assert_eq!(session.snapshot.as_ref().map(|s| s.key), session.timeline.shown().map(|s| s.key));
        let present: Vec<u32> = session.primitives().iter().map(|p| p.id).collect();
        assert!(session.selection.iter().all(|id| present.contains(id)), "a ghost is selected");
        assert!(session.hidden.iter().all(|id| present.contains(id)), "a ghost is hidden");
        if let (Some(loaded), Some(snapshot)) = (&session.loaded, &session.snapshot) {
            let samples = loaded.cloud.points.len();
            assert_eq!(snapshot.abstraction.labels.len(), samples, "the labels are of another cloud");
            assert!(session.selected_points.iter().all(|&i| (i as usize) < samples));
        }
        assert!(session.params.check().is_ok(), "{:?}", session.params.check());
        let mistake = session.messages.iter().find(|m| m.what.contains("internal error"));
        assert!(mistake.is_none(), "{mistake:?}");
    }

    /// Whatever was begun comes to rest, and work can be asked for again.
    fn rest(&mut self) {
        self.note("rest".to_owned());
        self.driver.settle();
        self.check();
    }
}

fn key(printed: Printed) -> Option<Key> {
    Some(match printed {
        Printed::Home => Key::Home,
        Printed::Space => Key::Space,
        Printed::Escape => Key::Escape,
        Printed::Backspace => Key::Backspace,
        Printed::Delete => Key::Delete,
        Printed::Enter => Key::Enter,
        Printed::Left => Key::ArrowLeft,
        Printed::Right => Key::ArrowRight,
        Printed::Char(letter) => Key::from_name(&letter.to_string())?,
        Printed::Function(number) => Key::from_name(&format!("F{number}"))?,
        #[allow(unreachable_patterns, reason = "keys that are added need not be pressed by their name")]
        _ => return None,
    })
}

/// Says how to walk the same way again.
struct Walk<'a>(&'a [String], u64);

impl Drop for Walk<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("SUPERFORM_MONKEY_SEED={}; the last steps:\n  {}", self.1, self.0.join("\n  "));
        }
    }
}

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

#[test]
fn nothing_that_is_done_at_random_breaks_the_window() {
    let seed = number("SUPERFORM_MONKEY_SEED").unwrap_or(1);
    let steps = number("SUPERFORM_MONKEY_STEPS").unwrap_or(STEPS);
    // What the monkey saves it saves here.
    let folder = tempfile::tempdir().unwrap();
    let shape = file(&folder, "square.xyz", &square());
    std::env::set_current_dir(folder.path()).unwrap();
    let driver = Driver::start(options(Source::File(shape)), [1280.0, 800.0]);
    let mut monkey =
        Monkey { driver, rng: ChaCha8Rng::seed_from_u64(seed), size: vec2(1280.0, 800.0), done: Vec::new() };
    for step in 0..steps {
        let failed = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            monkey.step();
            if step % STEPS_BETWEEN_RESTS == STEPS_BETWEEN_RESTS - 1 {
                monkey.rest();
            }
        }));
        if let Err(panic) = failed {
            let _said = Walk(&monkey.done, seed);
            std::panic::resume_unwind(panic);
        }
    }
    monkey.rest();
    // And it still does its work.
    monkey.driver.harness.set_size(vec2(1280.0, 800.0));
    for _ in 0..6 {
        monkey.driver.key(Modifiers::NONE, Key::Escape);
    }
    monkey.driver.key(Modifiers::COMMAND, Key::O);
    monkey.driver.type_path("square.xyz");
    monkey.driver.press("Open");
    monkey.driver.settle();
    // The walk may have switched Live off: then a shape waits for Run.
    if !monkey.driver.session().live.is_on {
        monkey.driver.press("Run");
    }
    monkey.driver.until(|s| s.phase() == Some(Phase::Finished) && s.activity == Activity::Idle);
    assert_eq!(monkey.driver.session().phase(), Some(Phase::Finished));
}

/// Points on the rim of a square plate and a ball above it.
fn square() -> String {
    let mut text = String::new();
    for i in 0..300 {
        let (a, z) = (f64::from(i) * 0.618 * std::f64::consts::TAU, f64::from(i) / 150.0 - 1.0);
        let r = (1.0 - z * z).max(0.0).sqrt();
        text.push_str(&format!("{} {} {}\n", r * a.cos(), r * a.sin(), z + 3.0));
        text.push_str(&format!("{} {} 0\n", f64::from(i % 20) / 5.0 - 2.0, f64::from(i / 20) / 4.0 - 2.0));
    }
    text
}
