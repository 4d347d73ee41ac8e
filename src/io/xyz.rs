//! XYZ text: one point a line, in the many dialects of .xyz, .txt, .csv, .pts.

use nalgebra::Point3;

use super::error::Fault;
use super::raw::Raw;
use super::text::{counted, lines, number, quoted};

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
    let mut raw = Raw::default();
    let mut colors: Vec<[u8; 3]> = Vec::new();
    let mut layout: Option<(Dialect, Columns)> = None;
    let mut named: Option<Columns> = None;
    let mut announced: Option<usize> = None;
    let mut rows = 0;
    let mut values: Vec<f64> = Vec::new();

    for (line_number, line) in lines(text) {
        let line =
            line.trim_matches(|c: char| c.is_whitespace() || c == '\u{feff}' || c == '\0' || c == '\u{1a}');
        if line.starts_with('#') || line.starts_with("//") {
            named = named.or_else(|| Columns::by_name(line));
            continue;
        }
        if line.is_empty() {
            continue;
        }
        rows += 1;
        if layout.is_none() && rows == 1 && !is_data(line) {
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
        let (dialect, columns) = *layout.get_or_insert_with(|| {
            let dialect = Dialect::of(line);
            (dialect, named.unwrap_or_else(|| Columns::by_position(dialect.columns(line).count())))
        });
        values.clear();
        for token in dialect.columns(line) {
            let value = dialect.value(token);
            // Words in columns that aren't used (names of classes, say) do no harm.
            if value.is_none() && columns.position.contains(&values.len()) {
                return Err(not_a_number(line_number, token));
            }
            values.push(value.unwrap_or(f64::NAN));
        }
        let Some(position) = pick(&values, columns.position) else {
            let found = counted(values.len(), "column", "columns");
            return Err(Fault::at_line(line_number, format!("{found}, but a point needs three coordinates")));
        };
        raw.points.push(Point3::from(position));
        if let Some(color) = columns.color.and_then(|c| pick(&values, c)).and_then(color_of_bytes) {
            colors.push(color);
        }
    }
    if raw.points.is_empty() {
        return Err(Fault::whole("it has no points; there should be one a line, as x y z"));
    }
    if colors.len() == raw.points.len() && colors.iter().flatten().any(|&c| c > 1) {
        raw.colors = Some(colors);
    }
    if let Some(count) = announced.filter(|&n| n != raw.points.len()) {
        raw.notes
            .push(format!("the first line announces {count} points, but there are {}", raw.points.len()));
    }
    Ok(raw)
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
