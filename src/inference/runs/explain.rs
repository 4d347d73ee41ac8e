//! The odds of one point: what the next sweep would draw its table from.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::inference::data::normalization::Normalization;
use crate::inference::params::Algorithm;
use crate::inference::runs::checkpoint::Checkpoint;

/// The factor ½ of the density: noise goes to either side of the surface.
const HALF: f64 = 0.5;

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
    pub held: Option<Held>,
    /// The tables, in the order of the primitives.
    pub tables: Vec<Odds>,
    pub new: NewTable,
}

/// Why a sweep passes over a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Held {
    /// Its primitive is locked.
    Locked,
    /// It is pinned to its primitive.
    Pinned,
    /// It is frozen, since its primitive fits well.
    Frozen,
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
/// state of the sampler; `None` where there is no such sample, the state is of
/// another cloud, or a baseline's.
pub fn explain(points: &[Point3<f64>], checkpoint: &Checkpoint, sample: u32) -> Option<Explanation> {
    let Checkpoint { params, clusters, labels, .. } = checkpoint;
    if labels.len() != points.len() || params.algorithm != Algorithm::Sampler {
        return None;
    }
    let normalization = Normalization::of(points)?;
    let place = normalization.normalize(points.get(sample as usize)?);
    let label = labels[sample as usize];
    let present = clusters.get(label as usize);
    let mut sizes = vec![0.0; clusters.len()];
    for &l in labels {
        if let Some(size) = sizes.get_mut(l as usize) {
            *size += 1.0;
        }
    }
    if let Some(size) = sizes.get_mut(label as usize) {
        *size -= 1.0;
    }
    let (alpha, p0) = (params.alpha, params.p0);
    let new_weight = alpha * p0;
    let mut tables: Vec<Odds> = clusters
        .iter()
        .zip(sizes)
        .map(|(cluster, size)| {
            let sigma = cluster.sigma;
            let n = if cluster.locked { 0.0 } else { size };
            let distance = cluster.shape.radial_distance(&place).abs();
            let density = normal(distance, sigma);
            Odds {
                id: cluster.id,
                n,
                distance,
                distance_input: normalization.length(distance),
                sigma,
                density,
                weight: n * density * HALF,
                probability: 0.0,
            }
        })
        .collect();
    let total = new_weight + tables.iter().map(|t| t.weight).sum::<f64>();
    for table in &mut tables {
        table.probability = table.weight / total;
    }
    let held = if present.is_some_and(|c| c.locked) {
        Some(Held::Locked)
    } else if checkpoint.pinned.binary_search(&sample).is_ok() {
        Some(Held::Pinned)
    } else if checkpoint.frozen.binary_search(&sample).is_ok() {
        Some(Held::Frozen)
    } else {
        None
    };
    Some(Explanation {
        sample,
        present: present.map(|c| c.id),
        held,
        tables,
        new: NewTable { alpha, waiting: 0.0, p0, weight: new_weight, probability: new_weight / total },
    })
}

/// N(d; σ).
fn normal(d: f64, sigma: f64) -> f64 {
    (-d * d / (2.0 * sigma * sigma)).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt())
}

/// By how much lengths in input units are multiplied to be normalised; `None`
/// where the points all coincide.
pub fn normalised_scale(points: &[Point3<f64>]) -> Option<f64> {
    Normalization::of(points).map(|normalization| normalization.scale())
}

/// The normalised distance at which a new table, of weight α·p₀, draws a point
/// as much as a table with n points and noise σ, of weight n·N(d; σ)·½:
/// d = σ·√(2 ln(n·N(0; σ)·½ / α·p₀)). `None` where the new one wins everywhere.
pub fn new_table_distance(alpha: f64, p0: f64, n: f64, sigma: f64) -> Option<f64> {
    let odds = n * normal(0.0, sigma) * HALF / (alpha * p0);
    (odds >= 1.0 && odds.is_finite()).then(|| sigma * (2.0 * odds.ln()).sqrt())
}
