//! Manifests: lists of jobs as CSV with a header, or as JSON lines.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::names::nested;
use crate::cli::settings::{key, keys};

/// One job of a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Line {
    /// Position in the list, for messages; empty for inputs on the command line.
    pub(super) place: String,
    pub(super) input: PathBuf,
    pub(super) name: Option<String>,
    /// Its own settings: names of options, and values as text.
    pub(super) settings: Vec<(&'static str, String)>,
}

impl Line {
    /// A file of the command line.
    pub(super) fn of(input: PathBuf) -> Self {
        Self { place: String::new(), input, name: None, settings: Vec::new() }
    }
}

/// Meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Input,
    Name,
    Setting(&'static str),
}

impl Column {
    fn named(text: &str) -> Option<Self> {
        match text.trim().to_lowercase().as_str() {
            "input" => Some(Self::Input),
            "name" => Some(Self::Name),
            other => key(other).map(Self::Setting),
        }
    }
}

/// Reads a list. Paths in it are relative to it.
///
/// # Errors
/// One sentence with the line and the column.
pub(super) fn read(path: &Path) -> Result<Vec<Line>, String> {
    let shown = path.display();
    let bytes = fs::read(path).map_err(|e| format!("cannot read the manifest {shown}: {e}"))?;
    let text = std::str::from_utf8(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes)).map_err(|e| {
        let line = bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
        format!("{shown}, line {line}: not UTF-8 text; save the manifest as UTF-8")
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut builder = Builder { shown: shown.to_string(), folder, lines: Vec::new(), names: HashMap::new() };
    match text.trim_start().chars().next() {
        Some('{') => builder.json_lines(text)?,
        Some('[') => {
            return Err(format!("{shown} is a JSON array; write one object per line, without brackets"));
        }
        _ => builder.csv(text)?,
    }
    if builder.lines.is_empty() {
        return Err(format!("no jobs in {shown}; write one job per line, with its input"));
    }
    Ok(builder.lines)
}

#[derive(Debug)]
struct Builder<'a> {
    shown: String,
    folder: &'a Path,
    lines: Vec<Line>,
    /// The line of each name that was given, as it is written to disk.
    names: HashMap<String, u64>,
}

impl Builder<'_> {
    fn at(&self, line: u64, problem: impl std::fmt::Display) -> String {
        format!("{}, line {line}{problem}", self.shown)
    }

    fn unknown(&self, line: u64, column: &str) -> String {
        let settings: Vec<&str> = keys().collect();
        self.at(
            line,
            format_args!(
                ": unknown column “{}”; columns are input, name, {}",
                column.trim(),
                settings.join(", ")
            ),
        )
    }

    fn csv(&mut self, text: &str) -> Result<(), String> {
        let header = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
        let often = |c: char| header.matches(c).count();
        let delimiter = if often('\t') > often(',').max(often(';')) {
            b'\t'
        } else if often(';') > often(',') {
            b';'
        } else {
            b','
        };
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .from_reader(text.as_bytes());
        let mut columns: Option<Vec<(Column, String)>> = None;
        for record in reader.records() {
            let record = record.map_err(|e| format!("{}: {e}", self.shown))?;
            let line = line_at(text, record.position().map_or(0, csv::Position::byte) as usize);
            if record.iter().all(str::is_empty) {
                continue;
            }
            let Some(columns) = &columns else {
                columns = Some(self.header(line, record.iter())?);
                continue;
            };
            if record.len() > columns.len() {
                let (has, header) = (record.len(), columns.len());
                let problem = format!(": {has} fields, but the header has {header}");
                return Err(self.at(line, problem));
            }
            let cells = columns.iter().zip(&record).map(|((column, _), cell)| (*column, cell.to_owned()));
            self.line(line, cells)?;
        }
        Ok(())
    }

    fn header<'t>(
        &self,
        line: u64,
        fields: impl Iterator<Item = &'t str>,
    ) -> Result<Vec<(Column, String)>, String> {
        let mut columns: Vec<(Column, String)> = Vec::new();
        for field in fields {
            let column = Column::named(field).ok_or_else(|| self.unknown(line, field))?;
            if columns.iter().any(|(other, _)| *other == column) {
                return Err(self.at(line, format_args!(": duplicate column “{field}”")));
            }
            columns.push((column, field.to_owned()));
        }
        if !columns.iter().any(|(column, _)| *column == Column::Input) {
            let problem = ": no column “input”; the first line must name the columns";
            return Err(self.at(line, problem));
        }
        Ok(columns)
    }

    fn json_lines(&mut self, text: &str) -> Result<(), String> {
        use serde_json::Value;
        for (line, text) in (1..).zip(text.lines()) {
            if text.trim().is_empty() {
                continue;
            }
            let object: serde_json::Map<String, Value> = serde_json::from_str(text)
                .map_err(|e| self.at(line, format_args!(", column {}: not a JSON object", e.column())))?;
            let mut cells: Vec<(Column, String)> = Vec::new();
            for (field, value) in object {
                let column = Column::named(&field).ok_or_else(|| self.unknown(line, &field))?;
                if cells.iter().any(|(other, _)| *other == column) {
                    return Err(self.at(line, format_args!(": duplicate “{field}”")));
                }
                let cell = match value {
                    Value::String(text) => text.trim().to_owned(),
                    Value::Number(number) => number.to_string(),
                    Value::Bool(yes) => yes.to_string(),
                    Value::Null => continue,
                    Value::Array(_) | Value::Object(_) => {
                        let problem = format!(", column {field}: expected a string, a number or true");
                        return Err(self.at(line, problem));
                    }
                };
                cells.push((column, cell));
            }
            self.line(line, cells.into_iter())?;
        }
        Ok(())
    }

    fn line(&mut self, line: u64, cells: impl Iterator<Item = (Column, String)>) -> Result<(), String> {
        let (mut input, mut name, mut settings) = (None, None, Vec::new());
        // An empty cell says nothing.
        for (column, cell) in cells.filter(|(_, cell)| !cell.is_empty()) {
            match column {
                Column::Input => input = Some(self.folder.join(cell)),
                Column::Name => name = Some(cell),
                Column::Setting(key) => settings.push((key, cell)),
            }
        }
        let input = input.ok_or_else(|| self.at(line, ", column input: a job needs an input"))?;
        if let Some(name) = &name {
            if name.split(['/', '\\']).any(|part| part == "..") || Path::new(name).is_absolute() {
                return Err(self.at(line, ", column name: a name must stay inside the output folder"));
            }
            if let Some(other) = self.names.insert(nested(name).to_lowercase(), line) {
                let problem = format!(", column name: the name “{name}” is already used in line {other}");
                return Err(self.at(line, problem));
            }
        }
        let place = format!("{}, line {line}", self.shown);
        self.lines.push(Line { place, input, name, settings });
        Ok(())
    }
}

/// The line of what follows some bytes, line ends left aside: the reader of
/// tables counts those behind it that it has not looked at.
fn line_at(text: &str, byte: usize) -> u64 {
    let rest = &text.as_bytes()[byte.min(text.len())..];
    let skipped = rest.iter().take_while(|b| matches!(b, b'\r' | b'\n')).count();
    text.as_bytes()[..text.len() - rest.len() + skipped].iter().filter(|b| **b == b'\n').count() as u64 + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(content: &[u8]) -> Result<Vec<Line>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("jobs.list");
        fs::write(&path, content).unwrap();
        read(&path)
            .map(|mut lines| {
                for line in &mut lines {
                    line.input = line.input.strip_prefix(folder.path()).unwrap_or(&line.input).to_owned();
                }
                lines
            })
            .map_err(|problem| problem.replace(&folder.path().display().to_string(), ""))
    }

    #[test]
    fn tables_and_json_lines_say_the_same() {
        let table = of(b"\xef\xbb\xbfInput,name,alpha,primitive_cost\r\nshapes/a.obj,,0.5,\r\n\r\n\"b, c.ply\",x/y,2,3\n");
        let lines = of(b"{\"input\": \"shapes/a.obj\", \"alpha\": 0.5, \"name\": null}\n\n\n{\"input\": \"b, c.ply\", \"name\": \"x/y\", \"alpha\": \"2\", \"primitive-cost\": 3}");
        let (table, lines) = (table.unwrap(), lines.unwrap());
        let said = |lines: &[Line]| -> Vec<_> {
            lines.iter().map(|l| (l.input.clone(), l.name.clone(), l.settings.clone())).collect()
        };
        assert_eq!(said(&table), said(&lines));
        assert!(lines[1].place.ends_with("jobs.list, line 4"), "{}", lines[1].place);
        assert_eq!(table[0].input, Path::new("shapes/a.obj"));
        assert_eq!(table[1].settings, [("alpha", "2".to_owned()), ("primitive-cost", "3".to_owned())]);
        assert_eq!(table[1].name.as_deref(), Some("x/y"));
        assert!(table[1].place.ends_with("jobs.list, line 4"), "{}", table[1].place);
        let semicolons = of(b"input;seed\na.obj;3\n").unwrap();
        assert_eq!(semicolons[0].settings, [("seed", "3".to_owned())]);
        assert_eq!(of(b"input\tseed\na b.obj\t3\n").unwrap()[0].input, Path::new("a b.obj"));
    }

    #[test]
    fn what_can_not_be_meant_is_refused_with_its_line_and_column() {
        for (content, words) in [
            (
                &b"input,alpah\na.obj,1\n"[..],
                "line 1: unknown column “alpah”; columns are input, name, method",
            ),
            (b"name,alpha\na,1\n", "line 1: no column “input”"),
            (b"input,seed,Seed\n", "line 1: duplicate column “Seed”"),
            (b"input,seed\na.obj,1\nb.obj,2,3\n", "line 3: 3 fields, but the header has 2"),
            (b"input,seed\n,1\n", "line 2, column input: a job needs an input"),
            (
                b"input,name\na.obj,x\nb.obj,X\n",
                "line 3, column name: the name “X” is already used in line 2",
            ),
            (b"input,name\na.obj,../x\n", "line 2, column name"),
            (b"input\na\xff.obj\n", "line 2: not UTF-8"),
            (b"input\n", "no jobs"),
            (b"", "no jobs"),
            (b"{\"input\": \"a\"}\n{\"input\": \n", "line 2, column"),
            (b"[{\"input\": \"a\"}]", "is a JSON array"),
            (b"{\"input\": \"a\", \"alpah\": 1}", "line 1: unknown column “alpah”"),
            (b"{\"input\": \"a\", \"alpha\": [1]}", "line 1, column alpha"),
            (b"{\"input\": \"a\", \"method\": \"paper\", \"preset\": \"paper\"}", "duplicate “"),
        ] {
            let problem = of(content).unwrap_err();
            assert!(problem.contains(words), "{problem} lacks {words}");
        }
    }
}
