//! Meshes in parts as binary glTF 2.0: one node, mesh and material per part.

use std::io::{self, Write};

use nalgebra::{Isometry3, Point3};
use serde_json::{Value, json};

use super::atomic::unfit;
use super::parts::{Parts, PartsFormat, renumbered};
use super::text::rounding;
use super::writing::content;

pub(super) const GLB: PartsFormat = PartsFormat {
    write: |writing, path, parts, options| {
        writing.notes.extend(single_precision(parts).map_err(content(path))?);
        writing.files.stage(path, |w| glb(w, parts, options.colors))
    },
    size: |n, _| n.vertices * (12 + 12 * n.normals) + n.faces * 12 + 700 * n.primitives + 400,
    beside: |_, _| None,
};

// Numbers of the glTF specification.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The file's content so far.
#[derive(Default)]
struct Scene {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
}

impl Scene {
    /// A view of what has been appended since `start`; its number.
    fn view(&mut self, start: usize, target: u32) -> usize {
        self.views.push(json!({
            "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start, "target": target,
        }));
        self.views.len() - 1
    }

    /// An accessor of vectors; its number.
    fn vectors(&mut self, values: &[[f32; 3]]) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(values.iter().flatten().flat_map(|c| c.to_le_bytes()));
        let view = self.view(start, ARRAY_BUFFER);
        let extreme = |pick: fn(f32, f32) -> f32, from: f32| {
            values.iter().fold([from; 3], |m, v| [0, 1, 2].map(|k| pick(m[k], v[k])))
        };
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": "VEC3",
            "min": extreme(f32::min, f32::INFINITY), "max": extreme(f32::max, f32::NEG_INFINITY),
        }));
        self.accessors.len() - 1
    }

    fn indices(&mut self, faces: impl Iterator<Item = u32>) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(faces.flat_map(u32::to_le_bytes));
        let count = (self.bytes.len() - start) / 4;
        let view = self.view(start, ELEMENT_ARRAY_BUFFER);
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR",
        }));
        self.accessors.len() - 1
    }
}

/// A component of a colour in sRGB as glTF has it: linear.
fn linear(c: u8) -> f64 {
    let c = f64::from(c) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The places of a part's vertices in its frame.
fn local(frame: &Isometry3<f64>, p: &Point3<f64>) -> Point3<f64> {
    frame.inverse_transform_point(p)
}

/// Rejects values out of range for single precision, and notes where it is coarse.
fn single_precision(parts: &Parts) -> io::Result<Option<String>> {
    for (part, faces) in parts.parts.iter().zip(parts.by_part()) {
        let (_, used) = renumbered(&faces, parts.vertices.len());
        let places: Vec<_> = used.iter().map(|&i| local(&part.frame, &parts.vertices[i as usize])).collect();
        if let Some(note) = rounding(places.iter())? {
            return Ok(Some(note));
        }
    }
    Ok(None)
}

fn glb(w: &mut impl Write, parts: &Parts, colors: bool) -> io::Result<()> {
    let mut scene = Scene::default();
    for (part, faces) in parts.parts.iter().zip(parts.by_part()) {
        let (index, used) = renumbered(&faces, parts.vertices.len());
        let single = |v: [f64; 3]| v.map(|c| c as f32);
        let places: Vec<_> = used
            .iter()
            .map(|&i| single(local(&part.frame, &parts.vertices[i as usize]).coords.into()))
            .collect();
        let mut attributes = json!({ "POSITION": scene.vectors(&places) });
        if let Some(normals) = &parts.normals {
            let turned: Vec<_> = used
                .iter()
                .map(|&i| single(part.frame.inverse_transform_vector(&normals[i as usize]).into()))
                .collect();
            attributes["NORMAL"] = json!(scene.vectors(&turned));
        }
        let indices = scene.indices(faces.iter().flatten().map(|&i| index[i as usize]));
        let mut primitive = json!({ "attributes": attributes, "indices": indices });
        let number = scene.meshes.len();
        if colors {
            let [r, g, b] = part.color.map(linear);
            scene.materials.push(json!({
                "name": part.name,
                "pbrMetallicRoughness":
                    { "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.7 },
                "doubleSided": parts.normals.is_none(),
            }));
            primitive["material"] = json!(number);
        }
        scene.meshes.push(json!({ "name": part.name, "primitives": [primitive] }));
        let mut node = json!({ "name": part.name, "mesh": number, "extras": { "label": part.label } });
        let Isometry3 { translation, rotation } = part.frame;
        if part.frame != Isometry3::identity() {
            node["translation"] = json!(<[f64; 3]>::from(translation.vector));
            node["rotation"] = json!(<[f64; 4]>::from(rotation.coords));
        }
        scene.nodes.push(node);
    }

    let all: Vec<usize> = (0..scene.nodes.len()).collect();
    let mut document = json!({
        "asset": { "version": "2.0", "generator": concat!("superform ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [if all.is_empty() { json!({}) } else { json!({ "nodes": all }) }],
    });
    // Lists must not be empty.
    for (name, list) in [
        ("nodes", scene.nodes),
        ("meshes", scene.meshes),
        ("materials", scene.materials),
        ("accessors", scene.accessors),
        ("bufferViews", scene.views),
    ] {
        if !list.is_empty() {
            document[name] = Value::Array(list);
        }
    }
    if !scene.bytes.is_empty() {
        document["buffers"] = json!([{ "byteLength": scene.bytes.len() }]);
    }
    let mut text = serde_json::to_vec(&document)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let binary = if scene.bytes.is_empty() { 0 } else { 8 + scene.bytes.len() };
    let length = |n: usize| u32::try_from(n).map_err(|_| unfit("GLB files are limited to 4 GiB; use PLY"));
    w.write_all(b"glTF")?;
    w.write_all(&2u32.to_le_bytes())?;
    w.write_all(&length(20 + text.len() + binary)?.to_le_bytes())?;
    w.write_all(&length(text.len())?.to_le_bytes())?;
    w.write_all(b"JSON")?;
    w.write_all(&text)?;
    if binary > 0 {
        w.write_all(&length(scene.bytes.len())?.to_le_bytes())?;
        w.write_all(b"BIN\0")?;
        w.write_all(&scene.bytes)?;
    }
    Ok(())
}
