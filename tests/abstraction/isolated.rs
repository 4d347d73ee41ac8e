//! Isolated points of a cloud: outliers are left out, whatever the unit and the
//! order, and sparse, thin and far parts of a shape are not.

use std::time::Instant;

use nalgebra::{Point3, Vector3};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use superform::geometry::{Isolated, NO_SAMPLE, SampleCloud, SampledPart, SamplingOptions, sample_cloud};

fn sampled(points: &[Point3<f64>], wanted: usize) -> SampleCloud {
    let options = SamplingOptions { points: wanted, ..SamplingOptions::default() };
    assert_eq!(options.isolated, Isolated::LeaveOut);
    sample_cloud(points, &options).unwrap()
}

fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Points of the unit sphere along a spiral, evenly spread.
fn sphere(count: usize) -> Vec<Point3<f64>> {
    let golden = std::f64::consts::PI * (1.0 + 5f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / count as f64;
            let (r, angle) = ((1.0 - z * z).sqrt(), golden * i as f64);
            Point3::new(r * angle.cos(), r * angle.sin(), z)
        })
        .collect()
}

/// Random points of the unit sphere.
fn random_sphere(count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut rng = rng(seed);
    (0..count)
        .map(|_| {
            let z: f64 = rng.random_range(-1.0..1.0);
            let angle = rng.random_range(0.0..std::f64::consts::TAU);
            let r = (1.0 - z * z).sqrt();
            Point3::new(r * angle.cos(), r * angle.sin(), z)
        })
        .collect()
}

/// Random points of the cube [−half, half]³.
fn strewn(count: usize, half: f64, seed: u64) -> Vec<Point3<f64>> {
    let mut rng = rng(seed);
    (0..count).map(|_| Point3::from(Vector3::from_fn(|_, _| rng.random_range(-half..half)))).collect()
}

/// Share of some input points that no sample stands for.
fn unlabelled(cloud: &SampleCloud, chosen: std::ops::Range<usize>) -> f64 {
    let map = &cloud.sample_of_input.as_ref().unwrap()[chosen];
    map.iter().filter(|&&s| s == NO_SAMPLE).count() as f64 / map.len() as f64
}

/// Share of some input points that were left out of a cloud that was not
/// thinned.
fn left_out(cloud: &SampleCloud, points: &[Point3<f64>]) -> f64 {
    let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(f64::to_bits);
    let kept: std::collections::HashSet<_> = cloud.points.iter().map(key).collect();
    points.iter().filter(|p| !kept.contains(&key(p))).count() as f64 / points.len() as f64
}

#[test]
fn outliers_around_a_sphere_are_left_out_and_the_sphere_is_not() {
    for (name, surface) in [("even", sphere(12_000)), ("random", random_sphere(12_000, 3))] {
        for share in [0.01, 0.05, 0.2, 0.3] {
            let outliers = strewn((12_000.0 * share / (1.0 - share)) as usize, 2.0, 4);
            let input = [surface.clone(), outliers.clone()].concat();
            let cloud = sampled(&input, 100_000);
            let (of_outliers, of_sphere) = (left_out(&cloud, &outliers), left_out(&cloud, &surface));
            assert!(
                of_outliers >= 0.9 && of_sphere <= 0.005,
                "{share} outliers, {name} sphere: {of_outliers} of them and {of_sphere} of the sphere left out"
            );
            let SampledPart::Connected { points, isolated, unlabelled } = cloud.part else {
                panic!("{:?}", cloud.part)
            };
            assert_eq!((points, isolated), (input.len(), input.len() - cloud.points.len()));
            let map = cloud.sample_of_input.as_ref().unwrap();
            assert_eq!(unlabelled, map.iter().filter(|&&s| s == NO_SAMPLE).count());
            // Thinned, it is the same points that are left out.
            let thinned = sampled(&input, 3000);
            assert_eq!((thinned.points.len(), &thinned.part), (3000, &cloud.part));
        }
    }
}

#[test]
fn a_share_is_told_and_keeping_them_keeps_all() {
    let input = [sphere(6120), strewn(1380, 2.0, 1)].concat();
    let cloud = sampled(&input, 3500);
    let isolated = cloud.part.isolated();
    let note = cloud.part.note().unwrap();
    assert_eq!(
        note,
        format!("1,{:03} of 7,500 points are isolated outliers and were left out", isolated - 1000)
    );
    let options = SamplingOptions { isolated: Isolated::Keep, ..SamplingOptions::default() };
    let all = sample_cloud(&input, &options).unwrap();
    assert_eq!((all.part, all.part.note()), (SampledPart::Whole, None));
    assert_eq!(unlabelled(&all, 0..input.len()), 0.0);
    let far = |cloud: &SampleCloud| cloud.points.iter().filter(|p| p.coords.norm() > 1.2).count();
    assert!(far(&all) > 1000 && far(&cloud) == 0, "{} {}", far(&all), far(&cloud));
}

#[test]
fn labels_come_in_input_order_whatever_the_order() {
    let mut input = [sphere(5000), strewn(1200, 2.0, 2)].concat();
    input.shuffle(&mut rng(5));
    input[7] = Point3::new(f64::NAN, 0.0, 0.0);
    let cloud = sampled(&input, 2000);
    // Every sample stands for an octant.
    let octant = |p: &Point3<f64>| p.iter().fold(0, |o, c| 2 * o + u32::from(*c > 0.0));
    let labels: Vec<u32> = cloud.points.iter().map(octant).collect();
    let of_input = cloud.labels_of_input(&labels, 99);
    assert_eq!(of_input.len(), input.len());
    assert_eq!(of_input[7], 99);
    for (p, label) in input.iter().zip(of_input) {
        let off = (p.coords.norm() - 1.0).abs();
        let edge = p.iter().any(|c| c.abs() < 0.1);
        if off < 1e-9 {
            assert!(label == octant(p) || edge && label != 99, "{p} on the sphere has label {label}");
        } else if off > 0.3 {
            assert_eq!(label, 99, "{p}");
        }
    }

    // Which points are isolated depends on nothing but where they are.
    let isolated = |input: &[Point3<f64>]| {
        let kept = sampled(input, 100_000).points;
        let mut kept: Vec<_> = kept.iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect();
        kept.sort_unstable();
        kept
    };
    let before = isolated(&input);
    input.shuffle(&mut rng(6));
    assert_eq!(isolated(&input), before);
    let here = sampled(&input, 2000);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| sampled(&input, 2000)), here, "on {threads} threads");
    }
}

#[test]
fn the_unit_makes_no_difference() {
    let input = [sphere(4000), strewn(1000, 2.0, 7)].concat();
    let expected = sampled(&input, 100_000).part;
    assert!(expected.isolated() > 800, "{expected:?}");
    for (scale, offset) in [(1e-9, 0.0), (1e-3, 4.5e5), (1e12, -3e12), (1e-200, 0.0), (1e200, 0.0)] {
        let moved: Vec<_> =
            input.iter().map(|p| Point3::from(p.coords * scale).map(|c| c + offset)).collect();
        let found = sampled(&moved, 100_000).part.isolated();
        // Rounding may move a point over a limit.
        assert!(found.abs_diff(expected.isolated()) <= 3, "{found} at scale {scale} and offset {offset}");
    }
}

/// However often a point is repeated, it is no component of its own.
#[test]
fn twins_are_no_neighbours() {
    let outliers = strewn(1000, 2.0, 8);
    let once = [sphere(4000), outliers.clone()].concat();
    let cloud = sampled(&once, 100_000);
    let often: Vec<_> = (0..20).flat_map(|_| once.clone()).collect();
    assert_eq!(sampled(&often, 100_000).points, cloud.points);
    assert_eq!(sampled(&often, 100_000).part.isolated(), 20 * cloud.part.isolated());
    let only_outliers: Vec<_> =
        sphere(4000).into_iter().chain((0..20).flat_map(|_| outliers.clone())).collect();
    assert_eq!(sampled(&only_outliers, 100_000).points, cloud.points);
}

/// A few points so far out that they decide the mean spacing do not hide the
/// others, nor do they cost the shape its resolution.
#[test]
fn far_points_do_not_hide_near_outliers() {
    for far in [1e3, 1e10, 1e300] {
        let surface = sphere(6000);
        let mut input = [surface.clone(), strewn(600, 2.0, 9)].concat();
        input.extend([Point3::new(far, 0.0, 0.0), Point3::new(0.0, -far, far)]);
        let cloud = sampled(&input, 2000);
        let lost = unlabelled(&cloud, 0..6000);
        assert!(cloud.points.len() == 2000 && lost <= 0.005, "{lost} of the sphere, at {far}");
        let strays = unlabelled(&cloud, 6000..input.len());
        assert!(strays > 0.8, "{strays} of the outliers have no label, at {far}");
        // By chance a few of them see the others in one plane.
        let far_samples = cloud.points.iter().filter(|p| p.coords.norm() > 1.3).count();
        assert!(far_samples <= 30, "{far_samples} samples are outliers, at {far}");
        assert!(cloud.points.iter().all(|p| p.coords.norm() < 4.0), "a far sample, at {far}");
    }
}

#[test]
fn what_belongs_to_a_shape_is_not_left_out() {
    let row = |n: u32, step: f64| (0..n).map(move |i| f64::from(i) * step);
    let rod: Vec<_> = row(400, 0.01)
        .flat_map(|x| (0..6).map(move |k| (x, f64::from(k) * std::f64::consts::TAU / 6.0)))
        .map(|(x, a)| Point3::new(x, 0.01 * a.cos(), 0.01 * a.sin()))
        .collect();
    let wire: Vec<_> = row(500, 0.01).map(|x| Point3::new(x, x * x, 0.0)).collect();
    let two: Vec<_> = sphere(1500).into_iter().flat_map(|p| [p, p + Vector3::x() * 500.0]).collect();
    let grid: Vec<_> = row(40, 1.0).flat_map(|x| row(40, 1.0).map(move |y| Point3::new(x, y, 0.0))).collect();
    let filled = strewn(3000, 1.0, 10);
    for (name, input) in [
        ("rod", rod),
        ("wire", wire),
        ("two objects", two),
        ("plane", grid),
        ("random sphere", random_sphere(5000, 11)),
        ("filled cube", filled),
        ("few points", strewn(200, 1.0, 12)),
    ] {
        let cloud = sampled(&input, 100_000);
        assert_eq!((cloud.points.len(), cloud.part), (input.len(), SampledPart::Whole), "{name}");
    }
}

/// Nine tenths of the points crowd one tenth of a square; a sphere is dense at
/// one pole; a dense head is on a sparse body, as scanners see it.
#[test]
fn sparse_parts_of_a_surface_are_no_outliers() {
    let mut rng = rng(13);
    let square: Vec<_> = (0..40_000)
        .map(|i| {
            let x: f64 = rng.random();
            Point3::new(if i % 10 == 0 { x } else { 0.1 * x }, rng.random(), 0.0)
        })
        .collect();
    for (name, ratio, most) in [("graded", 50f64, 0.01), ("steep", 1000.0, 0.02)] {
        let graded: Vec<_> = random_sphere(60_000, 14)
            .into_iter()
            .filter(|p| rng.random::<f64>() < ratio.powf(0.5 * (p.z - 1.0)))
            .collect();
        let cloud = sampled(&graded, 100_000);
        let share = cloud.part.isolated() as f64 / graded.len() as f64;
        assert!(share <= most, "{share} of a {name} sphere of {} points", graded.len());
    }
    let share = sampled(&square, 100_000).part.isolated() as f64 / square.len() as f64;
    assert!(share <= 0.001, "{share} of the square");
}

#[test]
fn a_cloud_that_is_mostly_scattered_is_left_whole() {
    // A dense lump in a sparse volume: most of its points have no neighbours.
    let lump = strewn(1900, 1e-4, 15);
    let input = [lump, strewn(2000, 1.0, 16)].concat();
    let cloud = sampled(&input, 100_000);
    assert_eq!((cloud.points.len(), cloud.part), (3900, SampledPart::Whole));
}

/// As a ratio to the time that the rest of the sampling takes, both on this
/// machine and in this build.
#[test]
fn a_large_cloud_stays_quick() {
    let input = [random_sphere(160_000, 17), strewn(40_000, 2.0, 18)].concat();
    let timed = |isolated| {
        let start = Instant::now();
        let options = SamplingOptions { isolated, ..SamplingOptions::default() };
        let cloud = sample_cloud(&input, &options).unwrap();
        (start.elapsed().as_secs_f64(), cloud)
    };
    // On a busy machine either may be held up, now and then.
    let is_quick = (0..5).any(|_| {
        let (kept, _) = timed(Isolated::Keep);
        let (left_out, cloud) = timed(Isolated::LeaveOut);
        assert!(cloud.part.isolated() as f64 >= 0.9 * 40_000.0, "{:?}", cloud.part);
        assert!(unlabelled(&cloud, 0..160_000) <= 0.005);
        left_out <= 8.0 * kept + 1.0
    });
    assert!(is_quick, "it takes more than eight times as long");
}
