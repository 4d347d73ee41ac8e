//! Every export, read with libraries that are not ours: `tests/python/read_back.py`.
//!
//! Needs a Python (`SUPERFORM_PYTHON`, or `python3`) with the packages of
//! `tests/python/requirements.txt`. Where they are missing it says so and is
//! skipped, or fails if SUPERFORM_REQUIRE_PYTHON=1.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use crate::needs::lacking;
use nalgebra::{Point3, Rotation3, Vector3};
use serde_json::{Value, json};
use superform::geometry::palette::{Colors, UNASSIGNED_COLOR};
use superform::geometry::segmentation::face_labels;
use superform::geometry::{SampleCloud, SamplingOptions, Superquadric};
use superform::inference::{Abstraction, Figures, Params, Phase, Primitive, Sighting, UNASSIGNED};
use superform::io::{self, Attributes, ExportOptions, Format, Outcome, PointCloud, Shape, ShapeGeometry};

const PACKAGES: &str =
    "import jsonschema, lxml, mujoco, networkx, numpy, plyfile, pypcd4, scipy, trimesh, yourdfpy";
const DENSITY: f64 = 700.0;
/// Of a robot model whose input is in inches.
const SCALE: f64 = 0.0254;

/// A primitive, and what simulators should take it for: in URDF, in MJCF.
type Entry = (Superquadric, &'static str, &'static str);

fn shape(eps: [f64; 2], axes: [f64; 3], taper: [f64; 2]) -> Superquadric {
    Superquadric {
        exponents: eps,
        semi_axes: Vector3::from(axes),
        rotation: Rotation3::identity(),
        translation: Vector3::zeros(),
        taper,
    }
}

fn placed(shape: Superquadric, angles: [f64; 3], to: [f64; 3]) -> Superquadric {
    let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
    Superquadric { rotation, translation: Vector3::from(to), ..shape }
}

/// Points dealt to primitives in turn, ids with gaps, some points to none.
struct Case {
    shape: Shape,
    cloud: SampleCloud,
    abstraction: Abstraction,
    entries: Vec<Entry>,
}

impl Case {
    fn new(shape: Shape, points: usize, entries: Vec<Entry>, label: impl Fn(&Point3<f64>) -> usize) -> Self {
        let cloud = io::sample(&shape, &SamplingOptions { points, ..SamplingOptions::default() }).unwrap();
        let id = |place: usize| 3 * place as u32 + 2;
        let of = |p| entries.get(label(p)).map_or(UNASSIGNED, |_| id(label(p)));
        let labels: Arc<[u32]> = cloud.points.iter().map(of).collect();
        let primitive = |(place, (shape, ..)): (usize, &Entry)| Primitive {
            id: id(place),
            shape: *shape,
            sigma: 0.01 * place as f64,
            points: labels.iter().filter(|&&l| l == id(place)).count(),
            mean_distance: 0.002,
            locked: false,
        };
        let abstraction = Abstraction {
            phase: Phase::Finished,
            iteration: 1,
            primitives: entries.iter().enumerate().map(primitive).collect(),
            figures: Figures {
                clusters: entries.len(),
                unassigned: 0,
                mean_distance: 0.002,
                log_joint: None,
            },
            pinned: [].into(),
            sighting: Sighting::default(),
            labels,
        };
        Self { shape, cloud, abstraction, entries }
    }

    fn reference(&self, colors: &Colors) -> Value {
        let attributes = &self.shape.attributes;
        let points = match &self.shape.geometry {
            ShapeGeometry::Cloud(input) => &input.points,
            ShapeGeometry::Mesh(_) => &self.cloud.points,
        };
        let signed = |&label: &u32| if label == UNASSIGNED { -1 } else { i64::from(label) };
        let labels = self.cloud.labels_of_input(&self.abstraction.labels, UNASSIGNED);
        let color = |&label: &u32| if label == UNASSIGNED { UNASSIGNED_COLOR } else { colors.of(label) };
        let mesh = match &self.shape.geometry {
            ShapeGeometry::Cloud(_) => Value::Null,
            ShapeGeometry::Mesh(mesh) => {
                let found = face_labels(mesh, &self.cloud, &self.abstraction.labels);
                json!({
                    "vertices": mesh.vertices.iter().map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>(),
                    "faces": mesh.faces,
                    "labels": found.iter().map(signed).collect::<Vec<_>>(),
                })
            }
        };
        let primitives = self.abstraction.primitives.iter().zip(&self.entries).map(|(p, (_, urdf, mjcf))| {
            let r = p.shape.rotation.matrix();
            let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[(i, j)]));
            json!({
                "id": p.id, "eps": p.shape.exponents, "scale": p.shape.semi_axes.as_slice(),
                "rotation": rows,
                "translation": p.shape.translation.as_slice(), "taper": p.shape.taper,
                "sigma": p.sigma, "points": p.points, "mean_distance": p.mean_distance,
                "volume": p.shape.volume(), "color": colors.of(p.id), "urdf": urdf, "mjcf": mjcf,
            })
        });
        json!({
            "points": points.iter().map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>(),
            "labels": labels.iter().map(signed).collect::<Vec<_>>(),
            "colors": labels.iter().map(color).collect::<Vec<_>>(),
            "normals": attributes.normals, "input_labels": attributes.labels,
            "input_colors": attributes.colors.as_ref().filter(|_| mesh.is_null()),
            "mesh": mesh, "density": DENSITY, "model_scale": SCALE, "primitives": primitives.collect::<Vec<_>>(),
        })
    }

    fn write(&self, folder: &Path) {
        let (colors, params) = (Colors::default(), Params::default());
        let outcome = Outcome {
            colors: &colors,
            shape: &self.shape,
            cloud: &self.cloud,
            sampling: SamplingOptions::default(),
            params: &params,
            abstraction: &self.abstraction,
        };
        let is_mesh = matches!(self.shape.geometry, ShapeGeometry::Mesh(_));
        let options = ExportOptions { density: DENSITY, resolution: 24, ..ExportOptions::default() };
        for (inner, options) in [
            ("", options),
            ("text", ExportOptions { binary: false, ..options }),
            ("split", ExportOptions { split_boundaries: true, ..options }),
        ] {
            let names = Format::ALL.into_iter().filter(|f| is_mesh || !f.needs_mesh()).map(|format| {
                let stem = match format.name().split_once('-') {
                    Some(("cloud", _)) => "segmented",
                    Some(("mesh", _)) => "mesh",
                    None if matches!(format, Format::Urdf | Format::Mjcf) => "robot",
                    _ => "primitives",
                };
                format!("{stem}.{}", format.ending())
            });
            let names: Vec<String> = names.collect();
            let written = write_all(&folder.join(inner), &names, &options, &outcome);
            assert!(written >= names.len());
        }
        let doubles = ExportOptions { doubles: true, ..options };
        io::export(&folder.join("doubles.pcd"), Format::CloudPcd, &doubles, &outcome).unwrap();
        let scaled = ExportOptions { scale: SCALE, ..options };
        let robots = ["robot.urdf", "robot.xml"].map(str::to_owned);
        write_all(&folder.join("scaled"), &robots, &scaled, &outcome);
        fs::write(folder.join("reference.json"), self.reference(&colors).to_string()).unwrap();
    }
}

/// Writes files in the formats that their names tell; how many files that are.
fn write_all(folder: &Path, names: &[String], options: &ExportOptions, outcome: &Outcome<'_>) -> usize {
    fs::create_dir_all(folder).unwrap();
    let write = |name: &String| {
        let format = Format::from_path(Path::new(name), None).unwrap();
        io::export(&folder.join(name), format, options, outcome).unwrap().files.len()
    };
    names.iter().map(write).sum()
}

/// A cloud with everything that a file may say of its points, one of them
/// without a place.
fn cloud_case() -> Case {
    let mut points = Vec::new();
    for i in 0..900 {
        let (u, v) = (f64::from(i % 30) / 29.0, f64::from(i / 30) / 29.0);
        points.push(Point3::new(u + 1e-7 / 3.0, v, 0.1 * (7.0 * u).sin()));
    }
    points[17] = Point3::new(f64::NAN, 0.5, 1.0);
    let attributes = Attributes {
        colors: Some((0..900u32).map(|i| [(i % 256) as u8, (i / 4 % 256) as u8, 3]).collect()),
        normals: Some((0..900u16).map(|i| [0.1, f32::from(i) / 900.0, -0.7]).collect()),
        labels: Some((0..900).map(|i| i % 5 - 1).collect()),
    };
    let shape_of = Shape {
        name: "café.ply".to_owned(),
        path: None,
        content: None,
        geometry: ShapeGeometry::Cloud(PointCloud { points }),
        attributes,
        viewpoints: Vec::new(),
        notes: Vec::new(),
    };
    let entries = vec![
        (placed(shape([1.0, 1.0], [0.3; 3], [0.0; 2]), [0.1, 0.2, 0.3], [0.2, 0.2, 0.0]), "sphere", "sphere"),
        (
            placed(shape([0.5, 0.7], [0.3, 0.2, 0.1], [0.3, -0.2]), [1.0, -2.0, 0.4], [0.8, 0.5, 0.0]),
            "mesh",
            "mesh",
        ),
    ];
    Case::new(shape_of, 400, entries, |p| {
        if p.x < 0.4 {
            0
        } else if p.x < 0.9 {
            1
        } else {
            9
        }
    })
}

/// The chair, its samples dealt by height and side; boxes that can fall.
fn chair_case() -> Case {
    let chair = io::built_in().unwrap();
    let ShapeGeometry::Mesh(mesh) = &chair.geometry else { panic!("the chair is a mesh") };
    let (lo, hi) = mesh.bounds().unwrap();
    let (middle, size) = (nalgebra::center(&lo, &hi), hi - lo);
    let at = |x: f64, y: f64, z: f64| {
        [middle.x + 0.5 * x * size.x, middle.y + 0.5 * y * size.y, middle.z + 0.5 * z * size.z]
    };
    let s = size.min();
    let entries = vec![
        (
            placed(shape([0.08, 0.1], [0.4 * s, 0.4 * s, 0.05 * s], [0.0; 2]), [0.0; 3], at(0.0, 0.0, 0.0)),
            "box",
            "box",
        ),
        (
            placed(shape([0.1, 1.0], [0.1 * s, 0.1 * s, 0.3 * s], [0.0; 2]), [0.0; 3], at(0.0, 0.0, 0.5)),
            "cylinder",
            "cylinder",
        ),
        (
            placed(
                shape([0.3, 0.3], [0.2 * s, 0.3 * s, 0.1 * s], [0.2, 0.1]),
                [0.0, 0.0, 0.4],
                at(0.0, 0.0, -0.3),
            ),
            "mesh",
            "mesh",
        ),
    ];
    let thirds = move |p: &Point3<f64>| {
        if p.x > middle.x + 0.35 * size.x { 9 } else { (2.999 * (p.y - lo.y) / size.y) as usize }
    };
    Case::new(chair, 3000, entries, thirds)
}

/// Primitives at the ends of their range.
fn extreme_case() -> Case {
    let text: String = (0..60).map(|i| format!("{} {} {}\n", i % 5, i / 5 % 4, i / 20)).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.xyz");
    fs::write(&path, text).unwrap();
    let turned = [2.0, -1.3, 0.7];
    let entries = vec![
        (placed(shape([0.02, 0.02], [1.0, 0.5, 2.0], [-1.0, -1.0]), turned, [5.0, 0.0, 0.0]), "mesh", "mesh"),
        (placed(shape([2.0, 2.0], [1.0, 1.0, 1.0], [0.0; 2]), turned, [-300.0, 4.0, 9.0]), "mesh", "mesh"),
        (
            placed(
                shape([1.0, 1.0], [0.5, 1.0, 2.0], [0.0; 2]),
                [0.0, std::f64::consts::FRAC_PI_2, 0.3],
                [0.0; 3],
            ),
            "mesh",
            "ellipsoid",
        ),
        (placed(shape([1.0, 1.0], [1.0, 1.0, 1.5], [1.0, 1.0]), turned, [0.0, 8.0, 0.0]), "mesh", "mesh"),
        (placed(shape([0.1, 0.1], [1.0, 0.6, 0.004], [0.0; 2]), turned, [0.0, -8.0, 0.0]), "box", "box"),
        (placed(shape([1.9, 0.05], [0.2, 3.0, 1.0], [-0.8, 0.9]), turned, [0.0, 0.0, 12.0]), "mesh", "mesh"),
        (placed(shape([0.03, 1.0], [1.0, 0.4, 1.0], [1.0, 0.0]), turned, [7.0, 7.0, 7.0]), "mesh", "mesh"),
    ];
    Case::new(io::read(&path).unwrap(), 60, entries, |p| (p.x + 2.0 * p.y) as usize)
}

#[test]
fn others_read_what_we_write() {
    let python = std::env::var("SUPERFORM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let found = Command::new(&python).args(["-c", PACKAGES]).output();
    if !found.as_ref().is_ok_and(|output| output.status.success()) {
        let why = found.map_or_else(|e| e.to_string(), |o| String::from_utf8_lossy(&o.stderr).into_owned());
        let why = why.trim().lines().last().unwrap_or_default();
        let why = format!("{python} lacks packages of tests/python/requirements.txt: {why}");
        return lacking("SUPERFORM_REQUIRE_PYTHON", why);
    }
    let folder = tempfile::tempdir().unwrap();
    let root = std::env::var("SUPERFORM_KEEP_EXPORTS").map_or(folder.path().to_owned(), Into::into);
    for (name, case) in [("cloud", cloud_case()), ("chair", chair_case()), ("extreme", extreme_case())] {
        case.write(&root.join(name));
    }
    let source = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(&python)
        .arg(source.join("tests/python/read_back.py"))
        .args([&root, &source.join("docs")])
        .output()
        .unwrap();
    let [said, errors] = [output.stdout, output.stderr].map(|t| String::from_utf8_lossy(&t).into_owned());
    assert!(output.status.success(), "{said}\n{errors}");
}
