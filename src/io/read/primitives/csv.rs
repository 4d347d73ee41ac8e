//! Primitives as lines of 13 numbers, in the order used by the paper's authors.

use nalgebra::{Rotation3, Vector3};

use super::Found;
use crate::geometry::Superquadric;
use crate::inference::Primitive;
use crate::io::error::Fault;
use crate::io::read::text::{lines, number, quoted};

/// Names of the columns. Rz(yaw)·Ry(pitch)·Rx(roll) takes local to world.
pub(in crate::io) const COLUMNS: [&str; 13] =
    ["e1", "e2", "ax", "ay", "az", "yaw", "pitch", "roll", "tx", "ty", "tz", "kx", "ky"];

/// Columns of a primitive that is not tapered.
const WITHOUT_TAPER: usize = 11;

pub(super) fn parse(text: &str) -> Result<Found, Fault> {
    let mut ids: Option<Vec<u32>> = None;
    let mut primitives: Vec<Primitive> = Vec::new();
    for (line, content) in lines(text) {
        let content = content.trim();
        if let Some(comment) = content.strip_prefix(['#', '%']) {
            if let Some(list) = comment.trim_start().strip_prefix("ids") {
                ids = list.split_whitespace().map(|id| id.parse().ok()).collect();
            }
            continue;
        }
        let tokens: Vec<&str> = content
            .split(|c: char| matches!(c, ',' | ';') || c.is_whitespace())
            .filter(|token| !token.is_empty())
            .collect();
        if tokens.is_empty() {
            continue;
        }
        let values: Vec<Option<f64>> = tokens.iter().map(|token| number(token.trim_matches('"'))).collect();
        // A line of names comes before all numbers.
        if primitives.is_empty() && tokens.len() >= WITHOUT_TAPER && values.iter().all(Option::is_none) {
            continue;
        }
        if let Some(at) = values.iter().position(Option::is_none) {
            return Err(Fault::at_line(
                line,
                format!(
                    "{} is not a number; primitives are JSON, NPZ or lines of 13 numbers ({})",
                    quoted(tokens[at]),
                    COLUMNS.join(",")
                ),
            ));
        }
        let values: Vec<f64> = values.into_iter().flatten().collect();
        if values.len() != COLUMNS.len() && values.len() != WITHOUT_TAPER {
            return Err(Fault::at_line(
                line,
                format!(
                    "it has {} numbers, but a primitive has 13 ({}) or only the first {WITHOUT_TAPER}",
                    values.len(),
                    COLUMNS.join(",")
                ),
            ));
        }
        let id = u32::try_from(primitives.len()).unwrap_or(u32::MAX);
        primitives.push(primitive(id, &values).map_err(|problem| Fault::at_line(line, problem))?);
    }
    let mut notes = Vec::new();
    match ids {
        Some(ids) if ids.len() == primitives.len() => {
            for (primitive, id) in primitives.iter_mut().zip(ids) {
                primitive.id = id;
            }
        }
        Some(_) => notes.push("its line of ids does not match the primitives and was ignored".to_owned()),
        None => {}
    }
    if primitives.is_empty() && !text.trim_start().starts_with('#') {
        return Err(Fault::whole("it contains no primitives"));
    }
    Ok(Found { primitives, notes, ..Found::default() })
}

/// A primitive from its numbers, which may lack the taper.
fn primitive(id: u32, v: &[f64]) -> Result<Primitive, String> {
    if let Some(at) = v.iter().position(|value| !value.is_finite()) {
        return Err(format!("{} is {}", COLUMNS[at], v[at]));
    }
    Ok(Primitive {
        id,
        shape: Superquadric {
            exponents: [v[0], v[1]],
            semi_axes: Vector3::new(v[2], v[3], v[4]),
            // nalgebra's order is roll, pitch, yaw; the product is the same.
            rotation: Rotation3::from_euler_angles(v[7], v[6], v[5]),
            translation: Vector3::new(v[8], v[9], v[10]),
            taper: if v.len() == COLUMNS.len() { [v[11], v[12]] } else { [0.0; 2] },
        },
        sigma: 0.0,
        points: 0,
        mean_distance: 0.0,
        locked: false,
    })
}
