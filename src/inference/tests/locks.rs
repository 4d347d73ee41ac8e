//! Locked primitives: the sampler leaves them and their points alone.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{check, gate, same_bits, short};
use crate::geometry::SampleCloud;
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::{Abstraction, Phase, Primitive};
use crate::inference::params::{Algorithm, Params};
use crate::inference::runs::edit::Edit;
use crate::inference::runs::run::Run;

fn never() -> Cancel {
    Cancel::default()
}

fn started(n: usize, params: Params) -> Run {
    Run::new(Arc::new(SampleCloud::from_points(&gate(n))), params, &never()).unwrap()
}

fn lock(run: &mut Run, count: usize) -> Vec<u32> {
    let a = run.abstraction();
    let mut order: Vec<_> = a.primitives.iter().map(|p| (std::cmp::Reverse(p.points), p.id)).collect();
    order.sort_unstable();
    let ids: Vec<u32> = order.into_iter().map(|o| o.1).take(count).collect();
    for &id in &ids {
        run.edit(&Edit::Lock { id, locked: true }, &never()).unwrap();
    }
    ids
}

fn primitive(a: &Abstraction, id: u32) -> &Primitive {
    a.primitives.iter().find(|p| p.id == id).unwrap()
}

fn points_of(a: &Abstraction, id: u32) -> BTreeSet<u32> {
    (0u32..).zip(a.labels.iter()).filter(|(_, l)| **l == id).map(|(i, _)| i).collect()
}

/// What is locked in `before` is as it was; more points only where the
/// refinement may have given it some.
fn assert_kept(before: &Abstraction, now: &Abstraction, ids: &[u32]) {
    for &id in ids {
        let (old, new) = (primitive(before, id), primitive(now, id));
        assert!(new.locked);
        assert_eq!((old.shape, old.sigma.to_bits()), (new.shape, new.sigma.to_bits()), "{id} has changed");
        let (old, new) = (points_of(before, id), points_of(now, id));
        if now.phase == Phase::Finished {
            assert!(old.is_subset(&new), "{id} has lost points");
        } else {
            assert_eq!(old, new, "the points of {id}, iteration {}", now.iteration);
        }
    }
}

#[test]
fn a_run_leaves_alone_what_is_locked() {
    for params in [short(), Params { iterations: 17, clusters: 12, ..Params::paper() }] {
        for (steps, count) in [(1, 2), (3, 1), (0, 4)] {
            let mut run = started(600, params);
            for _ in 0..steps {
                run.step(&never()).unwrap();
            }
            let ids = lock(&mut run, count);
            let before = run.abstraction();
            let mut changed = false;
            while !run.is_finished() {
                run.step(&never()).unwrap();
                let now = run.abstraction();
                check(&now, before.labels.len());
                assert_kept(&before, &now, &ids);
                changed |= now.primitives.iter().any(|p| !p.locked && p.shape != before.primitives[0].shape);
            }
            assert!(changed, "nothing happened at all");
            // By hand it stays, too.
            let end = run.abstraction();
            while !run.step_merge(&never()).unwrap().is_empty() {}
            assert_kept(&end, &run.abstraction(), &ids);
            // Until it is unlocked.
            for &id in &ids {
                run.edit(&Edit::Lock { id, locked: false }, &never()).unwrap();
            }
            run.resample(2).unwrap();
            run.step(&never()).unwrap();
            let now = run.abstraction();
            let is_same = |id: &u32| {
                now.primitives.iter().any(|p| p.id == *id && p.sigma == primitive(&end, *id).sigma)
            };
            assert!(!ids.iter().any(is_same), "σ was not drawn again");
        }
    }
}

#[test]
fn a_restart_keeps_what_is_locked_and_starts_on_the_rest() {
    let mut run = started(600, short());
    while !run.is_finished() {
        run.step(&never()).unwrap();
    }
    let ids = lock(&mut run, 1);
    let before = run.abstraction();
    for params in [Params { seed: 5, clusters: 4, ..short() }, Params { clusters: 500, ..Params::paper() }] {
        let mut again = run.restarted(params, &never()).unwrap();
        let start = again.abstraction();
        check(&start, before.labels.len());
        assert_kept(&before, &Abstraction { phase: Phase::Start, ..start.clone() }, &ids);
        assert_eq!((start.phase, start.iteration, start.figures.unassigned), (Phase::Start, 0, 0));
        let free = before.labels.len() - points_of(&before, ids[0]).len();
        assert_eq!(start.primitives.len(), 1 + free.min(params.clusters as usize));
        // It is a start as any other.
        let mut other = again.resumed(&again.checkpoint(), &never()).unwrap();
        while !again.is_finished() {
            again.step(&never()).unwrap();
            other.step(&never()).unwrap();
            assert!(same_bits(&again.abstraction(), &other.abstraction()));
        }
        assert_kept(&before, &again.abstraction(), &ids);
    }
    // Baselines know no locks.
    let baseline = run.restarted(Params { algorithm: Algorithm::KMeans, ..short() }, &never()).unwrap();
    assert!(baseline.abstraction().primitives.iter().all(|p| !p.locked));
    assert!(same_bits(
        &baseline.abstraction(),
        &started(600, Params { algorithm: Algorithm::KMeans, ..short() }).abstraction()
    ));
}

#[test]
fn a_run_in_which_all_is_locked_ends_as_it_is() {
    let mut run = started(400, short());
    let count = run.abstraction().primitives.len();
    let ids = lock(&mut run, count);
    let before = run.abstraction();
    for mut run in [run.restarted(Params { seed: 3, ..short() }, &never()).unwrap(), run] {
        assert!(run.propose_merge(&[], &never()).unwrap().is_none(), "locked ones may merge");
        while !run.is_finished() {
            assert!(run.step(&never()).unwrap().is_empty());
        }
        assert_kept(&before, &run.abstraction(), &ids);
        assert_eq!(run.abstraction().labels, before.labels);
    }
}
