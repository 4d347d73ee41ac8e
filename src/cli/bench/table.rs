//! From runs to a table: medians and spread over seeds, means over shapes.

use std::collections::HashMap;
use std::path::Path;

use anyhow::bail;
use serde::Serialize;

use super::shapes::rows;
use super::store::Row;

/// One figure over several seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Spread {
    pub(super) median: f64,
    pub(super) mean: f64,
    pub(super) worst: f64,
}

impl Spread {
    /// `None` without values. `pick` is `f64::max` where less is better, and
    /// `f64::min` where more is.
    pub(super) fn of(mut values: Vec<f64>, pick: fn(f64, f64) -> f64) -> Option<Self> {
        let worst = values.iter().copied().reduce(pick)?;
        values.sort_by(f64::total_cmp);
        let middle = values.len() / 2;
        let median = match values.len() % 2 {
            1 => values[middle],
            _ => 0.5 * (values[middle - 1] + values[middle]),
        };
        Some(Self { median, mean: mean(&values), worst })
    }

    /// worst/median: 1 where all seeds agree.
    pub(super) fn ratio(&self) -> f64 {
        if self.worst == self.median { 1.0 } else { self.worst / self.median }
    }
}

/// Figures of one shape and method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Line {
    pub(super) shape: String,
    pub(super) method: String,
    pub(super) seeds: usize,
    pub(super) chamfer_l1: Spread,
    pub(super) accuracy: Spread,
    pub(super) completeness: Spread,
    pub(super) iou: Option<Spread>,
    pub(super) iou_outside: Option<Spread>,
    pub(super) primitives: Spread,
    pub(super) unassigned_share: Spread,
    pub(super) seconds: Spread,
    /// Beside the figures of the file that is compared with.
    pub(super) against: Option<Against>,
}

/// A line beside the other file's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Against {
    pub(super) chamfer_ratio: f64,
    pub(super) primitives_ratio: f64,
    pub(super) iou_difference: Option<f64>,
}

/// Figures of one method over all shapes: geometric means of the medians, the
/// mean of IoU.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Total {
    pub(super) method: String,
    pub(super) shapes: usize,
    pub(super) chamfer_l1: f64,
    /// Geometric mean and largest of the shapes' worst/median.
    pub(super) chamfer_spread: f64,
    pub(super) chamfer_spread_worst: f64,
    pub(super) iou: Option<f64>,
    pub(super) iou_outside: Option<f64>,
    pub(super) primitives: f64,
    pub(super) seconds: f64,
}

/// One method against the other file, over the shapes that both have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Versus {
    pub(super) method: String,
    pub(super) shapes: usize,
    /// Geometric means of ratios, this to the other: of medians over seeds,
    /// and of means over seeds.
    pub(super) chamfer_ratio: f64,
    pub(super) chamfer_ratio_of_means: f64,
    pub(super) primitives_ratio: f64,
    pub(super) primitives_ratio_of_means: f64,
    /// Mean IoU here and there, over the shapes where both have one.
    pub(super) iou: Option<(f64, f64)>,
    /// Share of the shapes with the smaller Chamfer distance.
    pub(super) better_share: f64,
    /// Shapes whose Chamfer distance and count are both larger.
    pub(super) worse_in_both: Vec<String>,
}

/// Figures of a shape in the file that is compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Other {
    primitives: f64,
    chamfer_l1: f64,
    iou: Option<f64>,
}

/// Reads the columns `name`, `primitives`, `chamfer_l1` and `iou` (which may
/// be empty) of a CSV file; that of an earlier benchmark of one method will do.
pub(super) fn read_others(path: &Path) -> anyhow::Result<HashMap<String, Other>> {
    let mut others = HashMap::new();
    for (line, row) in rows(path, &["name", "primitives", "chamfer_l1", "iou"])? {
        let number = |i: usize, name: &str| match row[i].parse::<f64>() {
            Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
            _ => bail!("{}, line {line}: {name} is “{}”, expected a number above 0", path.display(), row[i]),
        };
        let iou = match row[3].parse::<f64>() {
            _ if row[3].is_empty() => None,
            Ok(v) if (0.0..=1.0).contains(&v) => Some(v),
            _ => bail!("{}, line {line}: iou is “{}”, expected a number from 0 to 1", path.display(), row[3]),
        };
        let other = Other { primitives: number(1, "primitives")?, chamfer_l1: number(2, "chamfer_l1")?, iou };
        if others.insert(row[0].clone(), other).is_some() {
            bail!("{}, line {line}: duplicate row for {}; remove one", path.display(), row[0]);
        }
    }
    Ok(others)
}

/// All of a benchmark's figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Table {
    pub(super) lines: Vec<Line>,
    pub(super) totals: Vec<Total>,
    pub(super) comparison: Option<Vec<Versus>>,
}

impl Table {
    /// Lines in the order of the rows' first appearance.
    pub(super) fn new(rows: &[Row], others: Option<&HashMap<String, Other>>) -> Self {
        let mut order: Vec<(&str, &str)> = Vec::new();
        let mut groups: HashMap<(&str, &str), Vec<&Row>> = HashMap::new();
        for row in rows {
            let name = (row.shape.as_str(), row.method.as_str());
            groups
                .entry(name)
                .or_insert_with(|| {
                    order.push(name);
                    Vec::new()
                })
                .push(row);
        }
        let lines: Vec<Line> = order.iter().filter_map(|name| line(&groups[name], others)).collect();
        let mut methods: Vec<&str> = Vec::new();
        for line in &lines {
            if !methods.contains(&line.method.as_str()) {
                methods.push(&line.method);
            }
        }
        let of = |method: &str| lines.iter().filter(|l| l.method == method).collect::<Vec<_>>();
        let totals = methods.iter().map(|m| total(m, &of(m))).collect();
        let comparison =
            others.map(|others| methods.iter().filter_map(|m| versus(m, &of(m), others)).collect());
        Self { totals, comparison, lines }
    }
}

fn line(rows: &[&Row], others: Option<&HashMap<String, Other>>) -> Option<Line> {
    let first = rows.first()?;
    let largest = |value: fn(&Row) -> f64| Spread::of(rows.iter().map(|r| value(r)).collect(), f64::max);
    let smallest =
        |value: fn(&Row) -> Option<f64>| Spread::of(rows.iter().filter_map(|r| value(r)).collect(), f64::min);
    let (chamfer_l1, primitives) = (largest(|r| r.chamfer_l1)?, largest(|r| r.primitives as f64)?);
    let iou = smallest(|r| r.iou);
    let against = others.and_then(|o| o.get(&first.shape)).map(|other| Against {
        chamfer_ratio: chamfer_l1.median / other.chamfer_l1,
        primitives_ratio: primitives.median / other.primitives,
        iou_difference: iou.zip(other.iou).map(|(ours, theirs)| ours.median - theirs),
    });
    Some(Line {
        shape: first.shape.clone(),
        method: first.method.clone(),
        seeds: rows.len(),
        chamfer_l1,
        accuracy: largest(|r| r.accuracy)?,
        completeness: largest(|r| r.completeness)?,
        iou,
        iou_outside: smallest(|r| r.iou_outside),
        primitives,
        unassigned_share: largest(|r| r.unassigned_share)?,
        seconds: largest(|r| r.seconds)?,
        against,
    })
}

fn total(method: &str, lines: &[&Line]) -> Total {
    let medians = |value: fn(&Line) -> Option<Spread>| -> Vec<f64> {
        lines.iter().filter_map(|l| value(l)).map(|s| s.median).collect()
    };
    let mean_of = |values: Vec<f64>| (!values.is_empty()).then(|| mean(&values));
    let spreads: Vec<f64> = lines.iter().map(|l| l.chamfer_l1.ratio()).collect();
    Total {
        method: method.to_owned(),
        shapes: lines.len(),
        chamfer_l1: geometric_mean(&medians(|l| Some(l.chamfer_l1))),
        chamfer_spread: geometric_mean(&spreads),
        chamfer_spread_worst: spreads.iter().copied().fold(1.0, f64::max),
        iou: mean_of(medians(|l| l.iou)),
        iou_outside: mean_of(medians(|l| l.iou_outside)),
        primitives: geometric_mean(&medians(|l| Some(l.primitives))),
        seconds: geometric_mean(&medians(|l| Some(l.seconds))),
    }
}

fn versus(method: &str, lines: &[&Line], others: &HashMap<String, Other>) -> Option<Versus> {
    let pairs: Vec<(&Line, Against, &Other)> =
        lines.iter().filter_map(|l| Some((*l, l.against?, others.get(&l.shape)?))).collect();
    if pairs.is_empty() {
        return None;
    }
    let ratio = |value: fn(&(&Line, Against, &Other)) -> f64| {
        geometric_mean(&pairs.iter().map(value).collect::<Vec<_>>())
    };
    let (ours, theirs): (Vec<f64>, Vec<f64>) =
        pairs.iter().filter_map(|(l, _, o)| Some((l.iou?.median, o.iou?))).unzip();
    let better = pairs.iter().filter(|p| p.1.chamfer_ratio < 1.0).count();
    Some(Versus {
        method: method.to_owned(),
        shapes: pairs.len(),
        chamfer_ratio: ratio(|p| p.1.chamfer_ratio),
        chamfer_ratio_of_means: ratio(|(l, _, o)| l.chamfer_l1.mean / o.chamfer_l1),
        primitives_ratio: ratio(|p| p.1.primitives_ratio),
        primitives_ratio_of_means: ratio(|(l, _, o)| l.primitives.mean / o.primitives),
        iou: (!ours.is_empty()).then(|| (mean(&ours), mean(&theirs))),
        better_share: better as f64 / pairs.len() as f64,
        worse_in_both: pairs
            .iter()
            .filter(|p| p.1.chamfer_ratio > 1.0 && p.1.primitives_ratio > 1.0)
            .map(|p| p.0.shape.clone())
            .collect(),
    })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn geometric_mean(values: &[f64]) -> f64 {
    let logs: Vec<f64> = values.iter().map(|v| v.max(f64::MIN_POSITIVE).ln()).collect();
    mean(&logs).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(shape: &str, seed: u64, chamfer_l1: f64, primitives: usize, iou: Option<f64>) -> Row {
        Row {
            shape: shape.to_owned(),
            method: "default".to_owned(),
            seed,
            key: String::new(),
            primitives,
            chamfer_l1,
            accuracy: chamfer_l1,
            completeness: chamfer_l1,
            iou,
            iou_outside: None,
            unassigned_share: 0.0,
            seconds: 2.0 * seed as f64,
        }
    }

    #[test]
    fn medians_and_spreads_are_right() {
        let rows = [
            row("chair", 1, 0.004, 10, Some(0.8)),
            row("chair", 2, 0.002, 12, Some(0.7)),
            row("chair", 3, 0.005, 8, Some(0.9)),
            row("cloud", 1, 0.010, 4, None),
            row("cloud", 2, 0.030, 4, None),
        ];
        let table = Table::new(&rows, None);
        let [chair, cloud] = &table.lines[..] else { panic!("{table:?}") };
        assert_eq!(
            (chair.shape.as_str(), chair.seeds, cloud.shape.as_str(), cloud.seeds),
            ("chair", 3, "cloud", 2)
        );
        assert_eq!((chair.chamfer_l1.median, chair.chamfer_l1.worst), (0.004, 0.005));
        assert_eq!(chair.chamfer_l1.ratio(), 1.25);
        assert_eq!((chair.primitives.median, chair.primitives.worst), (10.0, 12.0));
        let iou = chair.iou.unwrap();
        assert_eq!((iou.median, iou.worst), (0.8, 0.7), "less is worse");
        assert!((iou.mean - 0.8).abs() < 1e-12);
        assert_eq!(chair.seconds.median, 4.0);
        assert_eq!((cloud.chamfer_l1.median, cloud.iou), (0.02, None));
        let total = &table.totals[0];
        assert_eq!((total.shapes, total.iou), (2, Some(0.8)));
        assert!((total.chamfer_l1 - (0.004f64 * 0.02).sqrt()).abs() < 1e-12);
        assert!((total.primitives - 40f64.sqrt()).abs() < 1e-12);
        assert_eq!(total.chamfer_spread_worst, 1.5);
        assert!(table.comparison.is_none());
    }

    #[test]
    fn the_comparison_tells_who_is_better() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("authors.csv");
        let text =
            "name,primitives,chamfer_l1,iou,cpu_s\r\na,20,0.008,0.5,9\r\nb,4,0.002,,9\r\nc,5,1,0.1,9\r\n";
        std::fs::write(&path, text).unwrap();
        let others = read_others(&path).unwrap();
        let rows = [
            row("a", 1, 0.002, 5, Some(0.8)),
            row("a", 2, 0.002, 5, Some(0.8)),
            row("a", 3, 0.008, 5, Some(0.8)),
            row("b", 1, 0.004, 8, Some(0.9)),
            row("d", 1, 0.004, 8, Some(0.9)),
        ];
        let table = Table::new(&rows, Some(&others));
        let against = table.lines[0].against.unwrap();
        assert_eq!((against.chamfer_ratio, against.primitives_ratio), (0.25, 0.25));
        assert!((against.iou_difference.unwrap() - 0.3).abs() < 1e-12);
        assert_eq!(table.lines[1].against.unwrap().iou_difference, None);
        assert_eq!(table.lines[2].against, None);
        let versus = &table.comparison.unwrap()[0];
        assert_eq!((versus.shapes, versus.better_share), (2, 0.5));
        assert!((versus.chamfer_ratio - (0.25f64 * 2.0).sqrt()).abs() < 1e-12);
        assert!((versus.chamfer_ratio_of_means - (0.5f64 * 2.0).sqrt()).abs() < 1e-12);
        assert_eq!(versus.worse_in_both, ["b"]);
        let (ours, theirs) = versus.iou.unwrap();
        assert!((ours - 0.8).abs() < 1e-12 && theirs == 0.5);
    }

    #[test]
    fn a_file_that_can_not_be_compared_with_is_refused_with_the_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.csv");
        for (text, words) in [
            ("name,primitives\na,3\n", "no column chamfer_l1"),
            ("name,primitives,chamfer_l1,iou\na,3,0.1,\na,3,0.1,\n", "line 3: duplicate row for a"),
            ("name,primitives,chamfer_l1,iou\na,3,zero,\n", "line 2: chamfer_l1 is “zero”"),
            ("name,primitives,chamfer_l1,iou\na,3,0.1,7\n", "line 2: iou is “7”"),
        ] {
            std::fs::write(&path, text).unwrap();
            let problem = format!("{:#}", read_others(&path).unwrap_err());
            assert!(problem.contains(words), "{problem}");
        }
    }
}
