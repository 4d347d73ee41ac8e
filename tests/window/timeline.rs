//! The timeline, its branches and undo, as a person uses them.

use std::sync::Arc;

use crate::driver::{Driver, Role, file, options};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use superform::inference::{Phase, disagreement};
use superform::worker::{Activity, Snapshot, Source};

fn shown(driver: &Driver) -> Arc<Snapshot> {
    Arc::clone(driver.session().snapshot.as_ref().unwrap())
}

fn keys(driver: &Driver, branch: usize) -> Vec<u64> {
    driver.session().timeline.branches()[branch].states.iter().map(|s| s.key).collect()
}

fn undo(driver: &mut Driver) {
    driver.key(Modifiers::COMMAND, Key::Z);
    driver.settle();
}

/// Waits for the end of a run that goes on from another state: the worker is
/// idle for a moment once it is there.
fn finish(driver: &mut Driver) {
    driver.harness.run_steps(2);
    driver.until(|s| s.activity == Activity::Idle && s.phase() == Some(Phase::Finished));
}

/// A finished run, and a branch that left it at its fourth state.
fn branched() -> Driver {
    branched_in([1280.0, 800.0])
}

fn branched_in(size: [f32; 2]) -> Driver {
    let mut driver = Driver::start(options(Source::BuiltIn), size);
    driver.settle();
    driver.slide("Shown state", 4.0);
    driver.press("Continue from here");
    finish(&mut driver);
    driver
}

#[test]
fn scrubbing_shows_the_whole_state() {
    let mut driver = Driver::finished();
    let states = driver.session().timeline.states().to_vec();
    for index in [2, 0, 4, states.len() - 1] {
        driver.slide("Shown state", (index + 1) as f64);
        let (state, now) = (&states[index], shown(&driver));
        assert!(Arc::ptr_eq(state, &now), "labels, primitives and figures are those of the state");
        assert!(driver.shows(&format!("Iteration {} of", state.abstraction.iteration)));
        assert!(driver.shows(&format!("{} primitives", state.abstraction.primitives.len())));
        let largest = state.abstraction.primitives.iter().max_by_key(|p| p.points).unwrap();
        assert!(driver.has_button(&format!("Primitive {}", largest.id)));
    }
    driver.press("First state");
    assert_eq!(driver.iteration(), 0);
    driver.press("Next state");
    driver.key(Modifiers::NONE, Key::ArrowRight);
    assert_eq!(driver.session().timeline.shown_index(), 2);
    driver.press("Last state");
    assert!(driver.session().timeline.is_at_end() && !driver.is_enabled("Next state"));
}

#[test]
fn a_click_on_a_plot_or_the_lane_jumps_and_hovering_tells() {
    let mut driver = Driver::finished();
    let count = driver.session().timeline.states().len();
    for label in ["Primitives K over the states", "States of Main"] {
        let rect = driver.harness.get_by_role_and_label(Role::Image, label).rect();
        for (share, expected) in [(0.01, 0), (0.99, count - 1)] {
            let at = egui::pos2(rect.left() + share * rect.width(), rect.top() + 8.0);
            driver.harness.hover_at(at);
            driver.harness.run_steps(3);
            assert!(driver.shows(&format!("state {} of {count}", expected + 1)), "{label}");
            driver.harness.drag_at(at);
            driver.harness.run_steps(2);
            driver.harness.drop_at(at);
            driver.harness.run_steps(2);
            assert_eq!(driver.session().timeline.shown_index(), expected, "{label}");
        }
    }
}

#[test]
fn playing_reaches_the_end() {
    let mut driver = Driver::finished();
    driver.choose("Play speed", "2 per second");
    driver.press("First state");
    driver.press("Play");
    assert!(driver.has_button("Stop playback") && !driver.has_button("Play"));
    let mut seen = vec![driver.session().timeline.shown_index()];
    for _ in 0..400 {
        driver.harness.step();
        let index = driver.session().timeline.shown_index();
        if seen.last() != Some(&index) {
            seen.push(index);
        }
        if !driver.session().playback.is_playing {
            break;
        }
    }
    driver.harness.run_steps(2);
    assert!(driver.session().timeline.is_at_end() && driver.has_button("Play"), "{seen:?}");
    assert!(seen.windows(2).all(|w| w[1] == w[0] + 1), "no state was left out: {seen:?}");
}

#[test]
fn continuing_from_here_makes_a_branch_and_leaves_the_other() {
    let mut driver = Driver::finished();
    let before = keys(&driver, 0);
    driver.slide("Shown state", 4.0);
    driver.press("Continue from here");
    finish(&mut driver);
    assert_eq!(keys(&driver, 0), before, "nothing is lost");
    let branch = driver.session().timeline.current().unwrap();
    assert_eq!((branch.name.as_str(), branch.origin.unwrap().index), ("Branch 1", 3));
    assert_eq!(keys(&driver, 1)[..4], before[..4]);
    assert!(keys(&driver, 1).len() > 4 && keys(&driver, 1)[4] != before[4]);
    assert_eq!(driver.iteration(), 6);
    driver.press("Main");
    assert_eq!(shown(&driver).key, *before.last().unwrap());
    undo(&mut driver);
    assert_eq!(driver.session().timeline.branches().len(), 1, "the branch was undone");
}

/// Also in a low panel, and with the marks of merges and edits.
#[test]
fn curves_stay_with_two_branches() {
    let heights = |driver: &Driver| -> Vec<f32> {
        ["Primitives K", "Mean error", "Chamfer-L1"]
            .iter()
            .map(|curve| {
                let label = format!("{curve} over the states");
                let plot = driver.harness.query_by_role_and_label(Role::Image, &label);
                plot.map_or(0.0, |plot| plot.rect().height())
            })
            .collect()
    };
    // The lowest panel is some 180 high.
    for size in [[1280.0, 800.0], [1024.0, 700.0], [910.0, 530.0]] {
        let mut driver = branched_in(size);
        driver.harness.run_steps(4);
        let two = heights(&driver);
        assert!(two.iter().all(|h| *h >= 21.0), "{size:?}: {two:?}");
        let id = driver.session().primitives()[0].id;
        driver.press(&format!("Primitive {id}"));
        driver.key(Modifiers::NONE, Key::K);
        driver.settle();
        assert!(driver.shows("Iteration 6 of 6 · edit"), "{size:?}");
        let edited = heights(&driver);
        assert!(edited.iter().all(|h| *h >= 21.0), "{size:?}: {edited:?}");
    }
}

#[test]
fn states_after_merges_and_edits_have_names_of_their_own() {
    let mut driver = Driver::finished();
    assert!(driver.shows("Iteration 6 of 6 · refined"));
    driver.press("Step merge");
    driver.until(|s| s.proposal.is_some());
    driver.key(Modifiers::NONE, Key::Enter);
    driver.until(|s| s.timeline.shown_name().short() == "6 · merge");
    assert!(driver.shows("Iteration 6 of 6 · merge"));
    driver.until(|s| !s.is_judging() || s.proposal.is_some());
    driver.press("Compare");
    driver.press("End of this branch");
    assert!(driver.shows("A Main, Iteration 6 · merge, K"));
    driver.slide("State of B", 6.0);
    assert!(driver.shows("B Main, Iteration 6, K"));
    driver.slide("State of B", 7.0);
    assert!(driver.shows("B Main, Iteration 6 · refined, K"));
}

#[test]
fn a_branch_is_renamed_and_removed_and_both_are_undone() {
    let mut driver = branched();
    driver.press("More about Branch 1");
    driver.press("Rename");
    let field = driver.harness.get_by_role_and_label(Role::TextInput, "Branch name");
    field.set_text_value_accesskit("Thin legs");
    driver.harness.run_steps(2);
    driver.key(Modifiers::NONE, Key::Enter);
    assert!(driver.has_button("Thin legs"));
    driver.press("More about Thin legs");
    driver.press("Remove");
    assert!(!driver.has_button("Thin legs"));
    undo(&mut driver);
    assert!(driver.has_button("Thin legs"));
    undo(&mut driver);
    assert!(driver.has_button("Branch 1"));
}

#[test]
fn two_states_are_compared_and_what_differs_is_counted() {
    let mut driver = branched();
    driver.press("Compare");
    driver.press("Start of this branch");
    let start = Arc::clone(&driver.session().timeline.states()[0]);
    let (here, there) = (shown(&driver), start);
    let marks = disagreement(&here.abstraction.labels, &there.abstraction.labels);
    let share = 100.0 * marks.iter().filter(|m| **m).count() as f64 / marks.len() as f64;
    assert!(share > 0.0, "a start is no result");
    assert!(driver.shows(&format!("Disagreement {share:.1} %")));
    assert!(driver.shows("B Branch 1, Iteration 0, K 12"));
    assert!(
        driver.shows(&format!("A Branch 1, Iteration 6 · refined, K {}", here.abstraction.primitives.len()))
    );
    driver.press("A | B");
    assert!(driver.shows("Computing time"));
    driver.key(Modifiers::NONE, Key::Escape);

    // Another branch; the same states are no disagreement.
    driver.slide("State of B", driver.session().timeline.states().len() as f64 - 1.0);
    assert!(driver.shows("Disagreement 0.0 %"));
    driver.harness.get_by_role_and_label(Role::ComboBox, "Compare with").click();
    driver.harness.run_steps(3);
    // The entry lies above the branch's own button.
    let entries: Vec<_> = driver.harness.query_all_by_role_and_label(Role::Button, "Main").collect();
    let top = |node: &egui_kittest::Node<'_>| node.rect().top();
    entries.iter().min_by(|a, b| top(a).total_cmp(&top(b))).unwrap().click();
    driver.harness.run_steps(3);
    assert!(driver.shows("B Main, Iteration 6"));

    // Linked, then each on its own.
    let turn = |driver: &mut Driver| {
        let view = driver.harness.get_by_role_and_label(Role::Image, "3D view of the other state").rect();
        driver.harness.drag_at(view.center());
        driver.harness.hover_at(view.center() + egui::vec2(40.0, 0.0));
        driver.harness.run_steps(2);
        driver.harness.drop_at(view.center() + egui::vec2(40.0, 0.0));
        driver.harness.run_steps(2);
    };
    let before = driver.session().camera;
    turn(&mut driver);
    let linked = driver.session().camera;
    assert_ne!(linked.yaw, before.yaw);
    driver.toggle("Link cameras");
    turn(&mut driver);
    assert_eq!(driver.session().camera.yaw, linked.yaw);
    assert_ne!(driver.session().other_camera.yaw, linked.yaw);
    driver.press("Stop comparing");
    assert!(driver.harness.query_by_role_and_label(Role::Image, "3D view of the other state").is_none());
}

#[test]
fn the_chamfer_distance_of_every_state_comes_by_and_by() {
    let mut driver = Driver::finished();
    driver.until(|s| {
        let states = s.timeline.states();
        s.measurement().is_some() && states.iter().all(|state| s.chamfer_of(state.key).is_some())
    });
    let session = driver.session();
    let value = |index: usize| session.chamfer_of(session.timeline.states()[index].key).unwrap();
    let last = session.timeline.states().len() - 1;
    assert!(!value(last).is_rough && value(0).is_rough);
    assert!(value(0).value > value(last).value, "a start is worse than a result");
    let text = format!("{:.5}", value(last).value);
    assert!(driver.shows(&text));
    driver.slide("Shown state", 3.0);
    assert!(driver.shows("≈ "), "an estimate says so");
}

#[test]
fn the_edit_menu_says_what_is_undone_and_goes_back_several_steps() {
    let mut driver = Driver::finished();
    let ids: Vec<u32> = driver.session().primitives().iter().map(|p| p.id).collect();
    let first = *ids
        .iter()
        .max_by_key(|id| driver.session().primitives().iter().find(|p| p.id == **id).map_or(0, |p| p.points))
        .unwrap();
    driver.press(&format!("Primitive {first}"));
    // The list makes room for the numbers.
    driver.harness.run_steps(4);
    driver.toggle(&format!("Primitive {first} in the viewport"));
    driver.press("Edit");
    // The shortcut is a part of the entry.
    assert!(driver.shows("Undo show or hide"));
    driver.key(Modifiers::NONE, Key::Escape);
    undo(&mut driver);
    driver.press("Edit");
    assert!(driver.shows("Undo select") && driver.shows("Redo show or hide"));
    driver.harness.get_by_role_and_label(Role::Button, "History").hover();
    driver.harness.run_steps(3);
    driver.press("Beginning");
    driver.settle();
    assert!(driver.session().selection.is_empty() && driver.session().undo.done().is_empty());
}

#[test]
fn undoing_another_file_brings_the_old_shape_with_its_states() {
    let folder = tempfile::tempdir().unwrap();
    let points: String = (0..400)
        .map(|i| {
            let (a, b) = (f64::from(i) * 0.61, f64::from(i % 20) * 0.3);
            format!("{} {} {}\n", a.cos() * b.sin(), a.sin() * b.sin(), b.cos())
        })
        .collect();
    let path = file(&folder, "ball.xyz", &points);
    let mut driver = Driver::finished();
    let before = keys(&driver, 0);
    driver.key(Modifiers::COMMAND, Key::O);
    driver.type_path(path.to_str().unwrap());
    driver.press("Open");
    finish(&mut driver);
    assert_eq!(driver.session().loaded.as_ref().unwrap().shape.name, "ball.xyz");
    assert_ne!(keys(&driver, 0), before);
    undo(&mut driver);
    assert_eq!(driver.session().loaded.as_ref().unwrap().shape.name, "built-in chair");
    assert_eq!(keys(&driver, 0), before);
    assert_eq!(
        driver.session().primitives(),
        &*driver.session().timeline.states().last().unwrap().abstraction.primitives
    );
    driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    driver.settle();
    assert_eq!(driver.session().loaded.as_ref().unwrap().shape.name, "ball.xyz");
}

#[test]
fn a_run_is_undone_and_made_again_with_its_states() {
    let mut driver = Driver::finished();
    driver.toggle("Live");
    let before = keys(&driver, 0);
    driver.slide("Clusters K", 5.0);
    driver.press("Run");
    finish(&mut driver);
    let after = keys(&driver, 0);
    assert!(after != before);
    undo(&mut driver);
    assert_eq!(keys(&driver, 0), before, "the states of the run before are back");
    driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    driver.settle();
    assert_eq!(keys(&driver, 0), after);
}

/// A small window keeps its view, and the panel its first row.
#[test]
fn a_small_window_keeps_its_view() {
    for size in [[1024.0, 700.0], [640.0, 480.0]] {
        let mut driver = Driver::start(options(Source::BuiltIn), size);
        driver.settle();
        driver.harness.run_steps(10);
        let view = driver.viewport();
        assert!(view.height() > 0.38 * size[1], "{size:?}: {view}");
        let play = driver.harness.get_by_role_and_label(Role::Button, "Play").rect();
        assert!(play.top() > view.bottom() && play.bottom() < size[1], "{play}");
        driver.harness.run_steps(20);
        assert_eq!(driver.viewport(), view, "nothing creeps");
    }
}
