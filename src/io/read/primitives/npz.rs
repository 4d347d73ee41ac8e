//! Primitives as arrays with the names common in Python superquadric tools.

use nalgebra::Vector3;

use super::arrays::{Archive, Array};
use super::{Found, rotation};
use crate::geometry::Superquadric;
use crate::inference::Primitive;
use crate::io::error::Fault;
use crate::io::read::text::counted;

/// How far RᵀR may be from the identity: networks compute in single precision.
const ORTHONORMAL: f64 = 1e-2;

/// A primitive is there where its `exist` is above this.
const EXISTS: f64 = 0.5;

/// An assignment matrix with more values is not counted.
const LARGEST_ASSIGNMENT: usize = 1 << 28;

/// One shape's slice of an array, `values` a primitive.
fn slice(
    archive: &mut Archive<'_>,
    name: &str,
    layout: &Layout,
    values: usize,
) -> Result<Option<Vec<f64>>, Fault> {
    let Some(array) = archive.get(name)? else { return Ok(None) };
    let wrong = |problem: String| Fault::whole(format!("the array \"{name}\" {problem}"));
    let [batch, count] = [layout.batch, layout.primitives];
    let size: usize = array.shape.iter().product();
    let leads = if layout.is_batched {
        array.shape.starts_with(&[batch, count])
    } else {
        array.shape.first() == Some(&count)
    };
    if !leads || size != batch * count * values {
        return Err(wrong(format!(
            "has shape {:?}, but needs {} of {values} for each of {count} primitives",
            array.shape,
            counted(batch, "batch", "batches")
        )));
    }
    array.numbers(layout.shape * count * values, count * values).map(Some).map_err(wrong)
}

/// How the arrays are laid out: (batch, primitives, …), or without the batch.
#[derive(Debug, Clone, Copy)]
struct Layout {
    is_batched: bool,
    batch: usize,
    primitives: usize,
    /// The shape of the batch that is asked for.
    shape: usize,
}

impl Layout {
    /// From the shape of `scale`.
    fn of(scale: &Array, shape: Option<usize>) -> Result<Self, Fault> {
        let (is_batched, batch, primitives) = match scale.shape[..] {
            [batch, primitives, 3] => (true, batch, primitives),
            [primitives, 3] => (false, 1, primitives),
            _ => {
                return Err(Fault::whole(format!(
                    "the array \"scale\" has shape {:?}, but needs (shapes, primitives, 3)",
                    scale.shape
                )));
            }
        };
        let shape = shape.unwrap_or(0);
        if shape >= batch {
            return Err(Fault::whole(format!(
                "it contains {}, so index {shape} does not exist",
                counted(batch, "shape", "shapes")
            )));
        }
        Ok(Self { is_batched, batch, primitives, shape })
    }
}

pub(super) fn parse(bytes: &[u8], shape: Option<usize>) -> Result<Found, Fault> {
    let mut archive = Archive::new(bytes)?;
    let Some(scale) = archive.get("scale")? else {
        return Err(Fault::whole(format!(
            "it contains no primitives: there is no array \"scale\" among {}",
            archive.names().join(", ")
        )));
    };
    let layout = Layout::of(&scale, shape)?;
    let mut notes = Vec::new();
    if layout.batch > 1 && shape.is_none() {
        notes.push(format!("it contains {} shapes; the first was read", layout.batch));
    }
    let mut need = |name: &str, values: usize| {
        slice(&mut archive, name, &layout, values)?
            .ok_or_else(|| Fault::whole(format!("there is no array \"{name}\"")))
    };
    let scale = need("scale", 3)?;
    let rotations = need("rotation", 9)?;
    let translations = need("translation", 3)?;
    let exponents = need("exponents", 2)?;
    let mut may = |name: &str, values: usize| slice(&mut archive, name, &layout, values);
    let exist = may("exist", 1)?;
    let tapering = may("tapering", 2)?;
    let (sigma, mean_distance) = (may("sigma", 1)?, may("mean_distance", 1)?);
    let (ids, points) = (may("ids", 1)?, may("points", 1)?);

    let mut primitives = Vec::new();
    let count = layout.primitives;
    // Counted only where our own figures are missing.
    let (samples, assigned) = samples(&mut archive, &layout, points.is_none())?;
    for k in 0..count {
        if exist.as_ref().is_some_and(|e| e[k].is_nan() || e[k] <= EXISTS) {
            continue;
        }
        let id = ids.as_ref().map_or(k as f64, |ids| ids[k]);
        if !(id >= 0.0 && id < f64::from(u32::MAX) && id.fract() == 0.0) {
            return Err(Fault::whole(format!("the id {id} is not a non-negative whole number")));
        }
        let id = id as u32;
        let r = &rotations[9 * k..][..9];
        let rows = [[r[0], r[1], r[2]], [r[3], r[4], r[5]], [r[6], r[7], r[8]]];
        let rotation = rotation(rows, ORTHONORMAL)
            .map_err(|problem| Fault::whole(format!("primitive {id}: {problem}")))?;
        let own = points.as_ref().map(|points| points[k].max(0.0) as usize);
        primitives.push(Primitive {
            id,
            shape: Superquadric {
                exponents: [exponents[2 * k], exponents[2 * k + 1]],
                semi_axes: Vector3::from_column_slice(&scale[3 * k..][..3]),
                rotation,
                translation: Vector3::from_column_slice(&translations[3 * k..][..3]),
                taper: tapering.as_ref().map_or([0.0; 2], |t| [t[2 * k], t[2 * k + 1]]),
            },
            sigma: sigma.as_ref().map_or(0.0, |s| s[k]),
            points: own.or_else(|| assigned.as_ref().map(|a| a[k])).unwrap_or(0),
            mean_distance: mean_distance.as_ref().map_or(0.0, |m| m[k]),
            locked: false,
        });
    }
    if primitives.len() < count {
        let rest = counted(count - primitives.len(), "primitive", "primitives");
        notes.push(format!("{rest} with \"exist\" not above {EXISTS} were ignored"));
    }
    let names = archive.get("names")?;
    let input = names.and_then(|names| names.text(layout.shape)).filter(|name| !name.is_empty());
    Ok(Found { input, points: samples, primitives, notes, ..Found::default() })
}

/// Number of samples, and how many of them belong most to each primitive.
#[allow(clippy::type_complexity)] // Two figures of one array.
fn samples(
    archive: &mut Archive<'_>,
    layout: &Layout,
    count_them: bool,
) -> Result<(Option<usize>, Option<Vec<usize>>), Fault> {
    let primitives = layout.primitives;
    let Some(matrix) = archive.get("assign_matrix")? else { return Ok((None, None)) };
    let samples = match matrix.shape[..] {
        [batch, samples, p] if layout.is_batched && batch == layout.batch && p == primitives => samples,
        [samples, p] if !layout.is_batched && p == primitives => samples,
        _ => return Ok((None, None)),
    };
    let values = samples.saturating_mul(primitives);
    if !count_them || primitives == 0 || values > LARGEST_ASSIGNMENT {
        return Ok((Some(samples), None));
    }
    let rows = matrix
        .numbers(layout.shape * values, values)
        .map_err(|problem| Fault::whole(format!("the array \"assign_matrix\" {problem}")))?;
    let mut assigned = vec![0; primitives];
    for row in rows.chunks_exact(primitives) {
        let most = (0..primitives).max_by(|&a, &b| row[a].total_cmp(&row[b]).then(b.cmp(&a)));
        if let Some(k) = most.filter(|&k| row[k] > 0.0) {
            assigned[k] += 1;
        }
    }
    Ok((Some(samples), Some(assigned)))
}
