//! View settings.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::scalar::Top;

/// Layers that can be shown or hidden.
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

/// Action of a left-button drag in the viewport.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tool {
    /// Orbits; a click selects.
    #[default]
    Click,
    /// Draws a box and selects what is in it.
    Box,
    /// Draws a line around what to select.
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

/// What point colours show.
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
    /// On the primitives' surfaces: the distance to the input.
    SurfaceDistance,
    /// The entropy of the point's labels over the last states.
    Uncertainty,
    /// The entropy of the point's labels over runs with several seeds.
    SeedUncertainty,
}

impl ColorBy {
    pub const ALL: [Self; 8] = [
        Self::Cluster,
        Self::OwnDistance,
        Self::NearestDistance,
        Self::SurfaceDistance,
        Self::Uncertainty,
        Self::SeedUncertainty,
        Self::Input,
        Self::Plain,
    ];

    pub fn text(self) -> &'static str {
        match self {
            Self::Cluster => "Cluster",
            Self::Input => "Input colour",
            Self::Plain => "Plain",
            Self::OwnDistance => "Error",
            Self::NearestDistance => "To primitives",
            Self::SurfaceDistance => "To input",
            Self::Uncertainty => "Uncertainty",
            Self::SeedUncertainty => "Seed disagreement",
        }
    }

    pub fn tooltip(self) -> &'static str {
        match self {
            Self::Cluster => "Each point in the colour of its primitive (label z)",
            Self::Input => "Each point in its colour from the input file",
            Self::Plain => "All points in one colour",
            Self::OwnDistance => {
                "First-order distance d from each point to the surface of its own primitive, in the file's \
                 units"
            }
            Self::NearestDistance => {
                "First-order distance from each point to the nearest primitive's surface, in the file's units"
            }
            Self::SurfaceDistance => {
                "Shown on the primitives: distance from each surface point to the input mesh (exact) or to \
                 the nearest point of the input cloud, in the file's units. Points are hidden in this mode"
            }
            Self::Uncertainty => {
                "How often the label z of each point changed over the last states, as the entropy of its \
                 labels: 0 if always the same, 1 if never the same twice"
            }
            Self::SeedUncertainty => {
                "Where runs with different seeds disagree: entropy of each point's labels over the seeds, \
                 after matching primitives that represent the same part"
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

/// Which layers are shown. In files by name, so that whoever adds one can still read what was
/// written before.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Layers([bool; Layer::ALL.len()]);

impl Serialize for Layers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Layer::ALL.map(|layer| (layer, self.0[layer as usize])).as_slice().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Layers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut layers = View::default().layers;
        for (layer, shown) in Vec::<(Layer, bool)>::deserialize(deserializer)? {
            layers.0[layer as usize] = shown;
        }
        Ok(layers)
    }
}

/// Settings of the viewport and the window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct View {
    layers: Layers,
    pub surface_style: SurfaceStyle,
    /// Diameter of a point in logical pixels.
    pub point_size: f32,
    pub color_by: ColorBy,
    /// End of a colour bar.
    pub legend_top: Top,
    /// Number of states W over which the uncertainty of labels is computed.
    pub uncertainty_window: u32,
    pub tool: Tool,
    pub picks: Picks,
    /// Boxes and lassos ignore what is hidden behind something else.
    pub visible_only: bool,
    pub up: super::scene::UpAxis,
    pub theme: ThemeChoice,
    /// The odds of a point, once one is chosen.
    pub shows_odds: bool,
    /// Runs with other seeds.
    pub shows_seeds: bool,
    pub shows_log: bool,
    pub shows_shortcuts: bool,
    pub shows_about: bool,
}

impl View {
    /// Limits of `point_size`.
    pub const POINT_SIZE: (f32, f32) = (1.0, 12.0);
    /// Limits of `uncertainty_window`.
    pub const UNCERTAINTY_WINDOW: (u32, u32) = (2, 200);

    /// Whether all numbers are within their limits.
    pub fn is_sound(&self) -> bool {
        let (least, most) = Self::UNCERTAINTY_WINDOW;
        (Self::POINT_SIZE.0..=Self::POINT_SIZE.1).contains(&self.point_size)
            && (least..=most).contains(&self.uncertainty_window)
            && !matches!(self.legend_top, Top::At(top) if !top.is_finite())
    }

    /// These view settings with the window settings of `other`.
    pub(super) fn in_window_of(self, other: &Self) -> Self {
        let Self { theme, shows_odds, shows_seeds, shows_log, shows_shortcuts, shows_about, .. } = *other;
        Self { theme, shows_odds, shows_seeds, shows_log, shows_shortcuts, shows_about, ..self }
    }

    pub fn shows(&self, layer: Layer) -> bool {
        self.layers.0[layer as usize]
    }

    pub fn set_layer(&mut self, layer: Layer, shown: bool) {
        self.layers.0[layer as usize] = shown;
    }
}

impl Default for View {
    fn default() -> Self {
        Self {
            layers: Layers([true; Layer::ALL.len()]),
            surface_style: SurfaceStyle::default(),
            point_size: 3.5,
            color_by: ColorBy::default(),
            legend_top: Top::default(),
            uncertainty_window: 10,
            tool: Tool::default(),
            picks: Picks::default(),
            visible_only: false,
            up: super::scene::UpAxis::default(),
            theme: ThemeChoice::default(),
            shows_odds: true,
            shows_seeds: false,
            shows_log: false,
            shows_shortcuts: false,
            shows_about: false,
        }
    }
}
