//! A run and its parts, on the built-in chair. What the sampler does in one go
//! is told apart by where in a run it stands: a step is repeated from a
//! checkpoint, which a clone is.
#![allow(clippy::unwrap_used)] // What can't be had here ends the benchmark.

use std::sync::Arc;
use std::time::Duration;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use superform::geometry::{SampleCloud, SamplingOptions};
use superform::inference::{Cancel, Method, Params, Run, Sampler};
use superform::io;

/// Samples of the chair: as many as the paper's shapes have.
const POINTS: usize = 3500;

fn chair() -> Arc<SampleCloud> {
    let options = SamplingOptions { points: POINTS, ..SamplingOptions::default() };
    Arc::new(io::sample(&io::built_in().unwrap(), &options).unwrap())
}

/// The run after so many iterations.
fn sampler_at(iteration: u32, params: Params) -> Sampler {
    let cancel = Cancel::default();
    let mut sampler = Sampler::new(chair(), params, &cancel).unwrap();
    while sampler.iteration() < iteration {
        sampler.step(&cancel).unwrap();
    }
    sampler
}

fn finished(cloud: &Arc<SampleCloud>, params: Params) -> Run {
    let cancel = Cancel::default();
    let mut run = Run::new(Arc::clone(cloud), params, &cancel).unwrap();
    while !run.is_finished() {
        run.step(&cancel).unwrap();
    }
    run
}

/// Steps of the default method, each from its own checkpoint.
fn steps(c: &mut Criterion) {
    let mut group = c.benchmark_group("step");
    group.sample_size(20).measurement_time(Duration::from_secs(5));
    let params = Params::default();
    let unmerged = Params { merge: superform::inference::MergeRule::None, ..params };
    let late = params.iterations - 1;
    for (name, sampler) in [
        ("sweep and fits that explore (iteration 1)", sampler_at(0, params)),
        ("sweep and fits that follow (iteration 10)", sampler_at(9, params)),
        ("the same before a merge pass (iteration 15, no merging)", sampler_at(14, unmerged)),
        ("the same with a merge pass (iteration 15)", sampler_at(14, params)),
        ("last iteration, with a merge pass", sampler_at(late, params)),
        ("refinement", sampler_at(params.iterations, params)),
    ] {
        let cancel = Cancel::default();
        group.bench_function(name, |b| {
            b.iter_batched_ref(
                || sampler.clone(),
                |sampler| sampler.step(&cancel).unwrap(),
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

/// One cluster, which is fitted to the whole chair from several starts.
fn fit(c: &mut Criterion) {
    let cancel = Cancel::default();
    let params = Params { clusters: 1, ..Method::KMeans.params() };
    let run = Run::new(chair(), params, &cancel).unwrap();
    c.bench_function("fit of one primitive to all samples", |b| {
        b.iter_batched_ref(|| run.clone(), |run| run.step(&cancel).unwrap(), BatchSize::LargeInput);
    });
}

fn start(c: &mut Criterion) {
    let cloud = chair();
    c.bench_function("start", |b| {
        b.iter(|| Sampler::new(Arc::clone(&cloud), Params::default(), &Cancel::default()).unwrap());
    });
}

fn whole_runs(c: &mut Criterion) {
    let mut group = c.benchmark_group("whole run");
    group.sample_size(10).measurement_time(Duration::from_secs(10));
    let cloud = chair();
    for method in Method::ALL {
        group.bench_function(method.name(), |b| b.iter(|| finished(&cloud, method.params())));
    }
    group.finish();
}

criterion_group!(benches, start, fit, steps, whole_runs);
criterion_main!(benches);
