//! The session file: everything comes back, nothing is half there, and nothing
//! that a file claims brings the program down.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::material::{Material, assert_same, assert_same_document, bytes, empty_document, workspace};
use proptest::prelude::*;
use rayon::prelude::*;
use superform::geometry::SamplingOptions;
use superform::inference::{Algorithm, Cancel, Params, Run};
use superform::io;
use superform::project::{self, OpenError, Opened};
use superform::session::saving::{KeepingEvent, Opening};
use superform::session::timeline::{Origin, Timeline};
use superform::session::workspace::Workspace;
use superform::session::{Action, Session, Verb};
use superform::worker::{Activity, Command, Event, Snapshot, Worker};
use tempfile::TempDir;

/// Opens these bytes as a file.
fn open(content: &[u8]) -> Result<Opened, OpenError> {
    let folder = TempDir::new().unwrap();
    project::open(&put(&folder, content))
}

fn put(folder: &TempDir, content: &[u8]) -> PathBuf {
    let path = folder.path().join("a.superform");
    fs::write(&path, content).unwrap();
    path
}

/// Two shapes and runs of all algorithms, some of them not finished.
fn materials() -> Vec<Material> {
    use Algorithm::{Ems, HierarchicalEms, KMeans, Sampler};
    [
        (1, true, Sampler, 99),
        (2, false, Sampler, 3),
        (3, false, KMeans, 2),
        (4, true, Ems, 3),
        (5, true, HierarchicalEms, 3),
    ]
    .map(|(generation, is_mesh, algorithm, most)| Material::new(generation, is_mesh, algorithm, most))
    .to_vec()
}

/// A session with a history that goes back to another shape.
fn rich() -> Workspace {
    let all = materials();
    workspace(
        all[0].branched(&[9, 2, 4]),
        &[empty_document(), all[1].document(2), all[0].document(1)],
        &[all[2].document(2)],
    )
}

/// A small one, so that every byte can be tried.
fn small() -> Workspace {
    let material = Material::new(1, true, Algorithm::Sampler, 2);
    workspace(material.document(2), &[material.document(1)], &[])
}

#[test]
fn a_session_comes_back_whole_and_the_same_bytes_are_written_of_it() {
    let workspace = rich();
    let Opened { workspace: back, notes } = open(&bytes(&workspace)).unwrap();
    assert_same(&workspace, &back);
    assert_eq!(notes, [""; 0]);
    // From now on the present shape is the newest, and all stays as it is.
    let again = bytes(&back);
    assert_eq!(bytes(&open(&again).unwrap().workspace), again);
}

#[test]
fn what_was_shared_is_written_once_and_shared_again() {
    let material = Material::new(1, true, Algorithm::Sampler, 99);
    let count = material.states.len();
    let once = bytes(&workspace(material.document(count), &[], &[]));
    let often: Vec<_> = (0..50).map(|i| material.branched(&[count, 1 + i % count])).collect();
    let workspace = workspace(material.document(count), &often, &often);
    let all = bytes(&workspace);
    assert!(all.len() < once.len() + 100 * 300, "{} for one, {} for 101", once.len(), all.len());
    let back = open(&all).unwrap().workspace;
    let steps = back.undo.done().iter().chain(back.undo.undone()).map(|step| &step.document);
    let documents: Vec<_> = steps.chain([&back.document]).collect();
    let shapes: BTreeSet<_> = documents.iter().map(|d| Arc::as_ptr(d.loaded.as_ref().unwrap())).collect();
    assert_eq!(shapes.len(), 1);
    let branches = documents.iter().flat_map(|d| d.timeline.branches());
    let states: BTreeSet<_> = branches.flat_map(|b| &b.states).map(Arc::as_ptr).collect();
    assert_eq!(states.len(), count);
    let keys: BTreeSet<u64> = back.document.timeline.keys();
    assert!(keys.is_disjoint(&workspace.document.timeline.keys()), "keys are of this process");
}

#[test]
fn a_run_goes_on_from_the_file_with_the_same_bits() {
    for material in materials() {
        let cancel = Cancel::default();
        let state = material.states.last().unwrap();
        let cloud = Arc::clone(&material.loaded.cloud);
        let workspace = workspace(material.document(99), &[], &[]);
        let back = open(&bytes(&workspace)).unwrap().workspace.document;
        let shown = back.timeline.shown_state().unwrap();
        let mut here = Run::resume(cloud, &state.checkpoint, &cancel).unwrap();
        let mut there =
            Run::resume(Arc::clone(&shown.loaded.cloud), &shown.snapshot.checkpoint, &cancel).unwrap();
        assert_eq!(here.abstraction(), there.abstraction());
        for _ in 0..3 {
            if here.is_finished() {
                break;
            }
            assert_eq!(here.step(&cancel).unwrap(), there.step(&cancel).unwrap());
            assert_eq!(here.abstraction(), there.abstraction());
        }
    }
}

#[test]
fn the_present_shape_is_the_newest_so_that_later_ones_are_newer_still() {
    let all = materials();
    let workspace =
        workspace(all[0].document(9), &[all[1].document(2)], &[all[2].document(1), all[0].document(2)]);
    let back = open(&bytes(&workspace)).unwrap().workspace;
    let generation = |d: &superform::session::document::Document| d.loaded.as_ref().unwrap().generation;
    let steps = back.undo.done().iter().chain(back.undo.undone());
    let others: Vec<u64> = steps.map(|step| generation(&step.document)).collect();
    assert_eq!(generation(&back.document), 3);
    assert_eq!(others, [2, 1, 3]);
    for document in [&back.document, &back.undo.done()[0].document] {
        for branch in document.timeline.branches() {
            assert!(branch.states.iter().all(|s| s.generation == branch.loaded.generation));
        }
    }
}

#[test]
fn a_file_that_was_cut_off_opens_with_what_was_whole_or_not_at_all() {
    let workspace = small();
    let whole = bytes(&workspace);
    let mut seen = [0; 3];
    let folder = TempDir::new().unwrap();
    for length in 0..whole.len() {
        match project::open(&put(&folder, &whole[..length])) {
            Ok(Opened { workspace: found, notes }) => {
                // The document comes first, then what undo goes back to.
                assert!(found.undo.done().is_empty() && found.undo.undone().is_empty());
                assert_same_document(&found.document, &workspace.document);
                let is_at_record = notes.is_empty();
                assert!(is_at_record || notes[0].contains("damaged at byte"), "{notes:?}");
                seen[usize::from(is_at_record)] += 1;
            }
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains("a.superform"), "{text}");
                seen[2] += 1;
            }
        }
    }
    assert!(seen[0] > 50 && seen[1] > 0 && seen[2] > 1000, "{seen:?}");
}

#[test]
fn a_changed_byte_is_noticed_wherever_it_is() {
    let workspace = small();
    let whole = bytes(&workspace);
    let folder = TempDir::new().unwrap();
    let mut opened = 0;
    for at in 0..whole.len() {
        let mut content = whole.clone();
        content[at] ^= 1 << (at % 8);
        match project::open(&put(&folder, &content)) {
            Ok(Opened { workspace: found, notes }) => {
                assert!(found.undo.done().is_empty() && found.undo.undone().is_empty());
                assert_same_document(&found.document, &workspace.document);
                assert!(notes[0].contains("damaged at byte"), "{notes:?}");
                opened += 1;
            }
            Err(OpenError::NotASession { .. }) => assert!(at < 14, "byte {at}"),
            Err(OpenError::Damaged { byte, .. }) => assert!(at >= 14 && byte <= at as u64, "byte {at}"),
            Err(error) => panic!("byte {at}: {error}"),
        }
    }
    assert!(opened > 50);
}

/// A header of that format.
fn header(format: u16, program: &[u8; 12]) -> Vec<u8> {
    let mut header = b"\x89Superform\r\n\x1a\n".to_vec();
    header.extend(format.to_le_bytes());
    header.extend(program);
    header.extend(crc32fast::hash(&header).to_le_bytes());
    header
}

/// A frame with a right checksum, whatever it claims.
fn record(kind: u8, packing: u8, stored: u64, length: u64, content: &[u8]) -> Vec<u8> {
    let mut frame = vec![kind, packing, 0, 0];
    frame.extend(stored.to_le_bytes());
    frame.extend(length.to_le_bytes());
    let mut sum = crc32fast::Hasher::new();
    sum.update(&frame);
    sum.update(content);
    frame.extend(sum.finalize().to_le_bytes());
    frame.extend(content);
    frame
}

#[test]
fn what_is_no_session_or_too_new_is_refused_with_what_to_do() {
    let newer = header(7, b"12.3.4\0\0\0\0\0\0");
    let text = open(&newer).unwrap_err().to_string();
    assert!(text.contains("format 7") && text.contains("open it with Superform 12.3.4 or later"), "{text}");
    let text = open(b"v 0 0 0\nv 1 0 0\n").unwrap_err().to_string();
    assert!(text.contains("is not a Superform session"), "{text}");
    let text = open(b"").unwrap_err().to_string();
    assert!(text.contains("is empty"), "{text}");
    let text = project::open(Path::new("no such folder/a.superform")).unwrap_err().to_string();
    assert!(text.contains("check the name"), "{text}");
    assert!(matches!(project::open(TempDir::new().unwrap().path()), Err(OpenError::NotAFile { .. })));
    let text = open(&header(1, b"0.1.0\0\0\0\0\0\0\0")).unwrap_err().to_string();
    assert!(text.contains("it contains no session") && text.contains("use a backup copy"), "{text}");
    // Where a shape is wanted.
    let folder = TempDir::new().unwrap();
    let text = io::read(&put(&folder, &bytes(&small()))).unwrap_err().to_string();
    assert!(text.contains("a Superform session"), "{text}");
}

#[test]
fn lengths_that_cant_be_are_refused_before_memory_is_taken() {
    const HUGE: u64 = 1_000_000_000_000;
    let start = header(1, b"0.1.0\0\0\0\0\0\0\0");
    let content = [0u8; 100];
    // Deflate of nothing, and what claims to become more than it can.
    for (kind, packing, stored, length) in [
        (7, 0, HUGE, HUGE),
        (7, 1, HUGE, HUGE),
        (7, 1, 100, HUGE),
        (7, 0, 100, HUGE),
        (7, 2, 100, 100),
        (0, 0, 100, 100),
        (99, 0, 100, 100),
        (7, 1, 100, 5),
        (7, 0, 100, 100),
        (7, 0, u64::MAX, u64::MAX),
        (7, 1, 100, u64::MAX),
    ] {
        let file = [start.clone(), record(kind, packing, stored, length, &content)].concat();
        assert!(matches!(open(&file), Err(OpenError::Damaged { .. })), "{kind} {packing} {stored} {length}");
    }
    // MessagePack: an array of 2³² − 1, a string of 2³² − 1, and arrays in arrays.
    let deep = [0x91u8; 100_000];
    for content in [&[0xdd, 0xff, 0xff, 0xff, 0xff][..], &[0xdb, 0xff, 0xff, 0xff, 0xff], &deep] {
        for kind in 1..=7 {
            let length = content.len() as u64;
            let file = [start.clone(), record(kind, 0, length, length, content)].concat();
            assert!(matches!(open(&file), Err(OpenError::Damaged { .. })));
        }
    }
}

#[test]
fn a_failed_save_leaves_the_old_file() {
    let folder = TempDir::new().unwrap();
    let path = put(&folder, b"old");
    let text = project::save(&path.join("inside"), &small()).unwrap_err().to_string();
    assert!(text.contains("cannot write"), "{text}");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    project::save(&path, &small()).unwrap();
    assert_eq!(fs::read(&path).unwrap(), bytes(&small()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn any_session_comes_back(
        present in proptest::collection::vec(0usize..9, 1..4),
        of in 0usize..5,
        done in proptest::collection::vec((0usize..5, 0usize..9), 0..6),
        undone in proptest::collection::vec((0usize..5, 0usize..9), 0..3),
    ) {
        let all = materials();
        let documents = |picks: &[(usize, usize)]| -> Vec<_> {
            picks.iter().map(|&(of, count)| all[of].document(count)).collect()
        };
        let workspace = workspace(all[of].branched(&present), &documents(&done), &documents(&undone));
        assert_same(&workspace, &open(&bytes(&workspace)).unwrap().workspace);
    }

    #[test]
    fn no_bytes_bring_it_down(tail in proptest::collection::vec(any::<u8>(), 0..400), cut in 0usize..4000) {
        let mut content = bytes(&small());
        content.truncate(cut);
        content.extend(tail);
        let _ = open(&content);
    }
}

/// A place in MessagePack: a value with all that it holds.
#[derive(Debug, Clone)]
struct Place {
    at: std::ops::Range<usize>,
    is_list: bool,
}

/// Walks the value at `at`; all numbers, arrays and byte strings in it go to
/// `places`, of an array's elements the first and the last. Where it ends.
fn walk(bytes: &[u8], at: usize, places: &mut Vec<Place>) -> usize {
    let big = |from: usize, count: usize| {
        bytes[from..from + count].iter().fold(0usize, |n, b| n << 8 | *b as usize)
    };
    let (kind, is_map, count, mut next) = match bytes[at] {
        0x80..=0x8f => ('n', true, usize::from(bytes[at] & 15), at + 1),
        0xde => ('n', true, big(at + 1, 2), at + 3),
        0xdf => ('n', true, big(at + 1, 4), at + 5),
        0x90..=0x9f => ('n', false, usize::from(bytes[at] & 15), at + 1),
        0xdc => ('n', false, big(at + 1, 2), at + 3),
        0xdd => ('n', false, big(at + 1, 4), at + 5),
        0xa0..=0xbf => ('s', false, 0, at + 1 + usize::from(bytes[at] & 31)),
        0xd9 => ('s', false, 0, at + 2 + big(at + 1, 1)),
        0xda => ('s', false, 0, at + 3 + big(at + 1, 2)),
        0xdb => ('s', false, 0, at + 5 + big(at + 1, 4)),
        0xc4 => ('b', false, 0, at + 2 + big(at + 1, 1)),
        0xc5 => ('b', false, 0, at + 3 + big(at + 1, 2)),
        0xc6 => ('b', false, 0, at + 5 + big(at + 1, 4)),
        0xc0 | 0xc2 | 0xc3 => ('s', false, 0, at + 1),
        0x00..=0x7f | 0xe0..=0xff => ('#', false, 0, at + 1),
        0xcc | 0xd0 => ('#', false, 0, at + 2),
        0xcd | 0xd1 => ('#', false, 0, at + 3),
        0xca | 0xce | 0xd2 => ('#', false, 0, at + 5),
        0xcb | 0xcf | 0xd3 => ('#', false, 0, at + 9),
        other => panic!("{other:#x} is nothing that is written"),
    };
    for i in 0..count {
        if is_map {
            next = walk(bytes, next, &mut Vec::new());
        }
        let mut inner = Vec::new();
        next = walk(bytes, next, &mut inner);
        if is_map || i == 0 || i + 1 == count {
            places.extend(inner);
        }
    }
    if kind == '#' || kind == 'b' || (kind == 'n' && !is_map) {
        places.push(Place { at: at..next, is_list: kind != '#' });
    }
    next
}

/// A session as its records, unpacked.
fn unpacked(file: &[u8]) -> Vec<(u8, Vec<u8>)> {
    use std::io::Read;
    let eight = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
    let mut records = Vec::new();
    let mut at = 32;
    while at < file.len() {
        let stored = &file[at + 24..at + 24 + eight(at + 4)];
        let mut content = Vec::new();
        match file[at + 1] {
            0 => content.extend(stored),
            _ => drop(flate2::read::DeflateDecoder::new(stored).read_to_end(&mut content).unwrap()),
        }
        records.push((file[at], content));
        at += 24 + stored.len();
    }
    records
}

fn packed(records: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let records = records.iter().map(|(kind, content)| {
        let length = content.len() as u64;
        record(*kind, 0, length, length, content)
    });
    std::iter::once(header(1, b"0.1.0\0\0\0\0\0\0\0")).chain(records).flatten().collect()
}

/// What a person may do with a session that has just been opened.
fn use_it(Opened { workspace, notes }: Opened) -> Session {
    let mut session = Session::new(Params::default(), SamplingOptions::default());
    let from = Opening::File("a.superform".into());
    session.absorb_keeping(KeepingEvent::Opened { from, workspace: Box::new(workspace), notes });
    let steps = session.undo.done().len() + session.undo.undone().len();
    for _ in 0..=steps {
        session.apply(Action::Verb(Verb::Undo));
        session.background();
    }
    for _ in 0..=steps {
        session.apply(Action::Verb(Verb::Redo));
    }
    let branches: Vec<u32> = session.timeline.branches().iter().map(|b| b.id).collect();
    for id in branches {
        session.apply(Action::SwitchBranch(id));
        for index in 0..session.timeline.states().len() {
            session.apply(Action::ShowState(index));
        }
        session.apply(Action::Verb(Verb::FirstState));
        session.apply(Action::Verb(Verb::Play));
        session.apply(Action::PlayOn(0.7));
        session.apply(Action::PlayOn(f64::MAX));
    }
    session.apply(Action::Verb(Verb::FrameAll));
    session.apply(Action::Verb(Verb::ContinueHere));
    assert!(!bytes(&session.workspace()).is_empty());
    session
}

/// Every number of a session replaced by those that overflow, and every array by
/// none and by a longer one: an error of the file, or a session that can be used.
#[test]
fn numbers_that_overflow_are_an_error_of_the_file() {
    let float = |value: f64| [&[0xcb][..], &value.to_be_bytes()].concat();
    let whole = |value: u64| [&[0xcf][..], &value.to_be_bytes()].concat();
    let numbers = [
        vec![0x00],
        vec![0xff],
        whole(u64::MAX),
        whole(u64::from(u32::MAX)),
        whole(1 << 53),
        vec![0xd3, 0x80, 0, 0, 0, 0, 0, 0, 0],
        float(f64::NAN),
        float(f64::INFINITY),
        float(f64::NEG_INFINITY),
        float(1e308),
        float(-1e308),
    ];
    let first = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(FIRST_FORMAT)).unwrap();
    let material = Material::new(2, false, Algorithm::Sampler, 2);
    let fresh = bytes(&workspace(material.branched(&[2, 1]), &[material.document(1)], &[]));
    let ems = Material::new(1, true, Algorithm::Ems, 2);
    let mut opened = Vec::new();
    let mut refused = 0;
    for file in [first, fresh, bytes(&workspace(ems.document(2), &[], &[]))] {
        let records = unpacked(&file);
        assert!(open(&packed(&records)).is_ok_and(|o| o.notes.is_empty()), "nothing was changed yet");
        let mut cases = Vec::new();
        for (number, (_, content)) in records.iter().enumerate() {
            let mut places = Vec::new();
            assert_eq!(walk(content, 0, &mut places), content.len());
            for Place { at, is_list } in places {
                let longer =
                    |marker: u8, count: u8| [&[marker, count][..], &vec![1; usize::from(count)]].concat();
                let others = match (is_list, content[at.start]) {
                    (false, _) => numbers.to_vec(),
                    (true, 0xc4..=0xc6) => {
                        vec![vec![0xc4, 0], longer(0xc4, 24), longer(0xc4, 240), longer(0xc4, 7)]
                    }
                    (true, _) => vec![vec![0x90], vec![0x91, 1], [&[0xdc, 0, 70][..], &[1; 70]].concat()],
                };
                cases.extend(others.into_iter().map(|other| (number, at.clone(), other)));
            }
        }
        assert!(cases.len() > 500, "{} cases", cases.len());
        let outcomes: Vec<Option<Session>> = cases
            .par_iter()
            .map(|(number, at, other)| {
                let mut changed = records.clone();
                changed[*number].1.splice(at.clone(), other.iter().copied());
                match open(&packed(&changed)) {
                    Ok(opened) => Some(use_it(opened)),
                    Err(OpenError::Damaged { problem, .. }) => {
                        assert!(!problem.is_empty());
                        None
                    }
                    Err(other) => panic!("{other}"),
                }
            })
            .collect();
        refused += outcomes.iter().filter(|o| o.is_none()).count();
        opened.extend(outcomes.into_iter().flatten());
    }
    assert!(refused > 1000 && opened.len() > 100, "{refused} were refused, {} opened", opened.len());
    // Of those that could be opened, runs go on: of each different state once.
    let mut worker = Worker::spawn(|| {}).unwrap();
    let mut seen = Vec::new();
    for session in opened {
        let Some(state) = session.shown_state() else { continue };
        let facts = (state.snapshot.checkpoint.clone(), state.snapshot.elapsed, state.snapshot.run);
        if seen.contains(&facts) {
            continue;
        }
        seen.push(facts);
        worker.send(Command::Resume(state));
        worker.send(Command::StepIteration);
        loop {
            match worker.next_event(std::time::Duration::from_secs(60)).expect("the worker has fallen silent")
            {
                Event::Ended { error, .. } => panic!("a thread has ended: {error}"),
                Event::Failed { what, error } => assert_ne!(what, superform::worker::FAULT, "{error}"),
                Event::Activity(Activity::Running) => {}
                Event::Activity(Activity::Idle) => break,
                _ => {}
            }
        }
    }
    assert!(seen.len() > 5, "only {} states were gone on from", seen.len());
}

#[test]
fn durations_counters_and_branches_that_cant_be_are_named() {
    let material = Material::new(1, true, Algorithm::Sampler, 2);
    type Change<'a> = &'a dyn Fn(&mut Snapshot);
    let problem = |change: Change<'_>| {
        let mut state = (*material.states[1]).clone();
        change(&mut state);
        let states = vec![Arc::clone(&material.states[0]), Arc::new(state)];
        let workspace = workspace(Material { states, ..material.clone() }.document(2), &[], &[]);
        open(&bytes(&workspace)).map(drop).map_err(|e| e.to_string())
    };
    assert_eq!(problem(&|_| ()), Ok(()));
    let cases: [(Change<'_>, &str); 5] = [
        (&|s| s.elapsed = std::time::Duration::MAX, "a duration out of range"),
        (&|s| s.run = u64::MAX, "a counter"),
        (&|s| s.generation = u64::MAX - 7, "a counter"),
        (&|s| s.abstraction.figures.mean_distance = f64::NAN, "a value"),
        (&|s| s.abstraction.iteration = u32::MAX, "a counter"),
    ];
    for (change, word) in cases {
        let text = problem(change).unwrap_err();
        assert!(text.contains("a.superform is damaged at byte") && text.contains(word), "{text}");
    }
    // Branches that leave each other would be followed for ever.
    let mut document = material.branched(&[2, 2]);
    let mut branches = document.timeline.branches().to_vec();
    for (branch, index) in [(1, 0), (0, 7)] {
        branches[1].origin = Some(Origin { branch, index });
        document.timeline = Timeline::from_parts(branches.clone(), 0, 0, 2).unwrap();
        let text = open(&bytes(&workspace(document.clone(), &[], &[]))).unwrap_err().to_string();
        assert!(text.contains("starts at a state that does not exist in its parent branch"), "{text}");
    }
}

/// A file of format 1, kept as it was written first: a box with two states, one
/// step to undo.
const FIRST_FORMAT: &str = "tests/data/session-1.superform";

#[test]
fn a_file_of_the_first_format_opens() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(FIRST_FORMAT);
    let Opened { workspace, notes } = project::open(&path).unwrap();
    assert_eq!(notes, [""; 0]);
    let document = &workspace.document;
    assert_eq!(document.loaded.as_ref().unwrap().shape.name, "box.obj");
    assert_eq!(document.timeline.states().len(), 2);
    assert_eq!(workspace.undo.done()[0].label, "done 0");
    let state = document.timeline.shown_state().unwrap();
    let run = Run::resume(Arc::clone(&state.loaded.cloud), &state.snapshot.checkpoint, &Cancel::default());
    assert_eq!(run.unwrap().abstraction().labels, state.snapshot.abstraction.labels);
}

/// Writes the file anew. Only for the first of a format: those that follow have
/// to read it.
#[test]
#[ignore = "writes the file that another test reads"]
fn write_a_file_of_the_present_format() {
    project::save(&Path::new(env!("CARGO_MANIFEST_DIR")).join(FIRST_FORMAT), &small()).unwrap();
}
