//! Sampling: the right number of points, on the surface, evenly spread, the
//! same every time, and each input point tied to its nearest sample.

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use superform::geometry::neighbors::KdTree;
use superform::geometry::{
    Isolated, NO_SAMPLE, SampleCloud, SamplingError, SamplingOptions, TriMesh, sample_cloud, sample_mesh,
};

fn options(points: usize, seed: u64) -> SamplingOptions {
    SamplingOptions { points, seed, ..SamplingOptions::default() }
}

/// A rectangle of two triangles, at `corner`, with sides `u` and `v`.
fn rectangle(mesh: &mut TriMesh, corner: Point3<f64>, u: Vector3<f64>, v: Vector3<f64>) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend([corner, corner + u, corner + u + v, corner + v]);
    mesh.faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

fn unit_square() -> TriMesh {
    let mut mesh = TriMesh::default();
    rectangle(&mut mesh, Point3::origin(), Vector3::x(), Vector3::y());
    mesh
}

fn random_points(n: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| Point3::new(rng.random(), rng.random(), rng.random())).collect()
}

/// Distance of each point to its nearest other point.
fn gaps(points: &[Point3<f64>]) -> Vec<f64> {
    let tree = KdTree::new(points);
    points.iter().map(|p| tree.nearest(p, 2)[1].0.sqrt()).collect()
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Every finite input point is mapped to its nearest sample, by brute force.
fn assert_mapped_to_nearest(input: &[Point3<f64>], cloud: &SampleCloud) {
    let map = cloud.sample_of_input.as_ref().unwrap();
    assert_eq!(map.len(), input.len());
    for (p, &sample) in input.iter().zip(map) {
        if !p.iter().all(|c| c.is_finite()) {
            assert_eq!(sample, NO_SAMPLE);
            continue;
        }
        let to = |s: &Point3<f64>| (p - s).norm();
        let nearest = least(&cloud.points.iter().map(to).collect::<Vec<_>>());
        let own = to(&cloud.points[sample as usize]);
        assert!(own <= nearest * (1.0 + 1e-9) + p.coords.norm() * 1e-15, "{own} > {nearest}");
    }
}

#[test]
fn a_square_is_sampled_evenly() {
    let n = 2000;
    let cloud = sample_mesh(&unit_square(), &options(n, 3)).unwrap();
    assert_eq!(cloud.points.len(), n);
    assert_eq!(cloud.sample_of_input, None);
    let even = gaps(&cloud.points);
    // The densest arrangement of n points on a unit area has this spacing;
    // blue noise reaches some 70 % of it, random points next to nothing.
    let densest = (2.0 / (3f64.sqrt() * n as f64)).sqrt();
    assert!(least(&even) > 0.6 * densest, "{} of {densest}", least(&even));
    assert!(mean(&even) > 0.72 * densest);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let random: Vec<_> = (0..n).map(|_| Point3::new(rng.random(), rng.random(), 0.0)).collect();
    assert!(least(&even) > 10.0 * least(&gaps(&random)));
    assert!(mean(&even) > 1.4 * mean(&gaps(&random)));
    // No holes: no spot is farther from a sample than about one spacing.
    let tree = KdTree::new(&cloud.points);
    for q in random_points(2000, 9) {
        let q = Point3::new(q.x, q.y, 0.0);
        assert!(tree.nearest(&q, 1)[0].0.sqrt() < 1.2 * densest);
    }
}

#[test]
fn faces_get_samples_in_proportion_to_their_area() {
    let mut mesh = TriMesh::default();
    rectangle(&mut mesh, Point3::origin(), Vector3::x() * 3.0, Vector3::y() * 2.0);
    rectangle(&mut mesh, Point3::new(10.0, 0.0, 5.0), Vector3::y(), Vector3::z() * 2.0);
    // Faces without an area, and faces that point nowhere, take nothing.
    mesh.vertices.push(Point3::new(1e6, f64::NAN, 0.0));
    mesh.faces.extend([[0, 0, 1], [0, 1, 8], [0, 1, 99]]);
    let cloud = sample_mesh(&mesh, &options(4000, 1)).unwrap();
    let large = cloud.points.iter().filter(|p| p.x < 5.0).count() as f64;
    assert!((large / 4000.0 - 0.75).abs() < 0.01, "{large} of 4000 on three quarters of the area");
    for p in &cloud.points {
        let on_large =
            p.z.abs() < 1e-12 && (-1e-12..3.0 + 1e-12).contains(&p.x) && (-1e-12..2.0 + 1e-12).contains(&p.y);
        let on_small =
            (p.x - 10.0).abs() < 1e-12 && (-1e-12..1.0 + 1e-12).contains(&p.y) && p.z > 5.0 - 1e-12;
        assert!(on_large || on_small, "{p} is off the surface");
    }
}

#[test]
fn thin_legs_are_not_missed() {
    // A table top of area 2·1 on a leg of width 0.02 and height 1.
    let mut mesh = unit_square();
    rectangle(&mut mesh, Point3::origin(), -Vector3::z(), Vector3::x() * 0.02);
    let cloud = sample_mesh(&mesh, &options(3500, 1)).unwrap();
    let mut heights: Vec<f64> = cloud.points.iter().map(|p| -p.z).filter(|h| *h > 0.0).collect();
    heights.extend([0.0, 1.0]);
    heights.sort_by(f64::total_cmp);
    let widest = heights.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
    assert!(widest < 0.05, "a gap of {widest} along the leg");
}

#[test]
fn a_surface_folded_over_itself_is_sampled() {
    let mut mesh = TriMesh::default();
    for layer in 0..2000 {
        rectangle(&mut mesh, Point3::new(0.0, 0.0, f64::from(layer) * 1e-9), Vector3::x(), Vector3::y());
    }
    assert_eq!(sample_mesh(&mesh, &options(3500, 1)).unwrap().points.len(), 3500);
}

#[test]
fn scale_and_offset_make_no_difference() {
    for (scale, offset) in [(1e-9, 0.0), (1.0, 5.4e6), (1e12, -3e12), (1e-3, 4.5e5), (1e150, 0.0)] {
        let mut mesh = TriMesh::default();
        let at = Point3::new(offset, offset * 0.1, offset);
        rectangle(&mut mesh, at, Vector3::x() * scale, Vector3::y() * scale * 2.0);
        let cloud = sample_mesh(&mesh, &options(800, 2)).unwrap();
        assert_eq!(cloud.points.len(), 800);
        let local: Vec<_> = cloud.points.iter().map(|p| Point3::from((p - at) / scale)).collect();
        assert!(least(&gaps(&local)) > 0.02, "at scale {scale} and offset {offset}");

        let input: Vec<_> =
            random_points(3000, 4).iter().map(|p| Point3::from(p.coords * scale + at.coords)).collect();
        let thinned = sample_cloud(&input, &options(500, 2)).unwrap();
        assert_eq!(thinned.points.len(), 500);
        assert_mapped_to_nearest(&input, &thinned);
    }
}

#[test]
fn the_seed_decides_and_nothing_else() {
    let mesh = unit_square();
    let points = random_points(20_000, 8);
    let both =
        || (sample_mesh(&mesh, &options(900, 5)).unwrap(), sample_cloud(&points, &options(900, 5)).unwrap());
    let here = both();
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(both), here, "on {threads} threads");
    }
    assert_ne!(sample_mesh(&mesh, &options(900, 6)).unwrap(), here.0);
}

#[test]
fn a_large_cloud_is_thinned_evenly_to_points_of_its_own() {
    // Nine tenths of the points crowd one tenth of the square.
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut input: Vec<Point3<f64>> = (0..100_000)
        .map(|i| {
            let x: f64 = rng.random();
            Point3::new(if i % 10 == 0 { x } else { x * 0.1 }, rng.random(), 0.0)
        })
        .collect();
    input[17] = Point3::new(f64::NAN, 0.0, 0.0);
    let cloud = sample_cloud(&input, &options(1500, 1)).unwrap();
    assert_eq!(cloud.points.len(), 1500);
    assert!(cloud.points.iter().all(|p| input.contains(p)));
    let densest = (2.0 / (3f64.sqrt() * 1500.0)).sqrt();
    assert!(least(&gaps(&cloud.points)) > 0.5 * densest);
    let crowded = cloud.points.iter().filter(|p| p.x < 0.1).count() as f64 / 1500.0;
    assert!((0.07..0.14).contains(&crowded), "{crowded} of the samples on a tenth of the area");
    assert_mapped_to_nearest(&input, &cloud);
}

#[test]
fn dense_clumps_and_far_outliers_are_no_trap() {
    // All but 300 points lie in a cube a hundred-millionth of the box across.
    let mut input: Vec<_> = random_points(30_000, 2).iter().map(|p| Point3::from(p.coords * 1e-5)).collect();
    input.extend(random_points(300, 3).iter().map(|p| Point3::from(p.coords * 1e3)));
    let keep = SamplingOptions { isolated: Isolated::Keep, ..options(1000, 1) };
    let cloud = sample_cloud(&input, &keep).unwrap();
    assert_eq!(cloud.points.len(), 1000);
    // The far points are rare and far apart: all of them stay, if they may.
    assert!(cloud.points.iter().filter(|p| p.coords.norm() > 1.0).count() > 290);
    let cloud = sample_cloud(&input, &options(1000, 1)).unwrap();
    let isolated = cloud.part.isolated();
    // But for a few that see the others in one plane, and with a few of the clump.
    assert!(cloud.points.len() == 1000 && (285..=303).contains(&isolated), "{isolated} are isolated");

    // One point so far out that the others are one spot next to it.
    let mut input = random_points(5000, 4);
    input.push(Point3::new(1e300, 0.0, 0.0));
    let cloud = sample_cloud(&input, &options(1000, 1)).unwrap();
    assert!((2..=1000).contains(&cloud.points.len()));
    assert_eq!(cloud.sample_of_input.as_ref().unwrap().len(), 5001);
}

#[test]
fn small_clouds_are_taken_as_they_are_and_twins_collapse() {
    let p = |x: f64| Point3::new(x, 0.0, 0.0);
    let input = [p(0.0), p(1.0), p(0.0), p(f64::INFINITY), p(-0.0), p(2.0)];
    let cloud = sample_cloud(&input, &options(100, 1)).unwrap();
    assert_eq!(cloud.points, [p(0.0), p(1.0), p(2.0)]);
    assert_eq!(cloud.sample_of_input, Some(vec![0, 1, 0, NO_SAMPLE, 0, 2]));
    assert_eq!(cloud.labels_of_input(&[7, 8, 9], 99), [7, 8, 7, 99, 7, 9]);

    // More points than samples, but fewer places than samples.
    let input: Vec<_> = (0..4000).map(|i| p(f64::from(i % 200))).collect();
    let cloud = sample_cloud(&input, &options(1000, 1)).unwrap();
    assert_eq!(cloud.points.len(), 200);
    assert_mapped_to_nearest(&input, &cloud);
}

#[test]
fn what_has_no_surface_and_no_points_is_refused() {
    let line = TriMesh {
        vertices: (0..3).map(|i| Point3::new(f64::from(i), f64::from(i), 0.0)).collect(),
        faces: vec![[0, 1, 2]],
    };
    assert_eq!(sample_mesh(&line, &options(10, 1)), Err(SamplingError::NoArea));
    assert_eq!(sample_mesh(&TriMesh::default(), &options(10, 1)), Err(SamplingError::NoArea));
    let nowhere = [Point3::new(f64::NAN, 0.0, 0.0)];
    assert_eq!(sample_cloud(&nowhere, &options(10, 1)), Err(SamplingError::NoPoints));
    assert_eq!(sample_cloud(&[], &options(10, 1)), Err(SamplingError::NoPoints));
    assert!(options(0, 1).check().is_err() && options(3500, 1).check().is_ok());
}

/// Coordinates as they come: of any size, equal, and not finite.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -1.0..1.0f64,
        2 => (-3i8..3).prop_map(f64::from),
        1 => prop::num::f64::ANY,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_cloud_gives_distinct_samples_of_its_own_and_a_whole_map(
        input in prop::collection::vec([coordinate(), coordinate(), coordinate()], 1..200),
        wanted in 1usize..150,
        axes in 1usize..4,
    ) {
        // Also linear and flat clouds.
        let input: Vec<_> = input
            .iter()
            .map(|c| Point3::new(c[0], if axes > 1 { c[1] } else { 0.0 }, if axes > 2 { c[2] } else { 0.0 }))
            .collect();
        let finite = input.iter().filter(|p| p.iter().all(|c| c.is_finite())).count();
        let Ok(cloud) = sample_cloud(&input, &options(wanted, 1)) else {
            prop_assert_eq!(finite, 0);
            return Ok(());
        };
        prop_assert!(!cloud.points.is_empty() && cloud.points.len() <= wanted.min(finite));
        let map = cloud.sample_of_input.as_ref().unwrap();
        prop_assert_eq!(map.len(), input.len());
        let mut used = vec![false; cloud.points.len()];
        for (p, &s) in input.iter().zip(map) {
            prop_assert_eq!(s == NO_SAMPLE, !p.iter().all(|c| c.is_finite()));
            if s != NO_SAMPLE && cloud.points[s as usize] == *p {
                used[s as usize] = true;
            }
        }
        // Each sample is an input point, and that point maps to it.
        prop_assert!(used.iter().all(|&u| u));
    }

    #[test]
    fn any_mesh_gives_exactly_the_wanted_number_or_says_why_not(
        vertices in prop::collection::vec([coordinate(), coordinate(), coordinate()], 3..20),
        faces in prop::collection::vec([0u32..22, 0u32..22, 0u32..22], 1..20),
        wanted in 1usize..60,
    ) {
        let mesh = TriMesh { vertices: vertices.into_iter().map(Point3::from).collect(), faces };
        match sample_mesh(&mesh, &options(wanted, 1)) {
            Ok(cloud) => {
                prop_assert_eq!(cloud.points.len(), wanted);
                let (lo, hi) = mesh.bounds().unwrap();
                let slack = (hi - lo) * 1e-9;
                for p in &cloud.points {
                    prop_assert!(p.iter().all(|c| c.is_finite()));
                    for k in 0..3 {
                        prop_assert!(p[k] >= lo[k] - slack[k].abs() - 1e-300 && p[k] <= hi[k] + slack[k].abs() + 1e-300);
                    }
                }
            }
            Err(e) => prop_assert_eq!(e, SamplingError::NoArea),
        }
    }
}
