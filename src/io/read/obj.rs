//! Wavefront OBJ: positions and faces, through tobj.
//!
//! tobj is strict where files in the wild are not: it knows no line
//! continuation and no comment outside UTF-8, gives up at the first index
//! that is out of range without naming its line, and drops vertices that no
//! face uses, so that a file of points comes out empty. The text is therefore
//! first put into plain `v` and `f` lines, which tobj parses and triangulates
//! (polygons as fans); a file without faces is a cloud of its vertices.

use std::borrow::Cow;
use std::fmt::Write as _;

use nalgebra::Point3;

use super::raw::{Raw, color_bytes};
use super::text::{lines, number, quoted};
use crate::io::Attributes;
use crate::io::error::Fault;

const OPTIONS: tobj::LoadOptions =
    tobj::LoadOptions { single_index: false, triangulate: true, ignore_points: true, ignore_lines: true };

pub(super) fn parse(text: &str) -> Result<Raw, Fault> {
    let plain = Plain::new(text)?;
    let faces_out_of_range = plain.faces_out_of_range;
    if plain.faces == 0 {
        let attributes = Attributes { colors: plain.colors(), ..Attributes::default() };
        return Ok(Raw { points: plain.points, attributes, faces_out_of_range, ..Raw::default() });
    }
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut plain.source.as_bytes(), &OPTIONS, no_materials)
        .map_err(|e| Fault::whole(format!("its faces can't be made out: {e}")))?;
    let mut raw = Raw { faces_out_of_range, ..Raw::default() };
    for tobj::Model { mesh, .. } in models {
        let offset = raw.points.len() as u32;
        raw.points.extend(mesh.positions.chunks_exact(3).map(|p| Point3::new(p[0], p[1], p[2])));
        raw.triangles.extend(mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| i + offset)));
    }
    Ok(raw)
}

/// The file in plain lines, and its points.
#[derive(Debug)]
struct Plain {
    source: String,
    faces: usize,
    faces_out_of_range: usize,
    points: Vec<Point3<f64>>,
    /// The three numbers after the coordinates, of the vertices that have them.
    extras: Vec<[f64; 3]>,
}

impl Plain {
    fn new(text: &str) -> Result<Self, Fault> {
        // Relative indices count from here, absolute ones may point ahead.
        let vertices = lines(text).filter(|(_, l)| l.split_whitespace().next() == Some("v")).count();
        let mut this = Self {
            source: String::with_capacity(text.len()),
            faces: 0,
            faces_out_of_range: 0,
            points: Vec::with_capacity(vertices),
            extras: Vec::new(),
        };
        let mut lines = lines(text);
        while let Some((line_number, line)) = lines.next() {
            let mut line = Cow::Borrowed(line);
            while let Some(continued) = line.trim_end().strip_suffix('\\') {
                let next = lines.next().map_or("", |(_, l)| l);
                line = Cow::Owned(format!("{continued} {next}"));
            }
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => this.vertex(words, line_number)?,
                Some("f" | "fo") => this.face(words, line_number, vertices)?,
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
        self.points.push(p);
        // Shortest decimals that give back the same number.
        let _ = writeln!(self.source, "v {:?} {:?} {:?}", p.x, p.y, p.z);
        let rest: Vec<f64> = words.map_while(number).collect();
        if let [r, g, b] | [r, g, b, _] = rest[..] {
            self.extras.push([r, g, b]);
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
            let token = word.split('/').next().unwrap_or_default();
            let index: i64 = token.parse().map_err(|_| {
                Fault::at_line(line, format!("{} is not the index of a vertex", quoted(word)))
            })?;
            let absolute = if index < 0 { self.points.len() as i64 + 1 + index } else { index };
            in_range &= (1..=vertices as i64).contains(&absolute);
            corners += 1;
            let _ = write!(self.source, " {absolute}");
        }
        self.source.push('\n');
        if in_range && corners >= 3 {
            self.faces += 1;
        } else {
            self.source.truncate(start);
            self.faces_out_of_range += usize::from(!in_range);
        }
        Ok(())
    }

    /// Vertex colours, where every vertex has them.
    fn colors(&self) -> Option<Vec<[u8; 3]>> {
        (self.extras.len() == self.points.len()).then(|| color_bytes(&self.extras)).flatten()
    }
}
