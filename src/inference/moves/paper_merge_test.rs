//! The paper's merge test: the authors' thresholds for one primitive in the
//! place of two.

use nalgebra::{Point3, Vector3};

use crate::geometry::Superquadric;
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::{MergeReason, PaperFinding};
use crate::inference::data::model::{Model, sum_squared_radial};
use crate::inference::data::state::State;
use crate::inference::fit::points::{Effort, fit};
use crate::inference::moves::union_cache::Union;
use crate::inference::params::Params;

/// From this iteration on the tests of the authors' program are more lenient.
pub(crate) const LATE_ITERATION: u32 = 15;
/// The pair must fill this share of what holds both.
pub(crate) const FILL: f64 = 0.7;
/// Mean squared relative radial error under which a union is good.
pub(crate) const RELATIVE: f64 = 5e-3;
/// Mean d² under which a union is good, in the first pass and later.
const MEAN_D2: (f64, f64) = (1e-3, 1e-2);

/// Two clusters that may be one.
#[derive(Debug)]
pub(crate) struct Pair<'a> {
    model: &'a Model,
    /// Their primitives, the larger cluster's first.
    shapes: [&'a Superquadric; 2],
    parts: [Vec<Point3<f64>>; 2],
    /// The points of both, in order of index.
    points: Vec<Point3<f64>>,
    /// Mean d² under which a union is good by now.
    limit: f64,
}

/// What the test measures of one primitive for the pair.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measured {
    /// (B₁ + B₂)/B: volumes of the parts' boxes against that of both.
    pub(crate) fill: f64,
    /// (V₁ + V₂)/V: volumes of the primitives against that of the union.
    pub(crate) volumes: f64,
    /// Mean squared relative radial error, (r/|q|)², of the union, and of the
    /// worse of the two alone.
    pub(crate) relative: f64,
    pub(crate) worse_relative: f64,
    /// Mean d² of the union, and of the worse of the two alone.
    pub(crate) mean_d2: f64,
    pub(crate) worse_mean_d2: f64,
    /// Mean d² under which a union is good by now.
    pub(crate) limit: f64,
}

impl Measured {
    /// What decides.
    pub(crate) fn verdict(&self) -> MergeReason {
        let Self { fill, volumes, relative, worse_relative, mean_d2, worse_mean_d2, limit } = *self;
        let (finding, value, limit) = if fill < FILL {
            (PaperFinding::BoxTooEmpty, fill, FILL)
        } else if volumes < FILL {
            (PaperFinding::UnionTooEmpty, volumes, FILL)
        } else if relative <= worse_relative {
            (PaperFinding::RelativeErrorNoWorse, relative, worse_relative)
        } else if relative < RELATIVE {
            (PaperFinding::RelativeErrorSmall, relative, RELATIVE)
        } else if mean_d2 < limit {
            (PaperFinding::MeanSquareSmall, mean_d2, limit)
        } else if mean_d2 < worse_mean_d2 {
            (PaperFinding::MeanSquareLess, mean_d2, worse_mean_d2)
        } else {
            (PaperFinding::ErrorsTooLarge, relative, RELATIVE.max(worse_relative))
        };
        MergeReason::Paper { finding, value, limit }
    }
}

impl<'a> Pair<'a> {
    pub(crate) fn new(state: &'a State, members: &[Vec<u32>], a: usize, b: usize) -> Self {
        let model = &state.model;
        let mut union: Vec<u32> = members[a].iter().chain(&members[b]).copied().collect();
        union.sort_unstable();
        Self {
            model,
            shapes: [&state.clusters[a].shape, &state.clusters[b].shape],
            parts: [model.gather(&members[a]), model.gather(&members[b])],
            points: model.gather(&union),
            limit: if state.iteration <= LATE_ITERATION { MEAN_D2.0 } else { MEAN_D2.1 },
        }
    }

    /// (B₁ + B₂)/B in the first primitive's frame.
    pub(crate) fn fill(&self) -> f64 {
        let box_volume = |points: &[Point3<f64>]| {
            let mut lo = Vector3::repeat(f64::INFINITY);
            let mut hi = Vector3::repeat(f64::NEG_INFINITY);
            for p in points {
                let p = self.shapes[0].local(p);
                lo = lo.inf(&p);
                hi = hi.sup(&p);
            }
            (hi - lo).product()
        };
        (box_volume(&self.parts[0]) + box_volume(&self.parts[1])) / box_volume(&self.points)
    }

    /// One primitive for both; `None` when cancelled.
    pub(crate) fn fit(&self, params: &Params, cancel: &Cancel) -> Option<Superquadric> {
        let warm = self.shapes.map(|s| *s);
        let limits = self.model.limits();
        fit(&self.points, &warm, limits, Effort::THOROUGH, params.fit_distance, cancel).map(|m| m.shape)
    }

    /// The union as a merge takes it.
    pub(crate) fn union(&self, shape: Superquadric, measured: &Measured, reason: MergeReason) -> Union {
        Union { shape, sum_d2: measured.mean_d2 * self.points.len().max(1) as f64, reason }
    }

    pub(crate) fn measure(&self, union: &Superquadric) -> Measured {
        let relative = |shape: &Superquadric, points: &[Point3<f64>]| {
            let square = |p: &Point3<f64>| {
                let q = shape.untapered(&shape.local(p)).norm().max(self.model.axis_floor());
                (shape.radial_distance(p) / q).powi(2)
            };
            points.iter().map(square).sum::<f64>() / points.len().max(1) as f64
        };
        let mean_d2 = |shape: &Superquadric, points: &[Point3<f64>]| {
            sum_squared_radial(shape, points) / points.len().max(1) as f64
        };
        let worse = |measure: &dyn Fn(&Superquadric, &[Point3<f64>]) -> f64| {
            measure(self.shapes[0], &self.parts[0]).max(measure(self.shapes[1], &self.parts[1]))
        };
        Measured {
            fill: self.fill(),
            volumes: (self.shapes[0].volume() + self.shapes[1].volume()) / union.volume(),
            relative: relative(union, &self.points),
            worse_relative: worse(&relative),
            mean_d2: mean_d2(union, &self.points),
            worse_mean_d2: worse(&mean_d2),
            limit: self.limit,
        }
    }

    /// One primitive for both if it passes the test.
    pub(crate) fn acceptable_union(&self, params: &Params, cancel: &Cancel) -> Option<Union> {
        // Most pairs die here, where no fit is needed.
        if self.fill() < FILL {
            return None;
        }
        let shape = self.fit(params, cancel)?;
        let measured = self.measure(&shape);
        let reason = measured.verdict();
        reason.is_good().then(|| self.union(shape, &measured, reason))
    }
}
