//! Formats that are recognised but not supported, with advice.

use std::io::Cursor;

use crate::io::read::text;
use endings::by_ending;

mod endings;

pub(super) use endings::by_ending as foreign_ending;

/// What a file is, and what to do.
pub(super) type Known = (&'static str, &'static str);

const CONVERT_MESH: &str = "convert it to OBJ, PLY, STL or glTF, for example with Blender or MeshLab";
const CONVERT_CLOUD: &str = "convert it to PLY, PCD, LAS or XYZ text, for example with CloudCompare";
const CONVERT_SOLID: &str = "export it as a mesh (STL, OBJ) from a CAD program";
const CONVERT_MAP: &str = "convert it to XYZ text in metres, for example with QGIS";
const FROM_BLENDER: &str = "export it from Blender as OBJ, PLY, STL or glTF";
const FROM_RECORDING: &str = "export a cloud from it, for example as PCD";
const UNPACK: &str = "extract it first and open the shape inside";
const NO_SHAPE: &str = "give a mesh or a point cloud";
const SAVE_ARRAY: &str = "save the points as an array (.npy, N×3) or as XYZ text";
const SAVE_TENSOR: &str =
    "save its points as an array, for example with np.save(\"points.npy\", tensor.numpy())";
const SAVE_TABLE: &str = "save the sheet with the points as CSV";
const OPEN_MESHES: &str = "open one of the meshes it refers to";
const COPY_AGAIN: &str = "copy or export it again";

/// By the first bytes, and by what is in an archive. What only tells how
/// content is packed leaves it to the name's ending to say what that is.
pub(super) fn foreign_binary(bytes: &[u8], ending: &str) -> Option<Known> {
    let magics: [(&[u8], &str, &str); 38] = [
        (b"ASTM-E57", "an E57 point cloud", CONVERT_CLOUD),
        (b"livox_tech", "a Livox scanner recording", CONVERT_CLOUD),
        (b"Kaydara FBX", "an FBX scene", CONVERT_MESH),
        (b"BLENDER", "a Blender scene", FROM_BLENDER),
        (b"PXR-USDC", "a USD scene", CONVERT_MESH),
        (b"Ogawa", "an Alembic scene", CONVERT_MESH),
        (b"DRACO", "a Draco-compressed mesh", "export it without compression"),
        (b"b3dm\x01\0\0\0", "a 3D Tiles tile", CONVERT_MESH),
        (b"i3dm\x01\0\0\0", "a 3D Tiles tile", CONVERT_MESH),
        (b"cmpt\x01\0\0\0", "a 3D Tiles tile", CONVERT_MESH),
        (b"pnts\x01\0\0\0", "a 3D Tiles tile", CONVERT_CLOUD),
        (b"xof ", "a DirectX mesh", CONVERT_MESH),
        (b"3D Geometry File Format", "a Rhino model", "export it as a mesh (STL, OBJ) from Rhino"),
        (
            b"\xff\xfe\xff\x0eS\0k\0e\0t\0c\0h\0",
            "a SketchUp model",
            "export it as a mesh (OBJ, STL) from SketchUp",
        ),
        (b"AC10", "a DWG drawing", CONVERT_SOLID),
        (b"#ROSBAG", "a ROS bag", FROM_RECORDING),
        (b"\x89MCAP", "an MCAP recording", FROM_RECORDING),
        (b"\xd4\xc3\xb2\xa1", "a network capture (PCAP)", FROM_RECORDING),
        (b"\xa1\xb2\xc3\xd4", "a network capture (PCAP)", FROM_RECORDING),
        (b"\x4d\x3c\xb2\xa1", "a network capture (PCAP)", FROM_RECORDING),
        (b"\x0a\x0d\x0d\x0a", "a network capture (PCAP)", FROM_RECORDING),
        (b"MATLAB 5.0 MAT-file", "a MATLAB file", SAVE_ARRAY),
        (b"MATLAB 7.3 MAT-file", "a MATLAB file", SAVE_ARRAY),
        (b"PAR1", "a Parquet table", "save it as CSV"),
        (b"ARROW1", "an Arrow table", "save it as CSV"),
        (b"\0\0\x27\x0a", "a shapefile", CONVERT_MAP),
        (b" BDV", "an OpenVDB volume", CONVERT_MESH),
        (b"NRRD000", "a volume (NRRD)", "export its surface as STL, for example with 3D Slicer"),
        (b"\x89PNG", "a picture", NO_SHAPE),
        (b"\xff\xd8\xff", "a picture", NO_SHAPE),
        (b"GIF8", "a picture", NO_SHAPE),
        (b"II*\0", "a picture (TIFF)", "convert its heights to XYZ text, for example with QGIS or GDAL"),
        (
            b"MM\0*\0\0\0",
            "a picture (TIFF)",
            "convert its heights to XYZ text, for example with QGIS or GDAL",
        ),
        (b"v/1\x01", "a picture (EXR)", NO_SHAPE),
        (b"8BPS", "a picture", NO_SHAPE),
        (b"%PDF", "a PDF document", NO_SHAPE),
        (b"\x7fELF", "a program", NO_SHAPE),
        (b"OggS", "an audio file", NO_SHAPE),
    ];
    // How content is packed, whatever it is.
    let packings: [(&[u8], &str, &str); 15] = [
        (b"PK\x05\x06", "an empty ZIP archive", COPY_AGAIN),
        (b"\x1f\x8b", "a gzip archive", UNPACK),
        (b"BZh", "a bzip2 archive", UNPACK),
        (b"\xfd7zXZ", "an xz archive", UNPACK),
        (b"\x28\xb5\x2f\xfd", "a Zstandard archive", UNPACK),
        (b"\x04\x22\x4d\x18", "an LZ4 archive", UNPACK),
        (b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive", UNPACK),
        (b"Rar!", "a RAR archive", UNPACK),
        (b"\x89HDF", "an HDF5 file", SAVE_ARRAY),
        (b"SQLite format 3", "a database", NO_SHAPE),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a Microsoft Office or CAD document", NO_SHAPE),
        (b"\x80\x02", "a Python pickle", SAVE_ARRAY),
        (b"\x80\x03", "a Python pickle", SAVE_ARRAY),
        (b"\x80\x04\x95", "a Python pickle", SAVE_ARRAY),
        (b"\x80\x05\x95", "a Python pickle", SAVE_ARRAY),
    ];
    let among = |list: &[(&[u8], &'static str, &'static str)]| {
        list.iter().find(|(magic, ..)| bytes.starts_with(magic)).map(|&(_, what, advice)| (what, advice))
    };
    if let Some(known) = among(&magics) {
        return Some(known);
    }
    if bytes.starts_with(b"PK\x03\x04") {
        return in_archive(bytes).or_else(|| by_ending(ending)).or(Some(("a ZIP archive", UNPACK)));
    }
    if let Some(packing) = among(&packings) {
        return by_ending(ending).or(Some(packing));
    }
    if bytes.get(257..262) == Some(b"ustar") {
        return Some(("a tar archive", UNPACK));
    }
    // A chunk of the whole file, then one of the version.
    let is_3ds = bytes.starts_with(b"MM") && matches!(bytes.get(6..8), Some([0x02, 0x00] | [0x3d, 0x3d]));
    if is_3ds {
        return Some(("a 3DS scene", CONVERT_MESH));
    }
    // A form, its length, and what it is of.
    let is_lwo = bytes.starts_with(b"FORM") && bytes.get(8..11) == Some(b"LWO");
    is_lwo.then_some(("a LightWave object", CONVERT_MESH))
}

/// By the names of what is in a ZIP archive.
fn in_archive(bytes: &[u8]) -> Option<Known> {
    let archive = zip::ZipArchive::new(Cursor::new(bytes)).ok()?;
    let names: Vec<String> = archive.file_names().flatten().map(|name| name.to_lowercase()).collect();
    let has = |test: &dyn Fn(&str) -> bool| names.iter().any(|name| test(name));
    let ends = |ending: &str| has(&|name| name.ends_with(ending));
    let starts = |start: &str| has(&|name| name.starts_with(start));
    Some(if has(&|name| name.starts_with("3d/") && name.ends_with(".model")) {
        ("a 3MF model", CONVERT_MESH)
    } else if ends(".usdc") || ends(".usda") || ends(".usd") {
        ("a USDZ scene", CONVERT_MESH)
    } else if ends("data.pkl") {
        ("a PyTorch file", SAVE_TENSOR)
    } else if starts("word/") {
        ("a Word document", NO_SHAPE)
    } else if starts("xl/") {
        ("an Excel workbook", SAVE_TABLE)
    } else if starts("ppt/") {
        ("a PowerPoint presentation", NO_SHAPE)
    } else if ends("mimetype") && ends("content.xml") {
        ("an OpenDocument file", SAVE_TABLE)
    } else if ends(".kml") {
        ("a KMZ map", "extract it and convert the COLLADA model inside to OBJ, PLY, STL or glTF")
    } else if ends("document.xml") && (ends("guidocument.xml") || ends(".brp")) {
        ("a FreeCAD document", CONVERT_SOLID)
    } else if starts("meta-inf/manifest.mf") {
        ("a Java archive", NO_SHAPE)
    } else {
        return None;
    })
}

/// By the first words.
pub(super) fn foreign_text(text: &str) -> Option<Known> {
    let start = text.trim_start().trim_start_matches('\u{feff}');
    let starts: [(&str, &str, &str); 24] = [
        ("version https://git-lfs", "a Git LFS pointer, not the file itself", "fetch it with “git lfs pull”"),
        ("# vtk", "a VTK file", CONVERT_MESH),
        ("#VRML", "a VRML scene", CONVERT_MESH),
        ("#X3D", "an X3D scene", CONVERT_MESH),
        ("#usda", "a USD scene", CONVERT_MESH),
        ("# Octomap", "an OctoMap", "export a cloud from it, for example as PCD"),
        ("#?RADIANCE", "a picture", NO_SHAPE),
        ("; FBX", "an FBX scene", CONVERT_MESH),
        ("//Maya ASCII", "a Maya scene", "export it from Maya as OBJ, STL or glTF"),
        ("newmtl ", "a material library (MTL)", "open the OBJ file it belongs to"),
        ("# Blender MTL", "a material library (MTL)", "open the OBJ file it belongs to"),
        ("ISO-10303-21", "a STEP model", CONVERT_SOLID),
        ("DBRep_DrawableShape", "a BREP model", CONVERT_SOLID),
        ("CASCADE Topology", "a BREP model", CONVERT_SOLID),
        ("**ABCDEFGHIJKLMNOPQRSTUVWXYZ", "a Parasolid model", CONVERT_SOLID),
        ("$MeshFormat", "a Gmsh mesh", CONVERT_MESH),
        ("MeshVersionFormatted", "a MEDIT mesh", CONVERT_MESH),
        ("*HEADING", "an Abaqus model", CONVERT_MESH),
        ("*Heading", "an Abaqus model", CONVERT_MESH),
        ("*KEYWORD", "an LS-DYNA model", CONVERT_MESH),
        ("ncols ", "a height grid", "convert it to XYZ text, for example with QGIS"),
        ("DSAA", "a height grid", "convert it to XYZ text, for example with QGIS"),
        ("%!PS", "a PostScript document", NO_SHAPE),
        ("{\\rtf", "a text document", NO_SHAPE),
    ];
    if let Some((_, what, advice)) = starts.into_iter().find(|(word, ..)| start.starts_with(word)) {
        let is_building = what == "a STEP model" && start.to_ascii_uppercase().contains("FILE_SCHEMA(('IFC");
        return Some(if is_building { ("an IFC building model", CONVERT_MESH) } else { (what, advice) });
    }
    if start.starts_with('<') {
        return xml(start);
    }
    let mut first = text::lines(start).map(|(_, line)| line.trim());
    let (a, b) = (first.next().unwrap_or_default(), first.next().unwrap_or_default());
    if a == "0" && b == "SECTION" || a == "999" && start.contains("\nSECTION") {
        return Some(("a DXF drawing", CONVERT_MESH));
    }
    // Columns 73 to 80 of the cards of old.
    if text.lines().next().is_some_and(|line| line.len() >= 80 && line.trim_end().ends_with("S      1")) {
        return Some(("an IGES model", CONVERT_SOLID));
    }
    is_ptx(start).then_some(("a PTX scan", CONVERT_CLOUD))
}

/// By the tags of an XML document, also of one without a first line that says so.
fn xml(start: &str) -> Option<Known> {
    let tags: [(&str, &str, &str); 15] = [
        ("<collada", "a COLLADA scene", CONVERT_MESH),
        ("<x3d", "an X3D scene", CONVERT_MESH),
        ("<vtkfile", "a VTK file", CONVERT_MESH),
        ("<amf", "an AMF model", CONVERT_MESH),
        ("<model unit", "a 3MF model", CONVERT_MESH),
        ("<kml", "a KML map", CONVERT_MAP),
        ("<gpx", "a GPX track", CONVERT_MAP),
        ("<osm", "an OpenStreetMap map", CONVERT_MAP),
        ("citymodel", "a CityGML model", CONVERT_MESH),
        ("<ifcxml", "an IFC building model", CONVERT_MESH),
        ("<robot", "a URDF robot", OPEN_MESHES),
        ("<mujoco", "a MuJoCo model", OPEN_MESHES),
        ("<sdf", "an SDF model", OPEN_MESHES),
        ("<svg", "a drawing", NO_SHAPE),
        ("<html", "a web page", "download the file itself"),
    ];
    let lower = start.to_ascii_lowercase();
    if lower.starts_with("<!doctype html") {
        return Some(("a web page", "download the file itself"));
    }
    let known = tags.into_iter().find(|(tag, ..)| lower.contains(tag));
    let is_xml = || start[1..].starts_with(|c: char| c.is_alphabetic() || c == '?' || c == '!');
    known
        .map(|(_, what, advice)| (what, advice))
        .or_else(|| is_xml().then_some(("an XML document", CONVERT_MESH)))
}

/// Data in JSON, or a list that was printed with its points side by side: the
/// reader of XYZ text would take a line of it for a point.
pub(super) fn foreign_json(text: &str) -> Option<Known> {
    let start = text.trim_start().trim_start_matches('\u{feff}');
    let first = text::lines(start).next().map_or("", |(_, line)| line.trim());
    let has = |word: &str| start.contains(&format!("\"{word}\""));
    if start.starts_with('{') {
        return Some(if has("FeatureCollection") || has("Feature") {
            ("a GeoJSON map", CONVERT_MAP)
        } else if has("CityJSON") {
            ("a CityJSON model", CONVERT_MESH)
        } else if has("BufferGeometry") || has("Object3D") {
            ("a three.js JSON scene", CONVERT_MESH)
        } else {
            ("a JSON file", SAVE_ARRAY)
        });
    }
    let compact: String = first.chars().filter(|c| !c.is_whitespace()).collect();
    let is_list = start.starts_with('[')
        && (compact.trim_matches('[').is_empty()
            || ["],[", "),(", "{"].iter().any(|joint| compact.contains(joint)));
    is_list.then_some(("a list in brackets (JSON or Python)", SAVE_ARRAY))
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
