//! The draws against their laws. Seeds are fixed; each tolerance is what a
//! right draw would exceed with the probability that is named, were the seed
//! chosen anew.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

use super::{block, noise, rng, samples};
use crate::geometry::Superquadric;
use crate::geometry::neighbors::{KdTree, RadiusGraph};
use crate::inference::data::abstraction::{Occurrence, UNASSIGNED};
use crate::inference::data::model::Model;
use crate::inference::data::normalization::Normalization;
use crate::inference::data::random_streams::{Purpose, stream};
use crate::inference::data::state::{Cluster, State};
use crate::inference::data::surface_distance::SurfaceDistance;
use crate::inference::fit::k_means::k_means;
use crate::inference::gibbs::sweep::sweep;
use crate::inference::params::{Params, SMALLEST_CLUSTER};

/// A model whose points are neighbours within `radius`, in a frame where
/// lengths are as given.
fn model(points: Vec<Point3<f64>>, radius: f64) -> Arc<Model> {
    let tree = KdTree::new(&points);
    let mut model = Model::new(Normalization::of(&points).unwrap(), &points, &[]);
    model.block = Arc::new(points.iter().copied().collect());
    model.spacing = 0.1;
    model.graph = Arc::new(RadiusGraph::new(&tree, &points, radius, points.len()));
    model.surface = Arc::new(SurfaceDistance::new(tree, &points, 0.1));
    model.points = Arc::new(points);
    Arc::new(model)
}

fn state(model: Arc<Model>, labels: Vec<u32>, clusters: &[(Superquadric, f64)]) -> State {
    let clusters: Vec<Cluster> = (0u32..)
        .zip(clusters)
        .map(|(id, &(shape, sigma))| Cluster { id, revision: u64::from(id), shape, sigma, locked: false })
        .collect();
    State {
        model,
        frozen: vec![false; labels.len()],
        labels,
        iteration: 1,
        pinned: Arc::default(),
        next_id: clusters.len() as u32,
        next_revision: clusters.len() as u64,
        clusters,
    }
}

/// N(d; σ)·½ by the definition.
fn half_normal(shape: &Superquadric, sigma: f64, x: &Point3<f64>) -> f64 {
    let z = shape.radial_distance(x) / sigma;
    0.5 * (-0.5 * z * z).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt())
}

#[test]
fn sigma_follows_its_gamma() {
    let model = model(noise(30, 1), 1.0);
    // For odd n the shape (n − 1)/2 = k is whole, and P(γ > x) is the Poisson
    // sum e^(−y)·Σ_{i<k} yⁱ/i!, y = x·D/2.
    for (n, sum_d2) in [(3usize, 0.5), (9, 2.0), (41, 0.3), (201, 40.0)] {
        let k = (n - 1) / 2;
        let mut rng = rng(n as u64);
        const DRAWS: usize = 20_000;
        let mut below: Vec<f64> = (0..DRAWS)
            .map(|_| {
                let sigma = model.draw_sigma(sum_d2, n, &mut rng);
                let y = 0.5 * sum_d2 / (sigma * sigma);
                let mut term = (-y).exp();
                let mut above = 0.0;
                for i in 0..k {
                    above += term;
                    term *= y / (i + 1) as f64;
                }
                1.0 - above
            })
            .collect();
        below.sort_by(f64::total_cmp);
        // Kolmogorov–Smirnov: the probability integral is uniform. The limit is
        // passed with probability 1e-6: √(ln(2/1e-6)/2N).
        let limit = ((2.0f64 / 1e-6).ln() / (2.0 * DRAWS as f64)).sqrt();
        let gap = below
            .iter()
            .enumerate()
            .map(|(i, u)| {
                let (left, right) = (i as f64 / DRAWS as f64, (i + 1) as f64 / DRAWS as f64);
                (u - left).abs().max((u - right).abs())
            })
            .fold(0.0, f64::max);
        assert!(gap < limit, "n = {n}: the distribution is off by {gap}");
    }
}

#[test]
fn sigma_of_a_perfect_fit_and_of_one_point_keeps_its_floor() {
    let model = model(noise(30, 1), 1.0);
    let mut rng = rng(2);
    for (sum_d2, n) in [(0.0, 100), (0.0, 1), (0.0, 0), (1.0, 1), (1e-300, 50), (1e300, 50)] {
        for _ in 0..200 {
            let sigma = model.draw_sigma(sum_d2, n, &mut rng);
            assert!(sigma.is_finite() && sigma >= model.sigma_floor(), "{sigma} for D = {sum_d2}, n = {n}");
        }
        let first = model.draw_first_sigma(&mut rng);
        assert!(first > 0.0 && first <= 1.0);
    }
}

/// 70 points on two spheres and some between, three clusters.
fn small_state() -> State {
    let spheres = [([0.0, 0.0, 0.0], 1.0), ([2.5, 0.0, 0.0], 1.2), ([0.5, 0.5, 0.0], 1.5)]
        .map(|(c, r)| Superquadric::sphere(Point3::from(c), r));
    let mut points = Vec::new();
    let mut labels = Vec::new();
    for (j, n) in [(0u32, 30), (1, 26), (2, 24)] {
        let found = samples(&spheres[j as usize], n);
        labels.extend(std::iter::repeat_n(j, found.len()));
        points.extend(found);
    }
    points.extend([Point3::new(1.2, 0.3, 0.1), Point3::new(1.1, -0.5, 0.4), Point3::new(1.5, 0.0, -0.6)]);
    labels.extend([0, 1, UNASSIGNED]);
    // All are neighbours of all: nothing is cut off.
    state(model(points, 100.0), labels, &spheres.map(|s| (s, 0.35)))
}

/// Σ (found − expected)²/expected, and a limit that a right draw passes with a
/// probability of about 1e-6 (Wilson and Hilferty).
fn chi_square(counts: &[f64], expected: &[f64]) -> (f64, f64) {
    let mut sum = 0.0;
    let mut cells = 0;
    let (mut rare, mut rare_expected) = (0.0, 0.0);
    for (c, e) in counts.iter().zip(expected) {
        if *e < 10.0 {
            rare += c;
            rare_expected += e;
        } else {
            sum += (c - e).powi(2) / e;
            cells += 1;
        }
    }
    if rare_expected > 0.0 {
        sum += (rare - rare_expected).powi(2) / rare_expected.max(1.0);
        cells += 1;
    }
    let freedom = f64::from(cells - 1).max(1.0);
    let spread = 2.0 / (9.0 * freedom);
    (sum, freedom * (1.0 - spread + 4.75 * spread.sqrt()).powi(3))
}

#[test]
fn free_points_choose_as_full_enumeration_says() {
    const SWEEPS: u64 = 20_000;
    let base = small_state();
    let last = base.labels.len() - 3;
    let params = Params { alpha: 1.5, p0: 0.6, ..Params::default() };
    for free in [vec![last], vec![last, last + 1, last + 2], vec![3, last + 2]] {
        let mut start = base.clone();
        start.frozen = (0..base.labels.len()).map(|i| !free.contains(&i)).collect();
        // Outcomes as numbers in base 4, the last digit the first free point's;
        // 3 is a new table.
        let outcomes = 4usize.pow(free.len() as u32);
        let mut expected = vec![0.0; outcomes];
        enumerate(&start, &params, &free, &mut expected);
        assert!((expected.iter().sum::<f64>() - 1.0).abs() < 1e-12);

        let mut counts = vec![0.0; outcomes];
        for seed in 0..SWEEPS {
            let mut state = start.clone();
            let mut occurrences = Vec::new();
            sweep(&mut state, &Params { seed, ..params }, &mut occurrences);
            assert!(occurrences.is_empty(), "three points are no table");
            let digit = |i: usize| if state.labels[i] == UNASSIGNED { 3 } else { state.labels[i] as usize };
            counts[free.iter().rev().fold(0, |sum, &i| 4 * sum + digit(i))] += 1.0;
        }
        let expected: Vec<f64> = expected.iter().map(|p| p * SWEEPS as f64).collect();
        let (sum, limit) = chi_square(&counts, &expected);
        assert!(sum < limit, "χ² = {sum} > {limit}: {counts:?}, not {expected:?}");
    }
}

/// Adds the probability of each outcome, over all orders of the free points
/// and all choices, by the formulas of the paper.
fn enumerate(start: &State, params: &Params, free: &[usize], probability: &mut [f64]) {
    fn go(
        s: &State,
        params: &Params,
        free: &[usize],
        left: &[usize],
        (labels, waiting, chance): (Vec<u32>, usize, f64),
        out: &mut [f64],
    ) {
        if left.is_empty() {
            let digit = |i: usize| if labels[i] == UNASSIGNED { 3 } else { labels[i] as usize };
            out[free.iter().rev().fold(0, |sum, &i| 4 * sum + digit(i))] += chance;
            return;
        }
        for &i in left {
            let rest: Vec<usize> = left.iter().copied().filter(|o| *o != i).collect();
            let mut weights: Vec<f64> = (0u32..)
                .zip(&s.clusters)
                .map(|(j, c)| {
                    let n = labels.iter().enumerate().filter(|&(o, l)| o != i && *l == j).count();
                    n as f64 * half_normal(&c.shape, c.sigma, &s.model.points[i])
                })
                .collect();
            weights.push((params.alpha + waiting as f64) * params.p0);
            let total: f64 = weights.iter().sum();
            for (choice, w) in weights.iter().enumerate() {
                let mut next = labels.clone();
                let new = choice + 1 == weights.len();
                next[i] = if new { UNASSIGNED } else { choice as u32 };
                let chance = chance / left.len() as f64 * w / total;
                go(s, params, free, &rest, (next, waiting + usize::from(new), chance), out);
            }
        }
    }
    go(start, params, free, free, (start.labels.clone(), 0, 1.0), probability);
}

#[test]
fn with_a_flat_likelihood_tables_keep_the_restaurants_expectation() {
    const SWEEPS: u64 = 2000;
    let points = noise(120, 3);
    let n = points.len() as f64;
    // So much noise that every point is equally likely everywhere.
    let sphere = Superquadric::sphere(Point3::new(0.5, 0.5, 0.5), 0.4);
    let sigma = 1e5;
    let density = half_normal(&sphere, sigma, &points[0]);
    let labels: Vec<u32> = (0..120).map(|i| u32::from(i >= 70)).collect();
    let base = state(model(points, 100.0), labels, &[(sphere, sigma), (sphere, sigma)]);

    // The new table has the same density as the old: the plain restaurant.
    let alpha = 1.0;
    let params = Params { alpha, p0: density, ..Params::default() };
    // A point that leaves and sits down again changes table j by −n_j/N and by
    // its share of the N − 1 others and α, whatever the others did before.
    let expected =
        |start: f64| (0..120).fold(start, |now, _| (now - start / n) * (1.0 + 1.0 / (n - 1.0 + alpha)));
    let mut sums = [0.0; 3];
    let mut squares = [0.0; 3];
    let mut births = 0;
    for seed in 0..SWEEPS {
        let mut state = base.clone();
        let mut occurrences = Vec::new();
        sweep(&mut state, &Params { seed, ..params }, &mut occurrences);
        births += occurrences.len();
        let count = |l: u32| state.labels.iter().filter(|x| **x == l).count() as f64;
        for (k, c) in [count(0), count(1), count(UNASSIGNED)].into_iter().enumerate() {
            sums[k] += c;
            squares[k] += c * c;
        }
    }
    // A birth or a death has probability under 1e-3 a sweep, and would shift a
    // mean by a few hundredths.
    assert!(births <= 4, "{births} births and deaths");
    let (first, second) = (expected(70.0), expected(50.0));
    for (k, e) in [first, second, n - first - second].into_iter().enumerate() {
        let mean = sums[k] / SWEEPS as f64;
        let error = ((squares[k] / SWEEPS as f64 - mean * mean) / SWEEPS as f64).sqrt();
        assert!((mean - e).abs() < 5.0 * error + 0.03, "table {k}: {mean} ± {error}, not {e}");
    }
}

/// A line of `n` points, neighbours of each other, at this place.
fn line(n: usize, at: [f64; 3]) -> impl Iterator<Item = Point3<f64>> {
    (0..n).map(move |i| Point3::from(at) + Vector3::x() * (0.01 * i as f64))
}

#[test]
fn far_points_found_a_table_where_enough_of_them_are_together() {
    let sphere = Superquadric::sphere(Point3::origin(), 1.0);
    for (companies, expected) in
        [(vec![20], 0), (vec![21], 1), (vec![15, 15], 0), (vec![30, 25], 2), (vec![40], 1)]
    {
        let mut points = samples(&sphere, 60);
        let near = points.len();
        for (k, &n) in companies.iter().enumerate() {
            points.extend(line(n, [500.0 + 100.0 * k as f64, 0.0, 0.0]));
        }
        // So far from the sphere that its density is 0 in floating point: the
        // new table wins however small it is.
        assert_eq!(half_normal(&sphere, 0.1, &points[near]), 0.0);
        let labels = vec![0; points.len()];
        let mut state = state(model(points, 0.6), labels, &[(sphere, 0.1)]);
        let mut occurrences = Vec::new();
        let params = Params { p0: 1e-6, alpha: 1e-3, ..Params::default() };
        sweep(&mut state, &params, &mut occurrences);
        let born: Vec<usize> = occurrences
            .iter()
            .filter_map(|o| match o {
                Occurrence::Born { points, .. } => Some(*points),
                _ => None,
            })
            .collect();
        assert_eq!(born.len(), expected, "{companies:?}: {occurrences:?}");
        assert!(born.iter().all(|n| *n > SMALLEST_CLUSTER));
        assert_eq!(state.clusters.len(), 1 + expected);
        // The sphere's points stay, and the far ones are not the sphere's.
        assert!(state.labels[..near].iter().all(|l| *l == 0));
        assert!(state.labels[near..].iter().all(|l| *l != 0));
        let mut at = near;
        for n in companies {
            let first = state.labels[at];
            if n > SMALLEST_CLUSTER + 1 {
                // Those who came after the birth draw between it and a new table.
                assert!(state.labels[at..at + n].iter().any(|l| *l != UNASSIGNED));
            } else if n <= SMALLEST_CLUSTER {
                assert_eq!(first, UNASSIGNED);
            }
            at += n;
        }
    }
}

#[test]
fn small_and_scattered_clusters_are_removed() {
    let sphere = Superquadric::sphere(Point3::origin(), 1.0);
    let far = Superquadric::sphere(Point3::new(40.0, 0.0, 0.0), 1.0);
    for (n, gap, lives) in [(20, 0.01, false), (21, 0.01, true), (40, 5.0, false)] {
        let mut points = samples(&sphere, 60);
        let near = points.len();
        points.extend((0..n).map(|i| Point3::new(40.0 + gap * f64::from(i), 0.0, 0.0)));
        let labels = (0..points.len()).map(|i| u32::from(i >= near)).collect();
        let mut state = state(model(points, 0.6), labels, &[(sphere, 0.1), (far, 0.1)]);
        // Nobody moves in the sweep; the removal comes after it.
        state.frozen.fill(true);
        let mut occurrences = Vec::new();
        sweep(&mut state, &Params::default(), &mut occurrences);
        assert_eq!(state.clusters.len(), 1 + usize::from(lives), "{n} points, {gap} apart");
        assert_eq!(occurrences, if lives { vec![] } else { vec![Occurrence::Died { id: 1 }] });
        for &label in &state.labels {
            assert!(label == UNASSIGNED || (label as usize) < state.clusters.len());
        }
        if !lives {
            // No existing table is near: they stay without one, and are free.
            assert!(state.labels[near..].iter().all(|l| *l == UNASSIGNED));
            assert!(state.frozen[near..].iter().all(|f| !f));
        }
    }
}

#[test]
fn streams_differ_in_each_of_their_addresses() {
    use rand::Rng;
    let mut first: Vec<u64> = Vec::new();
    for seed in [0, 1, u64::MAX] {
        for purpose in [Purpose::KMeans, Purpose::Sweep, Purpose::Sigma, Purpose::Cut] {
            for iteration in [0, 1, 500] {
                for id in [0, 1, u32::MAX] {
                    first.push(stream(seed, purpose, iteration, id).next_u64());
                    let again = stream(seed, purpose, iteration, id).next_u64();
                    assert_eq!(first.last(), Some(&again));
                }
            }
        }
    }
    let n = first.len();
    first.sort_unstable();
    first.dedup();
    assert_eq!(first.len(), n, "two streams start alike");
}

#[test]
fn k_means_finds_what_lies_apart_and_never_more_centres_than_places() {
    let mut points = Vec::new();
    for k in 0..4 {
        points.extend(samples(&block([f64::from(k) * 10.0, 0.0, 0.0], [1.0; 3]), 40));
    }
    let labels = k_means(&points, 4, &mut rng(5));
    let quarter = points.len() / 4;
    for part in labels.chunks(quarter) {
        assert!(part.iter().all(|l| *l == part[0]), "a lump is cut");
    }
    let places = k_means(&[Point3::origin(); 50], 30, &mut rng(5));
    assert!(places.iter().all(|l| *l == 0));
    assert!(k_means(&[], 3, &mut rng(5)).is_empty());
}
