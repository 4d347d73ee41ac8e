//! Sweeps over settings, and parts of a list of jobs.

use std::str::FromStr;

use crate::cli::settings::{KEYS, key};

/// Most values of one range.
const MOST_VALUES: u64 = 10_000;

/// Values of some settings, all of whose combinations are run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Sweep(Vec<Swept>);

/// One setting with its values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Swept {
    pub(super) key: &'static str,
    values: Vec<String>,
}

impl FromStr for Swept {
    type Err = String;

    /// `alpha=0.1,0.5`, `seed=1..5`: both ends of a range belong to it.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, list) = text.split_once('=').ok_or_else(|| {
            format!("“{text}” is not of the form alpha=0.1,0.5; write inputs before --sweep")
        })?;
        let key = key(name).ok_or_else(|| {
            let keys: Vec<&str> = KEYS.iter().map(|(name, _)| *name).collect();
            format!("“{name}” is not a setting; settings are {}", keys.join(", "))
        })?;
        let mut values: Vec<String> = Vec::new();
        for part in list.to_lowercase().split(',').map(str::trim) {
            let several = match part.split_once("..") {
                Some((from, to)) => range(from, to)
                    .ok_or_else(|| format!("“{part}” is not a range of 1 to {MOST_VALUES} whole numbers"))?,
                None if part.is_empty() => return Err(format!("empty value of {key} in “{text}”")),
                None => vec![part.to_owned()],
            };
            for value in several {
                if !values.contains(&value) {
                    values.push(value);
                }
            }
        }
        Ok(Self { key, values })
    }
}

fn range(from: &str, to: &str) -> Option<Vec<String>> {
    let (from, to) = (from.trim().parse::<u64>().ok()?, to.trim().parse::<u64>().ok()?);
    (from <= to && to - from < MOST_VALUES).then(|| (from..=to).map(|n| n.to_string()).collect())
}

impl Sweep {
    pub(super) fn new(swept: Vec<Swept>) -> Result<Self, String> {
        for (at, one) in swept.iter().enumerate() {
            if swept[..at].iter().any(|other| other.key == one.key) {
                return Err(format!("--sweep has {} twice; list all its values together", one.key));
            }
        }
        Ok(Self(swept))
    }

    pub(super) fn keys(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|swept| swept.key)
    }

    /// How many combinations there are.
    pub(super) fn len(&self) -> usize {
        self.0.iter().map(|swept| swept.values.len()).fold(1, usize::saturating_mul)
    }

    /// All combinations, the last setting changing fastest; one without
    /// settings where nothing is swept.
    pub(super) fn combinations(&self) -> impl Iterator<Item = Vec<(&'static str, &str)>> {
        (0..self.len()).map(|number| {
            let mut rest = number;
            let mut chosen: Vec<(&'static str, &str)> = self
                .0
                .iter()
                .rev()
                .map(|swept| {
                    let value = &swept.values[rest % swept.values.len()];
                    rest /= swept.values.len();
                    (swept.key, value.as_str())
                })
                .collect();
            chosen.reverse();
            chosen
        })
    }
}

/// Settings as they appear in a job's name: `alpha=0.1,p0=0.05`.
pub(super) fn shown<'a>(settings: impl IntoIterator<Item = (&'static str, &'a str)>) -> String {
    settings.into_iter().map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(",")
}

/// Every N-th job of a list, for one of N machines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shard {
    pub(super) index: usize,
    pub(super) of: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parsed {
            Some((index, of)) if index < of => Ok(Self { index, of }),
            Some(_) => Err("shards are counted from 0: four shards are 0/4, 1/4, 2/4 and 3/4".to_owned()),
            None => Err("expected a value such as 0/4".to_owned()),
        }
    }
}

/// Some jobs that follow each other, counted from 1; both ends belong to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Lines {
    pub(super) from: usize,
    pub(super) to: usize,
}

impl FromStr for Lines {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (from, to) = text.split_once("..").unwrap_or((text, text));
        match (from.trim().parse(), to.trim().parse()) {
            (Ok(from), Ok(to)) if 0 < from && from <= to => Ok(Self { from, to }),
            _ => Err("expected a range such as 11..20, counted from 1".to_owned()),
        }
    }
}

/// Which jobs of a list are to be done here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    All,
    Shard(Shard),
    Lines(Lines),
}

impl Part {
    /// Whether the job with this index (from 0) belongs to it.
    pub(super) fn has(self, index: usize) -> bool {
        match self {
            Self::All => true,
            Self::Shard(shard) => index % shard.of == shard.index,
            Self::Lines(lines) => (lines.from..=lines.to).contains(&(index + 1)),
        }
    }

    /// Name of its tables, without the ending.
    pub(super) fn table(self) -> String {
        match self {
            Self::All => "results".to_owned(),
            Self::Shard(shard) => format!("results.{}-of-{}", shard.index, shard.of),
            Self::Lines(lines) => format!("results.lines-{}-to-{}", lines.from, lines.to),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_combinations_are_there_once() {
        let swept = |text: &str| text.parse::<Swept>();
        let sweep = Sweep::new(vec![swept("alpha=0.1, 0.5,0.1").unwrap(), swept("seed=1..3").unwrap()]);
        let sweep = sweep.unwrap();
        let names: Vec<String> = sweep.combinations().map(shown).collect();
        assert_eq!(names.len(), sweep.len());
        assert_eq!(names[..2], ["alpha=0.1,seed=1", "alpha=0.1,seed=2"]);
        assert_eq!(names[5], "alpha=0.5,seed=3");
        assert_eq!(Sweep::default().combinations().map(shown).collect::<Vec<_>>(), [""]);
        assert!(Sweep::new(vec![swept("seed=1").unwrap(), swept("seed=2").unwrap()]).is_err());
        for (text, words) in [
            ("alpha", "write inputs before"),
            ("alpah=1", "is not a setting"),
            ("seed=3..1", "is not a range"),
            ("seed=0..99999", "is not a range"),
            ("alpha=1,,2", "empty"),
        ] {
            assert!(swept(text).unwrap_err().contains(words), "{text}");
        }
    }

    #[test]
    fn parts_cover_a_list_without_overlap() {
        let shards: Vec<Part> = (0..4).map(|i| Part::Shard(format!("{i}/4").parse().unwrap())).collect();
        let lines = ["1..3", "4", "5..40"].map(|text| Part::Lines(text.parse().unwrap()));
        for parts in [&shards[..], &lines[..]] {
            for index in 0..30 {
                assert_eq!(parts.iter().filter(|part| part.has(index)).count(), 1, "{index}");
            }
        }
        assert_eq!(shards[1].table(), "results.1-of-4");
        for text in ["4/4", "0/0", "1", "a/b", "-1/2"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        for text in ["0..3", "3..2", "x", ""] {
            assert!(text.parse::<Lines>().is_err(), "{text}");
        }
    }
}
