//! What a state means, as a person asks for it: the odds of a point, colours
//! that tell numbers, and what α and p0 stand for.

use crate::driver::{Driver, Role, options};
use crate::needs::drawn;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use nalgebra::Point3;
use superform::geometry::kernel::{PointBlock, euclidean_distances};
use superform::geometry::tessellate::{Resolution, surface_vertices};
use superform::inference::{UNASSIGNED, expected_tables, explain, label_entropy};
use superform::io::ShapeGeometry;
use superform::render::{Offscreen, RenderOptions};
use superform::worker::Source;

/// Plain text has its words as its value.
fn text_of(node: &egui_kittest::kittest::AccessKitNode<'_>) -> Option<String> {
    node.label().or_else(|| node.value())
}

/// The labels of all widgets that begin so.
fn labels(driver: &Driver, beginning: &str) -> Vec<String> {
    let found = driver.harness.query_all_by_label_contains(beginning);
    let mut labels: Vec<String> = found
        .filter_map(|node| text_of(&node.accesskit_node()))
        .filter(|l| l.starts_with(beginning))
        .collect();
    labels.sort();
    labels.dedup();
    labels
}

/// The number after `name` in a label such as `n 340, distance 0.0123`.
fn number_after(label: &str, name: &str) -> f64 {
    let rest = label.split_once(name).unwrap_or_else(|| panic!("no “{name}” in “{label}”")).1.trim_start();
    let rest = rest.trim_start_matches(['≈', '<', '≥', ' ']);
    let end = rest.find(|c: char| !(c.is_ascii_digit() || ".e-,".contains(c))).unwrap_or(rest.len());
    // Groups of three are set off by commas, and so are the parts of a label.
    let digits = rest[..end].trim_end_matches(',').replace(',', "");
    digits.parse().unwrap_or_else(|_| panic!("“{digits}” in “{label}”"))
}

fn show_or_hide_primitives(driver: &mut Driver) {
    driver.toggle_layer("Primitives");
    // The menu stays open for more.
    driver.press("Show");
}

/// Clicks here and there in the 3D view until a point is hit.
fn click_a_point(driver: &mut Driver) -> u32 {
    let view = driver.viewport();
    for i in 0..2000 {
        // Low-discrepancy places around the middle.
        let (u, v) =
            ((f64::from(i) * 0.754_877_666).fract() as f32, (f64::from(i) * 0.569_840_29).fract() as f32);
        let at = view.min + egui::vec2(0.3 + 0.4 * u, 0.3 + 0.4 * v) * view.size();
        driver.harness.hover_at(at);
        driver.harness.step();
        driver.harness.drag_at(at);
        driver.harness.drop_at(at);
        driver.harness.run_steps(2);
        if let Some(sample) = driver.session().explained {
            return sample;
        }
    }
    panic!("no click hit a point");
}

fn check_odds(driver: &Driver, sample: u32) {
    let session = driver.session();
    let state = session.snapshot.as_ref().unwrap();
    let expected =
        explain(&session.loaded.as_ref().unwrap().cloud.points, &state.checkpoint, sample).unwrap();
    let rows = labels(driver, "Table ");
    assert_eq!(rows.len(), expected.tables.len(), "{rows:?}");
    let mut sum = 0.0;
    for row in &rows {
        let id = number_after(row, "Table ") as u32;
        let odds = expected.tables.iter().find(|o| o.id == id).unwrap();
        assert_eq!(number_after(row, ", n "), odds.n, "{row}");
        let shown = number_after(row, "odds ");
        assert!((shown - 100.0 * odds.probability).abs() < 0.06, "{row}: {}", odds.probability);
        let distance = number_after(row, "distance ");
        assert!((distance - odds.distance_input).abs() <= 1e-3 * odds.distance_input + 6e-5, "{row}");
        sum += shown;
    }
    let new = labels(driver, "New table, weight").remove(0);
    let shown = number_after(&new, "odds ");
    assert!((shown - 100.0 * expected.new.probability).abs() < 0.06, "{new}");
    assert!((sum + shown - 100.0).abs() < 0.05 * (rows.len() + 1) as f64, "all odds together are {sum}");
}

#[test]
fn a_click_on_a_point_shows_its_odds_which_follow_the_state() {
    let mut driver = Driver::finished();
    show_or_hide_primitives(&mut driver);
    let sample = click_a_point(&mut driver);
    assert!(driver.shows("Point "), "a card says which");
    if let Some(more) = labels(&driver, "").into_iter().find(|l| l.contains(" more, together ")) {
        driver.press(&more);
    }
    check_odds(&driver, sample);
    let last = driver.session().snapshot.as_ref().unwrap().key;

    // The terms of the equation that was asked for.
    let new = labels(&driver, "New table, weight").remove(0);
    driver.press(&new);
    assert!(driver.shows("= α · p0"));
    assert!(driver.shows("N − 1 + α"));

    // Another state, another explanation.
    driver.key(Modifiers::NONE, Key::ArrowLeft);
    assert_ne!(driver.session().snapshot.as_ref().unwrap().key, last);
    if let Some(more) = labels(&driver, "").into_iter().find(|l| l.contains(" more, together ")) {
        driver.press(&more);
    }
    check_odds(&driver, sample);

    // The strip of labels leads to any state.
    let strip = labels(&driver, "Label over").remove(0);
    let strip = driver.harness.get_by_role_and_label(Role::Image, &strip).rect();
    let at = strip.left_center() + egui::vec2(1.0, 0.0);
    driver.harness.hover_at(at);
    driver.harness.step();
    driver.harness.drag_at(at);
    driver.harness.drop_at(at);
    driver.harness.run_steps(2);
    assert_eq!(driver.session().timeline.shown_index(), 0);
    assert_eq!(driver.session().explained, Some(sample), "it stays with its point");
}

#[test]
fn legends_say_how_large_errors_are_in_input_units() {
    let mut driver = Driver::finished();
    driver.choose("Colour by", "Error");
    driver.until_shown("Distance to own primitive from");
    driver.press("Scale colours to the maximum");
    let session = driver.session();
    let (samples, state) =
        (&session.loaded.as_ref().unwrap().cloud.points, session.snapshot.as_ref().unwrap());
    let labels_now = &state.abstraction.labels;
    let mut most = 0.0_f32;
    for primitive in state.abstraction.primitives.iter() {
        let own = samples.iter().zip(labels_now.iter()).filter(|(_, l)| **l == primitive.id).map(|(p, _)| *p);
        let mut distances = Vec::new();
        euclidean_distances(&primitive.shape, &own.collect::<PointBlock>(), &mut distances);
        most = distances.iter().fold(most, |most, d| most.max(d.abs()));
    }
    let legend = labels(&driver, "Distance to own primitive from").remove(0);
    let shown = number_after(&legend, " from 0 to ");
    assert!((shown - f64::from(most)).abs() < 2e-3 * f64::from(most) + 6e-5, "{legend}: {most}");

    driver.press("Scale colours to 95 %");
    let legend = labels(&driver, "Distance to own primitive from").remove(0);
    let robust = number_after(&legend, " from 0 to ");
    let share = |limit: f64| {
        let all = labels_now_of(&driver);
        let above = all.iter().filter(|d| f64::from(**d) > limit).count();
        above as f64 / all.len() as f64
    };
    assert!(share(robust) <= 0.05, "5 % at most lie above the end of the range");
}

/// The distance of each assigned sample to its own primitive.
fn labels_now_of(driver: &Driver) -> Vec<f32> {
    let session = driver.session();
    let samples = &session.loaded.as_ref().unwrap().cloud.points;
    let state = &session.snapshot.as_ref().unwrap().abstraction;
    let mut all = Vec::new();
    for primitive in state.primitives.iter() {
        let own =
            samples.iter().zip(state.labels.iter()).filter(|(_, l)| **l == primitive.id).map(|(p, _)| *p);
        let mut distances = Vec::new();
        euclidean_distances(&primitive.shape, &own.collect::<PointBlock>(), &mut distances);
        all.extend(distances.iter().map(|d| d.abs()));
    }
    all
}

#[test]
fn surfaces_are_painted_by_their_distance_to_the_input() {
    let mut driver = Driver::finished();
    driver.choose("Colour by", "To input");
    driver.until_shown("Distance to input from");
    driver.press("Scale colours to the maximum");
    let session = driver.session();
    let ShapeGeometry::Mesh(mesh) = &session.loaded.as_ref().unwrap().shape.geometry else {
        panic!("the built-in shape is a mesh");
    };
    let faces: Vec<[Point3<f64>; 3]> = mesh.faces.iter().filter_map(|f| mesh.corners(f)).collect();
    let mut most = 0.0_f64;
    for primitive in session.primitives() {
        for (vertex, _) in surface_vertices(&primitive.shape, Resolution::SCREEN) {
            let nearest =
                faces.iter().map(|f| distance_to_triangle(&vertex, f)).fold(f64::INFINITY, f64::min);
            most = most.max(nearest);
        }
    }
    let legend = labels(&driver, "Distance to input from").remove(0);
    let shown = number_after(&legend, " from 0 to ");
    assert!((shown - most).abs() < 2e-3 * most + 6e-5, "{legend}: {most}");
}

/// By the nearest of the plane's foot, if it is inside, and the three edges.
fn distance_to_triangle(p: &Point3<f64>, [a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let to_edge = |from: &Point3<f64>, to: &Point3<f64>| {
        let edge = to - from;
        let t = ((p - from).dot(&edge) / edge.norm_squared().max(1e-300)).clamp(0.0, 1.0);
        (p - (from + edge * t)).norm()
    };
    let normal = (b - a).cross(&(c - a));
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(s, t)| (*t - *s).cross(&(p - *s)).dot(&normal) >= 0.0);
    let edges = to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a));
    let area = normal.norm();
    if inside && area > 0.0 { ((p - a).dot(&normal) / area).abs() } else { edges }
}

#[test]
fn the_uncertainty_is_that_of_the_last_states_or_says_why_not() {
    let mut driver = Driver::finished();
    driver.choose("Colour by", "Uncertainty");
    let states = driver.session().timeline.states().to_vec();
    assert!(states.len() > 4);
    driver.until_shown(&format!("Uncertainty over {} states", states.len().min(10)));
    driver.harness.get_by_role_and_label(Role::SpinButton, "Last").set_value_accesskit(4.0);
    driver.harness.run_steps(3);
    assert_eq!(driver.session().view.uncertainty_window, 4);
    driver.until_shown("Uncertainty over 4 states from");
    driver.press("Scale colours to the maximum");
    let last: Vec<&[u32]> = states[states.len() - 4..].iter().map(|s| &*s.abstraction.labels).collect();
    assert!(last.iter().flat_map(|l| l.iter()).any(|l| *l != UNASSIGNED));
    let most = label_entropy(&last).into_iter().fold(0.0, f32::max);
    let legend = labels(&driver, "Uncertainty over 4 states from").remove(0);
    if most > 0.0 {
        assert!((number_after(&legend, " from 0 to ") - f64::from(most)).abs() < 1e-3, "{legend}: {most}");
    }
    driver.press("Reset");
    driver.settle();
    assert_eq!(driver.session().timeline.states().len(), 1);
    assert!(driver.shows("No history yet"), "the legend says why there is nothing");
}

#[test]
fn alpha_and_p0_are_told_in_plain_numbers_while_they_are_turned() {
    let mut driver = Driver::finished();
    let tables = |driver: &Driver| number_after(&labels(driver, "≈ ").remove(0), "≈ ");
    let distance = |driver: &Driver| {
        number_after(&labels(driver, "new primitive preferred beyond").remove(0), "beyond ")
    };
    assert!((tables(&driver) - expected_tables(0.5, 700)).abs() < 0.06);
    let before = distance(&driver);
    driver.toggle("Live");
    driver.slide("Concentration α", 5.0);
    assert!((tables(&driver) - expected_tables(5.0, 700)).abs() < 0.06);
    let nearer = distance(&driver);
    assert!(nearer < before, "more α, and a new table wins nearer by: {nearer} < {before}");
    driver.slide("New cluster p0", 1.0);
    assert!(distance(&driver) < nearer);
}

/// For the eye: with `SUPERFORM_PICTURES` the pictures are kept.
#[test]
fn the_card_and_the_legend_are_drawn() {
    if drawn(Offscreen::new(RenderOptions::default())).is_none() {
        return;
    }
    let mut options = options(Source::BuiltIn);
    options.sampling.points = 3500;
    options.params.iterations = 30;
    options.params.clusters = 30;
    let mut driver = Driver::start_drawn(options, [1440.0, 900.0]);
    driver.settle();
    show_or_hide_primitives(&mut driver);
    click_a_point(&mut driver);
    keep(&mut driver, "odds.png");
    driver.choose("Colour by", "Error");
    driver.until_shown("Distance to own primitive from");
    keep(&mut driver, "error.png");
    show_or_hide_primitives(&mut driver);
    driver.choose("Colour by", "To input");
    driver.until_shown("Distance to input from");
    keep(&mut driver, "surfaces.png");
    driver.choose("Colour by", "Uncertainty");
    driver.set_light();
    driver.until_shown("Uncertainty over");
    keep(&mut driver, "uncertainty.png");
}

fn keep(driver: &mut Driver, name: &str) {
    driver.harness.run_steps(3);
    let picture = driver.harness.render().unwrap();
    if let Some(folder) = std::env::var_os("SUPERFORM_PICTURES") {
        std::fs::create_dir_all(&folder).unwrap();
        picture.save(std::path::Path::new(&folder).join(name)).unwrap();
    }
}
