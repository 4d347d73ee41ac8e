//! Archives of NumPy arrays. Points, faces, normals, colours and labels are recognised by the names
//! of the arrays, then by their shapes.

use std::borrow::Cow;
use std::io::{Cursor, Read};

use zip::ZipArchive;

use super::grid::Grid;
use super::{Array, listed};
use crate::io::content::most_unpacked;
use crate::io::error::Fault;
use crate::io::npy::{Header, LONGEST, shown};
use crate::io::primitives::schema::arrays as schema;
use crate::io::read::columns;
use crate::io::read::raw::Raw;
use crate::io::read::text::counted;

const POINTS: [&str; 14] = [
    "points",
    "point_cloud",
    "pointcloud",
    "cloud",
    "pc",
    "pcd",
    "xyz",
    "coords",
    "coord",
    "pos",
    "positions",
    "position",
    "data",
    "arr_0",
];
const VERTICES: [&str; 4] = ["vertices", "verts", "vertex", "v"];
const FACES: [&str; 5] = ["faces", "triangles", "tris", "face", "f"];
const NORMALS: [&str; 4] = ["normals", "normal", "point_normals", "vertex_normals"];
const COLORS: [&str; 5] = ["colors", "color", "rgb", "point_colors", "vertex_colors"];
const LABELS: [&str; 11] = [
    "labels",
    "label",
    "classes",
    "classification",
    "segmentation",
    "segments",
    "seg",
    "clusters",
    "cluster",
    "parts",
    "part_ids",
];
/// Most arrays that are looked at.
const MOST: usize = 1 << 12;

type Zip<'a> = ZipArchive<Cursor<&'a [u8]>>;

pub(in crate::io::read) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let mut zip = ZipArchive::new(Cursor::new(bytes))
        .map_err(|e| Fault::whole(format!("the archive cannot be opened ({e}); it may be truncated")))?;
    if zip.len() > MOST {
        return Err(Fault::whole(format!("the archive has {} members; the limit is {MOST}", zip.len())));
    }
    let mut arrays: Vec<(String, Header)> = Vec::new();
    let mut members = Vec::new();
    let mut refused = None;
    for i in 0..zip.len() {
        match head_of(&mut zip, i) {
            Some((name, Ok(header))) => {
                arrays.push((name, header));
                members.push(i);
            }
            Some((name, Err(fault))) => refused = refused.or(Some(in_array(&name, fault))),
            None => {}
        }
    }
    let named = |names: &[&str], fits: &dyn Fn(&Header) -> bool| {
        let is = |name: &str, wanted: &str| name.eq_ignore_ascii_case(wanted);
        names.iter().find_map(|wanted| arrays.iter().position(|(name, h)| is(name, wanted) && fits(h)))
    };
    let is_cloud = |h: &Header| Grid::of(h).is_some() || h.is_structured;
    let is_triples = |h: &Header| Grid::of(h).is_some_and(|g| g.width == 3 && !g.turned);
    let faces = named(&FACES, &|h| is_triples(h) && !h.columns[0].scalar.is_float());
    let vertices = named(&VERTICES, &is_triples);
    // Beside primitives other arrays may be called so: numbers of points, say.
    let has = |wanted: &str| arrays.iter().any(|(name, _)| name == wanted);
    let of_primitives = named(&[schema::CLOUD], &is_cloud)
        .filter(|_| [schema::SCALE, schema::EXPONENTS].into_iter().all(has));
    let points = match (vertices, faces) {
        _ if of_primitives.is_some() => of_primitives,
        (Some(vertices), Some(_)) => Some(vertices),
        _ => named(&POINTS, &is_cloud).or(vertices),
    };
    // Without a known name: the only one that can be meant.
    let points = points.or_else(|| {
        let mut fitting = (0..arrays.len()).filter(|&i| is_triples(&arrays[i].1));
        fitting.next().filter(|_| fitting.next().is_none())
    });
    let Some(points) = points else {
        if let Some(fault) = refused.filter(|_| arrays.is_empty()) {
            return Err(fault);
        }
        return Err(Fault::whole(format!(
            "it is not clear which array contains the points: there are {}; name one of them “points” (N×3)",
            listed(&arrays)
        )));
    };
    let mut load = |i: usize| load(&mut zip, members[i], &arrays[i], bytes.len());
    let mut raw = load(points)?.cloud().map_err(|fault| in_array(&arrays[points].0, fault))?;
    let count = raw.points.len();
    raw.notes.push(format!("points were read from the array “{}”", arrays[points].0));
    // As many as there are points, or spread over the same sides.
    let about = &arrays[points].1;
    let sides = if about.is_structured { &about.shape[..] } else { &about.shape[..about.shape.len() - 1] };
    let of_points = |h: &Header, numbers: usize| {
        let of = |sides: &[u64]| {
            h.shape.strip_prefix(sides).is_some_and(|rest| rest.iter().product::<u64>() == numbers as u64)
        };
        !h.is_structured && (of(&[count as u64]) || of(sides))
    };
    if let Some(i) = named(&NORMALS, &|h| is_triples(h) && of_points(h, 3)) {
        raw.attributes.normals = columns::normals(triples(&load(i)?, count));
    }
    if let Some(i) = named(&COLORS, &|h| (3..=4).any(|n| of_points(h, n)) && Grid::of(h).is_some()) {
        let whole = !arrays[i].1.columns[0].scalar.is_float();
        raw.attributes.colors = columns::colors(&triples(&load(i)?, count), whole, &mut raw.notes);
    }
    if let Some(i) = named(&LABELS, &|h| of_points(h, 1)) {
        let array = load(i)?;
        let mut values =
            Grid::of_numbers(&array.header).map(|grid| array.rows(&grid, 0, 1)).unwrap_or_default();
        values.truncate(count);
        raw.attributes.labels = columns::labels(&values, &mut raw.notes).or(raw.attributes.labels);
    }
    if let Some(i) = faces.filter(|_| Some(points) == vertices) {
        let array = load(i)?;
        let indices = Grid::of(&array.header).map(|grid| array.rows(&grid, 0, 3)).unwrap_or_default();
        for face in indices.chunks_exact(3) {
            if face.iter().all(|v| (0.0..count as f64).contains(v)) {
                raw.triangles.push([face[0] as u32, face[1] as u32, face[2] as u32]);
            } else {
                raw.faces_out_of_range += 1;
            }
        }
    }
    Ok(raw)
}

fn in_array(name: &str, fault: Fault) -> Fault {
    Fault { problem: format!("in the array “{name}”: {}", fault.problem), place: None }
}

/// Name and header of a member that is an array; what else there is does no harm.
fn head_of(zip: &mut Zip<'_>, i: usize) -> Option<(String, Result<Header, Fault>)> {
    let member = zip.by_index(i).ok()?;
    let name = member.name().ok()?.strip_suffix(".npy")?.to_owned();
    let mut start = Vec::new();
    // What can't be unpacked in the middle of it is told on loading.
    let _ = member.take(LONGEST as u64 + 12).read_to_end(&mut start);
    Some((name, Header::parse(&start)))
}

/// All bytes of an array.
fn load(
    zip: &mut Zip<'_>,
    i: usize,
    (name, header): &(String, Header),
    whole: usize,
) -> Result<Array<'static>, Fault> {
    let most = most_unpacked(whole);
    if header.size > most {
        let problem = format!(
            "{} are declared, {} bytes, more than the {most} that an archive of this size can contain",
            shown(&header.shape),
            header.size
        );
        return Err(in_array(name, Fault::whole(problem)));
    }
    let damaged =
        |e: &dyn std::fmt::Display| in_array(name, Fault::whole(format!("it cannot be decompressed: {e}")));
    let mut member = zip.by_index(i).map_err(|e| damaged(&e))?;
    let mut body = Vec::new();
    let wanted = header.length as u64 + header.size;
    // The one byte more makes the library compare the checksum.
    (&mut member).take(wanted + 1).read_to_end(&mut body).map_err(|e| damaged(&e))?;
    if (body.len() as u64) < wanted {
        let there = counted(body.len().saturating_sub(header.length), "byte", "bytes");
        let problem = format!("{} are declared, but there are {there}", shown(&header.shape));
        return Err(in_array(name, Fault::whole(problem)));
    }
    body.drain(..header.length);
    Ok(Array { header: header.clone(), body: Cow::Owned(body) })
}

/// The first three numbers of each row.
fn triples(array: &Array<'_>, count: usize) -> Vec<[f32; 3]> {
    let Some(grid) = Grid::of(&array.header) else { return Vec::new() };
    let rows = array.rows(&grid, 0, 3);
    rows.chunks_exact(3).take(count).map(|t| [t[0] as f32, t[1] as f32, t[2] as f32]).collect()
}
