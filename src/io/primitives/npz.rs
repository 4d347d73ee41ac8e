//! Primitives as arrays with the names common in Python superquadric tools.

use std::io::{self, Seek, Write};

use nalgebra::Vector3;

use super::schema::arrays;
use super::set::{PrimitiveSet, checked};
use super::stored::{Found, rotation};
use crate::geometry::Superquadric;
use crate::inference::Primitive;
use crate::io::error::Fault;
use crate::io::npy::{Archive, Array, Npz};
use crate::io::read::text::counted;
use crate::io::write::file_label;

/// How far RᵀR may be from the identity: networks compute in single precision.
const ORTHONORMAL: f64 = 1e-2;

/// A primitive is there where its `exist` is above this.
const EXISTS: f64 = 0.5;

/// An assignment matrix with more values is not counted.
const LARGEST_ASSIGNMENT: usize = 1 << 28;

/// A batch of one shape, by the names that superquadric tools in Python use.
pub(in crate::io) fn write(w: &mut (impl Write + Seek), set: &PrimitiveSet<'_>) -> io::Result<()> {
    let all = set.primitives.iter().map(checked).collect::<io::Result<Vec<_>>>()?;
    let count = all.len();
    let mut npz = Npz::new(w);
    npz.text(arrays::NAMES, set.input.unwrap_or_default())?;
    if let Some((points, labels)) = set.samples {
        let place = |id: u32| all.iter().position(|p| p.id == id);
        let rows = labels.iter().flat_map(|&label| {
            let own = place(label);
            (0..count).map(move |k| if Some(k) == own { 1f32 } else { 0.0 }.to_le_bytes())
        });
        npz.doubles(arrays::CLOUD, &[1, points.len(), 3], points.iter().flat_map(|p| p.iter()))?;
        npz.add(arrays::ASSIGNMENT, "<f4", &[1, points.len(), count], rows)?;
    }
    let of =
        |values: fn(&Primitive) -> Vec<f64>| -> Vec<f64> { all.iter().flat_map(|p| values(p)).collect() };
    for (name, shape, values) in [
        (arrays::SCALE, &[1, count, 3][..], of(|p| p.shape.semi_axes.iter().copied().collect())),
        // NumPy's order is by rows, nalgebra's by columns.
        (
            arrays::ROTATION,
            &[1, count, 3, 3],
            of(|p| p.shape.rotation.matrix().transpose().iter().copied().collect()),
        ),
        (arrays::TRANSLATION, &[1, count, 3], of(|p| p.shape.translation.iter().copied().collect())),
        (arrays::EXPONENTS, &[1, count, 2], of(|p| p.shape.exponents.to_vec())),
        (arrays::EXIST, &[1, count, 1], of(|_| vec![1.0])),
        (arrays::TAPERING, &[1, count, 2], of(|p| p.shape.taper.to_vec())),
        (arrays::SIGMA, &[1, count], of(|p| vec![p.sigma])),
        (arrays::MEAN_DISTANCE, &[1, count], of(|p| vec![p.mean_distance])),
    ] {
        npz.doubles(name, shape, &values)?;
    }
    let ids = all.iter().map(|p| file_label(p.id)).collect::<io::Result<Vec<_>>>()?;
    npz.add(arrays::IDS, "<i4", &[1, count], ids.into_iter().map(i32::to_le_bytes))?;
    let points = all.iter().map(|p| (p.points as i64).to_le_bytes());
    npz.add(arrays::POINTS, "<i8", &[1, count], points)?;
    npz.finish()
}

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
    let Some(scale) = archive.get(arrays::SCALE)? else {
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
    let scale = need(arrays::SCALE, 3)?;
    let rotations = need(arrays::ROTATION, 9)?;
    let translations = need(arrays::TRANSLATION, 3)?;
    let exponents = need(arrays::EXPONENTS, 2)?;
    let mut may = |name: &str, values: usize| slice(&mut archive, name, &layout, values);
    let exist = may(arrays::EXIST, 1)?;
    let tapering = may(arrays::TAPERING, 2)?;
    let (sigma, mean_distance) = (may(arrays::SIGMA, 1)?, may(arrays::MEAN_DISTANCE, 1)?);
    let (ids, points) = (may(arrays::IDS, 1)?, may(arrays::POINTS, 1)?);

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
    let names = archive.get(arrays::NAMES)?;
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
    let Some(matrix) = archive.get(arrays::ASSIGNMENT)? else { return Ok((None, None)) };
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
