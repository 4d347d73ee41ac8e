//! The odds of one point: what the next sweep would draw its table from.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::checkpoint::Checkpoint;
use super::frame::Frame;

/// What the sweep would draw the table of one sample from, were it the first to
/// choose: the terms of the paper's two equations.
///
/// ```text
/// p(zᵢ = j)   ∝ n₋ᵢ,ⱼ · N(d(θⱼ, xᵢ); σⱼ) · ½
/// p(zᵢ = new) ∝ α · p₀
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Explanation {
    pub sample: u32,
    /// Id of its present primitive; none where it is unassigned.
    pub present: Option<u32>,
    /// Why the sweep would not draw at all; none where it would.
    pub held: Option<String>,
    /// The tables, in the order of the primitives.
    pub tables: Vec<Odds>,
    pub new: NewTable,
}

/// The odds of an existing table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Odds {
    pub id: u32,
    /// n₋ᵢ,ⱼ: its points without this one; 0 where it is locked, since nobody
    /// may join then.
    pub n: f64,
    /// d = |r|, the radial distance, normalised.
    pub distance: f64,
    /// The same in input units.
    pub distance_input: f64,
    /// σ, normalised.
    pub sigma: f64,
    /// N(d; σ), normalised.
    pub density: f64,
    /// n·N·½.
    pub weight: f64,
    /// The weight's share of all.
    pub probability: f64,
}

/// The odds of a new table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NewTable {
    pub alpha: f64,
    /// Points that wait for a new table and count with α: none before the first
    /// choice.
    pub waiting: f64,
    pub p0: f64,
    /// (α + waiting)·p₀.
    pub weight: f64,
    pub probability: f64,
}

/// The odds of each table for one sample of `points` (in input units) in a
/// state; `None` where there is no such sample or the state is of another
/// cloud.
pub fn explain(points: &[Point3<f64>], checkpoint: &Checkpoint, sample: u32) -> Option<Explanation> {
    let _ = (points, checkpoint, sample);
    None
}

/// By how much lengths in input units are multiplied to be normalised; `None`
/// where the points all coincide.
pub fn normalised_scale(points: &[Point3<f64>]) -> Option<f64> {
    Frame::of(points).map(|frame| 1.0 / frame.length(1.0))
}

/// The number of tables that a Chinese restaurant of n guests has on average:
/// Σ α/(α + i), i = 0 … n − 1.
pub fn expected_tables(alpha: f64, n: usize) -> f64 {
    (0..n).map(|i| alpha / (alpha + i as f64)).sum()
}

/// The normalised distance at which a new table draws a point as much as a
/// table with n points and noise σ; `None` where the new one wins everywhere.
pub fn new_table_distance(alpha: f64, p0: f64, n: f64, sigma: f64) -> Option<f64> {
    let _ = (alpha, p0, n, sigma);
    None
}
