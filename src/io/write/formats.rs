//! The registry of export formats, shared by the command line and the window, as plain data.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::geometry::tessellate::Resolution;

/// Content of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The cloud with a label and a colour a point.
    Cloud,
    /// The mesh with a label a face, in parts.
    Mesh,
    /// The parameters of the primitives.
    Primitives,
    /// The primitives as bodies: surfaces, robot models.
    Scene,
}

impl Kind {
    pub const ALL: [Self; 4] = [Self::Cloud, Self::Mesh, Self::Primitives, Self::Scene];

    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Cloud => "Segmented cloud",
            Self::Mesh => "Segmented mesh",
            Self::Primitives => "Primitives as numbers",
            Self::Scene => "Primitives as meshes",
        }
    }
}

/// An option that some formats read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Choice {
    /// [`ExportOptions::binary`].
    Binary,
    /// [`ExportOptions::colors`].
    Colors,
    /// [`ExportOptions::input_attributes`].
    InputAttributes,
    /// [`ExportOptions::doubles`].
    Doubles,
    /// [`ExportOptions::split_boundaries`].
    SplitBoundaries,
    /// [`ExportOptions::resolution`].
    Resolution,
    /// [`ExportOptions::exact_shapes`].
    ExactShapes,
    /// [`ExportOptions::density`].
    Density,
    /// [`ExportOptions::scale`].
    Scale,
}

impl Choice {
    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Binary => "Binary",
            Self::Colors => "Colours",
            Self::InputAttributes => "Normals, colours and labels of the input",
            Self::Doubles => "Double precision",
            Self::SplitBoundaries => "Cut faces along boundaries",
            Self::Resolution => "Resolution",
            Self::ExactShapes => "Use exact spheres, boxes and cylinders",
            Self::Density => "Density",
            Self::Scale => "Metres per unit",
        }
    }

    /// One sentence on what it does.
    pub fn hint(self) -> &'static str {
        match self {
            Self::Binary => "Smaller and faster. Off: the file is text.",
            Self::Colors => "Colours as shown on screen, in addition to labels.",
            Self::InputAttributes => {
                "Include normals, colours and labels from the input file, if it has any."
            }
            Self::Doubles => {
                "Keep all digits. PCL and Open3D cannot read this. Off: coordinates are rounded to 7 digits."
            }
            Self::SplitBoundaries => {
                "Cut faces that belong to several parts along the boundary. Off: a face goes to the part \
                 that covers most of it."
            }
            Self::Resolution => {
                "Segments per quarter turn. Higher values give smoother surfaces and larger files."
            }
            Self::ExactShapes => {
                "Write primitives that are nearly a sphere, box or cylinder as exactly that. Simulators \
                 compute contacts faster and more smoothly than with meshes."
            }
            Self::Density => {
                "In kilograms per cubic metre; water is 1000. Mass and inertia are computed from the volume."
            }
            Self::Scale => {
                "Simulators use metres. For an input in millimetres this is 0.001, in inches 0.0254."
            }
        }
    }
}

/// How a file is written. Each format reads some of it, [`Format::choices`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExportOptions {
    /// Binary, where the format has a text form, too.
    pub binary: bool,
    /// Colours as on the screen.
    pub colors: bool,
    /// Normals, colours and labels of the input go along where it has them.
    pub input_attributes: bool,
    /// Coordinates in double precision where many readers take single only
    /// (PCD). All formats that hold doubles anyway keep them regardless.
    pub doubles: bool,
    /// Cut faces of a mesh along the boundaries of the parts.
    pub split_boundaries: bool,
    /// Pieces of a quarter turn of a primitive's surface; even.
    pub resolution: usize,
    /// Use exact spheres, boxes and cylinders in robot models, where a primitive
    /// is one within the tolerance.
    pub exact_shapes: bool,
    /// Mass per volume of a robot model, in kg per cubic metre.
    pub density: f64,
    /// Length of a unit of the input in a robot model, in metres.
    pub scale: f64,
}

impl Default for ExportOptions {
    fn default() -> Self {
        Self {
            binary: true,
            colors: true,
            input_attributes: true,
            doubles: false,
            split_boundaries: false,
            resolution: 16,
            exact_shapes: true,
            density: 1000.0,
            scale: 1.0,
        }
    }
}

impl ExportOptions {
    /// Limits of the numbers.
    pub const RESOLUTION: (usize, usize) = (2, 128);
    pub const DENSITY: (f64, f64) = (1e-9, 1e9);
    pub const SCALE: (f64, f64) = (1e-9, 1e9);

    /// Says which option is out of its limits, if one is.
    ///
    /// # Errors
    /// One sentence that names the option and its limits.
    pub fn check(&self) -> Result<(), String> {
        let (least, most) = Self::RESOLUTION;
        if !(least..=most).contains(&self.resolution) {
            return Err(format!(
                "resolution is {}, but must lie between {least} and {most}",
                self.resolution
            ));
        }
        for (name, value, (least, most)) in
            [("density", self.density, Self::DENSITY), ("scale", self.scale, Self::SCALE)]
        {
            if !(value >= least && value <= most) {
                return Err(format!("{name} is {value:?}, but must be between {least:?} and {most:?}"));
            }
        }
        Ok(())
    }

    /// The resolution of a primitive's surface.
    pub(super) fn surface(&self) -> Resolution {
        Resolution { profile: self.resolution, section: self.resolution }
    }
}

/// What a result can be written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    CloudPly,
    CloudCsv,
    CloudXyz,
    CloudPcd,
    CloudNpz,
    MeshPly,
    MeshObj,
    MeshGlb,
    MeshStl,
    PrimitivesJson,
    PrimitivesNpz,
    PrimitivesCsv,
    SurfacesGlb,
    SurfacesObj,
    SurfacesPly,
    SurfacesStl,
    Urdf,
    Mjcf,
}

/// What there is to say of a format.
struct About {
    name: &'static str,
    ending: &'static str,
    kind: Kind,
    title: &'static str,
    description: &'static str,
    choices: &'static [Choice],
}

impl Format {
    pub const ALL: [Self; 18] = [
        Self::CloudPly,
        Self::CloudCsv,
        Self::CloudXyz,
        Self::CloudPcd,
        Self::CloudNpz,
        Self::MeshPly,
        Self::MeshObj,
        Self::MeshGlb,
        Self::MeshStl,
        Self::PrimitivesJson,
        Self::PrimitivesNpz,
        Self::PrimitivesCsv,
        Self::SurfacesGlb,
        Self::SurfacesObj,
        Self::SurfacesPly,
        Self::SurfacesStl,
        Self::Urdf,
        Self::Mjcf,
    ];

    fn about(self) -> About {
        use Choice::{
            Binary, Colors, Density, Doubles, ExactShapes, InputAttributes, Resolution, Scale,
            SplitBoundaries,
        };
        let about = |name, ending, kind, title, description, choices| About {
            name,
            ending,
            kind,
            title,
            description,
            choices,
        };
        match self {
            Self::CloudPly => about(
                "cloud-ply",
                "ply",
                Kind::Cloud,
                "PLY",
                "For CloudCompare, MeshLab and Open3D; full precision",
                &[Binary, Colors, InputAttributes],
            ),
            Self::CloudCsv => about(
                "cloud-csv",
                "csv",
                Kind::Cloud,
                "CSV",
                "For spreadsheets, pandas and R: one line per point, with a header",
                &[Colors, InputAttributes],
            ),
            Self::CloudXyz => about(
                "cloud-xyz",
                "xyz",
                Kind::Cloud,
                "XYZ text",
                "For programs that read columns of numbers; the label is the last column",
                &[Colors, InputAttributes],
            ),
            Self::CloudPcd => about(
                "cloud-pcd",
                "pcd",
                Kind::Cloud,
                "PCD",
                "For PCL, ROS and Open3D; single-precision coordinates by default",
                &[Binary, Colors, InputAttributes, Doubles],
            ),
            Self::CloudNpz => about(
                "cloud-npz",
                "npz",
                Kind::Cloud,
                "NPZ",
                "For NumPy and PyTorch: arrays points, labels, colors; full precision",
                &[Colors, InputAttributes],
            ),
            Self::MeshPly => about(
                "mesh-ply",
                "ply",
                Kind::Mesh,
                "PLY",
                "For MeshLab and trimesh: one mesh, one label and one colour per face",
                &[Binary, Colors, SplitBoundaries],
            ),
            Self::MeshObj => about(
                "mesh-obj",
                "obj",
                Kind::Mesh,
                "OBJ",
                "For Blender and most other programs: one object per part, colours in a separate .mtl file",
                &[Colors, SplitBoundaries],
            ),
            Self::MeshGlb => about(
                "mesh-glb",
                "glb",
                Kind::Mesh,
                "GLB",
                "For Blender, the web and game engines: one node, mesh and material per part",
                &[Colors, SplitBoundaries],
            ),
            Self::MeshStl => about(
                "mesh-stl",
                "stl",
                Kind::Mesh,
                "STL",
                "For 3D printing and CAD: as text one solid per part, as binary one solid with one colour \
                 per face",
                &[Binary, Colors, SplitBoundaries],
            ),
            Self::PrimitivesJson => about(
                "json",
                "json",
                Kind::Primitives,
                "JSON",
                "Superform's own format, complete and with a schema; can be opened again",
                &[],
            ),
            Self::PrimitivesNpz => about(
                "npz",
                "npz",
                Kind::Primitives,
                "NPZ",
                "For superquadric tools in Python (scale, rotation, translation, exponents, exist, …); can be opened again",
                &[],
            ),
            Self::PrimitivesCsv => about(
                "csv",
                "csv",
                Kind::Primitives,
                "CSV",
                "13 numbers per line, in the order used by the paper's authors (MATLAB); can be opened again",
                &[],
            ),
            Self::SurfacesGlb => about(
                "surfaces-glb",
                "glb",
                Kind::Scene,
                "GLB",
                "For Blender, the web and game engines: one node per primitive, with its pose",
                &[Colors, Resolution],
            ),
            Self::SurfacesObj => about(
                "surfaces-obj",
                "obj",
                Kind::Scene,
                "OBJ",
                "For Blender and most other programs: one object per primitive; full precision",
                &[Colors, Resolution],
            ),
            Self::SurfacesPly => about(
                "surfaces-ply",
                "ply",
                Kind::Scene,
                "PLY",
                "For MeshLab and trimesh: one mesh, one label and one colour per face",
                &[Binary, Colors, Resolution],
            ),
            Self::SurfacesStl => about(
                "surfaces-stl",
                "stl",
                Kind::Scene,
                "STL",
                "For 3D printing and CAD: as text one solid per primitive, as binary one solid with one \
                 colour per face",
                &[Binary, Colors, Resolution],
            ),
            Self::Urdf => about(
                "urdf",
                "urdf",
                Kind::Scene,
                "URDF",
                "For ROS, PyBullet, Drake and Isaac: one link per primitive with visual, convex collision, \
                 mass and inertia",
                &[Colors, Resolution, ExactShapes, Density, Scale],
            ),
            Self::Mjcf => about(
                "mjcf",
                "xml",
                Kind::Scene,
                "MJCF",
                "For MuJoCo: one free body with a child body per primitive, with convex geoms, mass and \
                 inertia",
                &[Colors, Resolution, ExactShapes, Density, Scale],
            ),
        }
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        self.about().name
    }

    /// The format of that name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// Ending of the names of its files, without the dot.
    pub fn ending(self) -> &'static str {
        self.about().ending
    }

    pub fn kind(self) -> Kind {
        self.about().kind
    }

    /// For people, within its kind.
    pub fn title(self) -> &'static str {
        self.about().title
    }

    /// One line on what it is for.
    pub fn description(self) -> &'static str {
        self.about().description
    }

    /// The options that it reads.
    pub fn choices(self) -> &'static [Choice] {
        self.about().choices
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

    #[test]
    fn options_out_of_their_limits_are_named() {
        assert_eq!(ExportOptions::default().check(), Ok(()));
        let with = |change: fn(&mut ExportOptions)| {
            let mut options = ExportOptions::default();
            change(&mut options);
            options.check().unwrap_err()
        };
        assert!(with(|o| o.resolution = 0).contains("resolution is 0"));
        assert!(with(|o| o.density = f64::NAN).contains("density is NaN"));
        assert!(with(|o| o.density = -1.0).contains("between"));
        assert!(with(|o| o.scale = 0.0).contains("scale is 0.0"));
    }
}
