//! Even samples of the surface of a union of primitives.

use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::body::{Body, RESOLUTION, SurfaceSampler, inside_any};
use super::triangles::running_sum;

/// Rounds of drawing, after which too few samples are accepted: the rest of
/// the surface lies inside other primitives.
const ROUNDS: u32 = 30;
/// Samples that share a random stream.
const CHUNK: usize = 4096;

/// Points of the union's surface.
#[derive(Debug)]
pub(super) struct UnionSurface {
    pub(super) points: Vec<Point3<f64>>,
    /// Share of the surfaces that lies inside other primitives.
    pub(super) buried_share: Option<f64>,
}

/// At least `wanted` points, even by area, in the bodies' frame; a point that,
/// pushed outward by `push`, lies in another body is dropped.
pub(super) fn sample(bodies: &[Body], wanted: usize, push: f64, seed: u64) -> UnionSurface {
    let faces = RESOLUTION.faces();
    let samplers: Vec<SurfaceSampler<'_>> =
        bodies.par_iter().map(|body| SurfaceSampler::new(body, &faces)).collect();
    let area_up_to = running_sum(samplers.iter().map(SurfaceSampler::area));
    let area = area_up_to.last().copied().unwrap_or(0.0);
    let mut points: Vec<Point3<f64>> = Vec::with_capacity(wanted + wanted / 10);
    let mut drawn = 0;
    if !(area > 0.0 && area.is_finite()) {
        return UnionSurface { points, buried_share: None };
    }
    for round in 0..ROUNDS {
        // What is missing, with a margin for the share that is dropped.
        let count = match points.len() {
            0 => wanted,
            kept => {
                let missing = wanted.saturating_sub(kept) as f64;
                let needed = 1.05 * missing * drawn as f64 / kept as f64;
                (needed.max(wanted as f64 / 10.0) as usize).min(4 * wanted)
            }
        };
        let phase = stream(seed, round, 0xffff, 0xffff).random::<f64>();
        let mut tasks = Vec::new();
        let mut before = 0;
        for (j, up_to) in area_up_to.iter().enumerate() {
            let until = if j + 1 == bodies.len() {
                count
            } else {
                ((up_to / area * count as f64 + phase) as usize).min(count)
            };
            let share = until.saturating_sub(before);
            tasks.extend((0..share.div_ceil(CHUNK)).map(|chunk| (j, share, chunk)));
            before = before.max(until);
        }
        let found: Vec<Vec<Point3<f64>>> = tasks
            .into_par_iter()
            .map(|(j, share, chunk)| {
                let mut rng = stream(seed, round, j, chunk);
                let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(share);
                samplers[j]
                    .draw(share, range, &mut rng)
                    .filter(|(p, normal)| !inside_any(bodies, &(p + normal * push), Some(j)))
                    .map(|(p, _)| p)
                    .collect()
            })
            .collect();
        drawn += count;
        points.extend(found.into_iter().flatten());
        if points.len() >= wanted {
            break;
        }
    }
    let buried_share = Some(1.0 - points.len() as f64 / drawn as f64);
    UnionSurface { points, buried_share }
}

/// The random stream of a chunk of one body's samples in one round.
fn stream(seed: u64, round: u32, body: usize, chunk: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from(round) << 56 | (body as u64 & 0xff_ffff) << 32 | chunk as u64);
    rng
}
