//! Separate and split: the two tests, made before each sweep, that let go of
//! points a primitive holds across empty space.

use nalgebra::Point3;
use rayon::prelude::*;

use crate::geometry::neighbors::KdTree;
use crate::geometry::{Superquadric, tessellate};
use crate::inference::control::Cancel;
use crate::inference::data::abstraction::Occurrence;
use crate::inference::data::change::{Change, Draw, Identity, Noise, Successor};
use crate::inference::data::model::Model;
use crate::inference::data::random_streams::{Purpose, stream};
use crate::inference::data::state::State;
use crate::inference::fit::k_means::k_means;
use crate::inference::fit::points::{Effort, fit};
use crate::inference::moves::paper_merge_test::LATE_ITERATION;
use crate::inference::params::{Params, SMALLEST_CLUSTER};

/// The first iteration that separates and splits.
const FIRST_ITERATION: u32 = 5;
/// Mean d² above which a cluster in several primitives is separated, before and
/// from [`LATE_ITERATION`] on.
const SEPARATE: (f64, f64) = (1e-3, 1e-2);
/// Coverage under which a cluster is split.
const SMALLEST_COVERAGE: f64 = 0.7;
/// Mean depth of the free space in a body, in mean spacings a point, above which
/// its cluster is split.
const INTRUDES: f64 = 0.3;
/// A surface sample is covered by a point within this many mean spacings.
const COVER_RADIUS: f64 = 1.1;
/// Surface samples of one coverage test at most.
const COVERAGE_SAMPLES: usize = 2000;

/// The share of the primitive's surface, sampled at the mean spacing, that has
/// one of `members` near by, where the place is known to be empty otherwise. A
/// primitive that bridges empty space has little.
fn coverage(model: &Model, shape: &Superquadric, members: &[u32]) -> f64 {
    let mut samples = tessellate::surface_samples(shape, model.spacing, COVERAGE_SAMPLES);
    if let Some(known) = &model.known {
        let near = |p: &Point3<f64>| model.surface.offset(p).distance < COVER_RADIUS * model.spacing;
        samples.retain(|(p, _)| known.is_free(p) || near(p));
    }
    if samples.is_empty() {
        return 0.0;
    }
    let tree = KdTree::new(&model.gather(members));
    let covered = samples.iter().filter(|s| tree.any_within(&s.0, COVER_RADIUS * model.spacing)).count();
    covered as f64 / samples.len() as f64
}

/// What the tests ask of one cluster.
enum Verdict {
    Keep,
    /// Keep some points and refit; let the others go.
    Reduce {
        successor: Box<Successor>,
        occurrence: Occurrence,
    },
    Remove,
}

/// Separates and splits all clusters that need it. Those that are locked, and
/// those whose points are all frozen, are left alone; pinned points stay.
pub(crate) fn separate_and_split(
    state: &mut State,
    params: &Params,
    cancel: &Cancel,
    occurrences: &mut Vec<Occurrence>,
) {
    if state.iteration < FIRST_ITERATION {
        return;
    }
    let members = state.members();
    let verdicts: Vec<Verdict> = (0..members.len())
        .into_par_iter()
        .map(|j| test_cluster(state, params, j, &members[j], cancel))
        .collect();
    let mut change = Change { keeps_frozen: true, ..Change::default() };
    for (j, verdict) in verdicts.into_iter().enumerate() {
        match verdict {
            Verdict::Keep => {}
            Verdict::Remove => {
                change.removed.push(j);
                occurrences.push(Occurrence::Died { id: state.clusters[j].id });
            }
            Verdict::Reduce { successor, occurrence } => {
                change.removed.push(j);
                change.added.push(*successor);
                occurrences.push(occurrence);
            }
        }
    }
    state.apply(change);
}

fn test_cluster(state: &State, params: &Params, j: usize, members: &[u32], cancel: &Cancel) -> Verdict {
    let model = &state.model;
    let cluster = &state.clusters[j];
    if cluster.locked {
        return Verdict::Keep;
    }
    if members.is_empty() {
        return Verdict::Remove;
    }
    if members.iter().all(|&i| state.frozen[i as usize]) {
        return Verdict::Keep;
    }
    let mut parts = state.components(j as u32, members);
    let several = parts.len() > 1;
    let largest = parts.swap_remove(0);

    let limit = if state.iteration < LATE_ITERATION { SEPARATE.0 } else { SEPARATE.1 };
    let mean_d2 = model.sum_d2(&cluster.shape, members) / members.len() as f64;
    let pinned: Vec<u32> = members.iter().copied().filter(|&i| state.is_pinned(i)).collect();
    let reduce = |mut keep: Vec<u32>, warm: &[Superquadric], occurrence: Occurrence| {
        keep.extend(&pinned);
        keep.sort_unstable();
        keep.dedup();
        let points = model.gather(&keep);
        let Some(found) = fit(&points, warm, model.limits(), Effort::ITERATION, params.fit_distance, cancel)
        else {
            return Verdict::Keep;
        };
        let successor = Successor {
            identity: Identity::Same(j),
            shape: found.shape,
            members: keep,
            noise: Noise::Conditional(Draw::Cluster(params.seed, Purpose::Split), None),
        };
        Verdict::Reduce { successor: Box::new(successor), occurrence }
    };
    if several && mean_d2 > limit {
        if largest.len() <= SMALLEST_CLUSTER {
            return if pinned.is_empty() { Verdict::Remove } else { Verdict::Keep };
        }
        return reduce(largest, &[cluster.shape], Occurrence::Separated { id: cluster.id });
    }
    let mut coverage = coverage(model, &cluster.shape, members);
    // A body that holds free space stands for points that it should not.
    let intrusion = model.known.as_ref().map_or(0.0, |known| known.intrusion(&cluster.shape, |depth| depth));
    if intrusion > INTRUDES * model.spacing * members.len() as f64 {
        coverage = 0.0;
    }
    if coverage < SMALLEST_COVERAGE {
        let mut rng = stream(params.seed, Purpose::Split, state.iteration, u32::MAX - cluster.id);
        let halves = k_means(&model.gather(&largest), 2, &mut rng);
        let ones = halves.iter().filter(|&&h| h == 1).count() as u32;
        let larger = u32::from(2 * ones as usize > halves.len());
        let keep: Vec<u32> = largest.iter().zip(&halves).filter(|h| *h.1 == larger).map(|h| *h.0).collect();
        if keep.len() > SMALLEST_CLUSTER {
            return reduce(keep, &[], Occurrence::Split { id: cluster.id, coverage });
        }
    }
    Verdict::Keep
}
