//! The energy: one number for how near the points are, how much else there is,
//! and how few primitives do.
//!
//! ```text
//! E = Σ_points ρ(d(x, primitives)) + Σ_visible surface c(s) + Σ_free ρ(depth) + price(K)
//! ```
//!
//! docs/method.md explains the terms and says where each constant comes from.

use crate::geometry::{Superquadric, kernel};
use crate::inference::data::model::Model;
use crate::inference::data::restaurant::expected_tables;
use crate::inference::fit::symmetric::{
    Detail, SurfaceSample, pseudo_huber, sample_surface, surface_cost, taper_cost,
};
use crate::inference::params::Params;

/// The mean error, in mean spacings, that a primitive has to save where
/// [`Params::primitive_cost`] is 1 and there are [`USUAL_COUNT`] of them.
const PRICE: f64 = 0.0112;
/// More points than this are closer together without telling more about what
/// is a part: the spacing of so many is what the price is measured by.
const MOST_POINTS: f64 = 5500.0;
const USUAL_COUNT: f64 = 8.0;
/// The concentration at which the price is stated, the paper's.
const USUAL_ALPHA: f64 = 0.5;
/// The price falls with this power of the number of expected tables, so that from
/// α = 0.01 to 10 the number of primitives at least trebles.
const TABLES: f64 = 1.25;
/// The price of K primitives grows with this power of K.
const GROWTH: f64 = 0.6;
/// A lonely point, of fewer neighbours than a surface gives, counts as this
/// many mean spacings at most: it may be an outlier.
pub(crate) const OUTLIER_SPACINGS: f64 = 2.0;
const LONELY: usize = 4;

/// What `count` primitives add to the energy.
pub(crate) fn price(model: &Model, params: &Params, count: usize) -> f64 {
    let crowding = (model.points.len() as f64 / MOST_POINTS).max(1.0).sqrt();
    let one =
        PRICE * params.primitive_cost * scale(model) * crowding / relative_tables(model, params).powf(TABLES);
    one * (count as f64).powf(GROWTH) / (GROWTH * USUAL_COUNT.powf(GROWTH - 1.0))
}

/// How many tables α lets the restaurant expect, against the usual α: the more,
/// the less one costs.
fn relative_tables(model: &Model, params: &Params) -> f64 {
    let tables = |alpha| expected_tables(alpha, model.points.len());
    tables(params.alpha) / tables(USUAL_ALPHA)
}

/// 2·N·s̄: the energy of an error of one mean spacing.
pub(crate) fn scale(model: &Model) -> f64 {
    2.0 * model.points.len() as f64 * model.spacing
}

/// Whether a point has so few neighbours that it may be an outlier.
pub(crate) fn is_lonely(model: &Model, i: u32) -> bool {
    model.graph.of(i).len() < LONELY
}

/// A primitive with what does not depend on the others.
#[derive(Debug, Clone)]
pub(crate) struct PrimitiveTerms {
    pub(crate) shape: Superquadric,
    /// Distance of each point of the cloud.
    pub(crate) distances: Vec<f32>,
    /// Surface samples, each with its cost where it is visible.
    pub(crate) samples: Vec<(SurfaceSample, f64)>,
    /// What the space inside of it that was seen to be free adds.
    pub(crate) intrusion: f64,
    radius: f64,
}

impl PrimitiveTerms {
    pub(crate) fn new(model: &Model, shape: Superquadric) -> Self {
        Self::with(model, shape, Detail::Full)
    }

    /// With fewer samples of the surface where a rough estimate will do.
    pub(crate) fn with(model: &Model, shape: Superquadric, detail: Detail) -> Self {
        let mut distances = Vec::new();
        kernel::euclidean_distances(&shape, &model.block, &mut distances);
        let (samples, weight) = sample_surface(&shape, model.spacing, detail);
        let samples: Vec<(SurfaceSample, f64)> = samples
            .into_iter()
            .map(|s| {
                (
                    s,
                    weight
                        * surface_cost(
                            model.known.as_deref(),
                            &s.place,
                            model.surface.offset(&s.place).distance,
                            model.spacing,
                        ),
                )
            })
            .collect();
        let intrusion = model
            .known
            .as_ref()
            .map_or(0.0, |known| known.intrusion(&shape, |depth| pseudo_huber(depth, model.spacing)));
        let area = weight * samples.len() as f64;
        let intrusion =
            intrusion + if model.known.is_some() { taper_cost(&shape, area, model.spacing) } else { 0.0 };
        // Samples are tested a little outside of the surface.
        let radius = shape.reach().norm() + model.spacing;
        Self { shape, distances, samples, intrusion, radius }
    }

    pub(crate) fn may_touch(&self, other: &PrimitiveTerms) -> bool {
        (self.shape.translation - other.shape.translation).norm() < self.radius + other.radius
    }

    /// The distance of the centres, as a share of that at which the spheres around
    /// both would touch.
    pub(crate) fn apart(&self, other: &PrimitiveTerms) -> f64 {
        (self.shape.translation - other.shape.translation).norm() / (self.radius + other.radius)
    }
}
