//! Wavefront OBJ: positions with colours and normals, and faces, read with tobj.
//!
//! tobj is stricter than many real files: it supports neither line continuation nor comments
//! outside UTF-8, fails at the first out-of-range index without naming its line, and drops vertices
//! that no face uses, so that a file of points comes out empty. The text is therefore first
//! rewritten as plain `v` and `f` lines. tobj returns vertices in order of first use, so each one
//! carries its number in the file in place of its colour, by which the original order is restored.
//! A file without faces is a cloud of its vertices.

use std::borrow::Cow;
use std::fmt::Write as _;

use nalgebra::Point3;

use super::columns;
use super::raw::Raw;
use super::text::{counted, lines, number, quoted};
use crate::io::error::Fault;
use crate::io::shape::Attributes;

const OPTIONS: tobj::LoadOptions =
    tobj::LoadOptions { single_index: false, triangulate: false, ignore_points: true, ignore_lines: true };

/// First words of the lines of numbers that are read here.
const NUMBERS: [&str; 5] = ["v", "vn", "f", "fo", "l"];

pub(super) fn parse(text: &str) -> Result<Raw, Fault> {
    let mut plain = Plain::new(text)?;
    let mut raw = Raw { faces_out_of_range: plain.faces_out_of_range, lines: plain.lines, ..Raw::default() };
    raw.attributes = plain.attributes(&mut raw.notes);
    raw.points = std::mem::take(&mut plain.points);
    let has_faces = plain.faces > 0 || plain.faces_out_of_range > 0;
    if plain.free_forms > 0 && !has_faces {
        // Their vertices are control points, which need not lie on the shape.
        let problem = "its curves and surfaces are free-form (curv, surf), which cannot be read; export it \
             as polygons";
        return Err(Fault::whole(problem));
    } else if plain.free_forms > 0 {
        let forms = counted(plain.free_forms, "free-form curve or surface", "free-form curves and surfaces");
        raw.notes.push(format!("ignored {forms}: only polygons are supported"));
    }
    if plain.faces == 0 {
        return Ok(raw);
    }
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut plain.source.as_bytes(), &OPTIONS, no_materials)
        .map_err(|e| Fault::whole(format!("its faces cannot be parsed: {e}")))?;
    for tobj::Model { mesh, .. } in models {
        let in_file = |i: u32| mesh.vertex_color.get(3 * i as usize).map(|number| *number as u32);
        let corners: Vec<u32> = mesh.indices.iter().filter_map(|&i| in_file(i)).collect();
        // Without them all faces are triangles.
        if mesh.face_arities.is_empty() {
            corners.chunks(3).for_each(|face| raw.polygon(face));
        }
        let mut rest = &corners[..];
        for &corners in &mesh.face_arities {
            let (face, others) = rest.split_at(rest.len().min(corners as usize));
            raw.polygon(face);
            rest = others;
        }
    }
    Ok(raw)
}

/// The file in plain lines, and its points.
#[derive(Debug)]
struct Plain {
    source: String,
    faces: usize,
    faces_out_of_range: usize,
    /// Lines, and faces of fewer than three corners.
    lines: usize,
    /// Curves and surfaces that have control points for vertices.
    free_forms: usize,
    points: Vec<Point3<f64>>,
    /// The three numbers after the coordinates, of the vertices that have them.
    extras: Vec<[f32; 3]>,
    /// The file's normals, and which of them each vertex has.
    normals: Vec<[f32; 3]>,
    normal_of: Vec<Normal>,
}

/// What the faces say of the normal of a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Normal {
    Unknown,
    Is([f32; 3]),
    /// Each corner has its own.
    Many,
}

impl Plain {
    fn new(text: &str) -> Result<Self, Fault> {
        // Relative indices count from here, absolute ones may point ahead.
        let vertices = lines(text).filter(|(_, l)| l.split_whitespace().next() == Some("v")).count();
        let mut this = Self {
            source: String::with_capacity(text.len()),
            faces: 0,
            faces_out_of_range: 0,
            lines: 0,
            free_forms: 0,
            points: Vec::with_capacity(vertices),
            extras: Vec::new(),
            normals: Vec::new(),
            normal_of: vec![Normal::Unknown; vertices],
        };
        let mut lines = lines(text);
        while let Some((line_number, line)) = lines.next() {
            let mut line = Cow::Borrowed(line);
            // Names and comments may end with a backslash that means nothing.
            let takes_numbers = line.split_whitespace().next().is_some_and(|word| NUMBERS.contains(&word));
            while takes_numbers && !line.contains('#') {
                let Some(continued) = line.trim_end().strip_suffix('\\') else { break };
                let next = lines.next().map_or("", |(_, l)| l);
                line = Cow::Owned(format!("{continued} {next}"));
            }
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => this.vertex(words, line_number)?,
                Some("vn") => {
                    let mut value = || words.next().and_then(number).unwrap_or(f64::NAN) as f32;
                    this.normals.push([value(), value(), value()]);
                }
                Some("f" | "fo") => this.face(words, line_number, vertices)?,
                Some("l") => this.lines += 1,
                Some("curv" | "surf") => this.free_forms += 1,
                _ => {}
            }
        }
        Ok(this)
    }

    fn vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a str>, line: usize) -> Result<(), Fault> {
        let mut coordinate = || {
            let token =
                words.next().ok_or_else(|| Fault::at_line(line, "a vertex needs three coordinates"))?;
            number(token).ok_or_else(|| Fault::at_line(line, format!("{} is not a number", quoted(token))))
        };
        let p = Point3::new(coordinate()?, coordinate()?, coordinate()?);
        // tobj needs to see numbers, not which: the points are kept here.
        let _ = writeln!(self.source, "v 0 0 0 {} 0 0", self.points.len());
        self.points.push(p);
        let rest: Vec<f64> = words.map_while(number).collect();
        if let [r, g, b] | [r, g, b, _] = rest[..] {
            self.extras.push([r, g, b].map(|v| v as f32));
        }
        Ok(())
    }

    fn face<'a>(
        &mut self,
        words: impl Iterator<Item = &'a str>,
        line: usize,
        vertices: usize,
    ) -> Result<(), Fault> {
        let start = self.source.len();
        self.source.push('f');
        let (mut corners, mut in_range) = (0, true);
        for word in words.take_while(|w| !w.starts_with('#')) {
            let mut parts = word.split('/');
            let token = parts.next().unwrap_or_default();
            let index: i64 = token.parse().map_err(|_| {
                Fault::at_line(line, format!("{} is not the index of a vertex", quoted(word)))
            })?;
            let absolute = if index < 0 { self.points.len() as i64 + 1 + index } else { index };
            let is_vertex = (1..=vertices as i64).contains(&absolute);
            in_range &= is_vertex;
            if is_vertex {
                self.corner(absolute as usize - 1, parts.nth(1));
            }
            corners += 1;
            let _ = write!(self.source, " {absolute}");
        }
        self.source.push('\n');
        if in_range && corners >= 3 {
            self.faces += 1;
        } else {
            self.source.truncate(start);
            self.faces_out_of_range += usize::from(!in_range);
            self.lines += usize::from(in_range && corners == 2);
        }
        Ok(())
    }

    /// Notes the normal of a corner at a vertex.
    fn corner(&mut self, vertex: usize, normal: Option<&str>) {
        let slot = &mut self.normal_of[vertex];
        let index = normal.and_then(|token| token.parse::<i64>().ok());
        let found = index.and_then(|i| {
            let at = if i < 0 { self.normals.len() as i64 + i } else { i - 1 };
            usize::try_from(at).ok().and_then(|at| self.normals.get(at))
        });
        *slot = match (found, *slot) {
            (Some(normal), Normal::Unknown) => Normal::Is(*normal),
            (Some(normal), Normal::Is(known)) if *normal == known => Normal::Is(known),
            _ => Normal::Many,
        };
    }

    /// Vertex colours and normals, where every vertex that is used has one.
    fn attributes(&mut self, notes: &mut Vec<String>) -> Attributes {
        let count = self.points.len();
        let colors = std::mem::take(&mut self.extras);
        let colors =
            Some(colors).filter(|c| c.len() == count).and_then(|c| columns::colors(&c, false, notes));
        let is_cloud = self.faces == 0 && self.faces_out_of_range == 0;
        let normals = if is_cloud && self.normals.len() == count {
            Some(std::mem::take(&mut self.normals))
        } else if self.normal_of.contains(&Normal::Many)
            || !self.normal_of.iter().any(|n| *n != Normal::Unknown)
        {
            None
        } else {
            let value = |n: &Normal| if let Normal::Is(value) = n { *value } else { [0.0; 3] };
            Some(self.normal_of.iter().map(value).collect())
        };
        Attributes { colors, normals: normals.and_then(columns::normals), labels: None }
    }
}
