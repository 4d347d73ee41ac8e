//! The whole window as a picture, drawn by a real driver. With
//! `SUPERFORM_PICTURES` set to a folder, the pictures are kept there.

use crate::driver::{Driver, options};
use crate::needs::drawn;
use egui::{Key, Modifiers};
use superform::render::{Offscreen, RenderOptions};
use superform::worker::{SamplingOptions, Source};

/// Whether there is a driver to draw with.
fn can_draw() -> bool {
    drawn(Offscreen::new(RenderOptions::default())).is_some()
}

fn keep(picture: &image::RgbaImage, name: &str) {
    if let Some(folder) = std::env::var_os("SUPERFORM_PICTURES") {
        std::fs::create_dir_all(&folder).unwrap();
        picture.save(std::path::Path::new(&folder).join(name)).unwrap();
    }
}

/// Pixels of saturated colour, as only primitives, points and the accent are.
fn colored(picture: &image::RgbaImage, rect: egui::Rect) -> usize {
    let inside = |x: u32, y: u32| rect.contains(egui::pos2(x as f32, y as f32));
    let is_colored =
        |p: &image::Rgba<u8>| p.0[..3].iter().max().unwrap() - p.0[..3].iter().min().unwrap() > 60;
    picture.enumerate_pixels().filter(|(x, y, p)| inside(*x, *y) && is_colored(p)).count()
}

#[test]
fn the_viewport_shows_the_shape_and_its_layers() {
    if !can_draw() {
        return;
    }
    let mut options = options(Source::BuiltIn);
    options.sampling = SamplingOptions::default();
    options.params.iterations = 30;
    options.params.clusters = 30;
    let mut driver = Driver::start_drawn(options, [1440.0, 900.0]);
    driver.settle();
    let dark = driver.harness.render().unwrap();
    keep(&dark, "window-dark.png");
    let viewport = driver.viewport();
    let all = colored(&dark, viewport);
    assert!(all > 5000, "the chair fills the view: {all}");

    let id = driver.session().primitives()[0].id;
    driver.press(&format!("Primitive {id}"));
    driver.choose("Surface style", "Solid");
    driver.set_light();
    let light = driver.harness.render().unwrap();
    keep(&light, "window-light.png");
    assert!(light.get_pixel(4, 4).0[0] > 200 && dark.get_pixel(4, 4).0[0] < 60, "the theme is switched");

    driver.press(&format!("Primitive {id}"));
    driver.toggle_layer("Primitives");
    let points = driver.harness.render().unwrap();
    keep(&points, "window-points.png");
    let points = colored(&points, viewport);
    assert!(points > 500 && points < all, "{points} of {all}");
    driver.toggle_layer("Points");
    let nothing = driver.harness.render().unwrap();
    assert!(colored(&nothing, viewport) < points / 4, "hidden layers are not drawn");
}

#[test]
fn a_small_window_with_everything_open() {
    if !can_draw() {
        return;
    }
    let mut driver = Driver::start_drawn(options(Source::BuiltIn), [1024.0, 700.0]);
    driver.settle();
    let id = driver.session().primitives()[0].id;
    driver.press(&format!("Primitive {id}"));
    driver.toggle("Live");
    driver.slide("Clusters K", 20.0);
    driver.press("Step merge");
    driver.settle();
    keep(&driver.harness.render().unwrap(), "small.png");
    driver.key(Modifiers::NONE, Key::F1);
    keep(&driver.harness.render().unwrap(), "small-help.png");
    driver.key(Modifiers::NONE, Key::F1);
    driver.key(Modifiers::COMMAND, Key::O);
    driver.type_path("/no/such/shape.obj");
    keep(&driver.harness.render().unwrap(), "small-open.png");
    driver.press("Open");
    driver.settle();
    driver.key(Modifiers::NONE, Key::L);
    let picture = driver.harness.render().unwrap();
    keep(&picture, "small-error.png");
    assert_eq!(picture.dimensions(), (1024, 700));
}
