//! Reading: every dialect that is promised, and one clear error for the rest.

use crate::common::{cloud, mesh, read_as, shared_data};
use nalgebra::Point3;
use proptest::prelude::*;
use superform::geometry::TriMesh;
use superform::io::{self, ReadError, ShapeGeometry};

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";

/// Surface area.
fn area(mesh: &TriMesh) -> f64 {
    mesh.faces
        .iter()
        .filter_map(|f| mesh.corners(f))
        .map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm())
        .sum()
}

/// The message of a refusal.
fn refusal(name: &str, content: impl AsRef<[u8]>) -> String {
    read_as(name, content).expect_err("this should be refused").to_string()
}

// OBJ

#[test]
fn obj_faces_in_all_notations() {
    let plain = mesh(read_as("a.obj", TETRAHEDRON).unwrap());
    assert_eq!((plain.0.len(), plain.1.len()), (4, 4));
    let notations = [
        // Normals, texture coordinates (also wrong ones), line endings.
        TETRAHEDRON.replace('\n', "\r\n"),
        TETRAHEDRON.replace("f 1 2 3", "vn 0 0 1\nvt 0 0\nf 1/1/1 2/1/1 3/9/-7"),
        TETRAHEDRON.replace("f 1 2 3", "f 1//1 2//1 3//1"),
        TETRAHEDRON.replace("f 1 2 3", "f -4 -3 -2"),
        TETRAHEDRON.replace("f 1 2 3", "f 1 \\\n 2 3 # a comment"),
        // What other programs put in between.
        format!("# caf\u{e9}\nmtllib gone.mtl\no part\n{TETRAHEDRON}usemtl\ng\ns off\nl 1 2\np 1\n"),
        TETRAHEDRON.replace("v 0 0 0", "v 0 0 0 1.0").replace("v 1 0 0", "v 1 0 0 0.5 0.5 0.5 1"),
        // Faces before their vertices.
        format!("f 1 2 3\n{}", TETRAHEDRON.replace("f 1 2 3\n", "")),
    ];
    for text in notations {
        let (vertices, faces) = mesh(read_as("a.obj", &text).unwrap());
        assert_eq!((vertices.len(), faces.len()), (4, 4), "{text}");
        assert!((area(&TriMesh { vertices, faces }) - (1.5 + 0.75f64.sqrt())).abs() < 1e-12, "{text}");
    }
    let latin1 = [b"# caf\xe9\n", TETRAHEDRON.as_bytes()].concat();
    assert_eq!(mesh(read_as("a.obj", latin1).unwrap()).1.len(), 4);
    let utf16: Vec<u8> =
        std::iter::once(0xfeff).chain(TETRAHEDRON.encode_utf16()).flat_map(u16::to_be_bytes).collect();
    assert_eq!(mesh(read_as("a.obj", utf16).unwrap()).1.len(), 4);
}

#[test]
fn obj_polygons_become_triangles() {
    let text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\n";
    let (vertices, faces) = mesh(read_as("house.obj", text).unwrap());
    assert_eq!(faces.len(), 3);
    assert!((area(&TriMesh { vertices, faces }) - 3.0).abs() < 1e-12);
}

#[test]
fn obj_keeps_double_precision() {
    let text = "v 450000.12345 5400000.54321 1e-300\nv 450001 5400000 0\nv 450000 5400001 0\nf 1 2 3\n";
    let (vertices, _) = mesh(read_as("utm.obj", text).unwrap());
    assert_eq!(vertices[0], Point3::new(450000.12345, 5400000.54321, 1e-300));
}

#[test]
fn obj_without_faces_is_a_cloud_in_file_order() {
    let text = "o Cube\nv 3 0 0 0.2 0 1\nv 1 0 0 0 0 0\nv 2 nan 0 1 1 1\n";
    let shape = read_as("points.obj", text).unwrap();
    assert!(shape.notes[0].contains("1 point has"), "{:?}", shape.notes);
    let (points, colors) = cloud(shape);
    assert_eq!(points[..2], [Point3::new(3.0, 0.0, 0.0), Point3::new(1.0, 0.0, 0.0)]);
    assert!(points[2].y.is_nan());
    assert_eq!(colors, Some(vec![[51, 0, 255], [0, 0, 0], [255, 255, 255]]));
}

#[test]
fn obj_faces_that_cannot_be_are_left_out_and_noted() {
    let text = format!("{TETRAHEDRON}f 1 2 9\nf 0 1 2\nf -9 1 2\nf 1 1 2\nv 7 nan 7\nf 1 2 5\nv 1e9 0 0\n");
    let shape = read_as("a.obj", text).unwrap();
    assert_eq!(shape.notes.len(), 3, "{:?}", shape.notes);
    assert!(shape.notes[0].contains("3 faces with missing vertices"));
    assert!(shape.notes[1].contains("1 face with a non-finite coordinate"));
    assert!(shape.notes[2].contains("1 face with zero area"));
    let (vertices, faces) = mesh(shape);
    assert_eq!((vertices.len(), faces.len()), (4, 4), "and vertices without a face don't count");
}

#[test]
fn obj_without_any_area_is_taken_as_a_cloud() {
    let shape = read_as("line.obj", "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n").unwrap();
    assert!(shape.notes.iter().any(|n| n.contains("read as a point cloud")));
    assert_eq!(cloud(shape).0.len(), 3);
}

#[test]
fn obj_faults_are_located() {
    for (line, text) in
        [(2, "v 0 0 0\nv 1 x 0\n"), (1, "v 1 2\n"), (5, "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 two 3\n")]
    {
        let message = refusal("broken.obj", text);
        assert!(message.contains(&format!("broken.obj, line {line}:")), "{message}");
    }
    assert!(refusal("none.obj", "# nothing\n").contains("no points"));
}

// PLY

/// A PLY of one triangle and colours in each of the three encodings.
fn ply(encoding: &str) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat {encoding} 1.0\ncomment caf\u{e9}\nelement material 1\nproperty uchar id\n\
         element vertex 4\nproperty float confidence\nproperty double x\nproperty float y\nproperty short z\n\
         property list uchar int ids\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face 2\nproperty uchar flag\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    .into_bytes();
    let vertices = [(0.5, 0.25, -3i16), (1.5, 0.0, 7), (0.0, 1.0, 0), (9.0, 9.0, 9)];
    let faces: [&[u32]; 2] = [&[0, 1, 2], &[0, 1, 3, 2]];
    if encoding == "ascii" {
        file.extend(b"5\n");
        for (i, (x, y, z)) in vertices.iter().enumerate() {
            file.extend(format!("0.9 {x} {y} {z} 2 7 8 {i} 20 30\r\n").bytes());
        }
        for face in faces {
            let list: Vec<String> = face.iter().map(u32::to_string).collect();
            file.extend(format!("\n 1 {} {}\n", face.len(), list.join(" ")).bytes());
        }
        return file;
    }
    let big = encoding == "binary_big_endian";
    let mut put = |bytes: &[u8]| {
        if big {
            file.extend(bytes.iter().rev());
        } else {
            file.extend(bytes);
        }
    };
    put(&[5]);
    for (i, (x, y, z)) in (0u8..).zip(vertices) {
        put(&0.9f32.to_le_bytes());
        put(&f64::to_le_bytes(x));
        put(&f32::to_le_bytes(y));
        put(&i16::to_le_bytes(z));
        put(&[2]);
        put(&7i32.to_le_bytes());
        put(&8i32.to_le_bytes());
        [i, 20, 30].iter().for_each(|c| put(&[*c]));
    }
    for face in faces {
        put(&[1]);
        put(&[face.len() as u8]);
        face.iter().for_each(|i| put(&i.to_le_bytes()));
    }
    file
}

#[test]
fn ply_encodings_agree() {
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let (vertices, faces) = mesh(read_as("a.ply", ply(encoding)).unwrap());
        assert_eq!(vertices[..2], [Point3::new(0.5, 0.25, -3.0), Point3::new(1.5, 0.0, 7.0)], "{encoding}");
        assert_eq!(faces, [[0, 1, 2], [2, 0, 1], [2, 1, 3]], "{encoding}: the bent quad has a notch at 2");
        // The same file without its faces is a cloud with colours.
        let text = String::from_utf8_lossy(&ply("ascii")).replace("element face 2", "element face 0");
        let text = text.split("\n 1 ").next().unwrap().to_owned();
        let (points, colors) = cloud(read_as("a.ply", text.trim_end()).unwrap());
        assert_eq!(points.len(), 4);
        assert_eq!(colors.unwrap()[3], [3, 20, 30]);
    }
}

#[test]
fn ply_triangle_strips_are_read() {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
                element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 2 0\n8 0 1 2 3 -1 1 3 4\n";
    let (_, faces) = mesh(read_as("strips.ply", text).unwrap());
    assert_eq!(faces, [[0, 1, 2], [1, 2, 3], [1, 3, 4]]);
}

#[test]
fn ply_faces_out_of_range_are_left_out() {
    let text = String::from_utf8(ply("ascii")).unwrap().replace("3 0 1 2\n", "3 0 -1 77\n");
    let shape = read_as("a.ply", text).unwrap();
    assert!(shape.notes[0].contains("1 face with missing vertices"), "{:?}", shape.notes);
    assert_eq!(mesh(shape).1.len(), 2);
}

#[test]
fn ply_that_promises_too_much_is_refused_before_it_costs_memory() {
    for encoding in ["ascii", "binary_little_endian"] {
        for count in ["1000000000000", "18446744073709551615", "99999999999999999999999"] {
            let text = format!(
                "ply\nformat {encoding} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
                 property float z\nend_header\n0 0 0\n"
            );
            let message = refusal("bomb.ply", text);
            assert!(message.contains("bomb.ply, ") && message.contains(count), "{message}");
        }
    }
    // Elements without properties take no room, however many there are.
    let text = "ply\nformat binary_little_endian 1.0\nelement nothing 99999999999999\nelement vertex 1\n\
                property uchar x\nproperty uchar y\nproperty uchar z\nend_header\nabc";
    assert_eq!(cloud(read_as("a.ply", text).unwrap()).0, [Point3::new(97.0, 98.0, 99.0)]);
    // A list of four billion entries that are not there.
    let mut file = b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty list uint double w\n\
                     property uchar x\nproperty uchar y\nproperty uchar z\nend_header\n"
        .to_vec();
    file.extend([0xff; 8]);
    assert!(refusal("a.ply", file).contains("truncated"));
}

#[test]
fn ply_faults_are_located() {
    let good = String::from_utf8(ply("ascii")).unwrap();
    for (from, to, place) in [
        ("0.9 1.5", "0.9 one", "line 21: “one” is not a number"),
        ("2 7 8 1", "2 7 8", "line 21: the line has fewer"),
        ("property double x", "property double w", "lack the properties x, y and z"),
        ("property double x", "property decimal x", "line 8: “property decimal x” is not a property"),
        ("end_header\n", "", "line 18"),
        ("format ascii 1.0\n", "", "has no format"),
        ("format ascii", "format binary_middle_endian", "line 2: unknown format"),
    ] {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good);
        let message = refusal("a.ply", text);
        assert!(message.contains(place), "{message} lacks {place}");
    }
    assert!(refusal("short.ply", &ply("binary_big_endian")[..430]).contains("byte"));
}

// XYZ text

#[test]
fn xyz_dialects_agree() {
    let expected = [Point3::new(1.5, -2.0, 3e-3), Point3::new(4.0, 5.25, -6.0)];
    for text in [
        "1.5 -2 3e-3\n4 5.25 -6\n",
        "1.5\t-2\t3e-3\r\n4\t5.25\t-6",
        "1.5,-2,0.003\n\n4, 5.25, -6\n",
        "1.5;-2;0.003\n4;5.25;-6\n",
        "1,5;-2;0,003\n4;5,25;-6\n",
        "1,5 -2,0 0,003\n4,0 5,25 -6,0\n",
        "# a comment\n// another\nx,y,z\n1.5,-2,0.003\n4,5.25,-6\n",
        "\"X\";\"Y\";\"Z\"\n1.5;-2;0.003\n4;5.25;-6\n",
        "name z y x\nwall 0.003 -2 1.5\nroof -6 5.25 4\n",
        "//X Y Z\n1.5 -2 3e-3\n4 5.25 -6\n",
        "2\n1.5 -2 3e-3\n4 5.25 -6\n",
        "\u{feff}1.5 -2 3e-3\n4 5.25 -6\n",
        "1.5 -2 3e-3 0.1 0.2 0.97\n4 5.25 -6 0 0 1\n",
    ] {
        let shape = read_as("points.txt", text).unwrap();
        assert!(shape.notes.is_empty());
        assert_eq!(cloud(shape), (expected.to_vec(), None), "{text}");
    }
}

#[test]
fn xyz_colors_are_taken_where_they_are_unmistakable() {
    let colors = |text: &str| cloud(read_as("points.xyz", text).unwrap()).1;
    assert_eq!(colors("0 0 0 255 0 9\n1 1 1 1 2 3\n"), Some(vec![[255, 0, 9], [1, 2, 3]]));
    assert_eq!(colors("0 0 0 -1234 255 0 9\n"), Some(vec![[255, 0, 9]]), "intensity comes before");
    assert_eq!(colors("x y z a r g b\n0 0 0 7 255 0 9\n"), Some(vec![[255, 0, 9]]));
    assert_eq!(colors("0 0 0 0 0 1\n1 1 1 1 0 0\n"), None, "these are normals");
    assert_eq!(colors("0 0 0 255 0 9\n1 1 1 256 0 0\n"), None);
    assert_eq!(colors("0 0 0 255 0 9\n1 1 1 0.5 0 0\n"), None);
    assert_eq!(colors("0 0 0 255 0 9\n1 1 1\n"), None);
}

#[test]
fn xyz_keeps_points_that_are_not_finite_in_their_place() {
    let shape = read_as("points.xyz", "0 0 0\nNaN nan 1\n1 -inf 0\n2 2 2\n").unwrap();
    assert!(shape.notes[0].contains("2 points have"), "{:?}", shape.notes);
    let points = cloud(shape).0;
    assert_eq!(points.len(), 4);
    assert_eq!(points[3], Point3::new(2.0, 2.0, 2.0));
    assert!(refusal("nan.xyz", "nan nan nan\n").contains("finite"));
}

#[test]
fn xyz_faults_are_located() {
    for (text, words) in [
        ("0 0 0\n1 1\n", "line 2: 2 columns"),
        ("0 0 0\n# c\n1 1 one\n", "line 3: “one” is not a number"),
        ("milk\nbread\n", "line 2"),
        ("1.5 2 3\n1,5 2 3\n1 2\n", "line 3: 2 columns"),
    ] {
        let message = refusal("a.xyz", text);
        assert!(message.contains(words), "{message}");
    }
    let shape = read_as("a.pts", "5\n0 0 0\n1 1 1\n").unwrap();
    assert!(shape.notes[0].contains("declares 5 points, but there are 2"));
}

// Any file

#[test]
fn content_goes_before_the_name() {
    assert_eq!(mesh(read_as("a.xyz", TETRAHEDRON).unwrap()).1.len(), 4);
    assert_eq!(mesh(read_as("a", ply("ascii")).unwrap()).1.len(), 3);
    assert_eq!(cloud(read_as("a.obj", "0 0 0\n1 1 1\n").unwrap()).0.len(), 2);
}

#[test]
fn other_formats_are_named() {
    let mut tar = vec![0; 600];
    tar[257..262].copy_from_slice(b"ustar");
    for (content, what, advice) in [
        (b"ASTM-E57\x01\0".as_slice(), "an E57 point cloud", "CloudCompare"),
        (b"PK\x03\x04 doc.xml", "a ZIP archive", "extract it"),
        (b"\x1f\x8b\x08\0", "a gzip archive", "extract it"),
        (&tar, "a tar archive", "extract it"),
        (b"MM\0\x10\0\0\x02\0\x0a\0", "a 3DS scene", "convert it to OBJ"),
        (b"ISO-10303-21;\nHEADER;\n", "a STEP model", "CAD"),
        (b"<?xml version=\"1.0\"?>\n<COLLADA>\n", "a COLLADA scene", "convert it to OBJ"),
        (b"0\r\nSECTION\r\n2\r\n", "a DXF drawing", "convert it to OBJ"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "a Git LFS pointer", "git lfs pull"),
        (b"<!DOCTYPE html><html>404</html>", "a web page", "download"),
        (
            b"2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n",
            "a PTX scan",
            "XYZ",
        ),
        (b"ncols 4\nnrows 5\nxllcorner 0\n1 2 3 4\n", "a height grid", "XYZ"),
        (b"\x80\x04\x95\x10\0", "a Python pickle", ".npy"),
    ] {
        // Whatever the name says.
        for name in ["a.xyz", "a.obj", "a.stl", "a"] {
            let message = refusal(name, content);
            assert!(message.contains(what) && message.contains(advice), "{message}");
        }
    }
    let primitives = "{\"format\": \"superform-primitives\", \"version\": 1}";
    assert!(matches!(read_as("a.json", primitives), Err(ReadError::Primitives { .. })));
    assert!(matches!(read_as("a.xyz", b"\x89Superform\n"), Err(ReadError::Session { .. })));
    assert!(refusal("a", "Dear all,\nhello\n").contains("unknown format"));
    assert!(refusal("a.ply", "").contains("empty"));
    assert!(refusal("a.ply", "plywood").contains("line 1"));
}

#[test]
fn what_is_no_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(io::read(folder.path()), Err(ReadError::NotAFile { .. })));
    let message = io::read(&folder.path().join("none.obj")).unwrap_err().to_string();
    assert!(message.contains("cannot open") && message.contains("none.obj"), "{message}");
}

#[test]
fn the_built_in_shape_is_a_chair() {
    let shape = io::built_in().unwrap();
    assert!(shape.notes.is_empty());
    let ShapeGeometry::Mesh(chair) = &shape.geometry else { panic!("a cloud") };
    assert_eq!(chair.faces.len(), 1912);
    assert_eq!(io::sample(&shape, &Default::default()).unwrap().points.len(), 5500);
}

/// Every file of the test shapes that can be read, against what is known of
/// it: the number of faces of a mesh and of points of a cloud.
#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn test_shapes_have_the_size_that_is_known_of_them() {
    let folder = shared_data();
    let table = std::fs::read_to_string(folder.join("SOURCES.csv")).unwrap();
    let mut seen = 0;
    for row in table.lines().skip(1) {
        let columns: Vec<&str> = row.split(',').collect();
        let [path, _, _, _, vertices, faces, ..] = columns[..] else { panic!("{row}") };
        let ending = path.rsplit('.').next().unwrap();
        if !io::SHAPE_ENDINGS.contains(&ending.to_ascii_lowercase().as_str()) {
            assert!(io::read(&folder.join(path)).is_err(), "{path}");
            continue;
        }
        let (Ok(vertices), Ok(faces)) = (vertices.parse::<usize>(), faces.parse::<usize>()) else { continue };
        // The table's reader knows neither decimal commas nor triangle strips,
        // and keeps faces without an area.
        if vertices == 0 || ["hard/tristrips.ply", "hard/all_faces_degenerate.obj"].contains(&path) {
            continue;
        }
        let shape = io::read(&folder.join(path)).unwrap_or_else(|e| panic!("{e}"));
        let left_out: usize = shape
            .notes
            .iter()
            .filter_map(|n| n.strip_prefix("ignored ")?.split(' ').next()?.parse::<usize>().ok())
            .sum();
        match &shape.geometry {
            // It cuts polygons as fans, too: over a notch one may have a triangle
            // without an area, which ears have not.
            ShapeGeometry::Mesh(mesh) => {
                let fewer = faces.checked_sub(mesh.faces.len() + left_out);
                assert!(fewer.is_some_and(|fewer| fewer <= faces / 1000), "{path}: {fewer:?} of {faces}");
            }
            ShapeGeometry::Cloud(cloud) => assert_eq!((cloud.points.len(), 0), (vertices, faces), "{path}"),
        }
        seen += 1;
    }
    assert!(seen > 90, "only {seen} files were compared");
}

/// Good files, to be broken.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("a.obj", TETRAHEDRON.into()),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf -3/1/1 -2/1 -1//1 \\\n 1\n".into()),
        ("a.ply", ply("ascii")),
        ("a.ply", ply("binary_little_endian")),
        ("a.ply", ply("binary_big_endian")),
        ("a.xyz", "3\n0 0 0 255 0 0\n1 1 1 0 255 0\n2 2 2 0 0 255\n".into()),
        ("a.csv", "x;y;z;r;g;b\n1,5;2;3;4;5;6\n7;8,25;9;10;11;12\n".into()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever is cut off, changed or doubled: a shape or an error, never a
    /// panic, and a shape that can be sampled.
    #[test]
    fn broken_files_never_panic(
        which in 0usize..7,
        cut in 0.0..1.3f64,
        changes in prop::collection::vec((0.0..1.0f64, prop_oneof![
            any::<u8>(),
            prop::sample::select(b"\n\r 0-1.,;/\\efv#\0\xff".to_vec()),
        ]), 0..6),
        double in prop::option::of((0.0..1.0f64, 1usize..40)),
    ) {
        let (name, mut bytes) = seeds().swap_remove(which);
        let length = bytes.len() as f64;
        for (at, byte) in changes {
            bytes[(at * length) as usize] = byte;
        }
        if let Some((at, count)) = double {
            let at = (at * length) as usize;
            let piece = bytes[at..bytes.len().min(at + count)].to_vec();
            bytes.splice(at..at, piece);
        }
        bytes.truncate((cut * length) as usize);
        match read_as(name, &bytes) {
            Ok(shape) => {
                let sampled = io::sample(&shape, &superform::geometry::SamplingOptions { points: 30, ..Default::default() });
                prop_assert!(sampled.is_ok(), "{:?}", sampled);
            }
            Err(e) => prop_assert!(!e.to_string().is_empty()),
        }
    }
}

/// Texts that are parsed in several pieces, with what stands between the lines.
#[test]
fn large_texts_are_read_in_order_and_faults_are_located() {
    let count = 60_000;
    let point = |i: usize| [(i * i % 101) as f64 * 0.25, -(i as f64), 1e-3 * i as f64];
    let mut xyz = String::from("# a scan\n");
    let mut obj = String::from("o points\r\n");
    for i in 0..count {
        let [x, y, z] = point(i);
        match i % 4 {
            // Every way to part numbers and to end lines, and numbers that aren't plain.
            0 => xyz.push_str(&format!("{x} {y} {z}\n")),
            1 => xyz.push_str(&format!("\t{x},{y} ,{z:e}\r\n")),
            2 => xyz.push_str(&format!("{x};{y};{z}\r")),
            _ => xyz.push_str(&format!("# é {i}\n\n{x}  {y}\u{a0}{z}\n")),
        }
        obj.push_str(&format!("v {x} {y} {z}\r\n"));
        if i >= 2 {
            // Relative, and absolute indices that point ahead.
            obj.push_str(&if i % 2 == 0 {
                format!("f {} {} 1\n", count - i, i)
            } else {
                "f -1 -2 -3\n".to_owned()
            });
        }
    }
    let expected: Vec<Point3<f64>> = (0..count).map(|i| Point3::from(point(i))).collect();
    assert_eq!(cloud(read_as("scan.xyz", &xyz).unwrap()).0, expected);
    let (vertices, faces) = mesh(read_as("points.obj", &obj).unwrap());
    for (face, i) in faces.iter().zip([2, 3, 4, 5]) {
        let corners = if i % 2 == 0 { [count - i - 1, i - 1, 0] } else { [i, i - 1, i - 2] };
        assert_eq!(face.map(|c| vertices[c as usize]), corners.map(|c| expected[c]), "face of vertex {i}");
    }

    let lines = |text: &str| text.replace("\r\n", "\n").matches(['\n', '\r']).count();
    let message = refusal("scan.xyz", format!("{xyz}1 2 x\n3 4 5\n"));
    assert!(
        message.contains(&format!("scan.xyz, line {}: “x” is not a number", lines(&xyz) + 1)),
        "{message}"
    );
    let message = refusal("points.obj", format!("{obj}v 1 2\n{obj}"));
    assert!(message.contains(&format!("points.obj, line {}:", lines(&obj) + 1)), "{message}");
}
