//! Settings of a run, shared by `run`, `bench` and the window.

use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use crate::geometry::{Isolated, SamplingOptions, Surface};
use crate::inference::{MergeRule, Method, Params, Setting};

/// A method, what it is tuned with, and what of a shape it is given.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Settings")]
pub(super) struct SettingsArgs {
    /// Method of abstraction
    #[arg(long, visible_alias = "preset", value_name = "NAME", value_parser = methods(), default_value = "default")]
    method: Method,
    #[command(flatten)]
    pub(super) tuning: TuningArgs,
    /// Part of a mesh to sample
    #[arg(long, value_enum, default_value_t = SurfaceChoice::Outside)]
    surface: SurfaceChoice,
    /// How to treat isolated points of a cloud
    #[arg(long, value_enum, default_value_t = IsolatedChoice::LeaveOut)]
    isolated: IsolatedChoice,
    /// Seed of all random draws; the same seed gives the same result [default: 1]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = whole::<u64>)]
    seed: Option<u64>,
}

/// The numbers that methods are tuned with, as far as they read them.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct TuningArgs {
    /// Number of samples N, from 100 to 200000 [default: 5500]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(super) points: Option<usize>,
    /// Concentration α; larger values give more primitives; from 0.001 to 100
    /// [default: 0.5]
    #[arg(long, value_name = "ALPHA", allow_negative_numbers = true)]
    pub(super) alpha: Option<f64>,
    /// Density p0 that a new primitive assigns to any point, from 1e-6 to 10
    /// [default: 0.1]
    #[arg(long, value_name = "P0", allow_negative_numbers = true)]
    pub(super) p0: Option<f64>,
    /// Number of Gibbs iterations T, from 1 to 500 [default: 30]
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = whole::<u32>)]
    pub(super) iterations: Option<u32>,
    /// Number of clusters K at the start, from 1 to 500 [default: 30]
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = whole::<u32>)]
    pub(super) clusters: Option<u32>,
    /// Cost of a primitive; larger values give fewer primitives with larger errors; from 0.1 to 10
    /// [default: 1]
    #[arg(long, value_name = "C", allow_negative_numbers = true)]
    pub(super) primitive_cost: Option<f64>,
    /// Share of outliers that EMS expects, from 0.01 to 0.99 [default: 0.5; 0.9 for
    /// hierarchical-ems]
    #[arg(long, value_name = "W0", allow_negative_numbers = true)]
    pub(super) outlier_prior: Option<f64>,
    /// Do not merge primitives
    #[arg(long)]
    pub(super) no_merge: bool,
}

/// The methods, with what they do.
pub(super) fn methods() -> impl TypedValueParser<Value = Method> {
    let values = Method::ALL.map(|method| PossibleValue::new(method.name()).help(method.tooltip()));
    PossibleValuesParser::new(values).try_map(|name| name.parse::<Method>())
}

/// A number that counts something.
fn whole<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "expected a non-negative whole number".to_owned())
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SurfaceChoice {
    /// Only what is visible from outside: no inner walls, no hidden parts
    Outside,
    /// Every face
    All,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum IsolatedChoice {
    /// Treat them as outliers without a primitive
    LeaveOut,
    /// Treat them like all other points
    Keep,
}

impl TuningArgs {
    /// The usual sampling, with the number of samples that was asked for.
    pub(super) fn sampling(&self) -> Result<SamplingOptions, String> {
        let usual = SamplingOptions::default();
        let sampling = SamplingOptions { points: self.points.unwrap_or(usual.points), ..usual };
        sampling.check().map(|()| sampling).map_err(|e| e.to_string())
    }

    /// The method's parameters, with the changes that it reads.
    pub(super) fn params(&self, method: Method) -> Result<Params, String> {
        let mut params = method.params();
        if self.no_merge && params.reads(Setting::Merge) {
            params.merge = MergeRule::None;
        }
        fn change<T: Copy>(value: &mut T, reads: bool, given: Option<T>) {
            *value = given.filter(|_| reads).unwrap_or(*value);
        }
        let of = params;
        change(&mut params.alpha, of.reads(Setting::Alpha), self.alpha);
        change(&mut params.p0, of.reads(Setting::P0), self.p0);
        change(&mut params.iterations, of.reads(Setting::Iterations), self.iterations);
        change(&mut params.clusters, of.reads(Setting::Clusters), self.clusters);
        change(&mut params.primitive_cost, of.reads(Setting::PrimitiveCost), self.primitive_cost);
        change(&mut params.outlier_prior, of.reads(Setting::OutlierPrior), self.outlier_prior);
        params.check().map(|()| params)
    }

    /// The first option that was given although none of the parameters reads
    /// it.
    pub(super) fn unread(&self, params: &[Params]) -> Option<&'static str> {
        [
            (self.alpha.is_some(), "--alpha", Setting::Alpha),
            (self.p0.is_some(), "--p0", Setting::P0),
            (self.iterations.is_some(), "--iterations", Setting::Iterations),
            (self.clusters.is_some(), "--clusters", Setting::Clusters),
            (self.primitive_cost.is_some(), "--primitive-cost", Setting::PrimitiveCost),
            (self.outlier_prior.is_some(), "--outlier-prior", Setting::OutlierPrior),
            (self.no_merge, "--no-merge", Setting::Merge),
        ]
        .into_iter()
        .find(|&(given, _, setting)| given && !params.iter().any(|p| p.reads(setting)))
        .map(|(_, option, _)| option)
    }
}

/// The settings that a manifest's columns and `--sweep` change, by the names of
/// their options, with what a method must read for them to make sense.
pub(super) const KEYS: [(&str, Option<Setting>); 12] = [
    ("method", None),
    ("points", None),
    ("alpha", Some(Setting::Alpha)),
    ("p0", Some(Setting::P0)),
    ("iterations", Some(Setting::Iterations)),
    ("clusters", Some(Setting::Clusters)),
    ("primitive-cost", Some(Setting::PrimitiveCost)),
    ("outlier-prior", Some(Setting::OutlierPrior)),
    ("no-merge", Some(Setting::Merge)),
    ("surface", None),
    ("isolated", None),
    ("seed", None),
];

/// The name in [`KEYS`] that a person means: `--primitive-cost`,
/// `primitive_cost` and `Primitive-Cost` are the same.
pub(super) fn key(text: &str) -> Option<&'static str> {
    let text = text.trim().trim_start_matches("--").replace('_', "-").to_lowercase();
    let text = if text == "preset" { "method" } else { &text };
    KEYS.iter().map(|(name, _)| *name).find(|name| *name == text)
}

/// What is wrong with a setting of one job among many.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BadSetting {
    /// Which of those that were given, by its place.
    pub(super) at: usize,
    pub(super) problem: String,
}

impl SettingsArgs {
    /// The settings, within their limits.
    pub(super) fn resolve(&self) -> Result<(SamplingOptions, Params), String> {
        let (sampling, params) = self.applied()?;
        if let Some(option) = self.tuning.unread(&[params]) {
            return Err(format!("--method {} does not use {option}; remove it", self.method));
        }
        Ok((sampling, params))
    }

    /// The settings, within their limits; what the method does not read is
    /// left aside.
    pub(super) fn applied(&self) -> Result<(SamplingOptions, Params), String> {
        let mut params = self.tuning.params(self.method)?;
        let mut sampling = SamplingOptions {
            surface: match self.surface {
                SurfaceChoice::Outside => Surface::Outside,
                SurfaceChoice::All => Surface::All,
            },
            isolated: match self.isolated {
                IsolatedChoice::LeaveOut => Isolated::LeaveOut,
                IsolatedChoice::Keep => Isolated::Keep,
            },
            ..self.tuning.sampling()?
        };
        if let Some(seed) = self.seed {
            (sampling.seed, params.seed) = (seed, seed);
        }
        Ok((sampling, params))
    }

    /// The settings with some changes, each a name of [`KEYS`] and a value as
    /// text. Other than those of the command line, changes must be read by the
    /// method.
    pub(super) fn changed(
        &self,
        changes: &[(&'static str, &str)],
    ) -> Result<(SamplingOptions, Params), BadSetting> {
        let mut settings = self.clone();
        // Which of the others can be told only once the method is known.
        let (first, then): (Vec<usize>, Vec<usize>) =
            (0..changes.len()).partition(|&at| changes[at].0 == "method");
        for &at in first.iter().chain(&then) {
            let (key, value) = changes[at];
            settings
                .set(key, value)
                .and_then(|()| settings.applied().map(drop))
                .map_err(|problem| BadSetting { at, problem })?;
        }
        let resolved = settings.applied().map_err(|problem| BadSetting { at: 0, problem })?;
        for at in then {
            let key = changes[at].0;
            let setting = KEYS.iter().find(|(name, _)| *name == key).and_then(|(_, setting)| *setting);
            if setting.is_some_and(|setting| !resolved.1.reads(setting)) {
                let problem = format!("the method {} does not use {key}; remove it", settings.method);
                return Err(BadSetting { at, problem });
            }
        }
        Ok(resolved)
    }

    /// Takes one setting from text.
    fn set(&mut self, key: &str, text: &str) -> Result<(), String> {
        fn number<T: FromStr>(text: &str, kind: &str) -> Result<Option<T>, String> {
            text.parse().map(Some).map_err(|_| format!("“{text}” is not {kind}"))
        }
        fn choice<T: ValueEnum>(text: &str) -> Result<T, String> {
            T::from_str(text, true).map_err(|_| {
                let all: Vec<PossibleValue> =
                    T::value_variants().iter().filter_map(ValueEnum::to_possible_value).collect();
                let names: Vec<&str> = all.iter().map(PossibleValue::get_name).collect();
                format!("“{text}” is not one of {}", names.join(", "))
            })
        }
        const WHOLE: &str = "a non-negative whole number";
        let tuning = &mut self.tuning;
        match key {
            "method" => {
                self.method = text.parse().map_err(|_| {
                    format!("“{text}” is not one of {}", Method::ALL.map(Method::name).join(", "))
                })?;
            }
            "points" => tuning.points = number(text, WHOLE)?,
            "alpha" => tuning.alpha = number(text, "a number")?,
            "p0" => tuning.p0 = number(text, "a number")?,
            "iterations" => tuning.iterations = number(text, WHOLE)?,
            "clusters" => tuning.clusters = number(text, WHOLE)?,
            "primitive-cost" => tuning.primitive_cost = number(text, "a number")?,
            "outlier-prior" => tuning.outlier_prior = number(text, "a number")?,
            "no-merge" => {
                tuning.no_merge = match text.to_lowercase().as_str() {
                    "true" | "yes" | "1" => true,
                    "false" | "no" | "0" => false,
                    _ => return Err(format!("“{text}” is neither true nor false")),
                }
            }
            "surface" => self.surface = choice(text)?,
            "isolated" => self.isolated = choice(text)?,
            "seed" => self.seed = number(text, WHOLE)?,
            other => return Err(format!("{other} is not a setting")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_take_the_changes_that_they_read() {
        let tuning = TuningArgs {
            alpha: Some(2.0),
            clusters: Some(7),
            primitive_cost: Some(3.0),
            no_merge: true,
            ..TuningArgs::default()
        };
        let merge = MergeRule::None;
        for (method, expected) in [
            (
                Method::Default,
                Params { alpha: 2.0, clusters: 7, primitive_cost: 3.0, merge, ..Params::default() },
            ),
            (Method::KMeans, Params { clusters: 7, ..Method::KMeans.params() }),
            (Method::Paper, Params { alpha: 2.0, clusters: 7, merge, ..Params::paper() }),
        ] {
            assert_eq!(tuning.params(method), Ok(expected), "{method}");
        }
        let [kmeans, paper] = [Method::KMeans, Method::Paper].map(Method::params);
        assert_eq!(tuning.unread(&[kmeans]), Some("--alpha"));
        assert_eq!(tuning.unread(&[kmeans, paper]), Some("--primitive-cost"));
        assert_eq!(tuning.unread(&[kmeans, paper, Params::default()]), None);
    }
}
