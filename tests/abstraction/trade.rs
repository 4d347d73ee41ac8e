//! The trade between error and number of primitives, on the built-in shape.

use std::sync::Arc;

use superform::geometry::{SampleCloud, SamplingOptions};
use superform::inference::{Cancel, Params, Sampler, Setting};

/// Number of primitives and mean distance, means over three seeds.
fn outcome(cloud: &Arc<SampleCloud>, primitive_cost: f64) -> (f64, f64) {
    let seeds = [1, 2, 3];
    let mut sums = (0.0, 0.0);
    for seed in seeds {
        let params = Params { primitive_cost, seed, iterations: 10, ..Params::default() };
        let mut sampler = Sampler::new(Arc::clone(cloud), params, &Cancel::default()).unwrap();
        while !sampler.is_finished() {
            sampler.step(&Cancel::default()).unwrap();
        }
        let figures = sampler.abstraction().figures;
        sums.0 += figures.clusters as f64;
        sums.1 += figures.mean_distance;
    }
    let n = seeds.len() as f64;
    (sums.0 / n, sums.1 / n)
}

#[test]
fn dearer_primitives_are_fewer_and_farther_from_their_points() {
    let sampling = SamplingOptions { points: 1000, ..SamplingOptions::default() };
    let cloud = Arc::new(superform::io::sample(&superform::io::built_in().unwrap(), &sampling).unwrap());
    let (low, high) = Setting::PrimitiveCost.range();
    let outcomes = [low, 1.0, high].map(|cost| outcome(&cloud, cost));
    for pair in outcomes.windows(2) {
        let [(few, near), (fewer, farther)] = [pair[0], pair[1]];
        // The search is greedy and seeded: a little may go the other way.
        assert!(fewer <= few + 0.5, "{outcomes:?}");
        assert!(farther >= 0.95 * near, "{outcomes:?}");
    }
    let [cheap, _, dear] = outcomes;
    assert!(dear.0 <= cheap.0 - 1.0 && dear.1 >= 1.05 * cheap.1, "the price does nothing: {outcomes:?}");
}
