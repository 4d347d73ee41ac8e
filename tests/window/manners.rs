//! The manners of the window: notes, errors, the log, all commands, help,
//! panels, what is remembered.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::driver::{Driver, Role, file, options};
use eframe::App as _;
use egui::{Key, Modifiers, OutputCommand};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use superform::app::{App, Options};
use superform::cli::Journal;
use superform::session::Verb;
use superform::session::action::Level;
use superform::session::view::{SurfaceStyle, ThemeChoice};
use superform::session::window::Panel;
use superform::worker::{Pace, Source};
use tracing_subscriber::layer::SubscriberExt as _;

const SIZE: [f32; 2] = [1280.0, 800.0];

/// A store that lives in memory.
#[derive(Debug, Default, Clone)]
struct Store(BTreeMap<String, String>);

impl eframe::Storage for Store {
    fn get_string(&self, key: &str) -> Option<String> {
        self.0.get(key).cloned()
    }
    fn set_string(&mut self, key: &str, value: String) {
        self.0.insert(key.to_owned(), value);
    }
    fn remove_string(&mut self, key: &str) {
        self.0.remove(key);
    }
    fn flush(&mut self) {}
}

/// The window as it was left, with that in the store.
fn start_again(store: &Store, options: Options) -> Driver {
    // The harness is 'static, and so is what it is built with.
    let store: &'static Store = Box::leak(Box::new(store.clone()));
    let harness = Harness::builder().with_size(SIZE).with_max_steps(20).build_eframe(move |cc| {
        cc.storage = Some(store);
        App::with_dialogs(cc, &options, false).unwrap()
    });
    let mut driver = Driver { harness };
    driver.settle();
    driver
}

fn type_text(driver: &mut Driver, text: &str) {
    driver.harness.event(egui::Event::Text(text.to_owned()));
    driver.harness.run_steps(2);
}

/// Steps until something is no longer shown; whether that came true.
fn goes_away(driver: &mut Driver, text: &str) -> bool {
    // While the pointer rests on it, it stays.
    driver.harness.hover_at(egui::pos2(400.0, 200.0));
    (0..200).any(|_| {
        driver.harness.step();
        !driver.shows(text)
    })
}

fn export(driver: &mut Driver, path: &Path) {
    driver.export("Primitives as numbers, JSON", path);
}

fn copied(driver: &Driver) -> Option<String> {
    driver.harness.output().platform_output.commands.iter().find_map(|command| match command {
        OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    })
}

#[test]
fn a_note_goes_by_itself_but_not_under_the_pointer() {
    let folder = tempfile::tempdir().unwrap();
    let mut driver = Driver::finished();
    export(&mut driver, &folder.path().join("out.json"));
    assert!(driver.shows("Wrote the primitives") && driver.has_button("Show in folder"));
    let place = driver.harness.get_by_role_and_label(Role::Button, "Show in folder").rect().center();
    driver.harness.hover_at(place);
    driver.harness.run_steps(150);
    assert!(driver.shows("Wrote the primitives"), "the pointer rests on it");
    driver.harness.hover_at(egui::pos2(10.0, 10.0));
    assert!(goes_away(&mut driver, "Wrote the primitives"));
    // The next one is closed by hand.
    export(&mut driver, &folder.path().join("other.json"));
    driver.press("Close notification");
    assert!(!driver.shows("other.json"));
}

#[test]
fn an_error_says_what_why_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let bad = file(&folder, "broken.obj", "f 1 2 3\n");
    let mut driver = Driver::finished();
    driver.key(Modifiers::COMMAND, Key::O);
    driver.type_path(bad.to_str().unwrap());
    driver.press("Open");
    driver.settle();
    let error = driver.session().messages.open_error().unwrap().clone();
    assert!(error.what.contains("broken.obj") && !error.why.is_empty() && !error.advice.is_empty());
    for part in [&error.what, &error.why, &error.advice] {
        assert!(driver.shows(part), "{part}");
    }
    assert!(driver.has_button("Open…"), "what a person may want to do next");
    driver.press("Details");
    // The box grows.
    driver.harness.run_steps(3);
    assert!(driver.shows("because"));
    driver.harness.get_by_role_and_label(Role::Button, "Copy").click();
    let report = (0..4).find_map(|_| {
        driver.harness.step();
        copied(&driver)
    });
    let report = report.unwrap();
    assert!(report.contains(&error.what) && report.contains(env!("CARGO_PKG_VERSION")), "{report}");
    driver.key(Modifiers::NONE, Key::Escape);
    assert!(driver.session().messages.open_error().is_none(), "Escape closes it");
}

#[test]
fn the_log_is_filtered_searched_copied_and_cleared() {
    let folder = tempfile::tempdir().unwrap();
    let mut driver = Driver::finished();
    export(&mut driver, &folder.path().join("out.json"));
    assert!(goes_away(&mut driver, "Wrote the primitives"));
    driver.key(Modifiers::NONE, Key::L);
    assert!(driver.shows("Loaded") && driver.shows("Wrote the primitives"));
    driver.press("Notes");
    assert!(!driver.shows("Loaded") && driver.shows("Wrote the primitives"));
    driver.press("Errors");
    assert!(driver.shows("No matching messages"));
    driver.press("All");
    let field = driver.harness.get_all_by_role(Role::TextInput).next().unwrap();
    field.focus();
    driver.harness.run_steps(2);
    type_text(&mut driver, "wrote the");
    assert!(!driver.shows("Loaded") && driver.shows("Wrote the primitives"));
    driver.harness.get_by_role_and_label(Role::Button, "Copy all").click();
    let text = (0..4).find_map(|_| {
        driver.harness.step();
        copied(&driver)
    });
    let text = text.unwrap();
    assert!(text.contains("Note") && text.contains("out.json") && text.lines().count() == 1, "{text}");
    driver.press("Clear");
    assert!(driver.shows("No messages yet"));
    driver.press("Close the log");
    assert!(!driver.session().view.shows_log);
}

#[test]
fn warnings_of_the_program_come_into_the_log() {
    let mut driver = Driver::finished();
    let (journal, layer) = Journal::new();
    driver.harness.state_mut().listen(journal);
    tracing::subscriber::with_default(tracing_subscriber::registry().with(layer), || {
        tracing::warn!(target: "superform::worker", "the pool is small");
    });
    driver.harness.run_steps(2);
    assert!(driver.shows("the pool is small"), "as a note");
    assert!(driver.session().messages.iter().any(|m| m.level == Level::Warning));
}

#[test]
fn any_command_is_found_and_run_by_a_few_letters() {
    let mut driver = Driver::finished();
    driver.key(Modifiers::COMMAND, Key::P);
    assert!(driver.session().window.shows_commands);
    type_text(&mut driver, "wire");
    driver.key(Modifiers::NONE, Key::Enter);
    assert_eq!(driver.session().view.surface_style, SurfaceStyle::Wire);
    assert!(!driver.session().window.shows_commands);
    // What was used last is first; the arrows move on from it.
    driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    assert!(driver.shows("Draw primitives wire"));
    driver.key(Modifiers::NONE, Key::ArrowDown);
    driver.key(Modifiers::NONE, Key::ArrowUp);
    driver.key(Modifiers::NONE, Key::Escape);
    assert!(!driver.session().window.shows_commands);
    // What can't be had now is listed with the reason, and does nothing.
    driver.key(Modifiers::COMMAND, Key::P);
    type_text(&mut driver, "frame selection");
    let row = driver.harness.get_by_role_and_label(Role::Button, "Frame selection");
    assert!(row.accesskit_node().is_disabled());
    driver.key(Modifiers::NONE, Key::Enter);
    assert!(driver.session().window.shows_commands, "it stays open");
    driver.key(Modifiers::NONE, Key::Escape);
    // Letters typed into it are no shortcuts.
    driver.key(Modifiers::COMMAND, Key::P);
    driver.key(Modifiers::NONE, Key::Num5);
    assert!(!driver.session().camera.orthographic);
}

#[test]
fn help_is_searched() {
    let mut driver = Driver::finished();
    driver.key(Modifiers::NONE, Key::F1);
    assert!(driver.shows("Zoom at the pointer") && driver.shows("Keyboard and mouse"));
    driver.harness.get_by_role(Role::TextInput).focus();
    driver.harness.run_steps(2);
    type_text(&mut driver, "merge all");
    assert!(!driver.shows("Zoom at the pointer") && driver.shows("Shift+M"));
}

#[test]
fn panels_open_and_close_and_the_interface_is_zoomed() {
    let mut driver = Driver::finished();
    let view = driver.viewport().width();
    for (key, panel) in [(Key::F2, Panel::Left), (Key::F3, Panel::Right), (Key::F4, Panel::Bottom)] {
        driver.key(Modifiers::NONE, key);
        assert!(!driver.session().window.shows(panel), "{panel:?}");
    }
    driver.harness.run_steps(2);
    assert!(!driver.has_button("Run") && driver.viewport().width() > view + 500.0);
    for key in [Key::F2, Key::F3, Key::F4] {
        driver.key(Modifiers::NONE, key);
    }
    driver.harness.run_steps(2);
    assert!(driver.has_button("Run") && (driver.viewport().width() - view).abs() < 1.0);
    driver.key(Modifiers::COMMAND, Key::Plus);
    driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::Plus);
    driver.key(Modifiers::COMMAND, Key::Equals);
    assert_eq!(driver.session().window.zoom, 1.3);
    driver.key(Modifiers::COMMAND, Key::Num0);
    assert_eq!(driver.session().window.zoom, 1.0);
}

#[test]
fn a_narrow_window_shows_one_side_at_a_time() {
    let mut driver = Driver::start(options(Source::BuiltIn), [640.0, 480.0]);
    driver.settle();
    assert!(driver.has_button("Reset") && driver.viewport().width() > 200.0);
    let id = driver.session().primitives()[0].id;
    assert!(!driver.has_button(&format!("Primitive {id}")));
    driver.key(Modifiers::NONE, Key::F3);
    driver.harness.run_steps(3);
    assert!(driver.has_button(&format!("Primitive {id}")) && !driver.has_button("Reset"));
}

#[test]
fn the_window_is_as_it_was_left() {
    let folder = tempfile::tempdir().unwrap();
    let points: String = (0..60).map(|i| format!("{} {} {}\n", i % 5, i / 5 % 4, i % 3)).collect();
    let shape = file(&folder, "sixty.xyz", &points);
    let mut driver = Driver::start(options(Source::File(shape.clone())), SIZE);
    driver.settle();
    driver.key(Modifiers::NONE, Key::F3);
    driver.set_light();
    driver.toggle("Live");
    driver.press("3/s");
    driver.key(Modifiers::COMMAND, Key::Plus);
    driver.harness.run_steps(3);
    // Wider, by its edge.
    let edge = driver.viewport().left_center() - egui::vec2(1.5, 0.0);
    driver.harness.hover_at(edge);
    driver.harness.run_steps(2);
    driver.harness.drag_at(edge);
    driver.harness.run_steps(2);
    driver.harness.hover_at(edge + egui::vec2(60.0, 0.0));
    driver.harness.run_steps(2);
    driver.harness.drop_at(edge + egui::vec2(60.0, 0.0));
    driver.harness.run_steps(3);
    let left = driver.viewport().left();
    assert!(left > edge.x + 30.0, "the panel was dragged from {} to {left}", edge.x);
    let mut store = Store::default();
    driver.harness.state_mut().save(&mut store);

    let again = start_again(&store, options(Source::BuiltIn));
    let session = again.session();
    assert!(!session.window.shows(Panel::Right) && session.window.shows(Panel::Left));
    assert_eq!((session.view.theme, session.window.zoom), (ThemeChoice::Light, 1.1));
    assert_eq!((session.pace, session.live.is_on), (Pace::PerSecond(3), false));
    assert_eq!(session.window.recent.iter().next(), Some(shape.as_path()));
    assert!((again.viewport().left() - left).abs() < 2.0, "{} was {left}", again.viewport().left());

    let anew = start_again(&store, Options { reset_layout: true, ..options(Source::BuiltIn) });
    assert!(anew.session().window.shows(Panel::Right) && anew.session().live.is_on);
}

#[test]
fn a_damaged_store_is_as_good_as_none() {
    for damage in ["", "{", "nonsense", r#"{"zoom": "much", "left": 7}"#, "[1, 2]"] {
        let names = ["preferences", "sizes", "egui"].map(|name| (name.to_owned(), damage.to_owned()));
        let driver = start_again(&Store(names.into()), options(Source::BuiltIn));
        let session = driver.session();
        assert!(session.window.shows(Panel::Right) && session.window.zoom == 1.0, "{damage}");
        assert_eq!(session.view.theme, ThemeChoice::System);
    }
}

#[test]
fn recent_files_are_opened_or_forgotten() {
    let folder = tempfile::tempdir().unwrap();
    let points: String = (0..200).map(|i| format!("{} {} {}\n", i % 7, i % 11, i % 13)).collect();
    let one = file(&folder, "one.xyz", &points);
    let mut driver = Driver::start(options(Source::File(one.clone())), SIZE);
    driver.settle();
    driver.key(Modifiers::COMMAND, Key::P);
    type_text(&mut driver, "open built-in");
    driver.key(Modifiers::NONE, Key::Enter);
    driver.settle();
    assert!(!driver.session().loaded.as_ref().unwrap().shape.name.contains("one"));
    driver.key(Modifiers::COMMAND, Key::P);
    type_text(&mut driver, "open one");
    driver.key(Modifiers::NONE, Key::Enter);
    driver.settle();
    assert_eq!(driver.session().loaded.as_ref().unwrap().shape.name, "one.xyz");
    // The menu has it, too.
    driver.press("File");
    driver.harness.get_by_role_and_label(Role::Button, "Open recent").hover();
    driver.harness.run_steps(3);
    assert!(driver.shows("one.xyz") && driver.has_button("Clear recent files"));
    driver.key(Modifiers::NONE, Key::Escape);
    std::fs::remove_file(&one).unwrap();
    driver.key(Modifiers::COMMAND, Key::P);
    type_text(&mut driver, "open one");
    driver.key(Modifiers::NONE, Key::Enter);
    driver.harness.run_steps(2);
    assert!(driver.shows("no longer exists"));
    assert!(driver.session().window.recent.is_empty());
}

/// A file that is let go over the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }
    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("nobody should read it through the window".to_owned())
    }
}

#[test]
fn files_are_dropped_with_a_hint_before() {
    let folder = tempfile::tempdir().unwrap();
    let points: String = (0..200).map(|i| format!("{} {} {}\n", i % 7, i % 11, i % 13)).collect();
    let shape = file(&folder, "shape.xyz", &points);
    let note = file(&folder, "note.doc", "text");
    let mut driver = Driver::finished();
    let over = |path: &Path| egui::HoveredFile { path: Some(path.to_owned()), mime: String::new() };
    driver.harness.input_mut().hovered_files = vec![over(&note)];
    driver.harness.run_steps(2);
    assert!(driver.shows("note.doc may not be a shape"));
    driver.harness.input_mut().hovered_files = vec![over(&note), over(&shape)];
    driver.harness.run_steps(2);
    assert!(driver.shows("Drop to open shape.xyz"));
    driver.harness.input_mut().hovered_files.clear();
    driver.harness.input_mut().dropped_files = vec![Arc::new(Dropped(note)), Arc::new(Dropped(shape))];
    driver.harness.run_steps(2);
    assert!(!driver.shows("Drop to open"));
    driver.settle();
    assert_eq!(driver.session().loaded.as_ref().unwrap().shape.name, "shape.xyz");
    assert!(driver.session().messages.iter().any(|m| m.what.contains("out of 2 dropped files")));
}

/// The window in states that show all there is.
fn states() -> Vec<(&'static str, Driver)> {
    let folder = tempfile::tempdir().unwrap();
    let mut all = vec![("at the start", Driver::start(options(Source::BuiltIn), SIZE))];
    let mut add = |name, prepare: &dyn Fn(&mut Driver)| {
        let mut driver = Driver::finished();
        prepare(&mut driver);
        driver.harness.run_steps(2);
        all.push((name, driver));
    };
    add("finished", &|_| {});
    add("selected", &|driver| {
        let id = driver.session().primitives()[0].id;
        driver.press(&format!("Primitive {id}"));
    });
    for menu in ["File", "Edit", "Sampler", "View", "Window", "Help"] {
        add(menu, &|driver| driver.press(menu));
    }
    for verb in [Verb::ShowCommands, Verb::ShowShortcuts, Verb::ToggleLog] {
        add(verb.entry().text, &|driver| {
            let shortcut = verb.entry().shortcut.unwrap();
            let modifiers =
                if shortcut.ctrl { Modifiers::COMMAND | Modifiers::SHIFT } else { Modifiers::NONE };
            let key = match verb {
                Verb::ShowCommands => Key::P,
                Verb::ShowShortcuts => Key::F1,
                _ => Key::L,
            };
            driver.key(modifiers, key);
        });
    }
    add("a question", &|driver| driver.key(Modifiers::COMMAND, Key::O));
    add("an error", &|driver| {
        driver.key(Modifiers::COMMAND, Key::O);
        driver.type_path("/no/such/shape.obj");
        driver.press("Open");
        driver.settle();
        driver.press("Details");
    });
    add("a note", &|driver| export(driver, &folder.path().join("out.json")));
    all
}

#[test]
fn every_control_has_a_name() {
    for (name, driver) in states() {
        let unnamed = driver.harness.unnamed_widgets();
        assert!(unnamed.is_empty(), "{name}: {}", unnamed.join("\n"));
    }
}

const CONTROLS: [Role; 7] = [
    Role::Button,
    Role::CheckBox,
    Role::Slider,
    Role::SpinButton,
    Role::ComboBox,
    Role::TextInput,
    Role::RadioButton,
];

#[test]
fn the_keyboard_reaches_every_control() {
    for (state, prepare) in [("plain", false), ("with the log", true)] {
        let mut driver = Driver::finished();
        if prepare {
            driver.key(Modifiers::NONE, Key::L);
            driver.harness.run_steps(3);
        }
        let name = |node: &egui_kittest::Node<'_>| {
            let node = node.accesskit_node();
            (format!("{:?}", node.role()), node.label().unwrap_or_default())
        };
        let mut wanted: BTreeSet<(String, String)> = BTreeSet::new();
        for role in CONTROLS {
            let nodes = driver.harness.query_all_by_role(role).filter(|n| !n.accesskit_node().is_disabled());
            wanted.extend(nodes.map(|node| name(&node)));
        }
        assert!(wanted.len() > 30, "{}", wanted.len());
        for _ in 0..3 * wanted.len() {
            driver.key(Modifiers::NONE, Key::Tab);
            let focused = driver.harness.root().children_recursive().find(|node| node.is_focused());
            if let Some(node) = focused {
                wanted.remove(&name(&node));
            }
        }
        assert!(wanted.is_empty(), "{state}: Tab never comes to {wanted:?}");
    }
}
