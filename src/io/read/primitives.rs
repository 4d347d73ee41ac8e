//! Reads primitives from Superform's JSON, NPZ and CSV files, and from those of other programs.

mod arrays;
mod csv;
mod json;
mod npz;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Rotation3};

use super::text;
use crate::geometry::Superquadric;
use crate::geometry::palette::Colors;
use crate::inference::{Edit, Params, Primitive};
use crate::io::error::{Fault, ReadError};
use crate::io::write::{PRIMITIVES_FILE, PrimitiveSet};

pub(in crate::io) use csv::COLUMNS as CSV_COLUMNS;

/// Name and version of the JSON format, as they stand in the file.
pub(in crate::io) const FORMAT: &str = "superform-primitives";
pub(in crate::io) const VERSION: u32 = 1;

/// Names by which primitives are looked for in a folder.
const NAMES: [&str; 3] = [PRIMITIVES_FILE, "primitives.npz", "primitives.csv"];

/// Content of a file of primitives.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredPrimitives {
    /// The file itself, where a folder was given, too.
    pub path: PathBuf,
    /// Name of the abstracted shape, if known.
    pub input: Option<String>,
    /// Number of samples they were computed from, if known.
    pub points: Option<usize>,
    pub seed: Option<u64>,
    pub sampling_seed: Option<u64>,
    pub params: Option<Params>,
    pub primitives: Vec<Primitive>,
    /// What was left aside or mended on reading, one sentence each.
    pub notes: Vec<String>,
}

impl StoredPrimitives {
    /// Share of the samples that belong to no primitive; `None` if their number is unknown.
    pub fn unassigned_share(&self) -> Option<f64> {
        let assigned: usize = self.primitives.iter().map(|p| p.points).sum();
        let points = self.points?;
        Some(if points == 0 { 0.0 } else { 1.0 - assigned as f64 / points as f64 })
    }

    pub fn shapes(&self) -> Vec<Superquadric> {
        self.primitives.iter().map(|p| p.shape).collect()
    }

    /// The change that brings the primitives to another cloud: what they came to
    /// on their own says nothing there.
    pub fn brought_in(&self) -> Edit {
        let primitives = self.primitives.iter().map(|p| Primitive { sigma: 0.0, ..p.clone() });
        Edit::Take { primitives: primitives.collect(), labels: Vec::new() }
    }

    /// The primitives as they can be written.
    pub fn set<'a>(&'a self, colors: &'a Colors) -> PrimitiveSet<'a> {
        PrimitiveSet {
            primitives: &self.primitives,
            colors,
            input: self.input.as_deref(),
            points: self.points,
            samples: None,
            sampling_seed: self.sampling_seed,
            seed: self.seed,
            params: self.params.as_ref(),
        }
    }
}

/// Reads the primitives of a run, by the name of the file or of the folder that
/// holds it: `primitives.json`, NPZ or CSV, told from the content. Of a file
/// with several shapes the first is taken, with a note.
///
/// # Errors
/// Where there is no such file, it is in none of these formats, a field is
/// missing or of the wrong kind, or a primitive is none: an exponent or a
/// semi-axis not above 0, a matrix that is no rotation, a taper beyond [−1, 1],
/// an id or more points than there are used twice.
pub fn read_primitives(path: &Path) -> Result<StoredPrimitives, ReadError> {
    read_primitives_of(path, None)
}

/// As [`read_primitives`], the shape at place `shape` (from 0) of a file with
/// several.
///
/// # Errors
/// The same, and where there are not so many shapes.
pub fn read_primitives_of(path: &Path, shape: Option<usize>) -> Result<StoredPrimitives, ReadError> {
    let path = if path.is_dir() {
        let found = NAMES.iter().map(|name| path.join(name)).find(|file| file.exists());
        found.unwrap_or_else(|| path.join(PRIMITIVES_FILE))
    } else {
        path.to_owned()
    };
    let bytes = super::content(&path)?;
    parse_primitives(&bytes, &path, shape)
}

/// As [`read_primitives_of`], from the content of a file or a text that was
/// pasted; `origin` is what messages call it.
///
/// # Errors
/// The same.
pub fn parse_primitives(
    bytes: &[u8],
    origin: &Path,
    shape: Option<usize>,
) -> Result<StoredPrimitives, ReadError> {
    let parsed = if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        npz::parse(bytes, shape)
    } else {
        let text = text::decode(bytes);
        let one =
            if text.trim_start().starts_with(['{', '[']) { json::parse(&text) } else { csv::parse(&text) };
        one.and_then(|stored| match shape {
            None | Some(0) => Ok(stored),
            Some(n) => Err(Fault::whole(format!("it contains only one shape, so index {n} does not exist"))),
        })
    };
    parsed.and_then(|stored| stored.checked(origin)).map_err(|fault| fault.in_file(origin.to_owned()))
}

/// What a format's reader has found, unchecked where formats are alike.
#[derive(Debug, Default)]
struct Found {
    input: Option<String>,
    points: Option<usize>,
    seed: Option<u64>,
    sampling_seed: Option<u64>,
    params: Option<Params>,
    primitives: Vec<Primitive>,
    notes: Vec<String>,
}

impl Found {
    fn checked(self, origin: &Path) -> Result<StoredPrimitives, Fault> {
        let Self { input, points, seed, sampling_seed, params, primitives, notes } = self;
        let mut ids = HashSet::new();
        for p in &primitives {
            check(p).map_err(|problem| Fault::whole(format!("primitive {}: {problem}", p.id)))?;
            if !ids.insert(p.id) {
                return Err(Fault::whole(format!("two primitives have the id {}", p.id)));
            }
        }
        let assigned = primitives.iter().try_fold(0usize, |sum, p| sum.checked_add(p.points));
        if assigned.is_none_or(|n| points.is_some_and(|all| n > all)) {
            return Err(Fault::whole("its primitives have more points than their cloud"));
        }
        let path = origin.to_owned();
        Ok(StoredPrimitives { path, input, points, seed, sampling_seed, params, primitives, notes })
    }
}

/// Says what is wrong with a primitive, if anything is.
fn check(p: &Primitive) -> Result<(), String> {
    let positive = |name: &str, values: &[f64]| {
        let wrong = values.iter().find(|v| !(v.is_finite() && **v > 0.0));
        wrong.map_or(Ok(()), |v| Err(format!("{name} {v} is not greater than 0")))
    };
    positive("the exponent", &p.shape.exponents)?;
    positive("the semi-axis", p.shape.semi_axes.as_slice())?;
    if let Some(k) = p.shape.taper.iter().find(|k| k.is_nan() || k.abs() > 1.0) {
        return Err(format!("the taper {k} is not between -1 and 1"));
    }
    let numbers_fit = p.sigma >= 0.0 && p.sigma.is_finite();
    if !(p.shape.is_valid() && numbers_fit && p.mean_distance >= 0.0 && p.mean_distance.is_finite()) {
        return Err("a number is not finite or below 0".to_owned());
    }
    Ok(())
}

/// A rotation from its rows; what deviates by more than `allowed` is none. What
/// was rounded is made orthonormal, what was not keeps its bits.
fn rotation(rows: [[f64; 3]; 3], allowed: f64) -> Result<Rotation3<f64>, String> {
    let [x, y, z] = rows;
    let matrix = Matrix3::from_rows(&[x.into(), y.into(), z.into()]);
    let off = (matrix.tr_mul(&matrix) - Matrix3::identity()).amax();
    if !(off <= allowed && matrix.determinant() > 0.0) {
        return Err("the matrix \"rotation\" is not a rotation".to_owned());
    }
    /// Beyond this it was written with fewer digits than there are.
    const ROUNDED: f64 = 1e-12;
    if off <= ROUNDED {
        return Ok(Rotation3::from_matrix_unchecked(matrix));
    }
    let svd = matrix.svd(true, true);
    match (svd.u, svd.v_t) {
        (Some(u), Some(v_t)) => Ok(Rotation3::from_matrix_unchecked(u * v_t)),
        _ => Err("the matrix \"rotation\" is not a rotation".to_owned()),
    }
}
