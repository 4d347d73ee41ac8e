//! Taking results home and bringing primitives in, by the labels a person sees.

use std::path::Path;

use crate::driver::{Driver, Role, file, options};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use superform::io::{self, Format};
use superform::render::{Offscreen, RenderOptions};
use superform::worker::Source;

/// Opens the dialog and names the file.
fn ask(driver: &mut Driver, format: &str, path: &Path) {
    driver.key(Modifiers::COMMAND, Key::E);
    // The list is longer than the dialog.
    driver.harness.get_by_role_and_label(Role::Button, format).scroll_to_me();
    driver.harness.run_steps(8);
    driver.press(format);
    let field = driver.harness.get_by_role_and_label(Role::TextInput, "File");
    field.set_text_value_accesskit(path.to_str().unwrap());
    driver.harness.run_steps(2);
}

/// The text that comes into the clipboard in the next frames.
fn copied(driver: &mut Driver) -> String {
    for _ in 0..4 {
        driver.harness.step();
        let commands = &driver.harness.output().platform_output.commands;
        for command in commands {
            if let egui::OutputCommand::CopyText(text) = command {
                return text.clone();
            }
        }
    }
    panic!("nothing was copied");
}

fn paste(driver: &mut Driver, text: &str) {
    driver.harness.event(egui::Event::Paste(text.to_owned()));
    driver.harness.run_steps(2);
    driver.settle();
}

#[test]
fn every_format_is_written_where_it_is_asked_for() {
    let mut driver = Driver::finished();
    let folder = tempfile::tempdir().unwrap();
    for format in Format::ALL {
        let path = folder.path().join(format!("{}.{}", format.name(), format.ending()));
        ask(&mut driver, &format!("{}, {}", format.kind().title(), format.title()), &path);
        assert!(driver.shows(format.description()), "{format:?} is not described");
        assert!(driver.shows("About "), "{format:?} has no size");
        driver.press("Export");
        driver.settle();
        assert!(driver.shows(&format!("to {}", path.display())), "{format:?} was not told");
        assert!(std::fs::metadata(&path).unwrap().len() > 100, "{format:?}");
        assert_eq!(driver.session().window.export.format, format, "the last one is remembered");
    }
}

#[test]
fn a_file_that_is_there_is_replaced_only_when_that_was_said() {
    let mut driver = Driver::finished();
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "mine.csv", "precious");
    ask(&mut driver, "Segmented cloud, CSV", &path);
    driver.press("Export");
    assert!(driver.shows("The file already exists"));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "precious");
    driver.press("Replace");
    driver.settle();
    let first = std::fs::read_to_string(&path).unwrap();
    assert!(first.starts_with("x,y,z"), "{first:.40}");
    // The same again, without a question.
    std::fs::write(&path, "old").unwrap();
    driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
    driver.settle();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), first);
    // A folder that isn't there can't be chosen.
    ask(&mut driver, "Segmented cloud, CSV", &folder.path().join("nowhere/x.csv"));
    assert!(driver.shows("Folder not found") && !driver.is_enabled("Export"));
    driver.press("Cancel");
}

#[test]
fn a_cloud_has_no_mesh_to_write_and_it_is_said_why() {
    let folder = tempfile::tempdir().unwrap();
    let points: String =
        (0..400).map(|i| format!("{} {} {}\n", i % 20, i / 20, (i % 7) as f64 * 0.1)).collect();
    let path = file(&folder, "sheet.xyz", &points);
    let mut driver = Driver::start(options(Source::File(path)), [1280.0, 800.0]);
    driver.settle();
    driver.key(Modifiers::COMMAND, Key::E);
    if Format::of_kind(io::Kind::Mesh).next().is_some() {
        assert!(driver.shows("a segmented mesh needs a mesh"));
        assert!(!driver.is_enabled("Segmented mesh, PLY"));
    }
    driver.press("Cancel");
}

#[test]
fn primitives_go_through_the_clipboard_and_back() {
    let mut driver = Driver::finished();
    let before: Vec<_> = driver.session().primitives().iter().map(|p| (p.id, p.shape)).collect();
    driver.harness.event(egui::Event::Copy);
    let json = copied(&mut driver);
    assert!(json.contains("superform-primitives"));
    driver.press("Edit");
    driver.harness.get_by_role_and_label(Role::Button, "Copy primitives as CSV").click();
    let csv = copied(&mut driver);
    for text in [json, csv] {
        driver.key(Modifiers::NONE, Key::Home);
        let id = driver.session().primitives()[0].id;
        driver.press(&format!("Primitive {id}"));
        driver.key(Modifiers::NONE, Key::Delete);
        driver.settle();
        assert_eq!(driver.session().primitives().len(), before.len() - 1);
        paste(&mut driver, &text);
        let after: Vec<_> = driver.session().primitives().iter().map(|p| (p.id, p.shape)).collect();
        assert_eq!(before.len(), after.len());
        for ((a, x), (b, y)) in before.iter().zip(&after) {
            assert_eq!(a, b);
            assert!((x.semi_axes - y.semi_axes).norm() < 1e-9 * x.semi_axes.norm());
            assert!((x.translation - y.translation).norm() < 1e-9 * x.semi_axes.norm());
        }
    }
    // It is one step that can be undone.
    driver.key(Modifiers::COMMAND, Key::Z);
    driver.settle();
    assert_eq!(driver.session().primitives().len(), before.len() - 1);
    // Text that is something else is refused with a reason, and nothing changes.
    paste(&mut driver, "To be, or not to be");
    assert!(driver.shows("Cannot paste primitives"));
    assert_eq!(driver.session().primitives().len(), before.len() - 1);
}

#[test]
fn a_result_is_opened_without_a_run_and_brought_in_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("primitives.json");
    let mut driver = Driver::finished();
    let count = driver.session().primitives().len();
    ask(&mut driver, "Primitives as numbers, JSON", &path);
    driver.press("Export");
    driver.settle();

    let mut other = Driver::start(options(Source::File(path.clone())), [1280.0, 800.0]);
    other.settle();
    assert_eq!((other.session().primitives().len(), other.iteration()), (count, 0));
    assert_eq!(other.session().timeline.states().len(), 1, "it was not run");
    other.until(|session| session.measurement().is_some());
    other.key(Modifiers::COMMAND, Key::I);
    other.type_path(path.to_str().unwrap());
    other.press("Open");
    other.settle();
    assert_eq!(other.session().primitives().len(), count);
    assert_eq!(other.session().timeline.states().len(), 2);
    other.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(other.session().timeline.shown_index(), 0);
}

#[test]
#[ignore = "draws pictures for people to look at, into the folder SUPERFORM_PICTURES"]
fn the_dialog_is_drawn() {
    let folder = std::env::var_os("SUPERFORM_PICTURES").unwrap();
    Offscreen::new(RenderOptions::default()).unwrap();
    let mut driver = Driver::start_drawn(options(Source::BuiltIn), [1280.0, 800.0]);
    driver.settle();
    driver.key(Modifiers::COMMAND, Key::E);
    driver.harness.run_steps(3);
    for light in [false, true] {
        let picture = driver.harness.render().unwrap();
        picture.save(Path::new(&folder).join(format!("export-{light}.png"))).unwrap();
        if !light {
            driver.press("Cancel");
            driver.set_light();
            driver.key(Modifiers::COMMAND, Key::E);
            driver.press("Segmented cloud, PCD");
            driver.harness.run_steps(3);
        }
    }
}
