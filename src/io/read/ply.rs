//! PLY, ASCII and binary in both byte orders: vertices with colours, normals and labels; faces as
//! polygons or triangle strips. Other elements and properties are skipped.
//!
//! Parsed here because existing crates allocate whatever a header declares, and name neither line
//! nor byte of an error.

use super::columns::{Color, Gatherer, Roles};
use super::raw::Raw;
use super::text;
use crate::io::error::Fault;
use header::{Element, Encoding, Header, Kind};
use values::{AsciiValues, BinaryValues, Values};

mod header;
mod values;

/// The spherical harmonic of degree 0, √(1/4π): colours of Gaussian splats are
/// multiples of it, around a half.
const HARMONIC: f64 = 0.282_094_791_773_878_14;

/// Whether a text begins as a PLY file does.
pub(super) fn is_ply(text: &str) -> bool {
    let first = text.trim_start().split(['\n', '\r']).next().unwrap_or_default();
    first.trim_end().eq_ignore_ascii_case("ply")
}

pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => parse_plain(text::decode(bytes).as_bytes()),
        [0xef, 0xbb, 0xbf, rest @ ..] => parse_plain(rest),
        _ => parse_plain(bytes),
    }
}

/// The same, without a mark of the byte order.
fn parse_plain(bytes: &[u8]) -> Result<Raw, Fault> {
    let header = Header::parse(bytes)?;
    match header.encoding {
        Encoding::Ascii => {
            let on_lines = header.elements.iter().filter(|element| !element.properties.is_empty());
            let elements = on_lines.fold(0, |all, element| element.count.saturating_add(all));
            body(&header, AsciiValues::new(&bytes[header.length..], header.lines, elements))
        }
        Encoding::Binary { big_endian } => body(&header, BinaryValues::new(bytes, header.length, big_endian)),
    }
}

fn body(header: &Header, mut values: impl Values) -> Result<Raw, Fault> {
    let mut raw = Raw::default();
    let vertices = header.elements.iter().find(|e| e.is_vertex()).map_or(0, |e| e.count);
    for element in &header.elements {
        // What a header claims is checked against what there is before
        // anything is set aside for it.
        if let Some(most) = values.most(element).filter(|&most| element.count > most) {
            return Err(values.fault(format!(
                "the header declares {} elements “{}”, but the file has room for at most {most}; the file \
                 may be truncated",
                element.count, element.name
            )));
        }
        if element.is_vertex() && raw.points.is_empty() {
            read_vertices(element, &mut values, &mut raw)?;
        } else if element.is_face() && element.count > 0 {
            let list = element.face_list().ok_or_else(|| {
                Fault::whole("its faces lack the property list vertex_indices; export the shape again")
            })?;
            read_faces(element, list, &mut values, vertices, &mut raw)?;
        } else {
            raw.lines += if element.is_edge() { element.count as usize } else { 0 };
            skip(element, &mut values)?;
        }
    }
    raw.notes.extend(values.end());
    if raw.points.is_empty() {
        return Err(Fault::whole("it has no vertices; export the shape again"));
    }
    Ok(raw)
}

fn read_vertices(element: &Element, values: &mut impl Values, raw: &mut Raw) -> Result<(), Fault> {
    let names: Vec<&str> = element.properties.iter().map(|p| p.name.as_str()).collect();
    let Some(mut roles) = Roles::of(&names) else {
        let problem = match names.contains(&"packed_position") {
            true => {
                "its Gaussian splats are packed (packed_position); save them as a PLY without compression"
            }
            false => "its vertices lack the properties x, y and z; export the shape again",
        };
        return Err(Fault::whole(problem));
    };
    let is_list = |&p: &usize| matches!(element.properties[p].kind, Kind::List { .. });
    if roles.position.iter().any(is_list) {
        return Err(Fault::whole("a vertex coordinate is a list; export the shape again"));
    }
    roles.normal = roles.normal.filter(|n| !n.iter().any(is_list));
    roles.label = roles.label.filter(|l| !is_list(l));
    roles.color = roles.color.filter(|color| match color {
        Color::Channels(columns) => !columns.iter().any(is_list),
        Color::Packed(column) => matches!(element.properties[*column].kind, Kind::Scalar(s) if !s.is_float()),
    });
    // Gaussian splats have no other colours.
    let place = |name: &str| names.iter().position(|n| *n == name);
    let harmonics = || Some([place("f_dc_0")?, place("f_dc_1")?, place("f_dc_2")?]);
    let harmonics = harmonics().filter(|h| roles.color.is_none() && !h.iter().any(is_list));
    roles.color = roles.color.or(harmonics.map(Color::Channels));
    let whole_colors = match roles.color {
        Some(Color::Channels(columns)) => columns
            .iter()
            .all(|&p| matches!(element.properties[p].kind, Kind::Scalar(scalar) if !scalar.is_float())),
        _ => true,
    };
    let count = element.count as usize;
    let mut gatherer = Gatherer::new(roles, count);
    let mut row = vec![0.0; element.properties.len()];
    for _ in 0..count {
        values.start(element)?;
        for (slot, property) in row.iter_mut().zip(&element.properties) {
            *slot = values.property(property.kind, None)?;
        }
        for column in harmonics.into_iter().flatten() {
            row[column] = (0.5 + HARMONIC * row[column]).clamp(0.0, 1.0);
        }
        gatherer.push(&row);
    }
    gatherer.finish(whole_colors, raw);
    if place("rot_0").is_some() && place("scale_0").is_some() {
        let colors = if harmonics.is_some() { " with their mean colours (f_dc)" } else { "" };
        let left_out = "sizes, rotations and opacities were ignored";
        raw.notes.push(format!("Gaussian splats were read as points{colors}; {left_out}"));
    }
    Ok(())
}

fn read_faces(
    element: &Element,
    list: usize,
    values: &mut impl Values,
    vertices: u64,
    raw: &mut Raw,
) -> Result<(), Fault> {
    let strips = element.name.eq_ignore_ascii_case("tristrips");
    let (mut corners, mut face): (Vec<f64>, Vec<u32>) = Default::default();
    // NaN and fractions fail the comparison or the truncation test.
    let index = |v: f64| (v >= 0.0 && v < vertices as f64 && v.fract() == 0.0).then_some(v as u32);
    for _ in 0..element.count {
        values.start(element)?;
        for (i, property) in element.properties.iter().enumerate() {
            values.property(property.kind, (i == list).then_some(&mut corners))?;
        }
        let mut add = |corners: &[f64]| {
            face.clear();
            face.extend(corners.iter().map_while(|&v| index(v)));
            if face.len() == corners.len() {
                raw.polygon(&face);
            } else {
                raw.faces_out_of_range += 1;
            }
        };
        // A strip starts anew at each −1, and each vertex after the second
        // closes a triangle.
        if strips {
            corners.split(|&v| v == -1.0).flat_map(|strip| strip.windows(3)).for_each(add);
        } else {
            add(&corners);
        }
    }
    Ok(())
}

fn skip(element: &Element, values: &mut impl Values) -> Result<(), Fault> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        values.start(element)?;
        for property in &element.properties {
            values.property(property.kind, None)?;
        }
    }
    Ok(())
}
