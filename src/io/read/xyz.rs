//! XYZ text: one point a line, in the many dialects of .xyz, .txt, .csv, .pts.

use nalgebra::Point3;
use rayon::prelude::*;

use super::raw::Raw;
use super::text::{self, counted, lines, number, plain_number, quoted};
use crate::io::error::Fault;

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
        let mut columns = line.split(|c: char| c == ';' || c.is_whitespace()).filter(|t| !t.is_empty());
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

    fn columns(self, line: &str) -> impl Iterator<Item = &str> {
        line.split(move |c: char| c.is_whitespace() || c == ';' || (self == Self::Point && c == ','))
            .filter(|t| !t.is_empty())
    }

    fn value(self, token: &str) -> Option<f64> {
        match self {
            Self::Point => number(token),
            Self::Comma => number(&token.replace(',', ".")),
        }
    }
}

/// Whether a line holds at least three numbers and nothing else.
pub(super) fn is_data(line: &str) -> bool {
    let dialect = Dialect::of(line);
    let mut count = 0;
    dialect.columns(line).all(|t| {
        count += 1;
        dialect.value(t).is_some()
    }) && count >= 3
}

/// Which columns hold what.
#[derive(Debug, Clone, Copy)]
struct Columns {
    position: [usize; 3],
    /// Columns that may hold colours from 0 to 255; kept only if all rows do.
    color: Option<[usize; 3]>,
}

impl Columns {
    /// Without names: x y z, then r g b where there are six columns, or
    /// intensity r g b where there are seven.
    fn by_position(count: usize) -> Self {
        let color = match count {
            6 => Some([3, 4, 5]),
            7 => Some([4, 5, 6]),
            _ => None,
        };
        Self { position: [0, 1, 2], color }
    }

    /// From a header line, if it names x, y and z.
    fn by_name(header: &str) -> Option<Self> {
        let names: Vec<String> = header
            .trim_start_matches(['#', '/', ' '])
            .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .filter(|t| !t.is_empty())
            .map(|t| t.trim_matches(['"', '\'']).to_ascii_lowercase())
            .collect();
        let find = |wanted: [&[&str]; 3]| -> Option<[usize; 3]> {
            let at = |w: &[&str]| names.iter().position(|n| w.contains(&n.as_str()));
            Some([at(wanted[0])?, at(wanted[1])?, at(wanted[2])?])
        };
        let position = find([&["x", "px", "x_m"], &["y", "py", "y_m"], &["z", "pz", "z_m"]])?;
        let color = find([&["r", "red"], &["g", "green"], &["b", "blue"]]);
        Some(Self { position, color })
    }
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
    let mut colors: Vec<[u8; 3]> = Vec::new();
    let mut line = head.lines;
    raw.points.reserve_exact(parts.iter().flatten().map(|part| part.points.len()).sum());
    for part in parts {
        let part = part.map_err(|fault| fault.after_lines(line))?;
        line += part.lines;
        raw.points.extend(part.points);
        colors.extend(part.colors);
    }
    if raw.points.is_empty() {
        return Err(Fault::whole("it has no points; there should be one a line, as x y z"));
    }
    if colors.len() == raw.points.len() && colors.iter().flatten().any(|&c| c > 1) {
        raw.attributes.colors = Some(colors);
    }
    if let Some(count) = head.announced.filter(|&n| n != raw.points.len()) {
        raw.notes
            .push(format!("the first line announces {count} points, but there are {}", raw.points.len()));
    }
    Ok(raw)
}

/// A line without what surrounds its text.
fn trimmed(line: &str) -> &str {
    line.trim_matches(|c: char| c.is_whitespace() || c == '\u{feff}' || c == '\0' || c == '\u{1a}')
}

fn is_comment(line: &str) -> bool {
    line.starts_with('#') || line.starts_with("//")
}

/// What stands before the first line of data, and how it is laid out.
#[derive(Debug)]
struct Head {
    /// Bytes and lines.
    length: usize,
    lines: usize,
    announced: Option<usize>,
    dialect: Dialect,
    columns: Columns,
}

impl Head {
    fn of(text: &str) -> Self {
        let mut named: Option<Columns> = None;
        let mut announced: Option<usize> = None;
        let mut rows = 0;
        for (line_number, whole) in lines(text) {
            let line = trimmed(whole);
            if is_comment(line) {
                named = named.or_else(|| Columns::by_name(line));
                continue;
            }
            if line.is_empty() {
                continue;
            }
            rows += 1;
            if rows == 1 && !is_data(line) {
                if let Ok(count) = line.parse::<usize>() {
                    announced = Some(count);
                    continue;
                }
                if line.chars().any(char::is_alphabetic)
                    && Dialect::Point.columns(line).all(|t| number(t).is_none())
                {
                    named = Columns::by_name(line);
                    continue;
                }
            }
            let dialect = Dialect::of(line);
            let columns = named.unwrap_or_else(|| Columns::by_position(dialect.columns(line).count()));
            // How far into the text this line starts.
            let length = whole.as_ptr() as usize - text.as_ptr() as usize;
            return Self { length, lines: line_number - 1, announced, dialect, columns };
        }
        let (dialect, columns) = (Dialect::Point, Columns::by_position(3));
        Self { length: text.len(), lines: 0, announced, dialect, columns }
    }

    /// The points of a piece of text that ends with a line.
    fn part(&self, piece: &str) -> Result<Part, Fault> {
        let mut part = Part::default();
        let mut values = Vec::new();
        for (line_number, line) in lines(piece) {
            part.lines = line_number;
            if !(self.dialect == Dialect::Point && plain_row(line.as_bytes(), &mut values)) {
                let line = trimmed(line);
                if line.is_empty() || is_comment(line) {
                    continue;
                }
                self.row(line, line_number, &mut values)?;
            }
            let Some(position) = pick(&values, self.columns.position) else {
                let found = counted(values.len(), "column", "columns");
                let problem = format!("{found}, but a point needs three coordinates");
                return Err(Fault::at_line(line_number, problem));
            };
            part.points.push(Point3::from(position));
            if let Some(color) = self.columns.color.and_then(|c| pick(&values, c)).and_then(color_of_bytes) {
                part.colors.push(color);
            }
        }
        // What follows the last ending is the next piece's first line.
        part.lines -= usize::from(piece.ends_with(['\n', '\r']));
        Ok(part)
    }

    /// The values of a line in any dialect.
    fn row(&self, line: &str, line_number: usize, values: &mut Vec<f64>) -> Result<(), Fault> {
        values.clear();
        for token in self.dialect.columns(line) {
            let value = self.dialect.value(token);
            // Words in columns that aren't used (names of classes, say) do no harm.
            if value.is_none() && self.columns.position.contains(&values.len()) {
                return Err(not_a_number(line_number, token));
            }
            values.push(value.unwrap_or(f64::NAN));
        }
        Ok(())
    }
}

/// What a piece of text holds.
#[derive(Debug, Default)]
struct Part {
    points: Vec<Point3<f64>>,
    colors: Vec<[u8; 3]>,
    /// Line endings.
    lines: usize,
}

/// The values of a line of plain numbers, parted by blanks, commas or
/// semicolons; `false` for a line with anything else, or without a value.
fn plain_row(line: &[u8], values: &mut Vec<f64>) -> bool {
    values.clear();
    let tokens = line.split(|b| matches!(b, b' ' | b'\t' | b',' | b';')).filter(|token| !token.is_empty());
    for token in tokens {
        match plain_number(token) {
            Some(value) => values.push(value),
            None => return false,
        }
    }
    !values.is_empty()
}

fn not_a_number(line: usize, token: &str) -> Fault {
    let hint = if token.contains(',') { "; write numbers with a decimal point" } else { "" };
    Fault::at_line(line, format!("{} is not a number{hint}", quoted(token)))
}

fn pick(values: &[f64], columns: [usize; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = columns.map(|i| values.get(i).copied());
    Some([a?, b?, c?])
}

/// A colour whose channels are whole numbers from 0 to 255.
fn color_of_bytes(values: [f64; 3]) -> Option<[u8; 3]> {
    values.iter().all(|v| v.fract() == 0.0 && (0.0..=255.0).contains(v)).then(|| values.map(|v| v as u8))
}
