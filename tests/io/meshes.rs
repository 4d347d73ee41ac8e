//! Reading STL, OFF and glTF: what they mean, what is mended and what is refused.

use crate::common::{cloud, mesh, read_as, shared_data};
use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;
use superform::geometry::SamplingOptions;
use superform::io;

/// The message of a refusal.
fn refusal(name: &str, content: impl AsRef<[u8]>) -> String {
    read_as(name, content).expect_err("this should be refused").to_string()
}

/// Corners of the faces, so that the order of the vertices doesn't matter.
fn corners((vertices, faces): (Vec<Point3<f64>>, Vec<[u32; 3]>)) -> Vec<[Point3<f64>; 3]> {
    faces.iter().map(|f| f.map(|i| vertices[i as usize])).collect()
}

fn p(x: f64, y: f64, z: f64) -> Point3<f64> {
    Point3::new(x, y, z)
}

// STL

/// Two triangles with a common edge.
const SQUARE: [[[f32; 3]; 3]; 2] = [
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5]],
    [[-0.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]],
];

fn binary_stl(header: &str, count: u32, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut file = header.as_bytes().to_vec();
    file.resize(80, b' ');
    file.extend(count.to_le_bytes());
    for triangle in triangles {
        file.extend([0; 12]);
        file.extend(triangle.iter().flatten().flat_map(|v| v.to_le_bytes()));
        file.extend([0; 2]);
    }
    file
}

fn ascii_stl(triangles: &[[[f32; 3]; 3]]) -> String {
    let mut text = "solid a square, of two facets\n".to_owned();
    for triangle in triangles {
        text += "facet normal nan 0 1\n outer loop\n";
        triangle.iter().for_each(|[x, y, z]| text += &format!("  vertex {x} {y} {z:e}\n"));
        text += " endloop\nendfacet\n";
    }
    text + "endsolid\n"
}

#[test]
fn stl_is_the_same_in_all_its_forms() {
    let ascii = ascii_stl(&SQUARE);
    let plain = mesh(read_as("a.stl", binary_stl("made by a test", 2, &SQUARE)).unwrap());
    assert_eq!(plain.0, [p(0., 0., 0.), p(1., 0., 0.), p(1., 1., 0.5), p(0., 1., 0.5)]);
    assert_eq!(plain.1, [[0, 1, 2], [0, 2, 3]]);
    for content in [
        binary_stl("solid as ASCII files begin, facet", 2, &SQUARE),
        ascii.clone().into(),
        ascii.to_uppercase().into(),
        ascii.replace('\n', "\r\n").into(),
        ascii.split_once('\n').map(|(_, rest)| format!("solid\n{}", rest.replace('\n', " "))).unwrap().into(),
        // One solid after another.
        (ascii_stl(&SQUARE[..1]) + &ascii_stl(&SQUARE[1..])).into(),
        // The square as one facet.
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 .5\nvertex 0 1 .5\nendloop\n\
         endfacet\nendsolid"
            .into(),
    ] {
        for name in ["a.stl", "a.STL", "a.dat"] {
            let shape = read_as(name, &content).unwrap();
            assert!(shape.notes.is_empty(), "{:?}", shape.notes);
            assert_eq!(mesh(shape), plain, "{}", String::from_utf8_lossy(&content));
        }
    }
}

#[test]
fn stl_that_is_broken_says_where() {
    let binary = binary_stl("x", 2, &SQUARE);
    let ascii = ascii_stl(&SQUARE);
    for (content, words) in [
        (&binary[..150], "byte 80: the header declares 2 triangles, but the file has room for at most 1"),
        (&[0; 60], "byte 60: the header of a binary STL ends here"),
        (&binary_stl("x", u32::MAX, &SQUARE), "declares 4294967295 triangles"),
        (&binary_stl("x", 0, &[]), "no triangles"),
        (b"solid nothing\nendsolid\n", "no triangles"),
        (b"A shopping list\n- milk\n", "line 1: unexpected “A”"),
        (ascii.replacen("1 1 5e-1", "1 one 0", 1).as_bytes(), "line 6: “one” is not a number"),
        (ascii.replacen("  vertex 1 0 0e0\n", "", 1).as_bytes(), "line 6: a facet needs three corners"),
        (&ascii.as_bytes()[..80], "incomplete; the file may be truncated"),
        (ascii.replacen("endloop", "endlop", 1).as_bytes(), "line 7: unexpected “endlop”"),
    ] {
        let message = refusal("a.stl", content);
        assert!(message.contains("a.stl") && message.contains(words), "{message} lacks {words}");
    }
    let shape = read_as("a.stl", ascii.replace("endsolid\n", "")).unwrap();
    assert!(shape.notes[0].contains("no endsolid"), "{:?}", shape.notes);
    let surplus = [binary, vec![7; 9]].concat();
    assert!(read_as("a.stl", surplus).unwrap().notes[0].contains("9 bytes after the 2 declared"));
}

// OFF

const OFF: &str = "OFF\n4 2 5\n0 0 0\n1 0 0\n1 1 0.5\n0 1 0.5\n3 0 1 2\n4 0 1 2 3\n";

#[test]
fn off_dialects_agree() {
    let plain = mesh(read_as("a.off", OFF).unwrap());
    assert_eq!(plain.0, [p(0., 0., 0.), p(1., 0., 0.), p(1., 1., 0.5), p(0., 1., 0.5)]);
    assert_eq!(plain.1, [[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
    for text in [
        OFF.replace("OFF\n4", "OFF 4"),
        OFF.replace("4 2 5", "4 2"),
        OFF.replace('\n', "\r\n"),
        format!("# made by hand\n\n{}", OFF.replace("1 0 0\n", "1 0 0 # right\n\n# up\n")),
        OFF.replace("3 0 1 2\n", "3 0 1 2 0.5 0.5 0.5 1\n").replace("0 1 2 3\n", "0 1 2 3 255 0 0\n"),
        OFF.replace("OFF", "COFF").replace("1 0 0\n", "1 0 0 255 0 0 255\n"),
        OFF.replace("OFF", "NOFF").replace("1 0 0\n", "1 0 0 0 0 1\n"),
        OFF.replace("OFF", "4OFF")
            .replace("0 0 0\n", "0 0 0 1\n")
            .replace("\n1 0 0\n", "\n2 0 0 2\n")
            .replace("0.5\n", "0.5 1\n"),
    ] {
        for name in ["a.off", "a"] {
            let shape = read_as(name, &text).unwrap();
            assert!(shape.notes.is_empty(), "{:?}", shape.notes);
            assert_eq!(mesh(shape), plain, "{text}");
        }
    }
}

#[test]
fn off_without_faces_is_a_cloud_with_its_colors() {
    let (points, colors) =
        cloud(read_as("a.off", "COFF 2 0 0\n0 0 0 255 0 9 255\n1 2 3 1 2 3 255\n").unwrap());
    assert_eq!((points[1], colors), (p(1., 2., 3.), Some(vec![[255, 0, 9], [1, 2, 3]])));
    let (_, colors) = cloud(read_as("a.off", "CNOFF 1 0 0\n0 0 0 9 9 9 1 0 0.2 1\n").unwrap());
    assert_eq!(colors, Some(vec![[255, 0, 51]]));
}

#[test]
fn off_that_is_broken_says_where() {
    for (from, to, words) in [
        ("4 2 5", "353535235358 2 5", "353535235358 vertices are declared, but there are 6"),
        ("4 2 5", "4 3 5", "3 faces are declared, but there are 2"),
        ("4 2 5", "4 two", "line 2: “two” is not a number of"),
        ("1 1 0.5", "1 1", "line 5: a vertex needs three"),
        ("1 1 0.5", "1 x 0.5", "line 5: “x” is not a number"),
        ("3 0 1 2", "3 0 1", "line 7: the face has fewer"),
        ("3 0 1 2", "3 0 1 b", "line 7: “b” is not the index"),
        ("OFF", "OFF BINARY", "line 1: binary OFF"),
        ("OFF", "nOFF 5", "“nOFF” starts an n-dimensional mesh"),
    ] {
        let message = refusal("a.off", OFF.replacen(from, to, 1));
        assert!(message.contains(words), "{message} lacks {words}");
    }
    let shape = read_as("a.off", OFF.replace("3 0 1 2\n", "3 0 1 4\n")).unwrap();
    assert!(shape.notes[0].contains("1 face with missing vertices"), "{:?}", shape.notes);
    assert_eq!(mesh(shape).1.len(), 2);
}

// glTF

/// Base64, for buffers inside the JSON.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().fold(0u32, |all, b| all << 8 | u32::from(*b)) << (8 * (3 - group.len()));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize & 63];
            text.push(if i <= group.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

/// A square of five vertices (the last unused) in floats at byte 0, and at
/// byte 60 the indices 0 1 2 0 2 3 as bytes.
fn square() -> Vec<u8> {
    let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 9.0f32]];
    let mut bytes: Vec<u8> = vertices.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3, 0, 0]);
    bytes
}

const ACCESSORS: &str = r#""bufferViews": [{"buffer": 0, "byteLength": 60}, {"buffer": 0, "byteOffset": 60, "byteLength": 8}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"}]"#;
const TRIANGLES: &str = r#"[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]"#;

/// A glTF file of the square with these nodes and meshes.
fn gltf(nodes: &str, meshes: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": {nodes}, "meshes": {meshes},
            "buffers": [{{"byteLength": 68, "uri": "data:application/octet-stream;base64,{}"}}], {ACCESSORS}}}"#,
        base64(&square())
    )
}

/// The same as GLB.
fn glb(json: &str, blob: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = (28 + json.len() + blob.len()) as u32;
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(length.to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(json);
    file.extend((blob.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(blob);
    file
}

fn square_corners() -> Vec<[Point3<f64>; 3]> {
    let [a, b, c, d] = [p(0., 0., 0.), p(1., 0., 0.), p(1., 1., 0.), p(0., 1., 0.)];
    vec![[a, b, c], [a, c, d]]
}

#[test]
fn gltf_keeps_its_buffer_in_three_places() {
    let text = gltf(r#"[{"mesh": 0}]"#, TRIANGLES);
    let uri = text.split('"').find(|t| t.starts_with("data:")).unwrap().to_owned();
    let without = text.replace(&format!(", \"uri\": \"{uri}\""), "");
    let shape = read_as("a.gltf", &text).unwrap();
    assert!(shape.notes.is_empty());
    let (vertices, faces) = mesh(shape);
    assert_eq!(vertices.len(), 4, "and the unused vertex doesn't count");
    assert_eq!(corners((vertices, faces)), square_corners());
    assert_eq!(corners(mesh(read_as("a.glb", glb(&without, &square())).unwrap())), square_corners());
    assert_eq!(corners(mesh(read_as("any.name", glb(&without, &square())).unwrap())), square_corners());

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, text.replace(&uri, "parts/the%20square.bin")).unwrap();
    let message = io::read(&path).unwrap_err().to_string();
    assert!(message.contains("second file") && message.contains("the square.bin"), "{message}");
    std::fs::create_dir(folder.path().join("parts")).unwrap();
    std::fs::write(folder.path().join("parts/the square.bin"), square()).unwrap();
    assert_eq!(corners(mesh(io::read(&path).unwrap())), square_corners());
}

#[test]
fn gltf_nodes_carry_their_meshes_into_the_world() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let nodes = format!(
        r#"[{{"children": [1, 3], "translation": [450000.125, 5400000.25, 0], "rotation": [0, 0, {half}, {half}]}},
            {{"mesh": 0, "scale": [2, 3, 0.5]}}, {{"mesh": 0}},
            {{"mesh": 0, "matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,7,1]}}]"#
    );
    let text = gltf(&nodes, TRIANGLES)
        .replace("\"nodes\": [{", "\"scene\": 1, \"scenes\": [{}, {\"nodes\": [0]}], \"nodes\": [{");
    let found = corners(mesh(read_as("a.gltf", text).unwrap()));
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    let offset = Vector3::new(450_000.125, 5_400_000.25, 0.0);
    let world = |local: Vector3<f64>| Point3::from(turn * local + offset);
    // The node that no scene shows is left out.
    assert_eq!(found.len(), 4);
    for (triangle, known) in found.iter().zip([square_corners(), square_corners()].concat()).take(2) {
        for (corner, known) in triangle.iter().zip(known) {
            let known = world(known.coords.component_mul(&Vector3::new(2.0, 3.0, 0.5)));
            // In single precision this would be off by half a unit.
            assert!((corner - known).norm() < 1e-8, "{corner} {known}");
        }
    }
    for triangle in &found {
        // The mirrored copy is turned back: all face the same way.
        let normal = (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0]));
        assert!(normal.z > 0.0, "{normal}");
    }
    assert!((found[2][0].z - 7.0).abs() < 1e-12);
}

#[test]
fn gltf_modes_mean_the_same_surface() {
    let one = |mode: u32, indices: [u8; 6], count: usize| {
        let text = gltf(
            r#"[{"mesh": 0}]"#,
            &TRIANGLES.replace("\"indices\": 1", &format!("\"indices\": 1, \"mode\": {mode}")),
        );
        let mut bytes = square();
        bytes[60..66].copy_from_slice(&indices);
        let text = text.replace("\"count\": 6", &format!("\"count\": {count}"));
        text.replace(&base64(&square()), &base64(&bytes))
    };
    let area_and_up = |text: String| {
        let all = corners(mesh(read_as("a.gltf", text).unwrap()));
        all.iter().map(|t| 0.5 * (t[1] - t[0]).cross(&(t[2] - t[0]))).sum::<Vector3<f64>>()
    };
    let up = Vector3::new(0.0, 0.0, 1.0);
    assert_eq!(area_and_up(one(4, [0, 1, 2, 0, 2, 3], 6)), up);
    assert_eq!(area_and_up(one(5, [0, 1, 3, 2, 0, 0], 4)), up, "each second triangle of a strip is turned");
    assert_eq!(area_and_up(one(6, [0, 1, 2, 3, 0, 0], 4)), up);
    // Points, in the order of their indices; lines alone are nothing.
    let (points, _) = cloud(read_as("a.gltf", one(0, [3, 1, 0, 0, 0, 0], 2)).unwrap());
    assert_eq!(points, [p(0., 1., 0.), p(1., 0., 0.)]);
    assert!(refusal("a.gltf", one(1, [0, 1, 2, 3, 0, 0], 4)).contains("neither triangles nor points"));
    assert!(refusal("a.gltf", one(9, [0, 1, 2, 3, 0, 0], 4)).contains("unknown mode 9"));
    // Beside a surface, points and lines are left out, and that is said.
    let more = TRIANGLES.replace(
        "}]}]",
        "}, {\"attributes\": {\"POSITION\": 0}, \"mode\": 0}, {\"attributes\": {\"POSITION\": 0}, \"mode\": 3}]}]",
    );
    let shape = read_as("a.gltf", gltf(r#"[{"mesh": 0}]"#, &more)).unwrap();
    assert_eq!(
        shape.notes,
        ["ignored 5 points next to the surfaces", "ignored 1 set of lines next to the surfaces"]
    );
    assert_eq!(mesh(shape).1.len(), 2);
}

#[test]
fn gltf_numbers_may_be_short_sparse_or_interleaved() {
    // Positions as normalised bytes with a stride of 4, the second one replaced.
    let views = r#""bufferViews": [{"buffer": 0, "byteLength": 12, "byteStride": 4}, {"buffer": 0, "byteOffset": 12, "byteLength": 4}],
        "accessors": [{"bufferView": 0, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3",
            "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121},
                       "values": {"bufferView": 1, "byteOffset": 1}}}]"#;
    let bytes = [0, 0, 0, 77, 9, 9, 9, 77, 0, 255, 51, 77, 1, 255, 0, 0];
    let text = gltf("[]", r#"[{"primitives": [{"attributes": {"POSITION": 0}}]}]"#)
        .replace(ACCESSORS, views)
        .replace(&base64(&square()), &base64(&bytes));
    let found = corners(mesh(read_as("a.gltf", text).unwrap()));
    assert_eq!(found, [[p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.2)]]);
}

#[test]
fn gltf_points_keep_their_colors() {
    // The colours are the positions, which are 0 and 1 (or far beyond).
    let meshes = r#"[{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 0}, "mode": 0}]}]"#;
    let text = gltf(r#"[{"mesh": 0}]"#, meshes);
    let (points, colors) = cloud(read_as("a.gltf", text).unwrap());
    assert_eq!((points.len(), colors.unwrap()[2]), (5, [255, 255, 0]));
}

#[test]
fn gltf_surfaces_keep_colors_and_normals() {
    // Both are the positions, which are 0 and 1 (or far beyond).
    let meshes = TRIANGLES.replace("\"POSITION\": 0", "\"POSITION\": 0, \"NORMAL\": 0, \"COLOR_0\": 0");
    let shape = read_as("a.gltf", gltf(r#"[{"mesh": 0, "scale": [2, 1, 1]}]"#, &meshes)).unwrap();
    let io::Attributes { colors, normals, labels } = shape.attributes.clone();
    let (vertices, _) = mesh(shape);
    assert_eq!((vertices.len(), colors.unwrap()[2], labels), (4, [255, 255, 0], None));
    // What is stretched along x turns away from it.
    let [x, y, z] = normals.unwrap()[2];
    assert!((x / y - 0.5).abs() < 1e-6 && (x * x + y * y - 1.0).abs() < 1e-6 && z == 0.0);
    // Colours that can't be made out cost no more than themselves.
    let broken = meshes.replace("\"COLOR_0\": 0", "\"COLOR_0\": 9");
    let shape = read_as("a.gltf", gltf(r#"[{"mesh": 0}]"#, &broken)).unwrap();
    assert!(shape.attributes.colors.is_none() && shape.attributes.normals.is_some());
}

#[test]
fn gltf_that_is_broken_is_refused() {
    let good = gltf(r#"[{"mesh": 0}]"#, TRIANGLES);
    for (from, to, words) in [
        ("\"version\": \"2.0\"", "\"version\": \"1.0\"", "glTF 1.0"),
        (
            "\"nodes\"",
            "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"nodes\"",
            "without compression",
        ),
        ("[{\"mesh\": 0}]", "[{\"mesh\": 3}]", "mesh 3, but has 1"),
        (
            "[{\"mesh\": 0}]",
            "[{\"children\": [1]}, {\"children\": [2]}, {\"children\": [1]}]",
            "node 1 has more than one parent",
        ),
        ("\"POSITION\": 0", "\"POSITION\": 8", "accessor 8"),
        ("\"POSITION\": 0", "\"POSITION\": 1", "contains SCALAR"),
        ("\"indices\": 1", "\"indices\": 0", "should contain indices"),
        ("\"count\": 5", "\"count\": 500000000000", "room for 5 elements, but 500000000000"),
        ("\"byteLength\": 60", "\"byteLength\": 6000", "should have at least 6000 bytes, but has 68"),
        ("\"byteOffset\": 60", "\"byteOffset\": 18446744073709551615", "truncated"),
        ("\"componentType\": 5126", "\"componentType\": 5555", "unknown number type 5555"),
        ("\"bufferView\": 0, ", "\"byteOffset\": 4000000000, \"bufferView\": 0, ", "truncated"),
        ("data:application", "https://elsewhere", "in a different location"),
        (";base64,", ";base64,!", "not valid base64"),
        ("\"nodes\": [", "\"nodes\": [,", "line 1: it is not the JSON"),
    ] {
        assert!(good.contains(from), "{from}");
        let message = refusal("a.gltf", good.replacen(from, to, 1));
        assert!(message.contains("a.gltf") && message.contains(words), "{message} lacks {words}");
    }
    // Zeros that no buffer holds.
    let zeros = good.replacen("\"bufferView\": 0, ", "", 1).replace("\"count\": 5", "\"count\": 99999999999");
    assert!(refusal("a.gltf", zeros).contains("99999999999 elements that are missing"));
    let file = glb(&good, &square());
    assert!(refusal("a.glb", &file[..200]).contains("byte 12: a part of"));
    assert!(refusal("a.glb", &file[..14]).contains("byte 12: its JSON part is missing"));
    assert!(refusal("a.glb", b"glTF\x01\0\0\0").contains("byte 4: it is binary glTF 1"));
    // An index beyond the vertices costs its triangle.
    let mut bytes = square();
    bytes[65] = 5;
    let shape = read_as("a.gltf", good.replace(&base64(&square()), &base64(&bytes))).unwrap();
    assert!(shape.notes[0].contains("1 face with missing vertices"), "{:?}", shape.notes);
}

/// A small file that asks for more than any machine has.
#[test]
fn gltf_copies_are_bounded() {
    let node = vec!["{\"mesh\": 0}"; 1000].join(",");
    let primitive = vec!["{\"attributes\": {\"POSITION\": 0}, \"indices\": 1}"; 20_000].join(",");
    let text = gltf(&format!("[{node}]"), &format!("[{{\"primitives\": [{primitive}]}}]"));
    assert!(refusal("a.gltf", text).contains("repeats meshes to more than"));
}

/// What is known of some of the test shapes beyond their counts.
#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn known_files_have_their_known_places() {
    let folder = shared_data();
    let bounds = |path: &str| {
        let shape = io::read(&folder.join(path)).unwrap_or_else(|e| panic!("{e}"));
        let (vertices, _) = mesh(shape);
        superform::geometry::mesh::bounds(vertices).unwrap()
    };
    // A unit cube under scale (2, ½, 1) and offset 3, and one turned within it.
    let (lo, hi) = bounds("hard/nested_transforms.glb");
    let half = 0.5 * (0.7f64.cos() + 0.7f64.sin());
    assert!((lo - p(3.0 - 2.0 * half, -0.5 * half, -0.5)).norm() < 1e-6, "{lo}");
    assert!((hi - p(3.0 + 2.0 * half, 0.5 * half, 0.5)).norm() < 1e-6, "{hi}");
    // The same tin in four files.
    let (lo, hi) = bounds("hard/embedded.gltf");
    for path in ["hard/ascii.stl", "hard/binary_starts_with_solid.stl", "hard/header_on_one_line.off"] {
        let (l, h) = bounds(path);
        assert!((l - lo).norm() < 1e-5 && (h - hi).norm() < 1e-5, "{path}: {l} {h}, not {lo} {hi}");
    }
    for (path, words) in [
        ("hard/truncated.stl", "declares 428 triangles, but the file has room for at most 98"),
        ("hard/truncated.glb", "truncated"),
        ("hard/text_renamed.stl", "line 1: unexpected “This”"),
        ("hard/tm_stl_empty_bin.stl", "no triangles"),
        ("hard/as_OutOfMemory.off", "353535235358 vertices are declared"),
    ] {
        let message = io::read(&folder.join(path)).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

/// Good files, to be broken.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let text = gltf(r#"[{"children": [1]}, {"mesh": 0, "scale": [1, 2, 3]}]"#, TRIANGLES);
    let uri = text.split('"').find(|t| t.starts_with("data:")).unwrap().to_owned();
    let without = text.replace(&format!(", \"uri\": \"{uri}\""), "");
    vec![
        ("a.stl", binary_stl("x", 2, &SQUARE)),
        ("a.stl", ascii_stl(&SQUARE).into()),
        ("a.off", OFF.into()),
        ("a.off", "CNOFF 2 0 0\n0 0 0 0 0 1 255 0 9 255\n1 2 3 0 0 1 1 2 3 255\n".into()),
        ("a.glb", glb(&without, &square())),
        ("a.gltf", text.into()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever is cut off or changed: a shape or an error, never a panic, and
    /// a shape that can be sampled.
    #[test]
    fn broken_files_never_panic(
        which in 0usize..6,
        cut in 0.5..1.5f64,
        changes in prop::collection::vec((0.0..1.0f64, prop_oneof![
            any::<u8>(),
            prop::sample::select(b"\n 0123456789-.,[]{}\"AZ\0\xff".to_vec()),
        ]), 0..6),
    ) {
        let (name, mut bytes) = seeds().swap_remove(which);
        let length = bytes.len() as f64;
        for (at, byte) in changes {
            bytes[(at * length) as usize] = byte;
        }
        bytes.truncate((cut * length) as usize);
        match read_as(name, &bytes) {
            Ok(shape) => {
                let options = SamplingOptions { points: 30, ..Default::default() };
                let sampled = io::sample(&shape, &options);
                prop_assert!(sampled.is_ok(), "{:?}", sampled);
            }
            Err(e) => prop_assert!(!e.to_string().is_empty()),
        }
    }
}
