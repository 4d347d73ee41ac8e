//! Memory on reading: what a file claims costs nothing, what it holds a small
//! multiple of its size. Alone in its process, whose peak is measured.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)] // What can't be had in a helper fails the test, too.

#[path = "common/formats.rs"]
mod formats;

use formats::{las, npy, npz, pcd, pcd_packed};
use superform::io::read_bytes;

/// The most memory that the process has had since the last call, in bytes,
/// beyond what it has had at the end of that.
struct Peak(usize);

impl Peak {
    fn field(name: &str) -> usize {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find(|l| l.starts_with(name)).unwrap();
        line.split_whitespace().nth(1).unwrap().parse::<usize>().unwrap() << 10
    }

    fn new() -> Self {
        // Lowers the peak to what there is; where that isn't allowed, a peak
        // of before may hide a smaller one, but none appears that is not.
        let _ = std::fs::write("/proc/self/clear_refs", "5");
        Self(Self::field("VmHWM"))
    }

    fn grown(&self) -> usize {
        Self::field("VmHWM").saturating_sub(self.0)
    }
}

const CLAIMED: u64 = 1_000_000_000_000;

fn liars() -> Vec<(&'static str, Vec<u8>)> {
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let ply = |form: &str, faces: u64| {
        let text = format!(
            "ply\nformat {form} 1.0\nelement vertex {}\n{xyz}element face {faces}\n\
             property list uchar int vertex_indices\nend_header\n",
            if faces > 0 { 1 } else { CLAIMED }
        );
        [text.into_bytes(), b"0 0 0 \n0 0 0".to_vec()].concat()
    };
    let scan: Vec<_> =
        (0..50).map(|i| ([500_000.0 + f64::from(i), 5_400_000.0, 0.0], 2, [1, 2, 3])).collect();
    let with = |mut file: Vec<u8>, at: usize, bytes: &[u8]| {
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let scans = |format, packed| {
        let file = with(las(format, packed, &scan), 107, &[0; 4]);
        with(file, 247, &CLAIMED.to_le_bytes())
    };
    // Just below what is refused at once, so that the decoder has to find out.
    let patient = with(las(3, true, &scan), 107, &[0; 4]);
    let patient = with(patient, 247, &500_000u64.to_le_bytes());
    let gltf = format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"componentType":5126,"count":{CLAIMED},"type":"VEC3"}}]}}"#
    );
    let array = format!("{CLAIMED}, 3");
    let packed = pcd("x y z", "4 4 4", "F F F", 300_000_000, "binary_compressed");
    let lying =
        [packed, 100u32.to_le_bytes().to_vec(), 3_600_000_000u32.to_le_bytes().to_vec(), vec![0; 100]]
            .concat();
    vec![
        ("ascii vertices", ply("ascii", 0)),
        ("binary vertices", ply("binary_little_endian", 0)),
        ("ascii faces", ply("ascii", CLAIMED)),
        ("binary faces", ply("binary_big_endian", CLAIMED)),
        ("off", format!("OFF\n{CLAIMED} 1 0\n0 0 0\n").into_bytes()),
        ("stl", [vec![b' '; 80], u32::MAX.to_le_bytes().to_vec(), vec![1; 50]].concat()),
        ("gltf", gltf.into_bytes()),
        (
            "ascii pcd",
            [pcd("x y z", "4 4 4", "F F F", CLAIMED as usize, "ascii"), b"1 2 3\n".to_vec()].concat(),
        ),
        ("binary pcd", [pcd("x y z", "4 4 4", "F F F", CLAIMED as usize, "binary"), vec![0; 24]].concat()),
        ("packed pcd", lying),
        ("las", scans(3, false)),
        ("laz", scans(3, true)),
        ("layered laz", scans(7, true)),
        ("patient laz", patient),
        ("npy", npy("'<f8'", false, &array, &[0; 24])),
        ("npz", npz(&[("points", npy("'<f8'", false, &array, &[0; 24]))], true)),
        ("packed npz", npz(&[("points", npy("'<f8'", false, "1000000, 3", &vec![0; 24_000_000]))], true)),
    ]
}

#[test]
fn claims_cost_nothing_and_content_a_small_multiple() {
    const SLACK: usize = 48 << 20;
    for (name, bytes) in liars() {
        let peak = Peak::new();
        let message = read_bytes(&bytes, name).expect_err(name).to_string();
        assert!(peak.grown() < SLACK, "{name}: {} MiB for {message}", peak.grown() >> 20);
    }
    let lines = 600_000;
    let points = |line: &str| line.repeat(lines).into_bytes();
    let mesh = [points("v 1 2 3\n"), points("f 1 2 3\n")].concat();
    let body: Vec<u8> = (0..3 * lines).flat_map(|i| (i as f32).to_le_bytes()).collect();
    let header = |data: &str| pcd("x y z", "4 4 4", "F F F", lines, data);
    for (name, bytes, most) in [
        ("a.xyz", points("1 2 3\n"), 16),
        ("a.csv", points("1,2,3,4,5,6,7,8\n"), 16),
        ("a.obj", mesh, 24),
        ("a.pcd", [header("ascii"), points("1 2 3\n")].concat(), 16),
        ("a.pcd", [header("binary"), body.clone()].concat(), 8),
        ("a.pcd", pcd_packed(header("binary_compressed"), &body), 16),
        ("a.npy", npy("'<f4'", false, &format!("{lines}, 3"), &body), 8),
    ] {
        let peak = Peak::new();
        let shape = read_bytes(&bytes, name).unwrap_or_else(|e| panic!("{e}"));
        let grown = peak.grown();
        drop(shape);
        assert!(
            grown < SLACK + most * bytes.len(),
            "{name}: {} MiB for {} MiB",
            grown >> 20,
            bytes.len() >> 20
        );
    }
}
