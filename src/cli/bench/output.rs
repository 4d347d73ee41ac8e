//! The table as Markdown and CSV.

use super::table::{Line, Spread, Table, Total, Versus};

/// A Markdown table with the means below it and, where there is something to
/// compare with, a summary of that.
pub(super) fn markdown(table: &Table) -> String {
    let compared = table.comparison.is_some();
    let filled = table.lines.iter().any(|l| l.iou_outside.is_some());
    let mut header = vec!["shape", "method", "Chamfer-L1", "spread", "IoU", "spread"];
    if filled {
        header.push("IoU outside");
    }
    header.extend(["primitives", "spread", "seconds"]);
    if compared {
        header.extend(["Chamfer ratio", "count ratio", "IoU gain"]);
    }
    let mut cells = vec![header.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    cells.extend(table.lines.iter().map(|l| line(l, filled, compared)));
    for total in &table.totals {
        let versus = table.comparison.as_ref().map(|all| all.iter().find(|v| v.method == total.method));
        cells.push(total_line(total, versus, filled));
    }
    let mut text = aligned(&cells, 2);
    text.push_str(
        "\nMedians over seeds; spread is worst/median. The last rows are geometric means (arithmetic mean \
         for IoU). Lengths are in units of the longest edge of the reference's bounding box; seconds are \
         CPU seconds on one core.\n",
    );
    for versus in table.comparison.iter().flatten() {
        text.push_str(&comparison(versus));
    }
    text
}

fn line(line: &Line, filled: bool, compared: bool) -> Vec<String> {
    let mut cells = vec![
        line.shape.clone(),
        line.method.clone(),
        distance(line.chamfer_l1.median),
        ratio(line.chamfer_l1.ratio()),
        line.iou.map_or_else(none, |s| share(s.median)),
        line.iou.map_or_else(none, |s| ratio(s.ratio())),
    ];
    if filled {
        cells.push(line.iou_outside.map_or_else(none, |s| share(s.median)));
    }
    cells.extend([
        count(line.primitives.median),
        ratio(line.primitives.ratio()),
        format!("{:.2}", line.seconds.median),
    ]);
    if compared {
        cells.extend([
            line.against.map_or_else(none, |a| ratio(a.chamfer_ratio)),
            line.against.map_or_else(none, |a| ratio(a.primitives_ratio)),
            line.against.and_then(|a| a.iou_difference).map_or_else(none, |d| format!("{d:+.3}")),
        ]);
    }
    cells
}

fn total_line(total: &Total, versus: Option<Option<&Versus>>, filled: bool) -> Vec<String> {
    let mut cells = vec![
        format!("**all {}**", total.shapes),
        total.method.clone(),
        distance(total.chamfer_l1),
        ratio(total.chamfer_spread),
        total.iou.map_or_else(none, share),
        String::new(),
    ];
    if filled {
        cells.push(total.iou_outside.map_or_else(none, share));
    }
    cells.extend([format!("{:.1}", total.primitives), String::new(), format!("{:.2}", total.seconds)]);
    if let Some(versus) = versus {
        cells.extend([
            versus.map_or_else(none, |v| ratio(v.chamfer_ratio)),
            versus.map_or_else(none, |v| ratio(v.primitives_ratio)),
            versus.and_then(|v| v.iou).map_or_else(none, |(ours, theirs)| format!("{:+.3}", ours - theirs)),
        ]);
    }
    cells
}

fn comparison(versus: &Versus) -> String {
    let iou = versus.iou.map_or(String::new(), |(ours, theirs)| {
        format!("mean IoU {} instead of {}; ", share(ours), share(theirs))
    });
    let worse = match &versus.worse_in_both[..] {
        [] => "none is worse in both".to_owned(),
        shapes => format!("worse in both: {}", shapes.join(", ")),
    };
    format!(
        "\n{}, compared over {} shapes: Chamfer-L1 {}× (by means over seeds {}×), primitives {}× ({}×); {iou}\
         better Chamfer-L1 on {:.0} %; {worse}.\n",
        versus.method,
        versus.shapes,
        ratio(versus.chamfer_ratio),
        ratio(versus.chamfer_ratio_of_means),
        ratio(versus.primitives_ratio),
        ratio(versus.primitives_ratio_of_means),
        100.0 * versus.better_share,
    )
}

fn distance(value: f64) -> String {
    format!("{value:.5}")
}

fn share(value: f64) -> String {
    format!("{value:.3}")
}

fn ratio(value: f64) -> String {
    format!("{value:.2}")
}

fn count(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value:.0}") } else { format!("{value:.1}") }
}

/// Where there is no figure.
pub(super) fn none() -> String {
    "–".to_owned()
}

/// Rows of cells as Markdown, in columns also for those who read the text:
/// as many columns of `words`, then numbers.
pub(super) fn aligned(cells: &[Vec<String>], words: usize) -> String {
    let columns = cells.first().map_or(0, Vec::len);
    let width = |k: usize| cells.iter().map(|row| row[k].chars().count()).max().unwrap_or(0).max(3);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for (i, row) in cells.iter().enumerate() {
        text.push('|');
        for (k, cell) in row.iter().enumerate() {
            let pad = " ".repeat(widths[k] - cell.chars().count());
            text.push_str(&if k < words { format!(" {cell}{pad} |") } else { format!(" {pad}{cell} |") });
        }
        text.push('\n');
        if i == 0 {
            text.push('|');
            for (k, width) in widths.iter().enumerate() {
                let dashes = "-".repeat(width + 1);
                text.push_str(&if k < words { format!("{dashes}-|") } else { format!("{dashes}:|") });
            }
            text.push('\n');
        }
    }
    text
}

/// The lines, one a shape and method, in full precision.
pub(super) fn csv(table: &Table) -> Result<Vec<u8>, csv::Error> {
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record([
        "name",
        "method",
        "seeds",
        "primitives",
        "chamfer_l1",
        "iou",
        "iou_outside",
        "seconds",
        "accuracy",
        "completeness",
        "unassigned_share",
        "primitives_mean",
        "primitives_worst",
        "chamfer_l1_mean",
        "chamfer_l1_worst",
        "iou_mean",
        "iou_worst",
        "seconds_worst",
        "chamfer_ratio",
        "primitives_ratio",
        "iou_difference",
    ])?;
    for line in &table.lines {
        let text = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
        let of = |spread: Option<Spread>, value: fn(&Spread) -> f64| text(spread.as_ref().map(value));
        out.write_record([
            line.shape.clone(),
            line.method.clone(),
            line.seeds.to_string(),
            line.primitives.median.to_string(),
            line.chamfer_l1.median.to_string(),
            of(line.iou, |s| s.median),
            of(line.iou_outside, |s| s.median),
            line.seconds.median.to_string(),
            line.accuracy.median.to_string(),
            line.completeness.median.to_string(),
            line.unassigned_share.median.to_string(),
            line.primitives.mean.to_string(),
            line.primitives.worst.to_string(),
            line.chamfer_l1.mean.to_string(),
            line.chamfer_l1.worst.to_string(),
            of(line.iou, |s| s.mean),
            of(line.iou, |s| s.worst),
            line.seconds.worst.to_string(),
            text(line.against.map(|a| a.chamfer_ratio)),
            text(line.against.map(|a| a.primitives_ratio)),
            text(line.against.and_then(|a| a.iou_difference)),
        ])?;
    }
    out.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}
