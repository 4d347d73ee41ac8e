//! The Chinese Restaurant Process that the sampler draws its tables from.

/// The number of tables that a Chinese restaurant of n guests has on average:
/// Σ α/(α + i), i = 0 … n − 1, which is α·(ψ(α + n) − ψ(α)).
pub fn expected_tables(alpha: f64, n: usize) -> f64 {
    if n <= SHORT_SUM {
        return (0..n).map(|i| alpha / (alpha + i as f64)).sum();
    }
    alpha * (digamma(alpha + n as f64) - digamma(alpha))
}

/// Sums of so many terms are no work.
const SHORT_SUM: usize = 64;

/// ψ(x), x > 0, by its recurrence and its asymptotic series.
fn digamma(mut x: f64) -> f64 {
    let mut shifted = 0.0;
    while x < 10.0 {
        shifted -= 1.0 / x;
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = y * (1.0 / 12.0 - y * (1.0 / 120.0 - y * (1.0 / 252.0 - y * (1.0 / 240.0 - y / 132.0))));
    shifted + x.ln() - 0.5 / x - series
}
