//! Runs with several seeds, as a person makes, compares and takes them.

use std::sync::Arc;

use crate::driver::{Driver, Role, options};
use crate::needs::drawn;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use superform::inference::{Cancel, Params, Run};
use superform::render::{Offscreen, RenderOptions};
use superform::worker::Source;

/// The window with all seeds run and measured.
fn with_seeds(mut driver: Driver) -> Driver {
    driver.key(Modifiers::SHIFT, Key::R);
    assert!(driver.session().seeds.is_running());
    driver.until(|session| !session.seeds.is_running());
    driver
}

/// The card of a seed.
fn card(driver: &Driver, seed: u64) -> String {
    use egui_kittest::kittest::NodeT;
    let beginning = format!("Seed {seed}: ");
    let mut found = driver.harness.query_all_by_label_contains(&beginning);
    found.find_map(|node| node.accesskit_node().label()).unwrap_or_else(|| panic!("no card of seed {seed}"))
}

/// Presses a card that may have to be scrolled to.
fn press_card(driver: &mut Driver, label: &str) {
    driver.harness.get_by_role_and_label(Role::Button, label).click_accesskit();
    driver.harness.run_steps(2);
}

#[test]
fn eight_seeds_are_listed_best_first_and_are_what_they_say() {
    let driver = with_seeds(Driver::finished());
    let session = driver.session();
    let params = session.params;
    let cloud = Arc::clone(&session.loaded.as_ref().unwrap().cloud);
    assert_eq!(session.seeds.results().len(), 8);
    for seed in params.seed..params.seed + 8 {
        let label = card(&driver, seed);
        let cancel = Cancel::default();
        let mut run = Run::new(Arc::clone(&cloud), Params { seed, ..params }, &cancel).unwrap();
        while !run.is_finished() {
            run.step(&cancel).unwrap();
        }
        let expected = run.abstraction();
        assert!(label.contains(&format!("K {},", expected.primitives.len())), "{label}");
        assert!(label.contains("Chamfer "), "it is measured: {label}");
        let result = session.seeds.results().iter().find(|r| r.run.seed == seed).unwrap();
        assert_eq!(result.last().unwrap().abstraction.labels, expected.labels, "the same bits");
    }
    let chamfers: Vec<f64> = session.seeds.sorted().iter().map(|r| r.chamfer().unwrap()).collect();
    assert!(chamfers.is_sorted(), "{chamfers:?}");
    assert!(driver.is_enabled("Run 8 seeds"));
}

#[test]
fn a_click_takes_one_and_undo_gives_it_back() {
    let mut driver = with_seeds(Driver::finished());
    let before = driver.session().snapshot.as_ref().unwrap().key;
    let seed = driver.session().params.seed + 4;
    let label = card(&driver, seed);
    press_card(&mut driver, &label);
    let session = driver.session();
    let result = session.seeds.results().iter().find(|r| r.run.seed == seed).unwrap();
    let taken = result.last().unwrap().key;
    assert_eq!(session.snapshot.as_ref().unwrap().key, taken);
    let branch = session.timeline.current().unwrap();
    assert_eq!(branch.name, format!("Seed {seed}"));
    assert_eq!(branch.states.len(), result.run.states.len(), "with all its states");
    assert_eq!(session.params.seed, seed, "what runs next has its seed");
    assert!(session.measurement().is_some(), "its figures are known");
    press_card(&mut driver, &label);
    assert_eq!(driver.session().timeline.branches().len(), 2, "it is taken once");
    driver.key(Modifiers::COMMAND, Key::Z);
    let session = driver.session();
    assert_eq!(session.snapshot.as_ref().unwrap().key, before);
    assert_eq!(session.timeline.branches().len(), 1);
    assert_eq!(session.params.seed, seed - 4);
    driver.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(driver.session().snapshot.as_ref().unwrap().key, taken);
    // The worker goes on from there.
    driver.press("Step merge");
    driver.settle();
    assert!(driver.session().messages.open_error().is_none());
}

#[test]
fn where_seeds_disagree_is_painted_with_a_legend() {
    let mut driver = Driver::finished();
    driver.choose("Colour by", "Seed disagreement");
    assert!(driver.shows("No seed runs yet"), "the legend says what is missing");
    let mut driver = with_seeds(driver);
    driver.harness.run_steps(3);
    assert!(driver.shows("Disagreement among 8 seeds from"));
    driver.press("Paint disagreement");
    assert!(!driver.shows("Disagreement among 8 seeds from"), "the same button leads back");
    driver.choose("Sort seeds by", "By seed");
    let seeds: Vec<u64> = driver.session().seeds.sorted().iter().map(|r| r.run.seed).collect();
    assert!(seeds.is_sorted());
    driver.press("Close seeds");
    assert!(!driver.has_button("Paint disagreement"));
    assert_eq!(driver.session().seeds.results().len(), 8, "the runs stay");
}

#[test]
fn seeds_can_be_stopped_and_the_run_goes_on_beside_them() {
    let mut options = options(Source::BuiltIn);
    options.params.iterations = 500;
    let mut driver = Driver::start(options, [1280.0, 800.0]);
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| s.abstraction.iteration >= 1));
    driver.key(Modifiers::SHIFT, Key::R);
    let before = driver.iteration();
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| s.abstraction.iteration > before));
    assert!(driver.session().is_running(), "it was not interrupted");
    driver.press("Stop seed runs");
    driver.until(|s| !s.seeds.is_running());
    assert!(driver.session().seeds.results().len() < 8);
    assert!(driver.has_button("Run 8 seeds"));
    driver.press("Pause");
    driver.settle();
}

#[test]
fn each_seed_has_its_picture() {
    if drawn(Offscreen::new(RenderOptions::default())).is_none() {
        return;
    }
    let mut options = options(Source::BuiltIn);
    options.sampling.points = 2000;
    let mut driver = Driver::start_drawn(options, [1440.0, 900.0]);
    driver.settle();
    let mut driver = with_seeds(driver);
    let colored = |driver: &mut Driver, rect: egui::Rect| {
        let picture = driver.harness.render().unwrap();
        let spread = |p: &image::Rgba<u8>| p.0[..3].iter().max().unwrap() - p.0[..3].iter().min().unwrap();
        let inside = |x: u32, y: u32| rect.contains(egui::pos2(x as f32, y as f32));
        picture.enumerate_pixels().filter(|(x, y, p)| inside(*x, *y) && spread(p) > 60).count()
    };
    driver.choose("Sort seeds by", "By seed");
    driver.choose("Colour by", "Seed disagreement");
    // One picture a frame, and the device takes its time.
    for seed in 1..=6 {
        driver.draw_until(&format!("the picture of seed {seed}"), |driver| {
            driver.harness.run_steps(3);
            let label = card(driver, seed);
            let rect = driver.harness.get_by_role_and_label(Role::Button, &label).rect();
            colored(driver, rect) > 150
        });
    }
    if let Some(folder) = std::env::var_os("SUPERFORM_PICTURES") {
        std::fs::create_dir_all(&folder).unwrap();
        driver.harness.render().unwrap().save(std::path::Path::new(&folder).join("seeds.png")).unwrap();
    }
}
