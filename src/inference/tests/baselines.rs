//! The baselines: recovery among outliers and from one side, and what holds of
//! every run.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::{Point3, Rotation3, Unit, Vector3};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use super::{block, cancelled_after, check, delays, gate, jitter, rng, same_bits, sampler, samples, scene};
use crate::geometry::{SampleCloud, Superquadric, tessellate};
use crate::inference::control::{Cancel, InferenceError};
use crate::inference::data::abstraction::{Abstraction, Figures, Phase, UNASSIGNED};
use crate::inference::method::Method;
use crate::inference::parameters::Setting;
use crate::inference::params::{Algorithm, MergeRule, Params};
use crate::inference::runs::run::Run;

const BASELINES: [Method; 3] = [Method::KMeans, Method::Ems, Method::HierarchicalEms];

fn run_of(points: &[Point3<f64>], params: Params) -> Run {
    Run::new(Arc::new(SampleCloud::from_points(points)), params, &Cancel::default()).unwrap()
}

/// All states of a run.
fn states(mut run: Run) -> Vec<Abstraction> {
    let mut states = vec![run.abstraction()];
    while !run.is_finished() {
        run.step(&Cancel::default()).unwrap();
        states.push(run.abstraction());
    }
    states
}

fn finish(run: Run) -> Abstraction {
    states(run).pop().unwrap()
}

/// Mean distance between two surfaces, there and back, in parts of √area of the
/// first.
fn between(truth: &Superquadric, found: &Superquadric) -> f64 {
    let fit_points = |from: &Superquadric, to: &Superquadric| {
        let points = samples(from, 700);
        points.iter().map(|x| to.first_order_distance(x)).sum::<f64>() / points.len() as f64
    };
    0.5 * (fit_points(truth, found) + fit_points(found, truth)) / tessellate::surface_area(truth).sqrt()
}

fn placed(shape: Superquadric, rng: &mut impl Rng) -> Superquadric {
    let turn = Vector3::from_fn(|_, _| rng.random_range(-2.0..2.0));
    let t = Vector3::from_fn(|_, _| rng.random_range(-3.0..3.0));
    Superquadric { rotation: Rotation3::new(turn), translation: t, ..shape }
}

/// An ellipsoid, a box, a cylinder and something between them.
fn kinds(rng: &mut impl Rng) -> [(&'static str, Superquadric); 4] {
    let mut axes = || Vector3::from_fn(|_, _| rng.random_range(0.4..1.0));
    let (a, b, c, d) = (axes(), axes(), axes(), axes());
    let shape = |exponents, semi_axes| Superquadric { exponents, semi_axes, ..block([0.0; 3], [1.0; 3]) };
    let between = [rng.random_range(0.2..1.5), rng.random_range(0.2..1.5)];
    [
        ("ellipsoid", shape([1.0, 1.0], a)),
        ("box", shape([0.1, 0.1], b)),
        ("cylinder", shape([0.1, 1.0], Vector3::new(c.x, c.x, c.y))),
        ("any exponents", shape(between, d)),
    ]
    .map(|(name, s)| (name, placed(s, rng)))
}

/// Recovers eight of each kind from what `see` gives of them, and demands a
/// rate within a distance.
fn demand(
    rate: f64,
    distance: f64,
    outlier_prior: f64,
    see: impl Fn(&Superquadric, u64) -> Vec<Point3<f64>>,
) {
    let mut missed = Vec::new();
    let mut tries = 0;
    for seed in 0..8 {
        for (name, truth) in kinds(&mut rng(100 + seed)) {
            tries += 1;
            let points = see(&truth, seed);
            let a = finish(run_of(&points, Params { outlier_prior, ..Method::Ems.params() }));
            check(&a, points.len());
            assert_eq!(a.primitives.len(), 1);
            let error = between(&truth, &a.primitives[0].shape);
            if error > distance {
                missed.push(format!("{name} {seed}, {error:.4} off"));
            }
        }
    }
    let found = 1.0 - missed.len() as f64 / f64::from(tries);
    assert!(found >= rate, "w0 = {outlier_prior}: only {found} recovered\n{}", missed.join("\n"));
}

/// Points of the whole surface with noise of 0.5 % of √area.
fn noisy(truth: &Superquadric, n: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut points = samples(truth, n);
    jitter(&mut points, 0.005 * tessellate::surface_area(truth).sqrt(), seed);
    points
}

/// Adds points drawn evenly from the box of the others, grown by a factor.
fn strew(points: &mut Vec<Point3<f64>>, n: usize, factor: f64, seed: u64) {
    let mut rng = rng(seed);
    let (mut lo, mut hi) = (points[0], points[0]);
    for p in points.iter() {
        (lo, hi) = (lo.inf(p), hi.sup(p));
    }
    let (center, half) = (nalgebra::center(&lo, &hi), (hi - lo) * 0.5 * factor);
    for _ in 0..n {
        points.push(center + half.map(|h| rng.random_range(-h..h)));
    }
}

#[test]
fn a_primitive_is_recovered_among_as_many_as_40_percent_outliers() {
    for outlier_prior in [0.3, 0.5, 0.7] {
        demand(0.95, 0.003, outlier_prior, |truth, seed| {
            let mut points = noisy(truth, 600, seed);
            let outliers = points.len() * 2 / 3;
            strew(&mut points, outliers, 1.3, seed);
            points
        });
    }
}

/// As a camera sees it: the points whose normals face the viewer. The hidden
/// half is what the smallest body that explains them has there.
#[test]
fn a_primitive_is_recovered_from_one_side() {
    demand(0.9, 0.025, 0.5, |truth, seed| {
        let mut rng = rng(seed);
        let view = Unit::new_normalize(Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng)));
        let spacing = (tessellate::surface_area(truth) / 1200.0).sqrt();
        let all = tessellate::surface_samples(truth, spacing, 9000);
        let mut seen: Vec<_> = all.into_iter().filter(|(_, n)| n.dot(&view) > 0.0).map(|s| s.0).collect();
        jitter(&mut seen, 0.005 * tessellate::surface_area(truth).sqrt(), seed);
        seen
    });
}

#[test]
fn outliers_stay_unassigned_and_the_surface_does_not() {
    for seed in 0..4 {
        for (name, truth) in kinds(&mut rng(seed)) {
            let mut points = noisy(&truth, 600, seed);
            let surface = points.len();
            strew(&mut points, 400, 1.3, seed);
            let a = finish(run_of(&points, Method::Ems.params()));
            let kept = a.labels[..surface].iter().filter(|l| **l != UNASSIGNED).count();
            assert!(kept * 20 >= surface * 19, "{name} {seed}: only {kept} of {surface} are kept");
            let thrown = a.labels[surface..].iter().filter(|l| **l == UNASSIGNED).count();
            // Some lie on the surface by chance.
            assert!(thrown * 10 >= 400 * 8, "{name} {seed}: only {thrown} of 400 are outliers");
        }
    }
}

#[test]
fn where_there_are_no_outliers_hardly_a_point_is_called_one() {
    for (name, truth) in kinds(&mut rng(3)) {
        let points = noisy(&truth, 600, 3);
        let a = finish(run_of(&points, Params { outlier_prior: 0.1, ..Method::Ems.params() }));
        assert!(a.figures.unassigned * 20 < points.len(), "{name}: {} outliers", a.figures.unassigned);
        assert!(between(&truth, &a.primitives[0].shape) < 0.003, "{name}");
    }
}

#[test]
fn kmeans_fits_each_cluster_once() {
    let points = gate(600);
    let params = Params { clusters: 9, ..Method::KMeans.params() };
    let states = states(run_of(&points, params));
    let start = sampler(&points, Params { clusters: 9, ..Params::default() }).abstraction();
    assert_eq!(states.len(), 1 + 9);
    // (But it has no prior of partitions.)
    let figures = Figures { log_joint: None, ..start.figures };
    assert!(same_bits(&states[0], &Abstraction { figures, ..start.clone() }), "it starts like the sampler");
    for (i, pair) in states.windows(2).enumerate() {
        check(&pair[1], points.len());
        assert_eq!(pair[1].labels, start.labels, "nothing is sampled");
        let changed = pair[0].primitives.iter().zip(pair[1].primitives.iter()).enumerate();
        let changed: Vec<usize> = changed.filter(|(_, (a, b))| a != b).map(|c| c.0).collect();
        assert_eq!(changed, [i], "step {i} fits one cluster");
        assert!(pair[1].primitives[i].mean_distance < 0.5 * pair[0].primitives[i].mean_distance);
    }
}

#[test]
fn hierarchical_ems_takes_one_part_after_another() {
    let boxes = [
        block([0.0; 3], [0.5, 0.5, 0.5]),
        block([3.0, 0.0, 0.0], [0.4, 0.8, 0.3]),
        block([0.0, 3.0, 0.0], [0.3, 0.3, 0.9]),
    ];
    let (mut points, of) = scene(&boxes, 1200);
    jitter(&mut points, 0.005, 1);
    let states = states(run_of(&points, Method::HierarchicalEms.params()));
    assert_eq!(states[0].primitives.len(), 0);
    for pair in states.windows(2) {
        check(&pair[1], points.len());
        let grown = pair[1].primitives.len() - pair[0].primitives.len();
        assert!(grown <= 1, "one step fits one primitive");
        // What has a primitive keeps it.
        for (before, after) in pair[0].labels.iter().zip(pair[1].labels.iter()) {
            assert!(*before == UNASSIGNED || before == after);
        }
    }
    let last = &states[states.len() - 1];
    for (j, truth) in boxes.iter().enumerate() {
        let nearest = last.primitives.iter().map(|p| between(truth, &p.shape)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.01, "box {j} is {nearest} from the nearest primitive");
    }
    // No primitive has points of two boxes: they do not touch.
    for p in last.primitives.iter() {
        let parts: BTreeSet<u32> =
            of.iter().zip(last.labels.iter()).filter(|x| *x.1 == p.id).map(|x| *x.0).collect();
        assert_eq!(parts.len(), 1);
    }
    // w0 = 0.9 asks of a point that it be ten times likelier of the surface.
    assert!(last.figures.unassigned * 4 < points.len(), "{} points are left", last.figures.unassigned);
}

#[test]
fn the_number_of_threads_does_not_change_a_bit_of_a_baseline() {
    let points = gate(500);
    for method in BASELINES {
        let on = |threads: usize, params: Params| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| states(run_of(&points, params)))
        };
        let params = method.params();
        let one = on(1, params);
        assert_eq!((one[0].phase, one[0].iteration), (Phase::Start, 0));
        let last = one.last().unwrap();
        assert_eq!((last.phase, last.iteration as usize), (Phase::Finished, one.len() - 1));
        for threads in [2, 3] {
            let many = on(threads, params);
            assert_eq!(one.len(), many.len());
            assert!(one.iter().zip(&many).all(|(a, b)| same_bits(a, b)), "{method} on {threads} threads");
        }
        let other = on(2, Params { seed: 2, ..params });
        let is_other = !same_bits(last, other.last().unwrap());
        // EMS draws nothing; a hierarchy's starts may lead to the same end.
        assert!(is_other == params.reads(Setting::Seed) || method == Method::HierarchicalEms, "{method}");
    }
}

#[test]
fn a_cancelled_step_of_a_baseline_leaves_no_trace() {
    let points = gate(400);
    for method in BASELINES {
        let never = states(run_of(&points, method.params()));
        let mut often = run_of(&points, method.params());
        let mut steps = 0;
        for turns in (0..20).flat_map(|_| delays()) {
            if often.is_finished() {
                break;
            }
            let before = often.abstraction();
            match cancelled_after(turns, |cancel| often.step(cancel)) {
                Ok(_) => steps += 1,
                Err(error) => {
                    assert!(matches!(error, InferenceError::Cancelled));
                    assert!(same_bits(&before, &often.abstraction()), "{method}");
                    // On without disturbance, now and then.
                    if turns % 3 == 0 {
                        often.step(&Cancel::default()).unwrap();
                        steps += 1;
                    }
                }
            }
            assert!(same_bits(&never[steps], &often.abstraction()), "{method} after {steps} steps");
        }
        assert!(steps > 0);
    }
}

#[test]
fn a_baseline_merges_nothing_and_keeps_what_it_was_started_with() {
    let points = gate(400);
    for method in BASELINES {
        let mut run = run_of(&points, method.params());
        run.step(&Cancel::default()).unwrap();
        let before = run.abstraction();
        assert_eq!(run.step_merge(&Cancel::default()).unwrap(), []);
        run.set_params(Params::paper()).unwrap();
        run.set_params(Params { clusters: 5, seed: 9, ..method.params() }).unwrap();
        assert_eq!(*run.params(), method.params());
        assert!(same_bits(&before, &run.abstraction()));
        assert!(run.set_params(Params { outlier_prior: 2.0, ..method.params() }).is_err());
    }
}

#[test]
fn any_cloud_gives_a_valid_end() {
    let line: Vec<_> = (0..60).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
    let plane: Vec<_> = (0..400).map(|i| Point3::new(f64::from(i % 20), f64::from(i / 20), 0.0)).collect();
    let mut twins = samples(&block([0.0; 3], [1.0, 0.5, 0.2]), 200);
    twins.extend(twins.clone());
    let clouds = [line, plane, twins, super::noise(300, 1), super::noise(22, 2)];
    for (i, points) in clouds.iter().enumerate() {
        for method in BASELINES {
            for scale in [1e-9, 1.0, 1e12] {
                let points: Vec<_> = points.iter().map(|p| p * scale).collect();
                let a = finish(run_of(&points, method.params()));
                check(&a, points.len());
                assert_eq!(a.phase, Phase::Finished, "cloud {i} by {method}");
            }
        }
    }
    let few = Arc::new(SampleCloud::from_points(&super::noise(15, 1)));
    for method in BASELINES {
        let error = Run::new(few.clone(), method.params(), &Cancel::default()).unwrap_err();
        assert!(matches!(error, InferenceError::TooFewPoints { points: 15 }));
    }
}

#[test]
fn methods_have_names_and_are_known_by_their_parameters() {
    for method in Method::ALL {
        assert_eq!(method.name().parse(), Ok(method));
        assert_eq!(serde_json::to_value(method).unwrap(), method.name());
        let params = method.params();
        params.check().unwrap();
        assert_eq!(Method::of(&params), Some(method));
        let tuned = Params { alpha: 2.0, seed: 7, clusters: 9, primitive_cost: 3.0, ..params };
        assert_eq!(Method::of(&tuned), Some(method));
        let other = Params { merge: MergeRule::None, refine: true, ..params };
        let known = Method::of(&other);
        assert_eq!(known, (params.algorithm != Algorithm::Sampler).then_some(method), "{method}");
        // A setting is either read, or there is a reason why not.
        for setting in [Setting::Alpha, Setting::Clusters, Setting::OutlierPrior, Setting::PrimitiveCost] {
            assert_eq!(params.reads(setting), params.why_unread(setting).is_none());
        }
    }
    let problem = "best".parse::<Method>().unwrap_err();
    assert!(problem.contains("hierarchical-ems"), "{problem}");
}
