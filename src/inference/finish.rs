//! What is left to do after the last iteration.

use super::abstraction::UNASSIGNED;
use super::state::State;

/// A point farther than this many mean spacings (or standard deviations of
/// the noise) from every primitive is an outlier and stays unassigned.
const OUTLIER_SPACINGS: f64 = 2.0;
const OUTLIER_SIGMAS: f64 = 4.0;

/// Gives each unassigned point to the nearest primitive (first-order
/// distance), but for outliers.
pub(crate) fn assign_leftovers(state: &mut State) {
    let model = state.model.clone();
    for (p, label) in model.points.iter().zip(&mut state.labels) {
        if *label != UNASSIGNED {
            continue;
        }
        let nearest = (0u32..)
            .zip(&state.clusters)
            .map(|(j, c)| (c.shape.first_order_distance(p), j))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, j)) = nearest {
            let sigma = state.clusters[j as usize].sigma;
            if distance <= (OUTLIER_SPACINGS * model.spacing).max(OUTLIER_SIGMAS * sigma) {
                *label = j;
            }
        }
    }
}
