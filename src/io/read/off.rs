//! OFF (Geomview's object files): vertices with their normals and colours, then
//! polygons, in text.

use nalgebra::Point3;

use super::columns;
use super::raw::Raw;
use super::text::{lines, number, quoted};
use crate::io::error::Fault;

/// What the first word says of the vertices: `[ST][C][N][4]OFF`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Layout {
    has_colors: bool,
    has_normals: bool,
    is_homogeneous: bool,
}

impl Layout {
    fn of(word: &str) -> Option<Self> {
        let rest = word.strip_suffix("OFF")?;
        let rest = rest.strip_prefix("ST").unwrap_or(rest);
        let (has_colors, rest) = strip(rest, 'C');
        let (has_normals, rest) = strip(rest, 'N');
        let (is_homogeneous, rest) = strip(rest, '4');
        rest.is_empty().then_some(Self { has_colors, has_normals, is_homogeneous })
    }

    /// The column at which the colour begins.
    fn color_column(self) -> usize {
        self.normal_column() + if self.has_normals { 3 } else { 0 }
    }

    fn normal_column(self) -> usize {
        3 + usize::from(self.is_homogeneous)
    }

    /// The layout that a first word tells, and the rest of that word: some
    /// programs write the counts without a blank in between (`OFF8 12 0`).
    fn leading(word: &str) -> Option<(Self, &str)> {
        let (name, rest) = word.split_at(word.find("OFF")? + 3);
        let is_count = rest.bytes().all(|b| b.is_ascii_digit());
        Some((Self::of(name).filter(|_| is_count)?, rest))
    }
}

fn strip(text: &str, prefix: char) -> (bool, &str) {
    text.strip_prefix(prefix).map_or((false, text), |rest| (true, rest))
}

/// Lines with something on them, without their comments.
fn content(text: &str) -> impl Iterator<Item = (usize, &str)> {
    lines(text)
        .map(|(n, line)| (n, line.split('#').next().unwrap_or_default().trim()))
        .filter(|(_, line)| !line.is_empty())
}

/// Whether a text begins as an OFF file does.
pub(super) fn is_off(text: &str) -> bool {
    let first = content(text).next().and_then(|(_, line)| line.split_whitespace().next());
    first.is_some_and(|word| Layout::leading(word).is_some() || word == "nOFF" || word == "4nOFF")
}

pub(super) fn parse(text: &str) -> Result<Raw, Fault> {
    let mut lines = content(text);
    let (line, head) = lines.next().unwrap_or((1, ""));
    let mut words = head.split_whitespace();
    let (layout, glued) = words.next().and_then(Layout::leading).ok_or_else(|| {
        let problem = format!("{} begins no OFF mesh of three dimensions", quoted(head));
        Fault::at_line(line, problem)
    })?;
    let mut counts: Vec<&str> = Some(glued).filter(|w| !w.is_empty()).into_iter().chain(words).collect();
    if counts.first().is_some_and(|w| w.eq_ignore_ascii_case("binary")) {
        return Err(Fault::at_line(line, "a binary OFF mesh can't be read; save it as text"));
    }
    let mut line = line;
    if counts.is_empty() {
        let Some((at, next)) = lines.next() else {
            return Err(Fault::at_line(line, "the counts of vertices and faces are missing"));
        };
        (line, counts) = (at, next.split_whitespace().collect());
    }
    let count = |i: usize| {
        let word = counts.get(i).copied().unwrap_or_default();
        word.parse::<u64>().map_err(|_| {
            Fault::at_line(line, format!("{} is not a number of vertices or faces", quoted(word)))
        })
    };
    let (vertices, faces) = (count(0)?, count(1)?);

    // Nothing is set aside for what is only announced.
    let mut raw = Raw::default();
    let (mut colors, mut normals) = (Vec::new(), Vec::new());
    for done in 0..vertices {
        let (at, values) = lines.next().ok_or_else(|| cut_short(text, vertices, "vertices", done))?;
        let row = numbers(values, at)?;
        let [x, y, z, ..] = row[..] else {
            return Err(Fault::at_line(at, "a vertex needs three coordinates"));
        };
        let point = Point3::new(x, y, z);
        raw.points.push(match row.get(3) {
            Some(w) if layout.is_homogeneous => point / *w,
            _ => point,
        });
        if let Some(&[x, y, z, ..]) = row.get(layout.normal_column()..).filter(|_| layout.has_normals) {
            normals.push([x, y, z].map(|v| v as f32));
        }
        if let Some(&[r, g, b, ..]) = row.get(layout.color_column()..).filter(|_| layout.has_colors) {
            colors.push([r, g, b].map(|v| v as f32));
        }
    }
    for done in 0..faces {
        let (at, values) = lines.next().ok_or_else(|| cut_short(text, faces, "faces", done))?;
        polygon(values, at, &mut raw)?;
    }
    let count = raw.points.len();
    if colors.len() == count {
        raw.attributes.colors = columns::colors(&colors, false, &mut raw.notes);
    }
    raw.attributes.normals = Some(normals).filter(|n| n.len() == count).and_then(columns::normals);
    Ok(raw)
}

fn cut_short(text: &str, announced: u64, what: &str, found: u64) -> Fault {
    let last = lines(text).last().map_or(1, |(n, _)| n);
    let problem =
        format!("{announced} {what} are announced, but there are {found}; the file may have been cut short");
    Fault::at_line(last, problem)
}

fn numbers(values: &str, line: usize) -> Result<Vec<f64>, Fault> {
    let value = |w| number(w).ok_or_else(|| Fault::at_line(line, format!("{} is not a number", quoted(w))));
    values.split_whitespace().map(value).collect()
}

/// A polygon becomes a fan around its first corner; what comes after the
/// corners is its colour.
fn polygon(values: &str, line: usize, raw: &mut Raw) -> Result<(), Fault> {
    let mut words = values.split_whitespace();
    let mut index = || {
        let word =
            words.next().ok_or_else(|| Fault::at_line(line, "the face has fewer corners than it says"))?;
        word.parse::<i64>()
            .map_err(|_| Fault::at_line(line, format!("{} is not the index of a vertex", quoted(word))))
    };
    let corners = index()?;
    let (mut fan, mut in_range) = (Vec::new(), true);
    for _ in 0..corners {
        let i = index()?;
        let valid = usize::try_from(i).is_ok_and(|i| i < raw.points.len());
        in_range &= valid;
        fan.push(u32::try_from(i).unwrap_or_default());
    }
    if !in_range {
        raw.faces_out_of_range += 1;
    } else if let [first, rest @ ..] = &fan[..] {
        raw.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
    }
    Ok(())
}
