//! Work by hand on primitives and points, through the labels that a person
//! reads. With `SUPERFORM_PICTURES` set to a folder, pictures are kept there.

use crate::driver::{Driver, Role, options};
use egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::Queryable;
use superform::inference::{Phase, Primitive, UNASSIGNED};
use superform::session::Verb;
use superform::session::camera::Camera;
use superform::session::gizmo::{Figure, Gizmo, Handle, Mode};
use superform::worker::{Activity, Cause, Source};

/// The window after its first run, with sliders that wait for the next.
fn finished() -> Driver {
    let mut driver = Driver::finished();
    driver.toggle("Live");
    driver
}

fn largest(driver: &Driver) -> Primitive {
    driver.session().primitives().iter().max_by_key(|p| p.points).unwrap().clone()
}

fn primitive(driver: &Driver, id: u32) -> Option<Primitive> {
    driver.session().primitives().iter().find(|p| p.id == id).cloned()
}

fn row(id: u32) -> String {
    format!("Primitive {id}")
}

fn set_number(driver: &mut Driver, name: &str, value: f64) {
    driver.harness.get_by_role_and_label(Role::SpinButton, name).set_value_accesskit(value);
    driver.harness.run_steps(2);
}

fn states(driver: &Driver) -> usize {
    driver.session().timeline.states().len()
}

/// Waits for the state that an edit leads to.
fn edited(driver: &mut Driver, before: usize) {
    driver.until(|s| s.timeline.states().len() > before && s.activity == Activity::Idle);
}

#[test]
fn a_number_changes_the_shape_and_undo_brings_it_back() {
    let mut driver = finished();
    let before = largest(&driver);
    let count = states(&driver);
    driver.press(&row(before.id));
    let wanted = before.shape.semi_axes.x * 1.5;
    set_number(&mut driver, "Semi-axis ax", wanted);
    edited(&mut driver, count);
    let after = primitive(&driver, before.id).unwrap();
    assert!((after.shape.semi_axes.x - wanted).abs() < 1e-9 * wanted);
    assert_eq!(after.points, before.points, "its points stay");
    assert!((after.shape.translation - before.shape.translation).norm() < 1e-9);
    assert_eq!(states(&driver), count + 1, "one state on the timeline");
    assert_eq!(driver.session().snapshot.as_ref().unwrap().cause, Cause::Edit);
    driver.key(Modifiers::COMMAND, Key::Z);
    driver.settle();
    assert_eq!(primitive(&driver, before.id).unwrap().shape, before.shape);
    driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    driver.settle();
    assert_eq!(primitive(&driver, before.id).unwrap().shape, after.shape);
}

#[test]
fn a_drag_of_a_number_is_seen_at_once_and_one_state() {
    let mut driver = finished();
    let before = largest(&driver);
    let count = states(&driver);
    driver.press(&row(before.id));
    let number = driver.harness.get_by_role_and_label(Role::SpinButton, "Rotation about z");
    let start = number.rect().center();
    driver.harness.drag_at(start);
    driver.harness.run_steps(1);
    let mut seen = Vec::new();
    for i in 1..=12 {
        driver.harness.hover_at(start + vec2(8.0 * i as f32, 0.0));
        driver.harness.run_steps(1);
        seen.extend(driver.session().draft().map(|(_, shape)| *shape));
    }
    assert!(seen.len() > 8, "it is seen while it is dragged");
    assert!(driver.shows("editing"));
    assert_eq!(states(&driver), count, "nothing is sent before the hand lets go");
    driver.harness.drop_at(start + vec2(96.0, 0.0));
    driver.harness.run_steps(2);
    edited(&mut driver, count);
    assert_eq!(states(&driver), count + 1);
    let after = primitive(&driver, before.id).unwrap();
    let turned = before.shape.rotation.angle_to(&after.shape.rotation).to_degrees();
    assert!((20.0..70.0).contains(&turned), "{turned}");
    assert!(driver.session().draft().is_none());
    let undone = driver.session().undo.done().len();
    driver.key(Modifiers::COMMAND, Key::Z);
    driver.settle();
    assert_eq!(primitive(&driver, before.id).unwrap().shape, before.shape);
    assert_eq!(driver.session().undo.done().len(), undone - 1, "one step");
}

#[test]
fn escape_gives_a_dragged_shape_back() {
    let mut driver = finished();
    let before = largest(&driver);
    let count = states(&driver);
    driver.press(&row(before.id));
    let start = driver.harness.get_by_role_and_label(Role::SpinButton, "Taper kx").rect().center();
    driver.harness.drag_at(start);
    driver.harness.run_steps(1);
    driver.harness.hover_at(start + vec2(60.0, 0.0));
    driver.harness.run_steps(1);
    assert!(driver.session().is_shaping());
    driver.key(Modifiers::NONE, Key::Escape);
    assert!(driver.session().draft().is_none());
    driver.harness.hover_at(start + vec2(80.0, 0.0));
    driver.harness.run_steps(1);
    driver.harness.drop_at(start + vec2(80.0, 0.0));
    driver.harness.run_steps(2);
    driver.settle();
    assert_eq!(states(&driver), count, "nothing was changed");
    assert_eq!(driver.session().selection, [before.id].into(), "and it is still selected");
}

#[test]
fn numbers_keep_their_limits() {
    let mut driver = finished();
    let id = largest(&driver).id;
    driver.press(&row(id));
    for (name, value) in [("Exponent ε1", 7.0), ("Taper ky", -4.0)] {
        let count = states(&driver);
        set_number(&mut driver, name, value);
        edited(&mut driver, count);
    }
    let shape = primitive(&driver, id).unwrap().shape;
    assert!(shape.exponents[0] < 2.0 && shape.exponents[0] > 1.5);
    assert!((-1.0..-0.9).contains(&shape.taper[1]));
    assert!(driver.session().messages.open_error().is_none());
}

#[test]
fn locked_ones_stay_bit_for_bit_when_the_run_starts_over() {
    let mut driver = finished();
    let id = largest(&driver).id;
    driver.press(&row(id));
    let count = states(&driver);
    driver.press("Lock");
    edited(&mut driver, count);
    assert!(driver.shows("locked: the sampler will not change it"));
    let locked = primitive(&driver, id).unwrap();
    assert!(locked.locked);
    let samples = |driver: &Driver| -> Vec<usize> {
        let labels = &driver.session().snapshot.as_ref().unwrap().abstraction.labels;
        labels.iter().enumerate().filter(|(_, l)| **l == id).map(|(i, _)| i).collect()
    };
    let held = samples(&driver);
    // Its numbers and what would change it can't be had.
    for button in ["Refit", "Split", "Delete"] {
        assert!(!driver.is_enabled(button), "{button}");
    }
    // Also by key, which says why, and says it once.
    for times in ["Delete", "Delete (×2)"] {
        driver.key(Modifiers::NONE, Key::Delete);
        assert!(driver.shows("Unlock the primitive first") && driver.shows(times), "{times}");
        assert_eq!(driver.harness.query_all_by_label_contains("Unlock the primitive first").count(), 1);
    }
    driver.press("Reset");
    driver.settle();
    assert_eq!(driver.session().phase(), Some(Phase::Start));
    let same = |driver: &Driver, when: &str| {
        let now = primitive(driver, id).unwrap();
        assert_eq!((now.shape, now.sigma, now.locked), (locked.shape, locked.sigma, true), "{when}");
        let now = samples(driver);
        assert!(held.iter().all(|i| now.binary_search(i).is_ok()), "{when}");
    };
    same(&driver, "after Reset");
    driver.press("Run");
    driver.settle();
    assert_eq!(driver.session().phase(), Some(Phase::Finished));
    same(&driver, "after the run");
    assert!(driver.session().is_enabled(Verb::Continue));
    driver.key(Modifiers::SHIFT, Key::Space);
    driver.settle();
    same(&driver, "after Continue");
    driver.toggle("Live");
    driver.slide("Concentration α", 2.0);
    driver.settle();
    same(&driver, "after Live");
}

#[test]
fn primitives_are_split_refitted_merged_and_deleted() {
    let mut driver = finished();
    let id = largest(&driver).id;
    let k = driver.session().primitives().len();
    let count = states(&driver);
    driver.press(&row(id));
    driver.press("Split");
    edited(&mut driver, count);
    assert_eq!(driver.session().primitives().len(), k + 1);
    assert!(driver.shows("split into"));
    let parts: Vec<u32> = driver.session().selection.iter().copied().collect();
    assert_eq!(parts.len(), 2, "both halves are selected");
    driver.press("Merge");
    edited(&mut driver, count + 1);
    assert_eq!(driver.session().primitives().len(), k);
    assert_eq!(driver.session().selection.len(), 1, "what they became");
    let joined = *driver.session().selection.first().unwrap();
    set_number(&mut driver, "Exponent ε1", 1.7);
    edited(&mut driver, count + 2);
    let spoilt = primitive(&driver, joined).unwrap();
    driver.press("Refit");
    edited(&mut driver, count + 3);
    let refitted = primitive(&driver, joined).unwrap();
    assert!(refitted.mean_distance < spoilt.mean_distance);
    driver.press("Delete");
    edited(&mut driver, count + 4);
    assert_eq!(driver.session().primitives().len(), k - 1);
    let labels = &driver.session().snapshot.as_ref().unwrap().abstraction.labels;
    assert!(labels.iter().filter(|l| **l == UNASSIGNED).count() >= refitted.points);
    for _ in 0..5 {
        driver.key(Modifiers::COMMAND, Key::Z);
        driver.settle();
    }
    assert_eq!(driver.session().primitives().len(), k);
}

#[test]
fn the_sampler_goes_on_from_an_edited_state() {
    let mut driver = finished();
    let id = largest(&driver).id;
    driver.press(&row(id));
    let count = states(&driver);
    driver.press("Delete");
    edited(&mut driver, count);
    let (iteration, k) = (driver.iteration(), driver.session().primitives().len());
    driver.key(Modifiers::SHIFT, Key::Space);
    driver.settle();
    assert_eq!(driver.session().phase(), Some(Phase::Finished));
    assert!(driver.iteration() > iteration, "it went on");
    assert_eq!(driver.session().timeline.states()[count].abstraction.primitives.len(), k);
    let labels = &driver.session().snapshot.as_ref().unwrap().abstraction.labels;
    let lost = labels.iter().filter(|l| **l == UNASSIGNED).count();
    assert!(lost < labels.len() / 20, "the points have found primitives again: {lost}");
}

#[test]
fn edits_are_made_in_the_middle_of_a_run() {
    let mut options = options(Source::BuiltIn);
    options.params.iterations = 400;
    let mut driver = Driver::start(options, [1280.0, 800.0]);
    driver.toggle("Live");
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| s.abstraction.iteration >= 2));
    // While it goes on.
    let id = largest(&driver).id;
    driver.press(&row(id));
    driver.key(Modifiers::NONE, Key::K);
    driver.until(|s| s.primitives().iter().any(|p| p.id == id && p.locked));
    // It goes on, after a moment.
    driver.until(|s| s.activity == Activity::Running);
    let locked = primitive(&driver, id).unwrap();
    let iteration = driver.iteration();
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| s.abstraction.iteration >= iteration + 2));
    assert_eq!(primitive(&driver, id).unwrap().shape, locked.shape);
    // While it is paused.
    driver.press("Pause");
    driver.settle();
    let other = driver.session().primitives().iter().filter(|p| p.id != id).max_by_key(|p| p.points);
    let other = other.unwrap().id;
    let (count, iteration) = (states(&driver), driver.iteration());
    driver.press(&row(other));
    driver.press("Delete");
    edited(&mut driver, count);
    assert!(primitive(&driver, other).is_none());
    driver.press("Step iteration");
    driver.settle();
    assert_eq!(driver.iteration(), iteration + 1);
    assert_eq!(primitive(&driver, id).unwrap().shape, locked.shape);
}

#[test]
fn the_list_selects_ranges_sorts_and_follows_the_arrows() {
    let mut driver = finished();
    driver.press("Sort by id");
    let ids: Vec<u32> = {
        let mut ids: Vec<u32> = driver.session().primitives().iter().map(|p| p.id).collect();
        ids.sort_unstable();
        ids
    };
    assert!(ids.len() >= 4);
    driver.press(&row(ids[0]));
    driver.click_with(&row(ids[2]), Modifiers::SHIFT);
    assert_eq!(driver.session().selection, ids[..3].iter().copied().collect());
    driver.click_with(&row(ids[1]), Modifiers::COMMAND);
    assert_eq!(driver.session().selection, [ids[0], ids[2]].into());
    assert!(driver.shows("2 primitives selected"));
    driver.press(&row(ids[1]));
    driver.key(Modifiers::NONE, Key::ArrowDown);
    assert_eq!(driver.session().selection, [ids[2]].into());
    driver.key(Modifiers::SHIFT, Key::ArrowDown);
    assert_eq!(driver.session().selection, [ids[2], ids[3]].into());
    driver.press("Sort by points");
    let rows: Vec<f32> = {
        let mut by_points: Vec<&Primitive> = driver.session().primitives().iter().collect();
        by_points.sort_by_key(|p| (std::cmp::Reverse(p.points), p.id));
        let visible = by_points.iter().filter_map(|p| {
            let name = row(p.id);
            let row = driver.harness.query_by_role_and_label(Role::Button, &name)?;
            Some(row.rect().top())
        });
        visible.collect()
    };
    assert!(rows.len() >= 3 && rows.is_sorted(), "largest first: {rows:?}");
}

#[test]
fn a_box_of_points_becomes_a_primitive() {
    let mut driver = finished();
    let k = driver.session().primitives().len();
    let count = states(&driver);
    driver.press("Select points");
    driver.press("Box select");
    let view = driver.viewport();
    let (from, to) = (view.lerp_inside(vec2(0.3, 0.2)), view.lerp_inside(vec2(0.7, 0.5)));
    driver.drag(from, to);
    let selected = driver.session().selected_points.len();
    assert!(selected > 30, "{selected}");
    assert!(driver.shows("points selected"));
    driver.press("New cluster");
    edited(&mut driver, count);
    let made = *driver.session().selection.first().unwrap();
    assert_eq!(primitive(&driver, made).unwrap().points, selected);
    assert!(driver.shows(&format!("Primitive {made} created from")));
    assert!(driver.session().selected_points.is_empty());
    assert!(driver.session().primitives().len() <= k + 1);
}

#[test]
fn points_that_belong_together_are_pinned_until_they_are_released() {
    let mut driver = finished();
    let count = states(&driver);
    driver.press("Select points");
    driver.press("Box select");
    let view = driver.viewport();
    driver.drag(view.lerp_inside(vec2(0.35, 0.55)), view.lerp_inside(vec2(0.65, 0.95)));
    let selected = driver.session().selected_points.to_vec();
    assert!(selected.len() > 20, "{}", selected.len());
    driver.press("Pin to one cluster");
    edited(&mut driver, count);
    let snapshot = driver.session().snapshot.clone().unwrap();
    let labels = &snapshot.abstraction.labels;
    let into = labels[selected[0] as usize];
    assert!(selected.iter().all(|i| labels[*i as usize] == into), "one primitive holds them");
    assert_eq!(snapshot.abstraction.pinned.to_vec(), selected);
    assert!(driver.shows("pinned to their primitive"));
    driver.key(Modifiers::SHIFT, Key::Space);
    driver.settle();
    let labels = driver.session().snapshot.as_ref().unwrap().abstraction.labels.clone();
    assert!(selected.iter().all(|i| labels[*i as usize] == labels[selected[0] as usize]), "still together");
    let count = states(&driver);
    driver.press("Unpin");
    edited(&mut driver, count);
    assert!(driver.session().snapshot.as_ref().unwrap().abstraction.pinned.is_empty());
    assert!(!driver.session().is_enabled(Verb::ReleasePoints));
}

/// Where a handle of the selected primitive can be taken hold of, and which way
/// it goes, in logical pixels of the window.
fn handle_at(driver: &Driver, handle: Handle) -> (egui::Pos2, egui::Vec2) {
    let session = driver.session();
    let view = driver.viewport();
    let shape = session.scene.shape(&session.selected_primitive().unwrap().shape);
    let size = nalgebra::Vector2::new(f64::from(view.width()), f64::from(view.height()));
    let gizmo = Gizmo::new(shape, session.handles.unwrap(), &session.camera, size);
    let part = gizmo.parts().into_iter().find(|p| p.handle == handle).unwrap();
    let at = |p: nalgebra::Vector2<f64>| view.min + vec2(p.x as f32, p.y as f32);
    match part.figure {
        Figure::Arrow(from, to) => (at(from + (to - from) * 0.85), (at(to) - at(from)).normalized()),
        Figure::Knob { from, at: knob } => (at(knob), (at(knob) - at(from)).normalized()),
        figure => panic!("{figure:?}"),
    }
}

/// Whether nobody has moved the camera; the form of its picture may differ.
fn same_view(a: &Camera, b: &Camera) -> bool {
    Camera { aspect: b.aspect, ..*a } == *b
}

#[test]
fn handles_in_the_view_move_scale_and_taper() {
    let mut driver = finished();
    let id = largest(&driver).id;
    driver.press(&row(id));
    for (verb, handle) in [
        ("Move", Handle::MoveAxis(0)),
        ("Scale", Handle::ScaleAxis(1)),
        ("Taper", Handle::Taper(1)),
        ("Round", Handle::Exponent(1)),
    ] {
        let before = primitive(&driver, id).unwrap().shape;
        let (count, camera) = (states(&driver), driver.session().camera);
        driver.press(verb);
        let (at, along) = handle_at(&driver, handle);
        driver.drag(at, at + along * 30.0);
        edited(&mut driver, count);
        let after = primitive(&driver, id).unwrap().shape;
        assert!(same_view(&driver.session().camera, &camera), "{verb} does not orbit");
        assert_eq!(states(&driver), count + 1, "{verb} is one state");
        match handle {
            Handle::MoveAxis(_) => {
                let local = before.rotation.inverse() * (after.translation - before.translation);
                assert!(local.x > 0.0 && local.yz().norm() < 1e-6 * local.x, "{local}");
            }
            Handle::ScaleAxis(_) => assert!(after.semi_axes.y > before.semi_axes.y * 1.02),
            Handle::Taper(_) => assert_ne!(after.taper[1], before.taper[1]),
            _ => assert_ne!(after.exponents[1], before.exponents[1]),
        }
    }
    assert_eq!(driver.session().handles, Some(Mode::Roundness));
    driver.key(Modifiers::NONE, Key::O);
    assert_eq!(driver.session().handles, None, "the same key puts them away");
}

#[test]
fn escape_ends_the_drag_of_a_handle() {
    let mut driver = finished();
    let before = largest(&driver);
    let count = states(&driver);
    driver.press(&row(before.id));
    driver.key(Modifiers::NONE, Key::V);
    let (at, along) = handle_at(&driver, Handle::MoveAxis(2));
    driver.harness.hover_at(at);
    driver.harness.run_steps(1);
    driver.harness.drag_at(at);
    driver.harness.run_steps(1);
    for i in 1..=4 {
        driver.harness.hover_at(at + along * (8.0 * i as f32));
        driver.harness.run_steps(1);
    }
    assert!(driver.session().is_shaping());
    driver.key(Modifiers::NONE, Key::Escape);
    assert!(driver.session().draft().is_none());
    let camera = driver.session().camera;
    driver.harness.hover_at(at + along * 60.0);
    driver.harness.run_steps(2);
    driver.harness.drop_at(at + along * 60.0);
    driver.harness.run_steps(2);
    driver.settle();
    assert!(same_view(&driver.session().camera, &camera), "the rest of the drag moves nothing");
    assert_eq!((states(&driver), driver.session().draft().is_none()), (count, true));
    assert_eq!(driver.session().selection, [before.id].into());
}
