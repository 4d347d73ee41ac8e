//! The table of a run's parameters. The command line, the columns of manifests
//! and sweeps, the sliders and the checks read it; a further parameter is a
//! field of [`Params`] and a row here.

use crate::inference::params::{Algorithm, MergeRule, Params, SeenFrom};

/// A parameter by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    Alpha,
    P0,
    Iterations,
    Clusters,
    PrimitiveCost,
    OutlierPrior,
    Seed,
    Merge,
    SeenFrom,
    FitDistance,
    Freeze,
    Refine,
}

/// A row of the table.
#[derive(Debug)]
pub struct Parameter {
    pub setting: Setting,
    /// Of the option and the column, for instance `primitive-cost`.
    pub name: &'static str,
    /// In the usage of the option, for instance `ALPHA`.
    pub symbol: &'static str,
    /// In the window.
    pub label: &'static str,
    /// What it is, in a line for the command line.
    pub help: &'static str,
    /// What it does, in sentences.
    pub tooltip: &'static str,
    pub taken: Taken,
    /// The algorithms that read it.
    pub readers: &'static [Algorithm],
    /// Where it is a number: its field and its range, ends included.
    pub number: Option<Number>,
    copy: fn(&mut Params, &Params),
}

/// The field and the range of a number.
#[derive(Debug, Clone, Copy)]
pub enum Number {
    Real(fn(&mut Params) -> &mut f64, (f64, f64)),
    Count(fn(&mut Params) -> &mut u32, (u32, u32)),
}

/// When a run takes a parameter that has been changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken {
    Iteration,
    Step,
    Fit,
    Merge,
    Start,
}

const ALL: &[Algorithm] =
    &[Algorithm::Sampler, Algorithm::KMeans, Algorithm::Ems, Algorithm::HierarchicalEms];
const SAMPLER: &[Algorithm] = &[Algorithm::Sampler];

/// All parameters, in the order of [`Setting`].
pub const PARAMETERS: [Parameter; 12] = [
    Parameter {
        setting: Setting::Alpha,
        name: "alpha",
        symbol: "ALPHA",
        label: "Concentration α",
        help: "Concentration α: the larger, the more primitives",
        tooltip: "Concentration α of the Chinese Restaurant Process. Larger values expect more \
             primitives a priori.",
        taken: Taken::Iteration,
        readers: SAMPLER,
        number: Some(Number::Real(|p| &mut p.alpha, (1e-3, 100.0))),
        copy: |to, from| to.alpha = from.alpha,
    },
    Parameter {
        setting: Setting::P0,
        name: "p0",
        symbol: "P0",
        label: "New cluster p0",
        help: "Density p0 that a new primitive gives to any point",
        tooltip: "Density p0 that a new primitive assigns to any point. The larger it is, the \
             closer a point must be to a primitive to stay with it.",
        taken: Taken::Iteration,
        readers: SAMPLER,
        number: Some(Number::Real(|p| &mut p.p0, (1e-6, 10.0))),
        copy: |to, from| to.p0 = from.p0,
    },
    Parameter {
        setting: Setting::Iterations,
        name: "iterations",
        symbol: "T",
        label: "Iterations T",
        help: "Number of Gibbs iterations T",
        tooltip: "Number of Gibbs iterations T per run.",
        taken: Taken::Iteration,
        readers: SAMPLER,
        number: Some(Number::Count(|p| &mut p.iterations, (1, 500))),
        copy: |to, from| to.iterations = from.iterations,
    },
    Parameter {
        setting: Setting::Clusters,
        name: "clusters",
        symbol: "K",
        label: "Clusters K",
        help: "Number of clusters K at the start",
        tooltip: "Number of k-means clusters K at the start of a run.",
        taken: Taken::Start,
        readers: &[Algorithm::Sampler, Algorithm::KMeans],
        number: Some(Number::Count(|p| &mut p.clusters, (1, 500))),
        copy: |to, from| to.clusters = from.clusters,
    },
    Parameter {
        setting: Setting::PrimitiveCost,
        name: "primitive-cost",
        symbol: "C",
        label: "Cost of a primitive",
        help: "Cost of a primitive: more gives fewer primitives with larger errors",
        tooltip: "How much error a primitive must save to be kept, as a multiple of the default. \
             Larger values give fewer primitives with larger errors.",
        taken: Taken::Merge,
        readers: SAMPLER,
        number: Some(Number::Real(|p| &mut p.primitive_cost, (0.1, 10.0))),
        copy: |to, from| to.primitive_cost = from.primitive_cost,
    },
    Parameter {
        setting: Setting::OutlierPrior,
        name: "outlier-prior",
        symbol: "W0",
        label: "Outlier prior w0",
        help: "Share of outliers that EMS expects",
        tooltip: "Share of outliers w0 that EMS expects a priori. The larger it is, the closer a \
             point must be to the primitive to belong to it.",
        taken: Taken::Step,
        readers: &[Algorithm::Ems, Algorithm::HierarchicalEms],
        number: Some(Number::Real(|p| &mut p.outlier_prior, (0.01, 0.99))),
        copy: |to, from| to.outlier_prior = from.outlier_prior,
    },
    Parameter {
        setting: Setting::Seed,
        name: "seed",
        symbol: "S",
        label: "Seed",
        help: "Seed of all random draws",
        tooltip: "Seed of all random draws. The same seed gives the same result.",
        taken: Taken::Start,
        readers: &[Algorithm::Sampler, Algorithm::KMeans, Algorithm::HierarchicalEms],
        number: None,
        copy: |to, from| to.seed = from.seed,
    },
    Parameter {
        setting: Setting::Merge,
        name: "merge",
        symbol: "RULE",
        label: "Merging",
        help: "The test by which two primitives become one",
        tooltip: "How pairs of primitives are chosen for merging.",
        taken: Taken::Merge,
        readers: SAMPLER,
        number: None,
        copy: |to, from| to.merge = from.merge,
    },
    Parameter {
        setting: Setting::SeenFrom,
        name: "seen-from",
        symbol: "SIDES",
        label: "Seen from",
        help: "Whether the shape was seen from all sides or from one",
        tooltip: "Where nobody looked there may be surface without points. From one side, only places \
             that were seen to be empty count as empty.",
        taken: Taken::Start,
        readers: SAMPLER,
        number: None,
        copy: |to, from| to.seen_from = from.seen_from,
    },
    Parameter {
        setting: Setting::FitDistance,
        name: "fit-distance",
        symbol: "DISTANCE",
        label: "Fit distance",
        help: "What the fit of a primitive minimises",
        tooltip: "Distance that a fit minimises.",
        taken: Taken::Fit,
        readers: ALL,
        number: None,
        copy: |to, from| to.fit_distance = from.fit_distance,
    },
    Parameter {
        setting: Setting::Freeze,
        name: "freeze",
        symbol: "BOOL",
        label: "Freeze good fits",
        help: "Freeze the points of well fitted primitives",
        tooltip: "Points of well-fitted primitives keep their label in later sweeps. Faster, as in the paper, \
             but mistakes are also kept",
        taken: Taken::Iteration,
        readers: SAMPLER,
        number: None,
        copy: |to, from| to.freeze = from.freeze,
    },
    Parameter {
        setting: Setting::Refine,
        name: "refine",
        symbol: "BOOL",
        label: "Refine at the end",
        help: "Refine by descent on the energy after the last iteration",
        tooltip: "After the last iteration, reassign, refit, cut, merge and remove for as long as that lowers \
             the energy: two-way error plus cost of primitives",
        taken: Taken::Start,
        readers: SAMPLER,
        number: None,
        copy: |to, from| to.refine = from.refine,
    },
];

impl Setting {
    /// Its row of the table.
    pub fn parameter(self) -> &'static Parameter {
        const TABLE: &[Parameter; 12] = &PARAMETERS;
        &TABLE[self as usize]
    }

    /// Smallest and largest value of a number; everything where it is none.
    pub fn range(self) -> (f64, f64) {
        match self.parameter().number {
            Some(Number::Real(_, range)) => range,
            Some(Number::Count(_, (low, high))) => (f64::from(low), f64::from(high)),
            None => (f64::NEG_INFINITY, f64::INFINITY),
        }
    }

    /// The largest value of a number that counts.
    pub fn most(self) -> u32 {
        self.range().1 as u32
    }
}

impl Parameter {
    /// The number in `params`, where it is one.
    pub fn value(&self, params: &Params) -> Option<f64> {
        let mut params = *params;
        match self.number? {
            Number::Real(field, _) => Some(*field(&mut params)),
            Number::Count(field, _) => Some(f64::from(*field(&mut params))),
        }
    }

    /// Sets the number, which is whole where it counts.
    pub fn set(&self, params: &mut Params, value: f64) {
        match self.number {
            Some(Number::Real(field, _)) => *field(params) = value,
            Some(Number::Count(field, _)) => *field(params) = value as u32,
            None => {}
        }
    }

    /// In words: `primitive cost`.
    pub fn spoken(&self) -> String {
        self.name.replace('-', " ")
    }
}

impl Params {
    /// Whether a run with these parameters looks at `setting`.
    pub fn reads(&self, setting: Setting) -> bool {
        let has_energy = self.merge == MergeRule::Energy || self.refine;
        setting.parameter().readers.contains(&self.algorithm)
            && (!matches!(setting, Setting::PrimitiveCost | Setting::SeenFrom) || has_energy)
    }

    /// Whence a run takes the cloud to have been seen: only the energy can tell
    /// what is unknown.
    pub(crate) fn sight(&self) -> SeenFrom {
        if self.reads(Setting::SeenFrom) { self.seen_from } else { SeenFrom::All }
    }

    /// Why a run with these parameters doesn't look at `setting`; `None` where
    /// it does.
    pub fn why_unread(&self, setting: Setting) -> Option<String> {
        (!self.reads(setting)).then(|| match (self.algorithm, setting) {
            (Algorithm::Sampler, Setting::OutlierPrior) => {
                "The sampler does not use this; EMS and hierarchical EMS do".to_owned()
            }
            (Algorithm::Sampler, _) => "Only merging by energy and the final refinement use this".to_owned(),
            (other, _) => format!("{} does not use this", other.title()),
        })
    }

    /// The parameters with those of `other` that this run doesn't look at.
    pub fn with_unread_of(&self, other: &Self) -> Self {
        let mut read = *self;
        for parameter in PARAMETERS.iter().filter(|p| !self.reads(p.setting)) {
            (parameter.copy)(&mut read, other);
        }
        read
    }

    /// The parameters with the numbers, the seed and the viewpoints of `other`.
    pub fn tuned_as(&self, other: &Self) -> Self {
        let mut tuned = *self;
        let is_tuned =
            |p: &&Parameter| p.number.is_some() || matches!(p.setting, Setting::Seed | Setting::SeenFrom);
        for parameter in PARAMETERS.iter().filter(is_tuned) {
            (parameter.copy)(&mut tuned, other);
        }
        tuned
    }

    /// Says which parameter is out of its limits, if one is.
    ///
    /// # Errors
    /// The first that is.
    pub fn check(&self) -> Result<(), String> {
        for parameter in &PARAMETERS {
            let (low, high) = parameter.setting.range();
            let Some(value) = parameter.value(self) else { continue };
            if !(value >= low && value <= high) {
                let [value, low, high] = [value, low, high].map(brief);
                return Err(format!(
                    "{} is {value}, but must be between {low} and {high}",
                    parameter.spoken()
                ));
            }
        }
        Ok(())
    }
}

/// A number as a person would write it: 0.001, 1e300.
pub(crate) fn brief(value: f64) -> String {
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
    fn the_table_is_in_the_order_of_the_settings_and_names_each_once() {
        let mut names = std::collections::BTreeSet::new();
        for (at, parameter) in PARAMETERS.iter().enumerate() {
            assert_eq!(parameter.setting as usize, at, "{}", parameter.name);
            assert!(names.insert(parameter.name), "{}", parameter.name);
            // The row's field is the one of its name.
            let mut params = Params::default();
            if let Some(value) = parameter.value(&params) {
                let other = if value == 2.0 { 1.0 } else { 2.0 };
                parameter.set(&mut params, other);
                let json = serde_json::to_value(params).unwrap();
                assert_eq!(
                    json[parameter.name.replace('-', "_")].as_f64(),
                    Some(other),
                    "{}",
                    parameter.name
                );
                let mut copied = Params::default();
                (parameter.copy)(&mut copied, &params);
                assert_eq!(copied, params);
            }
        }
        // Every field of the parameters has a row; the algorithm is what reads them.
        let json = serde_json::to_value(Params::default()).unwrap();
        for key in json.as_object().unwrap().keys().filter(|key| *key != "algorithm") {
            assert!(names.contains(key.replace('_', "-").as_str()), "{key}");
        }
    }

    #[test]
    fn numbers_out_of_their_limits_are_told_in_few_digits() {
        for (p0, text) in [(1e300, "1e300"), (-1e-300, "-1e-300"), (f64::NAN, "NaN"), (20.0, "20")] {
            let problem = Params { p0, ..Params::default() }.check().unwrap_err();
            assert_eq!(problem, format!("p0 is {text}, but must be between 1e-6 and 10"));
        }
    }
}
