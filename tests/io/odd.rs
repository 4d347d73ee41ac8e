//! Odd files, one of each kind that people and programs make: each is read for
//! what it is, or refused with one message that says what, where and what to do.

use std::io::{Cursor, Write};

use crate::formats::{f64s, npy, npz, pcd};
use superform::io::{ShapeGeometry, read_bytes};

/// What becomes of a file.
enum Becomes {
    /// Vertices, faces, and a part of the notes.
    Mesh(usize, usize, &'static str),
    Cloud(usize, &'static str),
    /// A part of the message.
    Refused(&'static str),
}
use Becomes::{Cloud, Mesh, Refused};

#[track_caller]
fn expect(cases: Vec<(&str, Vec<u8>, Becomes)>) {
    for (i, (name, bytes, becomes)) in cases.into_iter().enumerate() {
        let found = read_bytes(&bytes, name);
        let start = String::from_utf8_lossy(&bytes[..bytes.len().min(60)]).into_owned();
        match (found, becomes) {
            (Ok(shape), Mesh(vertices, faces, note)) => {
                let ShapeGeometry::Mesh(mesh) = &shape.geometry else { panic!("{i} is a cloud: {start}") };
                let notes = shape.notes.join("; ");
                assert_eq!((mesh.vertices.len(), mesh.faces.len()), (vertices, faces), "{i}: {start}");
                assert!(notes.contains(note) && notes.is_empty() == note.is_empty(), "{i}: {notes}");
            }
            (Ok(shape), Cloud(points, note)) => {
                let ShapeGeometry::Cloud(cloud) = &shape.geometry else { panic!("{i} is a mesh: {start}") };
                let notes = shape.notes.join("; ");
                assert_eq!(cloud.points.len(), points, "{i}: {start}");
                assert!(notes.contains(note) && notes.is_empty() == note.is_empty(), "{i}: {notes}");
            }
            (Err(e), Refused(words)) => {
                let message = e.to_string();
                assert!(message.contains(words) && message.contains(name), "{i}: {message} lacks {words}");
            }
            (Ok(shape), Refused(words)) => panic!("{i} was read, not {words}: {start}: {shape:?}"),
            (Err(e), _) => panic!("{i}: {e}"),
        }
    }
}

fn text(s: &str) -> Vec<u8> {
    s.as_bytes().to_vec()
}

fn utf16(s: &str, big: bool) -> Vec<u8> {
    let unit = |u: u16| if big { u.to_be_bytes() } else { u.to_le_bytes() };
    std::iter::once(0xfeff).chain(s.encode_utf16()).flat_map(unit).collect()
}

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn texts_of_any_encoding_and_ending() {
    let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2";
    let stl = "solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a";
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2";
    let mut cases = Vec::new();
    for (name, content) in [("a.obj", OBJ), ("a.off", off), ("a.stl", stl)] {
        cases.push((name, [b"\xef\xbb\xbf", content.as_bytes()].concat(), Mesh(3, 1, "")));
        cases.push((name, utf16(content, false), Mesh(3, 1, "")));
        cases.push((name, utf16(content, true), Mesh(3, 1, "")));
    }
    for (name, content) in [("a.obj", OBJ), ("a.off", off), ("a.stl", stl), ("a.ply", ply)] {
        cases.push((name, text(&content.replace('\n', "\r")), Mesh(3, 1, "")));
        cases.push((name, text(&content.replace('\n', "\r\n")), Mesh(3, 1, "")));
        cases.push((name, text(content.trim_end()), Mesh(3, 1, "")));
        cases.push(("a", text(content), Mesh(3, 1, "")));
        cases.push(("a.xyz", text(&content.replace('\n', "\n\n")), Mesh(3, 1, "")));
    }
    cases.push(("a.xyz", utf16("1 2 3\n4 5 6", false), Cloud(2, "")));
    cases.push(("a.csv", utf16("x,y,z\r\n1,2,3\r\n4,5,6\r\n", true), Cloud(2, "")));
    cases.push(("a.xyz", text("1 2 3\r4 5 6\r"), Cloud(2, "")));
    cases.push(("a.xyz", text("1 2 3\n4 5 6\n\u{1a}"), Cloud(2, "")));
    cases.push(("a.xyz", b"1 2 3\n4 5 6\n\0\0\0".to_vec(), Refused("unknown format")));
    cases.push(("a.ply", utf16(ply, false), Mesh(3, 1, "")));
    expect(cases);
}

#[test]
fn odd_obj() {
    expect(vec![
        ("a.obj", text(&OBJ.replace("f 1", "f -0")), Cloud(3, "1 face with missing vertices")),
        ("a.obj", text(&OBJ.replace("f 1 2 3", "f 1 \\\n2 \\\n3")), Mesh(3, 1, "")),
        ("a.obj", text(&OBJ.replace("f 1 2 3", "f 1 2 3\\")), Mesh(3, 1, "")),
        (
            "a.obj",
            text(&OBJ.replace("f 1 2 3", "f 1 2")),
            Refused("no faces, only 1 line, and therefore no surface"),
        ),
        ("a.obj", text(&OBJ.replace("f 1 2 3", "l 1 2 3\nl 3 1")), Refused("no faces, only 2 lines")),
        (
            "a.obj",
            text(&format!("{}l 1 2\n", "v 1 2 3\n".repeat(1000))),
            Cloud(1000, "no faces, only 1 line; its vertices were read as a point cloud"),
        ),
        ("a.obj", text(&OBJ.replace("f 1 2 3", "p 1 2 3")), Cloud(3, "")),
        // A backslash goes on with numbers only.
        ("a.obj", text(&format!("# saved to C:\\models\\\n{OBJ}")), Mesh(3, 1, "")),
        ("a.obj", text(&OBJ.replace("v 1 0 0", "v 1 0 0 # C:\\")), Mesh(3, 1, "")),
        ("a.obj", text(&OBJ.replace("v 1 0 0", "usemtl brick\\\nv 1 0 0")), Mesh(3, 1, "")),
        ("a.obj", text(&OBJ.replace("v 1 0 0", "g left\\\nv 1 0 0")), Mesh(3, 1, "")),
        ("a.obj", text(&OBJ.replace("v 1 0 0", "o C:\\a\\  \r\nv 1 0 0")), Mesh(3, 1, "")),
        ("a.obj", text(&format!("mtllib C:\\a b\\\n{OBJ}")), Mesh(3, 1, "")),
        ("a.obj", text(&OBJ.replace("v 1 0 0", "v 1 \\\r\n 0 \\\r\n 0")), Mesh(3, 1, "")),
        // Control points are not the shape.
        (
            "a.obj",
            text("v 0 0 0\nv 1 0 0\nv 0 1 0\ncstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3\nparm u 0 1\nend\n"),
            Refused("free-form (curv, surf), which cannot be read; export it as polygons"),
        ),
        (
            "a.obj",
            text(&OBJ.replace("f 1 2 3", "f 99999999999999999999 2 3")),
            Refused("line 4: “99999999999999999999”"),
        ),
        ("a.obj", text(&OBJ.replace("f 1 2 3", "f 1.0 2 3")), Refused("line 4: “1.0” is not the index")),
        ("a.obj", text(&OBJ.replace("v 0 1 0", "v 0 1")), Refused("line 3: a vertex needs three")),
        ("a.obj", text(&OBJ.replace("v 0 1 0", "v 0 1,5 0")), Refused("line 3: “1,5” is not a number")),
        ("a.obj", text(&OBJ.replace("v 0 1 0", "v 0 1 0x10")), Refused("line 3: “0x10” is not a number")),
        (
            "a.obj",
            text(&format!("{OBJ}vt 0\nvp 1\ncurv 0 1\nsurf 0\nparm u 0\nend\nl 1 2\nf 3 2 1 # back\n")),
            Mesh(
                3,
                2,
                "ignored 2 free-form curves and surfaces: only polygons are supported; ignored 1 line next to the surfaces",
            ),
        ),
        ("a.obj", text("mtllib x.mtl\no nothing\n"), Refused("no points")),
        ("a.obj", text("V 0 0 0\nV 1 0 0\n"), Refused("no points")),
    ]);
}

#[test]
fn odd_ply() {
    let header = |body: &str| text(&format!("ply\nformat ascii 1.0\n{body}"));
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let list = |kind: &str| {
        format!(
            "element vertex 3\n{xyz}element face 1\nproperty list {kind} vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
        )
    };
    let mut big = b"ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                    element tristrips 1\nproperty list int int vertex_indices\nend_header\n".to_vec();
    for v in [0f32, 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.] {
        big.extend(v.to_be_bytes());
    }
    for v in [6i32, 0, 1, 2, 3, -1, 0] {
        big.extend(v.to_be_bytes());
    }
    expect(vec![
        ("a.ply", big, Mesh(4, 2, "")),
        ("a.ply", header(&list("uchar double")), Mesh(3, 1, "")),
        ("a.ply", header(&list("int64 uint64")), Mesh(3, 1, "")),
        ("a.ply", header(&list("float int")), Mesh(3, 1, "")),
        (
            "a",
            text(&format!("\nPLY \r\nformat ascii\r\n{}", list("uchar int").replace('\n', "\r\n"))),
            Mesh(3, 1, ""),
        ),
        ("a.ply", header(&list("double int").replace("3 0 1 2", "3.0 0 1 2")), Mesh(3, 1, "")),
        (
            "a.ply",
            header(&list("float int").replace("3 0 1 2", "2.5 0 1 2")),
            Refused("line 13: 2.5 is not a valid list length; expected a whole number"),
        ),
        (
            "a.ply",
            header(&list("uchar int").replace("3 0 1 2\n", "3 0 1 2 255 0 0\n")),
            Mesh(3, 1, "1 line has more values than the header declares, from line 13 on"),
        ),
        (
            "a.ply",
            header(&list("uchar int").replace(" 0 0\n", " 0 0 9 9\n")),
            Mesh(3, 1, "2 lines have more values than the header declares, from line 10 on"),
        ),
        // All of it on one line, or the vertices.
        (
            "a.ply",
            header(&list("uchar int").replace("0 0 0\n1 0 0\n0 1 0\n", "0 0 0 1 0 0 0 1 0 ")),
            Mesh(3, 1, ""),
        ),
        ("a.ply", header(&list("uchar int").replace("0 0 0\n1 0 0\n", "0 0 0 1 0 0\n")), Mesh(3, 1, "")),
        (
            "a.ply",
            header(&list("uchar int").replace("3 0 1 2\n", "")),
            Refused("the header declares 1 elements “face”"),
        ),
        // No faces.
        (
            "a.ply",
            header(&format!(
                "element vertex 2\n{xyz}element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0\n1 1 1\n0 1\n"
            )),
            Refused("no faces, only 1 line"),
        ),
        (
            "a.ply",
            header(&format!(
                "element vertex 3\n{xyz}element face 1\nproperty int a\nproperty int b\nproperty int c\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 1 2\n"
            )),
            Refused("its faces lack the property list vertex_indices"),
        ),
        (
            "a.ply",
            header(
                &list("uchar int")
                    .replace("property list", "property list uchar float texcoord\nproperty list")
                    .replace("3 0 1 2", "6 0 0 1 0 0 1 3 0 1 2")
                    .replace("vertex_indices", "corners"),
            ),
            Mesh(3, 1, ""),
        ),
        (
            "a.ply",
            header(
                "element chunk 1\nproperty float min_x\nelement vertex 1\nproperty uint packed_position\nend_header\n0\n0\n",
            ),
            Refused("its Gaussian splats are packed (packed_position)"),
        ),
        ("a.ply", header(&list("uchar list uchar int")), Refused("line 8: “property list uchar list")),
        (
            "a.ply",
            header(&list("uchar int").replace("3 0 1 2", "-3 0 1 2")),
            Refused("line 13: -3 is not a valid list length"),
        ),
        (
            "a.ply",
            header(&list("uchar int").replace("3 0 1 2", "999999999999 0 1 2")),
            Refused("line 13: the line has fewer"),
        ),
        (
            "a.ply",
            header(&format!("element vertex -5\n{xyz}end_header\n")),
            Refused("line 3: “-5” is not a number of elements"),
        ),
        (
            "a.ply",
            header(&format!(
                "comment a\nobj_info b\nelement vertex 1\ncomment c\n{xyz}comment\nend_header\n1 2 3\n"
            )),
            Cloud(1, ""),
        ),
        ("a.ply", header(&format!("element vertex 0\n{xyz}end_header\n")), Refused("no vertices")),
        (
            "a.ply",
            header(&format!(
                "element vertex 2\n{xyz}element vertex 1\n{xyz}property uchar red\nend_header\n0 0 0\n1 1 1\n2 2 2 9\n"
            )),
            Cloud(2, ""),
        ),
        ("a.ply", header(&format!("element vertex 1\n{xyz}")), Refused("no end (end_header)")),
        ("a.ply", text("ply\n"), Refused("line 2: the header has no end")),
        (
            "a.ply",
            header("element face 1000000000000\nproperty list uchar int vertex_indices\nend_header\n"),
            Refused("declares 1000000000000 elements “face”"),
        ),
        (
            "a.ply",
            header(
                "element vertex 1\nproperty list uchar float x\nproperty float y\nproperty float z\nend_header\n1 2 3 4\n",
            ),
            Refused("is a list"),
        ),
    ]);
}

/// An L of area 5, with its notch at the second corner, in every format that
/// has polygons; a fan around any corner but two would close the notch.
#[test]
fn concave_polygons_of_every_format() {
    let corners = [[3, 1], [1, 1], [1, 3], [0, 3], [0, 0], [3, 0]];
    let numbers = |i: usize| format!("{} {} 7", corners[i][0], corners[i][1]);
    for first in 0..6 {
        let vertices: Vec<String> = (0..6).map(|i| numbers((first + i) % 6)).collect();
        let lines = vertices.join("\n");
        let obj = format!("v {}\n", vertices.join("\nv "));
        let ply = |format: &str| {
            format!(
                "ply\nformat {format} 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                 element face 1\nproperty list uchar uchar vertex_indices\nend_header\n"
            )
        };
        let mut binary = ply("binary_little_endian").into_bytes();
        let coordinates = (0..6).flat_map(|i| corners[(first + i) % 6].into_iter().chain([7]));
        binary.extend(coordinates.flat_map(|v| (v as f32).to_le_bytes()));
        binary.extend([6, 0, 1, 2, 3, 4, 5]);
        let (head, elements) =
            ply("ascii").split_once("element face").map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
        let vertex = head.split_once("element vertex").unwrap().1.to_owned();
        let faces = elements.replace("end_header\n", "");
        for (name, content) in [
            ("a.obj", text(&format!("{obj}f 1 2 3 4 5 6\n"))),
            ("a.obj", text(&format!("{obj}vn 0 0 1\nvt 0 0\nf -6/1/1 -5/1/1 -4/1/1 -3/1/1 -2/1/1 -1/1/1\n"))),
            ("a.obj", text(&format!("f 6//1 5//1 4//1 \\\n 3//1 2//1 1//1\n{obj}vn 0 0 1\n"))),
            ("a.ply", text(&format!("{}{lines}\n6 0 1 2 3 4 5\n", ply("ascii")))),
            (
                "a.ply",
                text(&format!(
                    "ply\nformat ascii 1.0\nelement face{faces}element vertex{vertex}end_header\n6 5 4 3 2 1 0\n{lines}\n"
                )),
            ),
            ("a.ply", binary),
            ("a.off", text(&format!("OFF\n6 1 0\n{lines}\n6 0 1 2 3 4 5 255 0 0\n"))),
            (
                "a.stl",
                text(&format!(
                    "solid\nfacet normal 0 0 1\nouter loop\nvertex {}\nendloop\nendfacet\nendsolid",
                    vertices.join("\nvertex ")
                )),
            ),
        ] {
            let shape = read_bytes(&content, name).unwrap_or_else(|e| panic!("{e}"));
            let ShapeGeometry::Mesh(mesh) = &shape.geometry else { panic!("{name} is a cloud") };
            let triangles: Vec<_> = mesh.faces.iter().map(|f| mesh.corners(f).unwrap()).collect();
            let area: f64 = triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum();
            assert!((area - 5.0).abs() < 1e-12 && triangles.len() == 4, "{name}: {area}, {triangles:?}");
            let in_notch = |[a, b, c]: &[nalgebra::Point3<f64>; 3]| {
                let middle = (a.coords + b.coords + c.coords) / 3.0;
                middle.x > 1.0 && middle.y > 1.0
            };
            assert!(!triangles.iter().any(in_notch), "{name}: {triangles:?}");
        }
    }
}

/// Gaussian splats are points with the colours of their zeroth harmonics.
#[test]
fn splats_are_points_with_their_mean_colors() {
    let names = [
        "x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0", "opacity", "scale_0",
        "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3",
    ];
    let properties: String = names.iter().map(|name| format!("property float {name}\n")).collect();
    let mut file =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex 2\n{properties}end_header\n")
            .into_bytes();
    for [red, green, blue] in [[0.0, 9.0, -9.0], [0.886_226_9, -0.886_226_9, f32::NAN]] {
        let values =
            [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, red, green, blue, 5.0, -2.0, 0.1, 0.1, 0.1, 1.0, 0.0, 0.0, 0.0];
        file.extend(values.iter().flat_map(|v: &f32| v.to_le_bytes()));
    }
    let shape = read_bytes(&file, "a.ply").unwrap();
    assert_eq!(shape.attributes.colors, Some(vec![[128, 255, 0], [191, 64, 0]]));
    assert_eq!(shape.attributes.normals, None);
    let note = shape.notes.iter().find(|note| note.contains("Gaussian splats")).unwrap();
    assert!(
        note.contains("(f_dc)") && note.contains("sizes, rotations and opacities were ignored"),
        "{note}"
    );
}

#[test]
fn odd_stl() {
    let facet = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a b";
    let triangle: Vec<u8> = [0f32, 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0.]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .chain([0, 0])
        .collect();
    let binary = |name: &str, count: u32, triangles: usize| {
        let mut file = name.as_bytes().to_vec();
        file.resize(80, b' ');
        file.extend(count.to_le_bytes());
        file.extend(triangle.repeat(triangles));
        file
    };
    expect(vec![
        ("a.stl", binary("solid", 1, 1), Mesh(3, 1, "")),
        ("a.stl", binary("written as it went", 0, 3), Mesh(3, 3, "declares no triangles, but there are 3")),
        ("a.stl", binary("", 1, 3), Mesh(3, 1, "100 bytes after the 1 declared")),
        (
            "a.stl",
            binary("", 2, 1),
            Refused("byte 80: the header declares 2 triangles, but the file has room for at most 1"),
        ),
        ("a.stl", binary("", u32::MAX, 1), Refused("byte 80: the header declares 4294967295")),
        ("a.stl", [binary("COLOR=\u{1}", 1, 1), b"and more".to_vec()].concat(), Mesh(3, 1, "8 bytes after")),
        ("a.obj", binary("not an OBJ", 1, 1), Mesh(3, 1, "")),
        ("a.stl", text("solid\nendsolid\n"), Refused("no triangles")),
        (
            "a.stl",
            text(
                "solid x\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet endsolid",
            ),
            Mesh(3, 1, ""),
        ),
        (
            "a.stl",
            text(
                "SOLID X\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 0\nENDLOOP\nENDFACET\nENDSOLID",
            ),
            Mesh(3, 1, ""),
        ),
        ("a.stl", text(&facet.replace("endloop", "end loop")), Mesh(3, 1, "")),
        ("a.stl", text(&facet.replace("end", "End ").replace('\n', "\r\n\t")), Mesh(3, 1, "")),
        ("a.stl", text(&facet.replace('\n', " ")), Mesh(3, 1, "")),
        (
            "a.stl",
            text(&facet.replace("solid a b\n", "solid\n").replace("endsolid a b", "end\nsolid")),
            Mesh(3, 1, ""),
        ),
        (
            "a.stl",
            text(&facet.replace("solid a b", "solid facet 7 of normal size, endsolid")),
            Mesh(3, 1, ""),
        ),
        ("a.stl", text(&facet.replace("facet normal 0 0 1", "facet normal")), Mesh(3, 1, "")),
        ("a.stl", text(&facet.replace("facet normal 0 0 1", "facet normal 0 0 1 0 0 1")), Mesh(3, 1, "")),
        ("a.stl", text(&facet.replace("facet normal 0 0 1", "facet\nnormal 0 0\n1")), Mesh(3, 1, "")),
        ("a.stl", text(&format!("{facet}\n\n{}\n", facet.replace("vertex 1", "vertex 2"))), Mesh(4, 2, "")),
        ("a.stl", text(&format!("# by hand\n; too\n{facet}\nMade by a program\n{facet}\n")), Mesh(3, 2, "")),
        ("a.stl", text(&format!("{facet}\n\u{1a}\0\0\0")), Mesh(3, 1, "")),
        ("a.stl", text(facet.trim_start_matches("solid a b\n")), Mesh(3, 1, "")),
        ("a.stl", text(&facet.replace("endloop", "end lop")), Refused("line 7: unexpected “lop”")),
        ("a.stl", text(&facet.replace("endloop", "endloop vertx")), Refused("line 7: unexpected “vertx”")),
        ("a.stl", text(&facet.replace("vertex 0 1 0\n", "")), Refused("line 6: a facet needs three corners")),
        (
            "a.stl",
            text("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0"),
            Refused("a facet is incomplete"),
        ),
    ]);
}

#[test]
fn odd_off() {
    let body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    expect(vec![
        ("a.off", text(&format!("OFF3 1 0\n{body}")), Mesh(3, 1, "")),
        (
            "a.off",
            text(&format!("OFF 3 1 0 # counts\n# and\n\n  # comments\n{}", body.replace('\n', "\n# more\n"))),
            Mesh(3, 1, ""),
        ),
        ("a.off", text(&format!("OFF\n3 1\n{body}")), Mesh(3, 1, "")),
        ("a.off", text(&format!("STOFF\n3 1 0\n{}", body.replace("0 0 0", "0 0 0 0.5 0.5"))), Mesh(3, 1, "")),
        (
            "a.off",
            text(&format!("nOFF\n4\n3 1 0\n{body}")),
            Refused("line 1: “nOFF” starts an n-dimensional mesh"),
        ),
        ("a.off", text("OFF BINARY\n"), Refused("line 1: binary OFF")),
        ("a.off", text(&format!("OFF\n-3 1 0\n{body}")), Refused("line 2: “-3” is not a number of vertices")),
        (
            "a.off",
            text(&format!("OFF\n3 1000000000000 0\n{body}")),
            Refused("line 7: 1000000000000 faces are declared, but there are 1"),
        ),
        (
            "a.off",
            text(&format!("OFF\n3 1 0\n{}", body.replace("3 0 1 2", "4 0 1 2"))),
            Refused("line 6: the face has fewer corners"),
        ),
        (
            "a.off",
            text(&format!("OFF\n3 1 0\n{}", body.replace("3 0 1 2", "3 0 1 7"))),
            Cloud(3, "1 face with missing vertices"),
        ),
        (
            "a.off",
            text(&format!("OFF\n3 1 0\n{}", body.replace("3 0 1 2", "-1 0 1 2"))),
            Refused("line 6: “-1” is not a number of corners"),
        ),
        (
            "a.off",
            text(&format!("OFF\n3 1 0\n{}", body.replace("3 0 1 2", "2 0 1"))),
            Refused("no faces, only 1 line"),
        ),
        // The first word in any case, glued to the counts, or missing.
        ("a.off", text(&format!("off\n3 1 0\n{body}")), Mesh(3, 1, "")),
        ("a", text(&format!("Off 3 1 0\n{body}")), Mesh(3, 1, "")),
        ("a.off", text(&format!("coff3 1 0\n{}", body.replace("0\n", "0 255 0 0 255\n"))), Mesh(3, 1, "")),
        ("a.off", text(&format!("noff\n3 1 0\n{}", body.replace("0\n", "0 0 0 1\n"))), Mesh(3, 1, "")),
        ("a.off", text(&format!("3 1 0\n{body}")), Mesh(3, 1, "")),
        ("a.OFF", text(&format!("# none\n\n3 1 # edges\n{body}")), Mesh(3, 1, "")),
        ("a.off", text(&format!("OFF\n3\n1\n0\n{body}")), Mesh(3, 1, "")),
        ("a.off", text(&format!("{body}3 1 0\n")), Cloud(5, "")),
        // All on one line, or in lines of other lengths.
        ("a.off", text(&format!("OFF 3 1 0 {}", body.replace('\n', " "))), Mesh(3, 1, "")),
        ("a.off", text(&format!("off 3 1 0\n{} # end", body.replace('\n', "\t"))), Mesh(3, 1, "")),
        ("a.off", text(&format!("3 1 0\n{}", body.replace("0\n1", "0 1"))), Mesh(3, 1, "")),
        ("a.off", text(&format!("OFF 3 1 0 {body}")), Mesh(3, 1, "")),
        ("a.off", text("COFF 3 1 0 0 0 0 9 9 9 9 1 0 0 9 9 9 9 0 1 0 9 9 9 9 3 0 1 2"), Mesh(3, 1, "")),
        (
            "a.off",
            text("OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2 255 0 0"),
            Refused("put each vertex and each face on its own line"),
        ),
        ("a.off", text("OFF 3 1 0 0 0 0 1 0 0 0 1 0"), Refused("3 vertices are declared, but there are 0")),
        ("a.off", b"OFF BINARY\n\0\0\0\x03\0\0\0\x01\0\0\0\0".to_vec(), Refused("line 1: binary OFF")),
        ("a.off", text("nOFF 4\n3 1 0\n"), Refused("“nOFF” starts an n-dimensional mesh")),
        ("a.off", text("4nOFF\n4\n3 1 0\n"), Refused("“4nOFF” starts an n-dimensional mesh")),
        ("a.off", text("OOFF\n3 1 0\n"), Refused("“OOFF” does not start a three-dimensional OFF mesh")),
        ("a.off", text("OFF\n0 0 0\n"), Refused("no points")),
        ("a.off", text("OFF\n"), Refused("counts of vertices and faces are missing")),
    ]);
}

#[test]
fn odd_gltf() {
    let glb = |length: u32, json: &str| {
        let mut json = json.to_owned();
        while !json.len().is_multiple_of(4) {
            json.push(' ');
        }
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend((20 + json.len() as u32).to_le_bytes());
        file.extend(if length == 0 { json.len() as u32 } else { length }.to_le_bytes());
        file.extend(b"JSON");
        file.extend(json.bytes());
        file
    };
    let empty = r#"{"asset": {"version": "2.0"}}"#;
    let deep = format!("{}{}", r#"{"asset": {"version": "2.0"}, "extras": "#, "[".repeat(10_000));
    let nodes = |nodes: &str| {
        text(&format!(r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": {nodes}}}"#))
    };
    let buffer = |uri: &str| {
        text(&format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 4, "uri": "{uri}"}}]}}"#
        ))
    };
    expect(vec![
        ("a.glb", glb(u32::MAX, empty), Refused("byte 12: a part of 4294967295 bytes starts here")),
        ("a.glb", glb(8, empty), Refused("byte 28: a part of")),
        ("a.glb", glb(0, empty), Refused("neither triangles nor points")),
        ("a.glb", glb(0, "{}"), Refused("neither triangles nor points")),
        ("a.glb", b"glTF".to_vec(), Refused("byte 12: its JSON part is missing")),
        ("a.gltf", text(&deep), Refused("line 1")),
        ("a.gltf", nodes(r#"[{"children": [0]}]"#), Refused("node 0 has more than one parent")),
        (
            "a.gltf",
            nodes(r#"[{"children": [1]}, {"children": [0]}]"#),
            Refused("node 0 has more than one parent"),
        ),
        (
            "a.gltf",
            text(r#"{"asset": {"version": "2.0"}, "nodes": [{"children": [1]}, {"children": [0]}]}"#),
            Refused("form a cycle"),
        ),
        ("a.gltf", nodes(r#"[{"mesh": 7}]"#), Refused("mesh 7, but has 0")),
        ("a.gltf", buffer("a.bin"), Refused("is a separate file; embed it")),
        ("a.gltf", buffer("/etc/passwd"), Refused("in a different location")),
        ("a.gltf", buffer("data:;base64,!!!!"), Refused("buffer 0 is not valid base64")),
        ("a.gltf", text(r#"{"asset": {"version": "2.0"}, "nodes": 7}"#), Refused("line 1")),
        ("a.json", text(r#"{"type": "FeatureCollection"}"#), Refused("a GeoJSON map")),
    ]);
}

#[test]
fn odd_clouds() {
    let rows = "1 2 3\n4 5 6\n";
    let binary = [pcd("x y z", "4 4 4", "F F F", 2, "binary"), vec![0; 24]].concat();
    let bomb = npz(&[("points", npy("'<f8'", false, "1000000, 3", &vec![0; 24_000_000]))], true);
    assert!(bomb.len() < 100_000);
    expect(vec![
        (
            "a.pcd",
            text(&format!("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nDATA ascii\n{rows}")),
            Cloud(2, ""),
        ),
        ("a.xyz", binary, Cloud(2, "")),
        (
            "a.pcd",
            text(&format!(
                "\u{feff}# .PCD v0.7\r\nFIELDS x y z\r\nSIZE 4 4 4\r\nTYPE F F F\r\nPOINTS 2\r\nDATA ascii\r\n{rows}"
            )),
            Cloud(2, ""),
        ),
        (
            "a.pcd",
            text("# .PCD v0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 0\nDATA ascii\n"),
            Refused("no points"),
        ),
        (
            "a.pcd",
            pcd("x y z", "8 8 8", "F F F", usize::MAX / 8, "binary"),
            Refused("more than any file can contain"),
        ),
        ("a.pcd", text(rows), Cloud(2, "")),
        ("a.las", text("LASF"), Refused("the file ends here, but more data is declared")),
        ("a.las", text("nothing of a scan"), Refused("the file ends here, but more data is declared")),
        ("a.npy", text("nothing"), Refused("byte 0: a NumPy array starts with")),
        ("a.npz", text("PK\u{3}\u{4}nothing.npy"), Refused("the archive cannot be opened")),
        ("a.npz", text("nothing"), Refused("unknown format")),
        ("a.npz", bomb, Refused("24000000 bytes, more than the")),
        (
            "a.npy",
            npy("'<f8'", false, "2, 3", &f64s(&[f64::NAN; 6])),
            Refused("none of its points has finite"),
        ),
        ("a.xyz", text("1 2 3\n4 5 6 7 8 9 10 11\n"), Cloud(2, "")),
        ("a.xyz", text("1 2\n3 4\n"), Refused("line 1: 2 columns, but a point needs three")),
        ("a.csv", text("lat,lon\n1,2\n"), Refused("line 2: 2 columns")),
        ("a.txt", text("exported today\nX Y Z\nm m m\n1 2 3\n"), Cloud(1, "")),
        ("a.xyz", text(&format!("{}1 2 3\n", "# a long comment\n".repeat(10_000))), Cloud(1, "")),
        ("a.xyz", text("1e400 0 0\n1 1 1\n"), Cloud(2, "1 point has")),
        ("a.pts", text("99999999999999999999\n1 2 3\n"), Refused("line 1")),
    ]);
}

/// What a file is that can't be read, by its content first, then by its ending.
#[test]
fn other_formats_have_their_names() {
    let archive = |names: &[&str]| {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for name in names {
            zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
            zip.write_all(b"something").unwrap();
        }
        zip.finish().unwrap().into_inner()
    };
    let step = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\n";
    let iges = format!("{:72}S      1\n", "");
    let numbers = "1 2 3\n4 5 6\n";
    expect(vec![
        // By what is in an archive, whatever it is called.
        ("a.zip", archive(&["[Content_Types].xml", "3D/3dmodel.model"]), Refused("a 3MF model")),
        ("a", archive(&["scene.usdc", "0/texture.png"]), Refused("a USDZ scene")),
        ("model.bin", archive(&["archive/data.pkl", "archive/version"]), Refused("a PyTorch file")),
        ("a.zip", archive(&["[Content_Types].xml", "word/document.xml"]), Refused("a Word document")),
        (
            "a.xyz",
            archive(&["[Content_Types].xml", "xl/workbook.xml"]),
            Refused("sheet with the points as CSV"),
        ),
        ("a.zip", archive(&["doc.kml", "models/a.dae"]), Refused("a KMZ map")),
        ("a.zip", archive(&["Document.xml", "GuiDocument.xml"]), Refused("a FreeCAD document")),
        ("a.zip", archive(&["a.obj"]), Refused("a ZIP archive, which cannot be read; extract it")),
        ("a.npz", archive(&["readme.txt"]), Refused("an NPZ archive without arrays")),
        ("a.npz", archive(&[]), Refused("an NPZ archive without arrays")),
        // By the ending, where the content only tells how it is packed.
        ("a.3mf", b"PK\x03\x04cut short".to_vec(), Refused("a 3MF model")),
        (
            "a.blend",
            b"\x28\xb5\x2f\xfd0".to_vec(),
            Refused("a Blender scene, which cannot be read; export it"),
        ),
        ("a.pth", b"\x80\x02\x8a\x0a".to_vec(), Refused("a PyTorch file")),
        ("a.ply.gz", b"\x1f\x8b\x08\0".to_vec(), Refused("a gzip archive")),
        ("a.max", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1".to_vec(), Refused("a 3ds Max scene")),
        ("a.db3", b"SQLite format 3\0".to_vec(), Refused("a ROS bag")),
        ("a.7z", b"7z\xbc\xaf\x27\x1c\0".to_vec(), Refused("a 7-Zip archive")),
        ("a.rar", b"Rar!\x1a\x07".to_vec(), Refused("a RAR archive")),
        // By the first bytes.
        ("a.ply", b"Kaydara FBX Binary  \0".to_vec(), Refused("an FBX scene")),
        ("a.stl", b"BLENDER-v300".to_vec(), Refused("a Blender scene")),
        ("a", b"\xd4\xc3\xb2\xa1\x02\0\x04\0".to_vec(), Refused("a network capture (PCAP)")),
        ("a.las", b"ASTM-E57\x01\0\0\0".to_vec(), Refused("an E57 point cloud")),
        ("a.obj", b"b3dm\x01\0\0\0".to_vec(), Refused("a 3D Tiles tile")),
        ("a", b"\xff\xfe\xff\x0eS\0k\0e\0t\0c\0h\0U\0p\0".to_vec(), Refused("a SketchUp model")),
        ("a.tif", b"II*\0\x08\0\0\0".to_vec(), Refused("a picture (TIFF)")),
        // By the first words.
        ("a.ifc", text(step), Refused("an IFC building model")),
        ("a.stp", text("ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AP214'));\n"), Refused("a STEP model")),
        ("a.txt", text(&iges), Refused("an IGES model")),
        ("a.vtk", text("# vtk DataFile Version 3.0\n"), Refused("a VTK file")),
        ("a.vtp", text("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">\n"), Refused("a VTK file")),
        ("a.wrl", text("#VRML V2.0 utf8\n"), Refused("a VRML scene")),
        ("a.x3d", text("<?xml version=\"1.0\"?>\n<!DOCTYPE X3D>\n<X3D>\n"), Refused("an X3D scene")),
        ("a.amf", text("<?xml version=\"1.0\"?>\n<amf unit=\"inch\">\n"), Refused("an AMF model")),
        ("a.urdf", text("<robot name=\"a\">\n"), Refused("a URDF robot")),
        ("a.kml", text("<?xml version=\"1.0\"?>\n<kml>\n"), Refused("a KML map")),
        ("a.mtl", text("# Blender MTL File\nnewmtl a\n"), Refused("a material library (MTL)")),
        // JSON and lists, which are no rows of text.
        ("a.json", text("[[1, 2, 3], [4, 5, 6]]"), Refused("a list in brackets (JSON or Python)")),
        ("a.txt", text("[(1, 2, 3), (4, 5, 6)]"), Refused("save the points as an array (.npy")),
        ("a.json", text("[\n  [1, 2, 3],\n  [4, 5, 6]\n]\n"), Refused("a list in brackets")),
        ("a.json", text("[{\"x\": 1, \"y\": 2, \"z\": 3}]"), Refused("a list in brackets")),
        ("a.json", text("{\"points\": [\n[1, 2, 3],\n[4, 5, 6]\n]}"), Refused("a JSON file")),
        ("a.txt", text("[[1. 2. 3.]\n [4. 5. 6.]]\n"), Cloud(2, "")),
        ("a.txt", text("[[1, 2, 3],\n [4, 5, 6]]\n"), Cloud(2, "")),
        // By the ending alone, where rows of numbers may stand in anything.
        ("a.sat", text(numbers), Refused("an ACIS model")),
        ("a.rcp", vec![7, 0, 9, 1], Refused("a ReCap point cloud")),
        ("a.dae", text("nothing"), Refused("a COLLADA scene")),
        ("a.dat", text(numbers), Cloud(2, "")),
        ("a.3ds", text(OBJ), Mesh(3, 1, "")),
    ]);
}
