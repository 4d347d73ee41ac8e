//! Clouds as scanners give them: noise, outliers, one side only, uneven
//! density. What is asserted is what a good result has, over three seeds, not
//! what one run had. A property that the sampler does not have yet is ignored
//! with what it misses; `cargo test --test abstraction hard -- --ignored` measures it.

use std::sync::{Arc, LazyLock};

use crate::common::{cloud, finished, shared_data};
use nalgebra::Point3;
use superform::geometry::metrics::{MetricOptions, Metrics, Reference, evaluate};
use superform::geometry::{SampleCloud, SamplingOptions, Superquadric, sample_cloud};
use superform::inference::{Params, UNASSIGNED};
use superform::io;

/// Points of the chair that the clouds of chairs were sampled from lie this
/// close to it, outliers and noise mostly do not; in longest edges.
const ON_THE_CHAIR: f64 = 0.005;

/// What three seeds make of a cloud.
struct Results {
    runs: Vec<Run>,
    /// Points of the file, in its order.
    points: Vec<Point3<f64>>,
}

struct Run {
    cloud: SampleCloud,
    labels: Vec<u32>,
    shapes: Vec<Superquadric>,
}

impl Results {
    fn of(name: &str) -> Self {
        let (points, _) = cloud(io::read(&shared_data().join("hard").join(name)).unwrap());
        let runs = (1..=3)
            .map(|seed| {
                let cloud = Arc::new(sample_cloud(&points, &SamplingOptions::default()).unwrap());
                let a = finished(&cloud, Params { seed, ..Params::default() });
                Run {
                    labels: a.labels.to_vec(),
                    shapes: a.primitives.iter().map(|p| p.shape).collect(),
                    cloud: Arc::unwrap_or_clone(cloud),
                }
            })
            .collect();
        Self { runs, points }
    }

    fn metrics(&self, reference: &Reference) -> Vec<Metrics> {
        self.runs.iter().map(|run| evaluate(&run.shapes, None, reference)).collect()
    }

    /// No primitive is larger than the shape itself: the box of each, in its
    /// own axes, has no more volume than the box of the shape.
    fn assert_no_giants(&self, shape_box: f64) {
        for run in &self.runs {
            for shape in &run.shapes {
                let volume = 8.0 * shape.half_extents().product();
                assert!(volume <= shape_box, "a primitive's box of {volume}, the shape's {shape_box}");
            }
        }
    }

    fn counts(&self) -> Vec<usize> {
        self.runs.iter().map(|run| run.shapes.len()).collect()
    }

    /// Share of the file's points without a label.
    fn unassigned(&self) -> Vec<f64> {
        let share = |run: &Run| {
            let labels = run.cloud.labels_of_input(&run.labels, UNASSIGNED);
            labels.iter().filter(|&&l| l == UNASSIGNED).count() as f64 / labels.len() as f64
        };
        self.runs.iter().map(share).collect()
    }
}

fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn box_volume(points: &[Point3<f64>]) -> f64 {
    let first = points[0];
    let (lo, hi) = points.iter().fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p)));
    (hi - lo).product()
}

const QUICK: MetricOptions = MetricOptions { samples: 20_000, volume_points: 50_000, seed: 1 };

/// The chair of which the hard chairs are made: it is the built-in shape.
static CHAIR: LazyLock<Reference> =
    LazyLock::new(|| io::reference(&io::built_in().unwrap(), &QUICK).unwrap());

fn chair_samples(count: usize) -> Vec<Point3<f64>> {
    let options = SamplingOptions { points: count, ..SamplingOptions::default() };
    io::sample(&io::built_in().unwrap(), &options).unwrap().points
}

static NOISY: LazyLock<Results> = LazyLock::new(|| Results::of("noisy_chair_2pct.ply"));
static OUTLIERS: LazyLock<Results> = LazyLock::new(|| Results::of("outliers_20pct_chair.ply"));
static PARTIAL: LazyLock<Results> = LazyLock::new(|| Results::of("partial_front_view_chair.ply"));
static UNEVEN: LazyLock<Results> = LazyLock::new(|| Results::of("uneven_density_man.ply"));

#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn noise_makes_no_giants_and_no_crowd() {
    let noisy = &*NOISY;
    noisy.assert_no_giants(box_volume(&chair_samples(3500)));
    assert!(noisy.counts().iter().all(|n| (4..=16).contains(n)), "{:?} primitives", noisy.counts());
    assert!(noisy.unassigned().iter().all(|u| *u <= 0.02), "{:?} unassigned", noisy.unassigned());
    let errors: Vec<f64> = noisy.metrics(&CHAIR).iter().map(|m| m.chamfer_l1.unwrap()).collect();
    assert!(errors.iter().all(|e| *e <= 0.03), "Chamfer-L1 {errors:?} under noise of 0.02");
}

/// The points lie 0.013 off the chair on average; a surface through their
/// midst is nearer than they are.
#[test]
#[ignore = "known to fail: Chamfer-L1 is 0.018 with the default settings"]
fn noise_is_averaged_out() {
    let noisy = &*NOISY;
    let error = mean(noisy.metrics(&CHAIR).iter().map(|m| m.chamfer_l1.unwrap()));
    assert!(error <= 0.015, "Chamfer-L1 {error}");
}

#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn outliers_make_no_giants() {
    let outliers = &*OUTLIERS;
    outliers.assert_no_giants(box_volume(&chair_samples(3500)));
}

/// They are a fifth of the cloud, and even thinning would keep all of them.
#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn thinning_does_not_favour_outliers() {
    let outliers = &*OUTLIERS;
    for run in &outliers.runs {
        let stray = strays(&run.cloud.points).iter().filter(|s| **s).count() as f64;
        let share = stray / run.cloud.points.len() as f64;
        assert!(share <= 0.08, "{share} of the samples are outliers");
    }
}

#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn the_shape_is_found_among_outliers() {
    let outliers = &*OUTLIERS;
    let found = outliers.metrics(&CHAIR);
    for m in &found {
        assert!(m.chamfer_l1.unwrap() <= 0.02, "Chamfer-L1 {:?}", m.chamfer_l1);
    }
    let iou = mean(found.iter().map(|m| m.iou.unwrap()));
    assert!(iou >= 0.5, "IoU {iou}");
    assert!(outliers.counts().iter().all(|n| (4..=16).contains(n)), "{:?} primitives", outliers.counts());
}

#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn outliers_end_unassigned_and_the_shape_does_not() {
    let outliers = &*OUTLIERS;
    let stray = strays(&outliers.points);
    for run in &outliers.runs {
        let labels = run.cloud.labels_of_input(&run.labels, UNASSIGNED);
        let unassigned = |of_strays: bool| {
            let chosen = stray.iter().zip(&labels).filter(|(s, _)| **s == of_strays);
            mean(chosen.map(|(_, l)| f64::from(u8::from(*l == UNASSIGNED))))
        };
        let (of_outliers, of_chair) = (unassigned(true), unassigned(false));
        assert!(
            of_outliers >= 0.7 && of_chair <= 0.05,
            "{of_outliers} of the outliers and {of_chair} of the chair's points end unassigned"
        );
    }
}

/// Which points are off the chair.
fn strays(points: &[Point3<f64>]) -> Vec<bool> {
    let chair = chair_samples(50_000);
    let tree = superform::geometry::neighbors::KdTree::new(&chair);
    let limit = ON_THE_CHAIR * CHAIR.longest_edge();
    points.iter().map(|p| tree.nearest_one(p).unwrap().0.sqrt() > limit).collect()
}

/// What is not there is not made up, and what is there is covered.
#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn half_a_chair_is_that_half() {
    let partial = &*PARTIAL;
    partial.assert_no_giants(box_volume(&partial.points));
    assert!(partial.counts().iter().all(|n| *n <= 20), "{:?} primitives", partial.counts());
    assert!(partial.unassigned().iter().all(|u| *u <= 0.02), "{:?} unassigned", partial.unassigned());
    let scan = Reference::of_cloud(&partial.points, &QUICK).unwrap();
    for (m, of_scan) in partial.metrics(&CHAIR).iter().zip(partial.metrics(&scan)) {
        assert!(m.accuracy.unwrap() <= 0.01, "surface off the chair by {:?}", m.accuracy);
        assert!(of_scan.completeness.unwrap() <= 0.01, "scan missed by {:?}", of_scan.completeness);
    }
}

#[test]
#[ignore = "known to fail: the sparse lower legs are lost, Chamfer-L1 is 0.017 to 0.023"]
fn density_does_not_decide_what_is_a_part() {
    let uneven = &*UNEVEN;
    let data = shared_data();
    uneven.assert_no_giants(box_volume(&uneven.points));
    assert!(uneven.counts().iter().all(|n| (6..=25).contains(n)), "{:?} primitives", uneven.counts());
    assert!(uneven.unassigned().iter().all(|u| *u <= 0.05), "{:?} unassigned", uneven.unassigned());
    let man = io::read(&data.join("human/mh_man_walk.ply")).unwrap();
    for m in uneven.metrics(&io::reference(&man, &QUICK).unwrap()) {
        // The feet, too, of which there are few points.
        assert!(m.chamfer_l1.unwrap() <= 0.02, "Chamfer-L1 {:?}", m.chamfer_l1);
        assert!(m.iou.unwrap() >= 0.5, "IoU {:?}", m.iou);
    }
}
