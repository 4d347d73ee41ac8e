//! The first two terms of the energy of some primitives, kept so that the
//! terms with some of them replaced cost a fraction of a new sum.

use rayon::prelude::*;

use crate::geometry::Superquadric;
use crate::inference::data::model::Model;
use crate::inference::fit::symmetric::{SurfaceSample, pseudo_huber};
use crate::inference::objective::energy::{OUTLIER_SPACINGS, PrimitiveTerms, is_lonely};

/// Marks the place of a hider that isn't there.
const NONE: u32 = u32::MAX;
/// Hiders of a sample that are remembered.
const OCCLUDERS: usize = 4;

/// The nearest primitive to a point and the next one, with their distances.
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
pub(crate) struct EnergyCache {
    primitives: Vec<PrimitiveTerms>,
    /// For each point its nearest primitive and the next one, with their distances.
    nearest: Vec<Nearest>,
    /// For each point what it adds.
    point_costs: Vec<f64>,
    /// For each sample of each primitive the first primitives that hide it.
    occluders: Vec<Vec<[u32; OCCLUDERS]>>,
    /// What the visible surface of each primitive and free space inside it add.
    surface_costs: Vec<f64>,
    most: f64,
}

impl EnergyCache {
    pub(crate) fn new(model: &Model, primitives: Vec<PrimitiveTerms>) -> Self {
        let most = pseudo_huber(OUTLIER_SPACINGS * model.spacing, model.spacing);
        let mut whole = Self {
            nearest: vec![Nearest::default(); model.points.len()],
            point_costs: Vec::new(),
            occluders: Vec::new(),
            surface_costs: Vec::new(),
            primitives,
            most,
        };
        for (j, primitive) in (0u32..).zip(&whole.primitives) {
            for (nearest, d) in whole.nearest.iter_mut().zip(&primitive.distances) {
                nearest.offer(j, *d);
            }
        }
        whole.point_costs =
            (0u32..).zip(&whole.nearest).map(|(i, n)| whole.point_cost(model, i, n.first.1)).collect();
        whole.occluders =
            (0..whole.primitives.len()).into_par_iter().map(|j| whole.occluders_of(j)).collect();
        whole.surface_costs = whole
            .primitives
            .iter()
            .zip(&whole.occluders)
            .map(|(primitive, occluders)| {
                let visible = primitive.samples.iter().zip(occluders).filter(|(_, h)| h[0] == NONE);
                visible.map(|((_, cost), _)| cost).sum::<f64>() + primitive.intrusion
            })
            .collect();
        whole
    }

    pub(crate) fn primitives(&self) -> &[PrimitiveTerms] {
        &self.primitives
    }

    /// The primitives, of which none is left.
    pub(crate) fn take_primitives(&mut self) -> Vec<PrimitiveTerms> {
        std::mem::take(&mut self.primitives)
    }

    /// The primitive nearest to each point; none where there are no primitives.
    pub(crate) fn nearest(&self) -> impl Iterator<Item = Option<u32>> {
        self.nearest.iter().map(|nearest| (nearest.first.0 != NONE).then_some(nearest.first.0))
    }

    fn point_cost(&self, model: &Model, i: u32, distance: f32) -> f64 {
        let cost = pseudo_huber(f64::from(distance), model.spacing);
        if cost > self.most && is_lonely(model, i) { self.most } else { cost }
    }

    fn occluders_of(&self, j: usize) -> Vec<[u32; OCCLUDERS]> {
        let primitive = &self.primitives[j];
        let near: Vec<(u32, &Superquadric)> = (0u32..)
            .zip(&self.primitives)
            .filter(|(k, other)| *k as usize != j && primitive.may_touch(other))
            .map(|(k, other)| (k, &other.shape))
            .collect();
        primitive
            .samples
            .iter()
            .map(|(s, _)| {
                let mut found = [NONE; OCCLUDERS];
                let hiding = near.iter().filter(|(_, o)| o.contains(&s.outside)).map(|(k, _)| *k);
                for (place, k) in found.iter_mut().zip(hiding) {
                    *place = k;
                }
                found
            })
            .collect()
    }

    /// What the visible surface of primitive `j` and free space inside it add.
    pub(crate) fn surface_cost(&self, j: usize) -> f64 {
        self.surface_costs[j]
    }

    /// The first two terms of the energy.
    pub(crate) fn error(&self) -> f64 {
        self.point_costs.iter().sum::<f64>() + self.surface_costs.iter().sum::<f64>()
    }

    /// The same with the primitives `added` in the place of those at `removed`.
    pub(crate) fn error_with(&self, model: &Model, removed: &[usize], added: &[PrimitiveTerms]) -> f64 {
        let mut come = vec![f32::INFINITY; self.nearest.len()];
        for primitive in added {
            come.iter_mut().zip(&primitive.distances).for_each(|(least, d)| *least = least.min(*d));
        }
        let mut is_removed = vec![false; self.primitives.len()];
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
                let left = self.primitives.iter().zip(&is_removed).filter(|(_, is_removed)| !**is_removed);
                left.map(|(primitive, _)| primitive.distances[i as usize]).fold(f32::INFINITY, f32::min)
            };
            there += self.point_cost(model, i, come.min(left));
        }
        let mut back = 0.0;
        for (k, primitive) in self.primitives.iter().enumerate() {
            if removed.contains(&k) {
                continue;
            }
            let come: Vec<&Superquadric> =
                added.iter().filter(|a| primitive.may_touch(a)).map(|a| &a.shape).collect();
            let go = removed.iter().any(|&r| primitive.may_touch(&self.primitives[r]));
            back += if come.is_empty() && !go {
                self.surface_costs[k]
            } else {
                self.surface_with(k, removed, &come)
            };
        }
        for (k, primitive) in added.iter().enumerate() {
            let left =
                self.primitives.iter().enumerate().filter(|(j, _)| !removed.contains(j)).map(|(_, p)| p);
            let siblings = added.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, p)| p);
            let near: Vec<&Superquadric> =
                left.chain(siblings).filter(|o| primitive.may_touch(o)).map(|o| &o.shape).collect();
            back += primitive
                .samples
                .iter()
                .filter(|(s, cost)| *cost > 0.0 && !near.iter().any(|o| o.contains(&s.outside)))
                .map(|(_, cost)| cost)
                .sum::<f64>();
            back += primitive.intrusion;
        }
        there + back
    }

    fn surface_with(&self, k: usize, removed: &[usize], added: &[&Superquadric]) -> f64 {
        let primitive = &self.primitives[k];
        let still_hidden = |s: &SurfaceSample, occluders: &[u32; OCCLUDERS]| {
            let known = occluders.iter().take_while(|h| **h != NONE);
            if known.clone().any(|&h| !removed.contains(&(h as usize))) {
                return true;
            }
            // All occluders that are known have gone; there may be more.
            occluders[OCCLUDERS - 1] != NONE
                && self.primitives.iter().enumerate().any(|(j, o)| {
                    j != k && !removed.contains(&j) && primitive.may_touch(o) && o.shape.contains(&s.outside)
                })
        };
        primitive
            .samples
            .iter()
            .zip(&self.occluders[k])
            .filter(|((s, cost), occluders)| {
                *cost > 0.0 && !still_hidden(s, occluders) && !added.iter().any(|o| o.contains(&s.outside))
            })
            .map(|((_, cost), _)| cost)
            .sum::<f64>()
            + primitive.intrusion
    }
}
