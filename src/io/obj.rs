//! Wavefront OBJ: positions and faces. A file without faces is a cloud of its
//! vertices.
//!
//! Pieces of the text are parsed side by side. Indices that count back from the
//! last vertex are resolved once it is known how many stand before a piece.

use std::borrow::Cow;

use nalgebra::Point3;
use rayon::prelude::*;

use super::error::Fault;
use super::raw::{Raw, color_bytes};
use super::text::{self, lines, number, quoted};

pub(super) fn parse(text: &str) -> Result<Raw, Fault> {
    // A line that is continued on the next must not be cut.
    let size = if text.contains('\\') { text.len() } else { text::PIECE };
    let pieces: Vec<Result<Piece, Fault>> =
        text::pieces(text, size).into_par_iter().map(Piece::parse).collect();
    let mut line = 0;
    let mut sound = Vec::with_capacity(pieces.len());
    let mut raw = Raw::default();
    let mut extras = Vec::new();
    for piece in pieces {
        let mut piece = piece.map_err(|fault| fault.after_lines(line))?;
        line += piece.lines;
        piece.before = raw.points.len() as i64;
        raw.points.append(&mut piece.points);
        extras.append(&mut piece.extras);
        sound.push(piece);
    }
    let vertices = raw.points.len() as i64;
    let faces: Vec<(Vec<[u32; 3]>, usize)> =
        sound.par_iter().map(|piece| piece.triangles(vertices)).collect();
    raw.triangles.reserve_exact(faces.iter().map(|(triangles, _)| triangles.len()).sum());
    for (triangles, out_of_range) in faces {
        raw.triangles.extend(triangles);
        raw.faces_out_of_range += out_of_range;
    }
    // Vertex colours, of a cloud whose vertices all have them.
    if raw.triangles.is_empty() && extras.len() == raw.points.len() {
        raw.colors = color_bytes(&extras);
    }
    Ok(raw)
}

/// What a corner of a face points to.
#[derive(Debug, Clone, Copy)]
enum Index {
    /// From 1, over the whole file; it may point ahead.
    Absolute(i64),
    /// From 1, over the piece; earlier vertices have 0 and less.
    Relative(i64),
}

/// What a piece of the text holds.
#[derive(Debug, Default)]
struct Piece {
    points: Vec<Point3<f64>>,
    /// The three numbers after the coordinates, of the vertices that have them.
    extras: Vec<[f64; 3]>,
    /// The corners of all faces, and where in there each face ends.
    corners: Vec<Index>,
    ends: Vec<usize>,
    /// Line endings.
    lines: usize,
    /// Number of vertices before the piece.
    before: i64,
}

impl Piece {
    fn parse(text: &str) -> Result<Self, Fault> {
        let mut this = Self::default();
        let mut lines = lines(text);
        while let Some((line_number, line)) = lines.next() {
            this.lines = line_number;
            let mut line = Cow::Borrowed(line);
            while let Some(continued) = line.trim_end().strip_suffix('\\') {
                let next = lines.next().map_or("", |(_, l)| l);
                line = Cow::Owned(format!("{continued} {next}"));
            }
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => this.vertex(words, line_number)?,
                Some("f" | "fo") => this.face(words, line_number)?,
                _ => {}
            }
        }
        // What follows the last ending is the next piece's first line.
        this.lines -= usize::from(text.ends_with(['\n', '\r']));
        Ok(this)
    }

    fn vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a str>, line: usize) -> Result<(), Fault> {
        let mut coordinate = || {
            let token =
                words.next().ok_or_else(|| Fault::at_line(line, "a vertex needs three coordinates"))?;
            number(token).ok_or_else(|| Fault::at_line(line, format!("{} is not a number", quoted(token))))
        };
        self.points.push(Point3::new(coordinate()?, coordinate()?, coordinate()?));
        let mut numbers = words.map_while(number).fuse();
        let rest: [Option<f64>; 5] = std::array::from_fn(|_| numbers.next());
        if let [Some(r), Some(g), Some(b), _, None] = rest {
            self.extras.push([r, g, b]);
        }
        Ok(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>, line: usize) -> Result<(), Fault> {
        for word in words.take_while(|w| !w.starts_with('#')) {
            let token = word.split('/').next().unwrap_or_default();
            let index: i64 = token.parse().map_err(|_| {
                Fault::at_line(line, format!("{} is not the index of a vertex", quoted(word)))
            })?;
            self.corners.push(if index < 0 {
                Index::Relative((self.points.len() as i64 + 1).saturating_add(index))
            } else {
                Index::Absolute(index)
            });
        }
        self.ends.push(self.corners.len());
        Ok(())
    }

    /// The faces as triangles, polygons as fans around their first corner, and
    /// the number of faces that point to none of the file's vertices.
    fn triangles(&self, vertices: i64) -> (Vec<[u32; 3]>, usize) {
        let resolve = |index: &Index| {
            let from_one = match *index {
                Index::Absolute(index) => index,
                Index::Relative(index) => index.saturating_add(self.before),
            };
            let in_range = (1..=vertices).contains(&from_one);
            u32::try_from(from_one - 1).ok().filter(|_| in_range)
        };
        let mut triangles = Vec::with_capacity(self.ends.len());
        let mut out_of_range = 0;
        let mut face: Vec<u32> = Vec::new();
        let mut start = 0;
        for &end in &self.ends {
            let corners = &self.corners[start..end];
            start = end;
            face.clear();
            face.extend(corners.iter().map_while(resolve));
            if face.len() < corners.len() {
                out_of_range += 1;
            } else if let [first, rest @ ..] = &face[..] {
                triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }
        }
        (triangles, out_of_range)
    }
}
