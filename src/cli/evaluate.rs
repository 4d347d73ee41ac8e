//! `superform evaluate`: measures a stored result against a shape.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use serde::Serialize;

use super::headless::{contents, length};
use super::output::{fail_by, print, say};
use crate::geometry::metrics::{MetricOptions, Metrics, Reference, evaluate};
use crate::io::{self, Shape, StoredPrimitives};

/// A result to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluateJob {
    /// `primitives.json`, or the folder that holds it.
    pub result: PathBuf,
    /// Mesh or cloud to measure against.
    pub reference: PathBuf,
    /// JSON instead of a table.
    pub json: bool,
    pub options: MetricOptions,
}

impl EvaluateJob {
    /// Does the job: the figures go to standard output, notes about the
    /// reference to standard error (with JSON they are part of it).
    pub fn run(&self) -> ExitCode {
        match self.work() {
            Ok(text) => print(&(text + "\n")),
            Err(e) => fail_by(&e),
        }
    }

    fn work(&self) -> anyhow::Result<String> {
        let result = io::read_primitives(&self.result)?;
        let shape = io::read(&self.reference)?;
        let reference = io::reference(&shape, &self.options).with_context(|| shape.name.clone())?;
        let metrics = evaluate(&result.shapes(), result.unassigned_share(), &reference);
        if self.json {
            return Ok(serde_json::to_string_pretty(&Evaluation {
                format: "superform-evaluation",
                version: 1,
                program: concat!("superform ", env!("CARGO_PKG_VERSION")),
                result: result.path.display().to_string(),
                reference: self.reference.display().to_string(),
                longest_edge: reference.longest_edge(),
                options: &self.options,
                metrics: &metrics,
                notes: shape.notes.iter().chain(reference.notes()).collect(),
            })?);
        }
        for note in shape.notes.iter().chain(reference.notes()) {
            say(&format!("{}: {note}", shape.name));
        }
        Ok(table(&result, &shape, &reference, &metrics))
    }
}

#[derive(Debug, Serialize)]
struct Evaluation<'a> {
    format: &'static str,
    version: u32,
    program: &'static str,
    result: String,
    reference: String,
    /// In input units; the unit of the lengths below.
    longest_edge: f64,
    options: &'a MetricOptions,
    #[serde(flatten)]
    metrics: &'a Metrics,
    notes: Vec<&'a String>,
}

fn table(result: &StoredPrimitives, shape: &Shape, reference: &Reference, metrics: &Metrics) -> String {
    let mut text = format!(
        "{} of {} against {}: {}\n",
        counted(metrics.primitives, "primitive", "primitives"),
        result.input.as_deref().unwrap_or("an unnamed shape"),
        shape.name,
        contents(shape)
    );
    let mut row = |name: &str, value: String, about: &str| {
        // Writing to a string can't fail.
        let _ = write!(text, "\n{name:<16}{value:>9}  {about}");
    };
    let figure =
        |value: Option<f64>, digits: usize| value.map_or("–".to_owned(), |v| format!("{v:.digits$}"));
    let unit = format!("of the longest edge, {}", length(reference.longest_edge()));
    row("Chamfer-L1", figure(metrics.chamfer_l1, 5), &unit);
    row("  accuracy", figure(metrics.accuracy, 5), "primitives to reference");
    row("  completeness", figure(metrics.completeness, 5), "reference to primitives");
    let about_iou = match (&metrics.iou_missing, metrics.iou_error) {
        (Some(why), _) => why.clone(),
        (None, Some(error)) => format!("± {error:.3}"),
        (None, None) => String::new(),
    };
    row("IoU", figure(metrics.iou, 3), &about_iou);
    if metrics.iou_outside.is_some() {
        row("IoU outside", figure(metrics.iou_outside, 3), "cavities filled");
    }
    row("Primitives", metrics.primitives.to_string(), "");
    if let Some(share) = metrics.unassigned_share {
        row("Unassigned", format!("{:.1} %", 100.0 * share), "of the samples");
    }
    if let Some(share) = metrics.buried_share {
        row(
            "Buried",
            format!("{:.1} %", 100.0 * share),
            "of the primitives' surface is inside other primitives",
        );
    }
    text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

/// "1 primitive", "3 primitives".
fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
