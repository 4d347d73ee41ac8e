//! `primitives.json`, version 1.

use nalgebra::Vector3;
use serde::{Deserialize, Deserializer};

use super::{FORMAT, Found, VERSION, rotation};
use crate::geometry::Superquadric;
use crate::inference::{Params, Primitive};
use crate::io::error::Fault;
use crate::io::write::{PRIMITIVES_FILE, PrimitiveEntry};

/// How far RᵀR may be from the identity: what is left of a rotation that was
/// written with six digits.
const ORTHONORMAL: f64 = 1e-5;

/// The fields that identify the format, read first.
#[derive(Debug, Deserialize)]
struct Head {
    format: Option<String>,
    version: Option<u32>,
}

#[derive(Debug, Deserialize)]
struct File {
    #[serde(deserialize_with = "or_null")]
    input: Option<String>,
    #[serde(deserialize_with = "or_null")]
    seed: Option<u64>,
    #[serde(deserialize_with = "or_null")]
    points: Option<usize>,
    #[serde(default)]
    sampling_seed: Option<u64>,
    /// Of this program or another version of it.
    #[serde(default)]
    params: Option<serde_json::Value>,
    primitives: Vec<PrimitiveEntry>,
}

/// A field that must be there, but may be null.
fn or_null<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    Option::deserialize(deserializer)
}

pub(super) fn parse(text: &str) -> Result<Found, Fault> {
    let head: Head = serde_json::from_str(text).map_err(|e| json_fault(&e))?;
    if head.format.as_deref() != Some(FORMAT) {
        return Err(Fault::whole(format!(
            "it is JSON, but not a file of primitives (its \"format\" is not \"{FORMAT}\"); give a \
             {PRIMITIVES_FILE} or the folder of a run"
        )));
    }
    if head.version != Some(VERSION) {
        let found = head.version.map_or("missing".to_owned(), |v| v.to_string());
        return Err(Fault::whole(format!(
            "its version is {found}, but only version {VERSION} is supported; export it again or use a \
             newer program"
        )));
    }
    let file: File = serde_json::from_str(text).map_err(|e| json_fault(&e))?;
    let mut notes = Vec::new();
    let params = file.params.filter(|params| !params.is_null()).and_then(|params| {
        let read = serde_json::from_value::<Params>(params);
        if read.is_err() {
            notes.push("its parameters belong to a different version and were ignored".to_owned());
        }
        read.ok()
    });
    let primitives = file
        .primitives
        .into_iter()
        .map(|entry| {
            let id = entry.id;
            primitive(entry).map_err(|problem| Fault::whole(format!("primitive {id}: {problem}")))
        })
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Found {
        input: file.input,
        points: file.points,
        seed: file.seed,
        sampling_seed: file.sampling_seed,
        params,
        primitives,
        notes,
    })
}

fn json_fault(error: &serde_json::Error) -> Fault {
    let whole = error.to_string();
    let problem = whole.split(" at line ").next().unwrap_or(&whole).to_owned();
    match error.line() {
        0 => Fault::whole(problem),
        line => Fault::at_line(line, problem),
    }
}

fn primitive(entry: PrimitiveEntry) -> Result<Primitive, String> {
    Ok(Primitive {
        id: entry.id,
        shape: Superquadric {
            exponents: entry.eps,
            semi_axes: Vector3::from(entry.scale),
            rotation: rotation(entry.rotation, ORTHONORMAL)?,
            translation: Vector3::from(entry.translation),
            taper: entry.taper,
        },
        sigma: entry.sigma,
        points: entry.points,
        mean_distance: entry.mean_distance,
        locked: false,
    })
}
