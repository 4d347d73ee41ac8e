//! Fitting all primitives again, each next to the others.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};

use rayon::prelude::*;

use super::super::energy::Piece;
use super::super::fit::Effort;
use super::super::state::{SMALLEST_CLUSTER, State};
use super::super::two_way::Detail;
use super::{Layout, NOTABLE, Name};
use crate::geometry::Superquadric;

/// Steps of a two-way fit in each of the two passes of a round.
const FIT_STEPS: usize = 8;
/// Passes over the final primitives at most, and steps of a fit in each.
const POLISHES: usize = 5;
const POLISH_STEPS: usize = 25;

/// How a primitive is fitted again.
#[derive(Debug, Clone, Copy, Hash)]
struct Way {
    /// Start anew from the points, too.
    explore: bool,
    steps: usize,
    detail: Detail,
}

/// What need not be done again.
#[derive(Debug, Default)]
pub(super) struct Refits {
    /// Revisions that have been fitted from their points alone.
    explored: HashSet<u64>,
    /// Fits that came to nothing, by all that they depend on.
    idle: HashSet<u64>,
}

/// All that the fit of a primitive depends on, as one number.
fn circumstances(layout: &Layout<'_>, j: usize, way: Way) -> u64 {
    let mut hasher = DefaultHasher::new();
    let mut add = |shape: &Superquadric| {
        let pose = shape.rotation.matrix().iter().chain(&shape.translation);
        let rest = shape.semi_axes.iter().chain(&shape.exponents).chain(&shape.taper);
        pose.chain(rest).for_each(|v| v.to_bits().hash(&mut hasher));
    };
    add(&layout.pieces()[j].shape);
    layout.around(j).for_each(add);
    (way, &layout.members[j]).hash(&mut hasher);
    hasher.finish()
}

/// Fits every primitive to its points and what is around it, and keeps what
/// lowers the energy. Returns the energy.
pub(super) fn refit(
    layout: &mut Layout<'_>,
    names: &mut [Name],
    state: &mut State,
    refits: &mut Refits,
) -> f64 {
    let notable = NOTABLE * layout.price_of_one_more();
    let mut energy = layout.energy();
    for explore in [true, false] {
        let ways: Vec<Way> = names
            .iter()
            .map(|name| Way {
                explore: explore && refits.explored.insert(name.revision),
                steps: FIT_STEPS,
                detail: Detail::Rough,
            })
            .collect();
        energy = refit_once(layout, energy, &ways, refits, |j, gain| {
            if gain > notable {
                names[j].revision = state.new_revision();
            }
        });
    }
    energy
}

/// Fits the final primitives until they rest.
pub(super) fn polish(layout: &mut Layout<'_>, refits: &mut Refits) {
    let rest = NOTABLE * layout.price_of_one_more();
    let mut energy = layout.energy();
    for _ in 0..POLISHES {
        let way = Way { explore: false, steps: POLISH_STEPS, detail: Detail::Full };
        let now = refit_once(layout, energy, &vec![way; layout.pieces().len()], refits, |_, _| {});
        if energy - now < rest {
            break;
        }
        energy = now;
    }
}

/// Fits primitives next to the others, and takes those fits that lower the
/// `energy`, which is returned; `taken` hears of each with its gain.
fn refit_once(
    layout: &mut Layout<'_>,
    mut energy: f64,
    ways: &[Way],
    refits: &mut Refits,
    mut taken: impl FnMut(usize, f64),
) -> f64 {
    let keys: Vec<u64> = ways.iter().enumerate().map(|(j, way)| circumstances(layout, j, *way)).collect();
    let fitted: Vec<Option<Piece>> = ways
        .par_iter()
        .enumerate()
        .map(|(j, way)| if refits.idle.contains(&keys[j]) { None } else { fitted_again(layout, j, *way) })
        .collect();
    // Each judged next to those taken before it.
    let (mut old, mut new): (Vec<usize>, Vec<Piece>) = (Vec::new(), Vec::new());
    for (j, piece) in fitted.into_iter().enumerate() {
        let Some(piece) = piece else { continue };
        refits.idle.insert(keys[j]);
        old.push(j);
        new.push(piece);
        let now = layout.energy_with(&old, &new);
        if now < energy {
            refits.idle.remove(&keys[j]);
            taken(j, energy - now);
            energy = now;
        } else {
            old.pop();
            new.pop();
        }
    }
    layout.change_pieces(|pieces| {
        for (j, piece) in old.into_iter().zip(new) {
            pieces[j] = piece;
        }
    });
    layout.assign();
    energy
}

/// A primitive fitted to its points, next to the others.
fn fitted_again(layout: &Layout<'_>, j: usize, way: Way) -> Option<Piece> {
    let points = &layout.members[j];
    if points.is_empty() || layout.locked[j] {
        return None;
    }
    let mut starts = vec![layout.pieces()[j].shape];
    if way.explore && points.len() > SMALLEST_CLUSTER {
        starts.extend(layout.one_way(points, &[], Effort::THOROUGH));
    }
    let shape = layout.two_way(points, &starts, &layout.others(&[j]), way.steps, way.detail)?;
    Some(Piece::new(layout.model, shape))
}
