//! What a person can turn: one struct for the sliders, the command line and
//! the report.

use super::method::Algorithm;
use crate::geometry::kernel::Distance;
use serde::{Deserialize, Serialize};

/// Parameters of the inference. By default α, p₀, T and K have the paper's
/// values, whereas merging, the distance of the fits, freezing and refining are
/// the program's own: [`Params::paper`] has the paper's there, too.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// What the run computes with; the other parameters say how, as far as it
    /// reads them ([`Params::reads`]).
    pub algorithm: Algorithm,
    /// Concentration α of the Chinese Restaurant Process: the larger, the more
    /// primitives are expected a priori.
    pub alpha: f64,
    /// Density p₀ that a new primitive gives to any point, per unit of the
    /// normalised cloud.
    pub p0: f64,
    /// Number of Gibbs iterations T.
    pub iterations: u32,
    /// Number of clusters K at the start.
    pub clusters: u32,
    /// Seed of every random draw.
    pub seed: u64,
    /// Which clusters are merged, and by which test.
    pub merge: MergeRule,
    /// What one primitive costs in the energy (two-way error and cost of
    /// primitives), as a multiple of the default: the larger, the fewer
    /// primitives and the larger their error.
    pub primitive_cost: f64,
    /// What a fit minimises: the paper's radial distance, or its first-order
    /// correction to the Euclidean one, which does not blow up on thin plates
    /// and long rods.
    pub fit_distance: Distance,
    /// Freeze the points of well fitted clusters (a speed-up of the authors'
    /// program that also locks mistakes in).
    pub freeze: bool,
    /// After the last iteration, refine by descent on the energy: assign every
    /// point that is no outlier, refit in both directions, cut, merge and remove
    /// until nothing lowers it.
    pub refine: bool,
    /// Probability w₀ that EMS gives a point, before it has seen it, of being an
    /// outlier.
    pub outlier_prior: f64,
}

/// The test by which two clusters become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
pub enum MergeRule {
    /// No merging.
    None,
    /// The thresholds of the authors' program, largest cluster first.
    Paper,
    /// The pair that lowers the energy most, first: two-way error and cost of
    /// primitives.
    #[default]
    Energy,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            algorithm: Algorithm::Sampler,
            alpha: 0.5,
            p0: 0.1,
            iterations: 30,
            clusters: 30,
            seed: 1,
            merge: MergeRule::Energy,
            primitive_cost: 1.0,
            fit_distance: Distance::FirstOrder,
            freeze: false,
            refine: true,
            outlier_prior: 0.5,
        }
    }
}

impl Params {
    /// Limits of each parameter, as sliders and the command line offer them.
    pub const ALPHA: (f64, f64) = (1e-3, 100.0);
    pub const P0: (f64, f64) = (1e-6, 10.0);
    pub const ITERATIONS: (u32, u32) = (1, 500);
    pub const CLUSTERS: (u32, u32) = (1, 500);
    pub const PRIMITIVE_COST: (f64, f64) = (0.1, 10.0);
    pub const OUTLIER_PRIOR: (f64, f64) = (0.01, 0.99);

    /// The steps of the paper and the thresholds of its authors' program.
    pub fn paper() -> Self {
        Self {
            merge: MergeRule::Paper,
            fit_distance: Distance::Radial,
            freeze: true,
            refine: false,
            ..Self::default()
        }
    }

    /// Says which parameter is out of its limits, if one is.
    pub fn check(&self) -> Result<(), String> {
        fn within<T: PartialOrd + Copy + Into<f64>>(
            name: &str,
            value: T,
            (low, high): (T, T),
        ) -> Result<(), String> {
            if value >= low && value <= high {
                return Ok(());
            }
            let [value, low, high] = [value, low, high].map(|v| brief(v.into()));
            Err(format!("{name} is {value}, but must lie between {low} and {high}"))
        }
        within("alpha", self.alpha, Self::ALPHA)?;
        within("p0", self.p0, Self::P0)?;
        within("iterations", self.iterations, Self::ITERATIONS)?;
        within("clusters", self.clusters, Self::CLUSTERS)?;
        within("primitive cost", self.primitive_cost, Self::PRIMITIVE_COST)?;
        within("outlier prior", self.outlier_prior, Self::OUTLIER_PRIOR)
    }
}

/// A number as a person would write it: 0.001, 1e300.
fn brief(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() || (1e-4..1e7).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_their_limits_are_told_in_few_digits() {
        for (p0, text) in [(1e300, "1e300"), (-1e-300, "-1e-300"), (f64::NAN, "NaN"), (20.0, "20")] {
            let problem = Params { p0, ..Params::default() }.check().unwrap_err();
            assert_eq!(problem, format!("p0 is {text}, but must lie between 1e-6 and 10"));
        }
    }
}
