//! Meshes in parts as PLY, OBJ and STL.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};

use super::cloud::begin_ply;
use super::parts::{Parts, PartsFormat};
use super::place::is_written_through;
use super::text::Text;
use super::writing::{Writing, content};
use crate::io::error::WriteError;

pub(super) const PLY: PartsFormat = PartsFormat {
    write: |writing, path, parts, options| {
        writing.files.stage(path, |w| ply(w, parts, options.binary, options.colors))
    },
    size: |n, options| match options.binary {
        true => n.vertices * (24 + 12 * n.normals) + n.faces * (17 + 3 * n.colors) + 400,
        false => n.vertices * (n.place + 36 * n.normals) + n.faces * (3 * n.digits + 8 + 12 * n.colors) + 400,
    },
    beside: |_, _| None,
};
pub(super) const OBJ: PartsFormat = PartsFormat {
    write: |writing, path, parts, options| obj_with_materials(writing, path, parts, options.colors),
    size: |n, _| {
        n.vertices * (n.place + 2 + 36 * n.normals)
            + n.faces * (3 * n.digits + 5 + (3 * n.digits + 6) * n.normals)
            + 100 * n.primitives
    },
    beside: |path, options| materials(path).filter(|_| options.colors),
};
pub(super) const STL: PartsFormat = PartsFormat {
    write: |writing, path, parts, options| {
        if !options.binary {
            return writing.files.stage(path, |w| stl_text(w, parts));
        }
        writing.notes.extend(parts.single_precision().map_err(content(path))?);
        writing.files.stage(path, |w| stl_binary(w, parts, options.colors))
    },
    size: |n, options| if options.binary { 84 + 50 * n.faces } else { n.faces * (3 * n.place + 100) },
    beside: |_, _| None,
};

/// The file beside an OBJ that has its colours, if there is a place beside it.
fn materials(path: &Path) -> Option<PathBuf> {
    // The OBJ is text, and must be able to name it.
    let name = path.with_extension("mtl").file_name()?.to_string_lossy().into_owned();
    (!is_written_through(path)).then(|| path.with_file_name(name))
}

fn obj_with_materials(
    writing: &mut Writing,
    path: &Path,
    parts: &Parts,
    colors: bool,
) -> Result<(), WriteError> {
    let materials = materials(path).filter(|_| colors);
    if colors && materials.is_none() {
        let lost = "an OBJ stores its colours in a second file, which cannot be written here; they are \
                    omitted";
        writing.notes.push(lost.to_owned());
    }
    let name = materials.as_deref().and_then(Path::file_name).map(|n| n.to_string_lossy());
    writing.files.stage(path, |w| obj(w, parts, name.as_deref()))?;
    match materials {
        Some(materials) => writing.files.stage(&materials, |w| mtl(w, parts)),
        None => Ok(()),
    }
}

/// One mesh, its faces in their order, each with the id of its part.
fn ply(w: &mut impl Write, parts: &Parts, binary: bool, colors: bool) -> io::Result<()> {
    begin_ply(w, binary, parts.vertices.len())?;
    if parts.normals.is_some() {
        w.write_all(b"property float nx\nproperty float ny\nproperty float nz\n")?;
    }
    write!(w, "element face {}\nproperty list uchar int vertex_indices\n", parts.faces.len())?;
    if colors {
        w.write_all(b"property uchar red\nproperty uchar green\nproperty uchar blue\n")?;
    }
    w.write_all(b"property int label\nend_header\n")?;
    for (i, p) in parts.vertices.iter().enumerate() {
        let normal = parts.normals.as_ref().map(|normals| normals[i].map(|c| c as f32));
        if binary {
            p.iter().try_for_each(|c| w.write_all(&c.to_le_bytes()))?;
            normal.iter().flatten().try_for_each(|c| w.write_all(&c.to_le_bytes()))?;
        } else {
            write!(w, "{} {} {}", Text(p.x), Text(p.y), Text(p.z))?;
            normal.iter().flatten().try_for_each(|c| write!(w, " {}", Text(*c)))?;
            w.write_all(b"\n")?;
        }
    }
    for (i, face) in parts.faces.iter().enumerate() {
        let part = parts.part(i);
        if binary {
            w.write_all(&[3])?;
            face.iter().try_for_each(|&v| w.write_all(&(v as i32).to_le_bytes()))?;
            w.write_all(if colors { &part.color } else { &[] })?;
            w.write_all(&part.label.to_le_bytes())?;
        } else {
            write!(w, "3 {} {} {}", face[0], face[1], face[2])?;
            if colors {
                let [r, g, b] = part.color;
                write!(w, " {r} {g} {b}")?;
            }
            writeln!(w, " {}", part.label)?;
        }
    }
    Ok(())
}

/// An object a part; their colours are in the file of materials `mtl`.
fn obj(w: &mut impl Write, parts: &Parts, mtl: Option<&str>) -> io::Result<()> {
    writeln!(w, "# superform {}; an object a primitive", env!("CARGO_PKG_VERSION"))?;
    if let Some(mtl) = mtl {
        writeln!(w, "mtllib {mtl}")?;
    }
    for p in &parts.vertices {
        writeln!(w, "v {} {} {}", Text(p.x), Text(p.y), Text(p.z))?;
    }
    for n in parts.normals.iter().flatten() {
        let n = n.map(|c| c as f32);
        writeln!(w, "vn {} {} {}", Text(n.x), Text(n.y), Text(n.z))?;
    }
    for (part, faces) in parts.parts.iter().zip(parts.by_part()) {
        writeln!(w, "o {}", part.name)?;
        if mtl.is_some() {
            writeln!(w, "usemtl {}", part.name)?;
        }
        for face in faces {
            let [a, b, c] = face.map(|i| i + 1);
            if parts.normals.is_some() {
                writeln!(w, "f {a}//{a} {b}//{b} {c}//{c}")?;
            } else {
                writeln!(w, "f {a} {b} {c}")?;
            }
        }
    }
    Ok(())
}

/// The materials of an OBJ.
fn mtl(w: &mut impl Write, parts: &Parts) -> io::Result<()> {
    for part in &parts.parts {
        let [r, g, b] = part.color.map(|c| f32::from(c) / 255.0);
        write!(w, "newmtl {}\nKa 0 0 0\nKd {r:.4} {g:.4} {b:.4}\nKs 0 0 0\nillum 1\n\n", part.name)?;
    }
    Ok(())
}

fn normal([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    let (u, v) = (b - a, c - a);
    // Scaled, so that squares of small numbers don't vanish.
    let size = u.amax().max(v.amax()).max(f64::MIN_POSITIVE);
    (u / size).cross(&(v / size)).try_normalize(0.0).unwrap_or_else(Vector3::zeros)
}

/// A solid a part.
fn stl_text(w: &mut impl Write, parts: &Parts) -> io::Result<()> {
    for (part, faces) in parts.parts.iter().zip(parts.by_part()) {
        writeln!(w, "solid {}", part.name)?;
        for face in faces {
            let corners = face.map(|i| parts.vertices[i as usize]);
            let n = normal(&corners).map(|c| c as f32);
            writeln!(w, "facet normal {} {} {}\nouter loop", Text(n.x), Text(n.y), Text(n.z))?;
            for p in corners {
                writeln!(w, "vertex {} {} {}", Text(p.x), Text(p.y), Text(p.z))?;
            }
            w.write_all(b"endloop\nendfacet\n")?;
        }
        writeln!(w, "endsolid {}", part.name)?;
    }
    Ok(())
}

/// All faces in their order; the two free bytes of each hold its colour, five
/// bits each of red, green and blue under a bit that is set, as VisCAM and
/// SolidView have it.
pub(super) fn stl_binary(w: &mut impl Write, parts: &Parts, colors: bool) -> io::Result<()> {
    let mut head = [b' '; 80];
    let text = concat!("superform ", env!("CARGO_PKG_VERSION"));
    head[..text.len()].copy_from_slice(text.as_bytes());
    w.write_all(&head)?;
    w.write_all(&(parts.faces.len() as u32).to_le_bytes())?;
    for (i, face) in parts.faces.iter().enumerate() {
        let corners = face.map(|v| parts.vertices[v as usize]);
        let places = corners.iter().map(|p| p.coords);
        for v in std::iter::once(normal(&corners)).chain(places) {
            v.iter().try_for_each(|&c| w.write_all(&(c as f32).to_le_bytes()))?;
        }
        let [r, g, b] = parts.part(i).color.map(|c| u16::from(c >> 3));
        let attribute = if colors { 1 << 15 | r << 10 | g << 5 | b } else { 0 };
        w.write_all(&attribute.to_le_bytes())?;
    }
    Ok(())
}
