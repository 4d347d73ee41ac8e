//! How the shape is shown.

/// What can be shown or hidden as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    layers: [bool; Layer::ALL.len()],
    pub surface_style: SurfaceStyle,
    /// Diameter of a point in logical pixels.
    pub point_size: f32,
    pub up: super::scene::UpAxis,
    pub theme: ThemeChoice,
    pub shows_log: bool,
    pub shows_shortcuts: bool,
    pub shows_about: bool,
}

impl View {
    /// Limits of `point_size`.
    pub const POINT_SIZE: (f32, f32) = (1.0, 12.0);

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
            up: super::scene::UpAxis::default(),
            theme: ThemeChoice::default(),
            shows_log: false,
            shows_shortcuts: false,
            shows_about: false,
        }
    }
}
