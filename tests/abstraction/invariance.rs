//! What must not matter to the result: where the shape lies, how it is turned,
//! its unit, the order of its points, and how many points describe it.
//!
//! The sampler draws at random, and in a chaotic way: a last bit that differs
//! may lead to another run. So results are not compared with one result, but
//! with those of several seeds: what changes must change no more than they do.

use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;

use crate::common::{abstracted, apart, union_mesh};
use nalgebra::{Point3, Rotation3, Vector3};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use superform::geometry::metrics::{MetricOptions, evaluate};
use superform::geometry::{SamplingOptions, Superquadric, sample_mesh};
use superform::inference::{Abstraction, Params};
use superform::io;

/// What is small, in longest edges: one seed or order in a dozen takes two
/// parts of the simple scenes for one, which moves the surface by a thousandth.
const NOISE: f64 = 0.003;

/// A similarity: x ↦ scale·R·x + offset.
#[derive(Clone, Copy)]
struct Motion {
    rotation: Rotation3<f64>,
    scale: f64,
    offset: Vector3<f64>,
}

impl Motion {
    fn none() -> Self {
        Self { rotation: Rotation3::identity(), scale: 1.0, offset: Vector3::zeros() }
    }

    fn of(&self, points: &[Point3<f64>]) -> Vec<Point3<f64>> {
        points.iter().map(|p| self.rotation * p * self.scale + self.offset).collect()
    }

    /// Takes a primitive of the moved shape back to where the shape was.
    fn back(&self, shape: &Superquadric) -> Superquadric {
        let inverse = self.rotation.inverse();
        Superquadric {
            semi_axes: shape.semi_axes / self.scale,
            rotation: inverse * shape.rotation,
            translation: inverse * ((shape.translation - self.offset) / self.scale),
            ..*shape
        }
    }
}

/// What is compared: the primitives where the shape was before it was moved.
struct Outcome {
    shapes: Vec<Superquadric>,
    /// Mean distance of the samples, in the shape's first unit.
    error: f64,
}

impl Outcome {
    fn new(a: &Abstraction, motion: &Motion) -> Self {
        Self {
            shapes: a.primitives.iter().map(|p| motion.back(&p.shape)).collect(),
            error: a.figures.mean_distance / motion.scale,
        }
    }
}

/// A shape, and what several seeds make of it. (Of the chair's parts two are
/// worth about their price: it has six to eight.)
struct Scene {
    name: &'static str,
    points: Vec<Point3<f64>>,
    /// Longest edge of its box.
    size: f64,
    seeds: Vec<Outcome>,
    /// The largest distance between two of these.
    spread: f64,
}

impl Scene {
    fn new(name: &'static str, points: Vec<Point3<f64>>) -> Self {
        let seeds: Vec<Outcome> = (1..=5)
            .map(|seed| {
                Outcome::new(&abstracted(&points, Params { seed, ..Params::default() }), &Motion::none())
            })
            .collect();
        let spread = (0..seeds.len())
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| apart(&seeds[i].shapes, &seeds[j].shapes))
            .fold(0.0, f64::max);
        let first = points[0];
        let (lo, hi) = points.iter().fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p)));
        Self { name, size: (hi - lo).max(), points, seeds, spread }
    }

    /// The same abstraction within noise.
    fn assert_same(&self, what: &str, points: &[Point3<f64>], motion: &Motion) {
        let found = Outcome::new(&abstracted(points, Params::default()), motion);
        let what = format!("{} {what}", self.name);
        let count = found.shapes.len();
        let counts = || self.seeds.iter().map(|s| s.shapes.len());
        let (fewest, most) = (counts().min().unwrap(), counts().max().unwrap());
        let slack = 2;
        assert!(
            (fewest - slack..=most + slack).contains(&count),
            "{what}: {count} primitives, other seeds find {fewest} to {most}"
        );
        let to = |s: &Outcome| apart(&found.shapes, &s.shapes);
        let nearest = self.seeds.iter().map(to).fold(f64::INFINITY, f64::min);
        assert!(
            nearest <= self.spread.max(NOISE),
            "{what}: {nearest} from the nearest of other seeds, which are {} apart",
            self.spread
        );
        let worst = self.seeds.iter().map(|s| s.error).fold(0.0, f64::max);
        assert!(
            found.error <= (1.1 * worst).max(NOISE * self.size),
            "{what}: mean distance {}, {worst} at most with other seeds",
            found.error
        );
    }
}

fn block(center: [f64; 3], semi_axes: [f64; 3]) -> Superquadric {
    Superquadric {
        exponents: [0.1, 0.1],
        semi_axes: semi_axes.into(),
        rotation: Rotation3::identity(),
        translation: center.into(),
        taper: [0.0, 0.0],
    }
}

fn round(height: f64, radius: f64, half: f64, taper: f64) -> Superquadric {
    Superquadric {
        exponents: [0.2, 1.0],
        taper: [taper; 2],
        ..block([0.0, 0.0, height], [radius, radius, half])
    }
}

/// Even samples of the surface of some primitives' union.
fn samples(shapes: &[Superquadric], count: usize) -> Vec<Point3<f64>> {
    let options = SamplingOptions { points: count, ..SamplingOptions::default() };
    sample_mesh(&union_mesh(shapes), &options).unwrap().points
}

fn chair(count: usize) -> Vec<Point3<f64>> {
    let options = SamplingOptions { points: count, ..SamplingOptions::default() };
    io::sample(&io::built_in().unwrap(), &options).unwrap().points
}

static SCENES: LazyLock<[Scene; 4]> = LazyLock::new(|| {
    let leg = |x: f64, y: f64| block([x, y, 0.0], [0.08, 0.08, 0.7]);
    let table = [
        block([0.0, 0.0, 0.75], [1.0, 0.7, 0.06]),
        leg(0.85, 0.55),
        leg(-0.85, 0.55),
        leg(0.85, -0.55),
        leg(-0.85, -0.55),
    ];
    let lamp = [round(0.05, 0.5, 0.05, 0.0), round(1.0, 0.06, 0.95, 0.0), round(2.2, 0.45, 0.3, -0.4)];
    // Long and thin: its box grows most when it is turned.
    let rifle = [
        block([0.0, 0.0, 0.0], [0.5, 0.05, 0.08]),
        block([1.0, 0.0, 0.03], [0.6, 0.02, 0.02]),
        block([-0.75, 0.0, -0.03], [0.3, 0.035, 0.09]),
        block([0.1, 0.0, -0.22], [0.07, 0.03, 0.16]),
        block([-0.3, 0.0, -0.2], [0.05, 0.03, 0.13]),
    ];
    [
        Scene::new("chair", chair(1500)),
        Scene::new("table", samples(&table, 1500)),
        Scene::new("lamp", samples(&lamp, 1500)),
        Scene::new("rifle", samples(&rifle, 1500)),
    ]
});

#[test]
fn turning_makes_no_difference() {
    for scene in &*SCENES {
        for angles in [[0.0, 0.0, FRAC_PI_2], [0.7, -1.1, 2.3], [0.5, 0.6, 0.78]] {
            let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
            let motion = Motion { rotation, ..Motion::none() };
            scene.assert_same(&format!("turned by {angles:?}"), &motion.of(&scene.points), &motion);
        }
    }
}

#[test]
fn shifting_makes_no_difference() {
    for scene in &*SCENES {
        for sizes in [10.0, 1e6] {
            let motion =
                Motion { offset: Vector3::new(1.0, 0.3, -0.7) * scene.size * sizes, ..Motion::none() };
            scene.assert_same(&format!("{sizes} sizes away"), &motion.of(&scene.points), &motion);
        }
    }
}

#[test]
fn the_unit_makes_no_difference() {
    for scene in &*SCENES {
        for scale in [1e-9, 1e12] {
            let motion = Motion { scale, ..Motion::none() };
            scene.assert_same(&format!("times {scale}"), &motion.of(&scene.points), &motion);
        }
    }
}

#[test]
fn the_order_of_the_points_makes_no_difference() {
    for scene in &*SCENES {
        for seed in 1..=2 {
            let mut shuffled = scene.points.clone();
            shuffled.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
            scene.assert_same(&format!("in order {seed}"), &shuffled, &Motion::none());
        }
    }
}

#[test]
fn twice_the_points_are_not_worse() {
    let shape = io::built_in().unwrap();
    let reference =
        io::reference(&shape, &MetricOptions { samples: 20_000, ..MetricOptions::default() }).unwrap();
    let error = |count: usize| {
        let points = chair(count);
        let of_seed = |seed| {
            let a = abstracted(&points, Params { seed, ..Params::default() });
            let shapes: Vec<_> = a.primitives.iter().map(|p| p.shape).collect();
            evaluate(&shapes, None, &reference).chamfer_l1.unwrap()
        };
        (1..=3).map(of_seed).sum::<f64>() / 3.0
    };
    let (once, twice) = (error(1500), error(3000));
    assert!(twice <= 1.15 * once, "Chamfer-L1 {once} of 1500 points, {twice} of 3000");
}
