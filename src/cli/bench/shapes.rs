//! The shapes to measure, and their references.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::io;

/// A shape to abstract.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BenchShape {
    /// Name in the tables; no two shapes share one.
    pub(super) name: String,
    pub(super) input: PathBuf,
    /// What the result is measured against.
    pub(super) reference: PathBuf,
}

/// The shapes that are meant by files, folders and lists, in that order. A
/// list is a CSV file with the columns `name`, `cloud` and `reference`, whose
/// paths are relative to it; an empty reference means the cloud itself. A
/// folder stands for the shapes in it, by name. For shapes that come from no
/// list `references` may say what they are measured against; without that it
/// is themselves.
///
/// # Errors
/// Where something is not there, a list is broken or two shapes share a name.
pub(super) fn find(given: &[PathBuf], references: Option<&Path>) -> anyhow::Result<Vec<BenchShape>> {
    let references: HashMap<String, PathBuf> = match references {
        None => HashMap::new(),
        Some(list) => read_list(list)?.into_iter().map(|s| (s.name, s.reference)).collect(),
    };
    let alone = |path: PathBuf| {
        let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let reference = references.get(&name).unwrap_or(&path).clone();
        BenchShape { name, input: path, reference }
    };
    let mut shapes = Vec::new();
    for path in given {
        if path.is_dir() {
            let found = folder(path).with_context(|| format!("cannot list {}", path.display()))?;
            if found.is_empty() {
                bail!("no shapes in {}; give another folder or a file", path.display());
            }
            shapes.extend(found.into_iter().map(alone));
        } else if !path.is_file() {
            bail!("{} not found; give a shape, a folder of shapes or a list", path.display());
        } else if is_list(path) {
            shapes.extend(read_list(path)?);
        } else {
            shapes.push(alone(path.clone()));
        }
    }
    // The same stem with two endings: the whole file name tells them apart.
    let mut count: HashMap<String, usize> = HashMap::new();
    shapes.iter().for_each(|s| *count.entry(s.name.clone()).or_default() += 1);
    for shape in &mut shapes {
        if count[&shape.name] > 1
            && let Some(name) = shape.input.file_name()
        {
            shape.name = name.to_string_lossy().into_owned();
        }
    }
    for (i, shape) in shapes.iter().enumerate() {
        if let Some(twin) = shapes[..i].iter().find(|s| s.name == shape.name) {
            bail!(
                "{} and {} would have the same name, {}; rename or remove one",
                twin.input.display(),
                shape.input.display(),
                shape.name
            );
        }
    }
    Ok(shapes)
}

fn folder(path: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(path)? {
        let path = entry?.path();
        if path.is_file() && io::has_shape_ending(&path) && !is_list(&path) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Whether a file is a list of shapes, by its ending and first line.
fn is_list(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"))
        && reader(path).is_ok_and(|mut rows| {
            rows.headers().is_ok_and(|h| ["name", "cloud"].iter().all(|c| h.iter().any(|f| f == *c)))
        })
}

fn reader(path: &Path) -> Result<csv::Reader<fs::File>, csv::Error> {
    csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_path(path)
}

fn read_list(path: &Path) -> anyhow::Result<Vec<BenchShape>> {
    let folder = path.parent().unwrap_or(Path::new(""));
    rows(path, &["name", "cloud", "reference"])?
        .into_iter()
        .map(|(line, row)| {
            let [name, cloud, reference] = [0, 1, 2].map(|i| row[i].as_str());
            if name.is_empty() || cloud.is_empty() {
                bail!("{}, line {line}: a shape needs a name and a cloud", path.display());
            }
            let reference = if reference.is_empty() { cloud } else { reference };
            Ok(BenchShape {
                name: name.to_owned(),
                input: folder.join(cloud),
                reference: folder.join(reference),
            })
        })
        .collect()
}

/// The named columns of a CSV file, with the line of each row. Other columns
/// don't matter.
pub(super) fn rows(path: &Path, columns: &[&str]) -> anyhow::Result<Vec<(u64, Vec<String>)>> {
    let shown = path.display();
    let mut rows = reader(path).with_context(|| format!("cannot read {shown}"))?;
    let headers = rows.headers().with_context(|| format!("cannot read {shown}"))?.clone();
    let at = columns
        .iter()
        .map(|column| {
            // A byte-order mark may stand before the first name.
            headers
                .iter()
                .position(|h| h.trim_start_matches('\u{feff}') == *column)
                .with_context(|| format!("{shown} has no column {column}; its first line must name it"))
        })
        .collect::<anyhow::Result<Vec<usize>>>()?;
    rows.records()
        .map(|record| {
            let record = record.with_context(|| format!("cannot read {shown}"))?;
            let line = record.position().map_or(0, csv::Position::line);
            Ok((line, at.iter().map(|&i| record.get(i).unwrap_or_default().to_owned()).collect()))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
        path
    }

    #[test]
    fn files_folders_and_lists_become_shapes() {
        let temp = tempfile::tempdir().unwrap();
        let folder = temp.path();
        let list = write(folder, "list.csv", "name,cloud,reference\r\na,x/a.xyz,m.obj\r\nb, x/b.xyz ,\r\n");
        for name in ["x/a.xyz", "x/c.obj", "x/c.ply", "x/notes.md"] {
            write(folder, name, "0 0 0\n");
        }
        let shape = |name: &str, input: &str, reference: &str| BenchShape {
            name: name.to_owned(),
            input: folder.join(input),
            reference: folder.join(reference),
        };
        let listed = [shape("a", "x/a.xyz", "m.obj"), shape("b", "x/b.xyz", "x/b.xyz")];
        assert_eq!(find(std::slice::from_ref(&list), None).unwrap(), listed);
        let found = find(&[folder.join("x")], Some(&list)).unwrap();
        assert_eq!(
            found,
            [
                shape("a", "x/a.xyz", "m.obj"),
                shape("c.obj", "x/c.obj", "x/c.obj"),
                shape("c.ply", "x/c.ply", "x/c.ply"),
            ]
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        let temp = tempfile::tempdir().unwrap();
        let folder = temp.path();
        let a = write(folder, "a.xyz", "0 0 0\n");
        let again = write(folder, "y/a.xyz", "0 0 0\n");
        let empty = write(folder, "z/readme.md", "").parent().unwrap().to_owned();
        let nameless = write(folder, "nameless.csv", "name,cloud,reference\n,a.xyz,\n");
        let narrow = write(folder, "narrow.csv", "name,cloud\nq,a.xyz\n");
        for (given, words) in [
            (vec![a.clone(), again], "the same name, a.xyz"),
            (vec![empty], "no shapes in"),
            (vec![folder.join("gone.obj")], "not found"),
            (vec![nameless], "line 2: a shape needs a name"),
            (vec![narrow], "has no column reference"),
        ] {
            let problem = format!("{:#}", find(&given, None).unwrap_err());
            assert!(problem.contains(words), "{problem}");
        }
        // A cloud in CSV is no list.
        let cloud = write(folder, "cloud.csv", "x,y,z\n0,0,0\n");
        assert_eq!(find(&[cloud], None).unwrap()[0].name, "cloud");
    }
}
