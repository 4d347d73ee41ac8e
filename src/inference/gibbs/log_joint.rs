//! The log of the joint density of labels and points.

/// ln p(z, x | θ, σ) of a state, in nats (see
/// [`Figures::log_joint`](crate::inference::data::abstraction::Figures::log_joint)).
/// `tables` gives for each cluster its number of points n, Σ d² over them, and
/// σ; `waiting` is the number of points without one.
pub(crate) fn log_joint(alpha: f64, p0: f64, tables: &[(usize, f64, f64)], waiting: usize) -> f64 {
    let waiting = waiting as f64;
    let guests = tables.iter().map(|t| t.0 as f64).sum::<f64>() + waiting;
    let seated = |&(n, sum_d2, sigma): &(usize, f64, f64)| {
        let n = n as f64;
        let half_normal = (0.5 / (sigma * (2.0 * std::f64::consts::PI).sqrt())).ln();
        alpha.ln() + libm::lgamma(n) + n * half_normal - sum_d2 / (2.0 * sigma * sigma)
    };
    let tables: f64 = tables.iter().filter(|t| t.0 > 0).map(seated).sum();
    tables + libm::lgamma(alpha + waiting) + waiting * p0.ln() - libm::lgamma(alpha + guests)
}
