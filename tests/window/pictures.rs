//! Saving pictures and turntables, by the labels a person sees.

use crate::driver::{Driver, Role, options};
use crate::needs;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use superform::render::{Offscreen, RenderOptions};
use superform::worker::Source;

fn drawn() -> Option<Driver> {
    needs::drawn(Offscreen::new(RenderOptions::default()))?;
    let mut driver = Driver::start_drawn(options(Source::BuiltIn), [1024.0, 700.0]);
    driver.settle();
    Some(driver)
}

#[test]
fn a_picture_is_saved_at_the_chosen_size_without_background() {
    let Some(mut driver) = drawn() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chair.png");
    driver.key(Modifiers::SHIFT, Key::F12);
    driver.choose("Size", "1080p, 1920 × 1080");
    driver.toggle("Transparent background");
    if let Some(folder) = std::env::var_os("SUPERFORM_PICTURES") {
        let picture = driver.harness.render().unwrap();
        picture.save(std::path::Path::new(&folder).join("save-picture.png")).unwrap();
    }
    driver.press("Choose file and save…");
    driver.type_path(path.to_str().unwrap());
    driver.press("Save");
    driver.until_shown("Wrote ");
    let picture = image::open(&path).unwrap().to_rgba8();
    assert_eq!(picture.dimensions(), (1920, 1080));
    assert_eq!(picture.get_pixel(3, 3)[3], 0, "the background is transparent");
    let solid = picture.pixels().filter(|p| p[3] > 60).count();
    assert!(solid > 50_000, "{solid} pixels of the chair");
}

/// Asks for a turntable of that many PNG pictures.
fn ask_for_turntable(driver: &mut Driver, frames: f64, path: &std::path::Path) {
    driver.press("File");
    driver.press("Save turntable…");
    driver.harness.run_steps(3);
    driver.harness.get_by_role_and_label(Role::SpinButton, "Frames").set_value_accesskit(frames);
    driver.harness.run_steps(2);
    driver.harness.get_by_role_and_label(Role::RadioButton, "PNG pictures").click();
    driver.harness.run_steps(2);
    driver.press("Choose file and save…");
    driver.type_path(path.to_str().unwrap());
    driver.press("Save");
}

#[test]
fn a_turntable_can_be_given_up() {
    let Some(mut driver) = drawn() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("turn");
    ask_for_turntable(&mut driver, 700.0, &path);
    driver.until_shown("Turntable, ");
    driver.press("Cancel");
    driver.harness.run_steps(2);
    assert!(!path.exists() && !driver.shows("Turntable, "));
}

#[test]
fn a_turntable_goes_round() {
    let Some(mut driver) = drawn() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("turn");
    ask_for_turntable(&mut driver, 4.0, &path);
    driver.until_shown("Wrote ");
    let mut pictures: Vec<_> = std::fs::read_dir(&path).unwrap().map(|e| e.unwrap().path()).collect();
    pictures.sort();
    assert_eq!(pictures.len(), 4);
    let pictures: Vec<_> = pictures.iter().map(|p| image::open(p).unwrap().to_rgba8()).collect();
    assert_eq!(pictures[0].dimensions(), (480, 480));
    assert!(pictures.windows(2).all(|p| p[0] != p[1]), "each is from another side");
}
