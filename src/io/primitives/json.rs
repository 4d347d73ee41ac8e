//! `primitives.json`, version 1.

use std::io::{self, Write};

use nalgebra::Vector3;
use serde::{Deserialize, Deserializer, Serialize};

use super::schema::{FORMAT, VERSION};
use super::set::{PrimitiveSet, checked};
use super::stored::{Found, rotation};
use crate::geometry::Superquadric;
use crate::inference::{Method, Params, Primitive};
use crate::io::error::Fault;
use crate::io::names::PRIMITIVES_FILE;
use crate::io::write::json;

/// One entry of `primitives.json`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PrimitiveEntry {
    id: u32,
    eps: [f64; 2],
    scale: [f64; 3],
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
    taper: [f64; 2],
    sigma: f64,
    points: usize,
    mean_distance: f64,
}

impl PrimitiveEntry {
    fn new(p: &Primitive) -> io::Result<Self> {
        checked(p)?;
        let rotation = p.shape.rotation.matrix();
        Ok(Self {
            id: p.id,
            eps: p.shape.exponents,
            scale: p.shape.semi_axes.into(),
            rotation: [0, 1, 2].map(|row| [0, 1, 2].map(|column| rotation[(row, column)])),
            translation: p.shape.translation.into(),
            taper: p.shape.taper,
            sigma: p.sigma,
            points: p.points,
            mean_distance: p.mean_distance,
        })
    }
}

#[derive(Debug, Serialize)]
struct PrimitivesFile<'a> {
    format: &'static str,
    version: u32,
    program: &'static str,
    input: Option<&'a str>,
    units: &'static str,
    rotation: &'static str,
    seed: Option<u64>,
    points: Option<usize>,
    sampling_seed: Option<u64>,
    method: Option<Method>,
    params: Option<&'a Params>,
    primitives: Vec<PrimitiveEntry>,
}

/// `{"format": "superform-primitives", "version": 1, …, "primitives": [{"id",
/// "eps": [ε1, ε2], "scale": [ax, ay, az], "rotation": [rows of world_from_local],
/// "translation", "taper": [kx, ky], "sigma", "points", "mean_distance"}]}`, lengths in
/// input units. The same run gives the same bytes. The schema is
/// `docs/primitives.schema.json`.
pub(in crate::io) fn write(w: &mut (impl Write + ?Sized), set: &PrimitiveSet<'_>) -> io::Result<()> {
    let file = PrimitivesFile {
        format: FORMAT,
        version: VERSION,
        program: concat!("superform ", env!("CARGO_PKG_VERSION")),
        input: set.input,
        units: "those of the input",
        rotation: "world from local, rows",
        seed: set.seed,
        points: set.points,
        sampling_seed: set.sampling_seed,
        method: set.params.and_then(Method::of),
        params: set.params,
        primitives: set.primitives.iter().map(PrimitiveEntry::new).collect::<Result<_, _>>()?,
    };
    json(w, &file)
}

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
struct StoredFile {
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
    let file: StoredFile = serde_json::from_str(text).map_err(|e| json_fault(&e))?;
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
