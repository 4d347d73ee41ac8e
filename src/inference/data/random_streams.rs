//! Random streams: one for each step and cluster, addressed by counters, so
//! that a draw depends on the seed and on what it is for, never on what other
//! threads drew before it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What a stream is for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    KMeans = 1,
    StartSigma,
    Sweep,
    Birth,
    Sigma,
    Split,
    Merge,
    Cut,
    Refined,
    Edit,
}

/// The random stream of one purpose at one iteration (and for one cluster,
/// where `id` is its id).
pub(crate) fn stream(seed: u64, purpose: Purpose, iteration: u32, id: u32) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // Purpose in the top 8 bits, iteration in the next 24, id below: distinct
    // for every use that can occur (T is bounded well below 2²⁴).
    rng.set_stream((purpose as u64) << 56 | (u64::from(iteration) & 0xff_ffff) << 32 | u64::from(id));
    rng
}
