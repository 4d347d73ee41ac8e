//! Scalar values of the samples that can be shown as colours.

use std::sync::Arc;

use nalgebra::Point3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::scene::SceneFromInput;
use crate::geometry::kernel::{PointBlock, euclidean_distances};
use crate::geometry::metrics::Nearest;
use crate::geometry::tessellate::{Resolution, surface_vertices};
use crate::inference::{Abstraction, Primitive, UNASSIGNED, align_labels, label_entropy};

/// Unit of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// The input's unit of length.
    #[default]
    Length,
    /// Fraction of the maximum possible value.
    Share,
}

/// The value with the last colour.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Top {
    /// A value above 95 % of the values.
    #[default]
    Robust,
    /// The largest value.
    Most,
    At(f32),
}

/// Share of the values below the robust top, in percent.
const ROBUST: usize = 95;

/// A value for each sample, with the range of the colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Scalar {
    /// Title for the legend.
    pub title: String,
    pub unit: Unit,
    /// In the order of the samples; NaN for no value.
    pub values: Arc<[f32]>,
    /// Range of the colours.
    pub range: (f32, f32),
    extent: Extent,
}

impl Scalar {
    /// Lengths, with a range from 0 to a round number above 95 % of the values.
    pub fn from_zero(title: &str, values: Vec<f32>) -> Self {
        let extent = Extent::of(values.iter().copied());
        let range = (0.0, extent.top(Top::Robust));
        Self { title: title.to_owned(), unit: Unit::Length, values: values.into(), range, extent }
    }

    #[must_use]
    pub fn with_unit(self, unit: Unit) -> Self {
        Self { unit, ..self }
    }

    /// The same values with another end of the range.
    #[must_use]
    pub fn with_top(&self, top: Top) -> Self {
        Self { range: (0.0, self.extent.top(top)), ..self.clone() }
    }

    /// Position of a sample's value in the range, within [0, 1]; `None` for no value.
    pub fn share(&self, sample: usize) -> Option<f32> {
        let value = *self.values.get(sample)?;
        let (low, high) = self.range;
        (!value.is_nan()).then(|| ((value - low) / (high - low)).clamp(0.0, 1.0))
    }

    /// The largest value.
    pub fn most(&self) -> f32 {
        self.extent.most
    }

    /// Whether some values are above the range and share its last colour.
    pub fn exceeds_range(&self) -> bool {
        self.extent.most > self.range.1
    }
}

/// A value for each vertex of the primitives' surfaces, as
/// [`surface_vertices`] gives them for [`Resolution::SCREEN`].
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceScalar {
    /// Title for the legend.
    pub title: String,
    pub unit: Unit,
    /// Ids of primitives with the numbers at their vertices; NaN where there is
    /// none.
    pub values: Arc<[(u32, Vec<f32>)]>,
    /// Range of the colours.
    pub range: (f32, f32),
    extent: Extent,
}

impl SurfaceScalar {
    /// As [`Scalar::from_zero`].
    pub fn from_zero(title: &str, values: Vec<(u32, Vec<f32>)>) -> Self {
        let extent = Extent::of(values.iter().flat_map(|(_, values)| values).copied());
        let range = (0.0, extent.top(Top::Robust));
        Self { title: title.to_owned(), unit: Unit::Length, values: values.into(), range, extent }
    }

    /// The same values with another end of the range.
    #[must_use]
    pub fn with_top(&self, top: Top) -> Self {
        Self { range: (0.0, self.extent.top(top)), ..self.clone() }
    }

    /// Where a number lies in the range, within [0, 1]; NaN stays.
    pub fn share(&self, value: f32) -> f32 {
        let (low, high) = self.range;
        ((value - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// The largest value.
    pub fn most(&self) -> f32 {
        self.extent.most
    }

    /// Whether some values are above the range and share its last colour.
    pub fn exceeds_range(&self) -> bool {
        self.extent.most > self.range.1
    }
}

/// Statistics of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extent {
    /// A round number above almost all values.
    robust: f32,
    most: f32,
}

impl Extent {
    fn of(values: impl Iterator<Item = f32>) -> Self {
        let mut finite: Vec<f32> = values.filter(|v| v.is_finite()).collect();
        let most = finite.iter().copied().fold(0.0, f32::max);
        let rank = finite.len().saturating_sub(1) * ROBUST / 100;
        let robust =
            if finite.is_empty() { 0.0 } else { *finite.select_nth_unstable_by(rank, f32::total_cmp).1 };
        // Where next to all are 0, the others are what there is to see.
        let robust = if robust > 0.0 { robust } else { most };
        let robust = if robust > 0.0 { round_up(f64::from(robust)) as f32 } else { 1.0 };
        Self { robust, most }
    }

    /// Always positive.
    fn top(&self, top: Top) -> f32 {
        match top {
            Top::At(value) if value.is_normal() && value > 0.0 => value,
            Top::Most if self.most > 0.0 => self.most,
            _ => self.robust,
        }
    }
}

/// The distance of each vertex of the primitives' surfaces to the shape, in
/// input units.
pub fn surface_distances(primitives: &[Primitive], shape: &Nearest) -> Vec<(u32, Vec<f32>)> {
    let of_one = |primitive: &Primitive| {
        let vertices: Vec<Point3<f64>> =
            surface_vertices(&primitive.shape, Resolution::SCREEN).map(|(vertex, _)| vertex).collect();
        (primitive.id, shape.distances(&vertices).into_iter().map(|d| d as f32).collect())
    };
    primitives.par_iter().filter(|p| p.shape.is_valid()).map(of_one).collect()
}

/// How much runs with several seeds disagree about each sample: the entropy of
/// its labels over them ([`label_entropy`]), once what stands for the same part
/// as in the first has its label. What stands for no part of the first is a
/// label of its own in each.
pub fn seed_entropy(runs: &[&[u32]]) -> Vec<f32> {
    let Some(first) = runs.first() else { return Vec::new() };
    let mut aligned = vec![first.to_vec()];
    for (run, labels) in (1..).zip(&runs[1..]) {
        let names = align_labels(first, labels);
        // Far beyond the labels of any run, and each run's its own.
        let own = |label: u32| (u32::MAX / 64 * (run % 60 + 1)).wrapping_add(label % (u32::MAX / 64));
        let name = |&label: &u32| match label {
            UNASSIGNED => UNASSIGNED,
            label => names.get(&label).copied().unwrap_or_else(|| own(label)),
        };
        aligned.push(labels.par_iter().with_min_len(1 << 14).map(name).collect());
    }
    label_entropy(&aligned.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

/// The least of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten that is no less
/// than a positive number.
pub fn round_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    // What lacks only by rounding is taken as it is.
    steps.iter().map(|s| s * power).find(|&s| s >= value * (1.0 - 1e-6)).unwrap_or(10.0 * power)
}

/// The greatest of 1, 2, 5 times a power of ten that is no more than a positive
/// number: the length of a grid's cell.
pub fn round_down(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    let steps = [5.0, 2.0, 1.0];
    steps.iter().map(|s| s * power).find(|&s| s <= value * (1.0 + 1e-9)).unwrap_or(power)
}

/// Samples in scene units, as the distances want them.
fn block(samples: &[Point3<f64>], scene: &SceneFromInput) -> PointBlock {
    samples.iter().map(|p| scene.point(p)).collect()
}

/// The first-order distance of each sample to the surface of its own primitive
/// in input units; NaN for those without.
pub fn own_distances(samples: &[Point3<f64>], state: &Abstraction, scene: &SceneFromInput) -> Vec<f32> {
    let mut values = vec![f32::NAN; samples.len()];
    let to_input = 1.0 / scene.scale() as f32;
    let of_each: Vec<(Vec<usize>, Vec<f32>)> = state
        .primitives
        .par_iter()
        .filter(|p| p.shape.is_valid() && p.id != UNASSIGNED)
        .map(|primitive| {
            let own: Vec<usize> =
                (0..samples.len()).filter(|&i| state.labels.get(i) == Some(&primitive.id)).collect();
            let block: PointBlock = own.iter().map(|&i| scene.point(&samples[i])).collect();
            let mut distances = Vec::new();
            euclidean_distances(&scene.shape(&primitive.shape), &block, &mut distances);
            (own, distances)
        })
        .collect();
    for (own, distances) in of_each {
        for (i, distance) in own.into_iter().zip(distances) {
            values[i] = distance.abs() * to_input;
        }
    }
    values
}

/// The first-order distance of each sample to the nearest surface of all the
/// primitives in input units; NaN where there is none.
pub fn nearest_distances(samples: &[Point3<f64>], state: &Abstraction, scene: &SceneFromInput) -> Vec<f32> {
    let block = block(samples, scene);
    let to_input = 1.0 / scene.scale() as f32;
    state
        .primitives
        .par_iter()
        .filter(|p| p.shape.is_valid())
        .map(|primitive| {
            let mut distances = Vec::new();
            euclidean_distances(&scene.shape(&primitive.shape), &block, &mut distances);
            distances
        })
        .reduce(
            || vec![f32::NAN; samples.len()],
            // `min` takes the number where the other is none.
            |a, b| a.into_iter().zip(b).map(|(a, b)| a.abs().min(b.abs())).collect(),
        )
        .into_iter()
        .map(|d| d * to_input)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Superquadric;
    use crate::inference::{Figures, Phase, Primitive, Sighting};
    use crate::session::scene::UpAxis;

    fn state(centers: &[f64], labels: &[u32]) -> Abstraction {
        let primitive = |(id, x): (usize, &f64)| Primitive {
            id: id as u32,
            shape: Superquadric::sphere(Point3::new(*x, 0.0, 0.0), 2.0),
            sigma: 0.1,
            points: 1,
            mean_distance: 0.0,
            locked: false,
        };
        Abstraction {
            phase: Phase::Finished,
            iteration: 1,
            labels: labels.into(),
            primitives: centers.iter().enumerate().map(primitive).collect::<Vec<_>>().into(),
            figures: Figures::default(),
            pinned: [].into(),
            sighting: Sighting::default(),
        }
    }

    #[test]
    fn distances_are_to_ones_own_or_to_the_nearest_in_input_units() {
        // Far from the origin, and 40 units large.
        let shift = 5e5;
        let points: Vec<_> =
            [3.0, 17.5, 20.0, -20.0].iter().map(|x| Point3::new(shift + x, 0.0, 0.0)).collect();
        let scene = SceneFromInput::fit(&points, UpAxis::Z);
        let state = state(&[shift, shift + 15.0], &[0, 1, 0, UNASSIGNED]);
        let own = own_distances(&points, &state, &scene);
        let nearest = nearest_distances(&points, &state, &scene);
        for (i, (own_expected, nearest_expected)) in
            [(1.0, 1.0), (0.5, 0.5), (18.0, 3.0), (f32::NAN, 18.0)].into_iter().enumerate()
        {
            assert!(
                (own[i] - own_expected).abs() < 1e-3 || own[i].is_nan() && own_expected.is_nan(),
                "{own:?}"
            );
            assert!((nearest[i] - nearest_expected).abs() < 1e-3, "{nearest:?}");
        }
        let nothing = Abstraction { primitives: Arc::default(), ..state };
        assert!(nearest_distances(&points, &nothing, &scene).iter().all(|d| d.is_nan()));
    }

    #[test]
    fn the_range_is_round_and_leaves_out_next_to_nothing() {
        for scale in [1e-9_f32, 0.37, 1.0, 8.3e6] {
            let values: Vec<f32> = (0..1000).map(|i| i as f32 * scale).collect();
            let scalar = Scalar::from_zero("d", values);
            let above = scalar.values.iter().filter(|&&v| v > scalar.range.1).count();
            assert!(above <= 50 && scalar.range.1 <= 1500.0 * scale, "{scale}: {above}");
            assert_eq!(scalar.exceeds_range(), above > 0);
            assert_eq!(scalar.share(0), Some(0.0));
        }
        for values in [vec![], vec![f32::NAN], vec![0.0; 3]] {
            let scalar = Scalar::from_zero("d", values);
            assert_eq!(scalar.range, (0.0, 1.0));
        }
        assert_eq!(round_up(0.03), 0.03);
        assert_eq!(round_up(0.031), 0.04);
        for (value, expected) in [(0.13, 0.1), (0.2, 0.2), (499.0, 200.0), (1e-6, 1e-6), (7.0, 5.0)] {
            assert!((round_down(value) / expected - 1.0).abs() < 1e-9, "{value}");
        }
    }

    #[test]
    fn the_range_ends_where_it_was_asked_to() {
        let mut values = vec![0.1_f32; 99];
        values.push(7.25);
        let scalar = Scalar::from_zero("d", values);
        assert_eq!(scalar.range.1, 0.1, "one outlier doesn't matter");
        assert!(scalar.exceeds_range());
        assert_eq!(scalar.with_top(Top::Most).range, (0.0, 7.25));
        assert_eq!(scalar.with_top(Top::At(0.5)).range, (0.0, 0.5));
        for bad in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
            assert_eq!(scalar.with_top(Top::At(bad)).range, scalar.range, "{bad}");
        }
        // Where next to all are 0, the few others are what there is to see.
        let mut values = vec![0.0_f32; 99];
        values.push(0.5);
        assert_eq!(Scalar::from_zero("h", values).range.1, 0.5);
    }

    #[test]
    fn seeds_disagree_where_no_part_stands_for_the_other() {
        // The same two parts under other names; then one that cuts the second.
        let a = [0, 0, 0, 1, 1, 1, 1];
        let b = [9, 9, 9, 4, 4, 4, 4];
        let c = [2, 2, 2, 0, 0, 0, 7];
        assert_eq!(seed_entropy(&[&a, &b]), [0.0; 7]);
        let entropy = seed_entropy(&[&a, &b, &c]);
        assert!(entropy[..6].iter().all(|&h| h == 0.0), "{entropy:?}");
        // Two of three agree: H = ln 3 − (2/3) ln 2, as a share of ln 3.
        let expected = (3.0_f32.ln() - 2.0 / 3.0 * 2.0_f32.ln()) / 3.0_f32.ln();
        assert!((entropy[6] - expected).abs() < 1e-6, "{entropy:?}");
        // Two that each make a part of their own don't agree by that.
        let d = [2, 2, 2, 0, 0, 0, 7];
        let all = seed_entropy(&[&a, &c, &d]);
        assert!((all[6] - 1.0).abs() < 1e-6, "{all:?}");
        assert!(seed_entropy(&[]).is_empty());
    }
}
