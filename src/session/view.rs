//! How the shape is shown.

use serde::{Deserialize, Serialize};

/// What can be shown or hidden as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layer {
    Input,
    Points,
    Primitives,
    Grid,
}

impl Layer {
    pub const ALL: [Self; 4] = [Self::Input, Self::Points, Self::Primitives, Self::Grid];

    pub fn text(self) -> &'static str {
        match self {
            Self::Input => "Input mesh",
            Self::Points => "Points",
            Self::Primitives => "Primitives",
            Self::Grid => "Ground grid",
        }
    }
}

/// How primitives are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SurfaceStyle {
    Solid,
    #[default]
    Translucent,
    Wire,
}

impl SurfaceStyle {
    pub const ALL: [Self; 3] = [Self::Solid, Self::Translucent, Self::Wire];

    pub fn text(self) -> &'static str {
        match self {
            Self::Solid => "Solid",
            Self::Translucent => "Translucent",
            Self::Wire => "Wire",
        }
    }
}

/// What a drag with the left button does in the viewport.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tool {
    /// Orbits; a click selects.
    #[default]
    Click,
    /// Draws a box and selects what is in it.
    Box,
    /// Draws a line around what is to be selected.
    Lasso,
}

impl Tool {
    pub const ALL: [Self; 3] = [Self::Click, Self::Box, Self::Lasso];
}

/// What clicks, boxes and lassos select.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Picks {
    #[default]
    Primitives,
    Points,
}

/// What the colour of a point tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColorBy {
    /// The primitive that the point belongs to.
    #[default]
    Cluster,
    /// The colour in the file.
    Input,
    /// Nothing.
    Plain,
    /// The distance to the surface of the point's own primitive.
    OwnDistance,
    /// The distance to the nearest primitive's surface.
    NearestDistance,
}

impl ColorBy {
    pub const ALL: [Self; 5] =
        [Self::Cluster, Self::Input, Self::Plain, Self::OwnDistance, Self::NearestDistance];

    pub fn text(self) -> &'static str {
        match self {
            Self::Cluster => "Cluster",
            Self::Input => "Input colour",
            Self::Plain => "Plain",
            Self::OwnDistance => "Error",
            Self::NearestDistance => "Nearest surface",
        }
    }

    pub fn tooltip(self) -> &'static str {
        match self {
            Self::Cluster => "Each point in the colour of its primitive, its label z",
            Self::Input => "Each point in the colour that the file gives it",
            Self::Plain => "All points in one colour",
            Self::OwnDistance => {
                "The distance d from each point to the surface of its own primitive, to first order, in \
                 the file's units"
            }
            Self::NearestDistance => {
                "The distance from each point to the nearest surface of any primitive, to first order, in \
                 the file's units"
            }
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ThemeChoice {
    #[default]
    System,
    Light,
    Dark,
}

impl ThemeChoice {
    pub const ALL: [Self; 3] = [Self::System, Self::Light, Self::Dark];
}

/// Settings of the viewport and the window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct View {
    #[serde(with = "by_name")]
    layers: [bool; Layer::ALL.len()],
    pub surface_style: SurfaceStyle,
    /// Diameter of a point in logical pixels.
    pub point_size: f32,
    pub color_by: ColorBy,
    pub tool: Tool,
    pub picks: Picks,
    /// Boxes and lassos leave out what is hidden behind something else.
    pub visible_only: bool,
    pub up: super::scene::UpAxis,
    pub theme: ThemeChoice,
    pub shows_log: bool,
    pub shows_shortcuts: bool,
    pub shows_about: bool,
}

impl View {
    /// Limits of `point_size`.
    pub const POINT_SIZE: (f32, f32) = (1.0, 12.0);

    /// Whether all numbers are within their limits.
    pub fn is_sound(&self) -> bool {
        (Self::POINT_SIZE.0..=Self::POINT_SIZE.1).contains(&self.point_size)
    }

    /// How the shape is shown as here, the window itself as in `other`.
    pub(super) fn in_window_of(self, other: &Self) -> Self {
        let Self { theme, shows_log, shows_shortcuts, shows_about, .. } = *other;
        Self { theme, shows_log, shows_shortcuts, shows_about, ..self }
    }

    pub fn shows(&self, layer: Layer) -> bool {
        self.layers[layer as usize]
    }

    pub fn set_layer(&mut self, layer: Layer, shown: bool) {
        self.layers[layer as usize] = shown;
    }
}

impl Default for View {
    fn default() -> Self {
        Self {
            layers: [true; Layer::ALL.len()],
            surface_style: SurfaceStyle::default(),
            point_size: 3.5,
            color_by: ColorBy::default(),
            tool: Tool::default(),
            picks: Picks::default(),
            visible_only: false,
            up: super::scene::UpAxis::default(),
            theme: ThemeChoice::default(),
            shows_log: false,
            shows_shortcuts: false,
            shows_about: false,
        }
    }
}

/// Layers in files: whoever adds one can still read what was written before.
mod by_name {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{Layer, View};

    type Layers = [bool; Layer::ALL.len()];

    pub(super) fn serialize<S: Serializer>(layers: &Layers, serializer: S) -> Result<S::Ok, S::Error> {
        Layer::ALL.map(|layer| (layer, layers[layer as usize])).as_slice().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Layers, D::Error> {
        let mut layers = View::default().layers;
        for (layer, shown) in Vec::<(Layer, bool)>::deserialize(deserializer)? {
            layers[layer as usize] = shown;
        }
        Ok(layers)
    }
}
