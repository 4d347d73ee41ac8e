//! Meshes in parts as PLY, OBJ and STL.

use std::io::{self, Write};

use nalgebra::{Point3, Vector3};

use super::cloud::begin_ply;
use super::parts::Parts;
use super::text::Text;

/// One mesh, its faces in their order, each with the id of its part.
pub(super) fn ply(w: &mut impl Write, parts: &Parts, binary: bool, colors: bool) -> io::Result<()> {
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
pub(super) fn obj(w: &mut impl Write, parts: &Parts, mtl: Option<&str>) -> io::Result<()> {
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
pub(super) fn mtl(w: &mut impl Write, parts: &Parts) -> io::Result<()> {
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
pub(super) fn stl_text(w: &mut impl Write, parts: &Parts) -> io::Result<()> {
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
