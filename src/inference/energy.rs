//! Energy: one number for "the points are near", "there is nothing else" and
//! "few".
//!
//! ```text
//! E = Σ_points ρ(d(x, primitives)) + Σ_visible surface ρ(d(s, cloud)) + price(K)
//! ```
//!
//! Points count alike, the surface by its area in points' worth, so that the
//! first two terms are the two sides of the Chamfer-L1 distance between the
//! primitives' union and the cloud, in mean spacings times
//! 2N (as far as the cloud is even: a point stands for 0.9·s̄² of surface). The
//! price of the primitives is a share of that, too: one more has to lower the
//! error by so much. It grows as K^0.6: of a shape that has many parts
//! already one more says less about how simple it is. Unlike a likelihood of the points it knows when a
//! primitive sticks out over empty space.

use rayon::prelude::*;

use super::params::Params;
use super::state::Model;
use super::two_way::{Detail, SurfaceSample, rounded, sample_surface};
use crate::geometry::{Superquadric, kernel};

/// The mean error, in mean spacings, that a primitive has to save where
/// [`Params::primitive_cost`] is 1 and there are [`USUAL_COUNT`] of them.
const PRICE: f64 = 0.0112;
/// More points than this are closer together without telling more about what
/// is a part: the spacing of so many is what the price is measured by.
const MOST_POINTS: f64 = 5500.0;
const USUAL_COUNT: f64 = 8.0;
/// The price of K primitives grows with this power of K.
const GROWTH: f64 = 0.6;
/// A lonely point, of fewer neighbours than a surface gives, counts as this
/// many mean spacings at most: it may be an outlier.
pub(crate) const OUTLIER_SPACINGS: f64 = 2.0;
const LONELY: usize = 4;

/// What `count` primitives add to the energy.
pub(crate) fn price(model: &Model, params: &Params, count: usize) -> f64 {
    let crowding = (model.points.len() as f64 / MOST_POINTS).max(1.0).sqrt();
    let one = PRICE * params.primitive_cost * scale(model) * crowding;
    one * (count as f64).powf(GROWTH) / (GROWTH * USUAL_COUNT.powf(GROWTH - 1.0))
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
pub(crate) struct Piece {
    pub(crate) shape: Superquadric,
    /// Distance of each point of the cloud.
    pub(crate) distances: Vec<f32>,
    /// Surface samples, each with its cost where it is visible.
    samples: Vec<(SurfaceSample, f64)>,
    radius: f64,
}

impl Piece {
    pub(crate) fn new(model: &Model, shape: Superquadric) -> Self {
        Self::with(model, shape, Detail::Full)
    }

    /// With fewer samples of the surface where a rough estimate will do.
    pub(crate) fn with(model: &Model, shape: Superquadric, detail: Detail) -> Self {
        let mut distances = Vec::new();
        kernel::euclidean_distances(&shape, &model.block, &mut distances);
        let (samples, weight) = sample_surface(&shape, model.spacing, detail);
        let samples = samples
            .into_iter()
            .map(|s| (s, weight * rounded(model.field.offset(&s.place).distance, model.spacing)))
            .collect();
        // Samples are tested a little outside of the surface.
        let radius = shape.reach().norm() + model.spacing;
        Self { shape, distances, samples, radius }
    }

    pub(crate) fn may_touch(&self, other: &Piece) -> bool {
        (self.shape.translation - other.shape.translation).norm() < self.radius + other.radius
    }
}

/// Marks the place of a hider that isn't there.
const NONE: u32 = u32::MAX;
/// Hiders of a sample that are remembered.
const HIDERS: usize = 4;

/// The nearest piece to a point and the next one, with their distances.
#[derive(Debug, Clone, Copy)]
struct Nearest {
    first: (u32, f32),
    second: (u32, f32),
}

impl Default for Nearest {
    fn default() -> Self {
        Self { first: (NONE, f32::INFINITY), second: (NONE, f32::INFINITY) }
    }
}

impl Nearest {
    fn offer(&mut self, j: u32, distance: f32) {
        if distance < self.first.1 {
            self.second = std::mem::replace(&mut self.first, (j, distance));
        } else if distance < self.second.1 {
            self.second = (j, distance);
        }
    }
}

/// Pieces with what their error is made of, so that the error with some of
/// them replaced costs a fraction of a new sum.
#[derive(Debug, Clone)]
pub(crate) struct Assembly {
    pieces: Vec<Piece>,
    /// For each point its nearest piece and the next one, with their distances.
    nearest: Vec<Nearest>,
    /// For each point what it adds.
    point_costs: Vec<f64>,
    /// For each sample of each piece the first pieces that hide it.
    hiders: Vec<Vec<[u32; HIDERS]>>,
    /// What the visible surface of each piece adds.
    surface_costs: Vec<f64>,
    most: f64,
}

impl Assembly {
    pub(crate) fn new(model: &Model, pieces: Vec<Piece>) -> Self {
        let most = rounded(OUTLIER_SPACINGS * model.spacing, model.spacing);
        let mut whole = Self {
            nearest: vec![Nearest::default(); model.points.len()],
            point_costs: Vec::new(),
            hiders: Vec::new(),
            surface_costs: Vec::new(),
            pieces,
            most,
        };
        for (j, piece) in (0u32..).zip(&whole.pieces) {
            for (nearest, d) in whole.nearest.iter_mut().zip(&piece.distances) {
                nearest.offer(j, *d);
            }
        }
        whole.point_costs =
            (0u32..).zip(&whole.nearest).map(|(i, n)| whole.point_cost(model, i, n.first.1)).collect();
        whole.hiders = (0..whole.pieces.len()).into_par_iter().map(|j| whole.hiders_of(j)).collect();
        whole.surface_costs = whole
            .pieces
            .iter()
            .zip(&whole.hiders)
            .map(|(piece, hiders)| {
                let visible = piece.samples.iter().zip(hiders).filter(|(_, h)| h[0] == NONE);
                visible.map(|((_, cost), _)| cost).sum()
            })
            .collect();
        whole
    }

    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The pieces, of which none is left.
    pub(crate) fn take_pieces(&mut self) -> Vec<Piece> {
        std::mem::take(&mut self.pieces)
    }

    /// The piece nearest to each point; none where there are no pieces.
    pub(crate) fn nearest(&self) -> impl Iterator<Item = Option<u32>> {
        self.nearest.iter().map(|nearest| (nearest.first.0 != NONE).then_some(nearest.first.0))
    }

    fn point_cost(&self, model: &Model, i: u32, distance: f32) -> f64 {
        let cost = rounded(f64::from(distance), model.spacing);
        if cost > self.most && is_lonely(model, i) { self.most } else { cost }
    }

    fn hiders_of(&self, j: usize) -> Vec<[u32; HIDERS]> {
        let piece = &self.pieces[j];
        let near: Vec<(u32, &Superquadric)> = (0u32..)
            .zip(&self.pieces)
            .filter(|(k, other)| *k as usize != j && piece.may_touch(other))
            .map(|(k, other)| (k, &other.shape))
            .collect();
        piece
            .samples
            .iter()
            .map(|(s, _)| {
                let mut found = [NONE; HIDERS];
                let hiding = near.iter().filter(|(_, o)| o.contains(&s.outside)).map(|(k, _)| *k);
                for (place, k) in found.iter_mut().zip(hiding) {
                    *place = k;
                }
                found
            })
            .collect()
    }

    /// What the visible surface of piece `j` adds.
    pub(crate) fn surface_cost(&self, j: usize) -> f64 {
        self.surface_costs[j]
    }

    /// The first two terms of the energy.
    pub(crate) fn error(&self) -> f64 {
        self.point_costs.iter().sum::<f64>() + self.surface_costs.iter().sum::<f64>()
    }

    /// The same with the pieces `added` in the place of those at `removed`.
    pub(crate) fn error_with(&self, model: &Model, removed: &[usize], added: &[Piece]) -> f64 {
        let mut come = vec![f32::INFINITY; self.nearest.len()];
        for piece in added {
            come.iter_mut().zip(&piece.distances).for_each(|(least, d)| *least = least.min(*d));
        }
        let mut is_removed = vec![false; self.pieces.len()];
        removed.iter().for_each(|&j| is_removed[j] = true);
        let stays = |j: u32| j != NONE && !is_removed[j as usize];
        let mut there = 0.0;
        for (i, (nearest, come)) in (0u32..).zip(self.nearest.iter().zip(come)) {
            if stays(nearest.first.0) && nearest.first.1 <= come {
                there += self.point_costs[i as usize];
                continue;
            }
            let left = if stays(nearest.first.0) {
                nearest.first.1
            } else if stays(nearest.second.0) {
                nearest.second.1
            } else {
                let left = self.pieces.iter().zip(&is_removed).filter(|(_, is_removed)| !**is_removed);
                left.map(|(piece, _)| piece.distances[i as usize]).fold(f32::INFINITY, f32::min)
            };
            there += self.point_cost(model, i, come.min(left));
        }
        let mut back = 0.0;
        for (k, piece) in self.pieces.iter().enumerate() {
            if removed.contains(&k) {
                continue;
            }
            let come: Vec<&Superquadric> =
                added.iter().filter(|a| piece.may_touch(a)).map(|a| &a.shape).collect();
            let go = removed.iter().any(|&r| piece.may_touch(&self.pieces[r]));
            back += if come.is_empty() && !go {
                self.surface_costs[k]
            } else {
                self.surface_with(k, removed, &come)
            };
        }
        for (k, piece) in added.iter().enumerate() {
            let left = self.pieces.iter().enumerate().filter(|(j, _)| !removed.contains(j)).map(|(_, p)| p);
            let siblings = added.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, p)| p);
            let near: Vec<&Superquadric> =
                left.chain(siblings).filter(|o| piece.may_touch(o)).map(|o| &o.shape).collect();
            back += piece
                .samples
                .iter()
                .filter(|(s, cost)| *cost > 0.0 && !near.iter().any(|o| o.contains(&s.outside)))
                .map(|(_, cost)| cost)
                .sum::<f64>();
        }
        there + back
    }

    fn surface_with(&self, k: usize, removed: &[usize], added: &[&Superquadric]) -> f64 {
        let piece = &self.pieces[k];
        let still_hidden = |s: &SurfaceSample, hiders: &[u32; HIDERS]| {
            let known = hiders.iter().take_while(|h| **h != NONE);
            if known.clone().any(|&h| !removed.contains(&(h as usize))) {
                return true;
            }
            // All hiders that are known have gone; there may be more.
            hiders[HIDERS - 1] != NONE
                && self.pieces.iter().enumerate().any(|(j, o)| {
                    j != k && !removed.contains(&j) && piece.may_touch(o) && o.shape.contains(&s.outside)
                })
        };
        piece
            .samples
            .iter()
            .zip(&self.hiders[k])
            .filter(|((s, cost), hiders)| {
                *cost > 0.0 && !still_hidden(s, hiders) && !added.iter().any(|o| o.contains(&s.outside))
            })
            .map(|((_, cost), _)| cost)
            .sum()
    }
}
