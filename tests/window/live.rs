//! Live and the pace, as a person uses them: by labels and with the pointer.

use std::time::Instant;

use crate::driver::{Driver, PATIENCE, Role, options};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use superform::inference::Phase;
use superform::session::Session;
use superform::worker::{Activity, Pace, Source};

fn run_number(session: &Session) -> u64 {
    session.snapshot.as_ref().unwrap().run
}

#[test]
fn a_moved_slider_renews_the_result() {
    let mut driver = Driver::finished();
    assert!(driver.session().live.is_on, "it is on from the start");
    let before = run_number(driver.session());
    let camera = driver.session().camera;
    driver.slide("Clusters K", 5.0);
    assert!(driver.shows("Updating…"), "a calm word on it");
    assert!(driver.has_button("Run") && driver.is_enabled("Run"), "no button blinks");
    // Until the result is there, the last one stays.
    while run_number(driver.session()) == before {
        assert_eq!(driver.session().phase(), Some(Phase::Finished));
        assert!(!driver.session().primitives().is_empty());
        driver.wait();
    }
    let state = driver.session().snapshot.clone().unwrap();
    assert_eq!((state.abstraction.phase, state.start.clusters), (Phase::Finished, 5));
    assert_eq!(
        driver.session().timeline.states()[0].abstraction.figures.clusters,
        5,
        "the history is that of the new run"
    );
    assert_eq!(driver.session().camera, camera);
    driver.settle();
    assert!(driver.shows("Iteration 6 of 6") && driver.shows("Finished"));
    driver.until(|session| session.measurement().is_some());
}

#[test]
fn a_dragged_slider_is_followed_and_its_last_value_wins() {
    // High enough for all sliders.
    let mut driver = Driver::start(options(Source::BuiltIn), [1280.0, 1100.0]);
    driver.settle();
    let slider = driver.harness.get_by_role_and_label(Role::Slider, "Cost of a primitive").rect();
    let at = |share: f32| egui::pos2(slider.left() + share * slider.width(), slider.center().y);
    driver.harness.drag_at(at(0.5));
    driver.harness.step();
    let begun = Instant::now();
    let (mut results, mut last) = (0, run_number(driver.session()));
    let mut frame = 0_u32;
    // The hand never stops, and yet results come.
    while results < 3 {
        assert!(begun.elapsed() < PATIENCE, "only {results} results in {PATIENCE:?} of dragging");
        frame += 1;
        driver.harness.hover_at(at(0.5 + 0.02 * (frame % 20) as f32));
        driver.harness.step();
        let state = driver.session().snapshot.as_ref().unwrap();
        assert_eq!(state.abstraction.phase, Phase::Finished, "never a half-made picture");
        if state.run != last {
            last = state.run;
            results += 1;
        }
    }
    driver.harness.drop_at(at(0.97));
    driver.settle();
    let wanted = driver.session().params.primitive_cost;
    assert!(wanted > 5.0, "{wanted}");
    let state = driver.session().snapshot.clone().unwrap();
    assert_eq!((state.start.primitive_cost, state.abstraction.phase), (wanted, Phase::Finished));
}

#[test]
fn a_watched_run_gives_way_to_the_result() {
    let mut options = options(Source::BuiltIn);
    options.params.iterations = 400;
    let mut driver = Driver::start(options, [1280.0, 800.0]);
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| s.abstraction.iteration >= 1));
    assert_eq!(driver.session().pace, Pace::PerSecond(10), "slow enough to be seen");
    driver.slide("Iterations T", 5.0);
    driver.settle();
    assert_eq!((driver.iteration(), driver.session().phase()), (5, Some(Phase::Finished)));
    assert!(driver.shows("Iteration 5 of 5"));
}

#[test]
fn live_off_leaves_sliders_to_the_next_step() {
    let mut driver = Driver::finished();
    let before = run_number(driver.session());
    driver.toggle("Live");
    driver.slide("Clusters K", 5.0);
    driver.settle();
    assert_eq!(run_number(driver.session()), before);
    assert!(driver.shows("This run: K = 12"));
    // What was turned meanwhile is made up for.
    driver.toggle("Live");
    driver.settle();
    assert_eq!(driver.session().snapshot.as_ref().unwrap().start.clusters, 5);
    assert!(!driver.shows("This run: K"));
}

#[test]
fn what_is_shown_says_when_parameters_have_changed_since() {
    // What floats takes a frame to find its size.
    let says_so = |driver: &mut Driver| {
        driver.harness.run_steps(3);
        driver.shows("Parameters changed")
    };
    let run = "Run with changed parameters";
    let mut driver = Driver::finished();
    assert!(!says_so(&mut driver));
    driver.slide("Concentration α", 2.0);
    driver.settle();
    assert!(!says_so(&mut driver), "Live follows");
    driver.toggle("Live");
    driver.slide("Concentration α", 0.5);
    assert!(says_so(&mut driver));
    driver.slide("Concentration α", 2.0);
    assert!(!says_so(&mut driver), "it was turned back");
    for slider in ["Concentration α", "Clusters K"] {
        driver.slide(slider, 7.0);
        assert!(says_so(&mut driver), "{slider}");
        driver.press(run);
        driver.settle();
        assert!(!says_so(&mut driver), "{slider}");
    }
    let start = driver.session().snapshot.as_ref().unwrap().start;
    assert_eq!((start.alpha, start.clusters), (7.0, 7));
    driver.harness.get_by_role_and_label(Role::SpinButton, "seed").set_value_accesskit(5.0);
    driver.harness.run_steps(2);
    assert!(says_so(&mut driver), "other samples");
    driver.press(run);
    driver.until(|session| session.loaded.as_ref().is_some_and(|l| l.sampling.seed == 5));
    driver.settle();
    assert!(!says_so(&mut driver));
    driver.key(Modifiers::SHIFT, Key::Space);
    driver.settle();
    assert!(!says_so(&mut driver), "to go on changes no parameter");
}

#[test]
fn tooltips_say_when_a_change_is_taken() {
    let mut driver = Driver::finished();
    for (live, said, not_said) in [
        (true, "every change starts", "Takes effect"),
        (false, "Takes effect at the next iteration", "every change"),
    ] {
        if !live {
            driver.toggle("Live");
        }
        let slider = driver.harness.get_by_role_and_label(Role::Slider, "Concentration α").rect().center();
        driver.harness.hover_at(slider + egui::vec2(1.0, 0.0));
        driver.harness.run_steps(2);
        driver.harness.hover_at(slider);
        driver.harness.run_steps(60);
        assert!(driver.shows(said) && !driver.shows(not_said), "Live is {live}");
        driver.harness.hover_at(egui::pos2(5.0, 5.0));
        driver.harness.run_steps(30);
    }
}

#[test]
fn samples_follow_the_hand_as_well() {
    let mut driver = Driver::finished();
    let seed = driver.harness.get_by_role_and_label(Role::SpinButton, "seed");
    seed.set_value_accesskit(5.0);
    driver.harness.run_steps(2);
    assert!(!driver.has_button("Resample"), "it is done without a word");
    driver.settle();
    let session = driver.session();
    assert_eq!(session.loaded.as_ref().unwrap().sampling.seed, 5);
    assert_eq!(session.phase(), Some(Phase::Finished));
    assert!(!driver.has_button("Resample"));
}

#[test]
fn the_pace_can_be_chosen_on_the_way() {
    let mut options = options(Source::BuiltIn);
    options.params.iterations = 40;
    let mut driver = Driver::start(options, [1280.0, 800.0]);
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| s.abstraction.iteration >= 1));
    driver.press("1/s");
    assert_eq!(driver.session().pace, Pace::PerSecond(1));
    assert_eq!(driver.session().activity, Activity::Running);
    driver.press("Pause");
    driver.settle();
    driver.press("Step iteration");
    driver.settle();
    driver.press("Max");
    driver.press("Run");
    driver.settle();
    assert_eq!(driver.session().phase(), Some(Phase::Finished));
    let seen: Vec<u32> = driver.session().timeline.states().iter().map(|e| e.abstraction.iteration).collect();
    assert!((0..=40).all(|i| seen.contains(&i)), "every iteration was told: {seen:?}");
}
