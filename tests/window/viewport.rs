//! The viewport's bar, tools, axes and colours, by the labels a person sees and
//! real drags over the picture.

use crate::driver::{Driver, Role, file, options};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use superform::session::camera::AxisView;
use superform::session::view::{ColorBy, Picks, Tool};
use superform::worker::Source;

/// Presses, moves along the path and lets go, with these keys held.
fn drag(driver: &mut Driver, path: &[Pos2], modifiers: Modifiers) {
    let button =
        |pos, pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers };
    driver.harness.event(Event::ModifiersChanged(modifiers));
    driver.harness.event(Event::PointerMoved(path[0]));
    driver.harness.event(button(path[0], true));
    driver.harness.step();
    for &at in path {
        driver.harness.event(Event::PointerMoved(at));
        driver.harness.step();
    }
    driver.harness.event(button(path[path.len() - 1], false));
    driver.harness.step();
    driver.harness.event(Event::ModifiersChanged(Modifiers::NONE));
    driver.harness.run_steps(2);
}

fn whole(view: Rect) -> [Pos2; 2] {
    [view.left_bottom() + vec2(4.0, -4.0), view.right_top() + vec2(-4.0, 110.0)]
}

fn is_on(driver: &Driver, label: &str) -> bool {
    let node = driver.harness.get_by_role_and_label(Role::Button, label);
    node.accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)
}

/// Where a sample is seen, in the window.
fn place(driver: &Driver, sample: usize) -> Pos2 {
    let session = driver.session();
    let loaded = session.loaded.as_ref().unwrap();
    let seen = session.camera.project(&session.scene.point(&loaded.cloud.points[sample])).unwrap();
    let view = driver.viewport();
    view.center() + 0.5 * view.size() * vec2(seen.x as f32, -seen.y as f32)
}

#[test]
fn a_box_selects_the_points_in_it_and_keys_add_and_take_away() {
    let mut driver = Driver::finished();
    driver.key(Modifiers::NONE, Key::P);
    assert_eq!(driver.session().view.picks, Picks::Points);
    driver.press("Box select");
    assert_eq!(driver.session().view.tool, Tool::Box);
    assert!(is_on(&driver, "Box select") && !is_on(&driver, "Click select"));
    let view = driver.viewport();
    let camera = driver.session().camera;
    let left = Rect::from_min_max(view.min, pos2(view.center().x, view.bottom() - 5.0));
    drag(&mut driver, &[left.min + vec2(3.0, 3.0), left.center(), left.max], Modifiers::NONE);
    assert_eq!(driver.session().camera, camera, "a drag with a tool doesn't turn the view");
    let count = driver.session().loaded.as_ref().unwrap().cloud.points.len();
    let expected: Vec<u32> = (0..count as u32)
        .filter(|&i| {
            let at = place(&driver, i as usize);
            at.x > left.left() + 3.0 && at.x < left.right() && at.y < left.bottom()
        })
        .collect();
    assert!(expected.len() > 50 && expected.len() < count, "{} of {count}", expected.len());
    assert_eq!(driver.session().selected_points.to_vec(), expected);
    // All but a strip at the top, which is taken away again.
    drag(&mut driver, &whole(view), Modifiers::SHIFT);
    let all = driver.session().selected_points.len();
    assert!(all > expected.len());
    drag(&mut driver, &[left.min + vec2(3.0, 3.0), left.center(), left.max], Modifiers::COMMAND);
    assert_eq!(driver.session().selected_points.len(), all - expected.len());
    assert!(driver.session().selection.is_empty(), "no primitive was meant");
    // Alt orbits all the same, Escape ends the tool, then the selection.
    drag(&mut driver, &[view.center(), view.center() + vec2(30.0, 0.0)], Modifiers::ALT);
    assert_ne!(driver.session().camera, camera);
    driver.key(Modifiers::NONE, Key::Escape);
    assert_eq!(driver.session().view.tool, Tool::Click);
    assert!(!driver.session().selected_points.is_empty());
    driver.key(Modifiers::NONE, Key::Escape);
    assert!(driver.session().selected_points.is_empty());
}

#[test]
fn a_lasso_selects_primitives_and_is_undone() {
    let mut driver = Driver::finished();
    driver.key(Modifiers::SHIFT, Key::B);
    assert_eq!(driver.session().view.tool, Tool::Lasso);
    let view = driver.viewport();
    let [a, b] = whole(view);
    let around = [a, pos2(a.x, b.y), b, pos2(b.x, a.y), a];
    drag(&mut driver, &around, Modifiers::NONE);
    assert_eq!(driver.session().selection.len(), driver.session().primitives().len());
    driver.key(Modifiers::COMMAND, Key::Z);
    assert!(driver.session().selection.is_empty(), "selecting is a step of undo");
    // Around nothing.
    let corner = a + vec2(30.0, -30.0);
    drag(&mut driver, &[a, a + vec2(30.0, 0.0), corner, a], Modifiers::NONE);
    assert!(driver.session().selection.is_empty());
}

#[test]
fn the_axes_are_buttons_and_a_drag_on_them_orbits() {
    let mut driver = Driver::finished();
    let (target, distance) = (driver.session().camera.target, driver.session().camera.distance);
    driver.press("3D view from +x");
    assert_eq!(driver.session().camera.axis_view(), Some(AxisView::Right));
    // Who is there already gets to the other side.
    driver.press("3D view from +x");
    assert_eq!(driver.session().camera.axis_view(), Some(AxisView::Left));
    driver.press("3D view from +y");
    assert_eq!(driver.session().camera.axis_view(), Some(AxisView::Top));
    driver.press("View");
    driver.harness.get_by_role_and_label(Role::Button, "Up axis").hover();
    driver.harness.run_steps(3);
    driver.harness.get_by_role_and_label(Role::RadioButton, "Z is up").click();
    driver.harness.run_steps(3);
    driver.key(Modifiers::NONE, Key::Num1);
    driver.press("3D view from +z");
    assert_eq!(driver.session().camera.axis_view(), Some(AxisView::Top), "z is up now");
    driver.key(Modifiers::COMMAND, Key::Num1);
    assert_eq!(driver.session().camera.axis_view(), Some(AxisView::Back));
    let camera = driver.session().camera;
    assert!((camera.target - target).norm() < 0.2 && (camera.distance / distance - 1.0).abs() < 0.5);
    let ball = driver.harness.get_by_role_and_label(Role::Button, "3D view from +z").rect().center();
    drag(&mut driver, &[ball, ball + vec2(5.0, 8.0), ball + vec2(12.0, 14.0)], Modifiers::NONE);
    assert!(driver.session().camera.pitch.abs() > 0.02);
}

#[test]
fn colours_tell_what_was_chosen() {
    let mut driver = Driver::finished();
    for by in [ColorBy::OwnDistance, ColorBy::NearestDistance, ColorBy::Plain, ColorBy::Cluster] {
        driver.choose("Colour by", by.text());
        assert_eq!(driver.session().view.color_by, by);
    }
    assert!(driver.shows("Scale bar:"));
}

#[test]
fn colours_of_the_file_can_be_chosen_where_it_has_some() {
    let folder = tempfile::tempdir().unwrap();
    let mut ply = String::from(
        "ply\nformat ascii 1.0\nelement vertex 300\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
    );
    for i in 0..300 {
        let (a, z) = (f64::from(i) * 2.4, f64::from(i) / 150.0 - 1.0);
        let r = (1.0 - z * z).max(0.0).sqrt();
        ply.push_str(&format!("{} {} {z} 200 {} 0\n", r * a.cos(), r * a.sin(), i % 256));
    }
    let path = file(&folder, "colours.ply", &ply);
    let mut driver = Driver::start(options(Source::File(path)), [1280.0, 800.0]);
    driver.settle();
    driver.choose("Colour by", "Input colour");
    assert_eq!(driver.session().view.color_by, ColorBy::Input);
    let mut without = Driver::finished();
    without.harness.get_by_role_and_label(Role::ComboBox, "Colour by").click();
    without.harness.run_steps(3);
    assert!(!without.is_enabled("Input colour"), "the chair has no colours");
}

#[test]
fn nothing_of_the_bar_is_cut_off_in_a_small_window() {
    for size in [[1024.0, 700.0], [960.0, 640.0]] {
        let mut driver = Driver::start(options(Source::BuiltIn), size);
        driver.settle();
        let view = driver.viewport();
        let bar = Rect::from_x_y_ranges(view.x_range(), 0.0..=view.top() + 0.5);
        for (role, label) in [
            (Role::Button, "Click select"),
            (Role::Button, "Box select"),
            (Role::Button, "Lasso select"),
            (Role::Button, "Select primitives"),
            (Role::Button, "Select points"),
            (Role::ComboBox, "Colour by"),
            (Role::ComboBox, "Surface style"),
            (Role::Button, "Show"),
        ] {
            let rect = driver.harness.get_by_role_and_label(role, label).rect();
            assert!(bar.contains_rect(rect), "{label} at {rect:?} in {bar:?}");
        }
    }
}
