//! OFF (Geomview object files): vertices with normals and colours, then polygons, as text.

use std::str::SplitWhitespace;

use nalgebra::Point3;

use super::columns;
use super::raw::Raw;
use super::text::{lines, number, quoted};
use crate::io::error::Fault;

/// What the first word says of the vertices: `[ST][C][N][4]OFF`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Layout {
    has_texture: bool,
    has_colors: bool,
    has_normals: bool,
    is_homogeneous: bool,
}

impl Layout {
    fn of(word: &str) -> Option<Self> {
        let word = word.to_ascii_uppercase();
        let rest = word.strip_suffix("OFF")?;
        let (has_texture, rest) = strip(rest, "ST");
        let (has_colors, rest) = strip(rest, "C");
        let (has_normals, rest) = strip(rest, "N");
        let (is_homogeneous, rest) = strip(rest, "4");
        rest.is_empty().then_some(Self { has_texture, has_colors, has_normals, is_homogeneous })
    }

    /// The column at which the colour begins.
    fn color_column(self) -> usize {
        self.normal_column() + if self.has_normals { 3 } else { 0 }
    }

    fn normal_column(self) -> usize {
        3 + usize::from(self.is_homogeneous)
    }

    /// Numbers of a vertex.
    fn width(self) -> usize {
        self.color_column() + if self.has_colors { 4 } else { 0 } + if self.has_texture { 2 } else { 0 }
    }

    /// The layout that a first word tells, and the rest of that word: some
    /// programs write the counts without a blank in between (`OFF8 12 0`).
    fn leading(word: &str) -> Option<(Self, &str)> {
        let (name, rest) = word.split_at(word.to_ascii_uppercase().find("OFF")? + 3);
        let is_count = rest.bytes().all(|b| b.is_ascii_digit());
        let is_spatial = !has_n_dimensions(name);
        Some((Self::of(name).filter(|_| is_count && is_spatial)?, rest))
    }
}

fn strip<'a>(text: &'a str, prefix: &str) -> (bool, &'a str) {
    text.strip_prefix(prefix).map_or((false, text), |rest| (true, rest))
}

/// Whether a first word announces vertices of any number of coordinates: a
/// small n, while a large one announces normals.
fn has_n_dimensions(word: &str) -> bool {
    ["nOFF", "4nOFF"].iter().any(|name| word.ends_with(name))
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
    first.is_some_and(|word| Layout::leading(word).is_some() || has_n_dimensions(word))
}

/// Whether a text begins with a point, which no OFF file does.
pub(super) fn is_points(text: &str) -> bool {
    let first = content(text).next().and_then(|(_, line)| line.split_whitespace().next());
    first.is_some_and(|word| number(word).is_some()) && !is_bare(text)
}

/// Whether a text begins as an OFF file without its first word does: with two
/// or three counts.
fn is_bare(text: &str) -> bool {
    let counts = content(text).next().map_or("", |(_, line)| line).split_whitespace();
    let counts: Option<Vec<u64>> = counts.map(|word| word.parse().ok()).collect();
    counts.is_some_and(|counts| (2..=3).contains(&counts.len()) && counts[0] > 0)
}

/// The words of a file. An element is a line, and what is left on it no part
/// of the next one; only where the lines are too few do they run on.
struct Words<'a> {
    lines: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    line: usize,
    words: SplitWhitespace<'a>,
    /// Lines with something on them that were begun.
    begun: usize,
    run_on: bool,
}

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Self {
        let mut words = Self {
            lines: Box::new(content(text)),
            line: 1,
            words: "".split_whitespace(),
            begun: 0,
            run_on: false,
        };
        words.next_line();
        words
    }

    /// Advances to the next line; `false` at the end.
    fn next_line(&mut self) -> bool {
        let Some((number, line)) = self.lines.next() else { return false };
        (self.line, self.words) = (number, line.split_whitespace());
        self.begun += 1;
        true
    }

    /// Goes to where the next element begins.
    fn begin(&mut self) -> bool {
        self.run_on && self.words.clone().next().is_some() || self.next_line()
    }

    /// The next word of an element.
    fn next(&mut self) -> Option<&'a str> {
        loop {
            let word = self.words.next();
            if word.is_some() || !self.run_on || !self.next_line() {
                return word;
            }
        }
    }

    fn fault(&self, problem: impl Into<String>) -> Fault {
        Fault::at_line(self.line, problem)
    }

    /// The counts of vertices and faces, of which the first word may be read
    /// already. That of edges may be missing, and each may have its own line.
    fn counts(&mut self, first: &str) -> Result<[u64; 2], Fault> {
        let mut counts: Vec<&str> = Some(first).filter(|word| !word.is_empty()).into_iter().collect();
        let mut on_line = counts.len();
        while counts.len() < 3 {
            match self.words.next() {
                Some(word) => {
                    counts.push(word);
                    on_line += 1;
                }
                None if counts.len() == 2 && on_line == 2 => break,
                None if self.next_line() => on_line = 0,
                None => return Err(self.fault("the counts of vertices and faces are missing")),
            }
        }
        let count = |word: &str| {
            let problem = || self.fault(format!("{} is not a number of vertices or faces", quoted(word)));
            word.parse::<u64>().map_err(|_| problem())
        };
        Ok([count(counts[0])?, count(counts[1])?])
    }
}

pub(super) fn parse(text: &str) -> Result<Raw, Fault> {
    let mut words = Words::new(text);
    let first = words.next().unwrap_or_default();
    let (layout, glued) = match Layout::leading(first) {
        Some(leading) => leading,
        None if is_bare(text) => (Layout::default(), first),
        None if has_n_dimensions(first) => {
            let what = "starts an n-dimensional mesh, which cannot be read; save it as OFF";
            return Err(words.fault(format!("{} {what}", quoted(first))));
        }
        None => {
            let what = "does not start a three-dimensional OFF mesh; export the mesh again";
            return Err(words.fault(format!("{} {what}", quoted(first))));
        }
    };
    if words.words.clone().next().is_some_and(|word| word.eq_ignore_ascii_case("binary")) {
        return Err(words.fault("binary OFF meshes cannot be read; save it as text"));
    }
    let [vertices, faces] = words.counts(glued)?;
    let lines_left = content(text).count() - words.begun;
    if (lines_left as u64) < vertices.saturating_add(faces) {
        let rest = content(text).skip(words.begun).flat_map(|(_, line)| line.split_whitespace());
        let left = words.words.clone().chain(rest).count() as u64;
        // A face has three corners at the least.
        let needed = vertices.saturating_mul(layout.width() as u64).saturating_add(faces.saturating_mul(4));
        words.run_on = left >= needed;
    }

    // Nothing is set aside for what is only announced.
    let mut raw = Raw::default();
    let (mut colors, mut normals) = (Vec::new(), Vec::new());
    let mut row = Vec::new();
    for done in 0..vertices {
        if !words.begin() {
            return Err(cut_short(text, vertices, "vertices", done));
        }
        row.clear();
        while !(words.run_on && row.len() == layout.width())
            && let Some(word) = words.next()
        {
            let value = number(word);
            row.push(value.ok_or_else(|| words.fault(format!("{} is not a number", quoted(word))))?);
        }
        let [x, y, z, ..] = row[..] else { return Err(words.fault("a vertex needs three coordinates")) };
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
    let mut corners = Vec::new();
    for done in 0..faces {
        if !words.begin() {
            return Err(cut_short(text, faces, "faces", done));
        }
        polygon(&mut words, &mut corners, &mut raw)?;
    }
    if words.run_on && words.next().is_some() {
        let problem = "there is more data than the counts declare; put each vertex and each face on its own \
             line";
        return Err(words.fault(problem));
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
        format!("{announced} {what} are declared, but there are {found}; the file may be truncated");
    Fault::at_line(last, problem)
}

/// What comes after the corners on a line is the colour of the face.
fn polygon(words: &mut Words<'_>, corners: &mut Vec<u32>, raw: &mut Raw) -> Result<(), Fault> {
    let word = words.next().unwrap_or_default();
    let count: u64 =
        word.parse().map_err(|_| words.fault(format!("{} is not a number of corners", quoted(word))))?;
    let mut in_range = true;
    corners.clear();
    for _ in 0..count {
        let word = words.next().ok_or_else(|| words.fault("the face has fewer corners than declared"))?;
        let index: i64 = word
            .parse()
            .map_err(|_| words.fault(format!("{} is not the index of a vertex", quoted(word))))?;
        in_range &= usize::try_from(index).is_ok_and(|i| i < raw.points.len());
        corners.push(u32::try_from(index).unwrap_or_default());
    }
    if in_range {
        raw.polygon(corners);
    } else {
        raw.faces_out_of_range += 1;
    }
    Ok(())
}
