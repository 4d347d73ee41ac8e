//! A run taken apart and put together again goes on as if nothing had been.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

use super::{gate, same_bits};
use crate::geometry::SampleCloud;
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::data::abstraction::{Phase, UNASSIGNED};
use crate::inference::method::Method;
use crate::inference::params::{Algorithm, MergeRule, Params};
use crate::inference::runs::checkpoint::{Checkpoint, Remaining};
use crate::inference::runs::run::Run;

fn cloud(n: usize) -> Arc<SampleCloud> {
    Arc::new(SampleCloud::from_points(&gate(n)))
}

fn never() -> Cancel {
    Cancel::default()
}

/// Through text and back, on the same cloud loaded anew.
fn reborn(run: &Run, points: &[Point3<f64>]) -> Run {
    let saved = run.checkpoint();
    let text = serde_json::to_string(&saved).unwrap();
    let read: Checkpoint = serde_json::from_str(&text).unwrap();
    assert_eq!(saved, read, "the text lost something");
    let here = run.resumed(&saved, &never()).unwrap();
    assert!(same_bits(&here.abstraction(), &run.abstraction()));
    assert_eq!(here.checkpoint(), saved);
    Run::resume(Arc::new(SampleCloud::from_points(points)), &read, &never()).unwrap()
}

#[test]
fn every_method_goes_on_from_every_step_with_the_same_bits() {
    let points = gate(400);
    for method in Method::ALL {
        let params = Params { iterations: 17, clusters: 8, ..method.params() };
        let mut whole = Run::new(Arc::new(SampleCloud::from_points(&points)), params, &never()).unwrap();
        // This one is taken apart at every step.
        let mut primitives = reborn(&whole, &points);
        while !whole.is_finished() {
            let told = whole.step(&never()).unwrap();
            assert_eq!(told, primitives.step(&never()).unwrap(), "{method}");
            assert!(same_bits(&whole.abstraction(), &primitives.abstraction()), "{method}");
            assert_eq!(whole.checkpoint(), primitives.checkpoint(), "{method}");
            primitives = reborn(&primitives, &points);
        }
        assert!(primitives.is_finished(), "{method}");
        assert_eq!(primitives.abstraction().phase, Phase::Finished);
        assert!(primitives.step(&never()).unwrap().is_empty());
    }
}

#[test]
fn merges_by_hand_go_on_with_the_same_bits() {
    let points = gate(500);
    for merge in [MergeRule::Energy, MergeRule::Paper] {
        let params = Params { iterations: 3, clusters: 12, ..Params::default() };
        let mut whole = Run::new(Arc::new(SampleCloud::from_points(&points)), params, &never()).unwrap();
        // No merge pass yet.
        for _ in 0..2 {
            whole.step(&never()).unwrap();
        }
        whole.set_params(Params { merge, ..params }).unwrap();
        let mut primitives = reborn(&whole, &points);
        let mut merges = 0;
        loop {
            let report = whole.step_merge(&never()).unwrap();
            assert_eq!(report, primitives.step_merge(&never()).unwrap());
            primitives = reborn(&primitives, &points);
            assert_eq!(whole.checkpoint(), primitives.checkpoint());
            if report.is_empty() {
                break;
            }
            merges += report.len();
        }
        assert!(merges > 1, "{merge:?}: nothing to tell the two apart");
        whole.step(&never()).unwrap();
        primitives.step(&never()).unwrap();
        assert!(same_bits(&whole.abstraction(), &primitives.abstraction()));
    }
}

#[test]
fn a_damaged_checkpoint_is_refused_in_words() {
    let params = Params { iterations: 2, clusters: 6, ..Params::default() };
    let mut run = Run::new(cloud(400), params, &never()).unwrap();
    run.step(&never()).unwrap();
    let good = run.checkpoint();
    type Harm = fn(&mut Checkpoint);
    let harms: [(Harm, &str); 18] = [
        (|c| c.params.alpha = f64::NAN, "alpha"),
        (|c| c.labels.truncate(100), "labels for 100 samples"),
        (|c| c.labels[3] = 77, "labelled 77"),
        (|c| c.frozen = vec![5, 4], "order"),
        (|c| c.pinned = vec![1_000_000], "order"),
        (
            |c| {
                c.labels[9] = UNASSIGNED;
                c.pinned = vec![9];
            },
            "pinned",
        ),
        (|c| c.iteration = u32::MAX, "counters"),
        (|c| c.next_id = u32::MAX, "counters"),
        (|c| c.next_revision = u64::MAX, "counters"),
        (|c| c.next_id = 1, "id"),
        (|c| c.clusters[1].id = c.clusters[0].id, "id"),
        (|c| c.clusters[0].shape.semi_axes.x = f64::NAN, "shape"),
        (|c| c.clusters[0].shape.translation = Vector3::repeat(1e300), "shape"),
        (|c| c.clusters[0].shape.exponents[0] = 0.0, "shape"),
        (
            |c| {
                c.clusters[0].shape.rotation =
                    nalgebra::Rotation3::from_matrix_unchecked(nalgebra::Matrix3::repeat(1.0));
            },
            "shape",
        ),
        (|c| c.clusters[0].sigma = 0.0, "σ"),
        (|c| c.clusters[0].revision = c.next_revision, "revision"),
        (|c| c.work = Remaining::Fits(0), "remaining work"),
    ];
    for (harm, word) in harms {
        let mut bad = good.clone();
        harm(&mut bad);
        match run.resumed(&bad, &never()) {
            Err(InferenceError::Checkpoint(text)) => assert!(text.contains(word), "{text}"),
            other => panic!("{word}: {:?}", other.map(|r| r.iteration())),
        }
        assert!(Run::resume(cloud(400), &bad, &never()).is_err());
    }
    // Of a baseline, too.
    for (algorithm, work) in [
        (Algorithm::KMeans, Remaining::Fits(usize::MAX)),
        (
            Algorithm::HierarchicalEms,
            Remaining::Parts(vec![crate::inference::runs::checkpoint::Part { points: vec![], depth: 0 }]),
        ),
        (Algorithm::Ems, Remaining::Sampler),
    ] {
        let run = Run::new(cloud(400), Params { algorithm, ..params }, &never()).unwrap();
        let bad = Checkpoint { work, ..run.checkpoint() };
        assert!(matches!(run.resumed(&bad, &never()), Err(InferenceError::Checkpoint(_))));
    }
    let other = Run::resume(cloud(500), &good, &never());
    assert!(matches!(other, Err(InferenceError::Checkpoint(_))), "a checkpoint of another cloud");
}
