//! Settings of a run, shared by `run`, `bench` and the window.

use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, ValueEnum};

use crate::geometry::metrics::MetricOptions;
use crate::geometry::{Isolated, SamplingOptions, Surface};
use crate::inference::parameters::{Number, brief};
use crate::inference::{MergeRule, Method, PARAMETERS, Parameter, Params, SeenFrom, Setting};

/// A method, what it is tuned with, and what of a shape it is given.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Settings")]
pub(super) struct SettingsArgs {
    /// Method of abstraction
    #[arg(long, visible_alias = "preset", value_name = "NAME", value_parser = methods(), default_value = "default")]
    pub(super) method: Method,
    #[command(flatten)]
    pub(super) tuning: TuningArgs,
    /// Part of a mesh to sample
    #[arg(long, value_enum, default_value_t = SurfaceChoice::Outside)]
    surface: SurfaceChoice,
    /// How to treat isolated points of a cloud
    #[arg(long, value_enum, default_value_t = IsolatedChoice::LeaveOut)]
    isolated: IsolatedChoice,
    /// Seed of all random draws, a whole number: the same seed gives the same
    /// Seed of all random draws; the same seed gives the same result [default: 1]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = whole::<u64>)]
    seed: Option<u64>,
}

/// What methods are tuned with, as far as they read it.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct TuningArgs {
    /// Number of samples N, from 100 to 200000 [default: 5500]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(super) points: Option<usize>,
    #[command(flatten)]
    pub(super) numbers: Numbers,
    /// Do not merge primitives
    #[arg(long)]
    pub(super) no_merge: bool,
    /// Whether the shape was seen from all sides or from one [default: auto]
    #[arg(long, value_enum, value_name = "SIDES")]
    pub(super) seen_from: Option<SeenFromChoice>,
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

/// From which sides the shape was seen. What nobody saw may hold surface without
/// points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum SeenFromChoice {
    /// From its viewpoints if they are known, from one side if that shows all
    /// points, otherwise from all sides
    Auto,
    /// From all sides: a place without points is empty
    All,
    /// From its viewpoints if they are known, otherwise from the side that shows
    /// the most points
    OneSide,
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
        if let Some(choice) = self.seen_from.filter(|_| params.reads(Setting::SeenFrom)) {
            params.seen_from = match choice {
                SeenFromChoice::Auto => SeenFrom::Auto,
                SeenFromChoice::All => SeenFrom::All,
                SeenFromChoice::OneSide => SeenFrom::OneSide,
            };
        }
        let of = params;
        for (parameter, value) in self.numbers.given().filter(|(p, _)| of.reads(p.setting)) {
            parameter.set(&mut params, value);
        }
        params.check().map(|()| params)
    }

    /// The first option that was given although none of the parameters reads
    /// it.
    pub(super) fn unread(&self, params: &[Params]) -> Option<String> {
        let numbers = self.numbers.given().map(|(p, _)| (format!("--{}", p.name), p.setting));
        let merge = self.no_merge.then(|| ("--no-merge".to_owned(), Setting::Merge));
        let sides = self.seen_from.map(|_| ("--seen-from".to_owned(), Setting::SeenFrom));
        let mut given = numbers.chain(merge).chain(sides);
        given.find(|(_, setting)| !params.iter().any(|p| p.reads(*setting))).map(|(option, _)| option)
    }
}

/// The numbers of the table of parameters that were given as options, in its
/// order.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Numbers([Option<f64>; PARAMETERS.len()]);

impl Numbers {
    fn given(&self) -> impl Iterator<Item = (&'static Parameter, f64)> {
        PARAMETERS.iter().zip(self.0).filter_map(|(parameter, value)| Some((parameter, value?)))
    }

    pub(super) fn set(&mut self, setting: Setting, value: f64) {
        self.0[setting as usize] = Some(value);
    }

    /// The methods' defaults, for the help.
    fn default_of(parameter: &Parameter) -> String {
        let usual = parameter.value(&Params::default()).unwrap_or_default();
        let mut text = format!("{usual}");
        for method in Method::ALL.iter().filter(|m| m.params().reads(parameter.setting)) {
            let own = parameter.value(&method.params()).unwrap_or(usual);
            if own != usual {
                text.push_str(&format!(", and {own} for {method}"));
            }
        }
        text
    }

    /// A value from text.
    fn parse(number: Number, text: &str) -> Result<f64, String> {
        match number {
            Number::Real(..) => text.parse().map_err(|_| "a number".to_owned()),
            Number::Count(..) => text.parse::<u32>().map(f64::from).map_err(|_| WHOLE.to_owned()),
        }
    }
}

impl Args for Numbers {
    fn augment_args(mut command: Command) -> Command {
        for parameter in &PARAMETERS {
            let Some(number) = parameter.number else { continue };
            let (low, high) = parameter.setting.range();
            let [low, high] = [low, high].map(brief);
            let help = format!(
                "{}; from {low} to {high} [default: {}]",
                parameter.help,
                Self::default_of(parameter)
            );
            let value = move |text: &str| {
                Self::parse(number, text).map_err(|expected| format!("it must be {expected}"))
            };
            command = command.arg(
                Arg::new(parameter.name)
                    .long(parameter.name)
                    .value_name(parameter.symbol)
                    .allow_negative_numbers(true)
                    .value_parser(value)
                    .help(help),
            );
        }
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Numbers {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut new = Self::default();
        new.update_from_arg_matches(matches).map(|()| new)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for parameter in PARAMETERS.iter().filter(|p| p.number.is_some()) {
            if let Some(value) = matches.get_one::<f64>(parameter.name) {
                self.set(parameter.setting, *value);
            }
        }
        Ok(())
    }
}

const WHOLE: &str = "a non-negative whole number";

/// The settings that a manifest's columns and `--sweep` change, by the names of
/// their options.
pub(super) fn keys() -> impl Iterator<Item = &'static str> {
    let numbers = PARAMETERS.iter().filter(|p| p.number.is_some()).map(|p| p.name);
    ["method", "points"].into_iter().chain(numbers).chain([
        "no-merge",
        "seen-from",
        "surface",
        "isolated",
        "seed",
    ])
}

/// What a method must read for a setting to make sense.
fn setting_of(key: &str) -> Option<Setting> {
    let number = PARAMETERS.iter().find(|p| p.number.is_some() && p.name == key).map(|p| p.setting);
    number.or(match key {
        "no-merge" => Some(Setting::Merge),
        "seen-from" => Some(Setting::SeenFrom),
        _ => None,
    })
}

/// The name in [`keys`] that a person means: `--primitive-cost`,
/// `primitive_cost` and `Primitive-Cost` are the same.
pub(super) fn key(text: &str) -> Option<&'static str> {
    let text = text.trim().trim_start_matches("--").replace('_', "-").to_lowercase();
    let text = if text == "preset" { "method" } else { &text };
    keys().find(|name| *name == text)
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

    /// The settings with some changes, each a name of [`keys`] and a value as
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
            if setting_of(key).is_some_and(|setting| !resolved.1.reads(setting)) {
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
        let tuning = &mut self.tuning;
        match key {
            "method" => {
                self.method = text.parse().map_err(|_| {
                    format!("“{text}” is not one of {}", Method::ALL.map(Method::name).join(", "))
                })?;
            }
            "points" => tuning.points = number(text, WHOLE)?,
            "no-merge" => {
                tuning.no_merge = match text.to_lowercase().as_str() {
                    "true" | "yes" | "1" => true,
                    "false" | "no" | "0" => false,
                    _ => return Err(format!("“{text}” is neither true nor false")),
                }
            }
            "seen-from" => tuning.seen_from = Some(choice(text)?),
            "surface" => self.surface = choice(text)?,
            "isolated" => self.isolated = choice(text)?,
            "seed" => self.seed = number(text, WHOLE)?,
            other => {
                let parameter = PARAMETERS.iter().find(|p| p.name == other);
                let Some((parameter, number)) = parameter.and_then(|p| Some((p, p.number?))) else {
                    return Err(format!("{other} is not a setting"));
                };
                let value = Numbers::parse(number, text);
                let value = value.map_err(|expected| format!("“{text}” is not {expected}"))?;
                tuning.numbers.set(parameter.setting, value);
            }
        }
        Ok(())
    }
}

/// How much is measured.
#[derive(Debug, Args)]
#[command(next_help_heading = "Measuring")]
pub(super) struct MeasureArgs {
    /// Number of samples on each surface, and of points for volumes
    #[arg(long, value_name = "N", default_value_t = MetricOptions::default().samples)]
    samples: usize,
}

impl MeasureArgs {
    pub(super) fn resolve(&self, seed: u64) -> Result<MetricOptions, String> {
        let options = MetricOptions { samples: self.samples, volume_points: self.samples, seed };
        options.check().map(|()| options)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_take_the_changes_that_they_read() {
        let mut tuning = TuningArgs { no_merge: true, ..TuningArgs::default() };
        for (setting, value) in
            [(Setting::Alpha, 2.0), (Setting::Clusters, 7.0), (Setting::PrimitiveCost, 3.0)]
        {
            tuning.numbers.set(setting, value);
        }
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
        assert_eq!(tuning.unread(&[kmeans]).as_deref(), Some("--alpha"));
        assert_eq!(tuning.unread(&[kmeans, paper]).as_deref(), Some("--primitive-cost"));
        assert_eq!(tuning.unread(&[kmeans, paper, Params::default()]), None);
    }
}
