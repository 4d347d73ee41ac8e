//! How results can be written, as plain data for the command line and the window.

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

/// How a file is written. Each format reads some of it, [`super::formats::Format::choices`].
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
    /// Spheres, boxes and cylinders as such in robot models, where a primitive
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
            return Err(format!("resolution is {}, but must be between {least} and {most}", self.resolution));
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

#[cfg(test)]
mod tests {
    use super::*;

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
