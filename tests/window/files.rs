//! Files, layers, the list of primitives, help: by the labels a person sees.

use crate::driver::{Driver, PATIENCE, Role, file, options};
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use superform::session::verb::Verb;
use superform::session::view::Layer;
use superform::worker::Source;

#[test]
fn a_bad_file_says_what_is_wrong_and_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let bad = file(&folder, "broken.obj", "f 1 2 3\n");
    let mut driver = Driver::finished();
    let before = driver.session().snapshot.clone().unwrap();
    driver.key(Modifiers::COMMAND, Key::O);
    driver.type_path(bad.to_str().unwrap());
    driver.press("Open");
    driver.settle();
    assert!(driver.shows("broken.obj"), "the error names the file");
    assert!(driver.has_button("Dismiss"));
    let after = driver.session().snapshot.clone().unwrap();
    assert!(std::sync::Arc::ptr_eq(&before, &after), "the old state stays");
    driver.press("Dismiss");
    assert!(!driver.has_button("Dismiss"));
    // It can still be found in the log.
    driver.key(Modifiers::NONE, Key::L);
    assert!(driver.shows("broken.obj"));
}

#[test]
fn another_shape_is_opened_in_the_middle_of_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let mut points = String::new();
    for i in 0..400 {
        let (a, z) = (f64::from(i) * 0.618 * std::f64::consts::TAU, f64::from(i) / 200.0 - 1.0);
        let r = (1.0 - z * z).max(0.0).sqrt();
        points.push_str(&format!("{} {} {z}\n", r * a.cos(), r * a.sin()));
    }
    let ball = file(&folder, "ball.xyz", &points);
    let mut driver = Driver::start(options(Source::BuiltIn), [1280.0, 800.0]);
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| s.abstraction.iteration >= 1));
    driver.key(Modifiers::COMMAND, Key::O);
    driver.type_path(ball.to_str().unwrap());
    driver.press("Open");
    driver.until(|s| s.loaded.as_ref().is_some_and(|l| l.shape.name == "ball.xyz"));
    driver.settle();
    assert!(driver.shows("ball.xyz"));
    assert_eq!(driver.iteration(), 6, "it was run at once");
    assert_eq!(driver.session().primitives().len(), 1, "a ball is one primitive");
}

#[test]
fn the_result_is_taken_home() {
    let folder = tempfile::tempdir().unwrap();
    let cloud = folder.path().join("out.ply");
    let primitives = folder.path().join("out.json");
    let mut driver = Driver::finished();
    driver.export("Segmented cloud, PLY", &cloud);
    driver.export("Primitives as numbers, JSON", &primitives);
    assert!(driver.shows("Wrote the primitives"));
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(&primitives).unwrap()).unwrap();
    assert_eq!(json["primitives"].as_array().unwrap().len(), driver.session().primitives().len());
    assert!(std::fs::read(&cloud).unwrap().starts_with(b"ply"));
    // A folder that isn't there is said before anything is written.
    driver.export("Segmented cloud, PLY", std::path::Path::new("/no/such/folder/out.ply"));
    assert!(driver.shows("Folder not found") && !driver.is_enabled("Export"));
}

#[test]
fn layers_are_switched() {
    let mut driver = Driver::finished();
    for layer in Layer::ALL {
        assert!(driver.session().view.shows(layer));
        driver.toggle_layer(layer.text());
        assert!(!driver.session().view.shows(layer), "{layer:?}");
        driver.toggle_layer(layer.text());
        assert!(driver.session().view.shows(layer), "{layer:?}");
    }
    driver.choose("Surface style", "Wire");
    assert_eq!(driver.session().view.surface_style, superform::session::view::SurfaceStyle::Wire);
    driver.toggle_layer("Points");
    if driver.harness.query_by_role_and_label(Role::Slider, "Point size").is_none() {
        driver.press("Show");
    }
    driver.slide("Point size", 8.0);
    assert!((driver.session().view.point_size - 8.0).abs() < 1e-3);
}

#[test]
fn a_primitive_is_selected_inspected_and_hidden() {
    let mut driver = Driver::finished();
    let id = driver.session().primitives()[0].id;
    let row = format!("Primitive {id}");
    driver.press(&row);
    assert_eq!(driver.session().selected_primitive().map(|p| p.id), Some(id));
    for label in ["Exponents ε", "Semi-axes a", "Centre t", "Rotation R", "Taper k", "Noise σ"] {
        assert!(driver.shows(label), "{label}");
    }
    // The list makes room for the numbers.
    driver.harness.run_steps(4);
    driver.toggle(&format!("{row} in the viewport"));
    assert!(driver.session().hidden.contains(&id));
    driver.press("Show all");
    assert!(driver.session().hidden.is_empty());
    driver.key(Modifiers::NONE, Key::F);
    driver.key(Modifiers::NONE, Key::H);
    assert!(driver.session().hidden.contains(&id));
    driver.key(Modifiers::ALT, Key::H);
    driver.key(Modifiers::NONE, Key::Escape);
    assert!(driver.session().selection.is_empty() && driver.session().hidden.is_empty());
}

#[test]
fn the_camera_answers_to_keys_and_mouse() {
    let mut driver = Driver::finished();
    let start = driver.session().camera;
    driver.key(Modifiers::NONE, Key::Num7);
    assert!((driver.session().camera.pitch - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    driver.key(Modifiers::NONE, Key::Num5);
    assert!(driver.session().camera.orthographic);
    let center = driver.harness.get_by_role_and_label(Role::Image, "3D view").rect().center();
    driver.harness.drag_at(center);
    driver.harness.hover_at(center + egui::vec2(40.0, 25.0));
    driver.harness.drop_at(center + egui::vec2(40.0, 25.0));
    driver.harness.run_steps(3);
    assert_ne!(driver.session().camera.yaw, start.yaw, "dragging orbits");
    driver.key(Modifiers::NONE, Key::Home);
    assert!(driver.session().selection.is_empty(), "a drag is no click");
}

#[test]
fn help_lists_every_shortcut() {
    let mut driver = Driver::finished();
    driver.key(Modifiers::NONE, Key::F1);
    for verb in Verb::ALL {
        if let Some(shortcut) = verb.entry().shortcut {
            let text = verb.entry().text.trim_end_matches('…');
            assert!(driver.shows(text), "{text}");
            assert!(driver.shows(&shortcut.to_string()), "{shortcut}");
        }
    }
}

#[test]
fn escape_closes_what_is_open_before_it_deselects() {
    let mut driver = Driver::finished();
    let id = driver.session().primitives()[0].id;
    driver.press(&format!("Primitive {id}"));
    driver.key(Modifiers::NONE, Key::F1);
    assert!(driver.session().view.shows_shortcuts);
    driver.key(Modifiers::NONE, Key::Escape);
    assert!(!driver.session().view.shows_shortcuts);
    assert_eq!(driver.session().selection.len(), 1);
    driver.key(Modifiers::NONE, Key::Escape);
    assert!(driver.session().selection.is_empty());
}

#[test]
fn a_file_is_replaced_only_when_that_is_confirmed() {
    let folder = tempfile::tempdir().unwrap();
    let old = file(&folder, "out.superform", "precious");
    let mut driver = Driver::finished();
    let ask = |driver: &mut Driver| {
        driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
        driver.type_path(old.to_str().unwrap());
        driver.press("Save");
        driver.harness.run_steps(2);
        assert!(driver.shows("out.superform already exists. Replace it?"));
    };
    let until_saved = |driver: &mut Driver, path: &std::path::Path| {
        let ctx = driver.harness.ctx.clone();
        while driver.session().session_file() != Some(path) {
            let app = driver.harness.state_mut();
            assert!(app.wait_for_keeper(&ctx, PATIENCE), "the keeper is silent");
        }
    };
    ask(&mut driver);
    driver.press("Cancel");
    driver.settle();
    assert_eq!(std::fs::read_to_string(&old).unwrap(), "precious");
    ask(&mut driver);
    // Another name needs no confirmation, nor is it one.
    let other = folder.path().join("other.superform");
    driver.type_path(other.to_str().unwrap());
    driver.press("Save");
    until_saved(&mut driver, &other);
    assert!(other.exists() && std::fs::read_to_string(&old).unwrap() == "precious");
    ask(&mut driver);
    driver.press("Replace");
    until_saved(&mut driver, &old);
    assert!(std::fs::read(&old).unwrap().starts_with(b"\x89Superform"));
}

#[test]
fn shapes_that_can_hold_no_primitive_give_a_message() {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in [
        ("empty.xyz", ""),
        ("one.xyz", "1 2 3\n"),
        ("nan.xyz", "nan nan nan\n1 nan 2\n"),
        ("same.xyz", &"1 1 1\n".repeat(50)),
    ] {
        let path = file(&folder, name, content);
        let mut driver = Driver::start(options(Source::File(path)), [1024.0, 700.0]);
        driver.settle();
        assert!(driver.session().messages.open_error().is_some(), "{name} gives no message");
        assert!(driver.shows("Dismiss"), "{name}");
        assert!(!driver.is_enabled("Run"));
    }
}

/// Where a control is that a person has to reach.
fn place_of(driver: &Driver, role: Role, label: &str) -> egui::Rect {
    driver.harness.get_by_role_and_label(role, label).rect()
}

/// 1024 × 700, and 1366 × 768 at a zoom of 100, 150 and 200 %.
const SMALL: [[f32; 2]; 4] = [[1024.0, 700.0], [1366.0, 768.0], [911.0, 512.0], [683.0, 384.0]];

#[test]
fn dialogs_fit_into_small_windows_with_their_buttons() {
    for size in SMALL {
        let mut driver = Driver::start(options(Source::BuiltIn), size);
        driver.settle();
        let window = egui::Rect::from_min_size(egui::Pos2::ZERO, size.into());
        let check = |driver: &mut Driver, dialog: &str, controls: &[(Role, &str)]| {
            driver.harness.run_steps(4);
            for &(role, label) in controls {
                let place = place_of(driver, role, label);
                assert!(window.contains_rect(place), "{dialog} in {size:?}: {label} is at {place:?}");
            }
        };
        let buttons = [(Role::Button, "Export"), (Role::Button, "Cancel"), (Role::Button, "Browse…")];
        driver.key(Modifiers::COMMAND, Key::E);
        check(&mut driver, "export", &buttons);
        // Every format can be scrolled to.
        driver.harness.get_by_role_and_label(Role::Button, "Primitives as numbers, JSON").scroll_to_me();
        driver.harness.run_steps(8);
        check(&mut driver, "export", &[(Role::Button, "Primitives as numbers, JSON")]);
        driver.key(Modifiers::NONE, Key::Escape);
        driver.key(Modifiers::SHIFT, Key::F12);
        check(&mut driver, "picture", &[(Role::Button, "Choose file and save…"), (Role::Button, "Cancel")]);
        driver.key(Modifiers::NONE, Key::Escape);
        driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
        driver.harness.event(egui::Event::Text("clear recent".to_owned()));
        check(&mut driver, "commands", &[(Role::Button, "Clear recent files")]);
        driver.key(Modifiers::NONE, Key::Escape);
        driver.key(Modifiers::NONE, Key::F1);
        let scrolled = driver.harness.get_all_by_label_contains("Zoom at the pointer").next().unwrap();
        scrolled.scroll_to_me();
        driver.harness.run_steps(8);
        let last = driver.harness.get_all_by_label_contains("Zoom at the pointer").next().unwrap().rect();
        assert!(window.contains_rect(last), "help in {size:?}: its end is at {last:?}");
        driver.key(Modifiers::NONE, Key::Escape);
        driver.key(Modifiers::COMMAND, Key::O);
        check(&mut driver, "a path", &[(Role::Button, "Open"), (Role::Button, "Cancel")]);
        driver.type_path("/no/such/shape.obj");
        driver.press("Open");
        driver.settle();
        driver.press("Details");
        check(&mut driver, "an error", &[(Role::Button, "Dismiss"), (Role::Button, "Hide details")]);
    }
}

#[test]
fn a_menu_that_is_higher_than_the_window_scrolls() {
    let mut driver = Driver::start(options(Source::BuiltIn), [683.0, 384.0]);
    driver.settle();
    driver.press("Edit");
    driver.harness.run_steps(3);
    let last = Verb::ReleasePoints.entry().text;
    driver.harness.get_by_label_contains(last).scroll_to_me();
    driver.harness.run_steps(8);
    let place = driver.harness.get_by_label_contains(last).rect();
    assert!(place.max.y <= 384.0 && place.min.y > 20.0, "{last} is at {place:?}");
}

#[test]
fn a_tooltip_is_in_the_way_of_no_drag_and_no_dialog() {
    let mut driver = Driver::finished();
    let slider = place_of(&driver, Role::Slider, "Concentration α");
    let hover = |driver: &mut Driver, at: egui::Pos2| {
        driver.harness.hover_at(at + egui::vec2(1.0, 0.0));
        driver.harness.run_steps(2);
        driver.harness.hover_at(at);
        driver.harness.run_steps(60);
    };
    let tip = "of the Chinese Restaurant Process";
    hover(&mut driver, slider.center());
    assert!(driver.shows(tip));
    driver.harness.drag_at(slider.center());
    driver.harness.run_steps(2);
    assert!(!driver.shows(tip), "the slider is held");
    driver.harness.hover_at(slider.center() + egui::vec2(6.0, 0.0));
    driver.harness.run_steps(60);
    assert!(!driver.shows(tip), "the slider is dragged");
    driver.harness.drop_at(slider.center());
    driver.settle();
    hover(&mut driver, slider.center());
    assert!(driver.shows(tip), "it comes back");
    driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    driver.harness.run_steps(60);
    assert!(driver.session().window.shows_commands && !driver.shows(tip), "a dialog lies over it");
}

#[test]
fn no_contents_widen_a_panel() {
    let folder = tempfile::tempdir().unwrap();
    let points: String = (0..200).map(|i| format!("{} {} {}\n", i % 7, i % 11, i % 13)).collect();
    let long = file(&folder, &format!("{}.xyz", "a long name of a file ".repeat(8)), &points);
    for size in [[1280.0, 800.0], [900.0, 600.0], [640.0, 480.0]] {
        let mut driver = Driver::start(options(Source::File(long.clone())), size);
        driver.settle();
        driver.toggle("Live");
        let view = driver.viewport();
        driver.slide("New cluster p0", 1e-6);
        driver.slide("Concentration α", 0.001_234_567_8);
        let seed = driver.harness.get_by_role_and_label(Role::SpinButton, "Seed");
        seed.set_value_accesskit(1.8e19);
        driver.harness.run_steps(60);
        let now = driver.viewport();
        assert!((now.left() - view.left()).abs() < 0.5, "{size:?}: {view:?} became {now:?}");
        assert!((now.right() - view.right()).abs() < 0.5, "{size:?}: {view:?} became {now:?}");
        let p0 = driver.harness.get_by_role_and_label(Role::SpinButton, "New cluster p0");
        assert_eq!(p0.accesskit_node().value().as_deref(), Some("1e-6"));
    }
}
