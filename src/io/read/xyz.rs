//! XYZ text: one point per line, in the many dialects of .xyz, .txt, .csv and .pts.
//!
//! Parsed here because table crates need separators and columns in advance, and none supports
//! decimal commas or the count line of PTS.

use std::collections::HashMap;

use nalgebra::Point3;
use rayon::prelude::*;

use super::columns::{self, Color, Nameless, Roles};
use super::raw::Raw;
use super::text::{self, counted, lines, number, plain_number, quoted};
use crate::io::error::Fault;
use crate::io::shape::Attributes;

/// How numbers and columns are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Dialect {
    /// `1.5, 2.5, 3.5`: columns parted by blanks, commas or semicolons.
    Point,
    /// `1,5; 2,5; 3,5`: decimal commas, columns parted by blanks or semicolons.
    Comma,
}

impl Dialect {
    /// Told from one line of data.
    fn of(line: &str) -> Self {
        let mut columns =
            line.split(|c: char| matches!(c, ';' | '|') || c.is_whitespace()).filter(|t| !t.is_empty());
        let mut decimal = 0;
        let comma = columns.clone().count() >= 3
            && columns.all(|t| {
                let inner = t.trim_matches(|c: char| !c.is_ascii_digit());
                decimal += usize::from(inner.contains(','));
                !t.contains('.')
                    && t.matches(',').count() == inner.matches(',').count()
                    && inner.matches(',').count() <= 1
            });
        if comma && decimal > 0 { Self::Comma } else { Self::Point }
    }

    /// The columns of a line. Where a comma, a semicolon, a bar or (by choice) a
    /// tab parts them, they may be quoted, or empty.
    fn columns(self, line: &str, tabs: bool) -> Vec<&str> {
        let separator = if line.contains(';') {
            ';'
        } else if line.contains('|') {
            '|'
        } else if self == Self::Point && line.contains(',') {
            ','
        } else if tabs && line.contains('\t') {
            '\t'
        } else {
            return line.split_whitespace().collect();
        };
        let mut fields = Vec::new();
        let mut quote = None;
        let mut start = 0;
        for (at, c) in line.char_indices() {
            match quote {
                Some(q) if c == q => quote = None,
                Some(_) => {}
                None if c == '"' => quote = Some(c),
                None if c == separator => {
                    fields.push(&line[start..at]);
                    start = at + 1;
                }
                None => {}
            }
        }
        // What a separator at the end parts from nothing is no column.
        if !line[start..].trim().is_empty() {
            fields.push(&line[start..]);
        }
        let mut columns = Vec::with_capacity(fields.len());
        for field in fields {
            match field.trim() {
                "" => columns.push(""),
                // Blanks may part numbers, too, but not the words of a name.
                text if separator != '\t' && text.split_whitespace().all(|t| self.value(t).is_some()) => {
                    columns.extend(text.split_whitespace());
                }
                text => columns.push(text),
            }
        }
        columns
    }

    /// A number; NaN for what is left empty.
    fn value(self, token: &str) -> Option<f64> {
        let token = unquoted(token);
        match self {
            _ if token.is_empty() => Some(f64::NAN),
            Self::Point => number(token),
            Self::Comma => number(&token.replace(',', ".")),
        }
    }
}

/// A token without quotes, or the brackets of a printed list.
fn unquoted(token: &str) -> &str {
    token.trim_matches(|c: char| matches!(c, '"' | '\'' | '[' | ']' | '(' | ')') || c.is_whitespace())
}

/// Whether a line contains at least three numbers and nothing else.
pub(super) fn is_data(line: &str) -> bool {
    let dialect = Dialect::of(line);
    let columns = dialect.columns(line, false);
    let mut numbers = columns.iter().filter(|t| !t.is_empty());
    numbers.clone().count() >= 3 && numbers.all(|t| dialect.value(t).is_some())
}

/// Whether a line names columns, x, y and z among them.
pub(super) fn names_columns(line: &str) -> bool {
    Names::of(line).is_some()
}

/// A line of names.
#[derive(Debug, Clone)]
struct Names {
    roles: Roles,
    /// Whether tabs part its columns.
    tabs: bool,
}

impl Names {
    fn of(line: &str) -> Option<Self> {
        let line = line.trim_start_matches(['#', '/', ' ', '\u{feff}']).trim_end();
        let tabs = line.contains('\t') && !line.contains([',', ';']);
        let names = Dialect::Point.columns(line, tabs);
        let names: Vec<String> = names.iter().map(|t| unquoted(t).to_lowercase()).collect();
        Roles::of(&names).map(|roles| Self { roles, tabs })
    }
}

/// Which columns are kept.
#[derive(Debug)]
struct Layout {
    position: [usize; 3],
    /// Beside the coordinates.
    rest: Vec<usize>,
    named: Option<Roles>,
}

/// Columns that are looked at where they have no names.
const WIDEST: usize = 16;

impl Layout {
    /// Without names: x y z, then columns recognised by their values.
    fn by_position(count: usize) -> Self {
        Self { position: [0, 1, 2], rest: (3..count.clamp(3, WIDEST)).collect(), named: None }
    }

    fn by_name(roles: Roles) -> Self {
        let mut rest: Vec<usize> = roles.normal.into_iter().flatten().collect();
        match roles.color {
            Some(Color::Channels(columns)) => rest.extend(columns),
            Some(Color::Packed(column)) => rest.push(column),
            None => {}
        }
        rest.extend(roles.label);
        Self { position: roles.position, rest, named: Some(roles) }
    }

    /// What the values of the kept columns say, row by row.
    fn attributes(
        &self,
        values: &[f64],
        words: &[String],
        scalars_first: bool,
        notes: &mut Vec<String>,
    ) -> Attributes {
        let width = self.rest.len();
        let Some(roles) = self.named else {
            return Nameless { values, width, scalars_first }.attributes(notes);
        };
        if width == 0 {
            return Attributes::default();
        }
        let rows = || values.chunks_exact(width);
        // In the order in which `by_name` put them.
        let mut at = 0;
        let mut found = Attributes::default();
        let triples =
            |at: usize| rows().map(|row| [row[at], row[at + 1], row[at + 2]].map(|v| v as f32)).collect();
        if roles.normal.is_some() {
            found.normals = columns::normals(triples(at));
            at += 3;
        }
        match roles.color {
            Some(Color::Channels(_)) => {
                found.colors = columns::colors(&triples(at), false, notes);
                at += 3;
            }
            Some(Color::Packed(_)) => {
                let bytes = |bits: u32| [16, 8, 0].map(|shift| (bits >> shift & 0xff) as u8);
                found.colors = Some(rows().map(|row| bytes(columns::packed_bits(row[at]))).collect());
                at += 1;
            }
            None => {}
        }
        if roles.label.is_some() && words.len() == rows().len() {
            found.labels = Some(numbered(words, notes));
        } else if roles.label.is_some() {
            let labels: Vec<f64> = rows().map(|row| row[at]).collect();
            found.labels = columns::labels(&labels, notes);
        }
        found
    }
}

/// Numbers for labels that are words, in the order of their first appearance.
fn numbered(words: &[String], notes: &mut Vec<String>) -> Vec<i64> {
    const MOST_SHOWN: usize = 12;
    let mut numbers: HashMap<&str, i64> = HashMap::new();
    let mut shown = Vec::new();
    let mut labels = Vec::with_capacity(words.len());
    for word in words {
        let next = numbers.len() as i64;
        let label = *numbers.entry(word).or_insert(next);
        if label == next && shown.len() < MOST_SHOWN {
            shown.push(format!("{label} {}", quoted(word)));
        }
        labels.push(label);
    }
    let more = if numbers.len() > shown.len() { ", …" } else { "" };
    notes.push(format!("labels are words and were numbered: {}{more}", shown.join(", ")));
    labels
}

/// Parses the text. Blank lines and comments (`#`, `//`) are skipped, a first
/// line of names is used, a first line with nothing but the count too.
pub(super) fn parse(text: &str) -> Result<Raw, Fault> {
    let head = Head::of(text);
    let parts: Vec<Result<Part, Fault>> = text::pieces(&text[head.length..], text::PIECE)
        .into_par_iter()
        .map(|piece| head.part(piece))
        .collect();
    let mut raw = Raw::default();
    let (mut rest, mut words) = (Vec::new(), Vec::new());
    let (mut line, mut incomplete, mut announced) = (head.lines, 0, head.announced);
    raw.points.reserve_exact(parts.iter().flatten().map(|part| part.points.len()).sum());
    rest.reserve_exact(parts.iter().flatten().map(|part| part.rest.len()).sum());
    for part in parts {
        let part = part.map_err(|fault| fault.after_lines(line))?;
        line += part.lines;
        incomplete += part.incomplete;
        announced = announced.map(|n| n.saturating_add(part.announced));
        raw.points.extend(part.points);
        rest.extend(part.rest);
        words.extend(part.words);
    }
    if raw.points.is_empty() {
        return Err(Fault::whole("it has no points; write one point per line as x y z"));
    }
    if head.degrees {
        raw.notes.push(columns::DEGREES.to_owned());
    }
    if head.has_other_names {
        raw.notes.push("no columns are named x, y and z; the first three were used".to_owned());
    }
    if incomplete == 0 {
        raw.attributes = head.layout.attributes(&rest, &words, announced.is_some(), &mut raw.notes);
    } else {
        let lines = counted(incomplete, "line has", "lines have");
        raw.notes.push(format!("{lines} fewer columns than the first; only coordinates were read"));
    }
    if let Some(count) = announced.filter(|&n| n != raw.points.len()) {
        raw.notes.push(format!("the first line declares {count} points, but there are {}", raw.points.len()));
    }
    Ok(raw)
}

/// A line without what surrounds its text, and without a comment at its end.
fn trimmed(line: &str) -> &str {
    let end = line.find('#').filter(|at| !line[..*at].trim().is_empty()).unwrap_or(line.len());
    line[..end].trim_matches(|c: char| c.is_whitespace() || c == '\u{feff}' || c == '\0' || c == '\u{1a}')
}

fn is_comment(line: &str) -> bool {
    line.starts_with('#') || line.starts_with("//")
}

/// The lines before the data, and the layout of the data.
#[derive(Debug)]
struct Head {
    /// Bytes and lines.
    length: usize,
    lines: usize,
    announced: Option<usize>,
    /// Whether names were passed over that are not known.
    has_other_names: bool,
    /// Whether columns are named longitude and latitude.
    degrees: bool,
    dialect: Dialect,
    /// Whether tabs part columns, so that these may be empty.
    tabs: bool,
    layout: Layout,
}

impl Head {
    fn of(text: &str) -> Self {
        let mut named: Option<Names> = None;
        let mut announced: Option<usize> = None;
        let (mut rows, mut has_other_names, mut degrees) = (0, false, false);
        for (line_number, whole) in lines(text) {
            let line = trimmed(whole);
            if is_comment(line) {
                named = named.or_else(|| Names::of(line));
                continue;
            }
            if line.is_empty() {
                continue;
            }
            rows += 1;
            if rows <= 3 && !is_data(line) {
                if let Ok(count) = line.parse::<usize>() {
                    announced = Some(count);
                    continue;
                }
                let names = Names::of(line);
                let has_numbers =
                    || Dialect::Point.columns(line, false).iter().any(|t| number(unquoted(t)).is_some());
                // Below names there may be units; above them, a title.
                let is_text =
                    (rows == 1 || named.is_some()) && line.chars().any(char::is_alphabetic) && !has_numbers();
                if names.is_some() || is_text {
                    let words = Dialect::Point.columns(line, false);
                    has_other_names |= words.len() >= 3;
                    let words: Vec<String> = words.iter().map(|t| unquoted(t).to_lowercase()).collect();
                    degrees |= columns::name_degrees(&words);
                    named = names.or(named);
                    continue;
                }
            }
            let dialect = Dialect::of(line);
            let tabs = named.as_ref().is_some_and(|names| names.tabs);
            let layout = match &named {
                Some(names) => Layout::by_name(names.roles),
                None => Layout::by_position(dialect.columns(line, tabs).len()),
            };
            // How far into the text this line starts.
            let length = whole.as_ptr() as usize - text.as_ptr() as usize;
            let has_other_names = has_other_names && named.is_none();
            let degrees = named.as_ref().map_or(degrees, |names| names.roles.degrees);
            return Self {
                length,
                lines: line_number - 1,
                announced,
                has_other_names,
                degrees,
                dialect,
                tabs,
                layout,
            };
        }
        let (dialect, layout) = (Dialect::Point, Layout::by_position(3));
        let length = text.len();
        Self { length, lines: 0, announced, has_other_names, degrees, dialect, tabs: false, layout }
    }

    /// The points of a piece of text that ends with a line.
    fn part(&self, piece: &str) -> Result<Part, Fault> {
        let mut part = Part::default();
        let mut values = Vec::new();
        for (line_number, line) in lines(piece) {
            part.lines = line_number;
            if !(self.dialect == Dialect::Point && self.plain_row(line.as_bytes(), &mut values)) {
                if trimmed(line).is_empty() || is_comment(trimmed(line)) {
                    continue;
                }
                // A tab at the start may part an empty column from the next.
                let line = if self.tabs { line } else { trimmed(line) };
                part.words.extend(self.row(line, line_number, &mut values)?);
            }
            if let ([count], Some(_)) = (&values[..], self.announced)
                && count.fract() == 0.0
            {
                // PTS of several scans has a count before each.
                part.announced = part.announced.saturating_add(*count as usize);
                continue;
            }
            let Some(position) = pick(&values, self.layout.position) else {
                let found = counted(values.len(), "column", "columns");
                let problem = format!("{found}, but a point needs three coordinates");
                return Err(Fault::at_line(line_number, problem));
            };
            part.points.push(Point3::from(position));
            if self.layout.rest.iter().all(|&column| column < values.len()) {
                part.rest.extend(self.layout.rest.iter().map(|&column| values[column]));
            } else {
                part.incomplete += 1;
            }
        }
        // What follows the last ending is the next piece's first line.
        part.lines -= usize::from(piece.ends_with(['\n', '\r']));
        Ok(part)
    }

    /// The values of a line in any dialect; also its label, if that is a word.
    fn row(&self, line: &str, line_number: usize, values: &mut Vec<f64>) -> Result<Option<String>, Fault> {
        let label = self.layout.named.and_then(|roles| roles.label);
        let mut word = None;
        values.clear();
        for token in self.dialect.columns(line, self.tabs) {
            let value = self.dialect.value(token);
            // Words in columns that aren't used (names of classes, say) do no harm.
            if value.is_none() && self.layout.position.contains(&values.len()) {
                return Err(not_a_number(line_number, token));
            }
            if value.is_none() && label == Some(values.len()) {
                word = Some(unquoted(token).to_owned());
            }
            values.push(value.unwrap_or(f64::NAN));
        }
        Ok(word)
    }

    /// The values of a line of plain numbers, parted by blanks, commas or
    /// semicolons; `false` for a line with anything else, without a value, or
    /// with an empty column.
    fn plain_row(&self, line: &[u8], values: &mut Vec<f64>) -> bool {
        values.clear();
        // Whether a separator has been seen that a column must follow.
        let mut is_open = true;
        let mut rest = line;
        while let [first, tail @ ..] = rest {
            match first {
                b',' | b';' if is_open => return false,
                b'\t' if self.tabs && is_open => return false,
                b',' | b';' => (is_open, rest) = (true, tail),
                b'\t' if self.tabs => (is_open, rest) = (true, tail),
                b' ' | b'\t' => rest = tail,
                _ => {
                    let end = rest.iter().position(|b| matches!(b, b' ' | b'\t' | b',' | b';'));
                    let (token, tail) = rest.split_at(end.unwrap_or(rest.len()));
                    match plain_number(token) {
                        Some(value) => values.push(value),
                        None => return false,
                    }
                    (is_open, rest) = (false, tail);
                }
            }
        }
        !values.is_empty()
    }
}

/// Content of a piece of the text.
#[derive(Debug, Default)]
struct Part {
    points: Vec<Point3<f64>>,
    /// Further columns, for the rows that have them.
    rest: Vec<f64>,
    incomplete: usize,
    /// Labels that are no numbers.
    words: Vec<String>,
    /// Points that counts in between announce.
    announced: usize,
    /// Line endings.
    lines: usize,
}

fn not_a_number(line: usize, token: &str) -> Fault {
    let hint = if token.contains(',') { "; write numbers with a decimal point" } else { "" };
    Fault::at_line(line, format!("{} is not a number{hint}", quoted(token)))
}

fn pick(values: &[f64], columns: [usize; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = columns.map(|i| values.get(i).copied());
    Some([a?, b?, c?])
}
