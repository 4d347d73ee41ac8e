//! One primitive with a class of outliers: expectation, maximisation and
//! switching (EMS), after Liu, Wu, Ruan and Chirikjian, *Robust and Accurate
//! Superquadric Recovery: a Probabilistic Approach* (CVPR 2022).
//!
//! With probability 1 − w₀ a point is drawn evenly over the surface, of area
//! A, and displaced by normal noise σ; with probability w₀ it comes from
//! anywhere in the points' box, of volume V. At distance d from the surface the
//! density is
//!
//! ```text
//! p(x) = (1 − w₀)·N(d) + w₀/V,    N(d) = exp(−d²/2σ²) / ((A + 2πσ²)·√(2πσ²))
//! ```
//!
//! where 2πσ² lets N pass into the normal law of space around a body that is
//! small beside its noise. Expectation gives each point the probability wᵢ of
//! having come from the surface, maximisation improves the primitive's
//! parameters with these weights, and then σ. Where that stalls, switching
//! tries configurations of other parameters and nearly the same surface.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::geometry::kernel::{self, Distance, PointBlock};
use crate::geometry::neighbors::KdTree;
use crate::geometry::{Superquadric, tessellate};
use crate::inference::control::Cancel;
use crate::inference::data::limits::Limits;
use crate::inference::data::model::Model;
use crate::inference::fit::levenberg_marquardt::{Area, Target, descend};
use crate::inference::fit::moments::{box_of_extents, ellipsoid_of_moments};
use crate::inference::fit::points::{START_SHRINK, similar_configurations};
use crate::inference::runs::checkpoint::Recovered;

/// Starts and configurations are tried on about this many of the points.
const PROBE_POINTS: usize = 300;
/// Rounds that a start and a switched configuration are tried for.
const PROBE_ROUNDS: u32 = 14;
/// LM steps of one maximisation.
const LM_STEPS: usize = 3;
/// Gain in mean log-likelihood, in nats a point, under which a round has
/// stalled, and above which a switched configuration is better.
const STALLED: f64 = 1e-4;
const BETTER: f64 = 2e-3;
/// σ in parts of √A at most: a body that is small beside its noise is a cloud
/// around a place, and no surface.
const LARGEST_SIGMA: f64 = 0.1;
/// Rounds and switches at most.
const ROUNDS: u32 = 100;
const SWITCHES: u32 = 2;
/// Shares of the points, the most crowded ones, that starts are made of.
const CROWDED: [f64; 3] = [1.0, 0.5, 0.25];
/// Neighbours by which crowded points are told from lonely ones.
const CROWD: usize = 6;
/// Points that are told apart in this way at most.
const CROWD_POINTS: usize = 4000;
/// A box of points thinner than this share of its length and width is tried
/// as a plate, too.
const PLATE: f64 = 0.1;
/// Extents count for at least this share of the longest in the volume of the
/// box: a flat cloud has outliers, too.
const SMALLEST_EXTENT: f64 = 0.05;

/// The points of one recovery and what is known of them beforehand.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    points: Vec<Point3<f64>>,
    all: PointBlock,
    /// Some of them, for probes.
    few: PointBlock,
    /// w₀.
    outlier_prior: f64,
    distance: Distance,
    /// ln V of the points' box.
    ln_volume: f64,
    axis_floor: f64,
    sigma_floor: f64,
}

/// A primitive on its way to the points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Estimate {
    pub(crate) shape: Superquadric,
    pub(crate) sigma: f64,
    /// Mean log-likelihood of the points.
    likelihood: f64,
}

/// The recovery of one primitive, round by round.
#[derive(Debug, Clone)]
pub(crate) struct Recovery {
    /// Shared by checkpoints.
    problem: Arc<Problem>,
    estimate: Estimate,
    rounds: u32,
    switches: u32,
    is_done: bool,
}

impl Problem {
    pub(crate) fn new(
        model: &Model,
        points: Vec<Point3<f64>>,
        outlier_prior: f64,
        distance: Distance,
    ) -> Self {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = Vector3::repeat(f64::NEG_INFINITY);
        for p in &points {
            (low, high) = (low.inf(&p.coords), high.sup(&p.coords));
        }
        let extent = high - low;
        let least = (SMALLEST_EXTENT * extent.max()).max(model.spacing);
        let stride = points.len().div_ceil(PROBE_POINTS).max(1);
        Self {
            all: points.iter().copied().collect(),
            few: points.iter().step_by(stride).copied().collect(),
            outlier_prior,
            distance,
            ln_volume: extent.map(|e| e.max(least).ln()).sum(),
            axis_floor: model.axis_floor(),
            sigma_floor: model.sigma_floor(),
            points,
        }
    }

    /// Bodies to start from: of all points, and of the more crowded ones, since
    /// a surface is denser than what is strewn about in space.
    fn starts(&self) -> Vec<Superquadric> {
        let stride = self.points.len().div_ceil(CROWD_POINTS).max(1);
        let some: Vec<Point3<f64>> = self.points.iter().step_by(stride).copied().collect();
        let tree = KdTree::new(&some);
        let mut by_crowd: Vec<(f64, u32)> = (0u32..)
            .zip(&some)
            .map(|(i, p)| (tree.nearest(p, CROWD + 1).last().map_or(0.0, |f| f.0), i))
            .collect();
        by_crowd.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let crowded = CROWDED.map(|share| {
            let n = (share * some.len() as f64).ceil() as usize;
            by_crowd.iter().take(n).map(|c| some[c.1 as usize]).collect::<Vec<_>>()
        });
        crowded.iter().flat_map(|points| self.starts_from(points)).collect()
    }

    /// Bodies for some of the points: their ellipsoid, the paper's smaller one,
    /// and a plate if they are flat.
    fn starts_from(&self, points: &[Point3<f64>]) -> Vec<Superquadric> {
        let moments = ellipsoid_of_moments(points, 1.0, self.axis_floor);
        let small = (moments.semi_axes * START_SHRINK).map(|a| a.max(self.axis_floor));
        let plate = box_of_extents(points, &moments, self.axis_floor);
        let mut starts = vec![moments, Superquadric { semi_axes: small, ..moments }];
        if plate.semi_axes.x < PLATE * plate.semi_axes.y {
            starts.push(plate);
        }
        starts
    }

    /// The noise that a start is given: the distance that as many points keep
    /// as are expected to be no outliers.
    fn first_sigma(&self, shape: &Superquadric) -> f64 {
        let mut distances = Vec::new();
        kernel::distances(shape, &self.few, self.distance, &mut distances);
        let mut squares: Vec<f64> = distances.iter().map(|&d| f64::from(d * d)).collect();
        squares.sort_by(f64::total_cmp);
        let n = ((1.0 - self.outlier_prior) * squares.len() as f64).ceil().max(1.0) as usize;
        let kept = &squares[..n.min(squares.len())];
        let sigma = (kept.iter().sum::<f64>() / kept.len().max(1) as f64).sqrt();
        self.bounded(sigma, tessellate::surface_area(shape))
    }

    /// σ within its bounds for a body of surface area `area`.
    fn bounded(&self, sigma: f64, area: f64) -> f64 {
        sigma.min(LARGEST_SIGMA * area.sqrt()).max(self.sigma_floor)
    }

    /// Expectation: for each point of `block` the probability of being no
    /// outlier; and the mean log-likelihood.
    fn expect(&self, shape: &Superquadric, sigma: f64, block: &PointBlock) -> (Vec<f64>, f64) {
        let variance = sigma * sigma;
        let area = tessellate::surface_area(shape) + margin(sigma);
        let ln_inlier =
            (1.0 - self.outlier_prior).ln() - area.ln() - 0.5 * (2.0 * std::f64::consts::PI * variance).ln();
        let ln_outlier = self.outlier_prior.ln() - self.ln_volume;
        let mut distances = Vec::new();
        kernel::distances(shape, block, self.distance, &mut distances);
        let mut sum = 0.0;
        let probability = |d: &f32| {
            let odds = ln_inlier - 0.5 * f64::from(d * d) / variance - ln_outlier;
            // ln(e^odds + 1), without overflow.
            let total = odds.max(0.0) + (-odds.abs()).exp().ln_1p();
            sum += ln_outlier + total;
            (odds - total).exp()
        };
        let weights: Vec<f64> = distances.iter().map(probability).collect();
        let n = weights.len().max(1) as f64;
        (weights, sum / n)
    }

    /// One round of expectation and maximisation.
    fn round(&self, from: &Estimate, block: &PointBlock, cancel: &Cancel) -> Estimate {
        let (weights, _) = self.expect(&from.shape, from.sigma, block);
        let total: f64 = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let variance = from.sigma * from.sigma;
        let margin = margin(from.sigma);
        let mut target = Target {
            points: block,
            distance: self.distance,
            weights: Some(&weights),
            area: Some(Area { price: 2.0 * variance * total, margin }),
            pull: 0.0,
        };
        // A body of which one side is seen reaches beyond its points, up to as
        // far again.
        let limits = Limits { reach: 2.0, ..Limits::surrounded(self.axis_floor) };
        let found = descend(&mut target, &from.shape, limits, LM_STEPS, STALLED, cancel);
        let sum = kernel::weighted_cost(&found.shape, block, &weights, self.distance);
        // ∂/∂σ of the expected log-likelihood is 0 where
        // Σ w·d² = σ²·Σ w·(1 + 4πσ²/(A + 2πσ²)).
        let area = tessellate::surface_area(&found.shape);
        let sigma = (sum / (total * (1.0 + 2.0 * margin / (area + margin)))).sqrt();
        let sigma = self.bounded(sigma, area);
        let (_, likelihood) = self.expect(&found.shape, sigma, block);
        Estimate { shape: found.shape, sigma, likelihood }
    }

    /// Some rounds on few points.
    fn probe(&self, start: &Superquadric, sigma: f64, cancel: &Cancel) -> Estimate {
        let mut estimate = Estimate { shape: *start, sigma, likelihood: f64::NEG_INFINITY };
        for _ in 0..PROBE_ROUNDS {
            let next = self.round(&estimate, &self.few, cancel);
            let gain = next.likelihood - estimate.likelihood;
            if gain.is_nan() || cancel.is_requested() {
                break;
            }
            estimate = next;
            if gain.abs() < STALLED {
                break;
            }
        }
        estimate
    }
}

/// 2πσ²: what the noise adds to the area.
fn margin(sigma: f64) -> f64 {
    2.0 * std::f64::consts::PI * sigma * sigma
}

impl Recovery {
    /// Chooses the likeliest of the starts: those from all points, and those
    /// from each of `parts`, given as points.
    pub(crate) fn new(problem: Problem, parts: &[Vec<Point3<f64>>], cancel: &Cancel) -> Self {
        let mut starts = problem.starts();
        starts.extend(parts.iter().flat_map(|part| problem.starts_from(part)));
        let best = starts
            .par_iter()
            .map(|start| problem.probe(start, problem.first_sigma(start), cancel))
            .collect::<Vec<_>>()
            .into_iter()
            .max_by(|a, b| a.likelihood.total_cmp(&b.likelihood));
        let estimate = best.unwrap_or(Estimate {
            shape: ellipsoid_of_moments(&problem.points, 1.0, problem.axis_floor),
            sigma: problem.sigma_floor,
            likelihood: f64::NEG_INFINITY,
        });
        let (_, likelihood) = problem.expect(&estimate.shape, estimate.sigma, &problem.all);
        Self {
            estimate: Estimate { likelihood, ..estimate },
            problem: Arc::new(problem),
            rounds: 0,
            switches: 0,
            is_done: false,
        }
    }

    /// How far it has come.
    pub(crate) fn recovered(&self) -> Recovered {
        let Self { problem, estimate, rounds, switches, is_done } = self;
        Recovered {
            shape: estimate.shape,
            sigma: estimate.sigma,
            likelihood: estimate.likelihood,
            rounds: *rounds,
            switches: *switches,
            is_done: *is_done,
            outlier_prior: problem.outlier_prior,
            distance: problem.distance,
        }
    }

    /// The recovery that had come so far with the same problem.
    pub(crate) fn resumed(problem: Problem, saved: &Recovered) -> Self {
        let Recovered { shape, sigma, likelihood, rounds, switches, is_done, .. } = *saved;
        let estimate = Estimate { shape, sigma, likelihood };
        Self { problem: Arc::new(problem), estimate, rounds, switches, is_done }
    }

    /// Takes another prior and distance from here on.
    pub(crate) fn tune(&mut self, outlier_prior: f64, distance: Distance) {
        if (self.problem.outlier_prior, self.problem.distance) == (outlier_prior, distance) {
            return;
        }
        let problem = Arc::make_mut(&mut self.problem);
        (problem.outlier_prior, problem.distance) = (outlier_prior, distance);
        let Estimate { shape, sigma, .. } = self.estimate;
        self.estimate.likelihood = problem.expect(&shape, sigma, &problem.all).1;
    }

    pub(crate) fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    pub(crate) fn is_done(&self) -> bool {
        self.is_done
    }

    /// For each point whether it is more likely of the surface than an outlier.
    pub(crate) fn inliers(&self) -> Vec<bool> {
        let Estimate { shape, sigma, .. } = &self.estimate;
        let (weights, _) = self.problem.expect(shape, *sigma, &self.problem.all);
        weights.iter().map(|w| *w > 0.5).collect()
    }

    /// One round on all points; where it gains nothing, a switch; where none
    /// is better, the end.
    pub(crate) fn round(&mut self, cancel: &Cancel) {
        if self.is_done {
            return;
        }
        let problem = &self.problem;
        let next = problem.round(&self.estimate, &problem.all, cancel);
        let gain = next.likelihood - self.estimate.likelihood;
        self.rounds += 1;
        if gain > 0.0 && next.shape.is_valid() {
            self.estimate = next;
        }
        if self.rounds >= ROUNDS {
            self.is_done = true;
        } else if gain.is_nan() || gain < STALLED {
            self.is_done = self.switches >= SWITCHES || !self.switch(cancel);
        }
    }

    /// Tries the similar configurations; whether one is better.
    fn switch(&mut self, cancel: &Cancel) -> bool {
        self.switches += 1;
        let problem = &self.problem;
        let (_, present) = problem.expect(&self.estimate.shape, self.estimate.sigma, &problem.few);
        let better = similar_configurations(&self.estimate.shape)
            .into_iter()
            .map(|shape| {
                let semi_axes = shape.semi_axes.map(|a| a.max(problem.axis_floor));
                let shape = Superquadric { semi_axes, ..shape };
                problem.probe(&shape, problem.first_sigma(&shape), cancel)
            })
            .find(|found| found.likelihood > present + BETTER);
        let Some(found) = better else { return false };
        let (_, likelihood) = problem.expect(&found.shape, found.sigma, &problem.all);
        if likelihood <= self.estimate.likelihood {
            return false;
        }
        self.estimate = Estimate { likelihood, ..found };
        true
    }

    /// All rounds that are left.
    pub(crate) fn finish(&mut self, cancel: &Cancel) {
        while !self.is_done && !cancel.is_requested() {
            self.round(cancel);
        }
    }
}
