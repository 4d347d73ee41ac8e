//! Merging by hand, one pair at a time: the card with the test's numbers, and
//! what its buttons do.

use crate::driver::{Driver, Role, options};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use superform::session::merge_wording;
use superform::worker::{Activity, Source};

/// The window with a run that was paused after some iterations, before its
/// merges.
fn paused() -> Driver {
    let mut options = options(Source::BuiltIn);
    options.params.iterations = 400;
    let mut driver = Driver::start(options, [1280.0, 800.0]);
    driver.toggle("Live");
    driver.until(|s| s.snapshot.as_ref().is_some_and(|s| s.abstraction.iteration >= 3));
    driver.press("Pause");
    driver.settle();
    driver
}

fn pair(driver: &Driver) -> (u32, u32) {
    driver.session().proposal.as_ref().unwrap().pair
}

fn wait_for_proposal(driver: &mut Driver) {
    driver.until(|s| s.proposal.is_some());
}

#[test]
fn a_merge_is_proposed_with_its_numbers_and_accepted() {
    let mut driver = paused();
    let k = driver.session().primitives().len();
    let states = driver.session().timeline.states().len();
    driver.press("Step merge");
    wait_for_proposal(&mut driver);
    let proposal = driver.session().proposal.clone().unwrap();
    let verdict = if proposal.is_acceptable { "Recommended" } else { "Not recommended" };
    assert!(driver.shows(verdict));
    assert!(!proposal.numbers.is_empty());
    for number in &proposal.numbers {
        let name = merge_wording::quantity(number.quantity).0;
        assert!(driver.shows(name), "{name}");
    }
    assert_eq!(driver.session().timeline.states().len(), states, "a proposal is no state");
    driver.press("Accept");
    driver.until(|s| s.primitives().len() == k - 1 && s.activity == Activity::Idle);
    let merged = driver.session().primitives().iter().find(|p| p.id == proposal.into).unwrap();
    let drift = (merged.shape.semi_axes - proposal.union.semi_axes).norm();
    assert!(drift < 1e-9 * proposal.union.semi_axes.norm(), "the shown union, exactly");
    assert_eq!(driver.session().timeline.states().len(), states + 1);
}

#[test]
fn accept_skip_and_undo_go_through_the_pairs() {
    let mut driver = paused();
    let k = driver.session().primitives().len();
    driver.key(Modifiers::NONE, Key::M);
    wait_for_proposal(&mut driver);
    let first = pair(&driver);
    driver.key(Modifiers::NONE, Key::S);
    wait_for_proposal(&mut driver);
    let second = pair(&driver);
    assert_ne!(first, second, "the first was passed over");
    driver.key(Modifiers::NONE, Key::Enter);
    driver.until(|s| s.primitives().len() == k - 1 && s.proposal.is_some());
    assert_ne!(pair(&driver), first, "what was skipped stays skipped");
    // Back: the merge, then the skip.
    driver.press("Undo");
    wait_for_proposal(&mut driver);
    assert_eq!(driver.session().primitives().len(), k);
    assert_eq!(pair(&driver), second);
    driver.key(Modifiers::COMMAND, Key::Z);
    wait_for_proposal(&mut driver);
    assert_eq!(pair(&driver), first);
    driver.key(Modifiers::NONE, Key::Escape);
    assert!(driver.session().proposal.is_none() && !driver.shows("ecommended"));
    assert_eq!(driver.session().primitives().len(), k);
}

#[test]
fn any_two_are_judged_when_asked() {
    let mut driver = paused();
    let ids: Vec<u32> = driver.session().primitives().iter().map(|p| p.id).collect();
    driver.press(&format!("Primitive {}", ids[0]));
    driver.bring_into_view(Role::Button, &format!("Primitive {}", ids[1]));
    driver.click_with(&format!("Primitive {}", ids[1]), Modifiers::COMMAND);
    driver.press("Test this merge…");
    wait_for_proposal(&mut driver);
    let (a, b) = pair(&driver);
    assert_eq!((a.min(b), a.max(b)), (ids[0].min(ids[1]), ids[0].max(ids[1])));
    driver.press("Stop merging");
    assert!(driver.session().proposal.is_none());
    // From the menu of one.
    driver.press(&format!("Primitive {}", ids[0]));
    driver.press("Merge with…");
    let item = driver.harness.query_all_by_label_contains(" points").next();
    assert!(item.is_some(), "others are offered");
}
