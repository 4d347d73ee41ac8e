//! Clouds as PCD, LAS, NumPy arrays and tables, with their colours, normals
//! and labels; and the attributes of meshes.

use crate::formats::{cloud_of, f32s, f64s, las, npy, npz, pcd, pcd_packed, refusal};
use nalgebra::Point3;
use superform::geometry::SamplingOptions;
use superform::io::{self, Attributes, ShapeGeometry, read_bytes};

const PLACES: [[f64; 3]; 4] = [[0.0, 0.5, -1.0], [1.0, 2.0, 3.0], [-4.0, 0.25, 8.0], [5.0, 6.0, 7.5]];

fn flat() -> Vec<f64> {
    PLACES.concat()
}

// PCD

#[test]
fn pcd_forms_agree() {
    let (fields, sizes, types) =
        ("label rgb y x z normal_x normal_y normal_z", "2 4 8 4 4 4 4 4", "U F F F F F F F");
    let rgb = |i: usize| f32::from_bits(0x00_10_20_00 | i as u32);
    let mut text = pcd(fields, sizes, types, 4, "ascii");
    let mut rows = pcd(fields, sizes, types, 4, "binary");
    let mut columns = vec![Vec::new(); 8];
    for (i, [x, y, z]) in PLACES.into_iter().enumerate() {
        text.extend(format!("{} {:e} {y} {x} {z} 0 0 1\n", 7 + i, rgb(i)).bytes());
        let numbers: [&[u8]; 8] = [
            &(7 + i as u16).to_le_bytes(),
            &rgb(i).to_le_bytes(),
            &y.to_le_bytes(),
            &(x as f32).to_le_bytes(),
            &(z as f32).to_le_bytes(),
            &0f32.to_le_bytes(),
            &0f32.to_le_bytes(),
            &1f32.to_le_bytes(),
        ];
        for (column, number) in columns.iter_mut().zip(numbers) {
            rows.extend(number);
            column.extend(number);
        }
    }
    let packed = pcd_packed(pcd(fields, sizes, types, 4, "binary_compressed"), &columns.concat());
    for file in [&text, &rows, &packed] {
        let (points, shape) = cloud_of("a.pcd", file);
        assert_eq!(points, PLACES);
        assert!(shape.notes.is_empty(), "{:?}", shape.notes);
        let known = Attributes {
            colors: Some((0..4).map(|i| [0x10, 0x20, i]).collect()),
            normals: Some(vec![[0.0, 0.0, 1.0]; 4]),
            labels: Some(vec![7, 8, 9, 10]),
        };
        assert_eq!(shape.attributes, known);
        // By its content, whatever it is called.
        assert_eq!(cloud_of("a.obj", file).0, PLACES);
    }
    // Colours as the whole numbers that their bits are, also beyond floats.
    let whole = format!(
        "{}1 2 3 4280295456\n",
        String::from_utf8(pcd("x y z rgb", "4 4 4 4", "F F F F", 1, "ascii")).unwrap()
    );
    assert_eq!(cloud_of("a.pcd", whole).1.attributes.colors, Some(vec![[0x20, 0x20, 0x20]]));
}

#[test]
fn pcd_says_where_the_sensor_was() {
    let of = |viewpoint: &str| {
        let file = String::from_utf8(pcd("x y z", "4 4 4", "F F F", 2, "ascii")).unwrap() + "1 2 3\n4 5 6\n";
        let shape = cloud_of("a.pcd", file.replace("VIEWPOINT 0 0 0 1 0 0 0\n", viewpoint)).1;
        let cloud = io::sample(&shape, &SamplingOptions::default()).unwrap();
        assert_eq!(cloud.viewpoints, shape.viewpoints);
        (shape.viewpoints, shape.notes)
    };
    let (places, notes) = of("VIEWPOINT 0.5 -2 1e1 0.7 0 0.7 0\n");
    assert_eq!((places, notes), (vec![Point3::new(0.5, -2.0, 10.0)], vec![]));
    // Without a word of it, and with the default that most programs write.
    for unknown in ["", "VIEWPOINT 0 0 0 1 0 0 0\n"] {
        assert_eq!(of(unknown), (vec![], vec![]), "{unknown}");
    }
    for bad in ["VIEWPOINT 1 2 three 1 0 0 0\n", "VIEWPOINT 1 2 3\n", "VIEWPOINT nan 2 3 1 0 0 0\n"] {
        let (places, notes) = of(bad);
        assert!(places.is_empty() && notes[0].contains("VIEWPOINT is not seven numbers"), "{bad}: {notes:?}");
    }
}

#[test]
fn pcd_fields_may_be_many_and_grids_have_holes() {
    let header = "VERSION .7\nFIELDS x _ y z fpfh\nSIZE 4 1 4 4 4\nTYPE F U F F F\nCOUNT 1 4 1 1 3\nWIDTH 2\nHEIGHT 2\nDATA ascii\n";
    let rows = "1 0 0 0 0 2 3 9 9 9\nnan 0 0 0 0 nan nan 9 9 9\n4 0 0 0 0 5 6 9 9 9\n7 0 0 0 0 8 9 9 9 9\n";
    let (points, shape) = cloud_of("a.pcd", format!("{header}{rows}"));
    assert_eq!((points[0], points[3]), ([1.0, 2.0, 3.0], [7.0, 8.0, 9.0]));
    assert!(shape.notes[0].contains("1 point has"), "{:?}", shape.notes);
    // POINTS counts where WIDTH × HEIGHT says something else.
    let other = header.replace("DATA", "POINTS 3\nDATA");
    let (points, shape) = cloud_of("a.pcd", format!("{other}{rows}"));
    assert_eq!(points.len(), 3);
    assert!(shape.notes[0].contains("is 4, but POINTS is 3"), "{:?}", shape.notes);
    assert!(shape.notes[1].contains("ignored 1 lines"), "{:?}", shape.notes);
}

#[test]
fn pcd_that_is_broken_says_where() {
    let good = String::from_utf8(pcd("x y z", "4 4 4", "F F F", 2, "ascii")).unwrap() + "1 2 3\n4 5 6\n";
    for (from, to, words) in [
        ("4 5 6\n", "", "line 11: the header declares 2 points, but there are 1"),
        ("4 5 6", "4 5", "line 12: the line holds 2 values, but its fields need 3"),
        ("4 5 6", "4 five 6", "line 12: “five” is not a number"),
        ("x y z", "x y w", "line 3: its fields are x, y, w, but x, y and z are needed"),
        ("SIZE 4 4 4", "SIZE 4 4", "line 4: SIZE has 2 entries for 3 fields"),
        ("TYPE F F F", "TYPE F F Q", "line 5: unknown number type “Q”"),
        ("SIZE 4 4 4", "SIZE 4 4 3", "line 5: unknown number type “F” of size 3"),
        ("DATA ascii", "DATA jpeg", "line 10: “jpeg” is not one of ascii"),
        ("POINTS 2", "POINTS -2", "line 9: “-2” is not a number of points"),
        ("POINTS 2", "POINTS 9999999999999999999", "line 9: 9999999999999999999 points"),
        ("VIEWPOINT", "VIEWPORT", "line 8: unexpected “VIEWPORT 0 0 0 1 0 0 0”"),
        ("DATA ascii\n1 2 3\n4 5 6\n", "", "no end (a DATA line)"),
    ] {
        assert!(good.contains(from), "{from}");
        let message = refusal("a.pcd", good.replacen(from, to, 1));
        assert!(message.contains(words), "{message} lacks {words}");
    }
    // The place of the body depends on the length of the count.
    let binary = |n: usize| pcd("x y z", "4 4 4", "F F F", n, "binary");
    let cut = [binary(1_000_000_000_000), vec![0; 30]].concat();
    let message = refusal("a.pcd", cut);
    assert!(
        message.contains("the header declares 1000000000000 points of 12 bytes, but the file has room for 2"),
        "{message}"
    );
    let packed = pcd("x y z", "4 4 4", "F F F", 100, "binary_compressed");
    let body = vec![0; 1200];
    let good = pcd_packed(packed.clone(), &body);
    assert_eq!(cloud_of("a.pcd", &good).0, vec![[0.0; 3]; 100]);
    let at = packed.len();
    let with = |place: usize, size: u32| {
        let mut file = good.clone();
        file[place..place + 4].copy_from_slice(&size.to_le_bytes());
        file
    };
    for (file, words) in [
        (with(at, 9999), "9999 bytes of compressed data are declared"),
        (with(at + 4, 9), "the header declares 100 points of 12 bytes, but the file has room for 0"),
        (with(at + 4, u32::MAX), "cannot expand to the declared 4294967295"),
        (good[..at + 3].to_vec(), "the sizes of the compressed data are missing"),
        (good[..at + 12].to_vec(), "is truncated"),
        ([good[..at + 8].to_vec(), vec![0xff; good.len() - at - 8]].concat(), "are damaged"),
    ] {
        let message = refusal("a.pcd", file);
        assert!(
            message.contains(words)
                && message.contains(&format!("byte {at}")) | message.contains(&format!("byte {}", at + 8)),
            "{message} lacks {words}"
        );
    }
}

// LAS

#[test]
fn las_keeps_places_colors_and_classes() {
    let scan: Vec<([f64; 3], u8, [u16; 3])> = (0..300)
        .map(|i| {
            let t = f64::from(i);
            let place = [500_000.0 + 0.001 * t, 5_400_000.0 + 0.01 * t, 0.1 * t];
            (place, 2 + (i % 4) as u8, [65535, 257 * (i % 256) as u16, 0])
        })
        .collect();
    for (format, has_color) in [(0, false), (2, true), (3, true), (6, false), (7, true)] {
        for compressed in [false, true] {
            let (points, shape) = cloud_of("scan", las(format, compressed, &scan));
            let far = points.iter().zip(&scan).flat_map(|(p, (q, ..))| (0..3).map(|k| (p[k] - q[k]).abs()));
            assert!(far.fold(0.0, f64::max) < 1e-8, "format {format}");
            let labels: Vec<i64> = scan.iter().map(|(_, class, _)| i64::from(*class)).collect();
            assert_eq!(shape.attributes.labels, Some(labels), "format {format}");
            let colors: Vec<[u8; 3]> = (0..300).map(|i| [255, (i % 256) as u8, 0]).collect();
            assert_eq!(shape.attributes.colors, has_color.then_some(colors), "format {format}");
        }
    }
    // Colours of 8 bits, and classes that nobody gave.
    let plain: Vec<_> = scan.iter().map(|(p, ..)| (*p, 1, [200, 100, 0])).collect();
    let shape = cloud_of("scan", las(2, false, &plain)).1;
    assert_eq!(shape.attributes.colors.unwrap()[0], [200, 100, 0]);
    assert_eq!(shape.attributes.labels, None);
    // No point at all.
    let message = refusal("a.las", las(0, false, &[]));
    assert!(
        message.contains("the header declares no points") || message.contains("should start at"),
        "{message}"
    );
}

#[test]
fn las_that_lies_is_refused_before_it_costs_memory() {
    let scan: Vec<_> =
        (0..500).map(|i| ([500_000.0 + f64::from(i), 5_400_000.0, 0.0], 2, [1, 2, 3])).collect();
    let with = |file: &[u8], at: usize, bytes: &[u8]| {
        let mut file = file.to_vec();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    for compressed in [false, true] {
        for format in [3, 7] {
            let good = las(format, compressed, &scan);
            let offset = u32::from_le_bytes(good[96..100].try_into().unwrap()) as usize;
            let huge = (1u64 << 40).to_le_bytes();
            for (file, words) in [
                (
                    with(&with(&good, 107, &[0; 4]), 247, &huge),
                    "byte 247: the header declares 1099511627776 points",
                ),
                (
                    with(&good, 107, &u32::MAX.to_le_bytes()),
                    "byte 107: the header declares 4294967295 points",
                ),
                (
                    with(&good, 96, &u32::MAX.to_le_bytes()),
                    "byte 96: the points should start at byte 4294967295",
                ),
                (with(&good, 100, &u32::MAX.to_le_bytes()), "byte 100: 4294967295 records"),
                (with(&good, 94, &[0xff; 2]), "byte 94: the header declares 65535 bytes"),
                (
                    with(&good, 104, &[if compressed { 0x80 + 40 } else { 40 }]),
                    "byte 104: unknown point format 40",
                ),
                (with(&good, 105, &[1, 0]), "byte 105: a point of format"),
                (with(&good, 25, &[9]), "byte 24: it is LAS 1.9"),
                (with(&good, 131, &[0; 8]), "byte 131: x has the scale 0"),
                (good[..100].to_vec(), "the file ends here, but more data is declared"),
                (good[..offset + 60].to_vec(), "truncated"),
            ] {
                let message = refusal("a.las", file);
                assert!(
                    message.contains(words),
                    "format {format}, compressed {compressed}: {message} lacks {words}"
                );
            }
            // Records after the points that claim to be endless do no harm.
            let appended = with(&good, 235, &[&(offset as u64).to_le_bytes()[..], &[9, 0, 0, 0]].concat());
            assert_eq!(cloud_of("a.las", appended).0.len(), 500);
        }
    }
    // Sizes of layers and of the table of chunks.
    let good = las(7, true, &scan);
    let offset = u32::from_le_bytes(good[96..100].try_into().unwrap()) as usize;
    let layer = with(&good, offset + 8 + 36 + 4, &u32::MAX.to_le_bytes());
    assert!(refusal("a.laz", layer).contains("a chunk of 500 points should end at byte 4294"));
    let table = u64::from_le_bytes(good[offset..offset + 8].try_into().unwrap()) as usize;
    let chunks = with(&good, table + 4, &u32::MAX.to_le_bytes());
    assert!(refusal("a.laz", chunks).contains("4294967295 chunks are declared for 500 points"));
}

// NumPy

#[test]
fn npy_types_and_orders_agree() {
    let turned: Vec<f64> = (0..3).flat_map(|k| PLACES.map(|p| p[k])).collect();
    let big: Vec<u8> = flat().iter().flat_map(|v| (*v as f32).to_be_bytes()).collect();
    let halves: Vec<u8> = flat()
        .iter()
        .flat_map(|v| {
            // All of them have few digits: sign, exponent and ten bits of fraction.
            let bits = (*v as f32).to_bits();
            let exponent = ((bits >> 23 & 0xff) as i32 - 112).max(0) as u32;
            ((bits >> 16 & 0x8000 | exponent << 10 | bits >> 13 & 0x3ff) as u16).to_le_bytes()
        })
        .collect();
    let single = flat().iter().map(|v| *v as f32).collect::<Vec<_>>();
    for file in [
        npy("'<f8'", false, "4, 3", &f64s(&flat())),
        npy("'<f4'", false, "4, 3", &f32s(&single)),
        npy("'>f4'", false, "4, 3", &big),
        npy("'<f2'", false, "4, 3", &halves),
        npy("'<f8'", true, "4, 3", &f64s(&turned)),
        npy("'<f8'", false, "2, 2, 3", &f64s(&flat())),
        npy("'<f8'", false, "1L, 4L, 3L", &f64s(&flat())),
        npy("[('x', '<f8'), ('y', '<f8'), ('z', '<f8')]", false, "4,", &f64s(&flat())),
        npy("[('xyz', '<f8', (3,))]", false, "4,", &f64s(&flat())),
    ] {
        let (points, shape) = cloud_of("a.npy", &file);
        assert_eq!(points, PLACES, "{}", String::from_utf8_lossy(&file[..80]));
        let of_two = file.windows(7).any(|w| w == b"2, 2, 3");
        assert_eq!(shape.notes.is_empty(), !of_two, "{:?}", shape.notes);
    }
    let whole: Vec<u8> = (0u8..12).collect();
    assert_eq!(cloud_of("a.npy", npy("'|u1'", false, "4, 3", &whole)).0[3], [9.0, 10.0, 11.0]);
    let whole: Vec<u8> = (0i64..12).flat_map(|v| (-v).to_be_bytes()).collect();
    assert_eq!(cloud_of("a.npy", npy("'>i8'", false, "4, 3", &whole)).0[3], [-9.0, -10.0, -11.0]);
    // Three rows of many: points in columns, and that is said.
    let rows: Vec<f64> = (0..300).map(f64::from).collect();
    let (points, shape) = cloud_of("a.npy", npy("'<f8'", false, "3, 100", &f64s(&rows)));
    assert_eq!((points.len(), points[5]), (100, [5.0, 105.0, 205.0]));
    assert!(shape.notes[0].contains("3×100: its columns"), "{:?}", shape.notes);
}

#[test]
fn npy_columns_tell_what_they_are() {
    let rows: Vec<f64> = (0..40)
        .flat_map(|i| {
            let a = f64::from(i);
            [a, 2.0 * a, 0.5, a.sin(), 0.0, a.cos(), a, 2.0 * a, 200.0, f64::from(i % 5)]
        })
        .collect();
    let shape = cloud_of("a.npy", npy("'<f8'", false, "40, 10", &f64s(&rows))).1;
    let found = shape.attributes;
    assert_eq!(found.normals.unwrap()[0], [0.0, 0.0, 1.0]);
    assert_eq!(found.colors.unwrap()[7], [7, 14, 200]);
    assert_eq!(found.labels.unwrap()[..6], [0, 1, 2, 3, 4, 0]);
    let record =
        "[('x', '<f4'), ('name', '<U2'), ('y', '<f4'), ('z', '<f4'), ('rgb', '|u1', (3,)), ('label', '<i4')]";
    let mut body = Vec::new();
    for i in 0..3u8 {
        body.extend(f32s(&[1.0 + f32::from(i)]));
        body.extend([0; 8]);
        body.extend(f32s(&[2.0, 3.0]));
        body.extend([i, 1, 0]);
        body.extend((-1 + i32::from(i)).to_le_bytes());
    }
    let (points, shape) = cloud_of("a.npy", npy(record, false, "3,", &body));
    assert_eq!(points[2], [3.0, 2.0, 3.0]);
    assert_eq!(shape.attributes.colors.unwrap()[1], [1, 1, 0]);
    assert_eq!(shape.attributes.labels, Some(vec![-1, 0, 1]));
}

#[test]
fn npz_arrays_are_told_by_name_then_by_shape() {
    let points = || npy("'<f8'", false, "4, 3", &f64s(&flat()));
    let other = || npy("'<f8'", false, "4, 3", &[0; 96]);
    let labels: Vec<u8> = [3i64, 1, 4, -1].iter().flat_map(|v| v.to_le_bytes()).collect();
    for packed in [false, true] {
        let file = npz(
            &[
                ("normals", npy("'<f4'", false, "4, 3", &f32s(&[0.0, 1.0, 0.0].repeat(4)))),
                ("names", npy("'|O'", false, "4,", b"pickled")),
                ("colors", npy("'<f4'", false, "4, 4", &f32s(&[1.0, 0.2, 0.0, 1.0].repeat(4)))),
                ("labels", npy("'<i8'", false, "4,", &labels)),
                ("points", points()),
            ],
            packed,
        );
        let (found, shape) = cloud_of("a.npz", &file);
        assert_eq!(found, PLACES);
        assert_eq!(shape.notes, ["points were read from the array “points”"]);
        assert_eq!(shape.attributes.normals, Some(vec![[0.0, 1.0, 0.0]; 4]));
        assert_eq!(shape.attributes.colors, Some(vec![[255, 51, 0]; 4]));
        assert_eq!(shape.attributes.labels, Some(vec![3, 1, 4, -1]));
    }
    // The only one that can be meant.
    let one = npz(&[("scan7", points()), ("time", npy("'<f8'", false, "4,", &[0; 32]))], false);
    assert_eq!(cloud_of("a.npz", one).0, PLACES);
    let two = npz(&[("one", points()), ("two", other())], false);
    let message = refusal("a.npz", two);
    assert!(
        message.contains("2 arrays: one (4×3 <f8), two (4×3 <f8); name one of them “points”"),
        "{message}"
    );
    // Vertices with faces are a mesh.
    let faces: Vec<u8> = [0i32, 1, 2, 1, 2, 3, 0, 1, 9].iter().flat_map(|v| v.to_le_bytes()).collect();
    let mesh = npz(
        &[("faces", npy("'<i4'", false, "3, 3", &faces)), ("vertices", points()), ("points", other())],
        true,
    );
    let shape = read_bytes(&mesh, "a.npz").unwrap();
    assert!(shape.notes.iter().any(|n| n.contains("1 face with missing vertices")), "{:?}", shape.notes);
    let ShapeGeometry::Mesh(mesh) = shape.geometry else { panic!("a cloud") };
    assert_eq!(mesh.faces, [[0, 1, 2], [1, 2, 3]]);
}

#[test]
fn npy_that_cannot_be_points_is_refused() {
    let good = npy("'<f8'", false, "4, 3", &f64s(&flat()));
    for (file, words) in [
        (npy("'|O'", false, "4, 3", b"\x80\x04\x95"), "Python objects, which are not loaded"),
        (npy("'<c16'", false, "4, 3", &[0; 192]), "“<c16”, not integers or floating-point numbers"),
        (npy("'<U5'", false, "4, 3", &[0; 240]), "not numbers"),
        (npy("'<f8'", false, "12,", &f64s(&flat())), "the array is 12 of <f8; points need one row of three"),
        (npy("'<f8'", false, "", &[0; 8]), "no dimension"),
        (npy("'<f8'", false, "4, 2", &[0; 64]), "4×2"),
        (npy("'<f8'", false, "100, 100", &[0; 80_000]), "100×100"),
        (npy("'<f8'", false, "0, 3", &[]), "0×3"),
        (npy("'<f8'", false, "1000000000000, 3", &[0; 24]), "24000000000000 bytes, but there are 24"),
        (npy("'<f8'", false, "9999999999999, 9999999999999", &[0; 24]), "more than any file can contain"),
        (npy("'<f8'", false, "-4, 3", &[0; 96]), "is not a valid dictionary"),
        (npy(&"[".repeat(5000), false, "4, 3", &[0; 96]), "is not a valid dictionary"),
        (npy("[('x', '<f8'), ('y', '<f8')]", false, "4,", &[0; 64]), "its fields are x, y"),
        (npy("[('x', '<f8', (9999999999,))]", false, "4,", &[0; 64]), "more than 4096 numbers"),
        (good[..60].to_vec(), "the file is shorter"),
        (good[..good.len() - 1].to_vec(), "96 bytes, but there are 95; the file may be truncated"),
        (b"\x93NUMPY\x02\0\xff\xff\xff\xff".to_vec(), "byte 8: the header has 4294967295 bytes"),
        (b"\x93NUMPY\x07\0\0\0".to_vec(), "version 7"),
        (b"\x93NUMPY".to_vec(), "truncated"),
    ] {
        let message = refusal("a.npy", &file);
        assert!(message.contains("a.npy") && message.contains(words), "{message} lacks {words}");
    }
    let cut = npz(&[("points", good.clone())], true);
    assert!(refusal("a.npz", &cut[..cut.len() - 30]).contains("cannot be opened"));
    let short = npz(&[("points", good[..good.len() - 8].to_vec())], true);
    assert!(refusal("a.npz", short).contains("“points”: 4×3 are declared, but there are 88 bytes"));
    let pickled = npz(&[("points", npy("'|O'", false, "4, 3", b"x"))], false);
    assert!(refusal("a.npz", pickled).contains("“points”: it contains Python objects"));
    let mut damaged = npz(&[("points", good)], false);
    let place = damaged.windows(8).position(|w| w == 7.5f64.to_le_bytes()).unwrap();
    damaged[place] ^= 1;
    assert!(refusal("a.npz", damaged).contains("cannot be decompressed"));
}

// Tables

#[test]
fn tables_name_their_columns() {
    let rows = |text: &str| cloud_of("a.csv", text).1.attributes;
    let all = rows("id,x,y,z,nx,ny,nz,r,g,b,label\n7,0,0,0,0,0,1,0.2,0.4,1,3\n8,1,1,1,0,1,0,0,0,0,-1\n");
    assert_eq!(all.normals, Some(vec![[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]));
    assert_eq!(all.colors, Some(vec![[51, 102, 255], [0, 0, 0]]));
    assert_eq!(all.labels, Some(vec![3, -1]));
    // Quotes, tabs with empty columns, units below the names, decimal commas.
    let quoted = rows("\"X\",\"Y\",\"Z\",\"Segment\"\n\"1.5\",\"2\",\"3\",\"4\"\n\"1\",\"2\",\"3\",\"5\"\n");
    assert_eq!(quoted.labels, Some(vec![4, 5]));
    let (points, shape) = cloud_of("a.txt", "name\tx\ty\tz\tclass\n\t1\t2\t3\t4\nb c\t4\t\t6\t5\n");
    assert_eq!(points[0], [1.0, 2.0, 3.0]);
    assert!(points[1][1].is_nan(), "an empty column is no number");
    assert_eq!(shape.attributes.labels, Some(vec![4, 5]));
    assert_eq!(
        cloud_of("a.csv", "x;y;z;Class\nm;m;m;-\n1,5;2;3;1\n4;5;6,5;2\n").1.attributes.labels,
        Some(vec![1, 2])
    );
    assert_eq!(cloud_of("a.csv", "1,,3,\n4,5,6,7\n1,2,3,4\n").0.len(), 3);
    // As CloudCompare writes them.
    let cc = rows(
        "//X Y Z R G B Scalar_Label\n3\n0 0 0 255 0 9 1.000000\n1 1 1 1 2 3 2.000000\n2 2 2 0 0 0 1.0\n",
    );
    assert_eq!((cc.colors.unwrap()[1], cc.labels), ([1, 2, 3], Some(vec![1, 2, 1])));
    // As surveyors, Fortran and Python write them.
    let text = "Point ID,East,North,Height\n7,1,2,3\n8,4,5,6\n";
    assert_eq!(cloud_of("a.csv", text).0, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    for text in ["1D0 2.0D+00 3\n", "[1, 2, 3]\n", "(1 2 3)\n", "1|2|3\n", "1 2 3 # a comment\n"] {
        let (points, shape) = cloud_of("a.txt", text);
        assert_eq!((points, shape.notes.len()), (vec![[1.0, 2.0, 3.0]], 0), "{text}");
    }
    let notes = cloud_of("a.csv", "u,v,w\n1,2,3\n4,5,6\n").1.notes;
    assert_eq!(notes, ["no columns are named x, y and z; the first three were used"]);
    // Words are numbered, and that is said.
    let shape = cloud_of("a.csv", "x,y,z,class\n0,0,0,wall\n1,1,1,roof\n2,2,2,wall\n").1;
    assert_eq!(shape.attributes.labels, Some(vec![0, 1, 0]));
    assert!(shape.notes[0].contains("0 “wall”, 1 “roof”"), "{:?}", shape.notes);
}

#[test]
fn tables_without_names_are_told_from_their_values() {
    let table = |row: &dyn Fn(usize) -> String| {
        let text: String = (0..60).map(|i| format!("{i} {} 0.5 {}\n", 2 * i, row(i))).collect();
        cloud_of("a.xyz", text).1.attributes
    };
    assert_eq!(table(&|i| format!("{}", i % 6)).labels.unwrap()[7], 1);
    assert_eq!(table(&|i| format!("{}", i * i % 251)), Attributes::default(), "an intensity");
    assert_eq!(table(&|i| format!("0.{i}")), Attributes::default());
    let both = table(&|i| format!("0 0.6 -0.8 {i} 20 30"));
    assert!(both.normals.is_some() && both.colors.unwrap()[9] == [9, 20, 30]);
    let both = table(&|i| format!("{i} 20 30 0 0.6 -0.8"));
    assert!(both.normals.is_some() && both.colors.is_some());
    let part = table(&|i| format!("0 0.6 -0.8 {}", 10 + i % 4));
    assert!(part.normals.is_some() && part.labels.unwrap()[5] == 11);
    let scan = table(&|i| format!("{} {i} 20 30", 4 * i));
    assert_eq!((scan.colors.unwrap()[9], scan.labels), ([9, 20, 30], None));
    // PTS: intensity before colours, whatever they are, and several scans.
    let pts = "3\n0 0 0 1 9 8 7\n1 1 1 2 9 8 7\n2 2 2 1 9 8 7\n1\n3 3 3 2 6 6 6\n";
    let (points, shape) = cloud_of("a.pts", pts);
    assert_eq!(points.len(), 4);
    assert!(shape.notes.is_empty(), "{:?}", shape.notes);
    assert_eq!(shape.attributes.colors.unwrap()[3], [6, 6, 6]);
    let shape = cloud_of("a.xyz", "0 0 0 255 0 9\n1 1 1\n").1;
    assert!(shape.notes[0].contains("1 line has fewer columns"), "{:?}", shape.notes);
}

// Meshes

#[test]
fn meshes_keep_what_their_vertices_have() {
    let attributes = |name: &str, text: &str| {
        let shape = read_bytes(text.as_bytes(), name).unwrap_or_else(|e| panic!("{e}"));
        let ShapeGeometry::Mesh(mesh) = &shape.geometry else { panic!("{name} is a cloud") };
        assert!(shape.attributes.fit(mesh.vertices.len()), "{name}");
        (mesh.vertices.clone(), shape.attributes)
    };
    // Vertices stay in the file's order, those without a face are left out.
    let obj =
        "v 9 9 9 1 1 1\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvn 0 0 1\nvn 0 0 1\nf 4//1 2//2 3//1\n";
    let (vertices, found) = attributes("a.obj", obj);
    assert_eq!(vertices[0], [0.0, 0.0, 0.0].into());
    assert_eq!(found.colors, Some(vec![[255, 0, 0], [0, 255, 0], [0, 0, 255]]));
    assert_eq!(found.normals, Some(vec![[0.0, 0.0, 1.0]; 3]));
    // A corner with another normal: none of them is that of the vertex.
    let sharp = format!("{obj}vn 1 0 0\nf 4//3 3//3 2//3\n");
    assert_eq!(attributes("a.obj", &sharp).1.normals, None);
    let off = "CNOFF\n3 1 0\n0 0 0 0 0 2 1 0 0 1\n1 0 0 0 0 2 0 1 0 1\n0 1 0 0 0 2 0 0 1 1\n3 0 1 2\n";
    let (_, found) = attributes("a.off", off);
    assert_eq!(found.normals, Some(vec![[0.0, 0.0, 2.0]; 3]));
    assert_eq!(found.colors.unwrap()[1], [0, 255, 0]);
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               property float nx\nproperty float ny\nproperty float nz\nproperty ushort red\nproperty ushort green\n\
               property ushort blue\nproperty float scalar_Label\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0 0 0 1 65535 0 257 4\n1 0 0 0 0 1 0 0 0 5\n0 1 0 0 0 1 0 0 0 4\n3 0 1 2\n";
    let (_, found) = attributes("a.ply", ply);
    assert_eq!(found.colors.unwrap()[0], [255, 0, 1]);
    assert_eq!((found.normals.is_some(), found.labels), (true, Some(vec![4, 5, 4])));
}

// Our own exports

/// What `export` writes of a run is read as the cloud that it was, with its
/// labels, in every format.
#[test]
fn our_own_exports_come_back_with_their_labels() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let superform = |arguments: &[&str]| {
        let done =
            std::process::Command::new(env!("CARGO_BIN_EXE_superform")).args(arguments).output().unwrap();
        assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    };
    // Two rods, a point that is nowhere in between.
    let rod = |i: usize, x: f64| {
        let a = i as f64 * 0.7;
        format!("{} {} {}\n", x + a.cos(), a.sin(), 0.05 * (i % 100) as f64)
    };
    let text: String = (0..600)
        .map(|i| rod(i, 0.0))
        .chain(["nan 0 0\n".to_owned()])
        .chain((0..600).map(|i| rod(i, 9.0)))
        .collect();
    std::fs::write(at("rods.xyz"), &text).unwrap();
    superform(&["run", &at("rods.xyz"), "-o", &at("run")]);
    let known = superform::io::read(&folder.path().join("run/segmented.ply")).unwrap();
    let labels = known.attributes.labels.clone().unwrap();
    assert_eq!((labels.len(), labels[600]), (1201, -1));
    assert!(labels.iter().any(|l| *l >= 0), "something was found");
    for name in ["segmented.pcd", "segmented.npz", "segmented.csv", "segmented.xyz", "segmented_2.ply"] {
        superform(&["export", &at("run"), "-o", &at(name)]);
        let bytes = std::fs::read(at(name)).unwrap();
        // By its content alone.
        let (points, shape) = cloud_of("it", bytes);
        assert_eq!(points.len(), 1201, "{name}");
        assert_eq!(shape.attributes.labels, Some(labels.clone()), "{name}");
        assert_eq!(shape.attributes.colors, known.attributes.colors, "{name}");
    }
}
