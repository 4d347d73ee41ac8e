//! Formats that are known but not read, and what to do about them.

use crate::io::read::text;

/// What a file is, and what to do.
pub(super) type Known = (&'static str, &'static str);

const CONVERT_MESH: &str = "convert it to OBJ, PLY, STL or glTF, with Blender or MeshLab, say";
const CONVERT_CLOUD: &str = "convert it to PLY, PCD, LAS or XYZ text, with CloudCompare, say";
const CONVERT_SOLID: &str = "export a mesh of it (STL, OBJ) from a CAD program";
const UNPACK: &str = "unpack it first and open the shape in it";
const NO_SHAPE: &str = "give a mesh or a point cloud";
const SAVE_ARRAY: &str = "save the points as an array (.npy, N×3) or as XYZ text";

/// By the first bytes.
pub(super) fn foreign_binary(head: &[u8]) -> Option<Known> {
    let magics: [(&[u8], &str, &str); 28] = [
        (b"ASTM-E57", "an E57 point cloud", CONVERT_CLOUD),
        (b"Kaydara FBX", "an FBX scene", CONVERT_MESH),
        (b"BLENDER", "a Blender scene", "export it from Blender as OBJ, PLY, STL or glTF"),
        (b"PXR-USDC", "a USD scene", CONVERT_MESH),
        (b"Ogawa", "an Alembic scene", CONVERT_MESH),
        (b"DRACO", "a mesh compressed with Draco", "export it without compression"),
        (b"xof ", "a DirectX mesh", CONVERT_MESH),
        (b"#ROSBAG", "a ROS bag", "export a cloud from it, as PCD, say"),
        (b"\x89MCAP", "an MCAP recording", "export a cloud from it, as PCD, say"),
        (b"\x89HDF", "an HDF5 file", SAVE_ARRAY),
        (b"MATLAB 5.0 MAT-file", "a MATLAB file", SAVE_ARRAY),
        (b"PAR1", "a Parquet table", "save it as CSV"),
        (b"SQLite format 3", "a database", NO_SHAPE),
        (b"\x80\x02", "a Python pickle", SAVE_ARRAY),
        (b"\x80\x03", "a Python pickle", SAVE_ARRAY),
        (b"\x80\x04\x95", "a Python pickle", SAVE_ARRAY),
        (b"\x80\x05\x95", "a Python pickle", SAVE_ARRAY),
        (b"PK\x03\x04", "a ZIP archive", UNPACK),
        (b"PK\x05\x06", "an empty ZIP archive", UNPACK),
        (b"\x1f\x8b", "a gzip archive", UNPACK),
        (b"BZh", "a bzip2 archive", UNPACK),
        (b"\xfd7zXZ", "an xz archive", UNPACK),
        (b"\x28\xb5\x2f\xfd", "a Zstandard archive", UNPACK),
        (b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive", UNPACK),
        (b"\x89PNG", "a picture", NO_SHAPE),
        (b"\xff\xd8\xff", "a picture", NO_SHAPE),
        (b"GIF8", "a picture", NO_SHAPE),
        (b"%PDF", "a PDF document", NO_SHAPE),
    ];
    let known = magics.into_iter().find(|(magic, ..)| head.starts_with(magic));
    if let Some((_, what, advice)) = known {
        return Some((what, advice));
    }
    if head.get(257..262) == Some(b"ustar") {
        return Some(("a tar archive", UNPACK));
    }
    // A chunk of the whole file, then one of the version.
    let is_3ds = head.starts_with(b"MM") && matches!(head.get(6..8), Some([0x02, 0x00] | [0x3d, 0x3d]));
    is_3ds.then_some(("a 3DS scene", CONVERT_MESH))
}

/// By the first words.
pub(super) fn foreign_text(text: &str) -> Option<Known> {
    let start = text.trim_start().trim_start_matches('\u{feff}');
    let starts: [(&str, &str, &str); 20] = [
        ("version https://git-lfs", "a Git LFS pointer, not the file itself", "fetch it with “git lfs pull”"),
        ("# vtk", "a VTK file", CONVERT_MESH),
        ("<VTKFile", "a VTK file", CONVERT_MESH),
        ("<COLLADA", "a COLLADA scene", CONVERT_MESH),
        ("<X3D", "an X3D scene", CONVERT_MESH),
        ("<!DOCTYPE html", "a web page", "download the file itself"),
        ("<!doctype html", "a web page", "download the file itself"),
        ("<html", "a web page", "download the file itself"),
        ("#VRML", "a VRML scene", CONVERT_MESH),
        ("#X3D", "an X3D scene", CONVERT_MESH),
        ("#usda", "a USD scene", CONVERT_MESH),
        ("; FBX", "an FBX scene", CONVERT_MESH),
        ("ISO-10303-21", "a STEP model", CONVERT_SOLID),
        ("DBRep_DrawableShape", "a BREP model", CONVERT_SOLID),
        ("CASCADE Topology", "a BREP model", CONVERT_SOLID),
        ("$MeshFormat", "a Gmsh mesh", CONVERT_MESH),
        ("MeshVersionFormatted", "a MEDIT mesh", CONVERT_MESH),
        ("*HEADING", "an Abaqus model", CONVERT_MESH),
        ("ncols ", "a grid of heights", "convert it to XYZ text, with QGIS, say"),
        ("{\\rtf", "a text document", NO_SHAPE),
    ];
    if let Some((_, what, advice)) = starts.into_iter().find(|(word, ..)| start.starts_with(word)) {
        return Some((what, advice));
    }
    if start.starts_with("<?xml") {
        let names = [
            ("<COLLADA", "a COLLADA scene"),
            ("<X3D", "an X3D scene"),
            ("<VTKFile", "a VTK file"),
            ("<svg", "a drawing"),
        ];
        let what = names.into_iter().find(|(tag, _)| start.contains(tag)).map(|(_, what)| what);
        return Some((what.unwrap_or("an XML document"), CONVERT_MESH));
    }
    let mut first = text::lines(start).map(|(_, line)| line.trim());
    let (a, b) = (first.next().unwrap_or_default(), first.next().unwrap_or_default());
    if a == "0" && b == "SECTION" {
        return Some(("a DXF drawing", CONVERT_MESH));
    }
    // Columns 73 to 80 of the cards of old.
    if text.lines().next().is_some_and(|line| line.len() >= 80 && line.trim_end().ends_with("S      1")) {
        return Some(("an IGES model", CONVERT_SOLID));
    }
    is_ptx(start).then_some(("a PTX scan", CONVERT_CLOUD))
}

/// Two counts, four rows of three numbers, four of four, then points: read as
/// XYZ text, the rows of the scanner's place would become points.
fn is_ptx(start: &str) -> bool {
    let widths: Vec<usize> = text::lines(start)
        .take(10)
        .map(|(_, line)| {
            let mut words = line.split_whitespace();
            if words.clone().all(|w| text::number(w).is_some()) { words.by_ref().count() } else { 0 }
        })
        .collect();
    widths == [1, 1, 3, 3, 3, 3, 4, 4, 4, 4]
}
