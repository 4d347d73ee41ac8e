//! Small files of every format with bytes changed, cut out, doubled and mixed:
//! a shape or an error, never a panic, and in little time.

use std::time::{Duration, Instant};

use crate::formats::{f32s, las, npy, npz, pcd, pcd_packed};
use rand::{RngExt, SeedableRng, rngs::SmallRng, seq::IndexedRandom};
use superform::geometry::SamplingOptions;
use superform::io::{self, Shape, read_bytes, read_bytes_as};

/// Good files by their endings.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let values: Vec<f32> = (0..60).map(|i| (i * i % 17) as f32).collect();
    let body = f32s(&values);
    let scan: Vec<_> = (0..40)
        .map(|i| ([500_000.0 + f64::from(i), 5_400_000.5, 2.0], (i % 4) as u8, [i as u16, 7, 9]))
        .collect();
    let header = |data: &str| pcd("x y z", "4 4 4", "F F F", 20, data);
    let ply = |form: &str| {
        format!(
            "ply\nformat {form} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int label\n\
             element face 2\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let mut binary_ply = ply("binary_little_endian").into_bytes();
    for i in 0..4i32 {
        binary_ply.extend(f32s(&[i as f32, (i * i) as f32, 1.0]));
        binary_ply.extend([1, 2, 3]);
        binary_ply.extend(i.to_le_bytes());
    }
    for face in [[0i32, 1, 2], [1, 2, 3]] {
        binary_ply.push(3);
        face.iter().for_each(|i| binary_ply.extend(i.to_le_bytes()));
    }
    let mut stl = vec![b' '; 80];
    stl.extend(2u32.to_le_bytes());
    stl.extend([&body[..48], &[0; 2], &body[60..108], &[0; 2]].concat());
    let text = |t: &str| t.as_bytes().to_vec();
    vec![
        (
            "obj",
            text(
                "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\nvn 0 0 1\nf 1//1 2//1 3//1\nf -1 1 \\\n 2\n",
            ),
        ),
        (
            "ply",
            text(&format!(
                "{}0 0 0 1 2 3 4\n1 0 0 1 2 3 5\n0 1 0 1 2 3 6\n0 0 1 1 2 3 7\n3 0 1 2\n3 1 2 3\n",
                ply("ascii")
            )),
        ),
        ("ply", binary_ply),
        ("stl", stl),
        (
            "stl",
            text(
                "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
            ),
        ),
        (
            "off",
            text(
                "CNOFF\n3 1 0\n0 0 0 0 0 1 255 0 0 255\n1 0 0 0 0 1 0 255 0 255\n0 1 0 0 0 1 0 0 255 255\n3 0 1 2\n",
            ),
        ),
        (
            "gltf",
            text(
                r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"mesh":0,"scale":[1,2,3]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#,
            ),
        ),
        ("xyz", text("3\n0 0 0 12 255 0 0\n1 1 1 13 0 255 0\n2 2 2 14 0 0 255\n")),
        ("csv", text("x;y;z;label\n\"1,5\";2;3;4\n7;8,25;9;5\n;1;2;5\n")),
        ("pcd", [header("ascii"), text(&"1 2 3\n4 nan 6\n".repeat(10))].concat()),
        ("pcd", [header("binary"), body.clone()].concat()),
        ("pcd", pcd_packed(header("binary_compressed"), &body)),
        ("las", las(3, false, &scan)),
        ("laz", las(3, true, &scan)),
        ("laz", las(7, true, &scan)),
        ("npy", npy("'<f4'", false, "20, 3", &body)),
        ("npy", npy("[('x', '<f4'), ('y', '<f4'), ('z', '<f4')]", false, "20,", &body)),
        (
            "npz",
            npz(
                &[
                    ("points", npy("'<f4'", true, "20, 3", &body)),
                    ("labels", npy("'|u1'", false, "20,", &body[..20])),
                ],
                true,
            ),
        ),
    ]
}

/// Changes a file in one of many ways.
fn mutated(bytes: &mut Vec<u8>, other: &[u8], rng: &mut SmallRng) {
    const PIECES: [&[u8]; 14] = [
        b"\n",
        b"\r",
        b" ",
        b"-",
        b"0",
        b"9999999999999",
        b"nan",
        b"1e999",
        b"\0",
        b"\xff\xff\xff\xff",
        b",",
        b"\"",
        b"[",
        b"#",
    ];
    if bytes.is_empty() {
        return;
    }
    let at = rng.random_range(0..bytes.len());
    let end = (at + rng.random_range(1..24)).min(bytes.len());
    match rng.random_range(0..8) {
        0 => bytes[at] ^= 1 << rng.random_range(0..8),
        1 => bytes[at] = rng.random(),
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..end)),
        4 => {
            let piece = bytes[at..end].to_vec();
            bytes.splice(at..at, piece);
        }
        5 | 6 => {
            let piece = PIECES.choose(rng).unwrap();
            let over = if rng.random() { at..at } else { at..(at + piece.len()).min(bytes.len()) };
            bytes.splice(over, piece.iter().copied());
        }
        _ => {
            let from = rng.random_range(0..other.len());
            bytes.splice(at..end, other[from..(from + 24).min(other.len())].iter().copied());
        }
    }
}

fn check(shape: &Shape) {
    let points = match &shape.geometry {
        io::ShapeGeometry::Mesh(mesh) => mesh.vertices.len(),
        io::ShapeGeometry::Cloud(cloud) => cloud.points.len(),
    };
    assert!(shape.attributes.fit(points));
    let options = SamplingOptions { points: 20, ..SamplingOptions::default() };
    io::sample(shape, &options).unwrap();
}

#[test]
fn good_files_are_read() {
    for (ending, bytes) in seeds() {
        let shape = read_bytes(&bytes, "it").unwrap_or_else(|e| panic!("{ending}: {e}"));
        check(&shape);
        check(&read_bytes_as(&bytes, ending).unwrap().unwrap());
    }
}

#[test]
fn mutated_files_never_panic() {
    // A message for each panic of the LAZ decoder, which is caught, would drown
    // what matters.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !info.location().is_some_and(|l| l.file().contains("/laz-")) {
            hook(info);
        }
    }));
    let seeds = seeds();
    let mut rng = SmallRng::seed_from_u64(7);
    let (mut read, mut refused) = (0, 0);
    for round in 0..150 {
        for (i, (ending, good)) in seeds.iter().enumerate() {
            let mut bytes = good.clone();
            let other = &seeds.choose(&mut rng).unwrap().1;
            for _ in 0..rng.random_range(1..5) {
                mutated(&mut bytes, other, &mut rng);
            }
            let start = Instant::now();
            for found in [
                Some(read_bytes(&bytes, "it.xyz")).filter(|_| !bytes.is_empty()),
                read_bytes_as(&bytes, ending),
            ] {
                match found {
                    Some(Ok(shape)) => {
                        check(&shape);
                        read += 1;
                    }
                    Some(Err(e)) => {
                        assert!(e.to_string().len() > 10);
                        refused += 1;
                    }
                    None => {}
                }
            }
            assert!(start.elapsed() < Duration::from_secs(30), "round {round} of seed {i}, {ending}");
        }
    }
    // Both happen often, or the changes are of no use.
    assert!(read > 500 && refused > 500, "{read} read, {refused} refused");
}
