//! Fitting all primitives again, each next to the others.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};

use rayon::prelude::*;

use crate::geometry::Superquadric;
use crate::inference::data::state::State;
use crate::inference::fit::points::{Effort, boxes_and_plates};
use crate::inference::fit::symmetric::Detail;
use crate::inference::moves::configuration::{Configuration, Version};
use crate::inference::objective::energy::PrimitiveTerms;
use crate::inference::params::SMALLEST_CLUSTER;

/// Steps of a two-way fit in each of the two passes of a round.
const FIT_STEPS: usize = 8;
/// Passes over the final primitives at most, and steps of a fit in each.
const POLISHES: usize = 5;
const POLISH_STEPS: usize = 25;

/// A fit that gains less than this share of the price of a primitive does not
/// make changes worth trying again.
const NOTABLE: f64 = 0.05;
/// The same at the end where one side is seen: the points say little of the
/// other, but that little counts.
const NOTABLE_UNSEEN: f64 = 0.005;

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
pub(crate) struct Refits {
    /// Revisions that have been fitted from their points alone.
    explored: HashSet<u64>,
    /// Fits that came to nothing, by all that they depend on.
    idle: HashSet<u64>,
}

/// All that the fit of a primitive depends on, as one number.
fn circumstances(configuration: &Configuration<'_>, j: usize, way: Way) -> u64 {
    let mut hasher = DefaultHasher::new();
    let mut add = |shape: &Superquadric| {
        shape.numbers().for_each(|v| v.to_bits().hash(&mut hasher));
    };
    add(&configuration.primitives()[j].shape);
    configuration.around(j).for_each(add);
    (way, &configuration.members[j]).hash(&mut hasher);
    hasher.finish()
}

/// Fits every primitive to its points and what is around it, and keeps what
/// lowers the energy. Returns the energy.
pub(crate) fn refit(
    configuration: &mut Configuration<'_>,
    versions: &mut [Version],
    state: &mut State,
    refits: &mut Refits,
) -> f64 {
    let notable = NOTABLE * configuration.price_of_one_more();
    let mut energy = configuration.energy();
    for explore in [true, false] {
        let ways: Vec<Way> = versions
            .iter()
            .map(|name| Way {
                explore: explore && refits.explored.insert(name.revision),
                steps: FIT_STEPS,
                detail: Detail::Rough,
            })
            .collect();
        energy = refit_once(configuration, energy, &ways, refits, |j, gain| {
            if gain > notable {
                versions[j].revision = state.new_revision();
            }
        });
    }
    energy
}

/// Fits the final primitives until they rest.
pub(crate) fn polish(configuration: &mut Configuration<'_>, refits: &mut Refits) {
    let notable = if configuration.model.known.is_some() { NOTABLE_UNSEEN } else { NOTABLE };
    let rest = notable * configuration.price_of_one_more();
    let mut energy = configuration.energy();
    for _ in 0..POLISHES {
        let way = Way { explore: false, steps: POLISH_STEPS, detail: Detail::Full };
        let now = refit_once(
            configuration,
            energy,
            &vec![way; configuration.primitives().len()],
            refits,
            |_, _| {},
        );
        if energy - now < rest {
            break;
        }
        energy = now;
    }
}

/// Fits primitives next to the others, and takes those fits that lower the
/// `energy`, which is returned; `taken` hears of each with its gain.
fn refit_once(
    configuration: &mut Configuration<'_>,
    mut energy: f64,
    ways: &[Way],
    refits: &mut Refits,
    mut taken: impl FnMut(usize, f64),
) -> f64 {
    let keys: Vec<u64> =
        ways.iter().enumerate().map(|(j, way)| circumstances(configuration, j, *way)).collect();
    let fitted: Vec<Option<PrimitiveTerms>> = ways
        .par_iter()
        .enumerate()
        .map(
            |(j, way)| {
                if refits.idle.contains(&keys[j]) { None } else { fitted_again(configuration, j, *way) }
            },
        )
        .collect();
    // Each judged next to those taken before it.
    let (mut old, mut new): (Vec<usize>, Vec<PrimitiveTerms>) = (Vec::new(), Vec::new());
    for (j, primitive) in fitted.into_iter().enumerate() {
        let Some(primitive) = primitive else { continue };
        refits.idle.insert(keys[j]);
        old.push(j);
        new.push(primitive);
        let now = configuration.energy_with(&old, &new);
        if now < energy {
            refits.idle.remove(&keys[j]);
            taken(j, energy - now);
            energy = now;
        } else {
            old.pop();
            new.pop();
        }
    }
    configuration.change_primitives(|primitives| {
        for (j, primitive) in old.into_iter().zip(new) {
            primitives[j] = primitive;
        }
    });
    configuration.assign();
    energy
}

/// A primitive fitted to its points, next to the others.
fn fitted_again(configuration: &Configuration<'_>, j: usize, way: Way) -> Option<PrimitiveTerms> {
    let points = &configuration.members[j];
    if points.is_empty() || configuration.locked[j] {
        return None;
    }
    let mut starts = vec![configuration.primitives()[j].shape];
    if way.explore && points.len() > SMALLEST_CLUSTER {
        starts.extend(configuration.fit_points(points, &[], Effort::THOROUGH));
        if configuration.model.known.is_some() {
            let gathered = configuration.model.gather(points);
            let floor = configuration.model.axis_floor();
            starts.extend(boxes_and_plates(&gathered, &configuration.primitives()[j].shape, floor));
        }
    }
    let shape =
        configuration.fit_symmetric(points, &starts, &configuration.others(&[j]), way.steps, way.detail)?;
    Some(PrimitiveTerms::new(configuration.model, shape))
}
