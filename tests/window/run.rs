//! The run as a person drives it: by the buttons' labels.

use crate::driver::{Driver, Role, file, options};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use superform::geometry::{Isolated, SampledPart, Surface};
use superform::inference::{Algorithm, Phase};
use superform::session::Verb;
use superform::worker::{Activity, Snapshot, Source};

/// More iterations than are made before a test presses its button.
const LONG: u32 = 500;

/// The window in the middle of a run that doesn't end by itself for long.
fn running() -> Driver {
    let mut options = options(Source::BuiltIn);
    options.params.iterations = LONG;
    let mut driver = Driver::start(options, [1280.0, 800.0]);
    driver.toggle("Live");
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| s.abstraction.iteration >= 1));
    driver
}

/// The window after its first run, with sliders that wait for the next.
fn finished() -> Driver {
    let mut driver = Driver::finished();
    driver.toggle("Live");
    driver
}

#[test]
fn the_shape_becomes_primitives_without_a_touch() {
    let driver = Driver::finished();
    let session = driver.session();
    assert!(!session.primitives().is_empty());
    assert_eq!(session.timeline.states().first().map(|e| e.abstraction.iteration), Some(0));
    assert_eq!(driver.iteration(), 6);
    assert!(driver.shows("Iteration 6 of 6"));
    assert!(driver.shows("Finished"));
    assert!(driver.shows("built-in chair"));
    assert!(!driver.is_enabled("Step iteration"), "nothing is left to do");
    assert!(driver.is_enabled("Reset"));
}

#[test]
fn a_run_is_paused_stepped_and_continued() {
    let mut driver = running();
    driver.press("Pause");
    driver.settle();
    let paused_at = driver.iteration();
    assert!((1..LONG).contains(&paused_at), "it was paused in the middle");
    assert!(driver.shows("Paused"));
    driver.press("Step iteration");
    driver.settle();
    assert_eq!(driver.iteration(), paused_at + 1);
    driver.slide("Iterations T", f64::from(paused_at + 4));
    driver.press("Run");
    driver.settle();
    assert_eq!(driver.session().phase(), Some(Phase::Finished));
    assert_eq!(driver.iteration(), paused_at + 4, "a changed T is taken on the way");
    // Every iteration was seen once: pausing loses nothing.
    let iterations: Vec<u32> =
        driver.session().timeline.states().iter().map(|e| e.abstraction.iteration).collect();
    assert!(iterations.windows(2).all(|w| w[1] == w[0] || w[1] == w[0] + 1), "{iterations:?}");
}

#[test]
fn merging_step_by_step_says_which_and_when_none_is_left() {
    let mut options = options(Source::BuiltIn);
    options.sampling.points = 2500;
    let mut driver = Driver::start(options, [1280.0, 800.0]);
    driver.settle();
    driver.press("Reset");
    driver.settle();
    assert_eq!(
        (driver.iteration(), driver.session().primitives().len()),
        (0, 12),
        "the start has K clusters"
    );
    driver.press("Step iteration");
    driver.settle();
    let before = driver.session().primitives().len();
    driver.press("Step merge");
    driver.until(|s| s.proposal.is_some());
    assert_eq!(driver.session().primitives().len(), before, "a proposal changes nothing");
    driver.press("Accept");
    driver.until(|s| s.primitives().len() == before - 1);
    driver.press("Merge all");
    driver.settle();
    assert!(driver.shows("No more pairs to merge."));
    assert!(!driver.is_enabled("Merge all"), "it would do nothing");
}

#[test]
fn sliders_reach_the_sampler() {
    let mut driver = finished();
    driver.press("Reset");
    driver.settle();
    driver.slide("Concentration α", 3.0);
    driver.slide("Clusters K", 7.0);
    assert!(driver.shows("This run: K = 12"), "K waits for the next start, and that is said");
    driver.press("Step iteration");
    driver.settle();
    let params = driver.session().snapshot.as_ref().unwrap().params;
    assert!((params.alpha - 3.0).abs() < 1e-6);
    driver.press("Reset");
    driver.settle();
    assert_eq!(driver.session().primitives().len(), 7);
    assert!(!driver.shows("This run: K"), "it was taken");
}

#[test]
fn a_slider_moved_during_the_run_is_taken_on_the_way() {
    let mut driver = running();
    driver.slide("New cluster p0", 0.5);
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| (s.params.p0 - 0.5).abs() < 1e-6));
    driver.press("Pause");
    driver.settle();
    assert_eq!(
        driver.session().timeline.states().first().map(|e| e.abstraction.iteration),
        Some(0),
        "no new start"
    );
}

#[test]
fn keys_do_what_the_buttons_do() {
    let mut driver = finished();
    driver.choose("Method", "Paper");
    driver.choose("Method", "Default");
    driver.key(Modifiers::NONE, Key::Backspace);
    driver.settle();
    assert_eq!(driver.iteration(), 0);
    driver.key(Modifiers::NONE, Key::N);
    driver.settle();
    assert_eq!(driver.iteration(), 1);
    driver.key(Modifiers::NONE, Key::Space);
    assert_eq!(driver.session().activity, Activity::Running);
    driver.key(Modifiers::NONE, Key::Space);
    driver.settle();
    assert!(driver.iteration() < 30);
}

#[test]
fn a_method_is_chosen_run_and_seen() {
    let mut driver = finished();
    driver.choose("Method", "Paper");
    assert!(driver.session().params.freeze);
    driver.choose("Method", "K-means");
    driver.slide("Clusters K", 9.0);
    assert!(driver.shows("Shown now: Sampler"), "that it waits is said");
    for (slider, is_read) in [
        ("Concentration α", false),
        ("New cluster p0", false),
        ("Iterations T", false),
        ("Clusters K", true),
        ("Cost of a primitive", false),
        ("Outlier prior w0", false),
    ] {
        assert_eq!(driver.is_slider_enabled(slider), is_read, "{slider}");
    }
    driver.harness.get_by_role_and_label(Role::Slider, "Concentration α").hover();
    driver.harness.run_steps(8);
    assert!(driver.shows("K-means does not use this"), "a grey slider says why");
    driver.press("Run");
    driver.settle();
    let phase = driver.session().phase();
    assert_eq!((driver.session().primitives().len(), phase), (9, Some(Phase::Finished)));
    assert_eq!(driver.session().timeline.states().len(), 10, "every fit was seen");
    assert!(driver.shows("K-means: step 9 of 9") && driver.shows("Finished"));
    assert!(!driver.is_enabled("Step merge"), "there is nothing to judge a merge by");
    for (method, title) in
        [("One primitive (EMS)", "EMS: step"), ("Hierarchical EMS", "Hierarchical EMS: step")]
    {
        driver.choose("Method", method);
        assert!(driver.is_slider_enabled("Outlier prior w0") && !driver.is_slider_enabled("Clusters K"));
        driver.press("Run");
        driver.settle();
        assert!(driver.shows(title) && driver.shows("Finished"), "{method}");
        let count = driver.session().primitives().len();
        assert_eq!(count == 1, method.starts_with("One"), "{method} found {count}");
        assert!(!driver.shows("Shown now"), "it was taken");
        assert!(!driver.shows("1 primitives"));
    }
    driver.choose("Method", "Default");
    driver.press("Run");
    // (A frame may take in several states at once.)
    let is_of_sampler =
        |s: &Snapshot| s.start.algorithm == Algorithm::Sampler && s.abstraction.iteration >= 1;
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| is_of_sampler(s)));
    assert!(driver.shows("Iteration "));
}

#[test]
fn the_cost_of_a_primitive_is_turned() {
    let mut driver = finished();
    let count = |driver: &Driver| driver.session().primitives().len();
    let before = count(&driver);
    driver.slide("Cost of a primitive", 10.0);
    driver.press("Run");
    driver.settle();
    let dear = count(&driver);
    driver.slide("Cost of a primitive", 0.1);
    driver.press("Run");
    driver.settle();
    assert!(dear <= before && dear < count(&driver), "{dear} {before} {}", count(&driver));
    // The paper's merges do not read it.
    driver.choose("Method", "Paper");
    assert!(!driver.is_slider_enabled("Cost of a primitive"));
}

#[test]
fn iterations_below_what_is_done_are_not_claimed() {
    let mut driver = finished();
    driver.slide("Iterations T", 3.0);
    assert!(driver.shows("Iteration 6 of 6") && !driver.shows("of 3"));
}

#[test]
fn sampling_anew_starts_over() {
    let mut driver = finished();
    assert!(!driver.has_button("Resample"), "nothing has changed");
    let seed = driver.harness.get_by_role_and_label(Role::SpinButton, "seed");
    seed.set_value_accesskit(5.0);
    driver.harness.run_steps(2);
    driver.press("Resample");
    driver.settle();
    let loaded = driver.session().loaded.as_ref().unwrap();
    assert_eq!((loaded.sampling.seed, driver.iteration()), (5, 0));
    assert!(!driver.session().is_enabled(Verb::Resample));
}

/// The figures of the present state, which are those of `evaluate`.
#[test]
fn the_figures_of_a_state_that_rests_are_shown_and_explained() {
    let mut driver = finished();
    driver.until(|session| session.measurement().is_some());
    let metrics = driver.session().measurement().unwrap().result.clone().unwrap();
    for value in [metrics.chamfer_l1, metrics.accuracy, metrics.completeness] {
        assert!(driver.shows(&format!("{:.5}", value.unwrap())), "{metrics:?}");
    }
    assert!(driver.shows(&format!("{:.3}", metrics.iou.unwrap())));
    let labels = ["Chamfer-L1", "Accuracy", "Completeness", "IoU", "Primitives", "Unassigned"];
    for label in labels {
        assert!(driver.harness.query_all_by_label(label).next().is_some(), "{label}");
    }
    driver.harness.get_by_label("Completeness").hover();
    driver.harness.run_steps(30);
    assert!(driver.shows("Mean distance from the input to the surface"), "it is defined");
    // A state of its own has figures of its own: the start has none.
    driver.press("Reset");
    driver.settle();
    assert!(driver.session().measurement().is_none());
    assert!(!driver.shows(&format!("{:.5}", metrics.chamfer_l1.unwrap())));
    driver.press("Step iteration");
    driver.until(|session| session.measurement().is_some());
    let next = driver.session().measurement().unwrap().result.clone().unwrap();
    assert_ne!(next.chamfer_l1, metrics.chamfer_l1);
    assert!(driver.shows(&format!("{:.5}", next.chamfer_l1.unwrap())));
}

#[test]
fn a_cloud_says_why_it_has_no_volume() {
    let folder = tempfile::tempdir().unwrap();
    let points: String = (0..900)
        .map(|i| {
            let (u, v) = (f64::from(i % 30) * 0.21, f64::from(i / 30) * 0.1);
            format!("{} {} {v}\n", u.cos(), u.sin())
        })
        .collect();
    let cloud = file(&folder, "tube.xyz", &points);
    let mut driver = Driver::start(options(Source::File(cloud)), [1280.0, 800.0]);
    driver.until(|session| session.measurement().is_some());
    assert!(driver.shows("No IoU: the reference is a cloud"));
    driver.press("Reset");
    driver.settle();
    assert!(driver.shows("No IoU: the reference is a cloud"), "that is so in any state");
}

/// The built-in chair has parts that reach into others.
#[test]
fn what_is_hidden_is_sampled_on_request() {
    let mut driver = finished();
    let loaded = driver.session().loaded.as_ref().unwrap();
    assert!(loaded.cloud.part.left_out() > 0.02, "{:?}", loaded.cloud.part);
    let label = "Only the surface visible from outside";
    driver.harness.get_by_role_and_label(Role::CheckBox, label).click();
    driver.harness.run_steps(2);
    driver.press("Resample");
    driver.settle();
    let loaded = driver.session().loaded.as_ref().unwrap();
    assert_eq!((loaded.sampling.surface, loaded.cloud.part), (Surface::All, SampledPart::Whole));
}

/// A cloud has a check box of its own, for its outliers.
#[test]
fn isolated_points_are_sampled_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("strays.xyz");
    let mut text = String::new();
    for i in 0..900 {
        text.push_str(&format!("{} {} 0\n", i % 30, i / 30));
    }
    for i in 0..9 {
        text.push_str(&format!("{} {} {}\n", 10 * (i % 3), 10 * (i / 3), 12 + 7 * (i % 2)));
    }
    std::fs::write(&path, text).unwrap();
    let mut driver = Driver::start(options(Source::File(path)), [1280.0, 800.0]);
    driver.toggle("Live");
    driver.settle();
    let loaded = driver.session().loaded.as_ref().unwrap();
    assert_eq!(loaded.cloud.part.isolated(), 9, "{:?}", loaded.cloud.part);
    let label = "Leave out isolated points";
    driver.harness.get_by_role_and_label(Role::CheckBox, label).click();
    driver.harness.run_steps(2);
    driver.press("Resample");
    driver.settle();
    let loaded = driver.session().loaded.as_ref().unwrap();
    assert_eq!((loaded.sampling.isolated, loaded.cloud.part), (Isolated::Keep, SampledPart::Whole));
}
