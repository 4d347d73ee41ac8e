//! Sessions as a person saves, opens and recovers them: by the labels.

use std::path::Path;

use crate::driver::{Driver, PATIENCE, file, options};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use superform::app::Options;
use superform::session::{Session, Verb};
use superform::worker::Source;

const SIZE: [f32; 2] = [1280.0, 800.0];

/// The window, which keeps its session in that folder.
fn kept_in(folder: &Path, source: Source) -> Options {
    Options { state_folder: Some(folder.to_owned()), ..options(source) }
}

/// Takes in what the autosave tells until the session is as wished.
fn until_kept(driver: &mut Driver, wish: impl Fn(&Session) -> bool) {
    let ctx = driver.harness.ctx.clone();
    while !wish(driver.session()) {
        let app = driver.harness.state_mut();
        assert!(app.wait_for_keeper(&ctx, PATIENCE), "the keeper has fallen silent");
    }
    driver.harness.run_steps(3);
}

/// Deletes the first primitive by hand, after which there is something to lose.
fn work(driver: &mut Driver) -> usize {
    driver.settle();
    let before = driver.session().primitives().len();
    let id = driver.session().primitives()[0].id;
    driver.press(&format!("Primitive {id}"));
    driver.key(Modifiers::NONE, Key::Delete);
    driver.settle();
    assert_eq!(driver.session().primitives().len(), before - 1);
    before - 1
}

fn has_mark(driver: &Driver) -> bool {
    driver.harness.state().title().starts_with('•')
}

#[test]
fn a_session_is_saved_opened_and_everything_is_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.superform");
    let mut driver = Driver::finished();
    assert!(!has_mark(&driver), "the first run is nobody's work");
    work(&mut driver);
    driver.slide("Concentration α", 0.7);
    driver.settle();
    driver.key(Modifiers::NONE, Key::Num3);
    assert!(has_mark(&driver));
    driver.key(Modifiers::COMMAND, Key::S);
    // The ending is added.
    driver.type_path(folder.path().join("mine").to_str().unwrap());
    driver.press("Save");
    until_kept(&mut driver, |s| s.session_file().is_some());
    assert!(path.is_file() && !has_mark(&driver));
    assert_eq!(driver.harness.state().title(), "mine – Superform");
    let before = driver.session().workspace();

    let mut driver = Driver::start(options(Source::File(path.clone())), SIZE);
    until_kept(&mut driver, |s| s.loaded.is_some());
    let session = driver.session();
    assert_eq!(session.params, before.document.params);
    assert_eq!(session.undo.done().len(), before.undo.done().len());
    assert_eq!(session.timeline.branches().len(), before.document.timeline.branches().len());
    let counts = |d: &superform::session::timeline::Timeline| -> Vec<usize> {
        d.branches().iter().map(|b| b.states.len()).collect()
    };
    assert_eq!(counts(&session.timeline), counts(&before.document.timeline));
    assert_eq!(session.selection, before.document.selection);
    let (now, then) = (session.camera, before.camera);
    assert_eq!(
        (now.yaw, now.pitch, now.target, now.distance),
        (then.yaw, then.pitch, then.target, then.distance)
    );
    assert!(!has_mark(&driver), "nothing was changed since");
    // And work goes on where it was left.
    let primitives = driver.session().primitives().len();
    driver.key(Modifiers::COMMAND, Key::Z);
    driver.settle();
    driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    driver.settle();
    assert_eq!(driver.session().primitives().len(), primitives);
    let id = driver.session().primitives()[0].id;
    driver.press(&format!("Primitive {id}"));
    driver.key(Modifiers::NONE, Key::Delete);
    driver.settle();
    assert_eq!(driver.session().primitives().len(), primitives - 1);
    assert!(has_mark(&driver));
}

#[test]
fn another_shape_is_not_saved_over_the_session_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first.superform", "second.superform"].map(|name| folder.path().join(name));
    let other = file(&folder, "other.obj", include_str!("../../assets/chair.obj"));
    let save = |driver: &mut Driver, path: &Path| {
        driver.key(Modifiers::COMMAND, Key::S);
        driver.type_path(path.to_str().unwrap());
        driver.press("Save");
        until_kept(driver, |s| s.session_file() == Some(path));
    };
    let mut driver = Driver::finished();
    save(&mut driver, &first);
    let saved = std::fs::read(&first).unwrap();
    assert_eq!(driver.harness.state().title(), "first – Superform");

    driver.key(Modifiers::COMMAND, Key::O);
    driver.type_path(other.to_str().unwrap());
    driver.press("Open");
    driver.settle();
    assert_eq!(driver.harness.state().title(), "• other.obj – Superform");
    // It asks for a path, and the first file stays as it was.
    save(&mut driver, &second);
    assert_eq!(driver.harness.state().title(), "second – Superform");
    assert_eq!(std::fs::read(&first).unwrap(), saved);
    assert_ne!(std::fs::read(&second).unwrap(), saved);
    // Nor is the first shape saved over the second.
    driver.key(Modifiers::COMMAND, Key::Z);
    driver.settle();
    assert_eq!(driver.session().session_file(), None);
}

#[test]
fn a_file_that_is_no_session_leaves_the_present_one() {
    let folder = tempfile::tempdir().unwrap();
    let bad = file(&folder, "bad.superform", "v 0 0 0\n");
    let mut driver = Driver::finished();
    let before = driver.session().snapshot.clone().unwrap();
    driver.key(Modifiers::COMMAND, Key::O);
    driver.type_path(bad.to_str().unwrap());
    driver.press("Open");
    until_kept(&mut driver, |s| s.messages.open_error().is_some());
    assert!(driver.shows("is not a Superform session"));
    let after = driver.session().snapshot.clone().unwrap();
    assert!(std::sync::Arc::ptr_eq(&before, &after));
}

#[test]
fn what_a_crash_left_behind_is_offered_and_recovered() {
    let folder = tempfile::tempdir().unwrap();
    let mut driver = Driver::start(kept_in(folder.path(), Source::BuiltIn), SIZE);
    let left = work(&mut driver);
    // Closed like a process that is killed: without a word. What was handed over is on the disk.
    drop(driver);

    let mut driver = Driver::start(kept_in(folder.path(), Source::BuiltIn), SIZE);
    until_kept(&mut driver, |s| !s.saving.found().is_empty());
    assert!(driver.shows("built-in chair, iteration"));
    driver.press("Later");
    assert!(!driver.has_button("Recover"));
    driver.settle();
    drop(driver);

    let mut driver = Driver::start(kept_in(folder.path(), Source::BuiltIn), SIZE);
    until_kept(&mut driver, |s| s.saving.found().len() == 2);
    let before = driver.session().saving.found().to_vec();
    let edited = before.iter().position(|f| f.summary.steps > 1).unwrap();
    let recover = driver.harness.query_all_by_label("Recover").nth(edited).unwrap();
    recover.click();
    driver.harness.run_steps(2);
    until_kept(&mut driver, |s| s.saving.found().len() == 1);
    assert_eq!(driver.session().primitives().len(), left);
    assert!(driver.session().is_enabled(Verb::Undo) && has_mark(&driver), "it is in no file yet");
    driver.press("Discard");
    assert!(!driver.has_button("Recover"));
    // Closed in order, it is the last session.
    driver.settle();
    driver.harness.state_mut().close();
    drop(driver);

    let mut driver = Driver::start(kept_in(folder.path(), Source::BuiltIn), SIZE);
    until_kept(&mut driver, |s| s.saving.has_last());
    driver.press("File");
    driver.press("Reopen last session");
    until_kept(&mut driver, |s| s.primitives().len() == left);
    assert!(driver.session().saving.found().is_empty());
}

#[test]
fn unsaved_work_is_asked_about_where_nothing_keeps_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut driver = Driver::finished();
    work(&mut driver);
    driver.key(Modifiers::COMMAND, Key::Q);
    assert!(driver.shows("Save the session before quitting?"));
    driver.press("Cancel");
    assert!(!driver.shows("Save the session before quitting?"));
    driver.key(Modifiers::COMMAND, Key::Q);
    driver.press("Save");
    driver.type_path(folder.path().join("kept.superform").to_str().unwrap());
    driver.press("Save");
    until_kept(&mut driver, |s| s.session_file().is_some());
    assert!(driver.session().saving.parting().is_none(), "it went on to quit");
    assert!(folder.path().join("kept.superform").is_file());
}
