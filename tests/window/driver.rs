//! Drives the real application through its accessibility labels.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use superform::app::{App, Options};
use superform::inference::{Params, Phase};
use superform::session::Session;
use superform::worker::{Activity, SamplingOptions, Source};

pub(crate) use egui::accesskit::Role;

/// Longer than anything here takes, also on a machine that is busy with other
/// things; reached only by a failing test.
pub(crate) const PATIENCE: Duration = Duration::from_secs(300);
/// More events than any test waits for.
const MOST_EVENTS: usize = 2000;

/// A short run on few points.
pub(crate) fn options(source: Source) -> Options {
    Options {
        source,
        sampling: SamplingOptions { points: 700, seed: 1, ..SamplingOptions::default() },
        params: Params { iterations: 6, clusters: 12, ..Params::default() },
        screenshot: None,
        state_folder: None,
        reset_layout: false,
    }
}

pub(crate) struct Driver {
    pub(crate) harness: Harness<'static, App>,
}

impl Driver {
    /// The window with a shape that is being run, not yet settled.
    pub(crate) fn start(options: Options, size: [f32; 2]) -> Self {
        let build =
            move |cc: &mut eframe::CreationContext<'_>| App::with_dialogs(cc, &options, false).unwrap();
        let harness = Harness::builder().with_size(size).with_max_steps(20).build_eframe(build);
        Self { harness }
    }

    /// As [`Driver::start`], with a driver that draws the 3D view.
    pub(crate) fn start_drawn(options: Options, size: [f32; 2]) -> Self {
        let build =
            move |cc: &mut eframe::CreationContext<'_>| App::with_dialogs(cc, &options, false).unwrap();
        let builder = Harness::builder().with_size(size).with_max_steps(20).with_render_cursor(false);
        Self { harness: builder.wgpu().build_eframe(build) }
    }

    /// Where the 3D view is.
    pub(crate) fn viewport(&self) -> egui::Rect {
        self.harness.get_by_role_and_label(Role::Image, "3D view").rect()
    }

    /// Chooses the light theme from the menu.
    pub(crate) fn set_light(&mut self) {
        self.press("Window");
        self.harness.get_by_role_and_label(Role::Button, "Theme").hover();
        self.harness.run_steps(3);
        self.press("Light theme");
        self.harness.run_steps(2);
    }

    /// The window after the run of the built-in shape.
    pub(crate) fn finished() -> Self {
        let mut driver = Self::start(options(Source::BuiltIn), [1280.0, 800.0]);
        driver.settle();
        assert_eq!(driver.session().phase(), Some(Phase::Finished));
        driver
    }

    pub(crate) fn session(&self) -> &Session {
        self.harness.state().session()
    }

    /// Takes in one event of the worker and draws.
    pub(crate) fn wait(&mut self) {
        let ctx = self.harness.ctx.clone();
        let came = self.harness.state_mut().wait(&ctx, PATIENCE);
        assert!(came, "the worker has fallen silent; {}", self.state());
        self.harness.step();
    }

    /// Takes in events until the worker is idle, then draws what has become.
    pub(crate) fn settle(&mut self) {
        self.harness.run_steps(2);
        self.until(|session| session.activity == Activity::Idle);
    }

    /// Takes in events until the session is as wished.
    pub(crate) fn until(&mut self, wish: impl Fn(&Session) -> bool) {
        for _ in 0..MOST_EVENTS {
            if wish(self.session()) {
                self.harness.run_steps(2);
                return;
            }
            self.wait();
        }
        panic!("it did not come true in {MOST_EVENTS} events; {}", self.state());
    }

    /// Draws frames until it is as wished, which work in the background leads to.
    pub(crate) fn draw_until(&mut self, what: &str, mut wish: impl FnMut(&mut Self) -> bool) {
        let begun = Instant::now();
        while !wish(self) {
            assert!(begun.elapsed() < PATIENCE, "{what} did not come; {}", self.state());
            // Somebody else may have to do it.
            std::thread::yield_now();
            self.harness.step();
        }
    }

    /// Draws frames until some widget's label contains the text.
    pub(crate) fn until_shown(&mut self, text: &str) {
        self.draw_until(text, |driver| driver.shows(text));
    }

    /// Where the session stands, for messages of failing tests.
    fn state(&self) -> String {
        let session = self.session();
        let shown = session.snapshot.as_ref().map(|s| (s.run, s.abstraction.phase, s.abstraction.iteration));
        let said = session.messages.iter().last().map(|m| &m.what);
        format!("{:?}, shown (run, phase, iteration): {shown:?}, last said: {said:?}", session.activity)
    }

    /// Draws frames until there is such a widget: what was done last may bring it
    /// a frame or two later.
    fn until_there(&mut self, role: Role, label: &str) {
        self.draw_until(label, |driver| driver.harness.query_by_role_and_label(role, label).is_some());
    }

    /// Scrolls to a widget, and draws frames until it stays where it is: what is
    /// out of sight is behind something else, where a click would end up. Not in
    /// the middle of a run, where nothing stays.
    pub(crate) fn bring_into_view(&mut self, role: Role, label: &str) {
        self.harness.get_by_role_and_label(role, label).scroll_to_me();
        // It begins in the frame after that which hears of it.
        self.harness.run_steps(2);
        let mut before = None;
        self.draw_until(label, |driver| {
            let rect = driver.harness.get_by_role_and_label(role, label).rect();
            before.replace(rect) == Some(rect)
        });
    }

    pub(crate) fn press(&mut self, button: &str) {
        self.until_there(Role::Button, button);
        self.harness.get_by_role_and_label(Role::Button, button).click();
        self.harness.run_steps(2);
    }

    pub(crate) fn has_button(&self, button: &str) -> bool {
        self.harness.query_by_role_and_label(Role::Button, button).is_some()
    }

    pub(crate) fn is_enabled(&self, button: &str) -> bool {
        !self.harness.get_by_role_and_label(Role::Button, button).accesskit_node().is_disabled()
    }

    pub(crate) fn toggle(&mut self, checkbox: &str) {
        self.until_there(Role::CheckBox, checkbox);
        self.harness.get_by_role_and_label(Role::CheckBox, checkbox).click();
        self.harness.run_steps(2);
    }

    /// Chooses one of a combo box's entries.
    pub(crate) fn choose(&mut self, combo: &str, entry: &str) {
        self.until_there(Role::ComboBox, combo);
        self.harness.get_by_role_and_label(Role::ComboBox, combo).click();
        self.harness.run_steps(3);
        self.press(entry);
    }

    pub(crate) fn is_slider_enabled(&self, slider: &str) -> bool {
        !self.harness.get_by_role_and_label(Role::Slider, slider).accesskit_node().is_disabled()
    }

    /// Moves a slider.
    pub(crate) fn slide(&mut self, slider: &str, value: f64) {
        self.until_there(Role::Slider, slider);
        self.harness.get_by_role_and_label(Role::Slider, slider).set_value_accesskit(value);
        self.harness.run_steps(2);
    }

    pub(crate) fn key(&mut self, modifiers: egui::Modifiers, key: egui::Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(2);
    }

    /// Writes the shown state through the export dialog.
    pub(crate) fn export(&mut self, format: &str, path: &std::path::Path) {
        self.key(egui::Modifiers::COMMAND, egui::Key::E);
        // The list is longer than the dialog.
        self.harness.get_by_role_and_label(Role::Button, format).scroll_to_me();
        self.harness.run_steps(8);
        self.press(format);
        let field = self.harness.get_by_role_and_label(Role::TextInput, "File");
        field.set_text_value_accesskit(path.to_str().unwrap());
        self.harness.run_steps(2);
        if self.is_enabled("Export") {
            self.press("Export");
            self.settle();
        }
    }

    /// Answers the question for a path.
    pub(crate) fn type_path(&mut self, path: &str) {
        self.harness.run_steps(2);
        let field = self.harness.get_by_role_and_label(Role::TextInput, "File path");
        field.set_text_value_accesskit(path);
        self.harness.run_steps(2);
    }

    /// Clicks a button while modifiers are held.
    pub(crate) fn click_with(&mut self, button: &str, modifiers: egui::Modifiers) {
        self.until_there(Role::Button, button);
        self.harness.get_by_role_and_label(Role::Button, button).click_modifiers(modifiers);
        self.harness.run_steps(2);
    }

    /// Drags with the left button, with some stops on the way.
    pub(crate) fn drag(&mut self, from: egui::Pos2, to: egui::Pos2) {
        self.harness.hover_at(from);
        self.harness.run_steps(1);
        self.harness.drag_at(from);
        self.harness.run_steps(1);
        for i in 1..=6 {
            self.harness.hover_at(from + (to - from) * (i as f32 / 6.0));
            self.harness.run_steps(1);
        }
        self.harness.drop_at(to);
        self.harness.run_steps(2);
    }

    /// Shows or hides a layer by its entry in the viewport's menu.
    pub(crate) fn toggle_layer(&mut self, layer: &str) {
        if self.harness.query_by_role_and_label(Role::CheckBox, layer).is_none() {
            self.press("Show");
        }
        self.toggle(layer);
    }

    pub(crate) fn shows(&self, text: &str) -> bool {
        self.harness.query_all_by_label_contains(text).next().is_some()
    }

    pub(crate) fn iteration(&self) -> u32 {
        self.session().snapshot.as_ref().unwrap().abstraction.iteration
    }
}

/// A file in a temporary folder that lives as long as the folder.
pub(crate) fn file(folder: &tempfile::TempDir, name: &str, content: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    path
}
