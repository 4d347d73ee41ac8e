//! Reading primitives back.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::Deserialize;

use super::text;
use crate::geometry::Superquadric;
use crate::inference::Primitive;
use crate::io::error::{Fault, ReadError};
use crate::io::write::{PRIMITIVES_FILE, PrimitiveEntry};

/// Name and version of the format, as they stand in the file.
pub(in crate::io) const FORMAT: &str = "superform-primitives";
pub(in crate::io) const VERSION: u32 = 1;

/// How far RᵀR may be from the identity: what is left of a rotation that was
/// written with six digits.
const ORTHONORMAL: f64 = 1e-5;

/// What a file of primitives holds.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredPrimitives {
    /// The file itself, where a folder was given, too.
    pub path: PathBuf,
    /// Name of the shape that they stand for.
    pub input: String,
    /// Number of samples that they were made from.
    pub points: usize,
    pub seed: u64,
    pub primitives: Vec<Primitive>,
}

impl StoredPrimitives {
    /// Share of the samples that belong to no primitive.
    pub fn unassigned_share(&self) -> f64 {
        let assigned: usize = self.primitives.iter().map(|p| p.points).sum();
        if self.points == 0 { 0.0 } else { 1.0 - assigned as f64 / self.points as f64 }
    }

    pub fn shapes(&self) -> Vec<Superquadric> {
        self.primitives.iter().map(|p| p.shape).collect()
    }
}

/// Reads the `primitives.json` of a run, by its own name or by that of the
/// folder that holds it.
///
/// # Errors
/// Where there is no such file, it is no JSON of this format and version, a
/// field is missing or of the wrong kind, or a primitive is none: an exponent
/// or a semi-axis not above 0, a matrix that is no rotation, a taper beyond
/// [−1, 1], an id or more points than there are used twice.
pub fn read_primitives(path: &Path) -> Result<StoredPrimitives, ReadError> {
    let path = if path.is_dir() { path.join(PRIMITIVES_FILE) } else { path.to_owned() };
    let bytes = super::content(&path)?;
    match parse(&text::decode(&bytes)) {
        Ok((file, primitives)) => {
            let File { input, points, seed, .. } = file;
            Ok(StoredPrimitives { path, input, points, seed, primitives })
        }
        Err(fault) => Err(fault.in_file(path)),
    }
}

/// What tells the format; the rest is looked at once that is known.
#[derive(Debug, Deserialize)]
struct Head {
    format: Option<String>,
    version: Option<u32>,
}

#[derive(Debug, Deserialize)]
struct File {
    input: String,
    seed: u64,
    points: usize,
    primitives: Vec<PrimitiveEntry>,
}

fn parse(text: &str) -> Result<(File, Vec<Primitive>), Fault> {
    let head: Head = serde_json::from_str(text).map_err(|e| json_fault(&e))?;
    if head.format.as_deref() != Some(FORMAT) {
        return Err(Fault::whole(format!(
            "it is JSON, but no file of primitives (its \"format\" is not \"{FORMAT}\"); \
             give a {PRIMITIVES_FILE} or the folder of a run"
        )));
    }
    if head.version != Some(VERSION) {
        let found = head.version.map_or("missing".to_owned(), |v| v.to_string());
        return Err(Fault::whole(format!(
            "its version is {found}, but only version {VERSION} can be read; \
             write it again or take a newer program"
        )));
    }
    let file: File = serde_json::from_str(text).map_err(|e| json_fault(&e))?;
    let mut ids = HashSet::new();
    let primitives = file
        .primitives
        .iter()
        .map(|entry| {
            let id = entry.id;
            let primitive =
                primitive(entry).map_err(|problem| Fault::whole(format!("primitive {id}: {problem}")))?;
            if !ids.insert(id) {
                return Err(Fault::whole(format!("the id {id} belongs to two primitives")));
            }
            Ok(primitive)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let assigned = primitives.iter().try_fold(0usize, |sum, p| sum.checked_add(p.points));
    if assigned.is_none_or(|n| n > file.points) {
        return Err(Fault::whole("its primitives have more points than the cloud they were made from"));
    }
    Ok((file, primitives))
}

fn json_fault(error: &serde_json::Error) -> Fault {
    let whole = error.to_string();
    let problem = whole.split(" at line ").next().unwrap_or(&whole).to_owned();
    match error.line() {
        0 => Fault::whole(problem),
        line => Fault::at_line(line, problem),
    }
}

fn primitive(entry: &PrimitiveEntry) -> Result<Primitive, String> {
    let positive = |name: &str, values: &[f64]| {
        let wrong = values.iter().find(|v| !(v.is_finite() && **v > 0.0));
        wrong.map_or(Ok(()), |v| Err(format!("{name} {v} is not above 0")))
    };
    positive("the exponent", &entry.eps)?;
    positive("the semi-axis", &entry.scale)?;
    if let Some(k) = entry.taper.iter().find(|k| k.is_nan() || k.abs() > 1.0) {
        return Err(format!("the taper {k} is not between -1 and 1"));
    }
    let [x, y, z] = entry.rotation;
    let matrix = Matrix3::from_rows(&[x.into(), y.into(), z.into()]);
    let off = (matrix.tr_mul(&matrix) - Matrix3::identity()).amax();
    if !(off <= ORTHONORMAL && matrix.determinant() > 0.0) {
        return Err("the matrix \"rotation\" is not a rotation".to_owned());
    }
    let shape = Superquadric {
        exponents: entry.eps,
        semi_axes: Vector3::from(entry.scale),
        rotation: Rotation3::from_matrix_unchecked(matrix),
        translation: Vector3::from(entry.translation),
        taper: entry.taper,
    };
    if !(shape.is_valid() && entry.sigma >= 0.0 && entry.mean_distance >= 0.0) {
        return Err("a number is not finite or below 0".to_owned());
    }
    Ok(Primitive {
        id: entry.id,
        shape,
        sigma: entry.sigma,
        points: entry.points,
        mean_distance: entry.mean_distance,
        locked: false,
    })
}
