//! PLY, ASCII and binary of either byte order: vertices with their colours,
//! normals and labels, faces as polygons or triangle strips. Other elements and
//! properties are stepped over.
//!
//! Read here because the crates for it set aside what a header announces, and
//! name neither line nor byte of a fault.

use super::columns::{Color, Gatherer, Roles};
use super::raw::Raw;
use super::text;
use crate::io::error::Fault;
use header::{Element, Encoding, Header, Kind};
use values::{AsciiValues, BinaryValues, Values};

mod header;
mod values;

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
        Encoding::Ascii => body(&header, AsciiValues::new(&bytes[header.length..], header.lines)),
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
                "the header announces {} elements “{}”, but there is room for {most} at most; the file may have been cut short",
                element.count, element.name
            )));
        }
        if element.is_vertex() && raw.points.is_empty() {
            read_vertices(element, &mut values, &mut raw)?;
        } else if let Some(list) = element.face_list() {
            read_faces(element, list, &mut values, vertices, &mut raw)?;
        } else {
            skip(element, &mut values)?;
        }
    }
    if raw.points.is_empty() {
        return Err(Fault::whole("it has no vertices; export the shape again"));
    }
    Ok(raw)
}

fn read_vertices(element: &Element, values: &mut impl Values, raw: &mut Raw) -> Result<(), Fault> {
    let names: Vec<&str> = element.properties.iter().map(|p| p.name.as_str()).collect();
    let Some(mut roles) = Roles::of(&names) else {
        return Err(Fault::whole("its vertices lack the properties x, y and z; export the shape again"));
    };
    let is_list = |&p: &usize| matches!(element.properties[p].kind, Kind::List { .. });
    if roles.position.iter().any(is_list) {
        return Err(Fault::whole("a coordinate of its vertices is a list; export the shape again"));
    }
    roles.normal = roles.normal.filter(|n| !n.iter().any(is_list));
    roles.label = roles.label.filter(|l| !is_list(l));
    roles.color = roles.color.filter(|color| match color {
        Color::Channels(columns) => !columns.iter().any(is_list),
        Color::Packed(column) => matches!(element.properties[*column].kind, Kind::Scalar(s) if !s.is_float()),
    });
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
        gatherer.push(&row);
    }
    gatherer.finish(whole_colors, raw);
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
    let mut corners: Vec<f64> = Vec::new();
    // NaN and fractions fail the comparison or the truncation test.
    let index = |v: f64| (v >= 0.0 && v < vertices as f64 && v.fract() == 0.0).then_some(v as u32);
    for _ in 0..element.count {
        values.start(element)?;
        for (i, property) in element.properties.iter().enumerate() {
            values.property(property.kind, (i == list).then_some(&mut corners))?;
        }
        // A strip starts anew at each −1, and each vertex after the second
        // closes a triangle; a polygon is a fan around its first vertex.
        let mut add = |a: f64, b: f64, c: f64| match (index(a), index(b), index(c)) {
            (Some(a), Some(b), Some(c)) => raw.triangles.push([a, b, c]),
            _ => raw.faces_out_of_range += 1,
        };
        if strips {
            for strip in corners.split(|&v| v == -1.0) {
                strip.windows(3).for_each(|t| add(t[0], t[1], t[2]));
            }
        } else if let [first, rest @ ..] = &corners[..] {
            rest.windows(2).for_each(|t| add(*first, t[0], t[1]));
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
