//! What results can be written as: one table for the command line and the window.

use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use self::PrimitivesFormat::{Archive, Text};
use self::Writer::{Cloud, Mesh, Numbers, Surfaces};
use super::atomic::Sink;
use super::cloud::{self, CloudFormat};
use super::glb;
use super::meshes;
use super::options::Choice::{
    self, Binary, Colors, Density, Doubles, ExactShapes, InputAttributes, Resolution, Scale, SplitBoundaries,
};
use super::options::Kind;
use super::parts::PartsFormat;
use super::robot::Robot;
use crate::io::primitives::{PrimitiveSet, csv, json, npz};

/// What a format is made of, and what writes it.
#[derive(Clone, Copy)]
pub(super) enum Writer {
    /// The cloud with its labels.
    Cloud(CloudFormat),
    /// The input's mesh in parts.
    Mesh(PartsFormat),
    /// The parameters of the primitives.
    Numbers(PrimitivesFormat),
    /// The surfaces of the primitives.
    Surfaces(PartsFormat),
    /// The text of a robot model, which has its meshes beside it.
    Robot(fn(&Robot) -> String),
}

/// How the parameters of primitives are written.
#[derive(Clone, Copy)]
pub(super) enum PrimitivesFormat {
    Text(fn(&mut dyn Write, &PrimitiveSet<'_>) -> io::Result<()>),
    Archive(fn(&mut Sink<'_>, &PrimitiveSet<'_>) -> io::Result<()>),
}

/// What there is to say of a format.
struct Row {
    name: &'static str,
    ending: &'static str,
    title: &'static str,
    writer: Writer,
    choices: &'static [Choice],
    description: &'static str,
}

const fn row(
    name: &'static str,
    ending: &'static str,
    title: &'static str,
    writer: Writer,
    choices: &'static [Choice],
    description: &'static str,
) -> Row {
    Row { name, ending, title, writer, choices, description }
}

/// Options of robot models.
const ROBOT: &[Choice] = &[Colors, Resolution, ExactShapes, Density, Scale];

/// Makes [`Format`] of its table.
macro_rules! formats {
    ($($format:ident => $row:expr,)*) => {
        /// What a result can be written as.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Format {
            $($format,)*
        }

        impl Format {
            pub const ALL: [Self; [$(stringify!($format)),*].len()] = [$(Self::$format),*];

            fn row(self) -> Row {
                match self {
                    $(Self::$format => $row,)*
                }
            }
        }
    };
}

// Name on the command line, ending, title within its kind, writer, the options that it reads, and
// what it is for. The first of a kind with an ending is the one that the ending stands for.
formats! {
    CloudPly => row("cloud-ply", "ply", "PLY", Cloud(cloud::PLY), &[Binary, Colors, InputAttributes],
        "For CloudCompare, MeshLab and Open3D; full precision"),
    CloudCsv => row("cloud-csv", "csv", "CSV", Cloud(cloud::CSV), &[Colors, InputAttributes],
        "For spreadsheets, pandas and R: one line per point, with a header"),
    CloudXyz => row("cloud-xyz", "xyz", "XYZ text", Cloud(cloud::XYZ), &[Colors, InputAttributes],
        "For programs that read columns of numbers; the label is the last column"),
    CloudPcd => row("cloud-pcd", "pcd", "PCD", Cloud(cloud::PCD), &[Binary, Colors, InputAttributes, Doubles],
        "For PCL, ROS and Open3D; single-precision coordinates by default"),
    CloudNpz => row("cloud-npz", "npz", "NPZ", Cloud(cloud::NPZ), &[Colors, InputAttributes],
        "For NumPy and PyTorch: arrays points, labels, colors; full precision"),
    MeshPly => row("mesh-ply", "ply", "PLY", Mesh(meshes::PLY), &[Binary, Colors, SplitBoundaries],
        "For MeshLab and trimesh: one mesh, one label and one colour per face"),
    MeshObj => row("mesh-obj", "obj", "OBJ", Mesh(meshes::OBJ), &[Colors, SplitBoundaries],
        "For Blender and most other programs: one object per part, colours in a separate .mtl file"),
    MeshGlb => row("mesh-glb", "glb", "GLB", Mesh(glb::GLB), &[Colors, SplitBoundaries],
        "For Blender, the web and game engines: one node, mesh and material per part"),
    MeshStl => row("mesh-stl", "stl", "STL", Mesh(meshes::STL), &[Binary, Colors, SplitBoundaries],
        "For 3D printing and CAD: as text one solid per part, as binary one solid with one colour \
                 per face"),
    PrimitivesJson => row("json", "json", "JSON", Numbers(Text(|w, set| json::write(w, set))), &[],
        "Superform's own format, complete and with a schema; can be opened again"),
    PrimitivesNpz => row("npz", "npz", "NPZ", Numbers(Archive(|w, set| npz::write(w, set))), &[],
        "For superquadric tools in Python (scale, rotation, translation, exponents, exist, …); can be opened again"),
    PrimitivesCsv => row("csv", "csv", "CSV", Numbers(Text(|w, set| csv::write(w, set))), &[],
        "13 numbers per line, in the order used by the paper's authors (MATLAB); can be opened again"),
    SurfacesGlb => row("surfaces-glb", "glb", "GLB", Surfaces(glb::GLB), &[Colors, Resolution],
        "For Blender, the web and game engines: one node per primitive, with its pose"),
    SurfacesObj => row("surfaces-obj", "obj", "OBJ", Surfaces(meshes::OBJ), &[Colors, Resolution],
        "For Blender and most other programs: one object per primitive; full precision"),
    SurfacesPly => row("surfaces-ply", "ply", "PLY", Surfaces(meshes::PLY), &[Binary, Colors, Resolution],
        "For MeshLab and trimesh: one mesh, one label and one colour per face"),
    SurfacesStl => row("surfaces-stl", "stl", "STL", Surfaces(meshes::STL), &[Binary, Colors, Resolution],
        "For 3D printing and CAD: as text one solid per primitive, as binary one solid with one \
                 colour per face"),
    Urdf => row("urdf", "urdf", "URDF", Writer::Robot(Robot::urdf), ROBOT,
        "For ROS, PyBullet, Drake and Isaac: one link per primitive with visual, convex collision, \
                 mass and inertia"),
    Mjcf => row("mjcf", "xml", "MJCF", Writer::Robot(Robot::mjcf), ROBOT,
        "For MuJoCo: one free body with a child body per primitive, with convex geoms, mass and \
                 inertia"),
}

impl Format {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The format of that name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// Ending of the names of its files, without the dot.
    pub fn ending(self) -> &'static str {
        self.row().ending
    }

    pub fn kind(self) -> Kind {
        match self.writer() {
            Writer::Cloud(_) => Kind::Cloud,
            Writer::Mesh(_) => Kind::Mesh,
            Writer::Numbers(_) => Kind::Primitives,
            Writer::Surfaces(_) | Writer::Robot(_) => Kind::Scene,
        }
    }

    /// What writes it.
    pub(super) fn writer(self) -> Writer {
        self.row().writer
    }

    /// For people, within its kind.
    pub fn title(self) -> &'static str {
        self.row().title
    }

    /// One line on what it is for.
    pub fn description(self) -> &'static str {
        self.row().description
    }

    /// The options that it reads.
    pub fn choices(self) -> &'static [Choice] {
        self.row().choices
    }

    /// Whether the input must be a mesh.
    pub fn needs_mesh(self) -> bool {
        self.kind() == Kind::Mesh
    }

    /// Those of a kind.
    pub fn of_kind(kind: Kind) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |format| format.kind() == kind)
    }

    /// The format of a file by its ending, among those of a kind. Without a
    /// kind by the name, too: where a word of it is `segmented` or `cloud` it is
    /// a cloud, where one is `mesh` or `parts` a segmented mesh; all others are
    /// primitives, as numbers before bodies.
    pub fn from_path(path: &Path, kind: Option<Kind>) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_ascii_lowercase();
        let of = |kind: Kind| Self::of_kind(kind).find(|format| format.ending() == ending);
        if let Some(kind) = kind {
            return of(kind);
        }
        let stem = path.file_stem()?.to_string_lossy().to_ascii_lowercase();
        let mut words = stem.split(|c: char| !c.is_alphanumeric());
        let named = words.find_map(|word| match word {
            "segmented" | "cloud" => Some(Kind::Cloud),
            "mesh" | "parts" => Some(Kind::Mesh),
            "primitives" => Some(Kind::Primitives),
            _ => None,
        });
        if let Some(kind @ (Kind::Cloud | Kind::Mesh)) = named {
            return of(kind);
        }
        // What no primitives are written as can only be a cloud: .xyz, .pcd.
        of(Kind::Primitives).or_else(|| of(Kind::Scene)).or_else(|| of(Kind::Cloud))
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn names_tell_formats_apart_and_so_do_endings_within_a_kind() {
        let names: HashSet<_> = Format::ALL.iter().map(|f| f.name()).collect();
        let endings: HashSet<_> = Format::ALL.iter().map(|f| (f.kind(), f.ending())).collect();
        assert_eq!((names.len(), endings.len()), (Format::ALL.len(), Format::ALL.len()));
        for format in Format::ALL {
            assert_eq!(Format::by_name(format.name()), Some(format));
            let path = format!("x.{}", format.ending().to_uppercase());
            assert_eq!(Format::from_path(Path::new(&path), Some(format.kind())), Some(format));
        }
    }

    #[test]
    fn a_name_alone_tells_the_format() {
        for (name, format) in [
            ("segmented.ply", Format::CloudPly),
            ("cloud.NPZ", Format::CloudNpz),
            ("mesh.glb", Format::MeshGlb),
            ("chair-parts.stl", Format::MeshStl),
            ("chair-segmented.npz", Format::CloudNpz),
            ("primitives.npz", Format::PrimitivesNpz),
            ("out/chair.csv", Format::PrimitivesCsv),
            ("chair.glb", Format::SurfacesGlb),
            ("robot.urdf", Format::Urdf),
            ("robot.xml", Format::Mjcf),
            ("chair.pcd", Format::CloudPcd),
        ] {
            assert_eq!(Format::from_path(Path::new(name), None), Some(format), "{name}");
        }
        for name in ["chair", "chair.docx", "mesh.csv", "segmented.urdf"] {
            assert_eq!(Format::from_path(Path::new(name), None), None, "{name}");
        }
    }
}
