//! Arrays of several shapes, degrees, and colours on any scale: read for what they
//! are, or said.

use crate::formats::{cloud_of, f32s, f64s, las, npy, npz, pcd};

/// Points of a shape without order, each of another place for each seed.
fn scattered(count: usize, seed: usize) -> Vec<f64> {
    let turn = |i: usize, step: f64| ((i + 1000 * seed) as f64 * step).fract();
    (0..count).flat_map(|i| [turn(i, 0.618_034), turn(i, 0.754_877), turn(i, 0.569_840)]).collect()
}

#[test]
fn of_several_shapes_in_an_array_the_first_is_taken() {
    const N: usize = 500;
    let shapes: Vec<f64> = [scattered(N, 1), scattered(N, 2)].concat();
    let first: Vec<[f64; 3]> = shapes[..3 * N].chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
    // Point by point, coordinate by coordinate; in C's order and in Fortran's.
    let turned: Vec<f64> = shapes
        .chunks(3 * N)
        .flat_map(|s| (0..3).flat_map(|k| s.iter().skip(k).step_by(3)))
        .copied()
        .collect();
    let fortran: Vec<f64> = (0..3)
        .flat_map(|k| (0..N).flat_map(move |i| [3 * i + k, 3 * (N + i) + k]))
        .map(|i| shapes[i])
        .collect();
    for (file, shown) in [
        (npy("'<f8'", false, "2, 500, 3", &f64s(&shapes)), "2×500×3"),
        (npy("'<f8'", false, "2, 3, 500", &f64s(&turned)), "2×3×500"),
        (npy("'<f8'", true, "2, 500, 3", &f64s(&fortran)), "2×500×3"),
        (npy("'<f8'", false, "1, 2, 500, 3", &f64s(&shapes)), "1×2×500×3"),
        (npz(&[("points", npy("'<f8'", false, "2, 500, 3", &f64s(&shapes)))], true), "2×500×3"),
    ] {
        let (points, shape) = cloud_of("a.npy", file);
        assert_eq!(points, first, "{shown}");
        let note = shape.notes.iter().find(|note| note.contains("2 shapes of 500 points")).unwrap();
        assert!(note.contains(shown) && note.contains("np.save(\"shape1.npy\", array[1])"), "{note}");
    }
    // Their attributes go with them.
    let labels: Vec<u8> = (0..7).cycle().take(2 * N).collect();
    let colors = f32s(&[1.0, 0.0, 0.0].repeat(2 * N));
    let file = npz(
        &[
            ("pc", npy("'<f8'", false, "2, 500, 3", &f64s(&shapes))),
            ("labels", npy("'|u1'", false, "2, 500", &labels)),
            ("colors", npy("'<f4'", false, "2, 500, 3", &colors)),
        ],
        false,
    );
    let found = cloud_of("a.npz", file).1.attributes;
    assert_eq!(found.labels.unwrap(), labels[..N].iter().map(|l| i64::from(*l)).collect::<Vec<_>>());
    assert_eq!(found.colors, Some(vec![[255, 0, 0]; N]));
}

#[test]
fn a_scan_in_rows_and_columns_is_one_cloud() {
    const SIDES: (usize, usize) = (30, 40);
    let scan: Vec<f64> = (0..SIDES.0 * SIDES.1)
        .flat_map(|i| {
            let (v, u) = ((i / SIDES.1) as f64, (i % SIDES.1) as f64);
            let depth = 2.0 + (0.2 * u).sin() + 0.03 * v;
            // Here and there nothing was hit.
            if i % 11 == 0 { [f64::NAN; 3] } else { [0.02 * u * depth, 0.02 * v * depth, depth] }
        })
        .collect();
    let (points, shape) = cloud_of("a.npy", npy("'<f8'", false, "30, 40, 3", &f64s(&scan)));
    assert_eq!(points.len(), 1200);
    assert_eq!(shape.notes[0], "the array is 30×40×3: read as one cloud of 1200 points");
    // Entries that are no shapes: corners of triangles, say.
    let (points, shape) = cloud_of("a.npy", npy("'<f8'", false, "400, 3, 3", &f64s(&scattered(1200, 1))));
    assert_eq!((points.len(), shape.notes.len()), (1200, 1));
    // What has one entry has no others.
    for sides in ["1, 1200, 3", "1200, 1, 3"] {
        let (points, shape) = cloud_of("a.npy", npy("'<f8'", false, sides, &f64s(&scattered(1200, 1))));
        assert_eq!((points.len(), shape.notes.len()), (1200, 0), "{sides}");
    }
}

#[test]
fn degrees_are_said_to_be_no_lengths() {
    let row = "48.1,11.5,520\n48.2,11.6,530\n";
    for (names, first) in [
        ("lat,lon,alt", [11.5, 48.1, 520.0]),
        ("Latitude,Longitude,Elevation", [11.5, 48.1, 520.0]),
        ("lng,lat,height", [48.1, 11.5, 520.0]),
        ("\"lat (deg)\",\"lon (deg)\",\"h\"", [11.5, 48.1, 520.0]),
        ("gps_lat,gps_long,gps_alt", [11.5, 48.1, 520.0]),
        // Without a height.
        ("lat,lon,speed", [48.1, 11.5, 520.0]),
    ] {
        let (points, shape) = cloud_of("a.csv", format!("{names}\n{row}"));
        assert_eq!(points[0], first, "{names}");
        let note = shape.notes.first().cloned().unwrap_or_default();
        assert!(note.contains("degrees, not lengths") && note.contains("metres"), "{names}: {note}");
    }
    for names in ["x,y,z,lat,lon", "easting,northing,elevation,lat,lon", "x,y,z,along,flat"] {
        let notes = cloud_of("a.csv", format!("{names}\n1,2,3,4,5\n6,7,8,9,10\n")).1.notes;
        assert!(!notes.iter().any(|note| note.contains("degrees")), "{names}: {notes:?}");
    }
    let fields = pcd("lat lon alt", "4 4 4", "F F F", 2, "ascii");
    let notes = cloud_of("a.pcd", [fields, row.replace(',', " ").into_bytes()].concat()).1.notes;
    assert!(notes[0].contains("degrees, not lengths"), "{notes:?}");
    let fields = "[('lon', '<f8'), ('lat', '<f8'), ('alt', '<f8')]";
    let notes = cloud_of("a.npy", npy(fields, false, "2,", &f64s(&scattered(2, 1)))).1.notes;
    assert!(notes[0].contains("degrees, not lengths"), "{notes:?}");
    // A scan whose system of coordinates says so.
    let mut scan = las(
        2,
        false,
        &[([500_000.0, 5_400_000.0, 1.0], 1, [0; 3]), ([500_001.0, 5_400_001.0, 2.0], 1, [0; 3])],
    );
    assert!(cloud_of("a.las", &scan).1.notes.is_empty());
    geographic(&mut scan);
    let notes = cloud_of("a.las", &scan).1.notes;
    assert!(notes[0].contains("degrees, not lengths"), "{notes:?}");
}

/// Puts a record of GeoTIFF's keys into a scan: the model is geographic.
fn geographic(scan: &mut Vec<u8>) {
    let keys: Vec<u8> = [1u16, 1, 0, 1, 1024, 0, 1, 2].iter().flat_map(|v| v.to_le_bytes()).collect();
    let mut record = vec![0; 54];
    record[2..17].copy_from_slice(b"LASF_Projection");
    record[18..20].copy_from_slice(&34735u16.to_le_bytes());
    record[20..22].copy_from_slice(&(keys.len() as u16).to_le_bytes());
    record.extend(keys);
    let header = usize::from(u16::from_le_bytes([scan[94], scan[95]]));
    let points = u32::from_le_bytes([scan[96], scan[97], scan[98], scan[99]]) + record.len() as u32;
    scan[96..100].copy_from_slice(&points.to_le_bytes());
    let records = u32::from_le_bytes([scan[100], scan[101], scan[102], scan[103]]) + 1;
    scan[100..104].copy_from_slice(&records.to_le_bytes());
    scan.splice(header..header, record);
}

#[test]
fn colors_on_any_scale_are_read_or_said() {
    let places = scattered(50, 1);
    let table = |head: &str, color: &dyn Fn(usize) -> [f64; 3]| {
        let rows = places.chunks(3).enumerate().map(|(i, p)| {
            let [r, g, b] = color(i);
            format!("{} {} {} {r} {g} {b}\n", p[0], p[1], p[2])
        });
        cloud_of("a.xyz", format!("{head}{}", rows.collect::<String>())).1
    };
    let array = |color: &dyn Fn(usize) -> [f64; 3]| {
        let rows: Vec<f64> =
            places.chunks(3).enumerate().flat_map(|(i, p)| [p, &color(i)].concat()).collect();
        cloud_of("a.npy", npy("'<f8'", false, "50, 6", &f64s(&rows))).1
    };
    let apart = |color: &dyn Fn(usize) -> [f64; 3]| {
        let colors: Vec<f64> = (0..50).flat_map(color).collect();
        let file = [
            ("points", npy("'<f8'", false, "50, 3", &f64s(&places))),
            ("colors", npy("'<f8'", false, "50, 3", &f64s(&colors))),
        ];
        cloud_of("a.npz", npz(&file, false)).1
    };
    let fraction = |i: usize| [i as f64 / 49.0, 0.5, 0.0];
    let wide = |i: usize| fraction(i).map(|v| (v * 65535.0).round());
    let signed = |i: usize| fraction(i).map(|v| 2.0 * v - 1.0);
    let expected: Vec<[u8; 3]> = (0..50).map(|i| fraction(i).map(|v| (v * 255.0).round() as u8)).collect();
    let wide_first = |i: usize| {
        let [r, g, _] = wide(i);
        [r, g, 40_000.0]
    };
    for (shape, what) in [
        (table("x y z r g b\n", &fraction), "named fractions"),
        (table("x y z r g b\n", &wide), "named, 16 bits"),
        (table("x y z r g b\n", &signed), "named, from −1"),
        (table("", &fraction), "fractions"),
        (array(&fraction), "fractions in an array"),
        (apart(&wide), "an array of 16 bits"),
        (apart(&signed), "an array from −1"),
    ] {
        let colors = shape.attributes.colors.unwrap_or_else(|| panic!("{what}: none"));
        let near = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1);
        assert!(colors.iter().zip(&expected).all(near), "{what}: {colors:?}");
        let is_said = shape.notes.iter().any(|note| note.contains("−1 (black)"));
        assert_eq!(is_said, what.contains("−1"), "{what}: {:?}", shape.notes);
    }
    for shape in [table("", &wide_first), array(&wide_first)] {
        assert_eq!(shape.attributes.colors.unwrap()[49], [255, 128, 156]);
    }
    // Without a name, numbers around 0 may be anything.
    for shape in [table("", &signed), array(&signed)] {
        assert_eq!(shape.attributes.colors, None);
        assert!(shape.notes[0].contains("columns 4 to 6 are between −1 and 1"), "{:?}", shape.notes);
    }
    // Packed, as whole numbers of either sign, and as floats of the same bits.
    for packed in ["8405024", "-8372192", "1.177794722381323e-38"] {
        let shape = cloud_of("a.csv", format!("x,y,z,rgb\n0,0,0,{packed}\n1,1,1,0\n")).1;
        assert_eq!(shape.attributes.colors, Some(vec![[0x80, 0x40, 0x20], [0; 3]]), "{packed}");
    }
}
