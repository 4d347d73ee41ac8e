//! No text is cut off, in small windows and at any scale.

use crate::driver::{Driver, options};
use egui::epaint::{ClippedShape, Shape, TextShape};
use egui::{Key, Modifiers, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::NodeT;
use superform::app::App;
use superform::worker::Source;

fn texts<'a>(shape: &'a Shape, clip: Rect, found: &mut Vec<(&'a TextShape, Rect)>) {
    match shape {
        Shape::Text(text) => found.push((text, clip)),
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| texts(shape, clip, found)),
        _ => {}
    }
}

/// What is cut off in the last frame: texts that reach over the left or right
/// edge of what they are in, or out of the window.
fn cut_off(driver: &Driver, size: egui::Vec2) -> Vec<String> {
    let shapes: &[ClippedShape] = &driver.harness.output().shapes;
    let mut found = Vec::new();
    for ClippedShape { clip_rect, shape, .. } in shapes {
        texts(shape, *clip_rect, &mut found);
    }
    assert!(found.len() > 40, "only {} texts", found.len());
    let window = Rect::from_min_size(egui::Pos2::ZERO, size).expand(0.5);
    found
        .into_iter()
        .filter_map(|(text, clip)| {
            let rect = text.visual_bounding_rect();
            // What is scrolled out of sight is not cut.
            if !rect.is_positive() || !clip.intersects(rect) {
                return None;
            }
            let room = clip.intersect(window);
            let fits = rect.left() >= room.left() - 1.0 && rect.right() <= room.right() + 1.0;
            (!fits).then(|| format!("{:?} at {rect:?} in {room:?}", text.galley.text()))
        })
        .collect()
}

/// A window of that many logical pixels on a screen with that scale.
fn start(size: [f32; 2], scale: f32) -> Driver {
    let options = options(Source::BuiltIn);
    let builder = Harness::builder().with_size(size).with_pixels_per_point(scale).with_max_steps(20);
    let harness = builder.build_eframe(move |cc| App::with_dialogs(cc, &options, false).unwrap());
    let mut driver = Driver { harness };
    driver.settle();
    driver
}

#[test]
fn no_text_is_cut_off() {
    // 1024 × 700 at 100 % and at 200 %, and 200 % of a large screen.
    for (size, scale) in
        [([1024.0, 700.0], 1.0), ([512.0, 350.0], 2.0), ([1024.0, 700.0], 2.0), ([1440.0, 900.0], 1.5)]
    {
        let mut driver = start(size, scale);
        let window = egui::vec2(size[0], size[1]);
        let mut faults = Vec::new();
        let mut check = |driver: &mut Driver, state: &str| {
            driver.harness.run_steps(3);
            for fault in cut_off(driver, window) {
                faults.push(format!("{size:?} at {scale}, {state}: {fault}"));
            }
        };
        check(&mut driver, "finished");
        if driver.session().window.is_narrow() {
            driver.key(Modifiers::NONE, Key::F3);
            check(&mut driver, "right panel");
        }
        let id = driver.session().primitives()[0].id;
        driver.press(&format!("Primitive {id}"));
        check(&mut driver, "selected");
        for (key, modifiers, state) in [
            (Key::L, Modifiers::NONE, "log"),
            (Key::F1, Modifiers::NONE, "help"),
            (Key::P, Modifiers::COMMAND, "all commands"),
            (Key::O, Modifiers::COMMAND, "a question"),
        ] {
            driver.key(modifiers, key);
            check(&mut driver, state);
            driver.key(Modifiers::NONE, if key == Key::L { key } else { Key::Escape });
            driver.harness.run_steps(3);
        }
        driver.key(Modifiers::COMMAND, Key::O);
        driver.type_path("/no/such/folder/with/quite/a/long/path/that/has/to/be/wrapped/somewhere/shape.obj");
        driver.press("Open");
        driver.settle();
        driver.press("Details");
        check(&mut driver, "an error");
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }
}

#[test]
fn the_view_keeps_room_in_any_window() {
    for size in [[512.0, 350.0], [800.0, 600.0], [1024.0, 700.0], [2560.0, 1440.0]] {
        let driver = start(size, 1.0);
        let view = driver.viewport();
        assert!(view.width() > 0.3 * size[0] && view.height() > 0.2 * size[1], "{view:?} in {size:?}");
        let count = driver.harness.root().children_recursive().count();
        assert!(count > 30, "{count} nodes");
    }
}
