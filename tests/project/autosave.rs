//! The journal of a running window: what is lost when the process is killed,
//! who may recover it, and what a full or missing disk does.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

use crate::material::{Material, assert_same, workspace};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use superform::inference::Algorithm;
use superform::project::{Autosave, Event, Opened, Origin};
use superform::session::saving::Found;
use superform::session::workspace::Workspace;
use superform::worker::Snapshot;
use tempfile::TempDir;

/// Longer than any step here takes; reached only by a failing test.
const PATIENCE: Duration = Duration::from_secs(300);
/// Names the folder to the child that is to be killed.
const FOLDER: &str = "SUPERFORM_TEST_KEEPER_FOLDER";

fn autosave(folder: &Path) -> Autosave {
    Autosave::spawn(Some(folder.to_owned()), || {}).unwrap()
}

/// The first event that is wanted.
fn wait<T>(autosave: &mut Autosave, wanted: impl Fn(Event) -> Option<T>) -> T {
    loop {
        let event = autosave.next_event(PATIENCE).expect("the keeper has fallen silent");
        if let Some(found) = wanted(event) {
            return found;
        }
    }
}

fn keep(autosave: &mut Autosave, workspace: &Workspace) {
    let number = autosave.keep(workspace.clone());
    wait(autosave, |event| matches!(event, Event::Kept(n) if n == number).then_some(()));
}

fn found(autosave: &mut Autosave) -> Vec<Found> {
    wait(autosave, |event| if let Event::Found(found) = event { Some(found) } else { None })
}

fn open(autosave: &mut Autosave, origin: Origin, unsaved: Option<Workspace>) -> Opened {
    autosave.open(origin, unsaved);
    *wait(autosave, |event| match event {
        Event::Opened { opened, .. } => Some(opened),
        Event::Failed { what, error } => panic!("{what}: {error}"),
        _ => None,
    })
}

/// Names of the files in a folder, but for the lock on it.
fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.retain(|name| name != "folder.lock");
    names.sort();
    names
}

fn material() -> Material {
    Material::new(1, false, Algorithm::Sampler, 4)
}

/// A run that has come to its state number `count`.
fn grown(material: &Material, count: usize) -> Material {
    let states = material.states.iter().cycle().take(count);
    let renamed = states.map(|s| Arc::new(Snapshot { key: Snapshot::new_key(), ..Snapshot::clone(s) }));
    Material { loaded: Arc::clone(&material.loaded), states: renamed.collect() }
}

#[test]
#[ignore = "not a test by itself: another starts it and kills it"]
fn child_that_is_killed() {
    let folder = std::env::var_os(FOLDER).unwrap();
    let mut autosave = autosave(Path::new(&folder));
    let long = grown(&material(), 2000);
    for count in 1..long.states.len() {
        keep(&mut autosave, &workspace(long.document(count), &[long.document(1)], &[]));
        println!("\nkept {count}");
        std::io::stdout().flush().unwrap();
    }
}

#[test]
fn a_killed_process_loses_at_most_its_last_state() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..8 {
        let place = TempDir::new().unwrap();
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "autosave::child_that_is_killed", "--ignored", "--nocapture"])
            .env(FOLDER, place.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let mut kept = || {
            let count = |line: String| line.strip_prefix("kept ").and_then(|n| n.parse::<usize>().ok());
            lines.by_ref().find_map(|line| count(line.unwrap()))
        };
        let at = random.random_range(1..60);
        while kept().is_some_and(|count| count < at) {}
        // Somewhere within the next state.
        for i in 0..random.random_range(0..200_000) {
            std::hint::black_box(i);
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let last = std::iter::from_fn(kept).last().unwrap_or(at);
        let mut autosave = autosave(place.path());
        let [found] = &found(&mut autosave)[..] else { panic!("one process was killed") };
        assert!(found.summary.to_string().starts_with("pipe.xyz, iteration "), "{}", found.summary);
        let opened = open(&mut autosave, Origin::Recovered(found.id), None);
        let states = opened.workspace.document.timeline.states().len();
        assert!(states == last || states == last + 1, "{states} of {last} states");
        assert_eq!(opened.workspace.undo.done().len(), 1);
    }
}

#[test]
fn what_was_left_behind_is_offered_to_one_until_it_is_recovered_or_discarded() {
    let place = TempDir::new().unwrap();
    let material = material();
    let [first, second] = [1, 2].map(|count| workspace(material.document(count), &[], &[]));
    let [mut one, mut other] = [autosave(place.path()), autosave(place.path())];
    keep(&mut one, &first);
    keep(&mut other, &second);
    drop((one, other));
    // Both end without a word.
    let mut next = autosave(place.path());
    let offers = found(&mut next);
    assert_eq!(offers.len(), 2);
    let mut third = autosave(place.path());
    keep(&mut third, &first);
    drop(third);
    // The third was not offered the two that the next one holds, and its own is left behind now.
    let newest = open(&mut next, Origin::Recovered(offers[0].id), None);
    assert_same(&newest.workspace, &second);
    next.discard(offers[1].id);
    // In the order of orders: this is answered when all before it is done.
    keep(&mut next, &newest.workspace);
    drop(next);
    let mut last = autosave(place.path());
    let offers = found(&mut last);
    let summaries: Vec<_> = offers.iter().map(|f| f.summary.primitives).collect();
    assert_eq!(offers.len(), 2, "{summaries:?}");
    for offer in &offers {
        last.discard(offer.id);
    }
    last.close(None);
    assert_eq!(files(place.path()), [""; 0]);
}

#[test]
fn a_window_that_is_closed_leaves_its_unsaved_work_as_the_last_session() {
    let place = TempDir::new().unwrap();
    let material = material();
    let [first, second, third] = [1, 2, 3].map(|count| workspace(material.document(count), &[], &[]));
    let mut saved = autosave(place.path());
    keep(&mut saved, &first);
    saved.close(None);
    assert_eq!(files(place.path()), [""; 0], "nothing is left of saved work");
    let mut unsaved = autosave(place.path());
    keep(&mut unsaved, &first);
    unsaved.close(Some(second.clone()));
    assert_eq!(files(place.path()), ["last.superform"]);
    let mut next = autosave(place.path());
    assert!(wait(&mut next, |event| if let Event::HasLast(has) = event { Some(has) } else { None }));
    // What stood in the window changes places with it.
    let opened = open(&mut next, Origin::Last, Some(third.clone()));
    assert_same(&opened.workspace, &second);
    let opened = open(&mut next, Origin::Last, None);
    assert_same(&opened.workspace, &third);
    // Where the file can't be read, the present session stays.
    keep(&mut next, &third);
    next.open(Origin::File(place.path().join("nowhere.superform")), Some(first));
    let (what, error) =
        wait(
            &mut next,
            |event| if let Event::Failed { what, error } = event { Some((what, error)) } else { None },
        );
    assert!(
        what.contains("Cannot open ")
            && what.ends_with("nowhere.superform")
            && error.contains("check the name")
    );
    assert_eq!(files(place.path()).len(), 3, "{:?}", files(place.path()));
}

#[test]
fn a_session_is_saved_by_the_thread_and_comes_back() {
    let place = TempDir::new().unwrap();
    let path = place.path().join("mine.superform");
    let material = material();
    let session = workspace(material.branched(&[1, 3]), &[material.document(2)], &[]);
    // Without a folder for journals, files can be written all the same.
    let mut autosave = Autosave::spawn(None, || {}).unwrap();
    autosave.keep(session.clone());
    autosave.save(path.clone(), session.clone());
    wait(&mut autosave, |event| matches!(event, Event::Saved { .. }).then_some(()));
    let opened = open(&mut autosave, Origin::File(path.clone()), None);
    assert_same(&opened.workspace, &session);
    autosave.save(path.join("in a file"), session);
    let error =
        wait(&mut autosave, |event| if let Event::Failed { error, .. } = event { Some(error) } else { None });
    assert!(error.contains("cannot write"), "{error}");
}

#[test]
fn trouble_with_the_disk_is_told_once_and_over_when_it_is_over() {
    let place = TempDir::new().unwrap();
    let folder = place.path().join("state");
    std::fs::write(&folder, "in the way").unwrap();
    let mut autosave = autosave(&folder);
    let session = workspace(material().document(2), &[], &[]);
    autosave.keep(session.clone());
    let text = wait(&mut autosave, |event| if let Event::NotKept(text) = event { Some(text) } else { None });
    assert!(
        text.contains("state") && text.contains("save the session elsewhere") && !text.contains("room"),
        "{text}"
    );
    autosave.keep(session.clone());
    autosave.save(place.path().join("a.superform"), session.clone());
    let next = autosave.next_event(PATIENCE).unwrap();
    assert!(matches!(next, Event::Saved { .. }), "it is not told again: {next:?}");
    std::fs::remove_file(&folder).unwrap();
    keep(&mut autosave, &session);
    autosave.close(Some(session));
    assert_eq!(files(&folder), ["last.superform"]);
}
